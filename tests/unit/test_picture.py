"""Pictures: what is in the SVG, what the PNG shows, and files that are whole or not there."""

from __future__ import annotations

import os
import random
import re
import resource
import struct
import subprocess
import sys
import time
import zlib
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import pytest

from turtlewire import picture
from turtlewire.errors import OutputError, UsageError
from turtlewire.trace import Trace
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from collections.abc import Iterator

SVG = "{http://www.w3.org/2000/svg}"
WHITE = (255, 255, 255)


def drawn(*places: tuple[float, float], pen_down: bool = True, heading_deg: float = 0.0) -> Trace:
    """The trace of a turtle that went from home to each of these places."""
    trace = Trace()
    for x, y in places:
        trace.move(Pose(x, y, heading_deg), pen_down=pen_down)
    return trace


class Sheet:
    """An SVG as a reader finds it: in pixels, y down."""

    def __init__(self, text: str) -> None:
        self.root = ET.fromstring(text)
        self.width = float(self.root.get("width", "nan"))
        self.height = float(self.root.get("height", "nan"))

    def group(self, name: str) -> ET.Element:
        (found,) = (group for group in self.root.iter(f"{SVG}g") if group.get("id") == name)
        return found

    def lines(self, name: str) -> list[list[tuple[float, float]]]:
        lines = []
        for path in self.group(name).iter(f"{SVG}path"):
            numbers = [float(number) for number in re.findall(r"-?[\d.]+", path.get("d", ""))]
            lines.append(list(zip(numbers[::2], numbers[1::2], strict=True)))
        return lines

    def turtle(self) -> tuple[float, float, float]:
        """Where it is, and how far it is turned to the right."""
        transform = self.group("turtle").get("transform", "")
        found = re.fullmatch(r"translate\(([\d.]+),([\d.]+)\) rotate\((-?[\d.]+)\)", transform)
        assert found
        return float(found[1]), float(found[2]), float(found[3])

    def scale(self) -> tuple[str, float]:
        """The label of the scale bar, and its length."""
        group = self.group("scale")
        bar = group.find(f"{SVG}path")
        assert bar is not None
        found = re.fullmatch(r"M([\d.]+),([\d.]+) V([\d.]+) H([\d.]+) V\2", bar.get("d", ""))
        assert found
        return group.findtext(f"{SVG}title", ""), float(found[4]) - float(found[1])


def plain(row: bytes, above: bytes) -> bytes:
    return row


def add_left(row: bytes, above: bytes) -> bytes:
    whole = bytearray(row)
    for channel in range(4):
        whole[channel::4] = bytes(value % 256 for value in accumulate(row[channel::4]))
    return bytes(whole)


def add_above(row: bytes, above: bytes) -> bytes:
    return bytes((one + other) % 256 for one, other in zip(row, above, strict=True))


