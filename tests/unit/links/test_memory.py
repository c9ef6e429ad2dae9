"""The link in virtual time."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import LinkClosedError
from turtlewire.links.memory import MemoryLink
from turtlewire.robots.runner import InlineRunner
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


def test_waiting_for_what_never_happens_is_an_error() -> None:
    link = MemoryLink(SimulatedWalter())
    with pytest.raises(RuntimeError, match="never happen"):
        read(link, math.inf)


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
