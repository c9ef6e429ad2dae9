"""The console as people use it: a real process with simulated robots, and Debian's Chromium, by clicks, touches, keys.

A test that needs the page asks for ``visit``; every page is watched, and has to end without a word on its console
and without a request to any other host.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import httpx
import pytest
from playwright.sync_api import sync_playwright

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from playwright.sync_api import (
        Browser,
        BrowserContext,
        CDPSession,
        ConsoleMessage,
        Locator,
        Page,
        Request,
    )

DEADLINE_S = 40.0
# A robot that is where it was for so long stands.
STANDS_S = 0.2
CHROMIUM = "/usr/bin/chromium"
ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
PHONE: dict[str, Any] = {
    "viewport": {"width": 390, "height": 780},
    "device_scale_factor": 2,
    "has_touch": True,
    "is_mobile": True,
}
DESKTOP: dict[str, Any] = {"viewport": {"width": 1280, "height": 800}}
TICKS = """
() => new Promise((done) => {
  let left = 5;
  const timer = setInterval(() => {
    left -= 1;
    if (left > 0) return;
    clearInterval(timer);
    done();
  }, 40);
})
"""
ADDRESS = re.compile(r"turtlewire console: (\S+)")


def wait_until(condition: Callable[[], object], what: str) -> None:
    """Wait for a condition, looking again and again."""
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.01)


class Console:
    """A ``turtlewire console`` under way, and what a machine is told by it."""

    def __init__(self, arguments: list[str], folder: Path) -> None:
        self._said: list[str] = []
        self.popen = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "turtlewire",
                "console",
                "--listen-port",
                "0",
                "--programs",
                str(folder / "programs"),
                *arguments,
            ],
            cwd=folder,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
        )
        self._reader = threading.Thread(target=self._follow, daemon=True)
        self._reader.start()
        self.url = ""
        self.client = httpx.Client(timeout=DEADLINE_S, trust_env=False)
        try:
            self._wait(lambda: ADDRESS.search(self.said) is not None, "its address")
            found = ADDRESS.search(self.said)
            assert found is not None
            self.url = found[1]
            self.client.base_url = httpx.URL(self.url)
            self._wait(lambda: all(robot["reached"] for robot in self.robots()), "its robots")
        except BaseException:
            self.close()
            raise

    def _follow(self) -> None:
        assert self.popen.stdout is not None
        self._said.extend(self.popen.stdout)

    def _wait(self, condition: Callable[[], bool], what: str) -> None:
        wait_until(lambda: self.popen.poll() is not None or condition(), what)
        assert self.popen.poll() is None, f"it ended: {self.said}"

    @property
    def said(self) -> str:
        return "".join(self._said)

    def robots(self) -> list[dict[str, Any]]:
        answer = self.client.get("/api/robots")
        assert answer.status_code == 200, answer.text
        found: list[dict[str, Any]] = answer.json()
        return found

    def state(self, robot: str) -> dict[str, Any]:
        answer = self.client.get(f"/api/robots/{robot}")
        assert answer.status_code == 200, answer.text
        found: dict[str, Any] = answer.json()
        return found

    def view(self, robot: str) -> dict[str, Any]:
        view: dict[str, Any] = self.state(robot)["view"]
        return view

    def moves(self, robot: str) -> bool:
        view = self.view(robot)
        return bool(abs(view["speed_mm_per_s"]) > 1.0 or abs(view["turn_deg_per_s"]) > 1.0)

    def wait_for_motion(self, robot: str) -> None:
        wait_until(lambda: self.moves(robot), f"{robot} to move")

    def wait_for_rest(self, robot: str) -> None:
        """Until it stands, and has done so for a moment."""
        since_s, pose = time.monotonic(), None

        def stands() -> bool:
            nonlocal since_s, pose
            view = self.view(robot)
            if view["pose"] != pose or self.moves(robot):
                since_s, pose = time.monotonic(), view["pose"]
            return time.monotonic() - since_s > STANDS_S

        wait_until(stands, f"{robot} to stand")

    def stop(self) -> None:
        assert self.client.post("/api/stop").status_code == 200

    def close(self) -> None:
        self.client.close()
        if self.popen.poll() is None:
            self.popen.send_signal(signal.SIGINT)
        try:
            self.popen.wait(DEADLINE_S)
        finally:
            self.popen.kill()
            self.popen.wait()
        self._reader.join(DEADLINE_S)
        assert self.popen.stdout is not None
        self.popen.stdout.close()
        assert "Traceback" not in self.said, self.said


class Visitor:
    """Somebody with a browser: one page of the console."""

    def __init__(self, context: BrowserContext, console: Console, *, is_phone: bool) -> None:
        self.console = console
        self.way = console.url
        self.context = context
        self.is_phone = is_phone
        self.complaints: list[str] = []
        self.expected: list[str] = []
        self.page: Page = context.new_page()
        self.page.on("console", self._heard)
        self.page.on("pageerror", lambda error: self.complaints.append(f"{error}\n{error.stack}"))
        self.page.on("request", self._asked)
        self._touch: CDPSession | None = None

    def _heard(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning", "assert"):
            self.complaints.append(f"{message.type}: {message.text}")

    def _asked(self, request: Request) -> None:
        address = urlsplit(request.url)
        if address.scheme in ("data", "blob"):
            return
        if address.netloc != urlsplit(self.way).netloc:
            self.complaints.append(f"a request to another host: {request.url}")

    def open(self, robot: str = "walter") -> Visitor:
        """Go to the page, and wait until it shows a robot."""
        self.page.goto(self.way)
        self.page.locator(".tw-wheel").wait_for()
        if self.page.locator(".tw-robot select").count():
            self.page.locator(".tw-robot select").select_option(robot)
        self.page.locator(".tw-figures dd").first.wait_for(state="attached")
        return self

    def expect(self, complaint: str) -> None:
        """A complaint with this in it is part of the test."""
        self.expected.append(complaint)

    def check(self) -> None:
        """Nothing was said on the browser's console, nothing was asked of anybody else."""
        unexpected = [each for each in self.complaints if not any(part in each for part in self.expected)]
        assert not unexpected, "\n".join(unexpected)

    # ------------------------------------------------------------------ what people do

    def see(self, selector: str) -> Locator:
        return self.page.locator(selector)

    def tab(self, name: str) -> None:
        """``drive``, ``program``, ``traffic`` or ``link``."""
        self.press(f"#tw-tab-{name}")

    def press(self, selector: str) -> None:
        """By a finger on a phone, by a click elsewhere."""
        if self.is_phone:
            self.page.locator(selector).tap()
        else:
            self.page.locator(selector).click()

    def button(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True)

    def choose(self, setting: str, value: str) -> None:
        """``language`` or ``theme``, in the settings."""
        self.press(".tw-head [aria-label='Settings'], .tw-head [aria-label='Inställningar']")
        self.page.locator(f".tw-dialog select[name={setting}]").select_option(value)
        self.press(".tw-dialog .primary")

    def middle(self, selector: str) -> tuple[float, float, float]:
        """Where something is on the screen, and how large: x, y, half its width."""
        box = self.page.locator(selector).bounding_box()
        assert box is not None
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, box["width"] / 2

    def touch(self, kind: str, *places: tuple[float, float]) -> None:
        """Fingers: ``touchStart``, ``touchMove``, ``touchEnd`` or ``touchCancel``, and all places that are touched."""
        if self._touch is None:
            self._touch = self.context.new_cdp_session(self.page)
        points = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(places)]
        self._touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    @contextmanager
    def holding(self, key: str) -> Iterator[None]:
        """A key is held meanwhile."""
        self.page.keyboard.down(key)
        try:
            yield
        finally:
            self.page.keyboard.up(key)

    @contextmanager
    def driving(self, key: str, until: Callable[[], object]) -> Iterator[None]:
        """A key is held, and has done what it should. See ``drive``."""
        keyboard = self.page.keyboard
        self.drive(lambda: keyboard.down(key), lambda: keyboard.up(key), until)
        try:
            yield
        finally:
            keyboard.up(key)

    def drive(
        self, press: Callable[[], object], release: Callable[[], object], until: Callable[[], object]
    ) -> None:
        """Press until something is so. Set-points may be late on a busy computer, which ends a grip: press anew."""
        ended = self.page.locator(".tw-hand-says.ended")
        done = False

        def has_done() -> bool:
            nonlocal done
            done = bool(until())
            return done or ended.count() > 0

        deadline = time.monotonic() + DEADLINE_S
        while not done:
            assert time.monotonic() < deadline, f"it does not drive: {ended.all_inner_texts()}"
            press()
            wait_until(has_done, "the robot to be driven")
            if not done:
                release()

    def let_timers_run(self) -> None:
        """Until what the page does again and again has been done some times."""
        self.page.evaluate(TICKS)


