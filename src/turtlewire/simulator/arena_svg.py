"""Arenas drawn as SVG: straight lines are walls, circles are round obstacles, and ``id="start"`` says where to start.

A user unit is a millimetre, unless the drawing says how large it is (``width="2m" viewBox="0 0 100 100"``: 20 mm
each). SVG's y points down and the world's up: a point at (x, y) of the drawing is at (x, -y) of the world. Of what is
drawn, only geometry counts, not stroke or fill. Elements: line, polyline, polygon, rect, circle, path (straight
segments: M L H V Z), g with transforms. ``id="start"`` on a line starts at its first end and looks along it; on a
circle, at its middle, looking up; further robots start at ``start-2``, ``start-3`` and so on. Titles, texts, styles,
metadata and definitions are passed over.
"""

from __future__ import annotations

import math
import re
from itertools import pairwise
from typing import NamedTuple
from xml.etree import ElementTree as ET

from turtlewire.errors import DataError
from turtlewire.simulator.world import TOUCH_MM, Disc, Wall, World
from turtlewire.turtle import HOME, Pose

# Coordinates that an arena may have: beyond, the arithmetic would lose micrometres.
FURTHEST_MM = 1e6
MM_PER_UNIT = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "pt": 25.4 / 72.0, "pc": 25.4 / 6.0}
PASSED_OVER = {"defs", "desc", "metadata", "namedview", "script", "style", "text", "title"}
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
LENGTH = re.compile(rf"\s*({NUMBER})\s*([a-z%]*)\s*")
PATH_TOKEN = re.compile(rf"\s*,?\s*({NUMBER}|[A-Za-z])")
TRANSFORM = re.compile(r"\s*,?\s*([a-zA-Z]+)\s*\(([^)]*)\)\s*")
START = re.compile(r"start(?:-([1-9]\d*))?")
# How many numbers each straight segment takes.
SEGMENTS = {"m": 2, "l": 2, "h": 1, "v": 1, "z": 0}
Point = tuple[float, float]


class Transform(NamedTuple):
    """SVG's matrix(a b c d e f)."""

    a: float = 1.0
    b: float = 0.0
    c: float = 0.0
    d: float = 1.0
    e: float = 0.0
    f: float = 0.0

    def apply(self, point: Point) -> Point:
        """Where a point gets."""
        x, y = point
        return self.a * x + self.c * y + self.e, self.b * x + self.d * y + self.f

    def then_inside(self, inner: Transform) -> Transform:
        """The transform of what is transformed inside of this one."""
        a, b = self.a * inner.a + self.c * inner.b, self.b * inner.a + self.d * inner.b
        c, d = self.a * inner.c + self.c * inner.d, self.b * inner.c + self.d * inner.d
        return Transform(a, b, c, d, *self.apply((inner.e, inner.f)))


def read_svg(text: str, path: str) -> World:
    """The world that a drawing shows; ``path`` is its name in complaints.

    Raises ``DataError``, with the element, for what is no SVG or cannot be a wall.
    """
    try:
        root = ET.fromstring(text)
    except ET.ParseError as error:
        raise DataError(f"{path}: this is no valid SVG: {error}") from None
    if _tag(root) != "svg":
        raise DataError(f"{path}: this is no SVG: its outermost element is {_tag(root)!r}")
    drawing = _Drawing(path)
    drawing.read(root)
    first, *more = [pose for _, pose in sorted(drawing.starts.items())] or [HOME]
    return World(tuple(drawing.walls), first, tuple(drawing.discs), tuple(more))


def _tag(element: ET.Element) -> str:
    return element.tag.rpartition("}")[2]


