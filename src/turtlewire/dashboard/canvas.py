"""Drawing with the eight dots of a braille character: lines, in as few cells as a terminal has."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

DOTS_ACROSS, DOTS_DOWN = 2, 4
BLANK = 0x2800
# The bit of each dot of a character, by column and row.
BITS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))


class Cell(NamedTuple):
    """What is in a cell: a character, and the layer that it is of."""

    character: str
    layer: int


class Canvas:
    """So many cells. Dots are counted from the top left; what lies outside is cut off.

    Where dots of several layers meet in a cell, it is of the highest.
    """

    def __init__(self, columns: int, rows: int) -> None:
        self.columns, self.rows = columns, rows
        self.width, self.height = columns * DOTS_ACROSS, rows * DOTS_DOWN
        self._bits = [[0] * columns for _ in range(rows)]
        self._layers = [[0] * columns for _ in range(rows)]
        self._characters: dict[tuple[int, int], str] = {}

    def dot(self, x: int, y: int, layer: int) -> None:
        """Set a dot."""
        if 0 <= x < self.width and 0 <= y < self.height:
            row, column = y // DOTS_DOWN, x // DOTS_ACROSS
            self._bits[row][column] |= BITS[x % DOTS_ACROSS][y % DOTS_DOWN]
            self._layers[row][column] = max(self._layers[row][column], layer)

    def line(
        self, start: tuple[float, float], end: tuple[float, float], layer: int, *, every: int = 1
    ) -> None:
        """Draw a straight line; ``every`` so many dots one, counted so that lines that follow go on evenly."""
        inside = _clipped(start, end, self.width, self.height)
        if inside is None:
            return
        (x1, y1), (x2, y2) = inside
        steps = max(abs(round(x2) - round(x1)), abs(round(y2) - round(y1)), 1)
        for step in range(steps + 1):
            x, y = round(x1 + (x2 - x1) * step / steps), round(y1 + (y2 - y1) * step / steps)
            if every == 1 or (x + y) % every == 0:
                self.dot(x, y, layer)

    def polyline(self, points: Sequence[tuple[float, float]], layer: int, *, every: int = 1) -> None:
        """Draw lines from point to point."""
        for start, end in pairwise(points):
            self.line(start, end, layer, every=every)

    def circle(self, middle: tuple[float, float], radius: float, layer: int) -> None:
        """Draw a circle."""
        if not radius < 4 * (self.width + self.height):
            return
        steps = max(8, math.ceil(2.0 * math.pi * radius))
        for step in range(steps):
            angle = 2.0 * math.pi * step / steps
            x, y = middle[0] + radius * math.cos(angle), middle[1] + radius * math.sin(angle)
            if -1 <= x <= self.width and -1 <= y <= self.height:
                self.dot(round(x), round(y), layer)

    def put(self, x: float, y: float, character: str, layer: int) -> None:
        """Put a character in the cell of a dot, instead of dots."""
        column, row = math.floor(x / DOTS_ACROSS), math.floor(y / DOTS_DOWN)
        if 0 <= column < self.columns and 0 <= row < self.rows:
            self._characters[row, column] = character
            self._layers[row][column] = layer

    def cells(self) -> list[list[Cell]]:
        """All rows, from the top."""
        return [
            [
                Cell(self._characters.get((row, column), chr(BLANK + bits) if bits else " "), layer)
                for column, (bits, layer) in enumerate(zip(*lines, strict=True))
            ]
            for row, lines in enumerate(zip(self._bits, self._layers, strict=True))
        ]


def _clipped(
    start: tuple[float, float], end: tuple[float, float], width: int, height: int
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """The part of a line that is on the canvas (Liang and Barsky)."""
    (x, y), (dx, dy) = start, (end[0] - start[0], end[1] - start[1])
    first, last = 0.0, 1.0
    for way, room in ((-dx, x), (dx, width - 1 - x), (-dy, y), (dy, height - 1 - y)):
        if way == 0.0:
            if room < 0.0:
                return None
        elif way < 0.0:
            first = max(first, room / way)
        else:
            last = min(last, room / way)
    if first > last:
        return None
    return (x + first * dx, y + first * dy), (x + last * dx, y + last * dy)
