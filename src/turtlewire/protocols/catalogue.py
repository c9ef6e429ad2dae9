"""Every protocol by its name: what it can say, how to encode that, and how to decode either direction.

The one place that knows all protocols, for tools that take the name of one from their user. Nothing is imported
before it is asked for.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple

from turtlewire.errors import MessageError, UsageError
from turtlewire.protocols.message import AnyMessage, Decoded, Malformed, parse
from turtlewire.protocols.stream import Decoder, Received, Source

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from turtlewire.protocols.frame.codec import Item as FrameItem
    from turtlewire.protocols.frame.dialect import Dialect

Sender = Literal["host", "robot"]
SENDERS: tuple[Sender, ...] = ("host", "robot")
MODES = ("logo", "direct")


class Codec(ABC):
    """One protocol, with its settings.

    Attributes:
        name: of the protocol.
        baud: of its line, where nobody says otherwise.
    """

    name: ClassVar[str]
    baud: int

    @abstractmethod
    def types(self, sender: Sender) -> tuple[type[AnyMessage], ...]:
        """What the host, or the robot, can say."""

    @abstractmethod
    def encode(self, message: AnyMessage) -> bytes:
        """The bytes of a message. Raises ``MessageError`` if the wire cannot carry it."""

    @abstractmethod
    def decoder(self, sender: Sender) -> Decoder:
        """A decoder of what the host, or the robot, says."""

    def parse(self, text: str) -> AnyMessage:
        """The message of a text form, ``forward distance_half_mm=200``. Raises ``MessageError``."""
        return parse(text, self._all_types())

    def names(self) -> frozenset[str]:
        """What a text form may begin with."""
        return frozenset(message_type.name() for message_type in self._all_types())

    def to_json(self, message: AnyMessage) -> dict[str, object]:
        """The message's JSON form: its name and its fields."""
        return {"name": message.name(), "fields": {f.name: getattr(message, f.name) for f in message.FIELDS}}

    def from_json(self, form: object) -> AnyMessage:
        """The message of a JSON form. Raises ``MessageError``."""
        match form:
            case {"name": str(name), **rest} if isinstance(fields := rest.get("fields", {}), dict):
                return self._from_fields(name, fields)
        raise MessageError(f"a message must have a name and fields, and {form!r} has not")

    def _from_fields(self, name: str, given: dict[str, object]) -> AnyMessage:
        known = {message_type.name(): message_type for message_type in self._all_types()}
        if name not in known:
            raise MessageError(f"there is no message {name!r}; known are {', '.join(known)}")
        fields = {field.name: field for field in known[name].FIELDS}
        if given.keys() != fields.keys():
            raise MessageError(
                f"{name} must have {'the fields ' + ' '.join(fields) if fields else 'no fields'}, "
                f"and has {' '.join(given) or 'none'}"
            )
        return known[name](**given).check()

    def _all_types(self) -> tuple[type[AnyMessage], ...]:
        return tuple(dict.fromkeys((*self.types("host"), *self.types("robot"))))


class Walter(Codec):
    """WALTER: ``mode`` is what a decoder of the host's bytes begins in."""

    name = "walter"

    def __init__(self, mode: str = "logo") -> None:
        from turtlewire.protocols.walter.messages import BAUD

        self.baud = BAUD
        self._mode = mode

    def types(self, sender: Sender) -> tuple[type[AnyMessage], ...]:
        """Commands and keys, or replies and events."""
        from turtlewire.protocols.walter.messages import DIRECT_KEYS, LOGO_COMMANDS, ROBOT_MESSAGES, EmptyLine

        return (*LOGO_COMMANDS, *DIRECT_KEYS) if sender == "host" else (*ROBOT_MESSAGES, EmptyLine)

    def encode(self, message: AnyMessage) -> bytes:
        """Letters, arguments, RET."""
        from turtlewire.protocols.walter.codec import encode
        from turtlewire.protocols.walter.messages import WalterMessage

        if not isinstance(message, WalterMessage):
            raise _foreign(message, self)
        return encode(message)

    def decoder(self, sender: Sender) -> Decoder:
        """By length; it follows changes of mode."""
        from turtlewire.protocols.walter.codec import CommandDecoder, Mode, ReplyDecoder

        decoder = CommandDecoder(Mode(self._mode)) if sender == "host" else ReplyDecoder()
        return Decoder(
            Source(
                lambda data, _: decoder.receive_data(data),
                lambda: decoder.pending,
                between="the line feed after a RET",
            )
        )


