"""Links in virtual time that are lost, and found again: whoever waits pumps, and everything can be repeated."""

from __future__ import annotations

import re
import subprocess
import sys
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest

import turtlewire
from tests.unit.robots.reconnecting.ports import ROBOTS
from turtlewire.configuration import defaults, target
from turtlewire.connect import connect
from turtlewire.errors import LinkClosedError, LinkLostError
from turtlewire.links.faults import FaultyLink
from turtlewire.links.link import Link
from turtlewire.links.memory import MemoryLink
from turtlewire.protocols.simple import messages as simple
from turtlewire.protocols.walter import messages as walter
from turtlewire.robots.runner import InlineRunner
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from collections.abc import Callable


PROTOCOLS = pytest.mark.parametrize("protocol", ROBOTS)


class Tap(MemoryLink):
    """A link that keeps what was sent since it was opened last."""

    def __init__(self, within: MemoryLink) -> None:
        super().__init__(within._end, within.url)
        self.sent = b""

    def write(self, data: bytes) -> None:
        super().write(data)
        self.sent += data

    def write_urgent(self, data: bytes) -> None:
        super().write_urgent(data)
        self.sent += data

    async def reopen(self) -> None:
        await super().reopen()
        self.sent = b""


class Bench:
    """A robot whose link will be lost."""

    def __init__(self, url: str) -> None:
        self.notes: list[str] = []

        def wrap(link: Link) -> Link:
            assert isinstance(link, FaultyLink)
            self.faulty = link
            assert isinstance(link._link, MemoryLink)
            self.tap = link._link = Tap(link._link)
            return link

        settings: Any = defaults(target(url).protocol)
        # In the URL of a simulated robot this is its own; one that does not boot needs no patience.
        settings = settings._replace(boot_s=2.5 if "boot_s" in url else 0.0)
        self.turtle: Any = connect(url, settings, notify=self.notes.append, wrap=wrap)
        self.robot: Any = self.tap._end

    def lose(self, drive: Callable[[Any], object]) -> str:
        """Drive until the link is lost; what people are told."""
        with pytest.raises(LinkLostError) as caught:
            drive(self.turtle)
        return str(caught.value)

    @property
    def off_mm(self) -> float:
        return float(self.turtle.pose.distance_to(*self.robot.pose[:2]))


@pytest.fixture
def bench() -> Callable[[str], Bench]:
    return Bench


def far(turtle: Any) -> None:
    turtle.forward(20000)
    turtle.finish()


@PROTOCOLS
def test_lost_and_found_again(bench: Callable[[str], Bench], protocol: str) -> None:
    made = bench(f"sim:{protocol}?faults=close:10+3&speed=100")
    turtle, robot = made.turtle, made.robot
    assert turtle.link_state == "connected"
    made.lose(far)
    assert robot.now == pytest.approx(10.0, abs=0.01)
    assert robot.is_moving
    assert turtle.link_state == "reconnecting"
    for use in (
        lambda: turtle.forward(1),
        turtle.finish,
        turtle.resume,
        lambda: turtle.wait(1),
        turtle.pen_up,
    ):
        with pytest.raises(LinkLostError, match="may be moving"):
            use()
    turtle.stop()
    assert robot.now == pytest.approx(10.0, abs=0.01)  # nobody has waited
    turtle.reconnected()
    assert turtle.link_state == "stopped"
    assert 13.0 <= robot.now < 16.0
    assert not robot.is_moving
    first = {"walter": walter.ATTENTION, "simple": simple.EMERGENCY_STOP, "frame": b"\xa3"}[protocol]
    assert made.tap.sent.startswith(first)
    stood = robot.pose
    with pytest.raises(LinkLostError, match="reached again and stopped"):
        turtle.forward(1)
    turtle.stop()
    turtle.resume()
    assert turtle.link_state == "connected"
    assert robot.pose == stood
    if protocol == "walter":  # it was asked
        assert made.off_mm <= 0.5
    else:  # it went on for three seconds and something: the turtle is in the middle
        assert made.off_mm <= 3.5 * 260.0 / 2.0
        assert made.off_mm >= 100.0
    off_mm = made.off_mm
    turtle.right(90)
    turtle.forward(100)
    turtle.finish()
    assert made.off_mm == pytest.approx(off_mm, abs=1.0)
    assert turtle.statistics.reconnections == 1
    assert made.faulty.lost == 0
    assert made.notes[0].startswith("the link to sim")
    assert "was reached again after 3." in made.notes[1]
    turtle.close()
    assert turtle.link_state == "closed"