class _Drawing:
    """Collects what is drawn; every complaint names the file and the element."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.walls: list[Wall] = []
        self.discs: list[Disc] = []
        self.starts: dict[int, Pose] = {}
        self._numbers: dict[str, int] = {}
        self._where = "svg"

    def read(self, root: ET.Element) -> None:
        """Take the whole drawing."""
        self._children(root, self._size(root))

    def _size(self, root: ET.Element) -> Transform:
        """Millimetres for each user unit, and y up."""
        box = self._list(root.get("viewBox", ""), "viewBox")
        matched = LENGTH.fullmatch(root.get("width", ""))
        if not box or matched is None or matched[2] not in MM_PER_UNIT:
            return Transform(d=-1.0)
        if len(box) != 4 or box[2] <= 0.0:
            raise self._wrong("its viewBox must be four numbers: left, top, width, height")
        each = float(matched[1]) * MM_PER_UNIT[matched[2]] / box[2]
        if each <= 0.0:
            raise self._wrong(f"its width is {root.get('width')!r}, but must be above 0")
        return Transform(a=each, d=-each)

    def _children(self, element: ET.Element, outer: Transform) -> None:
        for child in element:
            if isinstance(child.tag, str):  # neither comment nor processing instruction
                self._element(child, outer)

    def _element(self, element: ET.Element, outer: Transform) -> None:
        tag = _tag(element)
        if tag in PASSED_OVER or element.get("display") == "none":
            return
        self._numbers[tag] = self._numbers.get(tag, 0) + 1
        name = element.get("id")
        self._where = f"{tag} {self._numbers[tag]}" + (f" (id {name!r})" if name else "")
        transform = outer.then_inside(self._transform(element.get("transform", "")))
        marked = START.fullmatch(name or "")
        start = int(marked[1] or 1) if marked else None
        if tag in ("g", "a", "svg"):
            self._children(element, transform)
        elif tag == "circle":
            self._circle(element, transform, start)
        elif start is not None:
            if tag != "line":
                raise self._wrong("the start is a line, from the place in the direction, or a circle")
            here, there = (transform.apply(point) for point in self._line(element))
            self._start(start, Pose(*self._checked(here), Pose(*here).bearing_to(*there)))
        else:
            for polyline in self._polylines(element, tag):
                self._add([self._checked(transform.apply(point)) for point in polyline])

    def _polylines(self, element: ET.Element, tag: str) -> list[list[Point]]:
        match tag:
            case "line":
                return [self._line(element)]
            case "polyline" | "polygon":
                numbers = self._list(element.get("points", ""), "points")
                if len(numbers) % 2 or len(numbers) < 4:
                    raise self._wrong("its points must be pairs of numbers, at least two of them")
                points = list(zip(numbers[::2], numbers[1::2], strict=True))
                return [[*points, points[0]] if tag == "polygon" else points]
            case "rect":
                if self._number(element, "rx") or self._number(element, "ry"):
                    raise self._wrong("rounded corners are no straight walls")
                x, y, width, height = (self._number(element, name) for name in ("x", "y", "width", "height"))
                if width <= 0.0 or height <= 0.0:
                    raise self._wrong("its width and height must be above 0")
                return [[(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)]]
            case "path":
                return self._path(element.get("d", ""))
        known = "line, polyline, polygon, rect, circle, path and g"
        raise self._wrong(f"this cannot be a wall; what can: {known}")

    def _line(self, element: ET.Element) -> list[Point]:
        x1, y1, x2, y2 = (self._number(element, name) for name in ("x1", "y1", "x2", "y2"))
        return [(x1, y1), (x2, y2)]

    def _circle(self, element: ET.Element, transform: Transform, start: int | None) -> None:
        middle = (self._number(element, "cx"), self._number(element, "cy"))
        x, y = self._checked(transform.apply(middle))
        if start is not None:
            self._start(start, Pose(x, y, 0.0))
            return
        a, b, c, d = transform[:4]
        scale, other = math.hypot(a, b), math.hypot(c, d)
        if abs(scale - other) > 1e-6 * scale or abs(a * c + b * d) > 1e-6 * scale * scale:
            raise self._wrong("a circle that is drawn as an ellipse cannot be an obstacle")
        radius = self._number(element, "r") * scale
        if radius <= 0.0:
            raise self._wrong("its radius must be above 0")
        self.discs.append(Disc(x, y, radius))

    def _start(self, number: int, pose: Pose) -> None:
        if number in self.starts:
            raise self._wrong(f"start {number} is there already")
        self.starts[number] = pose

    def _path(self, text: str) -> list[list[Point]]:
        tokens = self._path_tokens(text)
        polylines: list[list[Point]] = []
        command, place = "", 0
        x = y = 0.0
        while place < len(tokens):
            if tokens[place].isalpha():
                command = tokens[place]
                place += 1
            elif command in "Zz":  # also before the first command
                raise self._wrong(f"its path has a number {tokens[place]} where a command must be")
            kind, numbers = command.lower(), tokens[place : place + SEGMENTS.get(command.lower(), 0)]
            if kind not in SEGMENTS:
                raise self._wrong(
                    f"its path has {command!r}: only straight segments (M L H V Z) can be walls"
                )
            if len(numbers) < SEGMENTS[kind] or any(number.isalpha() for number in numbers):
                raise self._wrong(f"its path has too few numbers after {command!r}")
            if kind != "m" and not polylines:
                raise self._wrong("its path must start with M")
            place += len(numbers)
            values = [float(number) for number in numbers]
            if kind == "z":
                values = list(polylines[-1][0])
            from_x, from_y = (x, y) if command.islower() and kind != "z" else (0.0, 0.0)
            if kind != "v":
                x = from_x + values[0]
            if kind != "h":
                y = from_y + values[-1]
            if kind == "m":
                polylines.append([(x, y)])
                command = "l" if command == "m" else "L"  # further pairs are lines
            elif kind == "z":
                polylines[-1].append((x, y))
                if place < len(tokens) and tokens[place] not in "Mm":
                    polylines.append([(x, y)])
            else:
                polylines[-1].append((x, y))
        return polylines

    def _path_tokens(self, text: str) -> list[str]:
        tokens, place = [], 0
        text = text.strip()
        while place < len(text):
            matched = PATH_TOKEN.match(text, place)
            if matched is None:
                raise self._wrong(f"its path has {text[place:].strip()[:10]!r}")
            tokens.append(matched[1])
            place = matched.end()
        return tokens

    def _transform(self, text: str) -> Transform:
        whole, place = Transform(), 0
        while place < len(text.rstrip()):
            matched = TRANSFORM.match(text, place)
            if matched is None:
                raise self._wrong(f"its transform is {text!r}")
            whole = whole.then_inside(self._one_transform(matched[1], self._list(matched[2], "transform")))
            place = matched.end()
        return whole

    def _one_transform(self, name: str, values: list[float]) -> Transform:
        match name, values:
            case "matrix", [a, b, c, d, e, f]:
                return Transform(a, b, c, d, e, f)
            case "translate", [x]:
                return Transform(e=x)
            case "translate", [x, y]:
                return Transform(e=x, f=y)
            case "scale", [x]:
                return Transform(a=x, d=x)
            case "scale", [x, y]:
                return Transform(a=x, d=y)
            case "rotate", [angle]:
                sine, cosine = math.sin(math.radians(angle)), math.cos(math.radians(angle))
                return Transform(cosine, sine, -sine, cosine)
            case "rotate", [angle, x, y]:
                there = Transform(e=x, f=y).then_inside(self._one_transform("rotate", [angle]))
                return there.then_inside(Transform(e=-x, f=-y))
        raise self._wrong(f"its transform {name} of {len(values)} numbers is not known")

    def _add(self, points: list[Point]) -> None:
        for one, other in pairwise(points):
            if math.dist(one, other) >= TOUCH_MM:  # programs close what is closed already
                self.walls.append(Wall(*one, *other))

    def _number(self, element: ET.Element, name: str) -> float:
        text = element.get(name, "0")
        matched = LENGTH.fullmatch(text)
        if matched is None or matched[2] not in ("", "px"):
            raise self._wrong(f"its {name} is {text!r}, but must be a number, in units of the drawing")
        return float(matched[1])

    def _list(self, text: str, name: str) -> list[float]:
        try:
            return [float(part) for part in re.split(r"[\s,]+", text.strip()) if part]
        except ValueError:
            raise self._wrong(f"its {name} is {text!r}, but must be numbers") from None

    def _checked(self, point: Point) -> Point:
        if not all(abs(value) <= FURTHEST_MM for value in point):
            x, y = point
            raise self._wrong(f"it reaches {x:g}, {y:g} mm: further than {FURTHEST_MM:.0f} mm")
        return point[0] + 0.0, point[1] + 0.0  # no -0.0

    def _wrong(self, what: str) -> DataError:
        return DataError(f"{self.path}: {self._where}: {what}")