def add_average(row: bytes, above: bytes) -> bytes:
    whole = bytearray(4) + row
    for i, over in enumerate(above, 4):
        whole[i] = (whole[i] + (whole[i - 4] + over) // 2) % 256
    return bytes(whole[4:])


def add_paeth(row: bytes, above: bytes) -> bytes:
    whole, over = bytearray(4) + row, bytes(4) + above
    for i in range(4, len(whole)):
        left, up, corner = whole[i - 4], over[i], over[i - 4]
        to_left, to_up, to_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
        if to_left <= to_up and to_left <= to_corner:
            whole[i] = (whole[i] + left) % 256
        else:
            whole[i] = (whole[i] + (up if to_up <= to_corner else corner)) % 256
    return bytes(whole[4:])


FILTERS = (plain, add_left, add_above, add_average, add_paeth)


class Image:
    """A PNG, decoded: what it says about each pixel, as (red, green, blue) on white."""

    def __init__(self, data: bytes) -> None:
        assert data.startswith(b"\x89PNG\r\n\x1a\n")
        packed, at = b"", 8
        while at < len(data):
            (length,) = struct.unpack_from(">I", data, at)
            kind, content = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
            if kind == b"IHDR":
                self.width, self.height, depth, colour = struct.unpack_from(">IIBB", content)
                assert (depth, colour) == (8, 6)
            elif kind == b"IDAT":
                packed += content
            at += 12 + length
        self.rows = self._unfiltered(zlib.decompress(packed))

    def _unfiltered(self, raw: bytes) -> list[bytes]:
        rows: list[bytes] = []
        above = bytes(4 * self.width)
        for start in range(0, len(raw), 4 * self.width + 1):
            row = raw[start + 1 : start + 1 + 4 * self.width]
            above = FILTERS[raw[start]](row, above)
            rows.append(above)
        return rows

    def pixel(self, x: float, y: float) -> tuple[int, int, int]:
        red, green, blue, alpha = self.rows[int(y)][4 * int(x) : 4 * int(x) + 4]
        assert alpha == 255
        return red, green, blue

    def is_dark(self, x: float, y: float) -> bool:
        return max(self.pixel(x, y)) < 110

    def marks(self, x1: float, y1: float, x2: float, y2: float) -> int:
        """How many pixels of this rectangle are not white."""
        return sum(
            self.pixel(x, y) != WHITE for y in range(int(y1), int(y2)) for x in range(int(x1), int(x2))
        )


# --- the lines ------------------------------------------------------------------------------------------------


def test_up_in_logo_is_up_on_the_sheet() -> None:
    sheet = Sheet(picture.svg(drawn((0, 100), (50, 100))))
    ((start, corner, end),) = sheet.lines("ink")
    assert corner[0] == start[0]
    assert corner[1] < start[1]
    assert end[1] == corner[1]
    assert end[0] - corner[0] == pytest.approx((start[1] - corner[1]) / 2, abs=0.02)


def test_pen_up_travel_is_dashed_thin_and_pale_and_ink_is_neither() -> None:
    trace = drawn((0, 100))
    trace.move(Pose(100, 100), pen_down=False)
    trace.move(Pose(100, 0), pen_down=True)
    sheet = Sheet(picture.svg(trace))
    ink, travel = sheet.group("ink"), sheet.group("travel")
    assert [len(sheet.lines("ink")), len(sheet.lines("travel"))] == [2, 1]
    assert ink.get("stroke-dasharray") is None
    assert travel.get("stroke-dasharray")
    assert float(travel.get("stroke-width", "")) < float(ink.get("stroke-width", ""))
    assert int(travel.get("stroke", "")[1:], 16) > int(ink.get("stroke", "")[1:], 16)
    assert ink.get("stroke-linejoin") == "round"
    assert {ink.get("fill"), travel.get("fill")} == {"none"}


def test_ink_lies_over_travel_and_the_turtle_over_all() -> None:
    groups = [group.get("id") for group in Sheet(picture.svg(drawn((0, 1)))).root.iter(f"{SVG}g")]
    assert groups == ["travel", "ink", "scale", "turtle"]


def test_walls_are_lines_and_discs_are_full_circles_below_all_else() -> None:
    text = picture.svg(drawn((0.0, 100.0)), obstacles=[(-200.0, 0.0, -200.0, 100.0), (150.0, 50.0, 50.0)])
    sheet = Sheet(text)
    (wall,) = sheet.lines("obstacles")
    assert wall[0][0] == wall[1][0]
    (circle,) = sheet.group("obstacles").iter(f"{SVG}circle")
    x, y, radius = (float(circle.get(name, "nan")) for name in ("cx", "cy", "r"))
    # To scale: 350 mm lie between the wall and its middle, and its edge is the sheet's margin.
    scale = (x - wall[0][0]) / 350.0
    assert radius == pytest.approx(50.0 * scale, abs=0.01)
    assert x + radius == pytest.approx(sheet.width - picture.MARGIN, abs=1.0)
    assert y == pytest.approx((wall[0][1] + wall[1][1]) / 2.0, abs=0.02)
    assert text.index('id="obstacles"') < text.index('id="travel"')


def test_each_of_several_turtles_has_its_ink_and_its_place() -> None:
    traces = [drawn((100.0 * n, 100.0), heading_deg=10.0 * n) for n in range(9)]
    sheet = Sheet(picture.svg(traces[0], others=traces[1:]))
    colours = [sheet.group("ink").get("stroke")]
    colours += [sheet.group(f"ink-{n}").get("stroke") for n in range(2, 10)]
    assert len(set(colours[:7])) == 7
    assert colours[7:] == colours[1:3]
    ends = [sheet.lines("ink")[0][-1][0], *(sheet.lines(f"ink-{n}")[0][-1][0] for n in range(2, 10))]
    assert ends == sorted(ends)
    assert ends[-1] == pytest.approx(sheet.width - picture.MARGIN, abs=1.0)
    turns = [sheet.group(f"turtle-{n}").get("transform", "").rpartition("rotate")[2] for n in range(2, 10)]
    assert turns == [f"({10 * n})" for n in range(1, 9)]
    for n in range(2, 10):
        shells = [ellipse.get("fill") for ellipse in sheet.group(f"turtle-{n}").iter(f"{SVG}ellipse")]
        assert colours[n - 1] in shells


def test_each_stroke_is_one_path() -> None:
    trace = Trace()
    for i in range(1, 11):
        trace.move(Pose(10.0 * i, 10.0 * i), pen_down=i % 2 == 0)
    sheet = Sheet(picture.svg(trace))
    assert len(sheet.lines("ink")) == 5
    assert len(sheet.lines("travel")) == 5


def test_points_that_fall_together_are_written_once() -> None:
    sheet = Sheet(picture.svg(drawn((0, 1e-5), (0, 2e-5), (0, 100), (0, 100.00001), (0, 200))))
    assert [len(line) for line in sheet.lines("ink")] == [3]


def test_a_dot_beside_a_large_drawing_stays_visible() -> None:
    trace = drawn((0, 1e6), pen_down=False)
    trace.move(Pose(1, 1e6), pen_down=True)
    trace.move(Pose(1, 2e6), pen_down=False)
    text = picture.svg(trace)
    ((dot, same),) = Sheet(text).lines("ink")
    assert dot == same
    assert Image(picture.png(text)).is_dark(*dot)


def test_coordinates_have_at_most_two_decimals() -> None:
    text = picture.svg(drawn((1 / 3, 2 / 3), (100 / 7, 200 / 7), (1000 / 9, 30)))
    assert not re.search(r"\d\.\d{3}", text)


def test_the_same_trace_gives_the_same_bytes() -> None:
    one, other = drawn((10, 20), (30, 5)), drawn((10, 20), (30, 5))
    assert picture.svg(one) == picture.svg(other)
    assert picture.png(picture.svg(one)) == picture.png(picture.svg(other))


# --- the sheet ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [9.0, 10.0, 800.0, 123_456.0, 1e9, 1e300])
@pytest.mark.parametrize("shape", [(1, 1), (1, 0.5), (0.3, 1), (1, 0), (0, 1)])
def test_the_longest_side_is_about_1000_pixels(size: float, shape: tuple[float, float]) -> None:
    sheet = Sheet(picture.svg(drawn((size * shape[0], size * shape[1]))))
    assert 960 <= max(sheet.width, sheet.height) <= 1000
    assert min(sheet.width, sheet.height) >= 320


@pytest.mark.parametrize("size", [0.0, 1e-9, 0.5, 3.0, 800.0, 1e9])
@pytest.mark.parametrize("shape", [(1, 1), (-1, 0.5), (0.3, -1), (1, 0), (0, -1)])
@pytest.mark.parametrize("pen_down", [True, False])
def test_everything_is_within_the_margins(size: float, shape: tuple[float, float], pen_down: bool) -> None:
    trace = drawn((size * shape[0], size * shape[1]), (0, size / 2), pen_down=pen_down)
    sheet = Sheet(picture.svg(trace))
    points = [point for name in ("ink", "travel") for line in sheet.lines(name) for point in line]
    points.append(sheet.turtle()[:2])
    for x, y in points:
        assert 47.5 <= x <= sheet.width - 47.5
        assert 47.5 <= y <= sheet.height - 47.5 - 36


@pytest.mark.parametrize("scale", [1.0, 1000.0])
def test_a_drawing_far_from_home_fills_the_sheet_if_the_turtle_started_there(scale: float) -> None:
    trace = Trace(Pose(5000 * scale, -7000 * scale))
    trace.move(Pose(5000 * scale, -6900 * scale), pen_down=True)
    ((start, end),) = Sheet(picture.svg(trace)).lines("ink")
    assert start[1] - end[1] == pytest.approx(1000 - 2 * 48 - 36, abs=1)


@pytest.mark.parametrize("start", [Pose(0, 900), HOME])
def test_start_and_end_belong_to_the_picture_even_where_nothing_leads_there(start: Pose) -> None:
    trace = Trace(start)
    trace.pose = Pose(0, 900) if start == HOME else HOME
    sheet = Sheet(picture.svg(trace))
    assert sheet.height == pytest.approx(1000, abs=1)
    assert 47 <= sheet.turtle()[1] <= sheet.height - 47


def test_an_empty_picture_shows_the_turtle_in_the_middle() -> None:
    sheet = Sheet(picture.svg(Trace()))
    assert sheet.lines("ink") == sheet.lines("travel") == []
    assert sheet.turtle() == (sheet.width / 2, (sheet.height - 36) / 2, 0)
    assert sheet.scale() == ("20 cm", 200)


def test_rounding_noise_is_not_magnified() -> None:
    assert Sheet(picture.svg(drawn((1e-9, 1e-12)))).scale() == ("20 cm", 200)


def test_the_smallest_step_of_a_robot_is_visible_and_not_huge() -> None:
    sheet = Sheet(picture.svg(drawn((0, 0.5))))
    ((start, end),) = sheet.lines("ink")
    assert start[1] - end[1] == pytest.approx(50)
    assert sheet.scale() == ("2 mm", 200)


@pytest.mark.parametrize("far", [float("inf"), float("nan"), 1.7e308])
def test_a_drawing_without_a_finite_size_is_refused(far: float) -> None:
    with pytest.raises(OutputError, match="beyond all numbers"):
        picture.svg(drawn((far, 0), (-far, 0), (far, 0), (far, 1)))


# --- the scale bar --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("size_mm", "label", "length_mm"),
    [
        (9, "2 mm", 2),
        (30, "5 mm", 5),
        (60, "1 cm", 10),
        (500, "10 cm", 100),
        (2600, "50 cm", 500),
        (4600, "1 m", 1000),
        (500_000, "100 m", 100_000),
        (4.7e6, "1 km", 1e6),
        (2e9, "200 km", 2e8),
    ],
)
def test_the_scale_bar_is_true_and_round(size_mm: float, label: str, length_mm: float) -> None:
    sheet = Sheet(picture.svg(drawn((size_mm, 0))))
    ((start, end),) = sheet.lines("ink")
    shown, length_px = sheet.scale()
    assert shown == label
    assert length_px / (end[0] - start[0]) == pytest.approx(length_mm / size_mm, rel=1e-3)
    assert 70 <= length_px <= 200


