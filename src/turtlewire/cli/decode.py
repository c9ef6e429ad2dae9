"""``turtlewire decode PROTOCOL [FILE]``: what bytes say, one line a message or error."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.cli import options, output, wire

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterable, Iterator

    from turtlewire.capture import Record
    from turtlewire.cli.signals import Signals
    from turtlewire.protocols.catalogue import Codec, Sender
    from turtlewire.protocols.stream import Decoder, Item

DATA_IS_WRONG = 1
EXAMPLES = """\
examples:
  turtlewire decode walter traffic.bin
      what a host said; traffic.bin holds the bytes as they were on the wire
  turtlewire decode frame --from robot --dialect telemetry - < /dev/ttyUSB0
      what a robot says, live
  turtlewire decode walter recording.jsonl --json
      both directions of a recording of turtlewire monitor, for programs
  turtlewire decode walter traffic.bin | turtlewire encode walter --raw
      the same messages in their canonical bytes
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "decode",
        summary="show what bytes on a wire say",
        description="Show what bytes say, one line a message or error, each with its offset and its bytes. "
        "Files of any size, pipes while they are written, and recordings of turtlewire monitor.",
        examples=EXAMPLES,
    )
    parser.add_argument(
        "protocol", choices=wire.PROTOCOLS, metavar="PROTOCOL", help="simple, frame or walter"
    )
    parser.add_argument(
        "file", metavar="FILE", nargs="?", default="-", help="- is the standard input, as nothing is"
    )
    parser.add_argument(
        "--from",
        dest="sender",
        choices=["host", "robot"],
        help="who sent the bytes (host); of a recording, show only what this one said",
    )
    parser.add_argument("--hex", action="store_true", help="the file is hexadecimal text")
    parser.add_argument("--json", action="store_true", help="print a JSON object a line")
    wire.add_settings(parser)
    wire.intermix(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Decode until the end."""
    del signals
    codec = wire.codec(arguments)
    name = "standard input" if arguments.file == "-" else arguments.file
    with wire.reading(arguments.file) as (descriptor, size), wire.Bar(size) as bar:
        pieces: Iterable[bytes] = bar.follow(wire.pieces(descriptor, name))
        if arguments.hex:
            pieces = wire.from_hexadecimal(pieces, name)
        stream = wire.Stream(pieces, name, arguments.sender or "host")
        decoding = _Decoding(codec, stream, arguments.sender, as_json=arguments.json)
        for record in stream:
            bar.write("".join(decoding.lines(record)))
        bar.write("".join(decoding.rest()))
    if stream.torn:
        output.tell(f"turtlewire: {stream.torn}")
        return DATA_IS_WRONG
    return 0


class _Decoding:
    """Makes lines of records.

    Args:
        only: who is shown, where a recording has both; None: both.
    """

    def __init__(self, codec: Codec, stream: wire.Stream, only: Sender | None, *, as_json: bool) -> None:
        self._codec = codec
        self._stream = stream
        self._only = only
        self._as_json = as_json
        self._decoders: dict[Sender, Decoder] = {}
        self._t_ns = 0

    def lines(self, record: Record) -> Iterator[str]:
        """What a record completes."""
        from turtlewire.capture import Note

        self._t_ns = record.t_ns
        if isinstance(record, Note):
            if not self._as_json:
                yield f"{record.t_ns / 1e9:12.6f}  # {record.text}\n"
            return
        sender = record.sender
        if self._only not in (None, sender):
            return
        decoder = self._decoders.get(sender)
        if decoder is None:
            decoder = self._decoders[sender] = self._codec.decoder(sender)
        for item in decoder.receive_data(record.raw, record.t_ns / 1e9):
            yield self._line(item, sender)

    def rest(self) -> Iterator[str]:
        """What the end leaves unfinished."""
        for sender, decoder in self._decoders.items():
            for item in decoder.finish():
                yield self._line(item, sender)

    def _line(self, item: Item, sender: Sender) -> str:
        from turtlewire.protocols import forms

        t_ns = None if self._stream.header is None else self._t_ns
        if self._as_json:
            return forms.json_line(item, self._codec, sender, t_ns) + "\n"
        return forms.text_line(item, sender=None if t_ns is None else sender, t_ns=t_ns) + "\n"
