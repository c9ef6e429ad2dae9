"""``turtlewire logo PROGRAM``: a script, without a robot."""

from __future__ import annotations

from turtlewire.cli import output, program
from turtlewire.cli.signals import Interrupted

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path
    from random import Random

    from turtlewire.logo import Interpreter, ScreenTurtle
    from turtlewire.turtle import Turtle


def run(
    words: Sequence[str],
    pictures: Sequence[Path] = (),
    *,
    moves: bool = False,
    seed: int | None = None,
    step_mm: float = 1.0,
) -> int:
    """Run a script. Whatever happens, the pictures show what was drawn so far.

    Args:
        words: the program and its arguments; without any, the program is the standard input.
        pictures: where pictures are wanted.
        moves: whether .svg pictures are drawn line by line.
        seed: of RANDOM; ``None``: other numbers each time.
        step_mm: the length of a Logo step.
    """
    from turtlewire.logo.screen import ScreenTurtle

    script, *rest = words or ["-"]
    source, name = program.read(script), program.name_of(script)
    turtle = ScreenTurtle()
    logo = interpreter(turtle, rest, seed, step_mm)
    try:
        logo.run(source, name)
    except Interrupted as interrupted:
        if logo.position is not None:
            interrupted.add_note(f"in {logo.position.file}, line {logo.position.line}")
        raise
    finally:
        save_pictures(turtle, pictures, name, moves=moves)
    return 0


def interpreter(
    turtle: Turtle | Mapping[str, Turtle], command_line: list[str], seed: int | None, step_mm: float
) -> Interpreter:
    """What runs Logo."""
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.values import make_list, word

    def chance() -> Random:
        import random  # few programs throw dice

        return random.Random(seed)

    program.bound_memory()
    logo = Interpreter(turtle, output.write, chance, step_mm, compiled_at=program.compiled_at())
    logo.variables["commandline"] = make_list([word(each) for each in command_line])
    return logo


def save_pictures(turtle: ScreenTurtle, pictures: Sequence[Path], title: str, *, moves: bool) -> None:
    """Write what was drawn. Raises ``OutputError``."""
    if not pictures:
        return
    from turtlewire import picture

    for path in pictures:
        moving = moves and picture.format_of(path) == ".svg"
        picture.save(turtle.trace, path, title=title, moves=moving)
