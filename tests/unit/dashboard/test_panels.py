"""What each part of the dashboard says."""

from __future__ import annotations

from turtlewire.dashboard import panels
from turtlewire.dashboard.canvas import Cell
from turtlewire.dashboard.controls import Controls
from turtlewire.dashboard.layouts import layout
from turtlewire.helm.view import Notice, View
from turtlewire.helm.wire import Line
from turtlewire.helm.wishes import Wish
from turtlewire.turtle import Pose


def controls(protocol: str) -> Controls:
    return Controls(layout(protocol), speed=100, has_full_lock=False, first_s=0.7, hold_s=0.25)


def side(
    view: View, protocol: str = "frame", wish: Wish | None = None, *, latched: bool = False
) -> list[str]:
    text = panels.side(view, controls(protocol), wish or Wish(), latched=latched)
    return text.plain.splitlines()


def test_the_first_line_fits_and_says_how_the_link_is() -> None:
    for link, said in (("connected", "● connected"), ("reconnecting", "LINK LOST"), ("closed", "NO LINK")):
        line = panels.head("WALTER at /dev/ttyUSB0", View(link=link), 80).plain
        assert len(line) == 80
        assert line.startswith(" WALTER at /dev/ttyUSB0 ")
        assert said in line
    assert len(panels.head("WALTER at /dev/ttyUSB0", View(), 16).plain) <= 16
    assert set(panels.BANNERS) == set(panels.LINKS) - {"connected"}


def test_the_robot() -> None:
    view = View(
        pose=Pose(-0.01, 12.34, 359.99),
        certainty="reckoned",
        speed_mm_per_s=99.6,
        turn_deg_per_s=-0.01,
        pen_down=True,
        lamp=False,
    )
    assert side(view) == [
        "keys     ■ stop",
        "x             0.0 mm",
        "y            12.3 mm",
        "heading     360.0 deg",
        "speed         100 mm/s",
        "turning         0 deg/s",
        "by reckoning",
        "set      ▮▮▮▮▯▯▯▯▯ 100",
        "pen      down",
        "lights   off",
    ]
    assert "pen" not in "".join(side(View()))
    assert side(View(certainty="told"))[6] == "as it says"
    assert side(View(certainty="seen"))[6].startswith("set")
    assert side(View(), "walter")[7] == "set      100, of turns 100"
    assert "pen      up" in side(View(pen_down=False))
    assert "lights   on" in side(View(lamp=True))


def test_what_is_wished() -> None:
    for wish, said in (
        (Wish(0.5, 0.0), "▲ ahead"),
        (Wish(-0.5, 0.0), "▼ back"),
        (Wish(0.5, -0.1), "▲ ahead ◀ left"),
        (Wish(0.0, 0.1, horn=True), "▶ right ♪"),
        (Wish(), "■ stop"),
    ):
        assert side(View(), wish=wish)[0] == f"keys     {said}"
    assert side(View(), wish=Wish(0.5), latched=True)[0].endswith("▲ ahead (latched)")
    assert side(View(), latched=True)[0].endswith("■ stop")


def test_the_link() -> None:
    figures = {"bytes_sent": 120, "bytes_received": 17, "resynchronisations": 3, "corrections": 3}
    trips = {"round_trip_median_s": 0.0123, "round_trip_max_s": 0.0456, "retries": 0}
    always = ["sent     120 bytes", "received 17 bytes"]

    def noted(**more: object) -> list[str]:
        lines = side(View(figures={**figures, **more}))
        return lines[lines.index(always[0]) :]

    assert noted(window_commands=1, **trips) == [*always, "answers  12 ms, at most 46", "noted    2 resyncs"]
    assert noted(fences=9, fences_lost=1, round_trip_median_s=None, round_trip_max_s=None) == [
        *always,
        "noted    1 answers lost",
        "noted    3 corrections",
    ]
    assert noted(frames_lost=2, repeats=7) == [*always, "noted    3 resyncs", "noted    2 frames lost"]
    assert noted(fences=1, corrections=0, retries=4, reconnections=1) == [
        *always,
        "noted    4 retries",
        "noted    1 link losses",
    ]


def test_messages() -> None:
    lines = [Line(n + 0.5, "host", f"key_{n}", 1, n + 0.5, "") for n in range(20)]
    lines += [Line(21.0, "robot", "accepted", 7, 22.0, ""), Line(23.0, "robot", "error: what?", 1, 23.0, "")]
    text = panels.wire(lines, 3)
    assert text.plain.splitlines() == [
        "   19.500 → key_19",
        "   21.000 ← accepted x7",
        "   23.000 ← error: what?",
    ]
    assert "red" in [span.style for span in text.spans]
    assert panels.wire(lines, 0).plain == ""


def test_notices_the_newest_first_and_new_ones_stand_out() -> None:
    one = controls("walter")
    given = [
        Notice(1.0, "note", "hello"),
        Notice(2.0, "warning", "look out"),
        Notice(3.0, "error", "too late"),
    ]
    text = panels.notices(given, one, 4.0)
    assert text.plain.splitlines() == ["!! too late", "! look out", "hello"]
    assert [span.style for span in text.spans] == ["bold red", "dim", "dim"]
    assert panels.notices(given, one, 30.0).spans[0].style == "dim"
    one.press("g", 0.0)
    one.press("7", 0.0)
    assert panels.notices(given, one, 4.0).plain.startswith("speed, 1 to 255: 7_")
    one.press("b", 0.0)
    assert panels.notices(given, one, 4.0).plain.startswith("speed of turns, 1 to 255: _")


def test_keys_of_what_the_robot_has() -> None:
    def told(protocol: str, *features: str, latched: bool = False, width: int = 300) -> str:
        return panels.keys(layout(protocol), frozenset(features), width, latched=latched).plain

    assert told("simple", "lamp") == (
        "W A S D or arrows hold to drive  Space stop  1-9 + - speed  L lights  Q quit"
    )
    assert "P pen  " in told("frame", "pen", "horn")
    assert "H horn  " in told("frame", "pen", "horn")
    lines = told("walter", "lamp", "horn", "pen", width=78).splitlines()
    assert [len(line.rstrip()) <= 78 for line in lines] == [True, True]
    assert lines[1].startswith("F V of turns  ")
    assert told("walter", latched=True).startswith(
        "A Z , . or arrows drive until Space  Space stop  S X pen up"
    )


def test_the_ground_in_colours() -> None:
    text = panels.ground([[Cell("⠁", 3), Cell(" ", 0)], [Cell("↑", 5), Cell("x", 9)]])
    assert text.plain == "⠁ \n↑x"
    assert [(span.start, span.style) for span in text.spans] == [(0, "cyan"), (3, "bold green")]
