"""``turtlewire monitor``: stands between a host and a robot, passes every byte on, and shows what they say."""

from __future__ import annotations

import os
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

from turtlewire.cli import options, output, wire
from turtlewire.cli.signals import INTERRUPTED
from turtlewire.errors import OutputError, TurtlewireError, UsageError

if TYPE_CHECKING:
    import argparse
    import queue
    from collections.abc import Callable

    from turtlewire.capture import Record
    from turtlewire.cli.signals import Signals
    from turtlewire.protocols.catalogue import Codec, Sender
    from turtlewire.protocols.stream import Decoder, Item
    from turtlewire.relay import End

# So many bytes may wait to be shown or recorded. What is beyond is left out, and that is said.
MAX_BACKLOG_BYTES = 1 << 26
# What a record that waits takes besides its bytes.
RECORD_BYTES = 200
# How long the end waits for what is left to be shown (a terminal may have been stopped) and recorded.
SHOW_S, RECORD_S = 2.0, 10.0
# When nothing comes for so long, protocols may give up a message that does not go on.
QUIET_S = 0.1
RED, GREEN, CYAN, DIM, PLAIN = "\x1b[31m", "\x1b[32m", "\x1b[36m", "\x1b[2m", "\x1b[0m"
EXAMPLES = """\
examples:
  turtlewire monitor --listen pty --port /dev/ttyUSB0 --record walter.jsonl
      prints a path: let the host's program use that instead of /dev/ttyUSB0
  turtlewire monitor --port /dev/ttyUSB0 --port /dev/ttyUSB1 --protocol frame
      between two serial adapters: the host at the first, the robot at the second
  turtlewire decode walter walter.jsonl
      what was recorded
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "monitor",
        summary="stand between a host and a robot, and show what they say",
        description="Stand between a host and a robot: pass every byte on, show both directions, record them. "
        "Nothing is ever sent that did not come from the other end.",
        examples=EXAMPLES,
    )
    parser.add_argument(
        "--port",
        metavar="URL",
        action="append",
        default=[],
        help=f"the host's end, then the robot's; with --listen, the robot's: {options.PORTS}",
    )
    parser.add_argument("--listen", metavar="URL", help="be the host's port: pty, or socket://127.0.0.1:0")
    parser.add_argument(
        "--protocol", choices=wire.PROTOCOLS, default="walter", help="what they speak (walter)"
    )
    parser.add_argument("--baud", metavar="BAUD", type=int, help="of serial ports that name none themselves")
    parser.add_argument("--record", metavar="FILE", type=Path, help="keep everything in a new file")
    parser.add_argument("--json", action="store_true", help="print a JSON object a line")
    wire.add_settings(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Pass on until a signal comes or an end is gone."""
    from turtlewire.relay import End

    if len(arguments.port) != (1 if arguments.listen else 2):
        raise UsageError(
            "monitor stands between two ports: --port A --port B, the host's first; "
            "or --listen URL for the host and one --port for the robot"
        )
    codec = wire.codec(arguments)
    baud = arguments.baud or codec.baud
    host, robot = End("host", arguments.listen or arguments.port[0]), End("robot", arguments.port[-1])
    try:
        robot.open(baud=baud)
        if arguments.listen:
            host.listen()
        else:
            host.open(baud=baud)
        return _monitor(arguments, signals, codec, host, robot, baud)
    finally:
        host.close()
        robot.close()


def _monitor(
    arguments: argparse.Namespace, signals: Signals, codec: Codec, host: End, robot: End, baud: int
) -> int:
    from turtlewire.capture import Header, Writer
    from turtlewire.relay import Relay

    followers = [Follower(Printer(codec, as_json=arguments.json), "shown", SHOW_S)]
    writer: Writer | None = None
    if arguments.record is not None:
        header = Header.of(time.time_ns(), protocol=codec.name, baud=baud, host=host.url, robot=robot.url)
        writer = Writer(arguments.record, header)
        followers.append(Follower(writer.write, "recorded", RECORD_S))

    def tell(record: Record) -> None:
        for follower in followers:
            follower.put(record)

    # The thread that passes on waits no longer than this for one that decodes.
    sys.setswitchinterval(0.0005)
    try:
        with Relay(host, robot, tell) as relay:
            try:
                for follower in followers:
                    follower.start(relay.now_ns)
                signals.then(relay.stop)
                for end in (host, robot):
                    if end.url not in (arguments.listen, *arguments.port):
                        output.tell(f"the {end.sender}'s port is {end.url}")
                relay.run()
            finally:
                signals.hold()
                for follower in followers:
                    follower.finish()
    finally:
        if writer is not None:
            writer.close()
    for follower in followers:
        if follower.failure is not None:
            raise follower.failure
    output.tell(f"turtlewire: interrupted ({signals.received})")
    return INTERRUPTED


