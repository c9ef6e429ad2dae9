"""What passes on a robot's wire, both directions, decoded: the last so many messages, for pages that watch it."""

from __future__ import annotations

import threading
import time
from collections import deque
from itertools import islice
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

from turtlewire import capture
from turtlewire.errors import LinkClosedError
from turtlewire.helm.sight import codec, phrases, title
from turtlewire.helm.wire import Tap
from turtlewire.protocols import forms
from turtlewire.protocols.catalogue import SENDERS, Packet
from turtlewire.protocols.message import Decoded, Malformed

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.configuration import Target
    from turtlewire.links.link import Link
    from turtlewire.protocols.catalogue import Sender
    from turtlewire.protocols.stream import Decoder, Item

# How many messages are kept: some minutes of a busy line, and a few megabytes.
MAX_LINES = 10_000
Kind: TypeAlias = Literal["message", "error", "skipped", "note"]


class Phrase(NamedTuple):
    """What a host says in one breath from whatever state (W7, W8, S7): more than a message, and with zeros in it."""

    offset: int
    raw: bytes
    text: str


class Line(NamedTuple):
    """One thing that passed.

    Attributes:
        number: counts from 0, for ever.
        t_ns: when its last byte passed, nanoseconds since the console was started.
        sender: who sent it; of a note, None.
        offset: where in all that this one has sent its first byte stands, since the link was opened.
        what: the message, the error, the bytes between; or a note about the link.
    """

    number: int
    t_ns: int
    sender: Sender | None
    offset: int
    what: Item | Phrase | str

    @property
    def kind(self) -> Kind:
        """What kind of thing it is."""
        if isinstance(self.what, str):
            return "note"
        if isinstance(self.what, Decoded | Phrase):
            return "message"
        return "error" if isinstance(self.what, Malformed) else "skipped"

    @property
    def raw(self) -> bytes:
        """Its bytes."""
        return b"" if isinstance(self.what, str) else self.what.raw

    def as_json(self) -> dict[str, Any]:
        """For pages and programs: as ``turtlewire decode --json`` has it, and in words."""
        return {
            "number": self.number,
            "time_s": self.t_ns / 1e9,
            "from": self.sender,
            "offset": self.offset,
            "raw": forms.hexadecimal(self.raw),
            "kind": self.kind,
            "text": self._text(),
            "names": self._names(),
        }

    def _text(self) -> str:
        match self.what:
            case str(text) | Phrase(text=text):
                return text
            case Decoded(message=message):
                return str(message)
            case _:
                return self.what.reason

    def _names(self) -> list[str]:
        """Of the messages that it consists of."""
        if not isinstance(self.what, Decoded):
            return []
        message = self.what.message
        if isinstance(message, Packet):
            return [each.name() for each in (*message.messages, *message.refused)] or [message.name()]
        return [message.name()]


class Piece(NamedTuple):
    """Some lines in a row, and how many of those that were asked for are not there any more (or were left out)."""

    lines: list[Line]
    lost: int

    @property
    def following(self) -> int | None:
        """The number of the line behind the last one; None: there is none in here."""
        return self.lines[-1].number + 1 if self.lines else None