class Simple(Codec):
    """Enkelt protokoll."""

    name = "simple"

    def __init__(self) -> None:
        from turtlewire.protocols.simple.messages import BAUD

        self.baud = BAUD

    def types(self, sender: Sender) -> tuple[type[AnyMessage], ...]:
        """Commands, or the two replies."""
        from turtlewire.protocols.simple.messages import COMMANDS, REPLIES

        return COMMANDS if sender == "host" else REPLIES

    def encode(self, message: AnyMessage) -> bytes:
        """Seven bytes, or one."""
        from turtlewire.protocols.simple.codec import encode
        from turtlewire.protocols.simple.messages import SimpleMessage

        if not isinstance(message, SimpleMessage):
            raise _foreign(message, self)
        return encode(message)

    def decoder(self, sender: Sender) -> Decoder:
        """It counts to seven, or to one."""
        from turtlewire.protocols.simple.codec import CommandDecoder, ReplyDecoder

        if sender == "robot":
            replies = ReplyDecoder()
            return Decoder(Source(lambda data, _: replies.receive_data(data), lambda: 0))
        commands = CommandDecoder()
        return Decoder(Source(lambda data, _: commands.receive_data(data), lambda: len(commands.pending)))


class Packet(AnyMessage, frozen=True):
    """A frame of frame: what goes over the wire together.

    Attributes:
        seq: its sequence number; None: the next one.
        messages: what it says.
        refused: messages in it that break their restriction (F4): no host sends them.
        order, lost: how its number follows the one before (F6): "", "gap" (and how many are missing), "repeat",
            "restart".
    """

    seq: int | None
    messages: tuple[AnyMessage, ...] = ()
    refused: tuple[AnyMessage, ...] = ()
    order: str = ""
    lost: int = 0

    @classmethod
    def name(cls) -> str:
        """It is called a frame."""
        return "frame"

    def __str__(self) -> str:
        """``frame seq=3; engine_forward engine_id=0 speed=200; ...``, and in brackets what is odd about it."""
        parts = ["frame" if self.seq is None else f"frame seq={self.seq}", *map(str, self.messages)]
        parts += [f"refused {message}" for message in self.refused]
        odd = (
            f" ({self.lost} lost before it)"
            if self.order == "gap"
            else f" ({self.order})"
            if self.order
            else ""
        )
        return "; ".join(parts) + odd


class Frame(Codec):
    """Serial Protocol 0.1, in a dialect: each item is a frame, a ``Packet``."""

    name = "frame"

    def __init__(
        self, dialect: str | Path | Dialect = "0.1", crc: str | None = None, coverage: str | None = None
    ) -> None:
        from turtlewire.protocols.frame import dialect as dialects

        if isinstance(dialect, dialects.Dialect):
            made = dialect
        elif dialect in dialects.SHIPPED:
            made = dialects.shipped(str(dialect))
        else:
            made = dialects.load(dialect)
        self._dialect = made.configured(crc=crc, coverage=coverage)
        self.baud = made.baud
        self._seq = 0

    def types(self, sender: Sender) -> tuple[type[AnyMessage], ...]:
        """What a dialect knows in this direction."""
        return tuple(e.message_type for e in self._dialect.entries if e.goes(_DIRECTIONS[sender]))

    def encode(self, message: AnyMessage) -> bytes:
        """One frame, of a packet or of a lone message; without a number it takes the next."""
        from turtlewire.protocols.frame.codec import frame_bytes
        from turtlewire.protocols.frame.message import MAX_PAYLOAD

        packet = message if isinstance(message, Packet) else Packet(None, (message,))
        if packet.refused:
            raise MessageError(f"{packet.refused[0]} breaks its restriction: it cannot be sent")
        payload = b"".join(self._packed(packet.messages))
        if len(payload) > MAX_PAYLOAD:
            raise MessageError(
                f"a frame carries {MAX_PAYLOAD} bytes of messages, and these are {len(payload)}: make two of it"
            )
        seq = self._seq if packet.seq is None else packet.seq
        self._seq = (seq + 1) % 256
        return frame_bytes(self._dialect, seq, payload)

    def _packed(self, messages: tuple[AnyMessage, ...]) -> Iterator[bytes]:
        from turtlewire.protocols.frame.message import FrameMessage

        directions = list(_DIRECTIONS.values())
        for message in messages:
            if not isinstance(message, FrameMessage):
                raise _foreign(message, self)
            entry = self._dialect.entry(message)
            directions = [direction for direction in directions if entry.goes(direction)]
            if not directions:
                raise MessageError("a frame goes one way, and these messages do not all go the same")
            yield self._dialect.pack(message, directions[0])

    def decoder(self, sender: Sender) -> Decoder:
        """It looks for frames, and again within what was none (F5)."""
        from turtlewire.protocols.frame.codec import FrameDecoder

        decoder = FrameDecoder(self._dialect, _DIRECTIONS[sender])
        return Decoder(
            Source(
                lambda data, now: _packets(decoder.receive_data(data, now)),
                lambda: decoder.pending,
                between="no frame begins here",
                end=lambda: _packets(decoder.end()),
            )
        )

    def parse(self, text: str) -> AnyMessage:
        """A message, or messages with ``;`` between; ``frame seq=3; ...`` sets the number. Raises ``MessageError``."""
        (head_at, head), *rest = _parts(text.partition("(")[0])
        words = head.split()
        if words[:1] != ["frame"]:
            messages = [self._part(part, at) for at, part in ((head_at, head), *rest)]
            return messages[0] if not rest else Packet(None, tuple(messages))
        number = " ".join(words[1:]).removeprefix("seq=")
        if number and not (number.isascii() and number.isdigit() and int(number) < 256):
            raise MessageError(
                f"{head!r}: write frame seq=N with N from 0 to 255, or just frame",
                (head_at, head_at + len(head)),
            )
        refused = tuple(self._part(p[8:], at + 8) for at, p in rest if p.startswith("refused "))
        messages = [self._part(p, at) for at, p in rest if not p.startswith("refused ")]
        return Packet(int(number) if number else None, tuple(messages), refused)

    def _part(self, text: str, at: int) -> AnyMessage:
        """One message of a text, which begins at a character of it: there errors have their place."""
        try:
            return super().parse(text)
        except MessageError as error:
            start, end = error.place or (0, len(text))
            error.place = (at + start, at + end)
            raise

    def names(self) -> frozenset[str]:
        """Messages, and frame."""
        return super().names() | {Packet.name()}

    def to_json(self, message: AnyMessage) -> dict[str, object]:
        """A packet's fields are its number and its messages."""
        if not isinstance(message, Packet):
            return super().to_json(message)
        fields: dict[str, object] = {
            "seq": message.seq,
            "messages": [super(Frame, self).to_json(m) for m in message.messages],
        }
        if message.refused:
            fields["refused"] = [super(Frame, self).to_json(m) for m in message.refused]
        if message.order:
            fields |= {"order": message.order, "lost": message.lost}
        return {"name": message.name(), "fields": fields}

    def from_json(self, form: object) -> AnyMessage:
        """A packet, or a lone message. Raises ``MessageError``."""
        match form:
            case {"name": "frame", "fields": {"messages": list(messages), **rest}}:
                seq = rest.get("seq")
                if seq is not None and (not isinstance(seq, int) or not 0 <= seq <= 255):
                    raise MessageError(f"frame: seq is {seq!r}, but must be a whole number from 0 to 255")
                refused = rest.get("refused", [])
                if not isinstance(refused, list):
                    raise MessageError("frame: refused must be a list of messages")
                return Packet(
                    seq,
                    tuple(super(Frame, self).from_json(m) for m in messages),
                    tuple(super(Frame, self).from_json(m) for m in refused),
                )
        return super().from_json(form)


