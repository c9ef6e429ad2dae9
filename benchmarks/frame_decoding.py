"""Decoding frames, against what people use instead: thousand frames a second, side by side in one run.

python benchmarks/frame_decoding.py    (needs the extras ``bulk`` and ``bench``; one to two minutes)

The workload: one message a frame, its fields' values random, fed in pieces of 4,096 bytes; payloads of 3 bytes (type
and two u8: 7-byte frames), of 20 and of 124 bytes. Every peer gets the same values in its own format and decodes all of
them, and the values are compared. What a peer gives, its line says: "typed" are objects with named fields, "tuples" and
"bytes" leave the names to the caller. A star marks what nobody publishes, but was put together here as a mark to beat.
Two times are taken: decoding alone, and decoding and reading every field once, because some peers put the work off
until then. A second table has messages of three types, several messages in a frame, and damage.

Every piece of every stream is timed (the processor's time), the streams in turn, in several rounds; the best time of
each piece counts. So what else the machine does has little to say.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import importlib
import io
import itertools
import operator
import os
import platform
import random
import struct
import sys
import tempfile
import time
import tracemalloc
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import fastcrc
import msgspec

from turtlewire.protocols.frame import bulk
from turtlewire.protocols.frame.codec import Frame, FrameDecoder, FrameEncoder, frame_bytes
from turtlewire.protocols.frame.dialect import Dialect, read_dialect, shipped

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

PIECE = 4096
ROUNDS = 12
CAPTURE = 10  # bulk decodes a capture this many times as long
cobs: Any = importlib.import_module("cobs.cobs")
crc8 = fastcrc.crc8.smbus


class Load(NamedTuple):
    """A workload: the letters of the fields in the struct module's language, and values for every frame."""

    title: str
    letters: str
    values: list[tuple[int, ...]]

    @property
    def names(self) -> list[str]:
        """What the fields are called."""
        return [f"f{n}" for n in range(len(self.letters))]


class Runner(NamedTuple):
    """A decoder under test.

    ``gives`` is what: "typed", "tuples", "bytes" or "columns". ``decode`` decodes a stream, piece by piece;
    ``messages`` finds in what came of a piece the objects with the fields, and ``values`` reads these.
    """

    title: str
    gives: str
    data: bytes
    frames: int
    decode: Callable[[list[bytes]], Iterator[list[Any]]]
    values: Callable[[Any], Any]
    messages: Callable[[list[Any]], Iterable[Any]] = iter


def messages_of(items: list[Any]) -> Iterator[Any]:
    """Of our frames; what is malformed has none."""
    return itertools.chain.from_iterable([item.messages for item in items if type(item) is Frame])


def pieces(data: bytes) -> list[bytes]:
    """A stream in the pieces that it is fed in."""
    return [data[at : at + PIECE] for at in range(0, len(data), PIECE)]


# --------------------------------------------------------------------------------------------------- ourselves


def dialect_for(load: Load) -> Dialect:
    """A dialect with the one message."""
    kinds = {"B": "u8", "H": "u16", "I": "u32"}
    fields = ", ".join(
        f'{{ name = "{n}", kind = "{kinds[k]}" }}' for n, k in zip(load.names, load.letters, strict=True)
    )
    return read_dialect(
        'protocol = "frame"\ndialect = "bench"\n[[message]]\nname = "Load"\ntype = 1\n'
        f'direction = "to robot"\nfields = [{fields}]\n'
    )


def ours(load: Load) -> Iterator[Runner]:
    """The streaming decoder, and the bulk one."""
    dialect = dialect_for(load)
    encoder = FrameEncoder(dialect)
    made = [dialect["Load"](*values) for values in load.values]
    data = b"".join(frame for message in made for frame in encoder.encode([message]))

    def stream(chunks: list[bytes]) -> Iterator[list[Any]]:
        decoder = FrameDecoder(dialect)
        for chunk in chunks:
            yield decoder.receive_data(chunk)

    fields = operator.attrgetter(*load.names)
    yield Runner("turtlewire, streaming", "typed", data, len(made), stream, fields, messages_of)

    whole = data * CAPTURE

    def at_once(_: list[bytes]) -> Iterator[list[Any]]:
        columns = bulk.decode(whole, dialect).messages[dialect["Load"]]
        yield [columns.fields]

    def of_columns(fields: dict[str, Any]) -> tuple[int, ...]:
        return tuple(itertools.chain(*zip(*(column.tolist() for column in fields.values()), strict=True)))

    yield Runner("turtlewire, bulk", "columns", whole, CAPTURE * len(made), at_once, of_columns)


