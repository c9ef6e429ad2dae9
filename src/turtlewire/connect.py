"""``connect(url)``: brings links, robots and the simulator together."""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING
from urllib.parse import parse_qsl, urlsplit

from turtlewire.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from turtlewire.links.link import Link
    from turtlewire.robots.runner import Runner
    from turtlewire.robots.walter import AsyncWalter, Settings, Walter
    from turtlewire.simulator.walter import SimulatedWalter
    from turtlewire.turtle import Pose

SIM_OPTIONS = "pace, seed, slip, noise, arena, basic, groups, baud, boot_s, watchdog_s, pen_s, speed"


def is_simulated(url: str) -> bool:
    """Whether a URL means a simulated robot in this process, in virtual time."""
    return url.startswith("sim:")


def connect(
    url: str = "sim:walter",
    settings: Settings | None = None,
    *,
    notify: Callable[[str], None] | None = None,
    announce: Callable[[str], None] = print,
) -> Walter:
    """Connect to a robot.

    Args:
        url: ``sim:walter`` for a simulated robot in this process, in virtual time, with options as in
            ``sim:walter?slip=0.02&seed=3&arena=maze.toml&basic=1``; or a port: ``/dev/ttyUSB0``, ``COM3``,
            ``serial:///dev/ttyUSB0?baud=9600``, ``socket://host:port``, ``pty``.
        settings: how to drive the robot.
        notify: told what people should know and what is no error; by default the log ``turtlewire`` warns of it.
        announce: for ``pty``, told the path that the robot is to be at.

    Returns a ``Walter``, to be used in a ``with`` statement: the robot is at home, stopped, with its pen down.

    Raises ``UsageError`` (the URL or a setting means nothing), ``LinkError`` (no such port, port in use) or
    ``NoReplyError``.
    """
    from turtlewire.robots.runner import InlineRunner, ThreadRunner
    from turtlewire.robots.walter import Walter

    runner: Runner = InlineRunner() if is_simulated(url) else ThreadRunner()
    try:
        robot = runner.run(connect_async(url, settings, notify=notify, announce=announce))
    except BaseException:
        runner.close()
        raise
    return Walter(robot, runner)


async def connect_async(
    url: str = "sim:walter",
    settings: Settings | None = None,
    *,
    notify: Callable[[str], None] | None = None,
    announce: Callable[[str], None] = print,
) -> AsyncWalter:
    """``connect`` for asynchronous programs: ``async with await turtlewire.connect_async(url) as robot``."""
    from turtlewire.robots.walter import AsyncWalter, Settings

    settings = (settings or Settings()).checked()
    notify = notify or _warn
    if is_simulated(url):
        from turtlewire.links.memory import MemoryLink

        end, pace = _simulated(url)
        settings = settings._replace(baud=end.settings.baud or settings.baud)
        robot = AsyncWalter(MemoryLink(end, url, pace), settings, notify, paper=end)
    else:
        link, settings = await _opened(url, settings, announce)
        robot = AsyncWalter(link, settings, notify)
    await robot.connect()
    return robot


def stop(url: str, settings: Settings | None = None) -> Pose | None:
    """Stop the robot at a port, from any state (W8), then ask it; where it says it is, or None if it says nothing.

    Raises what ``connect`` raises for a port that cannot be opened.
    """
    from turtlewire.robots.runner import ThreadRunner
    from turtlewire.robots.walter import Settings

    runner = ThreadRunner()
    try:
        return runner.run(_stop(url, (settings or Settings()).checked()))
    finally:
        runner.close()


async def _stop(url: str, settings: Settings) -> Pose | None:
    from turtlewire.protocols.walter.messages import EMERGENCY_STOP
    from turtlewire.robots.walter import AsyncWalter

    link, settings = await _opened(url, settings)
    # A robot that is booting hears nothing of this, but does not move either.
    link.write_urgent(EMERGENCY_STOP)
    async with AsyncWalter(link, settings) as robot:
        await robot.connect()
        return await robot.reported_pose() if "Q" in robot.groups else None


async def _opened(
    url: str, settings: Settings, announce: Callable[[str], None] = lambda _: None
) -> tuple[Link, Settings]:
    """The link to a port, and the settings with the baud rate that the port names, if it does."""
    from turtlewire.links.port import Port
    from turtlewire.links.stream import open_port

    settings = settings._replace(baud=Port.parse(url).baud or settings.baud)
    return await open_port(url, baud=settings.baud, announce=announce), settings


def _warn(text: str) -> None:
    import logging

    logging.getLogger("turtlewire").warning(text)


def simulated(url: str) -> SimulatedWalter:
    """The simulated robot that a ``sim:`` URL describes. Raises ``UsageError`` or, for its arena, ``DataError``."""
    return _simulated(url)[0]


def _simulated(url: str) -> tuple[SimulatedWalter, float | None]:
    """The robot, and its pace."""
    from turtlewire.simulator.walter import Settings as SimulatorSettings
    from turtlewire.simulator.walter import SimulatedWalter

    parts = urlsplit(url)
    if parts.path != "walter":
        raise UsageError(f"{url!r}: there is no simulated robot {parts.path!r}; there is sim:walter")
    options: dict[str, Any] = {}
    pace: float | None = None
    for name, value in parse_qsl(parts.query, keep_blank_values=True):
        if name == "pace":
            pace = _pace(url, value)
        else:
            options |= _option(url, name, value)
    return SimulatedWalter(SimulatorSettings(**options)), pace


def _pace(url: str, value: str) -> float | None:
    if value in ("max", "real"):
        return None if value == "max" else 1.0
    with contextlib.suppress(ValueError):
        if 0.0 < float(value) < math.inf:
            return float(value)
    raise UsageError(
        f"{url!r}: pace is {value!r}, but must be max, real, or a number above 0 (times real time)"
    )


def _option(url: str, name: str, value: str) -> dict[str, Any]:
    try:
        if name in ("seed", "baud", "speed"):
            return {name: int(value)}
        if name in ("slip", "noise", "boot_s", "watchdog_s", "pen_s"):
            return {name: float(value)}
    except ValueError:
        raise UsageError(f"{url!r}: {name} is {value!r}, but must be a number") from None
    if name == "groups":
        return {"groups": frozenset(value.upper())}
    if name == "basic":
        return {"groups": frozenset()} if value not in ("0", "no", "false") else {}
    if name == "arena":
        from turtlewire.simulator.world import load_arena

        return {"world": load_arena(value)}
    raise UsageError(f"{url!r}: unknown option {name!r}; a simulated robot has {SIM_OPTIONS}")
