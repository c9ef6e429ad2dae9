"""``turtlewire simulate ROBOT``: a simulated robot for any other program, on a pty or a socket."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from turtlewire.cli import options, output
from turtlewire.cli.signals import INTERRUPTED
from turtlewire.errors import TurtlewireError

if TYPE_CHECKING:
    import argparse

    from turtlewire.cli.signals import Signals
    from turtlewire.simulator.walter import Action, SimulatedWalter

NUMBERS = {
    "--seed": ("N", "of slip and noise (0)"),
    "--slip": ("PART", "a wheel loses up to this part of its way, 0..1 (0)"),
    "--noise": ("MM", "standard deviation of a wheel's way after a metre (0)"),
    "--baud": ("BAUD", "of the line; 0: bytes take no time (9600)"),
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
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "simulate",
        summary="offer a simulated robot to any program",
        description="Offer a simulated robot to any program, until Ctrl-C or a signal. "
        "The first line printed is the URL that it listens on.",
        examples=EXAMPLES,
    )
    parser.add_argument("robot", choices=["walter", "simple", "frame"], help="what robot")
    parser.add_argument(
        "--listen", metavar="URL", default="pty", help="pty, or socket://127.0.0.1:0 (0: any free port)"
    )
    parser.add_argument(
        "--speed", metavar="N", type=options.positive, default=1.0, help="times real time (1)"
    )
    parser.add_argument(
        "--basic", action="store_true", help="leave out every command marked * in the protocol"
    )
    parser.add_argument("--groups", metavar="CQHE", help="the groups of * commands that it has (CQHE)")
    parser.add_argument("--arena", metavar="FILE", help="walls, and where it starts (TOML)")
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
        "-v", "--verbose", action="store_true", help="say on standard error what the robot does, and when"
    )
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Serve until a signal comes."""
    import asyncio
    from urllib.parse import urlencode

    from turtlewire import picture
    from turtlewire.connect import simulated

    for path in arguments.picture:
        picture.check(path)
    names = ("groups", "arena", *(option[2:].replace("-", "_") for option in NUMBERS))
    values = {name: getattr(arguments, name) for name in names if getattr(arguments, name) is not None}
    if arguments.basic:
        values["basic"] = "1"
    robot = simulated(f"sim:{arguments.robot}?{urlencode(values)}")
    if arguments.verbose:
        robot.events = _tell_action
    try:
        try:
            asyncio.run(_serve(robot, arguments, signals))
        finally:
            signals.hold()
    finally:
        failures = _save_pictures(robot, arguments.picture)
    if failures:
        raise failures[0]
    output.tell(f"turtlewire: interrupted ({signals.received})")
    return INTERRUPTED


def _save_pictures(robot: SimulatedWalter, paths: list[Path]) -> list[TurtlewireError]:
    """Write them all; what kept some from being written."""
    from turtlewire import picture

    failures: list[TurtlewireError] = []
    for path in dict.fromkeys(paths):
        try:
            picture.save(robot.trace, path, obstacles=robot.obstacles)
            output.tell(f"drawn {path}")
        except TurtlewireError as error:
            failures.append(error)
    for further in failures[1:]:
        output.tell(f"turtlewire: {further}")
    return failures


async def _serve(robot: SimulatedWalter, arguments: argparse.Namespace, signals: Signals) -> None:
    import asyncio

    from turtlewire.simulator.server import serve

    stopped = asyncio.Event()
    loop = asyncio.get_running_loop()
    # From the handler of a signal: it may interrupt the loop anywhere.
    signals.then(lambda: loop.call_soon_threadsafe(stopped.set))
    await serve(robot, arguments.listen, speed=arguments.speed, ready=_tell_url, stopped=stopped)


def _tell_url(url: str) -> None:
    output.write(f"{url}\n")


def _tell_action(action: Action) -> None:
    output.tell(f"{action.time_s:10.3f} s  {action.what}")
