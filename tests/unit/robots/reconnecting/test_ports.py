"""Links over real ports that are lost, and found again (section 4; S7, F13, W7; S8, W15)."""

from __future__ import annotations

import asyncio
import contextlib
import math
import os
import pty
import socket
import threading
import tty
from typing import TYPE_CHECKING, Any

import pytest

import turtlewire
from tests.unit.robots.reconnecting.ports import PATIENCE_S, PATIENT, ROBOTS, Notes, Port, open_files
from turtlewire.errors import LinkClosedError, LinkError, LinkLostError, StoppedError
from turtlewire.protocols.frame.codec import Frame, FrameDecoder, FrameEncoder
from turtlewire.protocols.frame.dialect import shipped
from turtlewire.protocols.frame.host import stop_bytes
from turtlewire.protocols.message import Malformed
from turtlewire.protocols.simple import messages as simple
from turtlewire.protocols.simple.codec import CommandDecoder as SimpleDecoder
from turtlewire.protocols.walter import messages as walter
from turtlewire.protocols.walter.codec import CommandDecoder as WalterDecoder

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from tests.unit.robots.reconnecting.conftest import MakePort

PROTOCOLS = pytest.mark.parametrize("protocol", ROBOTS)
KINDS = pytest.mark.parametrize("kind", ["pty", "socket"])
MOTIONS = (
    walter.Forward,
    walter.Back,
    walter.Left,
    walter.Right,
    walter.GoTo,
    walter.GoToX,
    walter.GoToY,
    walter.GoHome,
    walter.TurnTo,
    walter.PenDown,
    walter.PenUp,
)


def url(port: Port, protocol: str, more: str = "&boot_s=0") -> str:
    return f"{port.url}?protocol={protocol}{PATIENT[protocol]}{more}"


def begins_with_a_stop(protocol: str, heard: bytes) -> bool:
    """Whether the first thing that a robot hears stops it, whatever it is in the middle of."""
    if protocol == "walter":
        return heard.startswith(walter.EMERGENCY_STOP)  # which an attention begins with
    if protocol == "simple":
        return heard.startswith(simple.EMERGENCY_STOP)
    stop = stop_bytes(FrameEncoder(shipped("0.1")))
    # All but the sequence numbers, and the checksums of them.
    return len(heard) >= len(stop) and heard[2:9:] == stop[2:9:] and moves(protocol, heard[: len(stop)]) == []


def moves(protocol: str, heard: bytes) -> list[Any]:
    """What is there of commands that move anything."""
    if protocol == "walter":
        items = WalterDecoder().receive_data(heard)
        return [i.message for i in items if not isinstance(i, Malformed) and isinstance(i.message, MOTIONS)]
    if protocol == "simple":
        rest = heard[heard.rindex(b"SSSSSSSSSSSSSS") + 14 :].lstrip(b"S")
        rest = rest[rest.find(b"000000") + 6 :]
        commands = [i.message for i in SimpleDecoder().receive_data(rest) if not isinstance(i, Malformed)]
        return [c for c in commands if not isinstance(c, simple.Stop) and any(c.values())]
    frames = [i for i in FrameDecoder(shipped("0.1")).receive_data(heard) if isinstance(i, Frame)]
    return [m for frame in frames for m in frame.messages if m.name() != "engine_forward" or m.values()[1]]


def check_lost(robot: Any, use: Callable[[], object]) -> str:
    with pytest.raises(LinkLostError) as caught:
        use()
    assert caught.value.exit_code == 3
    return str(caught.value)


@PROTOCOLS
@KINDS
def test_lost_while_it_moves(port: MakePort, protocol: str, kind: str) -> None:
    there, notes = port(protocol, kind), Notes()
    with turtlewire.connect(url(there, protocol), notify=notes) as robot:
        assert robot.link_state == "connected"
        robot.reconnected()
        robot.resume()  # nothing to do
        there.moving.clear()

        def unplug() -> None:
            there.moving.wait(PATIENCE_S)
            there.unplug()

        unplugger = threading.Thread(target=unplug)
        unplugger.start()

        def drive() -> None:
            while True:
                robot.forward(5000)
                robot.right(90)

        text = check_lost(robot, drive)
        unplugger.join()
        assert "It may be moving until it is reached again" in text
        assert "resume()" in text
        assert "x 0 mm, y " in text
        assert robot.link_state == "reconnecting"
        robot.stop()
        check_lost(robot, lambda: robot.forward(1))
        check_lost(robot, robot.finish)
        check_lost(robot, robot.pen_up)
        check_lost(robot, robot.resume)
        check_lost(robot, lambda: robot.drive(1, 0))
        there.plug_in()
        robot.reconnected(PATIENCE_S)
        assert robot.link_state == "stopped"
        assert begins_with_a_stop(protocol, there.heard)
        assert moves(protocol, there.heard) == []
        assert not there.robot.is_moving
        text = check_lost(robot, lambda: robot.forward(1))
        assert "It was reached again and stopped" in text
        check_lost(robot, robot.clean)
        check_lost(robot, lambda: robot.drive(1, 0))
        robot.stop()
        assert moves(protocol, there.heard) == []
        robot.resume()
        assert robot.link_state == "connected"
        assert not there.robot.is_moving
        before = robot.pose
        robot.forward(30)
        robot.finish()
        assert robot.pose.distance_to(*before[:2]) == pytest.approx(30.0)
        assert moves(protocol, there.heard)
        assert robot.statistics.reconnections == 1
        if protocol == "walter":
            assert robot.reported_pose() == pytest.approx(robot.pose, abs=0.5)
    assert "Trying to reach it again, for 30 s" in notes[0]
    assert "was reached again after" in notes.wait_for("nothing goes on by itself")
    assert robot.link_state == "closed"


