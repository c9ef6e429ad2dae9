"""``turtlewire simulate ROBOT``: a simulated robot for any other program, on a pty or a socket."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlencode

from turtlewire.cli import options

if TYPE_CHECKING:
    import argparse

    from turtlewire.simulator.walter import SimulatedWalter

INTERRUPTED = 130
NUMBERS = {
    "--seed": ("SEED", "of slip and noise (0)"),
    "--slip": ("PART", "a wheel loses up to this part of its way, 0..1 (0)"),
    "--noise": ("MM", "standard deviation of a wheel's way after a metre (0)"),
    "--baud": ("BAUD", "of the line; 0: bytes take no time (9600)"),
    "--boot-s": ("SECONDS", "it takes to boot, and hears nothing meanwhile (0)"),
    "--watchdog-s": ("SECONDS", "of silence after which it stops by itself (never)"),
}


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = commands.add_parser(
        "simulate",
        help="offer a simulated robot to any program",
        description="Offer a simulated robot to any program. The first line printed is the URL that it listens on.",
    )
    parser.add_argument("robot", choices=["walter"], help="what robot")
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
        help="drawn when it ends (.svg, .png)",
    )
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Serve until a signal comes."""
    from turtlewire import picture
    from turtlewire.connect import simulated

    for path in arguments.picture:
        picture.check(path)
    names = ("groups", "arena", *(option[2:].replace("-", "_") for option in NUMBERS))
    values = {name: getattr(arguments, name) for name in names if getattr(arguments, name) is not None}
    if arguments.basic:
        values["basic"] = "1"
    robot = simulated(f"sim:{arguments.robot}?{urlencode(values)}")
    try:
        asyncio.run(_serve(robot, arguments))
    finally:
        for path in arguments.picture:
            picture.save(robot.trace, path, walls=robot.walls)
            print(f"drawn {path}", file=sys.stderr)
    return INTERRUPTED


async def _serve(robot: SimulatedWalter, arguments: argparse.Namespace) -> None:
    from turtlewire.simulator.server import serve

    stopped = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        with contextlib.suppress(NotImplementedError):  # Windows: KeyboardInterrupt does it
            loop.add_signal_handler(number, stopped.set)
    await serve(
        robot,
        arguments.listen,
        speed=arguments.speed,
        ready=lambda url: print(url, flush=True),
        stopped=stopped,
    )
