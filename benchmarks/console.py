"""What the web console costs: from a touch in the browser to the bytes on the robot's line, with and without watchers.

The robot is a car at a pty, in a process of its own, without wheels: it answers as cars do and tells when the command
to drive came. Three ways lead there, all of them from the moment at which somebody wants it to drive:

- the helm, called directly, in this process: the same path without server and browser;
- the stream, from a client in Python: without the browser;
- a touch in Chromium, from the time that the browser itself gives it.

The ways take turns, so that what the machine does besides happens to all of them. Only ratios within one run count.
Then the stream again, alone and with 20 who watch (2 browsers and 18 streams), in turns, too. Those who watch sit at
computers of their own: here they have the processor when nobody else wants it. At last two hours of a simulated car's
path, in virtual time, by what the console keeps of it; it keeps no more after 70 minutes. With ``--path`` only that.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import multiprocessing
import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import tty
import urllib.request
from pathlib import Path
from typing import TYPE_CHECKING, Any

import turtlewire
from turtlewire import configuration
from turtlewire.console.traffic import Traffic
from turtlewire.helm.helm import Helm
from turtlewire.helm.path import Path as Way
from turtlewire.helm.sight import Ear, Sight
from turtlewire.helm.wire import Tap
from turtlewire.helm.wishes import Wish
from turtlewire.protocols.simple.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Iterator
    from multiprocessing.connection import Connection

    from turtlewire.links.link import Link

ROUNDS, TOUCHES = 12, 10
WATCHERS, BROWSERS = 18, 2
LIFE_S, REST_S, PATIENCE_S = 0.3, 0.12, 1.0
PATH_S, LOOK_S = 7200.0, 0.08
CHROMIUM = "/usr/bin/chromium"
LAST = 19  # who is as nice as that has the processor when nobody else wants it
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"]


def be_a_car(near: int, told: Connection) -> None:
    """Answer as a car does; tell when it is to drive after it stood."""
    robot = Robot()
    while True:
        data = os.read(near, 4096)
        now = time.monotonic()
        stood = not robot.drive
        os.write(near, robot.receive_data(data).replies)
        if stood and robot.drive:
            told.send(now)


class Car:
    """A car at a pty."""

    def __init__(self) -> None:
        near, far = os.openpty()
        tty.setraw(far)
        self.url = f"{os.ttyname(far)}?protocol=simple&boot_s=0"
        self.told, tells = multiprocessing.Pipe(duplex=False)
        self._process = multiprocessing.Process(target=be_a_car, args=(near, tells), daemon=True)
        self._process.start()

    def moved_at(self) -> float | None:
        """When it was told to drive; None: it was not, because what was wanted came too late."""
        if not self.told.poll(PATIENCE_S):
            return None
        at: float = self.told.recv()
        return at


class Console:
    """A ``turtlewire console`` with a car."""

    def __init__(self, car: Car, folder: str) -> None:
        command = [sys.executable, "-m", "turtlewire", "console", "--listen-port", "0", "--port", car.url]
        self.process = subprocess.Popen(
            [*command, "--programs", folder], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        assert self.process.stdout is not None
        found = re.search(r"http\S+/", self.process.stdout.readline())
        assert found is not None
        self.url = found[0]
        while not self._is_reached():
            time.sleep(0.05)

    def _is_reached(self) -> bool:
        with urllib.request.urlopen(f"{self.url}api/robots") as answer:
            return all(robot["reached"] for robot in json.load(answer))


class Streamer:
    """A page without a browser."""

    def __init__(self, console: Console) -> None:
        from websockets.sync.client import connect

        self._open = contextlib.ExitStack()
        url = console.url.replace("http", "ws", 1) + "api/stream"
        self._socket = self._open.enter_context(connect(url, max_queue=None))
        self._stamp = (0.0, 0.0)
        self._number = self._grip = 0
        welcome = json.loads(self._socket.recv())
        self.robot = welcome["robots"][0]["name"]
        self._take(welcome)
        self.say(type="watch", robot=self.robot)
        threading.Thread(target=self._follow, daemon=True).start()

    def _take(self, message: dict[str, Any]) -> None:
        if "stamp" in message:
            self._stamp = (message["stamp"], time.monotonic())

    def _follow(self) -> None:
        with contextlib.suppress(Exception):
            for text in self._socket:
                self._take(json.loads(text))

    def say(self, **message: Any) -> None:
        """Say something to the server."""
        self._socket.send(json.dumps(message))

    def touch(self) -> float:
        """Begin to drive; when that was."""
        self._number += 1
        self._grip += 1
        stamp, received = self._stamp
        now = time.monotonic()
        said = {"speed": 0.5, "turn": 0.0, "stamp": stamp, "age_ms": (now - received) * 1000.0}
        self.say(type="drive", robot=self.robot, number=self._number, grip=self._grip, **said)
        return now

    def let_go(self) -> None:
        """Drive no more."""
        self.say(type="release", robot=self.robot)

    def give_up_the_wheel(self) -> None:
        """Let somebody else drive."""
        self.say(type="wheel", robot=self.robot, action="release")

    def close(self) -> None:
        """Go away."""
        self._open.close()


class Finger:
    """A touch in a browser."""

    def __init__(self, page: Any, context: Any) -> None:
        self._page = page
        self._protocol = context.new_cdp_session(page)
        box = page.locator(".tw-stick").bounding_box()
        self._middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        self._reach = box["height"] / 2.5
        page.evaluate(
            """() => {
              window.touched = [];
              addEventListener(
                "pointermove",
                ({timeStamp}) => touched.push([timeStamp, performance.now()]),
                {capture: true, passive: true},
              );
            }"""
        )
        self.untold: list[float] = []  # how long the browser took until it told the page, seconds
        self._ahead_s = min(self._clock() for _ in range(100))[1]

    def _clock(self) -> tuple[float, float]:
        """How long asking for the page's time takes, and how far its clock is behind ours."""
        before = time.monotonic()
        theirs = self._page.evaluate("() => performance.now()") / 1000.0
        after = time.monotonic()
        return after - before, (before + after) / 2 - theirs

    def _send(self, kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": x, "y": y, "id": 0} for x, y in places]
        self._protocol.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def touch(self) -> float:
        """Push the joystick ahead; when the browser says that was."""
        x, y = self._middle
        self._send("touchStart", (x, y))
        self._page.evaluate("() => { touched.length = 0; }")
        self._send("touchMove", (x, y - self._reach))
        moved, told = self._page.evaluate("() => touched[0]")
        self.untold.append((told - moved) / 1000.0)
        return float(moved) / 1000.0 + self._ahead_s

    def let_go(self) -> None:
        """Lift the finger."""
        self._send("touchEnd")


class Direct:
    """The helm, without server and browser."""

    def __init__(self, car: Car) -> None:
        self._helm = Helm(configuration.target(car.url), pace=1.0, announce=lambda _: None)
        self._helm.connect()
        self._number = 0

    def touch(self) -> float:
        """Begin to drive; when that was."""
        self._number += 1
        now = time.monotonic()
        self._helm.steer(Wish(speed=0.5, until=now + LIFE_S, number=self._number))
        return now

    def let_go(self) -> None:
        """Drive no more."""
        self._helm.steer(Wish(until=0.0, number=self._number))

    def close(self) -> None:
        """Let go of the car; in a thread of its own, for Playwright has a loop in this one."""
        closing = threading.Thread(target=self._helm.close)
        closing.start()
        closing.join()


def touches(way: Any, car: Car, count: int) -> Iterator[float]:
    """How long each took from the touch to the byte, seconds."""
    for _ in range(count):
        began = way.touch()
        moved = car.moved_at()
        if moved is not None:
            yield moved - began
        way.let_go()
        time.sleep(REST_S)


def figures(name: str, taken: list[float], beside: float | None = None) -> float:
    """Print median and p99; the median."""
    taken = sorted(taken)
    median, p99 = statistics.median(taken), taken[int(len(taken) * 0.99) - 1 if len(taken) >= 100 else -1]
    times = "" if beside is None else f"   {median / beside:5.1f} times the helm"
    print(
        f"{name:38} {len(taken):4} times: median {1000 * median:7.2f} ms   p99 {1000 * p99:7.2f} ms{times}",
        flush=True,
    )
    return median


def watch(url: str, count: int, is_over: Any) -> None:
    """Several who watch, in a process of their own."""
    from websockets.asyncio.client import connect

    os.nice(LAST)

    async def one() -> None:
        async with connect(url.replace("http", "ws", 1) + "api/stream") as socket:
            robot = json.loads(await socket.recv())["robots"][0]["name"]
            await socket.send(json.dumps({"type": "watch", "robot": robot}))
            await socket.send(json.dumps({"type": "traffic", "on": True}))
            async for _ in socket:
                pass

    async def all_of_them() -> None:
        watching = [asyncio.create_task(one()) for _ in range(count)]
        await asyncio.to_thread(is_over.wait)
        for each in watching:
            each.cancel()
        await asyncio.gather(*watching, return_exceptions=True)

    asyncio.run(all_of_them())


def latency() -> None:
    """From a touch to the byte, by the three ways; then with those who watch."""
    from playwright.sync_api import sync_playwright

    near, far = Car(), Car()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        console = Console(far, folder)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        context = browser.new_context(viewport={"width": 390, "height": 780}, has_touch=True, is_mobile=True)

        onlooker = Path(folder, "onlooker")
        onlooker.write_text(f'#!/bin/sh\nexec nice -n {LAST} {CHROMIUM} "$@"\n', encoding="ascii")
        onlooker.chmod(0o755)
        others = playwright.chromium.launch(executable_path=onlooker, args=ARGUMENTS).new_context()

        def visit(context: Any) -> Any:
            page = context.new_page()
            page.goto(console.url)
            page.locator(".tw-stick").wait_for()
            return page

        page = visit(context)
        finger, direct, stream = Finger(page, context), Direct(near), Streamer(console)
        taken: dict[str, list[float]] = {"helm": [], "stream": [], "touch": [], "alone": [], "watched": []}
        for _ in range(ROUNDS):
            taken["helm"] += touches(direct, near, TOUCHES)
            taken["stream"] += touches(stream, far, TOUCHES)
            stream.give_up_the_wheel()
            time.sleep(REST_S)
            taken["touch"] += touches(finger, far, TOUCHES)
            page.get_by_role("button", name="Let go").dispatch_event("click")
            time.sleep(REST_S)
        helm = figures("helm, called directly", taken["helm"])
        figures("stream, from Python", taken["stream"], helm)
        figures("touch in Chromium", taken["touch"], helm)
        figures("of that, until Chromium tells the page", finger.untold)
        direct.close()
        page.close()
        for _ in range(ROUNDS // 3):
            taken["alone"] += touches(stream, far, 2 * TOUCHES)
            pages = [visit(others) for _ in range(BROWSERS)]
            is_over = multiprocessing.Event()
            streams = multiprocessing.Process(target=watch, args=(console.url, WATCHERS, is_over))
            streams.start()
            time.sleep(2.0)
            taken["watched"] += touches(stream, far, 2 * TOUCHES)
            is_over.set()
            streams.join()
            for each in pages:
                each.close()
        alone = figures("stream, nobody else watches", taken["alone"])
        watched = figures(f"stream, {WATCHERS + BROWSERS} watch ({BROWSERS} in browsers)", taken["watched"])
        print(f"watched / alone: {watched / alone:.2f}")
        stream.close()
        browser.close()
        console.process.terminate()
        console.process.wait()


def resident_mib() -> float:
    """How much memory this process has now."""
    with open("/proc/self/statm", encoding="ascii") as statm:  # noqa: PTH123
        return int(statm.read().split()[1]) * resource.getpagesize() / 2**20


async def path() -> None:
    """Two hours of a car's path, in virtual time, by the parts of the console that keep something."""
    target = configuration.target("sim:simple")
    traffic, ear, way = Traffic(target), Ear(target, 1.0), Way()

    def wrap(link: Link) -> Link:
        ear.link = Tap(traffic.listen(link), ear.messages)
        return ear.link

    robot = await turtlewire.connect_async("sim:simple", wrap=wrap)
    async with robot:
        sight = Sight(robot, ear, is_seen=True, path=way)
        began_s, next_s, number = ear.link.now(), 0.0, 0
        while (passed_s := ear.link.now() - began_s) < PATH_S:
            if passed_s >= next_s:
                print(
                    f"{passed_s / 60:4.0f} min: {resident_mib():6.1f} MiB, {len(way)} points, "
                    f"{traffic.count} messages",
                    flush=True,
                )
                next_s += 600.0
            number += 1
            # Curves that never repeat.
            await robot.drive(0.7, 0.9 if number % 97 < 60 else -0.4 + (number % 13) / 40.0)
            sight.look((), is_over=False)
            await robot._pause(LOOK_S)
        print(
            f"{PATH_S / 60:4.0f} min: {resident_mib():6.1f} MiB, {len(way)} points, {traffic.count} messages"
        )


def main() -> None:
    """Measure all of it."""
    if "--path" not in sys.argv:
        latency()
    asyncio.run(path())


if __name__ == "__main__":
    main()