@PROTOCOLS
def test_nothing_that_was_under_way_is_sent_again(bench: Callable[[str], Bench], protocol: str) -> None:
    made = bench(f"sim:{protocol}?faults=close:10")
    made.lose(far)
    made.turtle.reconnected()
    sent, stood = made.tap.sent, made.robot.pose
    made.turtle.resume()
    made.turtle.finish()
    RUNNER.run(made.turtle._robot.wait(20.0))
    assert made.robot.pose == stood
    assert made.tap.sent.startswith(sent)
    assert not made.robot.is_moving
    for motion in (b"F\x9c", b"F100", b"F124"):
        assert motion not in made.tap.sent


RUNNER = InlineRunner()


@PROTOCOLS
def test_everything_can_be_repeated(bench: Callable[[str], Bench], protocol: str) -> None:
    def run() -> tuple[object, ...]:
        made = bench(f"sim:{protocol}?faults=close:8+1,lose:0.02,delay:0.01,seed:4")
        turtle = made.turtle
        for _ in range(3):
            try:
                far(turtle)
            except turtlewire.TurtlewireError:
                turtle.reconnected()
                turtle.resume()
        figures = (turtle.pose, made.robot.pose, made.robot.now, turtle.statistics, made.faulty.lost)
        turtle.close(finish=False)
        return figures

    one = run()
    assert one == run()
    assert one[4]
    assert one[3].reconnections == 1  # type: ignore[attr-defined]


@PROTOCOLS
def test_faults_go_on_over_the_link_that_was_opened_again(
    bench: Callable[[str], Bench], protocol: str
) -> None:
    made = bench(f"sim:{protocol}?faults=close:2,stall:9+0.3,to:robot")
    made.lose(far)
    made.turtle.reconnected()
    made.turtle.resume()
    reopened = made.robot.now
    assert reopened < 7.0
    made.turtle.wait(9.1 - reopened)
    made.tap.sent = b""
    made.turtle.stop()
    assert made.tap.sent == b""  # the stall has begun, by the clock of the first opening
    made.turtle.wait(2.0)
    assert made.tap.sent


@PROTOCOLS
def test_it_is_given_up_in_time(bench: Callable[[str], Bench], protocol: str) -> None:
    made = bench(f"sim:{protocol}?faults=close:5+100&reconnect_s=7")
    made.lose(far)
    with pytest.raises(LinkLostError, match=r"was not reached again within 2 s, and trying goes on"):
        made.turtle.reconnected(2.0)
    assert made.robot.now == pytest.approx(7.0, abs=0.01)
    assert made.turtle.link_state == "reconnecting"
    with pytest.raises(LinkClosedError, match=r"could not be reached again within 7 s \(there is no port"):
        made.turtle.reconnected()
    assert made.robot.now == pytest.approx(12.0, abs=0.01)
    assert made.turtle.link_state == "closed"
    for use in (
        made.turtle.finish,
        made.turtle.resume,
        made.turtle.reconnected,
        lambda: made.turtle.forward(1),
    ):
        with pytest.raises(LinkClosedError, match="switch it off"):
            use()
    made.turtle.close()


@PROTOCOLS
def test_letting_go_meanwhile_makes_one_last_try(bench: Callable[[str], Bench], protocol: str) -> None:
    made = bench(f"sim:{protocol}?faults=close:5")
    made.lose(far)
    assert made.robot.is_moving
    made.turtle.close()
    assert made.robot.now < 5.5
    assert not made.robot.is_moving
    gone = bench(f"sim:{protocol}?faults=close:5+1")
    gone.lose(far)
    gone.turtle.close()
    assert gone.robot.now < 5.1  # there is no waiting for what is not there
    assert gone.robot.is_moving


@PROTOCOLS
def test_a_loss_that_is_noticed_while_letting_go_does_not_keep_the_robot_from_being_stopped(
    bench: Callable[[str], Bench], protocol: str
) -> None:
    made = bench(f"sim:{protocol}?faults=stall:9.9+0.101,close:10,to:robot")
    made.turtle.drive(1, 0)
    waiting = made.turtle._robot._session.until(lambda: False, 9.995)
    made.turtle._runner.run(waiting)
    assert made.robot.is_moving
    made.turtle.close(finish=False)  # these bytes are held back, and lost
    assert 10.0 < made.robot.now < 10.4
    assert not made.robot.is_moving


