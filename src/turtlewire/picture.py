"""A trace as a picture: SVG text, PNG bytes, or a file of either kind.

Pen-down strokes are solid dark lines, travel with the pen up is thin, pale and dashed; the turtle sits at
its last pose; a scale bar tells the size. Where several turtles drew, each has a colour. The same traces
always give the same bytes. The letters of the scale bar are drawn as lines, so a machine without fonts makes
the same picture.
"""

from __future__ import annotations

import errno
import math
import re
from typing import TYPE_CHECKING, Any, NamedTuple

from turtlewire import animation, whole_file
from turtlewire.errors import OutputError, UsageError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from turtlewire.trace import Obstacle, Stroke, Trace
    from turtlewire.turtle import Pose

FORMATS = (".svg", ".png")

# Pixels.
LONGEST_SIDE = 1000
SHORTEST_SIDE = 320
MARGIN = 48  # holds the turtle, wherever it stands
SCALE_STRIP = 36  # below the drawing, for the scale bar
SCALE_BAR_LONGEST = 200
SCALE_BAR_SHORTEST = 70  # 1, 2, 5, 10 ...: without an upper end, one of them always lies between
LETTER_HEIGHT = 13
LETTER_GAP = 3.0

# No line is magnified more than this; below SPECK_MM a drawing is rounding noise, shown as a point.
LARGEST_PX_PER_MM = 100.0
SPECK_MM = 0.01
PX_PER_MM_OF_A_POINT = 1.0

INK = "#1d2a3a"
# What those after the first draw with, over and over.
OTHER_INKS = ("#b3402a", "#2465a8", "#8a5a00", "#7a3f8f", "#00757a", "#b0307a")
TRAVEL = "#9fb6cf"
WALL = "#d9cdbf"
SCALE = "#5b6b7d"
SHELL, SHELL_LINE, SKIN = "#2f8f5b", "#e9f7ee", "#74c08c"

UNITS = (("km", 1_000_000), ("m", 1_000), ("cm", 10), ("mm", 1))
ROUND_LENGTHS_MM = [mantissa * 10**exponent for exponent in range(9) for mantissa in (1, 2, 5)]

# What a scale label can say, as (width, path): lines on a grid 10 high, y down, the baseline at 10.
LETTERS = {
    "0": (6.0, "M3,0C5,0 6,2 6,5S5,10 3,10 0,8 0,5 1,0 3,0Z"),
    "1": (3.4, "M0.4,2.2L3,0V10"),
    "2": (6.0, "M0.3,2.8C0.4,1 1.5,0 3.1,0S5.8,1 5.8,2.7C5.8,4.6 4.2,6 0.2,10H6"),
    "5": (6.0, "M5.3,0H1.1L0.6,4.6C1.3,4 2.1,3.7 3,3.7 4.8,3.7 6,5 6,6.8S4.8,10 3,10C1.7,10 0.6,9.4 0,8.4"),
    "c": (5.2, "M5.2,4.8C4.7,4 3.9,3.5 3,3.5 1.2,3.5 0,4.9 0,6.7S1.2,10 3,10C3.9,10 4.7,9.5 5.2,8.7"),
    "k": (5.0, "M0,0V10M4.6,3.5L0,7.6M1.8,6L5,10"),
    "m": (
        8.4,
        "M0,3.5V10M0,6C0,4.5 1,3.5 2.2,3.5S4.2,4.3 4.2,6V10M4.2,6C4.2,4.5 5.2,3.5 6.4,3.5S8.4,4.3 8.4,6V10",
    ),
    " ": (2.0, ""),
}

# Characters that XML cannot carry, not even escaped.
NOT_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

ADVICE = {
    errno.ENOSPC: "free some space there, or choose another folder",
    errno.EDQUOT: "free some space there, or choose another folder",
    errno.EFBIG: "free some space there, or choose another folder",
    errno.ENOENT: "make the folder first, or choose one that exists",
    errno.ENOTDIR: "choose a folder: a part of this path is a file",
    errno.EISDIR: "choose another name: this one is a folder",
    errno.EACCES: "choose a folder that you may write to",
    errno.EPERM: "choose a folder that you may write to",
    errno.EROFS: "choose a folder that you may write to",
    errno.ENAMETOOLONG: "choose a shorter name",
}