def plain_state_machine(load: Load) -> Iterator[Runner]:
    """One byte after the other, as firmware would: (seq, payload)."""
    table = [crc8(bytes([byte])) for byte in range(256)]
    dialect = dialect_for(load)
    encoder = FrameEncoder(dialect)
    made = [dialect["Load"](*values) for values in load.values]
    data = b"".join(frame for message in made for frame in encoder.encode([message]))
    layout = struct.Struct(">x" + load.letters)

    def decode(chunks: list[bytes]) -> Iterator[list[Any]]:
        state = seq = size = crc = 0
        payload = bytearray()
        for chunk in chunks:
            out = []
            for byte in chunk:
                if state == 3:
                    payload.append(byte)
                    crc = table[crc ^ byte]
                    if len(payload) == size:
                        state = 4
                elif state == 0:
                    if byte == 0xA3:
                        crc = table[byte]
                        state = 1
                elif state == 1:
                    seq = byte
                    crc = table[crc ^ byte]
                    state = 2
                elif state == 2:
                    if byte > 124:
                        state = 0
                    else:
                        size = byte
                        crc = table[crc ^ byte]
                        payload = bytearray()
                        state = 3 if size else 4
                else:
                    if byte == crc:
                        out.append((seq, bytes(payload)))
                    state = 0
            yield out

    yield Runner(
        "* plain state machine", "bytes", data, len(made), decode, lambda item: layout.unpack(item[1])
    )


# ------------------------------------------------------------------------------------------------------- peers


def cobs_crc_struct(load: Load) -> Iterator[Runner]:
    """COBS in C, a CRC in Rust, struct: put together by hand; as tuples, and as typed objects."""
    layout = struct.Struct(">" + load.letters)
    bodies = [layout.pack(*values) for values in load.values]
    data = b"".join(cobs.encode(body + bytes([crc8(body)])) + b"\0" for body in bodies)
    made: Any = msgspec.defstruct("Made", [(name, int) for name in load.names], frozen=True, gc=False)

    def tuples(chunks: list[bytes]) -> Iterator[list[Any]]:
        rest = b""
        for chunk in chunks:
            out = []
            *frames, rest = (rest + chunk).split(b"\0")
            for frame in frames:
                body = cobs.decode(frame)
                if not crc8(body):
                    out.append(layout.unpack_from(body))
            yield out

    def typed(chunks: list[bytes]) -> Iterator[list[Any]]:
        rest = b""
        for chunk in chunks:
            out = []
            *frames, rest = (rest + chunk).split(b"\0")
            for frame in frames:
                body = cobs.decode(frame)
                if not crc8(body):
                    out.append(made(*layout.unpack_from(body)))
            yield out

    yield Runner("* cobs + fastcrc + struct", "tuples", data, len(bodies), tuples, tuple)
    yield Runner(
        "* cobs + fastcrc + struct + msgspec",
        "typed",
        data,
        len(bodies),
        typed,
        operator.attrgetter(*load.names),
    )


def protobuf_cobs(load: Load) -> Iterator[Runner]:
    """Protocol buffers (in C) in COBS, with the same CRC."""
    descriptor_pb2: Any = importlib.import_module("google.protobuf.descriptor_pb2")
    descriptor_pool: Any = importlib.import_module("google.protobuf.descriptor_pool")
    message_factory: Any = importlib.import_module("google.protobuf.message_factory")

    file = descriptor_pb2.FileDescriptorProto(name=f"bench{len(load.letters)}.proto", package="bench")
    described = file.message_type.add(name=f"Load{len(load.letters)}")
    for number, name in enumerate(load.names, 1):
        described.field.add(
            name=name,
            number=number,
            type=descriptor_pb2.FieldDescriptorProto.TYPE_UINT32,
            label=descriptor_pb2.FieldDescriptorProto.LABEL_OPTIONAL,
        )
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    made: Any = message_factory.GetMessageClass(pool.FindMessageTypeByName(f"bench.{described.name}"))
    bodies = [
        made(**dict(zip(load.names, values, strict=True))).SerializeToString() for values in load.values
    ]
    data = b"".join(cobs.encode(body + bytes([crc8(body)])) + b"\0" for body in bodies)
    read = made.FromString

    def decode(chunks: list[bytes]) -> Iterator[list[Any]]:
        rest = b""
        for chunk in chunks:
            out = []
            *frames, rest = (rest + chunk).split(b"\0")
            for frame in frames:
                body = cobs.decode(frame)
                if not crc8(body):
                    out.append(read(body[:-1]))
            yield out

    yield Runner(
        "protobuf + cobs + fastcrc",
        "typed",
        data,
        len(bodies),
        decode,
        operator.attrgetter(*load.names),
    )


