"""The helm, at a simulated robot in real time: what is wished, carried out, and ended by whatever ends it."""

from __future__ import annotations

import math
import threading
import time
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.configuration import target
from turtlewire.errors import LinkClosedError, NoReplyError
from turtlewire.helm import notices
from turtlewire.helm.helm import Helm
from turtlewire.helm.wishes import Action, Order, Wish
from turtlewire.links.memory import MemoryLink

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from turtlewire.turtle import Pose

DEADLINE_S = 30.0
ROBOTS = ("sim:walter", "sim:simple", "sim:frame")


def wait_until(condition: Callable[[], bool], what: str = "it") -> None:
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.002)


class Bench:
    """A helm at work, and the robot that it drives."""

    def __init__(self, url: str, pace: float) -> None:
        robot = target(url)
        robot = robot._replace(overrides={"boot_s": 0.1, **robot.overrides})
        self.helm = Helm(robot, pace=pace, announce=print)
        self.helm.connect()
        link: Any = self.helm._sight._link
        while not isinstance(link, MemoryLink):
            link = link._link
        self.robot: Any = link._end
        self._number = 0
        self._wish: Wish | None = None
        self._over = threading.Event()
        self._renewing = threading.Thread(target=self._renew)
        self._renewing.start()

    def wish(self, speed: float = 0.0, turn: float = 0.0, *, horn: bool = False) -> Wish:
        """Hold a key, pressed anew: the wish is renewed, as a dashboard does that is alive."""
        self._number += 1
        self._wish = Wish(speed, turn, horn, time.monotonic() + 60.0, self._number)
        self.helm.steer(self._wish)
        return self._wish

    def wish_once(self, speed: float, seconds: float) -> None:
        """Wish for this, and hang."""
        self._number += 1
        self.helm.steer(Wish(speed, until=time.monotonic() + seconds, number=self._number))

    def let_go(self) -> None:
        """Wish for nothing more."""
        self._wish = None
        self.helm.steer(Wish(number=self._number))

    def _renew(self) -> None:
        while not self._over.wait(0.05):
            wish = self._wish
            if wish is not None:
                self.helm.steer(wish._replace(until=time.monotonic() + 60.0))

    def close(self) -> None:
        self._over.set()
        self._renewing.join()
        self.helm.close()

    @property
    def pose(self) -> Pose:
        return self.helm.view.pose

    def wait_until_moving(self) -> None:
        wait_until(lambda: bool(self.robot.is_moving), "motion")

    def wait_until_standing(self) -> None:
        wait_until(lambda: not self.robot.is_moving, "a stop")

    def notices(self) -> str:
        return "\n".join(notice.text for notice in self.helm.view.notices)

    def said(self) -> list[str]:
        return [line.text for line in self.helm.view.lines]

    def times(self, text: str) -> int:
        """How often it was said."""
        return sum(line.times for line in self.helm._sight._messages.lines() if line.text == text)


@pytest.fixture
def bench() -> Iterator[Callable[..., Bench]]:
    benches: list[Bench] = []

    def make(url: str = "sim:walter", *, pace: float = 1.0) -> Bench:
        benches.append(Bench(url, pace))
        return benches[-1]

    yield make
    for each in benches:
        each.close()


@pytest.mark.parametrize("url", ROBOTS)
def test_a_wish_is_carried_out_and_ended(bench: Callable[..., Bench], url: str) -> None:
    made = bench(url)
    made.wish(0.5)
    made.wait_until_moving()
    wait_until(lambda: made.pose.y_mm > 10.0 and made.helm.view.speed_mm_per_s > 1.0)
    made.let_go()
    made.wait_until_standing()
    wait_until(lambda: made.helm.view.speed_mm_per_s == 0.0)
    assert made.helm.view.certainty == "seen"
    assert made.helm.view.distance_mm == pytest.approx(made.pose.y_mm, abs=3.0)
    assert made.pose == pytest.approx(made.robot.pose, abs=1.0)


@pytest.mark.parametrize("url", ROBOTS)
def test_a_wish_that_nobody_renews_ends(bench: Callable[..., Bench], url: str) -> None:
    """The dashboard hangs: the helm's own thread ends it."""
    made = bench(url)
    made.wish_once(0.5, 0.3)
    made.wait_until_moving()
    made.wait_until_standing()
    if url == "sim:walter":  # gently, before the driver stops it by force
        wait_until(lambda: "stop" in made.said())


def test_who_drives_on_at_once_is_not_stopped_by_the_stop_before(bench: Callable[..., Bench]) -> None:
    made = bench()
    made.wish(0.5)
    made.wait_until_moving()
    stops = made.times("emergency stop")
    for _ in range(5):
        made.let_go()
        made.wait_until_standing()
        made.wish(-0.5)
        made.wait_until_moving()
    before = made.pose.y_mm
    wait_until(lambda: made.pose.y_mm < before - 60.0)
    assert made.times("emergency stop") == stops


