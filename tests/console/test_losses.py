"""A driver who is gone: whatever becomes of the browser, the page or the way to it, the robot stops within 500 ms."""

from __future__ import annotations

import os
import signal
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import pytest

from .conftest import ARGUMENTS, CHROMIUM, Visitor, wait_until
from .onlookers import Forwarder, Onlooker

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from playwright.sync_api import Browser

    from .conftest import Console

    Visit = Callable[..., Visitor]

LONGEST_S = 0.5
# Where the robot is, is looked at so often.
GRAIN_S = 0.1
WAY_MM = 10.0


@pytest.fixture
def onlooker(console: Console) -> Iterator[Onlooker]:
    """Somebody who sees when the robot stops."""
    made = Onlooker(console)
    yield made
    made.close()


@pytest.fixture
def forwarder(console: Console) -> Iterator[Forwarder]:
    """A way to the console that can stall."""
    made = Forwarder(console)
    yield made
    made.close()


@contextmanager
def stops(onlooker: Onlooker) -> Iterator[None]:
    """What happens here stops the robot, within half a second of its time."""
    began_s = onlooker.robot_time()
    yield
    took_s = onlooker.stopped_at() - began_s
    print(f"stopped after {1000 * took_s:.0f} ms of the robot's time")
    assert took_s <= LONGEST_S
    assert took_s > -GRAIN_S, "it stood before"


def drive(visitor: Visitor, console: Console) -> None:
    """Hold a key, and go on holding it; anew where this computer was so busy that a set-point came late."""

    began_mm = console.view("walter")["distance_mm"]

    def moves() -> bool:
        if visitor.see(".tw-hand-says").inner_text() != "Driving":
            visitor.page.keyboard.up("ArrowUp")
            visitor.page.keyboard.down("ArrowUp")
        # So far that an onlooker can tell it from standing.
        return console.moves("walter") and console.view("walter")["distance_mm"] > began_mm + WAY_MM

    wait_until(moves, "walter to move")


@pytest.mark.parametrize("kind", ["browser", "renderer"])
def test_a_browser_that_is_killed(console: Console, chromium: Browser, onlooker: Onlooker, kind: str) -> None:
    browser = chromium.browser_type.launch(executable_path=CHROMIUM, args=ARGUMENTS)
    processes: list[dict[str, Any]] = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")[
        "processInfo"
    ]
    visitor = Visitor(browser.new_context(), console, is_phone=False).open()
    processes = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
    victims = [process["id"] for process in processes if process["type"] == kind]
    assert victims
    drive(visitor, console)
    with stops(onlooker):
        for victim in victims:
            os.kill(victim, signal.SIGKILL)
    wait_until(lambda: console.state("walter")["wheel"]["driver"] is None, "the wheel to be free")
    if kind == "renderer":
        browser.close()


def test_a_page_that_is_frozen(console: Console, visit: Visit, onlooker: Onlooker) -> None:
    visitor = visit()
    debugger = visitor.context.new_cdp_session(visitor.page)
    debugger.send("Debugger.enable")
    drive(visitor, console)
    with stops(onlooker):
        debugger.send("Debugger.pause")
    # It goes on where it was: the key is still down, but that grip has ended.
    before = onlooker.robot_time()
    debugger.send("Debugger.resume")
    debugger.detach()
    wait_until(lambda: visitor.see(".tw-hand-says").inner_text() != "Driving", "the page to know of it")
    visitor.page.wait_for_timeout(300)
    assert onlooker.stopped_at() < before
    visitor.page.keyboard.up("ArrowUp")
    drive(visitor, console)
    visitor.page.keyboard.up("ArrowUp")


def test_a_tab_that_is_hidden(console: Console, visit: Visit, onlooker: Onlooker) -> None:
    visitor = visit()
    drive(visitor, console)
    with stops(onlooker):
        visitor.page.evaluate(
            """() => {
              Object.defineProperty(document, "hidden", {value: true, configurable: true});
              document.dispatchEvent(new Event("visibilitychange"));
            }"""
        )
    assert console.state("walter")["wheel"]["driver_name"] is not None  # it is still there


@pytest.mark.parametrize("ending", ["closed", "reloaded", "gone elsewhere"])
def test_a_page_that_is_left(console: Console, visit: Visit, onlooker: Onlooker, ending: str) -> None:
    visitor = visit()
    drive(visitor, console)
    with stops(onlooker):
        if ending == "closed":
            visitor.page.close()
        elif ending == "reloaded":
            visitor.page.reload()
        else:
            visitor.page.goto("about:blank")


def test_set_points_that_were_held_up_are_not_replayed(
    console: Console, visit: Visit, onlooker: Onlooker, forwarder: Forwarder
) -> None:
    visitor = visit(before=lambda made: setattr(made, "way", forwarder.url))
    drive(visitor, console)
    with stops(onlooker):
        forwarder.stall()
    # Meanwhile the page goes on saying what it wants; all of it arrives at once, and is old.
    wait_until(lambda: onlooker.robot_time() > onlooker.stopped_at() + 1.0, "some of them to wait")
    before = onlooker.robot_time()
    forwarder.go_on()
    wait_until(lambda: visitor.see(".tw-hand-says").inner_text() != "Driving", "the page to know of it")
    visitor.page.wait_for_timeout(300)
    assert onlooker.stopped_at() < before
    visitor.page.keyboard.up("ArrowUp")
    drive(visitor, console)
    visitor.page.keyboard.up("ArrowUp")


def test_a_way_that_breaks(console: Console, visit: Visit, onlooker: Onlooker, forwarder: Forwarder) -> None:
    visitor = visit(before=lambda made: setattr(made, "way", forwarder.url))
    visitor.expect("ERR_")
    visitor.expect("WebSocket")
    drive(visitor, console)
    with stops(onlooker):
        forwarder.close()
    visitor.page.get_by_text("Connection lost, trying again").wait_for()