@pytest.mark.parametrize("exponent", range(1, 9))
@pytest.mark.parametrize("mantissa", [1.0, 1.3, 2.2, 4.4, 4.6, 7.0, 9.9])
def test_every_label_can_be_written(exponent: int, mantissa: float) -> None:
    sheet = Sheet(picture.svg(drawn((mantissa * 10**exponent, 0))))
    label, length_px = sheet.scale()
    assert re.fullmatch("[125]0{0,2} (mm|cm|m|km)", label)
    assert 70 <= length_px <= 200
    letters = len(label) - 1
    assert len(sheet.group("scale").findall(f"{SVG}path")) == 1 + letters


def test_beyond_all_floors_there_is_no_scale_bar() -> None:
    assert len(Sheet(picture.svg(drawn((1e12, 0)))).group("scale")) == 0


def test_the_label_needs_no_font() -> None:
    text = picture.svg(drawn((500, 300)))
    assert "<text" not in text
    sheet = Sheet(text)
    image = Image(picture.png(text))
    label, length_px = sheet.scale()
    assert label == "10 cm"
    # The letters stand over the middle of the bar, and nothing else does.
    middle = 24 + length_px / 2
    bottom = sheet.height - 24
    assert image.marks(middle - 40, bottom - 23, middle + 40, bottom - 6) > 100
    assert image.marks(24, bottom - 23, middle - 40, bottom - 6) == 0
    widths = [image.marks(middle + x, bottom - 23, middle + x + 1, bottom - 6) > 0 for x in range(-30, 30)]
    assert 45 < 60 - widths[::-1].index(True) - widths.index(True) < 58  # letters lie side by side
    assert image.is_dark(middle, bottom) or image.pixel(middle, bottom - 1) != WHITE