class Traffic:
    """The last of what passed. One thread hears it; any may read it.

    Args:
        target: the robot. Raises ``DataError`` for a dialect that cannot be read.
        clock: nanoseconds on the wall, that do not go back.
        max_lines: how many are kept.
    """

    def __init__(
        self, target: Target, clock: Callable[[], int] = time.monotonic_ns, max_lines: int = MAX_LINES
    ) -> None:
        self.codec = codec(target)
        self._phrases = sorted(phrases(target.protocol).items(), key=lambda phrase: -len(phrase[0]))
        self._title = title(target)
        self._clock = clock
        self._started_ns, self._started_unix_ns = clock(), time.time_ns()
        self._lock = threading.Lock()
        self._lines: deque[Line] = deque(maxlen=max_lines)
        self._count = 0
        self._begin()

    def _begin(self) -> None:
        """A link is opened: nothing of before belongs to what comes."""
        self._decoders: dict[Sender, Decoder] = {sender: self.codec.decoder(sender) for sender in SENDERS}

    # ------------------------------------------------------------------ heard

    def listen(self, link: Link) -> Link:
        """Hear what passes on this link from now on; use the one that this returns."""
        self._begin()
        return _Heard(link, self)

    def passed(self, data: bytes, sender: Sender, now: float) -> None:
        """Bytes passed; ``b""`` lets time pass."""
        decoder = self._decoders[sender]
        while sender == "host" and data and not decoder.kept:
            phrase, meaning = next((each for each in self._phrases if data.startswith(each[0])), (b"", ""))
            if not phrase:
                break
            at = decoder.offset
            decoder.receive_data(phrase, now)
            self._add(sender, [Phrase(at, phrase[: decoder.offset - at], meaning)])
            data = data[len(phrase) :]
        self._add(sender, decoder.receive_data(data, now))

    def note(self, text: str) -> None:
        """Something happened to the link: what has begun does not go on."""
        for sender, decoder in self._decoders.items():
            self._add(sender, decoder.finish())
        self._begin()
        self._add(None, [text])

    def _add(self, sender: Sender | None, things: list[Any]) -> None:
        if not things:
            return
        t_ns = self._clock() - self._started_ns
        with self._lock:
            for what in things:
                offset = 0 if isinstance(what, str) else what.offset
                self._lines.append(Line(self._count, t_ns, sender, offset, what))
                self._count += 1

    # ------------------------------------------------------------------ read

    @property
    def count(self) -> int:
        """How many lines there have ever been: the number of the next one."""
        return self._count

    def read(self, since: int, limit: int) -> Piece:
        """The first lines from a number on, at most so many; what is gone is counted."""
        return self._piece(since, limit, is_newest=False)

    def newest(self, since: int, limit: int) -> Piece:
        """The last lines from a number on, at most so many; what is gone or left out is counted."""
        return self._piece(since, limit, is_newest=True)

    def _piece(self, since: int, limit: int, *, is_newest: bool) -> Piece:
        with self._lock:
            oldest = self._count - len(self._lines)
            first = max(since, oldest)
            if is_newest:
                first = max(first, self._count - limit)
            lines = list(islice(self._lines, first - oldest, first - oldest + limit))
        return Piece(lines, max(0, first - since) if lines else 0)

    def recording(self) -> bytes:
        """All that is kept, in the format of recordings, which ``turtlewire decode`` reads."""
        with self._lock:
            lines = list(self._lines)
        header = capture.Header.of(
            self._started_unix_ns,
            protocol=self.codec.name,
            baud=self.codec.baud,
            host="turtlewire",
            robot=self._title,
        )
        records = [capture.encode_header(header)]
        if lines and lines[0].number:
            records.append(
                capture.encode_record(
                    capture.Note(lines[0].t_ns, f"{lines[0].number} messages before these were not kept")
                )
            )
        for line in lines:
            record: capture.Record
            if isinstance(line.what, str) or line.sender is None:
                record = capture.Note(line.t_ns, line.as_json()["text"])
            else:
                record = capture.Chunk(line.t_ns, line.sender, line.raw)
            records.append(capture.encode_record(record))
        return b"".join(records)


class _Heard(Tap):
    """A link, and how it goes with it."""

    def __init__(self, link: Link, traffic: Traffic) -> None:
        super().__init__(link, traffic)
        self._traffic = traffic
        self._has_ended = False

    async def read(self, until: float) -> bytes:
        """Wait for bytes."""
        try:
            return await super().read(until)
        except LinkClosedError as error:
            if not self._has_ended:
                self._has_ended = True
                self._traffic.note(str(error))
            raise

    async def reopen(self) -> None:
        """Open it again."""
        await super().reopen()
        self._has_ended = False
        self._traffic.note("the link is open again")