class Layout(NamedTuple):
    """How millimetres become pixels: the size of the sheet, and where the origin lies on it."""

    width: int
    height: int
    px_per_mm: float
    origin_x: float
    origin_y: float

    def place(self, x_mm: float, y_mm: float) -> str:
        """A point as SVG writes it; SVG's y axis points down."""
        x = self.origin_x + x_mm * self.px_per_mm
        y = self.origin_y - y_mm * self.px_per_mm
        return f"{round(x, 2):g},{round(y, 2):g}"


def save(
    trace: Trace,
    path: Path,
    *,
    title: str = "",
    obstacles: Sequence[Obstacle] = (),
    others: Sequence[Trace] = (),
    moves: bool = False,
) -> None:
    """Write a picture; the suffix of the path, .svg or .png, says which kind; ``moves`` as for ``svg``.

    The file appears whole or not at all: an old picture survives a full disk.

    Raises:
        UsageError: the suffix is neither .svg nor .png.
        OutputError: the file cannot be written.
    """
    kind = format_of(path)
    text = svg(trace, title=title, obstacles=obstacles, others=others, moves=moves)
    data = png(text) if kind == ".png" else text.encode()
    try:
        whole_file.replace(path, data)
    except OSError as error:
        advice = ADVICE.get(error.errno or 0, "choose another folder or name")
        reason = error.strerror or str(error)
        raise OutputError(f"cannot write the picture {path}: {reason}; {advice}") from error


def check(path: Path) -> None:
    """See early whether a picture can be written there: known format, a folder that exists.

    Raises ``UsageError``, or ``OutputError`` for a folder that is not there.
    """
    format_of(path)
    if not path.absolute().parent.is_dir():
        raise OutputError(f"cannot write the picture {path}: there is no folder {path.parent}; make it first")


def format_of(path: Path) -> str:
    """``".svg"`` or ``".png"``; to be asked before a robot sets out to draw.

    Raises:
        UsageError: the suffix is another one.
    """
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise UsageError(f"unknown picture format {path.suffix!r}: use .svg or .png")
    return kind


def svg(
    trace: Trace,
    *,
    title: str = "",
    obstacles: Sequence[Obstacle] = (),
    others: Sequence[Trace] = (),
    moves: bool = False,
) -> str:
    """The picture as SVG text.

    Args:
        trace: what the turtle drew.
        title: what a viewer shows as its name.
        obstacles: what stands around the turtle.
        others: what other turtles drew on the same ground.
        moves: let the lines be drawn before the viewer's eyes, in their order, where nobody has asked for less motion.

    Raises:
        OutputError: the drawing has no finite size.
    """
    import drawsvg  # type: ignore[import-untyped]

    layout = _layout([trace, *others], obstacles)
    drawing = drawsvg.Drawing(layout.width, layout.height)
    if title:
        drawing.append_title(NOT_XML.sub("\N{REPLACEMENT CHARACTER}", title))
    drawing.append(drawsvg.Rectangle(0, 0, layout.width, layout.height, fill="#ffffff"))
    lines = {"fill": "none", "stroke_linecap": "round", "stroke_linejoin": "round"}
    if obstacles:
        standing = drawsvg.Group(id="obstacles", stroke=WALL, stroke_width=6, **lines)
        for obstacle in obstacles:
            _draw_obstacle(drawsvg, standing, obstacle, layout)
        drawing.append(standing)
    if moves:
        drawing.append_css(animation.LINES)
    travel = drawsvg.Group(id="travel", stroke=TRAVEL, stroke_width=1.1, stroke_dasharray="5 5", **lines)
    drawing.append(travel)
    for number, each in enumerate([trace, *others]):
        ink = drawsvg.Group(id=_id("ink", number), stroke=_ink(number), stroke_width=2, **lines)
        total_s = animation.duration_s(each) if moves else 0.0
        for stroke, moment in zip(each.strokes, animation.moments(each.strokes, total_s), strict=True):
            shown = _shown(stroke, moment) if moves else {}
            (ink if stroke.pen_down else travel).append(drawsvg.Path(_path(stroke, layout), **shown))
        drawing.append(ink)
    scale = drawsvg.Group(id="scale", stroke=SCALE, stroke_width=1.6, **lines)
    _draw_scale(drawsvg, scale, layout)
    drawing.append(scale)
    for number, each in enumerate([trace, *others]):
        place = layout.place(each.pose.x_mm, each.pose.y_mm)
        heading = f"{round(each.pose.heading_deg, 2):g}"
        at = {"transform": f"translate({place}) rotate({heading})"}
        shell = _ink(number) if number else SHELL
        if moves and each.strokes:
            name, at["class_"] = _id("moving", number), _id("arrived", number)
            way, total_s = _way(each, layout), animation.duration_s(each)
            drawing.append_css(animation.turtle(way, total_s, name, at["class_"]))
            moving = drawsvg.Group(id=name, class_=name, visibility="hidden")
            _draw_turtle(drawsvg, moving, shell)
            drawing.append(moving)
        turtle = drawsvg.Group(id=_id("turtle", number), **at)
        _draw_turtle(drawsvg, turtle, shell)
        drawing.append(turtle)
    text = drawing.as_svg()
    assert isinstance(text, str)
    return text


