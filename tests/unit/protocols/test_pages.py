"""The pages in docs/protocols: their links lead somewhere, and their example is what the codec says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from turtlewire.protocols.message import Decoded
from turtlewire.protocols.walter.codec import CommandDecoder, ReplyDecoder
from turtlewire.protocols.walter.messages import ATTENTION, EMERGENCY_STOP

FOLDER = Path(__file__).parents[3] / "docs" / "protocols"
PAGES = sorted(FOLDER.glob("*.md"))
each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)


def anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.*)$", page.read_text("utf-8"), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@each_page
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)]+)\)", page.read_text("utf-8")):
        name, _, anchor = target.partition("#")
        to = FOLDER / name if name else page
        assert to.is_file(), target
        assert not anchor or anchor in anchors(to), target


def test_every_decision_is_there() -> None:
    text = (FOLDER / "decisions.md").read_text("utf-8")
    sections = re.split(r"^### ", text, flags=re.MULTILINE)[1:]
    numbers = [int(section[1:].split(".")[0]) for section in sections if re.match(r"W\d+\. ", section)]
    assert sorted(numbers) == list(range(1, 17))
    for section in sections:
        title = section.splitlines()[0]
        for part in ("- **The source", "- **What we do:**", "- **Why:**", "- **To change it:**"):
            assert part in section, title


def test_the_worked_example_is_understood_by_both_ends() -> None:
    text = (FOLDER / "walter.md").read_text("utf-8")
    rows = re.findall(r"^\| `([0-9A-F ]+)` \| (to|from) robot \| (.*) \|$", text, flags=re.MULTILINE)
    assert len(rows) == 12
    robot, host = CommandDecoder(), ReplyDecoder()
    said = []
    for wire, direction, _ in rows:
        data = bytes.fromhex(wire)
        items = (robot if direction == "to" else host).receive_data(data)
        if data in (ATTENTION, EMERGENCY_STOP):
            continue
        (item,) = items
        assert isinstance(item, Decoded)
        said.append(str(item.message))
    assert said == [
        "set_speed speed=100",
        "pen_down",
        "forward distance_half_mm=200",
        "right angle_deg=90",
        "query_heading",
        "heading_reply heading_deg=90",
        "query_location",
        "location_reply x_half_mm=0 y_half_mm=200",
        "go_to x_half_mm=300 y_half_mm=-200",
        "limit_front",
    ]