def test_one_that_is_latched_has_to_be_renewed_too(bench: Callable[..., Bench]) -> None:
    made = bench()
    made.wish_once(0.5, math.inf)
    made.wait_until_moving()
    made.wait_until_standing()  # by the time to live of its set-point
    assert "emergency stop" in made.said()


@pytest.mark.parametrize("url", ROBOTS)
def test_a_stop_overtakes_and_its_key_begins_nothing_more(bench: Callable[..., Bench], url: str) -> None:
    made = bench(url)
    wish = made.wish(0.5)
    made.wait_until_moving()
    made.helm.stop()
    made.wait_until_standing()
    assert made.helm.refused == wish.number
    seen = made.helm.view  # and the key is held still
    made.helm.do(Order(Action.LAMP))
    wait_until(lambda: made.helm.view.lamp is not ("lamp" not in made.helm.features))
    assert not made.robot.is_moving
    assert made.pose.distance_to(seen.pose.x_mm, seen.pose.y_mm) < 20.0
    made.wish(-0.5)
    made.wait_until_moving()


def test_a_stop_ends_nothing_that_comes_after_it(bench: Callable[..., Bench]) -> None:
    made = bench()
    made.wish(0.5)
    made.wait_until_moving()
    busy = threading.Event()
    made.helm._soon(lambda: busy.wait(DEADLINE_S))  # so that all of it is there when its turn comes
    made.helm.stop()
    made.helm.do(Order(Action.RAISE_PEN))
    wish = made.wish(-0.5)
    busy.set()
    wait_until(lambda: not made.robot.pen_is_down, "the pen")
    wait_until(lambda: made.helm.view.speed_mm_per_s < 0.0, "the wish after the stop")
    assert made.helm.refused < wish.number


@pytest.mark.parametrize("url", ROBOTS)
def test_the_way_out_stops_it_and_silences_it(bench: Callable[..., Bench], url: str) -> None:
    made = bench("sim:frame?dialect=telemetry" if url == "sim:frame" else url)
    made.wish(0.5)
    made.wait_until_moving()
    made.helm.close()
    link = made.robot
    link.read(link.now + 0.3)
    assert not made.robot.is_moving
    made.helm.steer(Wish(1.0, until=math.inf, number=99))  # nobody is there any more
    made.helm.stop()
    made.helm.stop_and_wait(1.0)
    made.helm.close()


def test_the_horn_sounds_while_it_is_wished_and_not_after_the_end(bench: Callable[..., Bench]) -> None:
    made = bench()
    made.wish(horn=True)
    wait_until(lambda: made.robot.horn == "low")
    wait_until(lambda: made.helm.view.horn)
    made.let_go()
    wait_until(lambda: made.robot.horn == "off")
    made.wish(horn=True)
    wait_until(lambda: made.robot.horn == "low")
    made.helm.close()
    assert made.robot.horn == "off"


def test_walter_stops_for_its_lamp_and_goes_on_with_the_next_key(bench: Callable[..., Bench]) -> None:
    made = bench()
    wish = made.wish(0.5)
    made.wait_until_moving()
    made.helm.do(Order(Action.LAMP))
    wait_until(lambda: bool(made.robot.lamp))
    wait_until(lambda: made.helm.view.lamp is True)
    assert not made.robot.is_moving
    assert made.helm.refused == wish.number
    made.helm.do(Order(Action.LAMP))
    wait_until(lambda: not made.robot.lamp)
    made.wish(0.5)
    made.wait_until_moving()


def test_walter_s_keys(bench: Callable[..., Bench]) -> None:
    made = bench()
    made.helm.do(Order(Action.MOVE_FASTER, 101))  # it stands: that is said with the next motion
    made.helm.do(Order(Action.RAISE_PEN))
    wait_until(lambda: not made.robot.pen_is_down)
    made.wish(100 / 255)
    made.wait_until_moving()
    assert "move_faster" not in made.said()
    made.helm.do(Order(Action.MOVE_FASTER, 101))
    wait_until(lambda: made.robot.speed == 101)
    made.helm.do(Order(Action.LOWER_PEN))
    wait_until(lambda: bool(made.robot.pen_is_down))
    assert made.robot.is_moving
    assert made.said().count("start_forward") == 1
    made.helm.do(Order(Action.TURN_SLOWER, 99))
    wait_until(lambda: made.robot.turn_speed == 99)
    wait_until(lambda: made.helm.view.pen_down is True)