# --- the turtle -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("heading_deg", [0.0, 45.0, 90.0, 180.0, 359.5])
def test_the_turtle_looks_along_its_heading(heading_deg: float) -> None:
    sheet = Sheet(picture.svg(drawn((0, 100), (80, 100), heading_deg=heading_deg)))
    x, y, turned = sheet.turtle()
    assert turned == heading_deg
    assert (x, y) == sheet.lines("ink")[0][-1]


def test_the_turtles_head_is_where_it_looks_in_the_png() -> None:
    trace = Trace()
    trace.move(HOME.turned(90), pen_down=True)
    text = picture.svg(trace)
    x, y, _ = Sheet(text).turtle()
    image = Image(picture.png(text))
    assert image.marks(x + 14, y - 8, x + 30, y + 8) > 60  # the head
    assert 0 < image.marks(x - 30, y - 8, x - 14, y + 8) < 40  # the tail
    for offset in (-25, 25):
        assert image.pixel(x, y + offset) == WHITE  # nothing but feet left and right
    red, green, blue = image.pixel(x - 8, y + 1)
    assert green > red + 40
    assert green > blue + 30


# --- the PNG --------------------------------------------------------------------------------------------------


def test_the_png_shows_the_svg_pixel_by_pixel_on_white() -> None:
    trace = drawn((0, 400), (300, 400), (300, 0))
    trace.move(Pose(150, 0), pen_down=False)
    text = picture.svg(trace)
    sheet, image = Sheet(text), Image(picture.png(text))
    assert (image.width, image.height) == (sheet.width, sheet.height)
    assert image.pixel(0, 0) == image.pixel(image.width - 1, image.height - 1) == WHITE
    ((start, up, right, down),) = sheet.lines("ink")
    for (x1, y1), (x2, y2) in ((start, up), (up, right), (right, down)):
        assert image.is_dark((x1 + x2) / 2, (y1 + y2) / 2)
    assert image.pixel((up[0] + right[0]) / 2, (up[1] + start[1]) / 2) == WHITE
    ((begin, end),) = sheet.lines("travel")
    shades = {image.pixel(x, begin[1]) for x in range(int(end[0]) + 40, int(begin[0]) - 10)}
    assert WHITE in shades
    assert any(shade < WHITE for shade in shades)
    assert all(min(shade) > 110 for shade in shades)


