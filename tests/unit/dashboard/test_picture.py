"""The picture of the dashboard in the documentation shows it as it is."""

from __future__ import annotations

import html
import re
from pathlib import Path

from tools.dashboard_picture import picture

ROOT = Path(__file__).parents[3]


def said(svg: str) -> str:
    """What stands in a picture. How it is drawn is another's business, and changes with their versions."""
    pieces = re.findall(r"<text[^>]*>([^<]*)</text>", svg)
    return re.sub(r"\s+", " ", html.unescape(" ".join(pieces)).replace("\u00a0", " "))


def test_it_is_current_and_needs_nothing_from_elsewhere() -> None:
    svg = (ROOT / "docs/pictures/drive.svg").read_text("utf-8")
    assert said(svg) == said(picture()), "run `make pictures`"
    for piece in ("simulated WALTER", "▲ ahead", "start_forward", "Hold a key to drive"):
        assert piece in said(svg)
    assert "url(" not in re.sub(r"url\(#[^)]*\)", "", svg)
    assert "http" not in re.sub(r"http://www.w3.org/\S*|<!--.*?-->", "", svg)
