"""What the vectors of all protocols have in common: the schema of their files, and how decoders are run on them.

Each protocol's own ``test_*.py`` adds what only it has, and tells its differences as data: a ``Runner``.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Generic, Literal, TypeVar

import msgspec
from msgspec import Meta, Struct, field

from turtlewire.protocols.message import Decoded, Malformed, Message, parse

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

FOLDER = Path(__file__).parents[2] / "spec" / "vectors"

Id = Annotated[str, Meta(pattern=r"^[a-z-]+/[a-z0-9]+(-[a-z0-9]+)*$")]
Hex = Annotated[str, Meta(pattern=r"^([0-9A-F]{2}( [0-9A-F]{2})*)?$")]
Origin = Literal["source", "by hand"]
Direction = Literal["to robot", "from robot"]
Text = Annotated[str, Meta(pattern=r"^[a-z_]+( [a-z_]+=-?\d+)*$")]
Natural = Annotated[int, Meta(ge=0)]


class Good(Struct, forbid_unknown_fields=True, frozen=True):
    """A message; ``canonical`` is what an encoder makes of it where that is not ``raw``."""

    offset: Natural
    raw: Hex
    message: Text
    fields: dict[str, int]
    canonical: Hex | None = None


class Bad(Struct, forbid_unknown_fields=True, frozen=True):
    """Bytes that are none, and what a decoder says of them."""

    offset: Natural
    raw: Hex
    error: str


class AnyVector(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """``attempts``: the message that ill-formed bytes were meant to be. ``pending``: bytes of an unfinished one."""

    id: Id
    origin: Origin
    direction: Direction
    attempts: str | None = None
    wire: Hex = field(name="bytes")
    items: list[dict[str, object]]
    pending: Natural

    def data(self) -> bytes:
        return bytes.fromhex(self.wire)


class Vector(AnyVector, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """Of a protocol whose items are messages."""

    def expected(self) -> list[Good | Bad]:
        return read_items(self.items, Good)


class AnySession(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    id: Id
    origin: Origin


VectorT = TypeVar("VectorT", bound=AnyVector)
SessionT = TypeVar("SessionT")
GoodT = TypeVar("GoodT")


class Topic(Struct, Generic[VectorT, SessionT], forbid_unknown_fields=True, frozen=True, kw_only=True):
    protocol: str
    topic: str
    about: str
    vectors: list[VectorT] = []
    sessions: list[SessionT] = []


def read_items(items: list[dict[str, object]], good: type[GoodT]) -> list[GoodT | Bad]:
    """What a decoder gives: an item with an ``error``, or a good one of the protocol's kind."""
    return [msgspec.convert(item, Bad) if "error" in item else msgspec.convert(item, good) for item in items]


def read_topics(protocol: str, kind: type[Topic[VectorT, SessionT]]) -> dict[str, Topic[VectorT, SessionT]]:
    """All files of a protocol, by their names."""
    files = sorted((FOLDER / protocol).glob("*.json"))
    return {path.stem: msgspec.json.decode(path.read_bytes(), type=kind) for path in files}


def check_topics(protocol: str, topics: dict[str, Topic[Any, Any]], names: set[str]) -> None:
    """These, and each file is of its topic and has either vectors or sessions."""
    assert set(topics) == names
    for name, topic in topics.items():
        assert (topic.protocol, topic.topic) == (protocol, name)
        assert topic.about.endswith(".")
        assert bool(topic.vectors) != bool(topic.sessions)


def check_ids(topics: dict[str, Topic[Any, Any]], sessions: Sequence[AnySession]) -> None:
    """They are unique, and begin with the topic."""
    for name, topic in topics.items():
        named = [one for one in (*topic.vectors, *topic.sessions) if isinstance(one, AnyVector | AnySession)]
        assert all(one.id.startswith(f"{name}/") for one in named)
    ids = Counter(vector.id for topic in topics.values() for vector in topic.vectors)
    ids.update(session.id for session in sessions)
    assert [name for name, n in ids.items() if n > 1] == []


def check_message(item: Good, types: tuple[type[Message], ...]) -> None:
    """Its text, its fields and its bytes say the same."""
    message = parse(item.message, types)
    assert str(message) == item.message
    assert item.fields == {f.name: getattr(message, f.name) for f in message.FIELDS}
    assert item.canonical != item.raw, "canonical says something only where it differs"


def check_times(steps: Sequence[Any]) -> None:
    """The steps of a session stand in the order of time."""
    times = [step.at_ms for step in steps]
    assert times == sorted(times)


def items_of(vector: Vector, types: tuple[type[Message], ...], moved: int = 0) -> list[object]:
    """What a decoder should give of a vector; with so many bytes before it."""
    return [
        Malformed(item.offset + moved, bytes.fromhex(item.raw), item.error)
        if isinstance(item, Bad)
        else Decoded(item.offset + moved, bytes.fromhex(item.raw), parse(item.message, types))
        for item in vector.expected()
    ]


def check_encoding(vector: Vector, types: tuple[type[Message], ...], encode: Callable[[Any], bytes]) -> None:
    """Encoding each message gives its canonical bytes."""
    by_name = {message_type.name(): message_type for message_type in types}
    for item in vector.expected():
        if isinstance(item, Good):
            message = by_name[item.message.split()[0]](**item.fields)
            assert encode(message).hex(" ").upper() == (item.canonical or item.raw)


def chunkings(data: bytes) -> Iterator[list[bytes]]:
    """Whole, byte by byte, and cut at every single point (empty pieces at both ends included)."""
    yield [data]
    yield [bytes([byte]) for byte in data]
    for cut in range(len(data) + 1):
        yield [data[:cut], data[cut:]]


@dataclass(frozen=True)
class Runner(Generic[VectorT]):
    """How a protocol's decoders are run on its vectors.

    Attributes:
        decoder: a fresh one for a vector.
        expected: what it should give, with so many bytes before: of each item what ``shown`` makes of it.
        rest: what it has left in the end, and what it should have.
        shown: what can be compared of an item.
        again: what of that must be the same when the same bytes come once more.
    """

    decoder: Callable[[VectorT], Any]
    expected: Callable[[VectorT, int], list[object]]
    rest: Callable[[Any, VectorT], tuple[object, object]]
    shown: Callable[[Any], object] = lambda item: item
    again: Callable[[Any], object] = lambda shown: shown

    def check_decoding(self, vector: VectorT) -> None:
        """The items are the expected ones in every chunking, and so is what is left."""
        expected = self.expected(vector, 0)
        for chunks in chunkings(vector.data()):
            decoder = self.decoder(vector)
            items = [item for chunk in chunks for item in decoder.receive_data(chunk)]
            assert [self.shown(item) for item in items] == expected
            left, should_be_left = self.rest(decoder, vector)
            assert left == should_be_left

    def check_decoding_again(self, vector: VectorT) -> None:
        """A vector after which nothing is left gives the same once more."""
        decoder = self.decoder(vector)
        decoder.receive_data(vector.data())
        items = [self.again(self.shown(item)) for item in decoder.receive_data(vector.data())]
        assert items == [self.again(shown) for shown in self.expected(vector, len(vector.data()))]