def test_a_walter_that_stands_is_asked_where_it_is(bench: Callable[..., Bench]) -> None:
    made = bench(pace=5.0)
    made.helm._sight._is_seen = False  # as a real one
    made.wish(0.5)
    made.wait_until_moving()
    wait_until(lambda: made.helm.view.certainty == "reckoned" and made.pose.y_mm > 50.0)
    made.let_go()
    wait_until(lambda: made.helm.view.certainty == "told", "its answer")
    assert made.pose.y_mm == pytest.approx(made.robot.pose.y_mm, abs=1.0)
    assert made.helm.view.figures["round_trip_median_s"] > 0.0
    # Somebody who drives on meanwhile does not wait for its answers.
    for _ in range(20):
        made.wish(0.5)
        made.wait_until_moving()
        made.let_go()
        made.wait_until_standing()
    assert not made.notices()
    made.wait_until_standing()
    made.helm._checked_s = -math.inf  # it is asked now
    wait_until(lambda: made.helm._asking is not None and not made.helm._asking.done())
    made.wish(-0.5)
    made.wait_until_moving()


def test_the_pen_of_two_engines_and_what_others_lack(bench: Callable[..., Bench]) -> None:
    made = bench("sim:frame")
    made.wish(0.5)
    made.wait_until_moving()
    made.helm.do(Order(Action.PEN))
    wait_until(lambda: made.helm.view.pen_down is False)
    made.wait_until_moving()  # the wheels stand while the pen moves, and go on
    made.helm.do(Order(Action.LAMP))
    wait_until(lambda: "this robot has no lights" in made.notices())
    made.helm.do(Order(Action.RAISE_PEN))  # a key of another robot
    made.helm.do(Order(Action.RESUME))
    made.helm.do(Order(Action.PEN))
    wait_until(lambda: made.helm.view.pen_down is True)


def test_w13_a_limit_ends_the_wish_of_its_key(bench: Callable[..., Bench], tmp_path: Any) -> None:
    (tmp_path / "arena.toml").write_text("[[wall]]\npoints = [[-300, 150], [300, 150]]\n", "utf-8")
    made = bench(f"sim:walter?arena={tmp_path}/arena.toml", pace=2.0)
    assert made.helm.obstacles == [(-300.0, 150.0, 300.0, 150.0)]
    wish = made.wish(1.0)
    wait_until(lambda: bool(made.notices()))
    assert (
        "front limit: something is in the way at x 0, y 60 mm. The robot stands; drive it back"
        in made.notices()
    )
    wait_until(lambda: made.helm.refused == wish.number)
    made.wish(-1.0)
    made.wait_until_moving()


def test_the_link_is_lost_and_nothing_goes_on_by_itself(bench: Callable[..., Bench]) -> None:
    made = bench("sim:walter?faults=close:0.6")
    made.wish(0.5)
    wait_until(lambda: made.helm.view.link in ("reconnecting", "stopped"), "the loss")
    wait_until(lambda: made.helm.view.link == "stopped", "the way back")
    made.wish(0.5)
    wait_until(lambda: made.helm.refused == 2)
    assert not made.robot.is_moving
    made.helm.do(Order(Action.RESUME))
    wait_until(lambda: made.helm.view.link == "connected")
    made.wish(0.5)
    made.wait_until_moving()
    assert "driving again" in made.notices()


@pytest.mark.parametrize("url", ["sim:walter", "sim:simple"])
def test_a_link_that_ends_is_told_though_nothing_is_wished(bench: Callable[..., Bench], url: str) -> None:
    made = bench(f"{url}?faults=close:0.6&reconnect_s=0")
    wait_until(lambda: made.helm.view.link == "closed", "the end")
    wait_until(lambda: isinstance(made.helm.failure, LinkClosedError))
    wait_until(lambda: "a fault that was asked for" in made.notices())


def test_a_robot_that_cannot_be_reached(tmp_path: Any) -> None:
    helm = Helm(
        target("sim:walter?faults=lose:1&reply_timeout_s=0.05&boot_s=0&require_replies=yes"),
        pace=50.0,
        announce=print,
    )
    with pytest.raises(NoReplyError):
        helm.connect()
    helm.close()
    helm.steer(Wish())


def test_a_mistake_of_ours_stops_the_robot(
    bench: Callable[..., Bench], monkeypatch: pytest.MonkeyPatch
) -> None:
    made = bench()
    made.wish(0.5)
    made.wait_until_moving()
    monkeypatch.setattr(made.helm, "_carry_out", lambda order: 1 / 0)
    made.helm.do(Order(Action.LAMP))
    made.wait_until_standing()
    wait_until(lambda: isinstance(made.helm.failure, ZeroDivisionError))


def test_notices_are_bounded_and_those_of_drivers_are_among_them(bench: Callable[..., Bench]) -> None:
    made = bench("sim:walter?groups=CHE")
    assert "answers no queries" in made.notices()
    for n in range(100):
        made.helm.note(f"note {n}")
    wait_until(lambda: "note 99" in made.notices())
    assert len(made.helm.view.notices) == notices.MAX_NOTICES
