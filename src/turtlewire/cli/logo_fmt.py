"""``turtlewire logo fmt``: lay out programs, in place."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from turtlewire import whole_file
from turtlewire.cli import options, output, program
from turtlewire.errors import DataError, OutputError

EXAMPLES = """\
examples:
  turtlewire logo fmt rose.logo tree.logo
      lay out these programs; says which have changed
  turtlewire logo fmt --check *.logo
      only say which would change; exit code 1 if there are any
  turtlewire logo fmt - < rose.logo
      from the standard input to the standard output
"""
DIFFERS = 1


def execute(words: list[str]) -> int:
    """Lay out the programs that the command line names."""
    parser = argparse.ArgumentParser(
        prog="turtlewire logo fmt",
        description="Lay out Logo programs: indentation, spaces around operators. What they mean never changes.",
        epilog=EXAMPLES,
        formatter_class=options.Formatter,
    )
    parser.add_argument(
        "programs", metavar="PROGRAM.logo", nargs="+", help="a program; - is the standard input"
    )
    parser.add_argument("--check", action="store_true", help="change nothing, say what would change")
    arguments = parser.parse_args(words)
    code = 0
    for name in arguments.programs:
        if _lay_out(name, only_check=arguments.check):
            code = DIFFERS
    return code if arguments.check else 0


def _lay_out(name: str, *, only_check: bool) -> bool:
    """Lay out a program; whether it was not so before. Raises ``DataError`` or ``OutputError``."""
    from turtlewire.logo.formatting import formatted

    data = sys.stdin.buffer.read() if name == "-" else _bytes(name)
    text = program.text_of(data, program.name_of(name))
    laid_out = formatted(text, program.name_of(name))
    if name == "-" and not only_check:
        output.write(laid_out)
    elif laid_out == text:
        return False
    elif only_check:
        output.write(f"{program.name_of(name)} would change\n")
    else:
        # As it was: with the marks that some editors put into files.
        newline, mark = (
            ("\r\n" if b"\r\n" in data else "\n"),
            ("\ufeff" if data.startswith(b"\xef\xbb\xbf") else ""),
        )
        try:
            whole_file.replace(Path(name), (mark + laid_out.replace("\n", newline)).encode())
        except OSError as error:
            raise OutputError(f"cannot write the program {name}: {error.strerror or error}") from error
        output.write(f"{name} changed\n")
    return laid_out != text


def _bytes(name: str) -> bytes:
    try:
        return Path(name).read_bytes()
    except OSError as error:
        raise DataError(f"cannot read the program {name}: {error.strerror}") from error