def mavlink(load: Load) -> Iterator[Runner]:
    """The Python code that mavgen makes for a dialect with this message."""
    mavgen: Any = importlib.import_module("pymavlink.generator.mavgen")
    mavparse: Any = importlib.import_module("pymavlink.generator.mavparse")

    kinds = {"B": "uint8_t", "H": "uint16_t", "I": "uint32_t"}
    fields = "".join(
        f'<field type="{kinds[k]}" name="{n}">x</field>'
        for n, k in zip(load.names, load.letters, strict=True)
    )
    name = f"mavlink_bench{len(load.letters)}"
    with tempfile.TemporaryDirectory() as folder:
        xml = Path(folder) / "bench.xml"
        xml.write_text(
            '<?xml version="1.0"?><mavlink><version>3</version><messages>'
            f'<message id="150" name="LOAD"><description>x</description>{fields}</message></messages></mavlink>'
        )
        options = mavgen.Opts(
            str(Path(folder) / name), wire_protocol=mavparse.PROTOCOL_2_0, language="Python3", validate=False
        )
        with contextlib.redirect_stdout(io.StringIO()):
            mavgen.mavgen(options, [str(xml)])
        sys.path.insert(0, folder)
        made: Any = importlib.import_module(name)
        sys.path.remove(folder)
    link = made.MAVLink(None)
    count = min(len(load.values), 3_000)
    data = b"".join(made.MAVLink_load_message(*values).pack(link) for values in load.values[:count])

    def decode(chunks: list[bytes]) -> Iterator[list[Any]]:
        reader = made.MAVLink(None)
        for chunk in chunks:
            yield reader.parse_buffer(bytearray(chunk)) or []

    yield Runner(
        "pymavlink",
        "typed",
        data,
        count,
        decode,
        operator.attrgetter(*load.names),
    )


def construct_compiled(load: Load) -> Iterator[Runner]:
    """Construct's compiled parser for a whole frame of ours, found by its magic, CRC by fastcrc."""
    construct: Any = importlib.import_module("construct")

    kinds = {"B": construct.Int8ub, "H": construct.Int16ub, "I": construct.Int32ub}
    frame = construct.Struct(
        "magic" / construct.Const(b"\xa3"),
        "seq" / construct.Int8ub,
        "size" / construct.Int8ub,
        "type" / construct.Int8ub,
        *(name / kinds[letter] for name, letter in zip(load.names, load.letters, strict=True)),
        "crc" / construct.Int8ub,
    ).compile()
    dialect = dialect_for(load)
    encoder = FrameEncoder(dialect)
    count = min(len(load.values), 3_000)
    made = [dialect["Load"](*values) for values in load.values[:count]]
    data = b"".join(bytes_ for message in made for bytes_ in encoder.encode([message]))

    def decode(chunks: list[bytes]) -> Iterator[list[Any]]:
        rest = b""
        for chunk in chunks:
            out = []
            buffer = rest + chunk
            at = 0
            while True:
                at = buffer.find(b"\xa3", at)
                if at < 0 or at + 3 > len(buffer) or at + buffer[at + 2] + 4 > len(buffer):
                    break
                stop = at + buffer[at + 2] + 4
                raw = buffer[at:stop]
                if crc8(raw):
                    at += 1
                else:
                    out.append(frame.parse(raw))
                    at = stop
            rest = buffer[at:] if at >= 0 else b""
            yield out

    yield Runner(
        "construct, compiled, + fastcrc",
        "typed",
        data,
        count,
        decode,
        operator.itemgetter(*load.names),
    )


