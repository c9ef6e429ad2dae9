"""The dashboard, with a robot of its own and no terminal: what keys make of it, and what becomes of mistakes."""

from __future__ import annotations

import asyncio
import threading
import time
from typing import TYPE_CHECKING, Any

import pytest
from textual import events

from turtlewire.configuration import target
from turtlewire.dashboard import keyboard, panels
from turtlewire.dashboard.app import Dashboard
from turtlewire.dashboard.controls import Controls
from turtlewire.dashboard.layouts import layout
from turtlewire.dashboard.terminal import HungUp, KeyEvent, Shown
from turtlewire.helm.helm import Helm

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Iterator
    from pathlib import Path

    from textual.pilot import Pilot

SIZE = (80, 24)


class Sitting:
    """Somebody at a dashboard."""

    def __init__(self, url: str, *, latched: bool = False) -> None:
        robot = target(url)._replace(overrides={"boot_s": 0.1})
        self.helm = Helm(robot, pace=1.0, announce=print)
        self.helm.connect()
        self.controls = Controls(
            layout(robot.protocol),
            speed=100,
            has_full_lock=robot.protocol == "simple",
            first_s=0.7,
            hold_s=0.25,
            latched=latched,
        )
        self.app = Dashboard(self.helm, self.controls, latched=latched)

    def run(
        self, act: Callable[[Pilot[None]], Coroutine[Any, Any, None]], size: tuple[int, int] = SIZE
    ) -> None:
        async def sit() -> None:
            async with self.app.run_test(size=size) as pilot:
                await act(pilot)

        try:
            asyncio.run(sit())
        finally:
            self.helm.close()

    async def until(self, condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + 30.0
        while not condition():
            assert time.monotonic() < deadline, self.text
            await asyncio.sleep(0.01)

    async def until_moving(self) -> None:
        await self.until(lambda: self.helm.view.speed_mm_per_s != 0.0)

    async def until_standing(self) -> None:
        await self.until(lambda: self.helm.view.speed_mm_per_s == 0.0)

    def stops(self) -> int:
        """How many emergency stops have gone out."""
        lines = self.helm._sight._messages.lines()
        return sum(line.times for line in lines if line.text == "emergency stop")

    @property
    def text(self) -> str:
        """What stands on the screen."""
        lines = self.app.screen._compositor.render_strips()
        return "\n".join(strip.text for strip in lines)


@pytest.fixture
def sitting() -> Iterator[Callable[..., Sitting]]:
    made: list[Sitting] = []

    def make(url: str = "sim:walter", *, latched: bool = False) -> Sitting:
        made.append(Sitting(url, latched=latched))
        return made[-1]

    yield make
    for each in made:
        each.helm.close()


def test_what_it_shows(sitting: Callable[..., Sitting]) -> None:
    one = sitting()

    async def act(pilot: Pilot[None]) -> None:
        await one.until(lambda: "Hold a key to drive" in one.text)
        for piece in (
            " simulated WALTER",
            "● connected",
            "↑",
            "├───┤",
            "heading",
            "set_speed speed=100",
            "A Z , . or arrows",
        ):
            assert piece in one.text
        await pilot.resize_terminal(50, 12)
        await one.until(lambda: "├───┤" not in one.text and "set_speed" not in one.text)
        assert "heading" in one.text
        await pilot.resize_terminal(120, 40)
        await one.until(lambda: "├───┤" in one.text)

    one.run(act)


def test_keys(sitting: Callable[..., Sitting]) -> None:
    one = sitting("sim:frame?dialect=telemetry", latched=True)

    async def act(pilot: Pilot[None]) -> None:
        await pilot.press("W")  # capitals are the same
        await one.until_moving()
        await one.until(lambda: "▲ ahead (latched)" in one.text)
        await pilot.press("right")
        await one.until(lambda: one.helm.view.turn_deg_per_s > 1.0)
        # As long as it is renewed, it goes on.
        await one.until(lambda: one.helm.view.distance_mm > 300.0)
        await pilot.press("space")
        assert one.helm.refused == one.app._wish.number  # no wish that ends: a stop, ahead of everything
        await one.until_standing()
        await pilot.press("plus", "l")
        await one.until(lambda: "▮▮▮▮▯▯▯▯▯ 113" in one.text and "lights   on" in one.text)
        await pilot.press("tab", "f5", "ctrl+q", "ctrl+c", "alt+w")  # which mean nothing here
        await one.until_standing()
        assert one.app.is_running
        await pilot.press("q")

    one.run(act)
    assert one.app.failure is None
    assert not one.app.has_hung_up


def test_the_keyboard_goes_elsewhere(sitting: Callable[..., Sitting]) -> None:
    one = sitting(latched=True)

    async def act(pilot: Pilot[None]) -> None:
        await pilot.press("a")
        await one.until_moving()
        one.app.post_message(events.AppBlur())
        await one.until_standing()
        assert one.helm.refused == 1  # no wish that ends: a stop, ahead of everything
        await one.until(lambda: "■ stop" in one.text)

    one.run(act)


def test_a_terminal_that_tells_releases(sitting: Callable[..., Sitting]) -> None:
    one = sitting("sim:simple")
    asked = threading.Event()

    async def act(pilot: Pilot[None]) -> None:
        driver: Any = one.app._driver
        driver.ask = asked.set
        await pilot.press("w")
        await one.until_moving()
        assert not asked.is_set()  # as long as nobody answers
        one.app.post_message(KeyEvent(keyboard.Answered(tells_events=True)))
        await one.until(lambda: one.controls.sees_releases)
        await one.until_standing()
        await pilot.press("w")
        await one.until(asked.is_set)
        one.app.post_message(KeyEvent(keyboard.Repeated("w")))
        await one.until_moving()
        one.app.post_message(KeyEvent(keyboard.Released("w")))
        await one.until_standing()

    one.run(act)


def test_the_terminal_hangs_up(sitting: Callable[..., Sitting]) -> None:
    one = sitting(latched=True)

    async def act(pilot: Pilot[None]) -> None:
        await pilot.press("a")
        await one.until_moving()
        one.app.post_message(HungUp())
        await one.until_standing()

    one.run(act)
    assert one.app.has_hung_up


def test_the_screen_is_made_anew_when_some_of_it_got_lost(
    sitting: Callable[..., Sitting], monkeypatch: pytest.MonkeyPatch
) -> None:
    one = sitting()

    async def act(pilot: Pilot[None]) -> None:
        await one.until(lambda: "Hold a key" in one.text)
        compositor = one.app.screen._compositor
        whole: list[object] = []
        monkeypatch.setattr(compositor, "render_full_update", lambda **_: whole.append(1))
        one.app.post_message(Shown())
        await one.until(lambda: bool(whole))

    one.run(act)


def test_a_signal(sitting: Callable[..., Sitting]) -> None:
    one = sitting(latched=True)

    async def act(pilot: Pilot[None]) -> None:
        await pilot.press("a")
        await one.until_moving()
        threading.Thread(target=one.app.interrupt).start()
        await one.until_standing()
        await one.until(lambda: not one.app.is_running or one.app._exit)

    one.run(act)


def test_a_signal_before_it_has_begun(sitting: Callable[..., Sitting]) -> None:
    one = sitting()
    one.app.interrupt()

    async def act(pilot: Pilot[None]) -> None:
        await one.until(lambda: one.app._exit)

    one.run(act)


def test_nobody_drives_while_the_program_is_suspended(sitting: Callable[..., Sitting]) -> None:
    one = sitting(latched=True)

    async def act(pilot: Pilot[None]) -> None:
        await pilot.press("a")
        await one.until_moving()
        stops = one.stops()
        one.app.stop_before_pause()  # comes back when the stop is on its way
        assert one.stops() > stops
        await one.until_standing()
        await one.until(lambda: "■ stop" in one.text)

    one.run(act)


def test_a_dashboard_that_hangs_keeps_no_robot_moving(sitting: Callable[..., Sitting]) -> None:
    one = sitting()

    async def act(pilot: Pilot[None]) -> None:
        await pilot.press("a")
        await one.until_moving()
        deadline = time.monotonic() + 30.0
        while one.helm.view.speed_mm_per_s != 0.0:  # and nobody else's turn comes
            assert time.monotonic() < deadline
            time.sleep(0.01)  # noqa: ASYNC251 - on purpose

    one.run(act)


def test_a_mistake_of_ours_stops_the_robot_and_is_kept(
    sitting: Callable[..., Sitting], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    one = sitting(latched=True)

    async def act(pilot: Pilot[None]) -> None:
        await pilot.press("a")
        await one.until_moving()
        monkeypatch.setattr(panels, "side", lambda *_, **__: 1 / 0)
        await one.until(lambda: one.app.failure is not None)
        await one.until_standing()

    one.run(act)
    assert isinstance(one.app.failure, ZeroDivisionError)
    assert "Traceback" not in capsys.readouterr().err


def test_speeds_are_typed(sitting: Callable[..., Sitting]) -> None:
    one = sitting()

    async def act(pilot: Pilot[None]) -> None:
        await pilot.press("g", "1", "2", "3")
        await one.until(lambda: "speed, 1 to 255: 123_" in one.text)
        await pilot.press("backspace", "enter")
        await one.until(lambda: "set      12, of turns 100" in one.text)

    one.run(act)


def test_w13_a_key_that_ran_into_something_counts_no_more(
    sitting: Callable[..., Sitting], tmp_path: Path
) -> None:
    (tmp_path / "arena.toml").write_text("[[wall]]\npoints = [[-300, 100], [300, 100]]\n", "utf-8")
    one = sitting(f"sim:walter?arena={tmp_path}/arena.toml", latched=True)

    async def act(pilot: Pilot[None]) -> None:
        for key in ("a", "up"):
            before = len(one.helm.view.notices)
            await pilot.press(key)
            await one.until(lambda: len(one.helm.view.notices) > before)  # noqa: B023 - waited for here
            await one.until(lambda: "! front limit: something is in the way" in one.text)
            await one.until(lambda: "■ stop" in one.text)

    one.run(act)


def test_a_robot_that_jumps_has_not_driven_there(sitting: Callable[..., Sitting]) -> None:
    one = sitting()

    async def act(pilot: Pilot[None]) -> None:
        await one.until(lambda: bool(one.app._path.legs))
        one.helm._sight._jumps += 1
        await one.until(lambda: len(one.app._path.legs) == 2)

    one.run(act)