@PROTOCOLS
@KINDS
def test_lost_while_nobody_wants_anything(port: MakePort, protocol: str, kind: str) -> None:
    there, notes = port(protocol, kind), Notes()
    with turtlewire.connect(url(there, protocol), notify=notes) as robot:
        for count in (1, 2):
            there.unplug()
            notes.wait_for("Trying to reach it again")
            assert robot.link_state == "reconnecting"
            there.plug_in()
            robot.reconnected(PATIENCE_S)
            assert robot.link_state == "stopped"
            robot.resume()
            robot.forward(10)
            assert robot.statistics.reconnections == count
            notes.clear()


@PROTOCOLS
def test_lost_again_while_it_is_stopped(port: MakePort, protocol: str) -> None:
    there, notes = port(protocol), Notes()
    with turtlewire.connect(url(there, protocol), notify=notes) as robot:
        for _ in range(2):
            there.unplug()
            notes.wait_for("Trying to reach it again")
            there.plug_in()
            robot.reconnected(PATIENCE_S)
            notes.clear()
        assert robot.link_state == "stopped"
        check_lost(robot, lambda: robot.forward(1))
        assert moves(protocol, there.heard) == []
        robot.resume()
        robot.forward(10)
        assert robot.statistics.reconnections == 2


@PROTOCOLS
def test_lost_while_it_is_being_reached(port: MakePort, protocol: str) -> None:
    there, notes = port(protocol), Notes()
    with turtlewire.connect(url(there, protocol), notify=notes) as robot:
        there.unplug()
        with socket.create_server(there.address()) as server:
            server.settimeout(PATIENCE_S)
            for _ in range(4):
                host, _ = server.accept()
                with host:
                    host.settimeout(PATIENCE_S)
                    assert host.recv(5)
        there.plug_in()
        robot.reconnected(PATIENCE_S)
        assert moves(protocol, there.heard) == []
        if protocol != "frame":  # that one is stopped as soon as it was told so: nothing answers
            assert robot.statistics.reconnections == 1
            assert len([note for note in notes if "Trying" in note]) == 1
        robot.resume()
        robot.forward(10)


@PROTOCOLS
@KINDS
def test_never_found_again(port: MakePort, protocol: str, kind: str) -> None:
    there, notes, before = port(protocol, kind), Notes(), set(threading.enumerate())
    robot = turtlewire.connect(url(there, protocol, "&boot_s=0&reconnect_s=0.2"), notify=notes)
    there.unplug()
    notes.wait_for("Trying to reach it again")
    with pytest.raises(LinkClosedError, match=r"could not be reached again within 0\.2 s"):
        robot.reconnected()
    assert robot.link_state == "closed"
    for use in (lambda: robot.forward(1), robot.finish, robot.resume, robot.stop, robot.reconnected):
        with pytest.raises(LinkClosedError, match="If it still moves, switch it off"):
            use()
    robot.close()
    assert set(threading.enumerate()) <= before
    assert there.url not in " ".join(open_files())


@PROTOCOLS
def test_a_robot_that_is_not_reached_in_time_is_tried_further(port: MakePort, protocol: str) -> None:
    there, notes = port(protocol), Notes()
    with turtlewire.connect(url(there, protocol), notify=notes) as robot:
        there.unplug()
        notes.wait_for("Trying to reach it again")
        with pytest.raises(LinkLostError, match="was not reached again within 0 s"):
            robot.reconnected(0.0)
        there.plug_in()
        robot.reconnected(PATIENCE_S)
        robot.resume()
        robot.forward(10)