@pytest.fixture(scope="session")
def start_console(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[..., Console]]:
    """Start one with arguments of its own; they live until the end."""
    consoles = []

    def start(*arguments: str) -> Console:
        consoles.append(Console(list(arguments), tmp_path_factory.mktemp("console")))
        return consoles[-1]

    yield start
    for each in consoles:
        each.close()


@pytest.fixture(scope="session")
def shared_console(start_console: Callable[..., Console]) -> Console:
    """The three simulated robots."""
    return start_console()


@pytest.fixture
def console(shared_console: Console) -> Iterator[Console]:
    """The three simulated robots, which stand, and nobody drives them."""
    yield shared_console
    shared_console.stop()
    wait_until(lambda: _is_left(shared_console), "everybody to be gone")


def _is_left(console: Console) -> bool:
    wheels = [console.state(robot["name"])["wheel"] for robot in console.robots()]
    return all(wheel["driver"] is None and wheel["watchers"] == 0 for wheel in wheels)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    """A browser; a machine without one fails here."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def visit(console: Console, chromium: Browser) -> Iterator[Callable[..., Visitor]]:
    """Visit the console: ``visit(phone=True, dark=True, language="sv-SE", robot="car", settings={...}, at=other)``."""
    visitors: list[Visitor] = []

    def come(
        *,
        phone: bool = False,
        dark: bool = False,
        language: str = "en-GB",
        robot: str = "walter",
        settings: dict[str, Any] | None = None,
        at: Console | None = None,
        before: Callable[[Visitor], None] | None = None,
    ) -> Visitor:
        context = chromium.new_context(
            **(PHONE if phone else DESKTOP),
            locale=language,
            color_scheme="dark" if dark else "light",
            accept_downloads=True,
        )
        context.set_default_timeout(DEADLINE_S * 1000)
        if settings is not None:
            kept = json.dumps(json.dumps(settings))
            context.add_init_script(
                f"localStorage.getItem('turtlewire') ?? localStorage.setItem('turtlewire', {kept})"
            )
        visitor = Visitor(context, at or console, is_phone=phone)
        visitors.append(visitor)
        if before is not None:
            before(visitor)
        return visitor.open(robot)

    yield come
    for visitor in visitors:
        visitor.context.close()
    for visitor in visitors:
        visitor.check()