class Printer:
    """Prints what passes, decoded, as it comes. Writes past Python's buffers: a stopped terminal blocks nobody else."""

    def __init__(self, codec: Codec, *, as_json: bool) -> None:
        self._codec = codec
        self._as_json = as_json
        self._decoders: dict[Sender, Decoder] = {
            "host": codec.decoder("host"),
            "robot": codec.decoder("robot"),
        }
        self._is_coloured = not as_json and sys.stdout.isatty() and "NO_COLOR" not in os.environ

    def __call__(self, record: Record) -> None:
        """Print what a record completes. Raises ``OutputError``."""
        from turtlewire.capture import Note

        if isinstance(record, Note):
            if not self._as_json:
                self._write([self._in_colour(DIM, f"{record.t_ns / 1e9:12.6f}  # {record.text}")])
            return
        items = self._decoders[record.sender].receive_data(record.raw, record.t_ns / 1e9)
        self._write([self._line(item, record.sender, record.t_ns) for item in items])

    def quiet(self, t_ns: int) -> None:
        """Nothing has come for a while."""
        for sender, decoder in self._decoders.items():
            if decoder.kept:
                items = decoder.receive_data(b"", t_ns / 1e9)
                self._write([self._line(item, sender, t_ns) for item in items])

    def finish(self, t_ns: int) -> None:
        """Print what the end leaves unfinished."""
        for sender, decoder in self._decoders.items():
            self._write([self._line(item, sender, t_ns) for item in decoder.finish()])

    def _line(self, item: Item, sender: Sender, t_ns: int) -> str:
        from turtlewire.protocols import forms
        from turtlewire.protocols.message import Malformed
        from turtlewire.protocols.stream import Skipped

        if self._as_json:
            return forms.json_line(item, self._codec, sender, t_ns)
        line = forms.text_line(item, sender=sender, t_ns=t_ns)
        if isinstance(item, Malformed):
            return self._in_colour(RED, line)
        if isinstance(item, Skipped):
            return self._in_colour(DIM, line)
        return self._in_colour(CYAN if sender == "host" else GREEN, line)

    def _in_colour(self, colour: str, line: str) -> str:
        return f"{colour}{line}{PLAIN}" if self._is_coloured else line

    @staticmethod
    def _write(lines: list[str]) -> None:
        data = "".join(f"{line}\n" for line in lines).encode("utf-8", "backslashreplace")
        try:
            while data:
                data = data[os.write(1, data) :]
        except OSError as error:
            raise OutputError(f"cannot write the output: {error.strerror or error}") from None


class Follower:
    """Does something with every record, in a thread of its own, so that what it takes delays nobody.

    Args:
        act: what; it may have ``quiet`` and ``finish``, as ``Printer`` has.
        done: what has then been done with a record, for messages to people.
        patience_s: how long ``finish`` waits for it.

    Attributes:
        failure: what kept it from going on; said when it happened.
    """

    def __init__(self, act: Callable[[Record], object], done: str, patience_s: float) -> None:
        import queue

        self._act = act
        self._done = done
        self._patience_s = patience_s
        self._records: queue.SimpleQueue[Record | None] = queue.SimpleQueue()
        # Counted by one thread each, so that no lock is needed.
        self._put_bytes = self._taken_bytes = 0
        self._left_out = 0
        self._now_ns: Callable[[], int] = lambda: 0
        self.failure: TurtlewireError | None = None
        self._thread = threading.Thread(target=self._run, name=f"to be {done}", daemon=True)

    def start(self, now_ns: Callable[[], int]) -> None:
        """Begin; ``now_ns`` is the clock of the records."""
        self._now_ns = now_ns
        self._thread.start()

    def put(self, record: Record) -> None:
        """Hand over a record. Never waits."""
        from turtlewire.capture import Chunk, Note

        size = RECORD_BYTES + (len(record.raw) if isinstance(record, Chunk) else 0)
        if self.failure is not None:
            return
        if self._put_bytes - self._taken_bytes + size > MAX_BACKLOG_BYTES:
            self._left_out += 1
            return
        if self._left_out:
            text = f"{self._left_out} records before this were not {self._done}: that took too long"
            self._left_out = 0
            self._put_bytes += RECORD_BYTES
            self._records.put(Note(record.t_ns, text))
        self._put_bytes += size
        self._records.put(record)

    def finish(self) -> None:
        """Wait until everything is done, if that does not take too long."""
        self._records.put(None)
        self._thread.join(self._patience_s)
        if self._thread.is_alive():
            output.tell(f"turtlewire: not everything was {self._done}: that took too long")

    def _run(self) -> None:
        try:
            while (record := self._next()) is not None:
                self._act(record)
                self._taken_bytes += RECORD_BYTES + len(getattr(record, "raw", b""))
            if isinstance(self._act, Printer):
                self._act.finish(self._now_ns())
        except TurtlewireError as error:
            self.failure = error
            output.tell(
                f"turtlewire: {error}. Nothing more is {self._done}; bytes are passed on until Ctrl-C"
            )

    def _next(self) -> Record | None:
        if not isinstance(self._act, Printer):
            return self._records.get()
        import queue

        while True:
            try:
                return self._records.get(timeout=QUIET_S)
            except queue.Empty:
                self._act.quiet(self._now_ns())
