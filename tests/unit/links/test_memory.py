"""The link in virtual time."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import LinkClosedError
from turtlewire.links.memory import MemoryLink
from turtlewire.robots.runner import InlineRunner
from turtlewire.simulator.car import SimulatedCar
from turtlewire.simulator.walter import Settings, SimulatedWalter

if TYPE_CHECKING:
    from turtlewire.links.link import Link


def read(link: Link, until: float) -> bytes:
    return InlineRunner().run(link.read(until))


def test_time_passes_only_while_somebody_reads() -> None:
    link = MemoryLink(SimulatedWalter(), "sim:walter")
    assert (link.url, link.in_background, link.now()) == ("sim:walter", False, 0.0)
    link.write(b"QX\r")
    link.wake()
    assert link.now() == 0.0
    assert read(link, 1.0) == b"Q"
    assert 0.0 < link.now() < 0.01
    assert b"".join(read(link, 1.0) for _ in range(4)) == b"X\x00\x00\r"
    assert (read(link, 1.0), link.now()) == (b"", 1.0)


def test_an_urgent_write_takes_back_what_has_not_gone_out() -> None:
    robot = SimulatedWalter()
    link = MemoryLink(robot)
    link.write(bytes(30))
    link.write_urgent(b"\r")
    assert robot.bytes_on_line == 2


@pytest.mark.parametrize("pace", [None, 1.0, 1000.0])
def test_waiting_for_what_never_happens_is_an_error(
    pace: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    wall = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: wall[0])
    monkeypatch.setattr(time, "sleep", lambda seconds: wall.__setitem__(0, wall[0] + seconds))
    link = MemoryLink(SimulatedWalter(), pace=pace)
    with pytest.raises(RuntimeError, match="never happen"):
        read(link, math.inf)
    # What does happen may be waited for without end; then there is nothing more.
    link.write(b"F\x01\x00\rQX\r")
    assert b"".join(read(link, math.inf) for _ in range(5)) == b"QX\x00\x00\r"
    link.write(b"F\x01\x00\r")
    assert read(link, math.inf) == b""
    assert link.now() > 2.0
    with pytest.raises(RuntimeError, match="never happen"):
        read(link, math.inf)


def test_a_robot_that_only_drives_on_is_waited_for_no_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: wall[0])
    monkeypatch.setattr(time, "sleep", lambda seconds: wall.__setitem__(0, wall[0] + seconds))
    for pace in (None, 2.0):
        car = SimulatedCar()
        link = MemoryLink(car, pace=pace)
        link.write(b"F200000")
        assert read(link, math.inf) == b"K"
        with pytest.raises(RuntimeError, match="never happen"):
            read(link, math.inf)
        assert car.is_moving


def test_use_after_close() -> None:
    link = MemoryLink(SimulatedWalter())
    InlineRunner().run(link.close())
    with pytest.raises(LinkClosedError):
        link.write(b"x")
    with pytest.raises(LinkClosedError):
        link.write_urgent(b"x")
    with pytest.raises(LinkClosedError):
        read(link, 1.0)


def test_a_pace_keeps_the_robot_s_time_to_the_wall_s(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: wall[0])
    monkeypatch.setattr(time, "sleep", lambda seconds: wall.__setitem__(0, wall[0] + seconds))
    link = MemoryLink(SimulatedWalter(Settings(baud=None)), pace=4.0)
    assert read(link, 10.0) == b""
    assert link.now() == 10.0
    assert wall[0] == pytest.approx(102.5, abs=0.001)
    link.write(b"QX\r")
    assert read(link, 20.0) == b"QX\x00\x00\r"
    assert wall[0] == pytest.approx(102.5, abs=0.001)


def test_a_link_that_is_opened_again_is_to_the_same_robot_and_hears_nothing_of_before() -> None:
    robot, runner = SimulatedWalter(), InlineRunner()
    link = MemoryLink(robot)
    link.write(b"F\x01\x00\rQX\r")
    runner.run(link.close())
    runner.run(link.sleep(5.0))
    assert link.now() == 5.0
    with pytest.raises(LinkClosedError):
        link.write(b"x")
    runner.run(link.reopen())
    assert robot.pose.y_mm == 128.0
    assert read(link, 6.0) == b""
    link.write(b"QY\r")
    assert b"".join(read(link, 7.0) for _ in range(5)) == b"QY\x01\x00\r"


def test_a_robot_that_takes_time_to_boot_is_reset_by_the_opening() -> None:
    robot, runner = SimulatedWalter(Settings(boot_s=1.0)), InlineRunner()
    link = MemoryLink(robot)
    assert read(link, 2.0) == b""
    link.write(b"V\x14\rF\x01\x00\r")
    assert read(link, 3.0) == b""
    moves = [robot.is_moving]
    runner.run(link.close())
    runner.run(link.reopen())
    assert [*moves, robot.is_moving] == [True, False]
    assert robot.speed == Settings().speed
    assert robot.odometer.y_mm == 0.0
    stood = robot.pose
    assert stood.y_mm > 0.0
    link.write(b"F\x01\x00\r")  # it hears nothing yet
    assert read(link, 5.0) == b""
    assert robot.pose == stood