@KINDS
def test_a_port_that_is_still_open_is_let_go_of_before_it_is_opened_again(port: MakePort, kind: str) -> None:
    there = port("walter", kind)
    with turtlewire.connect(url(there, "walter", "&boot_s=0&faults=close:0.3"), notify=Notes()) as robot:
        check_lost(robot, lambda: robot.wait(1e6))
        robot.reconnected(PATIENCE_S)
        robot.resume()
        robot.forward(10)
        robot.finish()
        assert robot.reported_pose().y_mm == 10.0


def test_reconnecting_can_be_switched_off(port: MakePort) -> None:
    there = port("walter")
    robot = turtlewire.connect(url(there, "walter", "&reconnect_s=0"))
    there.unplug()
    with pytest.raises(LinkClosedError, match="ended"):
        robot.wait(1e6)
    assert robot.link_state == "closed"
    assert robot.statistics.reconnections == 0
    robot.close()


class Deaf:
    """A port that is there, and at which nothing answers."""

    def __init__(self, device: Path) -> None:
        self.near, self.far = pty.openpty()
        tty.setraw(self.far)
        device.symlink_to(os.ttyname(self.far))
        self.heard = b""
        self._thread = threading.Thread(target=self._listen)
        self._thread.start()

    def _listen(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                self.heard += os.read(self.near, 4096)

    def close(self) -> None:
        os.write(self.far, b"")
        os.close(self.far)
        self._thread.join(PATIENCE_S)
        os.close(self.near)


@pytest.fixture
def deaf() -> Iterator[Callable[[Path], Deaf]]:
    made: list[Deaf] = []

    def make(device: Path) -> Deaf:
        made.append(Deaf(device))
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.mark.parametrize("protocol", ["walter", "simple"])
def test_what_comes_back_dead_is_given_up(
    port: MakePort, deaf: Callable[[Path], Deaf], protocol: str
) -> None:
    there, notes = port(protocol, "pty"), Notes()
    quick = "&boot_s=0&reconnect_s=0.3&" + ("reply_timeout_s=0.1" if protocol == "walter" else "retries=0")
    robot = turtlewire.connect(f"{there.url}?protocol={protocol}{quick}", notify=notes)
    there.unplug()
    notes.wait_for("Trying to reach it again")
    dead = deaf(there._device)
    with pytest.raises(LinkClosedError, match="does not answer"):
        robot.reconnected()
    while len([file for file in open_files() if os.ttyname(dead.far) in file]) > 1:
        assert robot.link_state == "closed"  # and its port is let go of
    robot.close()
    assert begins_with_a_stop(protocol, dead.heard)


def test_a_robot_that_never_answers_is_stopped_all_the_same(
    port: MakePort, deaf: Callable[[Path], Deaf]
) -> None:
    there, notes = port("frame", "pty"), Notes()
    with turtlewire.connect(url(there, "frame"), notify=notes) as robot:
        there.unplug()
        notes.wait_for("Trying to reach it again")
        dead = deaf(there._device)
        robot.reconnected(PATIENCE_S)
        assert robot.link_state == "stopped"
        assert begins_with_a_stop("frame", dead.heard)
        robot.resume()
        robot.forward(1)


@PROTOCOLS
def test_a_robot_that_was_reset_is_waited_for(port: MakePort, protocol: str) -> None:
    there, notes = port(protocol, "pty", boot_s=15.0), Notes()  # of the robot's time
    boots = "&boot_s=1" if protocol == "frame" else "&boot_s=20"  # that one does not tell when it hears again
    patient = url(there, protocol, boots).replace("timeout_s=20", "timeout_s=0.2")
    with turtlewire.connect(patient, notify=notes) as robot:
        robot.forward(20)
        robot.finish()
        there.unplug()
        notes.wait_for("Trying to reach it again")
        there.robot.port_opened()
        there.plug_in()
        robot.reconnected(PATIENCE_S)
        assert there.robot.now >= there.robot._booted_s
        assert moves(protocol, there.heard) == []
        robot.resume()
        robot.forward(20)
        robot.finish()
        assert robot.pose.y_mm == pytest.approx(
            40.0, abs=15.0
        )  # by the clock on the wall: a busy machine is late
    assert (protocol == "walter") == any("was reset" in note for note in notes)


# ---------------------------------------------------------------- stopping and letting go meanwhile


@PROTOCOLS
def test_a_stop_from_another_thread_while_nothing_can_be_reached(port: MakePort, protocol: str) -> None:
    there, notes = port(protocol), Notes()
    with turtlewire.connect(url(there, protocol), notify=notes) as robot:
        there.unplug()
        notes.wait_for("Trying to reach it again")
        waiting = threading.Thread(target=robot.reconnected)
        waiting.start()
        for _ in range(20):
            stopper = threading.Thread(target=robot.stop)
            stopper.start()
            stopper.join(PATIENCE_S)
        there.plug_in()
        while waiting.is_alive():
            robot.stop()
        assert robot.link_state == "stopped"
        assert moves(protocol, there.heard) == []
        robot.resume()
        robot.forward(10)


@PROTOCOLS
@KINDS
def test_letting_go_meanwhile_stops_the_robot_if_that_is_possible(
    port: MakePort, protocol: str, kind: str
) -> None:
    there, notes = port(protocol, kind), Notes()
    files = open_files()
    robot = turtlewire.connect(url(there, protocol, "&boot_s=0&speed=255"), notify=notes)
    robot.drive(1, 0)
    there.moving.wait(PATIENCE_S)
    there.unplug()
    notes.wait_for("Trying to reach it again")
    there.plug_in()
    robot.close(finish=False)
    while there.robot.is_moving:
        assert robot.link_state == "closed"
    assert begins_with_a_stop(protocol, there.heard)
    assert moves(protocol, there.heard) == []
    assert {f for f in open_files() - files if "ttyROBOT" in f} == set()


@PROTOCOLS
def test_letting_go_of_what_cannot_be_reached_is_prompt(port: MakePort, protocol: str) -> None:
    there, notes = port(protocol), Notes()
    threads = set(threading.enumerate())
    robot = turtlewire.connect(url(there, protocol, "&boot_s=0&reconnect_s=100000"), notify=notes)
    there.unplug()
    notes.wait_for("Trying to reach it again")
    waiting: list[LinkError] = []

    def wait() -> None:
        try:
            robot.reconnected()
        except LinkError as error:
            waiting.append(error)

    waiter = threading.Thread(target=wait)
    waiter.start()
    robot.close(finish=False)
    waiter.join(PATIENCE_S)
    assert isinstance(waiting[0], LinkClosedError)
    assert robot.link_state == "closed"
    assert set(threading.enumerate()) <= threads


@PROTOCOLS
def test_a_loss_that_nobody_was_told_of_is_told_when_the_robot_is_let_go(
    port: MakePort, protocol: str
) -> None:
    there, notes = port(protocol), Notes()
    robot = turtlewire.connect(url(there, protocol), notify=notes)
    there.unplug()
    notes.wait_for("Trying to reach it again")
    with pytest.raises(LinkLostError):
        robot.close()
    robot.close()
    assert robot.link_state == "closed"


def test_tasks_that_are_cancelled_meanwhile_leave_nothing_behind(port: MakePort) -> None:
    there = port("walter", "pty")

    async def main() -> None:
        lost = asyncio.Event()
        robot = await turtlewire.connect_async(url(there, "walter"), notify=lambda _: lost.set())
        motion = asyncio.create_task(robot.wait(1e6))
        await asyncio.to_thread(there.unplug)
        await lost.wait()
        with contextlib.suppress(LinkLostError):
            await motion
        waiting = [asyncio.create_task(robot.reconnected()) for _ in range(3)]
        await asyncio.sleep(0)
        for task in waiting:
            task.cancel()
        assert {type(e) for e in await asyncio.gather(*waiting, return_exceptions=True)} == {
            asyncio.CancelledError
        }
        assert robot.link_state == "reconnecting"
        closing = asyncio.create_task(robot.close())
        await closing
        assert asyncio.all_tasks() == {asyncio.current_task()}

    before = open_files()
    asyncio.run(main())
    assert {f for f in open_files() - before if "pts" in f} == set()


def test_a_program_that_ends_meanwhile_leaves_nothing_behind(port: MakePort) -> None:
    there = port("walter", "pty")

    async def main() -> None:
        lost = asyncio.Event()
        await turtlewire.connect_async(url(there, "walter"), notify=lambda _: lost.set())
        await asyncio.to_thread(there.unplug)
        await lost.wait()

    asyncio.run(main())  # which cancels what is left


@PROTOCOLS
def test_all_who_wait_are_told(port: MakePort, protocol: str) -> None:
    there = port(protocol)
    robot = turtlewire.connect(url(there, protocol), notify=Notes())
    errors: list[BaseException] = []

    def wait() -> None:
        try:
            robot.wait(1e6)
        except LinkError as error:
            errors.append(error)

    waiting = [threading.Thread(target=wait) for _ in range(3)]
    for thread in waiting:
        thread.start()
    there.unplug()
    for thread in waiting:
        thread.join(PATIENCE_S)
    assert [type(error) for error in errors] == [LinkLostError] * 3
    assert len({id(error) for error in errors}) == 3
    robot.close()
    assert math.isfinite(robot.pose.x_mm)
    with pytest.raises((LinkClosedError, StoppedError)):
        robot.forward(1)
