r"""What a terminal sends that tells of keys: repetitions and releases, where it knows the kitty keyboard protocol.

A key is ``CSI code ; modifiers : event ; text u``, with event 1 pressed (or left out), 2 repeated, 3 released; keys
that have always sent something else send that, as ``CSI 1 ; modifiers : event A``. ``CSI ? flags u`` answers the
question which parts of the protocol are on. https://sw.kovidgoyal.net/kitty/keyboard-protocol/

Whoever takes the rest of what a terminal sends gets presses without their event, and nothing of the others.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterator

# Switches on that events are told, beside whatever else is on; the question; the flag that says that they are told.
TELL_EVENTS = "\x1b[=2;2u"
ASK = "\x1b[?u"
EVENTS_FLAG = 2
ESCAPE = "\x1b"
_KEY = re.compile(
    r"\x1b\[(?P<code>\d*)(?P<others>[\d:]*)(?:;(?P<modifiers>\d*)(?::(?P<event>\d))?)?"
    r"(?P<text>;[\d:]*)?(?P<end>[u~ABCDEFHPQRS])"
)
_ANSWER = re.compile(r"\x1b\[\?(?P<flags>\d+)u")
# What may be the beginning of one of these.
_BEGINNING = re.compile(r"\x1b(?:\[(?:\?\d*|[\d:;]*))?\Z")
# What a terminal sends after an escape, as a part of something longer; whatever else follows is another key.
_AFTER_ESCAPE = "[OP]_^X\\"
_ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}
_NAMES = {" ": "space", "\x1b": "escape"}
_LARGEST_CODE = 0x10FFFF


class Text(NamedTuple):
    """What is no business of ours."""

    text: str


class Escape(NamedTuple):
    """The Escape key: what it sends is the beginning of much else, but this is not."""


class Repeated(NamedTuple):
    """A key that is held repeats."""

    key: str


class Released(NamedTuple):
    """A key was released."""

    key: str


class Answered(NamedTuple):
    """The terminal has answered the question; whether it tells of events."""

    tells_events: bool


Item = Text | Escape | Repeated | Released | Answered


class Keyboard:
    """Reads what a terminal sends, in any pieces."""

    def __init__(self) -> None:
        self._kept = ""

    def feed(self, text: str) -> list[Item]:
        """Take a piece; what it completes. What may be the beginning of something is kept."""
        return list(self._items(self._kept + text))

    def flush(self) -> list[Item]:
        """Nothing has come for a while: what was kept began nothing."""
        kept, self._kept = self._kept, ""
        if kept == ESCAPE:
            return [Escape()]
        return [Text(kept)] if kept else []

    def _items(self, text: str) -> Iterator[Item]:
        beginning = _BEGINNING.search(text)
        end = beginning.start() if beginning else len(text)
        text, self._kept = text[:end], text[end:]
        plain, at = "", 0
        while at < len(text):
            item, at = self._item(text, at)
            if isinstance(item, Text):
                plain += item.text
                continue
            if plain:
                yield Text(plain)
                plain = ""
            yield item
        if plain:
            yield Text(plain)

    @staticmethod
    def _item(text: str, at: int) -> tuple[Item, int]:
        """What stands here, and where it ends."""
        if text[at] != ESCAPE:
            return Text(text[at]), at + 1
        found = _KEY.match(text, at) or _ANSWER.match(text, at)
        if found is not None:
            return _item(found), found.end()
        after = text[at + 1 : at + 2] or ESCAPE  # which is kept
        return (Text(ESCAPE) if after in _AFTER_ESCAPE else Escape()), at + 1


def _item(found: re.Match[str]) -> Item:
    groups = found.groupdict()
    if "flags" in groups:
        return Answered(bool(int(groups["flags"]) & EVENTS_FLAG))
    event, end = groups["event"], groups["end"]
    if event not in ("2", "3"):
        # The driver of the terminal does not expect an event.
        modifiers = "" if groups["modifiers"] is None else f";{groups['modifiers']}"
        return Text(f"\x1b[{groups['code']}{groups['others']}{modifiers}{groups['text'] or ''}{end}")
    code = int(groups["code"] or "0")
    if end == "u":
        character = chr(code) if code <= _LARGEST_CODE else ""
        key = _NAMES.get(character, character.lower())
    else:
        key = _ARROWS.get(end, "")
    return Repeated(key) if event == "2" else Released(key)