def test_a_link_that_ends_again_each_time_is_given_up_in_time(bench: Callable[[str], Bench]) -> None:
    made = bench("sim:walter?faults=close:5&reconnect_s=6")

    reopen = made.faulty.reopen

    async def shortly() -> None:
        """It has been open for a hundredth of a second each time."""
        await reopen()
        made.faulty._closes_s = made.faulty.now() + 0.01

    made.faulty.reopen = shortly  # type: ignore[method-assign]
    made.lose(far)
    with pytest.raises(LinkClosedError, match=r"within 6 s \(it ends again each time\)"):
        made.turtle.reconnected()
    assert 11.0 <= made.robot.now < 11.5
    assert len(made.notes) == 2


def test_trying_gets_slower_and_never_much_slower(bench: Callable[[str], Bench]) -> None:
    made = bench("sim:walter?faults=close:5+20")
    times: list[float] = []
    reopen = made.faulty.reopen

    async def counted() -> None:
        times.append(made.robot.now)
        await reopen()

    made.faulty.reopen = counted  # type: ignore[method-assign]
    made.lose(far)
    made.turtle.reconnected()
    assert times[0] == pytest.approx(5.0, abs=0.01)  # it may be back at once
    pauses = [after - before for before, after in pairwise(times)]
    assert pauses[:5] == pytest.approx([0.05, 0.1, 0.2, 0.4, 0.8], abs=0.001)
    assert pauses[5:] == pytest.approx([1.0] * len(pauses[5:]), abs=0.001)
    assert 25.0 <= times[-1] < 26.0
    # The next time it begins anew.
    made.turtle.resume()
    times.clear()
    made.faulty.adjust(made.faulty.faults._replace(close_at_s=made.robot.now + 1.0, gone_s=0.1))
    made.lose(far)
    made.turtle.reconnected()
    assert [after - before for before, after in pairwise(times)] == pytest.approx([0.05, 0.1], abs=0.001)
    assert made.turtle.statistics.reconnections == 2


class Once(MemoryLink):
    """A link that cannot be opened again, for all that it knows, and ends when it is asked to."""

    reopen = Link.reopen
    ended = False

    def _check(self) -> None:
        if self.ended:
            raise LinkClosedError("it has ended")
        super()._check()


def test_a_link_that_cannot_be_opened_again_is_given_up_at_once() -> None:
    links: list[Once] = []

    def wrap(link: Link) -> Link:
        assert isinstance(link, MemoryLink)
        links.append(Once(link._end, link.url))
        return links[0]

    robot: Any = connect("sim:walter", notify=lambda _: None, wrap=wrap)
    links[0].ended = True
    with pytest.raises(LinkLostError, match=r"it has ended\. The robot"):
        robot.forward(10)
    before = links[0].now()
    with pytest.raises(LinkClosedError, match="cannot be opened again"):
        robot.reconnected()
    assert links[0].now() == before
    robot.close()


def test_a_basic_walter_goes_on_by_reckoning(bench: Callable[[str], Bench]) -> None:
    made = bench("sim:walter?basic=1&faults=close:10")
    made.lose(far)
    made.turtle.reconnected()
    made.turtle.resume()
    assert made.off_mm < 10.0
    assert "by reckoning only" in made.notes[-1]
    assert made.turtle.pose.y_mm > 300.0


@pytest.mark.parametrize("groups", ["CQHE", ""])
def test_a_walter_that_was_reset_by_the_opening_is_where_it_was_last(
    bench: Callable[[str], Bench], groups: str
) -> None:
    made = bench(f"sim:walter?groups={groups}&faults=close:30&boot_s=2")
    made.turtle.right(90)
    made.turtle.forward(300)
    made.turtle.right(45)
    made.turtle.finish()
    made.lose(lambda turtle: turtle.wait(100))
    made.turtle.reconnected()
    assert made.robot.now >= 32.0
    assert made.robot.odometer == HOME
    assert made.turtle.pose == pytest.approx(Pose(300.0, 0.0, 135.0), abs=1e-6)
    made.turtle.resume()
    assert any("was reset, and no longer knows where it is" in note for note in made.notes) == bool(groups)
    made.turtle.home()
    made.turtle.finish()
    assert made.turtle.pose == HOME
    assert made.off_mm <= 1.0
    assert made.turtle.statistics.corrections == 0
    if groups:
        assert made.turtle.reported_pose() == pytest.approx(HOME, abs=0.5)


