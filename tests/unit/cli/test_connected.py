"""Robots that are stopped together: in which order what goes out on their wires."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from turtlewire.cli.connected import Connected
from turtlewire.configuration import target
from turtlewire.errors import LinkClosedError, LinkError
from turtlewire.links.faults import Faults, FaultyLink

if TYPE_CHECKING:
    from turtlewire.links.link import Link

ROBOTS = {"elsie": "sim:walter", "herbie": "sim:simple", "dot": "sim:frame"}


class Heard(FaultyLink):
    """A link that notes whose stops go out, and whose link is closed."""

    def __init__(self, link: Link, name: str, log: list[str]) -> None:
        super().__init__(link, Faults.parse(""))
        self._name = name
        self._log = log

    def write_urgent(self, data: bytes) -> None:
        self._log.append(f"{self._name} is stopped")
        super().write_urgent(data)

    async def close(self) -> None:
        self._log.append(f"{self._name} is let go")
        await super().close()


def connected(log: list[str], **more: str) -> Connected:
    targets = {name: target(url) for name, url in {**ROBOTS, **more}.items()}
    robots = Connected(targets, lambda *_: None, print, lambda name, link: Heard(link, name, log))
    log.clear()
    return robots


def test_all_are_stopped_before_any_of_them_is_let_go() -> None:
    log: list[str] = []
    robots = connected(log)
    for robot in robots.robots.values():
        robot.forward(100)
    robots.close()
    assert sorted(log[:3]) == ["dot is stopped", "elsie is stopped", "herbie is stopped"]
    assert [line for line in log if "let go" in line] == [f"{name} is let go" for name in ROBOTS]
    assert all(robot.link_state == "closed" for robot in robots.robots.values())


def test_a_stop_is_for_all_and_ends_nothing() -> None:
    log: list[str] = []
    robots = connected(log)
    robots.stop()
    assert log == [f"{name} is stopped" for name in ROBOTS]
    for robot in robots.robots.values():
        robot.forward(10)
        robot.finish()
        assert robot.pose.y_mm == pytest.approx(10.0)
    robots.close()


def test_one_that_cannot_be_stopped_keeps_no_other_from_it() -> None:
    log: list[str] = []
    robots = connected(log, herbie="sim:simple?faults=close:5&reconnect_s=0")
    assert robots.lost == []
    with pytest.raises(LinkClosedError):
        robots.robots["herbie"].forward(5000)
    assert robots.lost == ["herbie"]
    robots.reach()  # in vain
    log.clear()
    robots.stop()
    assert log == [f"{name} is stopped" for name in ROBOTS]  # herbie's does not get through
    robots.close()
    assert all(robot.link_state == "closed" for robot in robots.robots.values())


def test_those_before_one_that_is_not_there_are_stopped(capsys: pytest.CaptureFixture[str]) -> None:
    log: list[str] = []
    targets = {
        name: target(url) for name, url in {"elsie": "sim:walter", "gone": "/dev/no-such-port"}.items()
    }
    with pytest.raises(LinkError, match="/dev/no-such-port"):
        Connected(targets, lambda *_: None, print, lambda name, link: Heard(link, name, log))
    assert log[-2:] == ["elsie is stopped", "elsie is let go"]
    assert capsys.readouterr().out == ""