class Wire:
    """What pySerialTransfer takes for its serial port."""

    is_open = True

    def __init__(self) -> None:
        self.buffer = b""
        self.at = 0
        self.written = bytearray()

    @property
    def in_waiting(self) -> int:
        """Bytes to read."""
        return len(self.buffer) - self.at

    def read(self, size: int = 1) -> bytes:
        """Some of them."""
        data = self.buffer[self.at : self.at + size]
        self.at += len(data)
        return data

    def write(self, data: bytes) -> None:
        """Keep what is sent."""
        self.written += bytes(data)

    def close(self) -> None:
        """Nothing to close."""


def serial_transfer(load: Load) -> Iterator[Runner]:
    """PySerialTransfer on a wire in memory; its payload read with struct."""
    transfer: Any = importlib.import_module("pySerialTransfer.pySerialTransfer")

    layout = struct.Struct("<" + load.letters)
    count = min(len(load.values), 1_500 if len(load.letters) < 10 else 150)

    def link(wire: Wire) -> Any:
        made = transfer.SerialTransfer("none", restrict_ports=False)
        made.connection = wire
        return made

    wire = Wire()
    sender = link(wire)
    for values in load.values[:count]:
        body = layout.pack(*values)
        sender.tx_buff[: len(body)] = list(body)
        sender.send(len(body))
    data = bytes(wire.written)

    def decode(chunks: list[bytes]) -> Iterator[list[Any]]:
        wire = Wire()
        reader = link(wire)
        for chunk in chunks:
            out = []
            wire.buffer, wire.at = wire.buffer[wire.at :] + chunk, 0
            while wire.in_waiting:
                if reader.available():
                    out.append(layout.unpack(bytes(reader.rx_buff[: layout.size])))
            yield out

    yield Runner("pySerialTransfer", "tuples", data, count, decode, tuple)


PEERS = (
    ours,
    plain_state_machine,
    cobs_crc_struct,
    protobuf_cobs,
    mavlink,
    construct_compiled,
    serial_transfer,
)

# --------------------------------------------------------------------------------------------------- measuring


def check(runner: Runner, load: Load) -> None:
    """What comes out must be what went in."""
    items = list(itertools.chain.from_iterable(runner.decode(pieces(runner.data))))
    want = (load.values * CAPTURE)[: runner.frames]
    if runner.gives == "columns":
        assert runner.values(items[0]) == tuple(itertools.chain(*want)), runner.title
    else:
        assert [tuple(runner.values(item)) for item in runner.messages(items)] == want, runner.title


def times(runner: Runner, *, read: bool) -> list[float]:
    """How long one round takes, piece by piece, in seconds."""
    gc.collect()
    taken = []
    decoded = runner.decode(pieces(runner.data))
    begin = time.thread_time()
    for piece in decoded:
        if read and runner.gives not in ("tuples", "columns"):
            deque(map(runner.values, runner.messages(piece)), maxlen=0)
        del piece
        end = time.thread_time()
        taken.append(end - begin)
        begin = end
    return taken


def rates(runners: list[Runner], *, read: bool) -> dict[str, float]:
    """Frames a second, of each the best."""
    rounds = [[times(runner, read=read) for runner in runners] for _ in range(ROUNDS)]
    bests = [sum(map(min, zip(*of_one, strict=True))) for of_one in zip(*rounds, strict=True)]
    return {runner.title: runner.frames / best for runner, best in zip(runners, bests, strict=True)}


