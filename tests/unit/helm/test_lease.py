"""A robot that the helm has lent: to a program, for a message."""

from __future__ import annotations

import asyncio
import concurrent.futures
from functools import partial
from threading import Thread
from typing import TYPE_CHECKING, Any

import pytest

from tests.unit.helm.test_helm import DEADLINE_S, ROBOTS, bench, wait_until
from turtlewire.configuration import target
from turtlewire.errors import LimitReachedError, LinkClosedError, StoppedError
from turtlewire.helm.helm import Helm
from turtlewire.helm.wishes import Action, Order, Wish

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.unit.helm.test_helm import Bench
    from turtlewire.connect import AsyncRobot

__all__ = ["bench"]


async def ahead(robot: AsyncRobot) -> None:
    await robot.forward(30.0)
    await robot.finish()


async def on_and_on(robot: AsyncRobot) -> None:
    while True:
        await robot.forward(2000.0)
        await robot.finish()


async def forever(_: AsyncRobot) -> None:
    await asyncio.Event().wait()


async def nothing(_: AsyncRobot) -> None:
    pass


async def a_while(_: AsyncRobot) -> None:
    await asyncio.sleep(0.2)


async def bytes_sent(robot: AsyncRobot) -> int:
    return robot.statistics.bytes_sent


@pytest.mark.parametrize("url", ROBOTS)
def test_it_does_what_it_is_lent_for(bench: Callable[..., Bench], url: str) -> None:
    made = bench(url)
    lease = made.helm.lend()
    calls = [lease.call(ahead) for _ in range(3)]
    for call in calls:
        call.result(DEADLINE_S)
    wait_until(lambda: abs(made.pose.distance_to(0.0, 0.0) - 90.0) < 25.0, "three moves")
    lease.close()
    made.wish(-0.5)
    made.wait_until_moving()


def test_who_drove_is_stopped_first_and_drives_again_only_by_a_new_press(bench: Callable[..., Bench]) -> None:
    made = bench("sim:frame")
    wish = made.wish(0.5)
    made.wait_until_moving()
    lease = made.helm.lend()
    lease.call(nothing).result(DEADLINE_S)
    assert made.helm.refused == wish.number
    made.wait_until_standing()
    lease.close()
    made.wish(0.5)
    made.wait_until_moving()


def test_nothing_is_asked_or_driven_meanwhile(
    bench: Callable[..., Bench], monkeypatch: pytest.MonkeyPatch
) -> None:
    made = bench("sim:walter")
    lease = made.helm.lend()
    lease.call(ahead).result(DEADLINE_S)
    monkeypatch.setattr("turtlewire.helm.helm.CHECK_S", 0.0)  # a check would be due all the time
    monkeypatch.setattr("turtlewire.helm.helm.ASK_S", 0.0)
    before = lease.call(bytes_sent).result(DEADLINE_S)
    looks: list[bool] = []
    look = Helm._next

    async def counted(helm: Helm, wish: Wish) -> bool:
        looks.append(await look(helm, wish))
        return looks[-1]

    monkeypatch.setattr(Helm, "_next", counted)
    wish = made.wish(0.5)
    made.helm.do(Order(Action.PEN))
    lease.call(a_while).result(DEADLINE_S)
    asyncio.run_coroutine_threadsafe(asyncio.sleep(0.2), made.helm._loop).result(DEADLINE_S)
    assert len(looks) < 50  # whoever has nothing to do waits
    assert lease.call(bytes_sent).result(DEADLINE_S) == before
    lease.close()
    wait_until(lambda: made.helm.view.pen_down is False, "the pen")
    assert wish.number > made.helm.refused
    made.wait_until_moving()


@pytest.mark.parametrize("url", ROBOTS)
@pytest.mark.parametrize("work", [on_and_on, forever], ids=["a motion", "anything"])
def test_a_stop_ends_it_whatever_it_is_doing(
    bench: Callable[..., Bench], url: str, work: Callable[[AsyncRobot], Any]
) -> None:
    made = bench(url)
    lease = made.helm.lend()
    under_way, waiting = lease.call(work), lease.call(ahead)
    if work is on_and_on:
        made.wait_until_moving()
    made.helm.stop()
    for call in (under_way, waiting, lease.call(ahead)):
        with pytest.raises(StoppedError):
            call.result(DEADLINE_S)
    made.wait_until_standing()
    assert lease.stopped
    lease.close()
    again = made.helm.lend()
    again.call(ahead).result(DEADLINE_S)
    again.close()


def test_a_stop_between_two_calls_ends_it(bench: Callable[..., Bench]) -> None:
    made = bench("sim:frame")
    lease = made.helm.lend()
    lease.call(ahead).result(DEADLINE_S)
    made.helm.stop()
    with pytest.raises(StoppedError):
        lease.call(ahead).result(DEADLINE_S)


def test_the_stop_of_its_own_ends_no_order_of_the_helm(bench: Callable[..., Bench]) -> None:
    made = bench("sim:frame")
    for is_down in (False, True, False, True):
        made.helm.do(Order(Action.PEN, int(is_down)))
        wait_until(partial(lambda wanted: made.helm.view.pen_down is wanted, is_down), "the pen")
        made.helm.stop()
    assert made.notices() == ""


def test_what_goes_wrong_is_told_to_who_called(bench: Callable[..., Bench], tmp_path: Any) -> None:
    arena = tmp_path / "wall.toml"
    arena.write_text("[[wall]]\npoints = [[-500, 150], [500, 150]]\n")
    made = bench(f"sim:walter?arena={arena}", pace=4.0)
    lease = made.helm.lend()
    with pytest.raises(LimitReachedError):
        lease.call(on_and_on).result(DEADLINE_S)
    lease.close()


def test_a_call_that_nobody_waits_for_any_more_ends(bench: Callable[..., Bench]) -> None:
    made = bench("sim:frame")
    lease = made.helm.lend()
    call = lease.call(forever)
    call.cancel()
    lease.call(ahead).result(DEADLINE_S)
    assert call.cancelled()


def test_the_way_out_ends_it(bench: Callable[..., Bench]) -> None:
    made = bench("sim:frame")
    lease = made.helm.lend()
    call = lease.call(on_and_on)
    made.wait_until_moving()
    made.helm.close()
    assert not made.robot.is_moving
    with pytest.raises((StoppedError, LinkClosedError, concurrent.futures.CancelledError)):
        call.result(DEADLINE_S)
    with pytest.raises(StoppedError):
        lease.call(ahead).result(DEADLINE_S)
    lease.close()
    with pytest.raises(LinkClosedError, match="not reached"):
        made.helm.lend()


def test_giving_up_a_robot_that_is_still_being_reached() -> None:
    announced: list[str] = []
    # nobody ever answers at this port: without `close`, reaching it would take minutes
    helm = Helm(
        target("pty?protocol=simple")._replace(overrides={"boot_s": 600.0}),
        pace=1.0,
        announce=announced.append,
    )
    ended: list[BaseException] = []

    def connect() -> None:
        try:
            helm.connect()
        except LinkClosedError as error:
            ended.append(error)

    thread = Thread(target=connect)
    thread.start()
    wait_until(lambda: bool(announced), "the pty")
    helm.close()
    thread.join(DEADLINE_S)
    assert len(ended) == 1