def png(svg: str) -> bytes:
    """The PNG image of an SVG text, a pixel for each of its units."""
    import resvg_py

    return bytes(resvg_py.svg_to_bytes(svg_string=svg, skip_system_fonts=True))


def _id(name: str, number: int) -> str:
    """The id of what belongs to one of several turtles."""
    return f"{name}-{number + 1}" if number else name


def _ink(number: int) -> str:
    """The colour that one of several turtles draws with."""
    return OTHER_INKS[(number - 1) % len(OTHER_INKS)] if number else INK


def _draw_obstacle(drawsvg: Any, group: Any, obstacle: Obstacle, layout: Layout) -> None:
    """A wall as a line, a disc as a full circle."""
    if len(obstacle) == 4:
        x1, y1, x2, y2 = obstacle
        group.append(drawsvg.Path(f"M{layout.place(x1, y1)} {layout.place(x2, y2)}"))
        return
    x, y = layout.place(*obstacle[:2]).split(",")
    radius = round(obstacle[2] * layout.px_per_mm, 2)
    group.append(drawsvg.Circle(x, y, f"{radius:g}", fill=WALL, stroke="none"))


def _corners(obstacle: Obstacle) -> tuple[tuple[float, float], tuple[float, float]]:
    """Two opposite corners of what an obstacle covers."""
    if len(obstacle) == 4:
        return obstacle[:2], obstacle[2:]
    x, y, radius = obstacle
    return (x - radius, y - radius), (x + radius, y + radius)


def _layout(traces: Sequence[Trace], obstacles: Sequence[Obstacle]) -> Layout:
    """Fit all strokes and obstacles, and the turtles at their starts and ends, on a sheet."""
    poses: list[Pose] = [pose for trace in traces for pose in (trace.start, trace.pose)]
    points = [(pose.x_mm, pose.y_mm) for pose in poses]
    points += [point for trace in traces for stroke in trace.strokes for point in stroke.points]
    points += [corner for obstacle in obstacles for corner in _corners(obstacle)]
    xs, ys = [x for x, _ in points], [y for _, y in points]
    left, right, bottom, top = min(xs), max(xs), min(ys), max(ys)
    width_mm, height_mm = right - left, top - bottom
    if not math.isfinite(sum(xs) + sum(ys)):
        raise OutputError(
            "cannot draw the picture: the turtle went beyond all numbers; see that it turns back"
        )
    room_x, room_y = LONGEST_SIDE - 2 * MARGIN, LONGEST_SIDE - 2 * MARGIN - SCALE_STRIP
    px_per_mm = PX_PER_MM_OF_A_POINT
    if max(width_mm, height_mm) >= SPECK_MM:
        # The larger ratio is the tighter fit; divided last, so that no side is divided by zero.
        px_per_mm = min(1 / max(width_mm / room_x, height_mm / room_y), LARGEST_PX_PER_MM)
    width = max(SHORTEST_SIDE, round(width_mm * px_per_mm) + 2 * MARGIN)
    height = max(SHORTEST_SIDE, round(height_mm * px_per_mm) + 2 * MARGIN + SCALE_STRIP)
    return Layout(
        width,
        height,
        px_per_mm,
        width / 2 - (left / 2 + right / 2) * px_per_mm,
        (height - SCALE_STRIP) / 2 + (bottom / 2 + top / 2) * px_per_mm,
    )