def test_100_000_points_in_10_000_strokes_are_a_matter_of_seconds() -> None:
    chance = random.Random(1)
    trace = Trace()
    pose = HOME
    for i in range(100_000):
        pose = pose.moved(5).turned(chance.uniform(-60, 60))
        trace.move(pose, pen_down=i // 10 % 2 == 0)
    began = time.process_time()
    text = picture.svg(trace)
    assert picture.png(text)
    assert time.process_time() - began < 20
    assert len(Sheet(text).lines("ink")) == 5_000


# --- the title ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("title", ["rose.logo", "a < b & c > \"d\" 'e'", "Rosë 🌹\n2nd"])
def test_the_title_is_what_a_viewer_reads(title: str) -> None:
    assert Sheet(picture.svg(Trace(), title=title)).root.findtext(f"{SVG}title") == title


def test_characters_that_xml_cannot_carry_do_not_break_the_picture(tmp_path: Path) -> None:
    title = "a\0b\x1bc\udcffd\ufffee"
    assert Sheet(picture.svg(Trace(), title=title)).root.findtext(f"{SVG}title") == "a�b�c�d�e"
    picture.save(Trace(), tmp_path / "a.svg", title=title)
    picture.save(Trace(), tmp_path / "a.png", title=title)


def test_without_a_title_there_is_none() -> None:
    assert Sheet(picture.svg(Trace())).root.find(f"{SVG}title") is None


# --- files ----------------------------------------------------------------------------------------------------


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("name", ["a.svg", "A.SVG"])
def test_save_svg(tmp_path: Path, name: str) -> None:
    trace = drawn((3, 4))
    picture.save(trace, tmp_path / name, title="Rosë")
    assert (tmp_path / name).read_text(encoding="utf-8") == picture.svg(trace, title="Rosë")


@pytest.mark.parametrize("name", ["a.png", "a.b.PNG"])
def test_save_png(tmp_path: Path, name: str) -> None:
    trace = drawn((3, 4))
    picture.save(trace, tmp_path / name)
    assert (tmp_path / name).read_bytes() == picture.png(picture.svg(trace))


@pytest.mark.parametrize(("name", "shown"), [("a.jpg", ".jpg"), ("a", ""), ("svg", ""), ("a.svg.gz", ".gz")])
def test_an_unknown_format_is_a_wrong_usage(tmp_path: Path, name: str, shown: str) -> None:
    message = f"unknown picture format '{shown}': use .svg or .png"
    for act in (picture.format_of, picture.check, lambda path: picture.save(Trace(), path)):
        with pytest.raises(UsageError, match=re.escape(message)):
            act(tmp_path / name)
    assert names(tmp_path) == []


def test_check_sees_early_what_save_would_say(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    picture.check(tmp_path / "a.svg")
    picture.check(Path("a.png"))
    with pytest.raises(OutputError, match="there is no folder there; make it first"):
        picture.check(Path("there/a.svg"))
    assert names(tmp_path) == []
    Path("there").write_text("a file")
    with pytest.raises(OutputError, match="there is no folder there"):
        picture.check(Path("there/a.svg"))


def test_an_old_picture_is_replaced_and_nothing_else_left(tmp_path: Path) -> None:
    path = tmp_path / "a.svg"
    path.write_text("old" * 10_000)
    picture.save(Trace(), path)
    assert path.read_text() == picture.svg(Trace())
    assert names(tmp_path) == ["a.svg"]


def test_a_new_picture_can_be_read_by_others(tmp_path: Path) -> None:
    before = os.umask(0o022)
    try:
        picture.save(Trace(), tmp_path / "a.svg")
    finally:
        os.umask(before)
    assert (tmp_path / "a.svg").stat().st_mode & 0o777 == 0o644


def test_a_symbolic_link_stays_one(tmp_path: Path) -> None:
    (tmp_path / "pictures").mkdir()
    link = tmp_path / "a.svg"
    link.symlink_to("pictures/b.svg")
    picture.save(Trace(), link)
    assert link.is_symlink()
    assert (tmp_path / "pictures" / "b.svg").read_text() == picture.svg(Trace())


def test_the_longest_name_that_a_folder_takes_works(tmp_path: Path) -> None:
    picture.save(Trace(), tmp_path / ("a" * 251 + ".svg"))
    with pytest.raises(OutputError, match="choose a shorter name"):
        picture.save(Trace(), tmp_path / ("a" * 252 + ".svg"))


def failure(path: Path) -> str:
    with pytest.raises(OutputError) as caught:
        picture.save(drawn((1, 1)), path)
    message = str(caught.value)
    assert message.startswith(f"cannot write the picture {path}: ")
    assert isinstance(caught.value.__cause__, OSError)
    return message.removeprefix(f"cannot write the picture {path}: ")


def test_a_full_device_is_said_and_not_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Root could really replace a device of the machine: not even a broken program may, here.
    for way in ("replace", "rename", "unlink"):
        monkeypatch.setattr(Path, way, lambda *_, **__: pytest.fail("a device is not to be replaced"))
        monkeypatch.setattr(os, way, lambda *_, **__: pytest.fail("a device is not to be replaced"))
    monkeypatch.setattr(Path, "with_name", lambda *_: pytest.fail("nothing is to be made beside a device"))
    path = tmp_path / "full.svg"
    path.symlink_to("/dev/full")
    said = failure(path)
    assert said == "No space left on device; free some space there, or choose another folder"
    assert names(tmp_path) == ["full.svg"]
    assert path.is_char_device()


@pytest.fixture
def disk_of_1000_bytes() -> Iterator[None]:
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, limits)


@pytest.mark.usefixtures("disk_of_1000_bytes")
@pytest.mark.parametrize("name", ["a.svg", "a.png"])
@pytest.mark.parametrize("old", ["the old picture", None])
def test_an_old_picture_survives_a_full_disk(tmp_path: Path, name: str, old: str | None) -> None:
    path = tmp_path / name
    if old is not None:
        path.write_text(old)
    assert failure(path) == "File too large; free some space there, or choose another folder"
    assert names(tmp_path) == ([name] if old else [])
    assert old is None or path.read_text() == old


def test_a_pipe_gets_the_picture_and_stays_a_pipe(tmp_path: Path) -> None:
    path = tmp_path / "a.svg"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    try:
        picture.save(Trace(), path)
        assert os.read(reader, 65536).decode() == picture.svg(Trace())
    finally:
        os.close(reader)
    assert path.is_fifo()
    assert names(tmp_path) == ["a.svg"]


def test_a_missing_folder(tmp_path: Path) -> None:
    said = failure(tmp_path / "there" / "a.svg")
    assert said == "No such file or directory; make the folder first, or choose one that exists"
    assert names(tmp_path) == []


def test_a_folder_that_is_a_file(tmp_path: Path) -> None:
    (tmp_path / "there").write_text("")
    said = failure(tmp_path / "there" / "a.svg")
    assert said == "Not a directory; choose a folder: a part of this path is a file"


def test_a_picture_that_is_a_folder(tmp_path: Path) -> None:
    (tmp_path / "a.svg").mkdir()
    assert failure(tmp_path / "a.svg") == "Is a directory; choose another name: this one is a folder"
    assert names(tmp_path) == ["a.svg"]


@pytest.fixture
def nobody(tmp_path: Path) -> Iterator[None]:
    """Somebody who may not write to this folder, even where the tests are run by root."""
    picture.png(picture.svg(Trace()))  # the libraries may be out of reach for nobody
    me = os.geteuid()
    tmp_path.chmod(0o555)
    if me == 0:
        os.seteuid(65534)
    yield
    if me == 0:
        os.seteuid(me)
    tmp_path.chmod(0o755)


@pytest.mark.usefixtures("nobody")
def test_a_folder_without_permission(tmp_path: Path) -> None:
    assert failure(tmp_path / "a.svg") == "Permission denied; choose a folder that you may write to"


def test_importing_costs_nothing() -> None:
    program = "import sys, turtlewire.picture; print(*(name for name in sys.modules))"
    loaded = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout.split()
    assert "turtlewire.picture" in loaded
    assert not {"drawsvg", "resvg_py", "xml", "urllib.request", "tempfile"} & set(loaded)
