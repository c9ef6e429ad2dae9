"""Python source: what the generators of all protocols share."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent.parent
RANGES = {"u8": (0, 255), "u16": (0, 65535), "i16": (-32768, 32767), "bit": (0, 1)}


def field_source(field: dict[str, Any]) -> str:
    low, high = RANGES[field["kind"]]
    high = field.get("max", high)
    return f"Field({field['name']!r}, {field['kind']!r}, {low}, {high}, {field['unit']!r})"


def formatted(source: str) -> str:
    command = [sys.executable, "-m", "ruff", "format", "-", "--stdin-filename", "messages.py"]
    return subprocess.run(command, input=source, capture_output=True, text=True, check=True, cwd=ROOT).stdout
