"""``turtlewire logo``: Logo without a robot, or with one under the fingers: a prompt, scripts, tools for programs."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from turtlewire.cli import logo_script, options
from turtlewire.errors import UsageError

if TYPE_CHECKING:
    from pathlib import Path

    from turtlewire.cli.signals import Signals

EXAMPLES = """\
examples:
  turtlewire logo
      a prompt, with a turtle on paper; BYE or Ctrl-D leaves, Ctrl-C stops what runs
  turtlewire logo --robot elsie
      the same with a robot, which Ctrl-C stops, too
  turtlewire logo --robot elsie --port rosa=sim:simple
      with two robots: TELL "ROSA FD 50, TELL [ELSIE ROSA] RT 90
  turtlewire logo --picture rose.svg --animate rose.logo 5 80
      a script: :COMMANDLINE is [5 80]; the picture is drawn before one's eyes
  turtlewire logo --check rose.logo tree.logo
      what is wrong with these programs, without running them
  turtlewire logo fmt rose.logo
      lay out a program
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "logo",
        summary="a Logo prompt; run, check and lay out Logo programs",
        description="Without a program: a prompt, or on no terminal the program in the standard input. "
        "With one: run it without a robot (`turtlewire run` has one).",
        examples=EXAMPLES,
    )
    # PARSER: what stands behind the program belongs to the program, whatever it looks like.
    words = parser.add_argument(
        "words",
        metavar="PROGRAM.logo",
        nargs=argparse.PARSER,
        default=[],
        help="the program (- is the standard input) and its arguments; or fmt and the programs to lay out",
    )
    words.required = False
    parser.add_argument("--check", action="store_true", help="only say what is wrong with programs")
    parser.add_argument(
        "--show-python", action="store_true", help="only show what the compiler makes of the procedures"
    )
    parser.add_argument("--json", action="store_true", help="with --check: as one JSON object")
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
    options.add_targets(parser, options.PORTS + "; for the prompt")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Do what the command line says."""
    words: list[str] = arguments.words
    if words[:1] == ["fmt"]:
        from turtlewire.cli import logo_fmt

        return logo_fmt.execute(words[1:])
    if arguments.check:
        from turtlewire.cli import logo_check

        return logo_check.execute(words, as_json=arguments.json)
    if arguments.show_python:
        from turtlewire.cli import logo_python

        return logo_python.execute(words)
    if arguments.json:
        raise UsageError("--json goes with --check; a program that runs prints what it likes")
    pictures = _pictures(arguments)
    if words or not (sys.stdin.isatty() and sys.stdout.isatty()):
        _refuse_robot(arguments)
        return logo_script.run(
            words,
            pictures,
            moves=arguments.animate,
            seed=arguments.seed,
            step_mm=arguments.step_mm,
        )
    from turtlewire.cli import logo_prompt

    return logo_prompt.execute(arguments, pictures, signals)


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


def _refuse_robot(arguments: argparse.Namespace) -> None:
    if arguments.robots or arguments.set:
        raise UsageError(
            "a robot is for the prompt here, which needs a terminal: `turtlewire run` runs programs on robots"
        )
