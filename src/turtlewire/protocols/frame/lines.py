"""Where in a TOML text each key stands, so that an error can name the line.

``tomllib`` says what a text means, not where. This walks a text that ``tomllib`` has accepted, so it has to tell
apart what may follow, never whether it is allowed.
"""

from __future__ import annotations

import re
from typing import Any

Path = tuple[str | int, ...]

_SPACE = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_BARE = re.compile(r"[A-Za-z0-9_-]+")
_SCALAR = re.compile(r"[^,\]}#\n]+")
# Strings, longest opening first; a basic one may carry escaped quotes, and up to two quotes may stand before the
# closing three.
_STRING = re.compile(
    r'"""(?:[^\\"]|\\.|"(?!""))*"""+' r"|'''(?:[^']|'(?!''))*'''+" r'|"(?:[^"\\\n]|\\.)*"' r"|'[^'\n]*'",
    re.DOTALL,
)


class _Walk:
    """One walk through a text."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.found: dict[Path, int] = {}

    def whole(self) -> dict[Path, int]:
        """Tables, arrays of tables, and keys at the beginning of lines."""
        table: Path = ()
        counts: dict[Path, int] = {}
        self.found[()] = 1
        self.skip()
        while self.at < len(self.text):
            if self.text.startswith("[[", self.at):
                self.at += 2
                line, name = self.line(), self.inside(self.key(), counts)
                counts[name] = counts.get(name, -1) + 1
                table = (*name, counts[name])
                self.note(name, line)
                self.note(table, line)
                self.at += 2
            elif self.text[self.at] == "[":
                self.at += 1
                line, table = self.line(), self.inside(self.key(), counts)
                self.note(table, line)
                self.at += 1
            else:
                self.pair(table)
            self.skip()
        return self.found

    @staticmethod
    def inside(name: tuple[str, ...], counts: dict[Path, int]) -> Path:
        """The path of a header: what stands in an array of tables stands in its last one."""
        path: Path = ()
        for part in name[:-1]:
            path = (*path, part)
            if path in counts:
                path = (*path, counts[path])
        return (*path, name[-1])

    def skip(self) -> None:
        match = _SPACE.match(self.text, self.at)
        assert match is not None
        self.at = match.end()

    def line(self) -> int:
        return self.text.count("\n", 0, self.at) + 1

    def note(self, path: Path, line: int) -> None:
        self.found.setdefault(path, line)

    def key(self) -> tuple[str, ...]:
        """A dotted key; stands behind it, and behind the space after it."""
        parts = []
        while True:
            self.skip()
            match = _STRING.match(self.text, self.at) or _BARE.match(self.text, self.at)
            assert match is not None
            parts.append(match[0].strip("\"'"))
            self.at = match.end()
            self.skip()
            if self.text[self.at] != ".":
                return tuple(parts)
            self.at += 1

    def pair(self, table: Path) -> None:
        """A key, =, and a value."""
        line = self.line()
        path = table
        for part in self.key():
            path = (*path, part)
            self.note(path, line)
        self.at += 1
        self.skip()
        self.value(path)

    def value(self, path: Path) -> None:
        self.note(path, self.line())
        if self.text[self.at] == "[":
            self.members(path, "]")
        elif self.text[self.at] == "{":
            self.members(path, "}")
        else:
            match = _STRING.match(self.text, self.at) or _SCALAR.match(self.text, self.at)
            assert match is not None
            self.at = match.end()

    def members(self, path: Path, closing: str) -> None:
        """What stands in an array or an inline table."""
        self.at += 1
        count = 0
        while True:
            self.skip()
            if self.text[self.at] == closing:
                self.at += 1
                return
            if self.text[self.at] == ",":
                self.at += 1
            elif closing == "]":
                self.value((*path, count))
                count += 1
            else:
                self.pair(path)


def lines(text: str) -> dict[Path, int]:
    """The line (from 1) of every table, key and element of an array in a TOML text that ``tomllib`` accepts.

    A path is what leads there from the top: ``("message", 0, "fields", 1, "kind")``. A key with escapes in it is
    found by its raw text.
    """
    return _Walk(text).whole()


def line_of(found: dict[Path, int], path: tuple[Any, ...]) -> int:
    """The line of a path, or of the nearest thing around it that has one."""
    while path not in found:
        path = path[:-1]
    return found[path]