def _parts(text: str) -> Iterator[tuple[int, str]]:
    """What stands between the ``;`` of a text, and where it begins."""
    at = 0
    for part in text.split(";"):
        yield at + len(part) - len(part.lstrip()), part.strip()
        at += len(part) + 1


# What the frame package calls the two directions.
_DIRECTIONS: dict[Sender, str] = {"host": "to robot", "robot": "from robot"}


def _packets(items: Sequence[FrameItem]) -> list[Received]:
    return [
        item
        if isinstance(item, Malformed)
        else Decoded(
            item.offset, item.raw, Packet(item.seq, item.messages, item.refused, item.order, item.lost)
        )
        for item in items
    ]


def _foreign(message: AnyMessage, codec: Codec) -> MessageError:
    return MessageError(f"{message.name()} is no message of {codec.name}")


class Settings(NamedTuple):
    """What can be said about a protocol besides its name; None is the protocol's default.

    Attributes:
        mode: walter: what a robot takes the first byte for, logo or direct.
        dialect: frame: one that comes with turtlewire, or a file.
        crc: frame: the algorithm's catalogue name.
        coverage: frame: where the CRC begins: magic, seq, size or payload.
    """

    mode: str | None = None
    dialect: str | Path | None = None
    crc: str | None = None
    coverage: str | None = None


def _walter(settings: Settings) -> Codec:
    if settings.mode not in (None, *MODES):
        raise UsageError(f"walter has no mode {settings.mode!r}: it is {' or '.join(MODES)}")
    return Walter(settings.mode or "logo")


def _simple(settings: Settings) -> Codec:
    del settings
    return Simple()


class _Entry(NamedTuple):
    """How to make a codec, and which settings it takes."""

    make: Callable[[Settings], Codec]
    settings: frozenset[str]


def _frame(settings: Settings) -> Codec:
    return Frame(settings.dialect or "0.1", settings.crc, settings.coverage)


_CATALOGUE = {
    "simple": _Entry(_simple, frozenset()),
    "frame": _Entry(_frame, frozenset({"dialect", "crc", "coverage"})),
    "walter": _Entry(_walter, frozenset({"mode"})),
}
NAMES = tuple(_CATALOGUE)


def codec(name: str, settings: Settings | None = None) -> Codec:
    """A protocol by its name.

    Raises ``UsageError`` for a name or a setting that there is not, ``DataError`` for a dialect that cannot be read.
    """
    settings = settings or Settings()
    entry = _CATALOGUE.get(name)
    if entry is None:
        raise UsageError(f"there is no protocol {name!r}; there are {', '.join(NAMES)}")
    for setting, value in settings._asdict().items():
        if value is not None and setting not in entry.settings:
            raise UsageError(f"{name} has no {setting}")
    return entry.make(settings)
