"""``turtlewire logo``: Logo without a robot, or with one under the fingers: a prompt, scripts, tools for programs."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from turtlewire.cli import options, output, program
from turtlewire.cli.signals import Interrupted
from turtlewire.errors import UsageError

if TYPE_CHECKING:
    from pathlib import Path

    from turtlewire.cli.signals import Signals
    from turtlewire.connect import Robot
    from turtlewire.logo import ScreenTurtle

EXAMPLES = """\
examples:
  turtlewire logo --picture rose.svg --animate rose.logo 5 80
      a script: :COMMANDLINE is [5 80]; the picture is drawn before one's eyes
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "logo",
        summary="run a Logo program as a script, without a robot",
        description="Run a Logo program without a robot, or the one in the standard input (`turtlewire run` has one).",
        examples=EXAMPLES,
    )
    # PARSER: what stands behind the program belongs to the program, whatever it looks like.
    words = parser.add_argument(
        "words",
        metavar="PROGRAM.logo",
        nargs=argparse.PARSER,
        default=[],
        help="the program (- is the standard input) and its arguments",
    )
    words.required = False
    parser.add_argument(
        "--picture",
        metavar="FILE",
        action="append",
        default=[],
        help="draw it there: .svg or .png, as often as wanted",
    )
    parser.add_argument("--animate", action="store_true", help="let an .svg picture be drawn line by line")
    parser.add_argument("--seed", type=int, metavar="N", help="of RANDOM; other numbers each time without it")
    parser.add_argument(
        "--step-mm", type=options.positive, default=1.0, metavar="MM", help="length of a Logo step (1)"
    )
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, _signals: Signals) -> int:
    """Do what the arguments say."""
    pictures = _pictures(arguments)
    return _run(arguments, pictures)


def _pictures(arguments: argparse.Namespace) -> list[Path]:
    """Where pictures are wanted, each of which can be written there. Raises ``UsageError`` or ``OutputError``."""
    if not arguments.picture:
        if arguments.animate:
            raise UsageError("--animate says how a picture looks: say where by --picture FILE.svg")
        return []
    from pathlib import Path

    from turtlewire import picture

    pictures = [Path(each) for each in dict.fromkeys(arguments.picture)]
    for path in pictures:
        picture.check(path)
    if arguments.animate and not any(picture.format_of(path) == ".svg" for path in pictures):
        raise UsageError("--animate is for .svg: a .png cannot move")
    return pictures


def _run(arguments: argparse.Namespace, pictures: list[Path]) -> int:
    """Run a script. Whatever happens, the pictures show what was drawn so far."""
    import random

    from turtlewire.logo import Interpreter, ScreenTurtle
    from turtlewire.logo.values import make_list, word

    script, *rest = arguments.words or ["-"]
    source, name = program.read(script), program.name_of(script)
    turtle = ScreenTurtle()
    logo = Interpreter(turtle, output.write, random.Random(arguments.seed), arguments.step_mm)
    logo.variables["commandline"] = make_list([word(each) for each in rest])
    try:
        logo.run(source, name)
    except Interrupted as interrupted:
        if logo.position is not None:
            interrupted.add_note(f"in {logo.position.file}, line {logo.position.line}")
        raise
    finally:
        save_pictures(turtle, pictures, name, moves=arguments.animate)
    return 0


def save_pictures(turtle: ScreenTurtle | Robot, pictures: list[Path], title: str, *, moves: bool) -> None:
    """Write what was drawn. Raises ``OutputError``."""
    if not pictures:
        return
    from turtlewire import picture

    for path in pictures:
        moving = moves and picture.format_of(path) == ".svg"
        picture.save(
            turtle.trace, path, title=title, obstacles=getattr(turtle, "obstacles", ()), moves=moving
        )