def test_a_walter_that_happens_to_be_at_its_origin_was_not_reset(bench: Callable[[str], Bench]) -> None:
    made = bench("sim:walter?faults=close:10")
    made.turtle.right(180)
    made.turtle.left(180)
    made.turtle.finish()
    made.lose(lambda turtle: turtle.wait(100))
    made.turtle.reconnected()
    made.turtle.resume()
    assert made.turtle.pose == HOME
    assert not any("reset" in note for note in made.notes)


def test_a_walter_lost_while_it_is_driven_by_hand(bench: Callable[[str], Bench]) -> None:
    made = bench("sim:walter?faults=close:10+2")
    made.turtle.drive(0.2, 0.0)
    text = made.lose(lambda turtle: turtle._runner.run(turtle._robot._wire.until(lambda: False)))
    assert re.search(r"was driven by hand, at x 0 mm, y 5\d\d mm", text)
    made.turtle.reconnected()
    assert not made.robot.is_moving
    assert made.off_mm <= 0.5
    made.turtle.resume()
    made.turtle.forward(10)
    made.turtle.finish()
    assert made.off_mm <= 0.5


@pytest.mark.parametrize("protocol", ["simple", "frame"])
def test_a_set_point_of_a_joystick_is_forgotten(bench: Callable[[str], Bench], protocol: str) -> None:
    made = bench(f"sim:{protocol}?faults=close:6+2&heartbeat_s=0.1")
    made.turtle.drive(0.5, 0.2, valid_s=50.0)
    made.lose(lambda turtle: turtle._runner.run(turtle._robot._until(lambda: False)))
    made.turtle.reconnected()
    stood = made.robot.pose
    made.turtle.resume()
    made.turtle._runner.run(made.turtle._robot._pause(60.0))
    assert made.robot.pose == stood
    assert made.robot.statistics.watchdog_stops == 0


@PROTOCOLS
def test_heartbeats_while_it_is_stopped_move_nothing(bench: Callable[[str], Bench], protocol: str) -> None:
    made = bench(f"sim:{protocol}?faults=close:6&heartbeat_s=0.1&watchdog_s=0.5")
    made.lose(far)
    made.turtle.reconnected()
    stood, session = made.robot.pose, getattr(made.turtle._robot, "_session", None)
    session = session or made.turtle._robot._wire.session
    made.tap.sent = b""
    end = made.robot.now + 5.0
    RUNNER.run(session.until(lambda: False, end))
    assert made.tap.sent
    assert made.robot.pose == stood
    made.turtle.resume()
    made.turtle.forward(10)


def test_the_pen_of_a_robot_that_was_reset_is_as_it_should_be(bench: Callable[[str], Bench]) -> None:
    for url in ("sim:walter?faults=close:10&boot_s=1", "sim:frame?pen_servo=0&faults=close:10&boot_s=1"):
        made = bench(url)
        made.turtle.pen_up()
        made.lose(far)
        made.turtle.reconnected()
        made.robot._set_pen(down=True) if "walter" in url else None
        made.turtle.resume()
        made.turtle.finish()
        assert not made.turtle.is_pen_down
        assert not made.robot.pen_is_down


def test_a_robot_that_is_reset_while_it_is_stopped_does_not_move_its_pen(
    bench: Callable[[str], Bench],
) -> None:
    made = bench("sim:frame?dialect=telemetry&pen_servo=0&faults=close:10&boot_s=0.5")
    made.turtle.pen_up()
    made.lose(far)
    made.turtle.reconnected()
    session = made.turtle._robot._session
    RUNNER.run(session.until(lambda: False, made.robot.now + 2.0))
    made.robot.port_opened()
    made.tap.sent = b""
    RUNNER.run(session.until(lambda: False, made.robot.now + 2.0))
    assert any("was reset" in note for note in made.notes)
    assert made.tap.sent == b""
    made.turtle.resume()
    assert made.tap.sent


def test_a_program_that_loses_and_finds_its_robot_needs_no_asyncio() -> None:
    program = (
        "import sys, turtlewire\n"
        "with turtlewire.connect('sim:walter?faults=close:3+1', notify=lambda _: None) as r:\n"
        "    try: r.forward(1000); r.finish()\n"
        "    except turtlewire.errors.LinkLostError: r.reconnected(); r.resume()\n"
        "    r.forward(10)\n"
        "print([n for n in ('asyncio', 'serialx') if n in sys.modules], r.statistics.reconnections)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("[] 1\n", "")