def _path(stroke: Stroke, layout: Layout) -> str:
    """One polyline as path data; points that fall on the same spot are written once."""
    points: list[str] = []
    last = ""
    for x_mm, y_mm in stroke.points:
        point = layout.place(x_mm, y_mm)
        if point != last:
            points.append(point)
            last = point
    if len(points) == 1:
        points *= 2  # a dot is a line of no length, with round ends
    return "M" + " ".join(points)


def _way(trace: Trace, layout: Layout) -> str:
    """All that the turtle went, with its pen up or down, as path data."""
    return "M" + " ".join(_path(stroke, layout)[1:] for stroke in trace.strokes)


def _shown(stroke: Stroke, moment: animation.Moment) -> dict[str, Any]:
    """What makes a line be drawn at its moment; a dot, or travel, just appears then."""
    if not stroke.pen_down or len(set(stroke.points)) == 1:
        return {"class_": "way", "style": moment.style()}
    return {"class_": "ink", "pathLength": 1, "style": moment.style()}


def _draw_scale(drawsvg: Any, group: Any, layout: Layout) -> None:
    """A bar of a round length in the lower left corner, its label above."""
    fitting = [mm for mm in ROUND_LENGTHS_MM if mm * layout.px_per_mm <= SCALE_BAR_LONGEST]
    if not fitting or fitting[-1] * layout.px_per_mm < SCALE_BAR_SHORTEST:
        return  # larger than any floor
    length_mm = fitting[-1]
    unit, unit_mm = next((unit, mm) for unit, mm in UNITS if length_mm >= mm)
    label = f"{length_mm // unit_mm} {unit}"
    group.append_title(label)
    left, bottom = MARGIN / 2, layout.height - MARGIN / 2
    right = round(left + length_mm * layout.px_per_mm, 2)
    group.append(drawsvg.Path(f"M{left:g},{bottom - 5:g} V{bottom:g} H{right:g} V{bottom - 5:g}"))
    size = LETTER_HEIGHT / 10
    gap = LETTER_GAP
    width = sum(LETTERS[letter][0] + gap for letter in label) - gap
    x = (left + right - width * size) / 2
    y = bottom - 8 - LETTER_HEIGHT
    for letter in label:
        advance, path = LETTERS[letter]
        if path:
            transform = f"translate({round(x, 2):g},{y:g}) scale({size:g})"
            group.append(drawsvg.Path(path, transform=transform, stroke_width=1.3))
        x += (advance + gap) * size


def _draw_turtle(drawsvg: Any, group: Any, shell: str) -> None:
    """A turtle seen from above, looking up, its middle at 0, 0; about 40 pixels long."""
    outline = {"stroke": "#ffffff", "stroke_width": 1.2, "stroke_linejoin": "round"}
    group.append(drawsvg.Path("M-2.6,12 L0,20.5 L2.6,12 Z", fill=SKIN, **outline))
    for x, y, tilt in ((-10, -8.5, -42), (10, -8.5, 42), (-9.5, 9.5, 38), (9.5, 9.5, -38)):
        leg = f"translate({x:g},{y:g}) rotate({tilt:g})"
        group.append(drawsvg.Ellipse(0, 0, 3.6, 6.2, fill=SKIN, transform=leg, **outline))
    group.append(drawsvg.Ellipse(0, -17, 4.8, 6.2, fill=SKIN, **outline))
    for x in (-2, 2):
        group.append(drawsvg.Circle(x, -19.6, 1, fill=INK))
    group.append(drawsvg.Ellipse(0, 0, 11, 13, fill=shell, **outline))
    plates = "M0,-6.5 L5,-3.2 V3.2 L0,6.5 L-5,3.2 V-3.2 Z M0,-6.5 V-12 M5,-3.2 L9.2,-6 M5,3.2 L9.2,6"
    plates += " M0,6.5 V12 M-5,3.2 L-9.2,6 M-5,-3.2 L-9.2,-6"
    group.append(drawsvg.Path(plates, fill="none", stroke=SHELL_LINE, stroke_width=1.1))
