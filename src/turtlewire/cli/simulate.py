"""``turtlewire simulate ROBOT...``: simulated robots for any other program, on ptys or sockets."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from turtlewire.cli import options, output
from turtlewire.cli.signals import INTERRUPTED
from turtlewire.errors import TurtlewireError, UsageError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Sequence

    from turtlewire.cli.signals import Signals
    from turtlewire.simulator.body import Body
    from turtlewire.simulator.settings import Action, BodySettings

    Robot = Body[BodySettings]

NUMBERS = {
    "--seed": ("N", "of slip and noise (0); each further robot has one more"),
    "--slip": ("PART", "a wheel loses up to this part of its way, 0..1 (0)"),
    "--noise": ("MM", "standard deviation of a wheel's way after a metre (0)"),
    "--sag": ("PART", "of its speed that a robot has lost when its battery is empty, 0..1 (0)"),
    "--battery-s": ("SECONDS", "at full speed empty the battery (3600)"),
    "--baud": (
        "BAUD",
        "of the line; 0: bytes take no time (9600; frame 115200). If given, a host of a pty must have set the same",
    ),
    "--boot-s": ("SECONDS", "it takes to boot, and hears nothing meanwhile (0)"),
    "--watchdog-s": ("SECONDS", "of silence after which it stops by itself (never)"),
}
EXAMPLES = """\
examples:
  turtlewire simulate walter
      on a new pty, in real time; the first line printed is its path
  turtlewire simulate walter --listen socket://127.0.0.1:2000 --speed 10 --picture drawn.svg
      on a socket, ten times as fast; Ctrl-C ends it and writes the picture
  turtlewire simulate walter --basic --verbose
      one that answers no queries, and says on standard error what it does
  turtlewire simulate walter --count 40 --listen socket://0.0.0.0:2000 --picture class.png
      a class: forty robots on one floor, at ports 2000 to 2039, and one picture of what they all drew
  turtlewire simulate walter "simple?sag=0.3" "frame?dialect=telemetry" --arena room.toml
      one of each in one room, two of them with options of their own: those of a sim: URL
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "simulate",
        summary="offer simulated robots to any program",
        description="Offer simulated robots to any program, until Ctrl-C or a signal. The first lines printed are the "
        "URLs that they listen on, one for each robot.",
        examples=EXAMPLES,
    )
    parser.add_argument(
        "robots",
        metavar="ROBOT",
        nargs="+",
        help="walter, simple or frame, each with options of its own, if wanted: walter?groups=Q&start=500,0,90",
    )
    parser.add_argument(
        "--count", metavar="N", type=options.whole_positive, default=1, help="so many of each (1)"
    )
    parser.add_argument(
        "--listen",
        metavar="URL",
        default="pty",
        help="pty, or socket://127.0.0.1:0 (0: any free port); several robots get ports that follow one another",
    )
    parser.add_argument(
        "--speed", metavar="N", type=options.positive, default=1.0, help="times real time (1)"
    )
    parser.add_argument(
        "--basic", action="store_true", help="leave out every command marked * in the protocol"
    )
    parser.add_argument("--groups", metavar="CQHE", help="the groups of * commands that it has (CQHE)")
    parser.add_argument("--arena", metavar="FILE", help="walls, and where robots start (TOML or SVG)")
    parser.add_argument(
        "--spacing",
        metavar="MM",
        type=options.positive,
        default=1000.0,
        help="between robots for which the arena names no start (1000)",
    )
    parser.add_argument("--ghosts", action="store_true", help="robots drive through one another")
    for option, (metavar, text) in NUMBERS.items():
        parser.add_argument(option, metavar=metavar, help=text)
    parser.add_argument(
        "--picture",
        metavar="FILE",
        action="append",
        default=[],
        type=Path,
        help="drawn when it ends: .svg or .png, as often as wanted",
    )
    parser.add_argument(
        "--json",
        action="store_true",
        help="print the robots as JSON objects, a line for each, instead of URLs",
    )
    parser.add_argument(
        "-v", "--verbose", action="store_true", help="say on standard error what the robots do, and when"
    )
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Serve until a signal comes."""
    import asyncio

    from turtlewire import picture

    for path in arguments.picture:
        picture.check(path)
    robots = _robots(arguments)
    if arguments.verbose:
        for number, robot in enumerate(robots, 1):
            robot.events = _teller(f"robot {number}: " if len(robots) > 1 else "")
    try:
        try:
            asyncio.run(_serve(robots, arguments, signals))
        finally:
            signals.hold()
    finally:
        failures = _save_pictures(robots, arguments.picture)
    if failures:
        raise failures[0]
    output.tell(f"turtlewire: interrupted ({signals.received})")
    return INTERRUPTED


def _robots(arguments: argparse.Namespace) -> list[Robot]:
    """The robots as they are wanted, each at its place."""
    from turtlewire.simulator.company import find_starts, share_world

    names = ("groups", "arena", *(option[2:].replace("-", "_") for option in NUMBERS))
    values = {name: str(getattr(arguments, name)) for name in names if getattr(arguments, name) is not None}
    if arguments.basic:
        values["basic"] = "1"
    wanted = [name for name in arguments.robots for _ in range(arguments.count)]
    robots = [_robot(name, number, values) for number, name in enumerate(wanted)]
    if len(robots) > 1:
        robots = find_starts(robots, arguments.spacing)
    # Ghosts have nothing to do with one another: then none has to keep the others' time.
    if len(robots) > 1 and not arguments.ghosts:
        share_world(robots)
    return robots


def _robot(name: str, number: int, values: dict[str, str]) -> Robot:
    from turtlewire import configuration
    from turtlewire.simulated import simulated

    target = configuration.target(f"sim:{name}")
    seed = _seed(values.get("seed", "0"), number)
    found = simulated(target._replace(simulation={**values, "seed": seed, **target.simulation}))
    if found.pace is not None:
        raise UsageError(f"{name!r}: the pace is given by --speed, for all robots")
    driving = [option for option in found.target.overrides if option != "dialect"]
    if driving or target.faults is not None:
        raise UsageError(
            f"{name!r}: {', '.join(driving) or 'faults'} is for who drives the robot: give it there, as in "
            "run --port 'URL?window=4'"
        )
    robot: Robot = found.robot
    return robot


def _seed(text: str, number: int) -> str:
    """The seed of one of several robots; what is no number is complained of where it is read."""
    try:
        return str(int(text) + number)
    except ValueError:
        return text


def _save_pictures(robots: Sequence[Robot], paths: list[Path]) -> list[TurtlewireError]:
    """Write them all; what kept some from being written."""
    from turtlewire import picture

    failures: list[TurtlewireError] = []
    trace, *others = (robot.trace for robot in robots)
    for path in dict.fromkeys(paths):
        try:
            picture.save(trace, path, obstacles=robots[0].obstacles, others=others)
            output.tell(f"drawn {path}")
        except TurtlewireError as error:
            failures.append(error)
    for further in failures[1:]:
        output.tell(f"turtlewire: {further}")
    return failures


async def _serve(robots: Sequence[Robot], arguments: argparse.Namespace, signals: Signals) -> None:
    import asyncio

    from turtlewire.simulator.server import serve_all

    stopped = asyncio.Event()
    loop = asyncio.get_running_loop()
    # From the handler of a signal: it may interrupt the loop anywhere.
    signals.then(lambda: loop.call_soon_threadsafe(stopped.set))

    def ready(urls: list[str]) -> None:
        if not arguments.json:
            output.write("".join(f"{url}\n" for url in urls))
            return
        wanted = [name.partition("?")[0] for name in arguments.robots for _ in range(arguments.count)]
        for name, url, robot in zip(wanted, urls, robots, strict=True):
            described: dict[str, Any] = {
                "robot": name,
                "url": url,
                "start": robot.settings.first_pose._asdict(),
            }
            output.write(json.dumps(described) + "\n")

    await serve_all(
        robots,
        arguments.listen,
        speed=arguments.speed,
        bauds=_bauds(robots, arguments),
        ready=ready,
        stopped=stopped,
    )


def _bauds(robots: Sequence[Robot], arguments: argparse.Namespace) -> list[int | None]:
    """The rates that robots insist on: those that somebody has asked for. Many a host of a pty sets none."""
    from turtlewire import configuration

    wanted = [name for name in arguments.robots for _ in range(arguments.count)]
    return [
        robot.settings.baud
        if arguments.baud is not None or "baud" in configuration.target(f"sim:{name}").simulation
        else None
        for name, robot in zip(wanted, robots, strict=True)
    ]


def _teller(who: str) -> Callable[[Action], None]:
    def tell(action: Action) -> None:
        output.tell(f"{action.time_s:10.3f} s  {who}{action.what}")

    return tell