def peak_bytes(data: bytes, dialect: Dialect, times: int) -> int:
    """The most memory that the streaming decoder holds over a stream, its items dropped as they come."""
    chunks = pieces(data) * times
    decoder = FrameDecoder(dialect)
    for chunk in chunks[: len(chunks) // 2]:
        decoder.receive_data(chunk)
    tracemalloc.start()
    for chunk in chunks:
        decoder.receive_data(chunk)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def compare(title: str, letters: str, count: int) -> float:
    """All peers with one kind of frame. Returns the rate of pymavlink."""
    chance = random.Random(1)
    tops = {"B": 256, "H": 1 << 16, "I": 1 << 32}
    values = [tuple(chance.randrange(tops[letter]) for letter in letters) for _ in range(count)]
    load = Load(title, letters, values)
    runners = list(itertools.chain.from_iterable(peer(load) for peer in PEERS))
    for runner in runners:
        check(runner, load)
    decoded, read = rates(runners, read=False), rates(runners, read=True)
    mine, at_once, mine_read = (
        rates["turtlewire, " + way]
        for rates, way in ((decoded, "streaming"), (decoded, "bulk"), (read, "streaming"))
    )
    print(f"\n{title}")
    print(f"  {'thousand frames a second':38}{'gives':9}{'decoded':>9}{'streaming':>11}{'bulk':>9}", end="")
    print(f"{'and read':>11}{'streaming':>11}")
    for runner in runners:
        rate, rate_read = decoded[runner.title], read[runner.title]
        print(f"  {runner.title:38}{runner.gives:9}{rate / 1000:>9,.0f}{mine / rate:>9.1f} x", end="")
        print(f"{at_once / rate:>7.1f} x{rate_read / 1000:>11,.0f}{mine_read / rate_read:>9.1f} x")
    short, long = (peak_bytes(runners[0].data, dialect_for(load), times) for times in (2, 10))
    print(f"  memory of streaming, peak: {short:,} bytes; for a stream 5 times as long {long:,} bytes")
    return decoded["pymavlink"]


def other_streams(mavlink_rate: float) -> None:
    """Ourselves where frames are not all alike, or damaged."""
    dialect = shipped("0.1").configured(counts={"servos": 256, "engines": 256})
    chance = random.Random(2)

    def message() -> bytes:
        kind = chance.randrange(3)
        return bytes((kind, chance.randrange(256), chance.randrange(256 if kind else 181)))

    def stream(count: int, number: Callable[[], int]) -> bytes:
        payloads = (b"".join(message() for _ in range(number())) for _ in range(count))
        return b"".join(frame_bytes(dialect, n % 256, payload) for n, payload in enumerate(payloads))

    def damaged(data: bytes, rate: float) -> bytes:
        return bytes(chance.randrange(256) if chance.random() < rate else byte for byte in data)

    one = stream(40_000, lambda: 1)

    def streaming(chunks: list[bytes]) -> Iterator[list[Any]]:
        decoder = FrameDecoder(dialect)
        for chunk in chunks:
            yield decoder.receive_data(chunk)

    def at_once(data: bytes, _: list[bytes]) -> Iterator[list[Any]]:
        yield [bulk.decode(data, dialect)]

    one = stream(30_000, lambda: 1)
    streams = {
        "7-byte frames of three types": one,
        "the same, 0.001% of the bytes replaced": damaged(one, 0.00001),
        "the same, 0.1% of the bytes replaced": damaged(one, 0.001),
        "the same, 1% of the bytes replaced": damaged(one, 0.01),
        "1 to 5 messages a frame": stream(15_000, lambda: chance.randint(1, 5)),
        "41 messages a frame": stream(1_500, lambda: 41),
    }
    print(
        f"\n  {'thousand messages a second':42}{'streaming':>10}{'pymavlink':>11}{'bulk':>10}{'pymavlink':>11}"
    )
    for title, data in streams.items():
        found = sum(len(messages.frame) for messages in bulk.decode(data, dialect).messages.values())
        whole = functools.partial(at_once, data * CAPTURE)
        runners = [
            Runner("streaming", "typed", data, found, streaming, iter),
            Runner("bulk", "columns", b"", found * CAPTURE, whole, iter),
        ]
        streamed, in_bulk = rates(runners, read=False).values()
        print(f"  {title:42}{streamed / 1000:>10,.0f}{streamed / mavlink_rate:>9.1f} x", end="")
        print(f"{in_bulk / 1000:>10,.0f}{in_bulk / mavlink_rate:>9.1f} x")
    print("  beside pymavlink with undamaged messages of two u8, each in a frame of its own")


def main() -> None:
    """Measure and print."""
    print(f"{platform.python_implementation()} {platform.python_version()}, {os.cpu_count()} processors")
    mavlink_rate = compare("7-byte frames: type, 2 x u8", "BB", 60_000)
    compare("20-byte payloads: type, u8, u16, 4 x u32", "BHIIII", 25_000)
    compare("124-byte payloads: type, u8, u16, 30 x u32", "BH" + "I" * 30, 8_000)
    other_streams(mavlink_rate)


if __name__ == "__main__":
    main()
