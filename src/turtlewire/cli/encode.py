"""``turtlewire encode PROTOCOL TEXT...``: the bytes of messages."""

from __future__ import annotations

import io
import sys
from typing import TYPE_CHECKING

from turtlewire.cli import options, output, wire
from turtlewire.errors import DataError, MessageError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterable, Iterator

    from turtlewire.cli.signals import Signals
    from turtlewire.protocols.catalogue import Codec
    from turtlewire.protocols.message import AnyMessage

MAX_LINE_BYTES = 1 << 20
EXAMPLES = """\
examples:
  turtlewire encode walter "forward distance_half_mm=200" "right angle_deg=90"
      46 00 C8 0D and 52 00 5A 0D
  turtlewire encode simple drive_forward 120
      the names of the fields may be left out
  turtlewire encode frame "engine_forward 0 200; engine_forward 1 200" --raw > /dev/ttyUSB0
      both messages in one frame
  turtlewire decode walter traffic.bin --json | turtlewire encode walter --json --raw
      lines of text or JSON from the standard input: what decode printed
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "encode",
        summary="make the bytes of messages",
        description="Make the bytes of messages, given in their text form, or line by line on the standard input.",
        examples=EXAMPLES,
    )
    parser.add_argument(
        "protocol", choices=wire.PROTOCOLS, metavar="PROTOCOL", help="simple, frame or walter"
    )
    parser.add_argument(
        "text", metavar="TEXT", nargs="*", help="messages; without any, lines from the standard input"
    )
    parser.add_argument("--raw", action="store_true", help="the bytes themselves instead of hexadecimal")
    parser.add_argument(
        "--json", action="store_true", help="lines of JSON come, as decode --json prints them"
    )
    wire.add_settings(parser)
    wire.intermix(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Encode everything."""
    del signals
    codec = wire.codec(arguments)
    if arguments.raw and isinstance(sys.stdout, io.TextIOWrapper):
        # Every byte is a character of Latin-1: so the bytes take the way that copes with whatever ends them.
        sys.stdout.reconfigure(encoding="latin-1", newline="")
    if arguments.text:
        messages: list[AnyMessage | None] = [codec.parse(text) for text in _texts(arguments.text, codec)]
        # All of them are encoded before any byte leaves.
        data = [codec.encode(message) for message in messages if message is not None]
        _write(data, raw=arguments.raw)
        return 0
    left_out = 0
    for lines in _lines(wire.pieces(0, "standard input")):
        data = []
        try:
            for number, line in lines:
                message = _read(codec, line, number, as_json=arguments.json)
                if message is None:
                    left_out += bool(line.strip())
                else:
                    data.append(message)
        finally:
            _write(data, raw=arguments.raw)
    if left_out:
        output.tell(
            f"turtlewire: {left_out} line{'s' * (left_out > 1)} left out: no message, or one that no host sends"
        )
    return 0


def _texts(words: list[str], codec: Codec) -> Iterator[str]:
    """The messages in the arguments: each begins with a name, and a shell may have split it at blanks."""
    text = ""
    for word in words:
        if text and not text.endswith(";") and _begins(word, text, codec):
            yield text
            text = word
        else:
            text = f"{text} {word}".strip()
    yield text


def _begins(word: str, text: str, codec: Codec) -> bool:
    """Whether a message begins with a word, rather than that one more goes to the text before it."""
    first = word.split()[:1]
    if first and first[0].rstrip(";").lower() in codec.names():
        return True
    if not word[:1].isalpha() or "=" in word:
        return False
    try:
        codec.parse(text)
    except MessageError:
        return False
    return True  # that one is complete, so this must be meant for a name


def _lines(pieces: Iterable[bytes]) -> Iterator[list[tuple[int, str]]]:
    """Whole lines with their numbers, as many as have come at once. Raises ``DataError``."""
    rest = b""
    number = 0
    for piece in pieces:
        *lines, rest = (rest + piece).split(b"\n")
        if len(rest) > MAX_LINE_BYTES:
            raise DataError(f"line {number + len(lines) + 1} of the standard input is too long for a message")
        yield [(number + n, line.decode("utf-8", "replace")) for n, line in enumerate(lines, 1)]
        number += len(lines)
    yield [(number + 1, rest.decode("utf-8", "replace"))]


def _read(codec: Codec, line: str, number: int, *, as_json: bool) -> bytes | None:
    from turtlewire.protocols import forms

    try:
        message = forms.read_json_line(line, codec) if as_json else forms.read_text_line(line, codec)
        return None if message is None else codec.encode(message)
    except DataError as error:
        error.add_note(f"It stands in line {number} of the standard input.")
        raise


def _write(data: list[bytes], *, raw: bool) -> None:
    from turtlewire.protocols.forms import hexadecimal

    if raw:
        output.write(b"".join(data).decode("latin-1"))
        output.finish()
    else:
        output.write("".join(f"{hexadecimal(each)}\n" for each in data))
