"""``connect(url)``: brings links, robots and the simulator together."""

from __future__ import annotations

from turtlewire.errors import TurtlewireError, UsageError
from turtlewire.named_tuple import NamedTuple

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import Any, Literal, TypeAlias, TypedDict, Unpack, overload

    from turtlewire.configuration import AnySettings, Target
    from turtlewire.links.link import Link
    from turtlewire.robots.car import AsyncCar, Car
    from turtlewire.robots.car import Settings as CarSettings
    from turtlewire.robots.runner import Runner
    from turtlewire.robots.two_engine import AsyncTwoEngine, TwoEngine
    from turtlewire.robots.two_engine import Settings as TwoEngineSettings
    from turtlewire.robots.walter import AsyncWalter, Walter
    from turtlewire.robots.walter import Settings as WalterSettings
    from turtlewire.turtle import Pose

    Robot: TypeAlias = Walter | Car | TwoEngine
    AsyncRobot: TypeAlias = AsyncWalter | AsyncCar | AsyncTwoEngine
    Wrap: TypeAlias = Callable[[Link], Link]

    class Options(TypedDict, total=False):
        """What ``connect`` takes besides."""

        notify: Callable[[str], None] | None
        announce: Callable[[str], None]
        wrap: Wrap | None


if TYPE_CHECKING:  # typing takes long to load

    @overload
    def connect(
        url: Literal["sim:walter"] = ...,
        settings: WalterSettings | None = ...,
        **options: Unpack[Options],
    ) -> Walter: ...
    @overload
    def connect(
        url: str | Target,
        settings: WalterSettings,
        **options: Unpack[Options],
    ) -> Walter: ...
    @overload
    def connect(
        url: Literal["sim:simple"],
        settings: CarSettings | None = ...,
        **options: Unpack[Options],
    ) -> Car: ...
    @overload
    def connect(
        url: str | Target,
        settings: CarSettings,
        **options: Unpack[Options],
    ) -> Car: ...
    @overload
    def connect(
        url: Literal["sim:frame"],
        settings: TwoEngineSettings | None = ...,
        **options: Unpack[Options],
    ) -> TwoEngine: ...
    @overload
    def connect(
        url: str | Target,
        settings: TwoEngineSettings,
        **options: Unpack[Options],
    ) -> TwoEngine: ...
    @overload
    def connect(
        url: str | Target,
        settings: AnySettings | None = ...,
        **options: Unpack[Options],
    ) -> Any: ...


def connect(
    url: str | Target = "sim:walter",
    settings: AnySettings | None = None,
    *,
    notify: Callable[[str], None] | None = None,
    announce: Callable[[str], None] = print,
    wrap: Wrap | None = None,
) -> Robot:
    """Connect to a robot.

    Args:
        url: ``sim:walter``, ``sim:simple`` or ``sim:frame`` for a simulated robot in this process, in virtual time,
            with options as in ``sim:walter?slip=0.02&seed=3&arena=maze.toml``; a port: ``/dev/ttyUSB0``, ``COM3``,
            ``serial:///dev/ttyUSB0``, ``socket://host:port``, ``pty``, with options as in
            ``/dev/ttyUSB0?protocol=simple&window=4&faults=lose:0.01``; or the name of a robot in ``robots.toml``.
        settings: how to drive the robot, where the URL does not say. They also say what it speaks, if the URL does
            not; without both, that is WALTER.
        notify: told what people should know and what is no error; by default the log ``turtlewire`` warns of it.
        announce: for ``pty``, told the path that the robot is to be at.
        wrap: given the link, returns the link to use instead: a recording, say.

    Returns a ``Walter``, a ``Car`` (simple) or a ``TwoEngine`` (frame), to be used in a ``with`` statement: the robot
    is at home, stopped, with its pen down. A type checker can tell which of them only by ``settings``, or by the plain
    URL of a simulated robot.

    Raises ``UsageError`` (the URL or a setting means nothing), ``DataError`` (a file says something wrong),
    ``LinkError`` (no such port, port in use) or ``NoReplyError``.
    """
    from turtlewire.robots.runner import InlineRunner, ThreadRunner

    target = _target(url, settings)
    runner: Runner = InlineRunner() if target.is_simulated else ThreadRunner()
    try:
        robot = runner.run(_connected(target, settings, notify, announce, wrap))
    except BaseException:
        runner.close()
        raise
    return _synchronous(robot, runner)


async def connect_async(
    url: str | Target = "sim:walter",
    settings: AnySettings | None = None,
    *,
    notify: Callable[[str], None] | None = None,
    announce: Callable[[str], None] = print,
    wrap: Wrap | None = None,
) -> Any:
    """``connect`` for asynchronous programs: ``async with await turtlewire.connect_async(url) as robot``.

    Returns an ``AsyncWalter``, an ``AsyncCar`` or an ``AsyncTwoEngine``.
    """
    return await _connected(_target(url, settings), settings, notify, announce, wrap)


def _target(url: str | Target, settings: AnySettings | None) -> Target:
    if not isinstance(url, str):
        return url
    from turtlewire import configuration

    return configuration.target(url, "walter" if settings is None else configuration.protocol_of(settings))


