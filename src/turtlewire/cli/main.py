"""``turtlewire``: the command line. One module a command; this one has what they share."""

from __future__ import annotations

import sys

from turtlewire.cli import output
from turtlewire.cli.signals import INTERRUPTED, Interrupted, Signals
from turtlewire.errors import TurtlewireError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from types import TracebackType

USAGE = 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code."""
    output.prepare()
    sys.excepthook = _tell_of_bug
    is_program = arguments is None
    arguments = sys.argv[1:] if arguments is None else arguments
    if not arguments:
        from turtlewire.cli import command_line

        output.tell(command_line.help_text())
        return USAGE
    execute = _command(arguments)
    with Signals() as signals:
        try:
            try:
                code = execute(signals)
            finally:
                output.finish()
        except TurtlewireError as error:
            output.tell("\n".join([f"turtlewire: {error}", *getattr(error, "__notes__", [])]))
            return error.exit_code
        except Interrupted as error:
            output.tell("\n".join([f"turtlewire: interrupted ({error})", *getattr(error, "__notes__", [])]))
            return INTERRUPTED
    if is_program and script_of(arguments) is not None:
        output.leave(code)
    return code


def _command(arguments: Sequence[str]) -> Callable[[Signals], int]:
    script = script_of(arguments)
    if script is not None:
        from turtlewire.cli import logo_script

        return lambda _signals: logo_script.run(script)
    from turtlewire.cli import command_line

    parsed = command_line.parse(arguments)

    def execute(signals: Signals) -> int:
        code: int = parsed.execute(parsed, signals)
        return code

    return execute


def script_of(arguments: Sequence[str]) -> Sequence[str] | None:
    """The program and its arguments in ``logo PROGRAM ARGUMENTS...``; ``None`` for any other command line.

    So scripts are mostly started, and a parser takes longer to load than they take to run. Whatever may be an option is
    the parser's.
    """
    command, *words = arguments
    is_script = (
        command == "logo" and words and words[0] != "fmt" and not any(w.startswith("-") for w in words)
    )
    return words if is_script else None


def _tell_of_bug(kind: type[BaseException], error: BaseException, where: TracebackType | None) -> None:
    """An exception that nobody raised on purpose: a paragraph too; the traceback with ``python -X dev``."""
    if sys.flags.dev_mode:
        sys.__excepthook__(kind, error, where)
        return
    import traceback

    frames = traceback.extract_tb(where)
    place = f" ({frames[-1].filename}, line {frames[-1].lineno})" if frames else ""
    output.tell(
        f"turtlewire: this is a bug in turtlewire, please report it: {kind.__name__}: {error}{place}. "
        "With PYTHONDEVMODE=1 in the environment it tells more"
    )