async def _connected(
    target: Target,
    settings: AnySettings | None,
    notify: Callable[[str], None] | None,
    announce: Callable[[str], None],
    wrap: Wrap | None,
) -> AsyncRobot:
    notify = notify or _warn
    end: Any = None
    link: Link
    if target.is_simulated:
        from turtlewire.links.memory import MemoryLink
        from turtlewire.simulated import simulated

        end, pace, target = simulated(target)
        settings = target.settings(settings)
        if end.settings.baud:
            settings = settings._replace(baud=end.settings.baud).checked()
        link = MemoryLink(end, target.name, pace)
    else:
        settings = target.settings(settings)
        link = await _opened(target, settings, announce)
    link = _with_faults(link, target)
    robot = _driver(wrap(link) if wrap else link, settings, notify, end)
    await robot.connect()
    return robot


async def _opened(
    target: Target, settings: AnySettings, announce: Callable[[str], None] = lambda _: None
) -> Link:
    from turtlewire.links.stream import open_port

    assert settings.baud is not None  # checked
    return await open_port(target.port, baud=settings.baud, announce=announce)


def _with_faults(link: Link, target: Target) -> Link:
    if target.faults is None:
        return link
    from turtlewire.links.faults import FaultyLink

    return FaultyLink(link, target.faults)


def _driver(link: Link, settings: AnySettings, notify: Callable[[str], None], end: Any) -> AsyncRobot:
    from turtlewire.robots import walter

    if isinstance(settings, walter.Settings):
        return walter.AsyncWalter(link, settings, notify, paper=end)
    from turtlewire.robots import car, two_engine

    if isinstance(settings, car.Settings):
        return car.AsyncCar(link, settings, notify, paper=end)
    return two_engine.AsyncTwoEngine(link, settings, notify, paper=end)


def _synchronous(robot: AsyncRobot, runner: Runner) -> Robot:
    from turtlewire.robots import walter

    if isinstance(robot, walter.AsyncWalter):
        return walter.Walter(robot, runner)
    from turtlewire.robots import car, two_engine

    if isinstance(robot, car.AsyncCar):
        return car.Car(robot, runner)
    return two_engine.TwoEngine(robot, runner)


def _warn(text: str) -> None:
    import logging

    logging.getLogger("turtlewire").warning(text)


class Stopped(NamedTuple):
    """A stop was sent: whether the robot has confirmed it, and where it says that it is, if it can say that."""

    is_confirmed: bool
    pose: Pose | None = None


def stop(url: str | Target, settings: AnySettings | None = None) -> Stopped:
    """Stop the robot at a port, from any state (S7, F13, W8), then ask it, if it is one that answers.

    Raises what ``connect`` raises for a port that cannot be opened, and ``NoReplyError`` for a robot that should answer
    and does not.
    """
    (result,) = stop_all([_target(url, settings)], settings)
    if isinstance(result, TurtlewireError):
        raise result
    return result


def stop_all(
    targets: Sequence[Target], settings: AnySettings | None = None
) -> list[Stopped | TurtlewireError]:
    """Stop several robots at the same time: for each, in order, what became of it."""
    import asyncio

    from turtlewire.robots.runner import ThreadRunner

    async def all_of_them() -> list[Stopped | TurtlewireError]:
        return await asyncio.gather(*(one(target) for target in targets))

    async def one(target: Target) -> Stopped | TurtlewireError:
        try:
            return await _stop(target, settings)
        except TurtlewireError as error:
            return error

    runner = ThreadRunner()
    try:
        return runner.run(all_of_them())
    finally:
        runner.close()


async def _stop(target: Target, settings: AnySettings | None) -> Stopped:
    from turtlewire.configuration import PTY
    from turtlewire.robots import walter

    if target.is_simulated:
        raise UsageError(f"{target.name} is a robot of its own in each process: there is nothing to stop")
    if target.port in PTY:
        raise UsageError("pty is a new port, with no robot at it yet: name the port of the robot")
    settings = target.settings(settings)._replace(reconnect_s=0.0)
    link = await _opened(target, settings)  # without faults: this is no lesson
    if target.protocol == "frame":
        return await _stop_unanswered(link, settings)
    # A robot that is booting hears nothing of this, but does not move either.
    if target.protocol == "walter":
        from turtlewire.protocols.walter.messages import EMERGENCY_STOP
    else:
        from turtlewire.protocols.simple.messages import EMERGENCY_STOP
    link.write_urgent(EMERGENCY_STOP)
    robot = _driver(link, settings, lambda _: None, None)
    async with robot:
        await robot.connect()
        if not isinstance(robot, walter.AsyncWalter):
            return Stopped(is_confirmed=True)
        answers = "Q" in robot.groups
        return Stopped(answers, await robot.reported_pose() if answers else None)


async def _stop_unanswered(link: Link, settings: AnySettings) -> Stopped:
    """F13, and nothing else: the driver would move the pen."""
    from turtlewire.protocols.frame.codec import FrameEncoder
    from turtlewire.protocols.frame.host import stop_bytes
    from turtlewire.robots import two_engine

    assert isinstance(settings, two_engine.Settings)
    assert settings.dialect is not None  # checked
    assert settings.baud is not None
    data = stop_bytes(FrameEncoder(settings.dialect))
    try:
        link.write_urgent(data)
        on_its_way_until = link.now() + len(data) * 10.0 / settings.baud
        while link.now() < on_its_way_until:
            await link.read(on_its_way_until)
    finally:
        await link.close()
    return Stopped(is_confirmed=False)
