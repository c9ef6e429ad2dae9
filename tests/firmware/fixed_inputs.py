"""A fixed set of commands for the runner that reaches every line and branch of the core, and tells its mutants apart.

The vectors, cut at every place; the ends of every range; every byte where a letter, a digit or a key may stand; and
traffic from fixed seeds, whole and damaged.
"""

from __future__ import annotations

import random
from functools import cache
from itertools import combinations, product
from typing import TYPE_CHECKING

from turtlewire.protocols.frame.codec import frame_bytes
from turtlewire.protocols.frame.dialect import SHIPPED, TO_ROBOT, shipped
from turtlewire.protocols.frame.message import MAX_FRAME, MAX_PAYLOAD
from turtlewire.protocols.message import Field
from turtlewire.protocols.simple import messages as s
from turtlewire.protocols.walter import messages as w
from turtlewire.protocols.walter.codec import Mode, encode
from turtlewire.protocols.walter.messages import (
    DIRECT_KEYS,
    LOGO_COMMANDS,
    HeadingReply,
    LimitBack,
    LimitFront,
    LimitLeft,
    LimitRight,
    LocationReply,
    PenReply,
    TowardsReply,
    XReply,
    YReply,
)
from turtlewire.protocols.walter.robot import Robot as WalterRobot

from .expected import (
    Expected,
    Telemetry,
    frame,
    is_valid,
    sends,
    simple,
    to_robot,
    vectors,
    walter,
    walter_receives,
)

if TYPE_CHECKING:
    from turtlewire.protocols.frame.dialect import Dialect, Entry
    from turtlewire.protocols.message import AnyField
    from turtlewire.protocols.walter.messages import WalterMessage

ALL = frozenset("CQHE")
SEEDS = 60


@cache
def fixed() -> dict[str, Expected]:
    """The commands for each protocol, and what each of them has to lead to."""
    return {"simple": of_simple(), "walter": of_walter(), "frame": of_frame()}


def halves(data: bytes) -> list[list[bytes]]:
    return [[data[:place], data[place:]] for place in range(len(data) + 1)]


def damaged(chance: random.Random, data: bytes) -> bytes:
    """Some bytes flipped, lost or added."""
    out = bytearray()
    for byte in data:
        what = chance.random()
        if what < 0.01:
            out.append(byte ^ 1 << chance.randrange(8))
        elif what < 0.02:
            out += bytes([byte, chance.randrange(256)])
        elif what >= 0.03:
            out.append(byte)
    return bytes(out)


# ------------------------------------------------------------------------------------------------------ simple


def of_simple() -> Expected:
    expected = Expected()
    for vector in to_robot("simple"):
        for pieces in halves(bytes.fromhex(vector["bytes"])):
            simple(expected, pieces, vector.get("extensions", False))
    letters = [bytes([letter]) + digits for letter in range(256) for digits in (b"0000000"[:6], b"------")]
    places = [
        letter + b"111000"[:place] + bytes([odd]) + b"111000"[place + 1 :]
        for letter, place, odd in product((b"F", b"H", b"V"), range(6), b"\x00/0129:;\xff")
    ]
    numbers = (0, 1, 9, 10, 99, 100, 179, 180, 181, 254, 255, 256, 260, 299, 300, 999)
    pairs = product("FBLRSHV", numbers, (0, 180, 181))
    values = [f"{letter}{number:03}{other:03}".encode() for letter, number, other in pairs]
    lights = [b"H" + bytes(each) + b"--" for each in product(b"0129", repeat=4)]
    for extended in (False, True):
        simple(expected, [*letters, *places, *values, *lights], extended)
        expected.add("stop", ["drive 0", "steer 0"], pending=0)
        expected.add("constants", [f"baud {s.BAUD} window {s.MAX_WINDOW}"])
    chance = random.Random(1)
    for _ in range(SEEDS):
        commands = chance.choices([*places, *values, *lights], k=20)
        simple(expected, [damaged(chance, b"".join(commands))], chance.random() < 0.5)
    return expected


# ------------------------------------------------------------------------------------------------------ walter


def with_arguments(message: type[WalterMessage]) -> list[bytes]:
    """The message with every field at the ends of its range and with bytes that look like something else."""
    ends = [
        (field.low, field.high, 1, 0x0D0A if field.kind.endswith("16") else 0x0D) for field in message.FIELDS
    ]
    return [encode(message(*values)) for values in product(*ends)]


def of_walter() -> Expected:
    expected = Expected()
    for vector in to_robot("walter"):
        groups = frozenset(vector.get("groups", ALL))
        for pieces in halves(bytes.fromhex(vector["bytes"])):
            walter(expected, pieces, Mode(vector["mode"]), groups, [20, 20])
    # The one that ends Logo control last.
    commands = sorted(LOGO_COMMANDS, key=lambda message: message is w.SelectDirect)
    lines = [line for message in commands for line in with_arguments(message)]
    keys = [key for message in DIRECT_KEYS for key in with_arguments(message)]
    for number in range(5):
        for present in combinations("CQHE", number):
            walter(expected, lines, Mode.LOGO, frozenset(present), [2] * len(lines))
    for mode, first in product(Mode, range(256)):
        walter(expected, [bytes([first]), b"\x00\x01\r", b"\n\r", b"pd\r"], mode, ALL, [2, 2, 2, 2])
    for first, second in product(b"CEHPQcehpq", range(256)):
        walter(expected, [bytes([first, second]), b"\x00\x01\x02\x03\r\r"], Mode.LOGO, ALL, [2, 2])
    for line in lines:
        walter(
            expected,
            [line.lower(), line[:-1] + b"\x00", b"\r\n", line + b"\n" + line],
            Mode.LOGO,
            ALL,
            [3] * 4,
        )
    for key in keys:
        walter(expected, [key + b"\n", key.lower()[:1] + key[1:], b"1", key], Mode.DIRECT, ALL, [])
    for size in (*range(60, 68), *range(124, 132), 200):
        for begin in (b"!", b"P", b"F\x00\x00", b""):
            walter(expected, [begin + b"x" * size, b"F\x00\x01\r", b"\n\rPU\r"], Mode.LOGO, ALL, [2, 2, 2])
    expected.add("walter", [], mode="logo")
    walter_receives(expected, WalterRobot(), lines, [1] * len(lines))
    expected.add("constants", [f"baud {w.BAUD} speed {w.DEFAULT_SPEED} arguments 4"])
    of_queue(expected)
    of_replies(expected)
    chance = random.Random(2)
    for _ in range(SEEDS):
        some = b"".join(chance.choices([*lines, *keys, b"2\r", b"1", b"\r", b"\r\n"], k=25))
        data = damaged(chance, some)
        place = chance.randrange(len(data))
        groups = frozenset(letter for letter in ALL if chance.random() < 0.8)
        walter(expected, [data[:place], data[place:]], chance.choice(list(Mode)), groups, [7, 30])
    return expected


def of_queue(expected: Expected) -> None:
    """Filled to its last place and beyond, wherever it begins; abandoned; and many times round."""
    for before, size in product((0, 1, 9, 15, 16), (15, 16, 17, 18)):
        some = [b"F" + number.to_bytes(2, "big") + b"\r" for number in range(before + size)]
        walter(
            expected, [b"".join(some[:before]), b"".join(some[before:])], Mode.LOGO, ALL, [before, size + 1]
        )
        expected.add(f"bytes {b''.join(some).hex()} 0", [])
        expected.add("abandon", [], queued=0)
        expected.add("take", ["none"], queued=0)
    overflowing = b"PU\r" * 65537
    for at in range(0, len(overflowing), 3000):
        expected.add(f"bytes {overflowing[at : at + 3000].hex()} 0", [], mode="logo")


def of_replies(expected: Expected) -> None:
    for value in (0, 1, 255, 256, 359):
        sends(expected, f"reply T {value}", TowardsReply(value))
        sends(expected, f"reply H {value}", HeadingReply(value))
    for x, y in product((-32768, -257, -1, 0, 1, 255, 256, 32767), repeat=2):
        sends(expected, f"reply X {x}", XReply(x))
        sends(expected, f"reply Y {y}", YReply(y))
        sends(expected, f"location {x} {y}", LocationReply(x, y))
    sends(expected, "pen 0", PenReply(0))
    sends(expected, "pen 1", PenReply(1))
    for side, event in {"F": LimitFront, "B": LimitBack, "L": LimitLeft, "R": LimitRight}.items():
        sends(expected, f"limit {side}", event())


# ------------------------------------------------------------------------------------------------------- frame


def values(dialect: Dialect, entry: Entry, field: AnyField) -> list[float]:
    """Around the ends of a field's range, and where its bytes tell."""
    high = dialect.high(entry, field)
    if not isinstance(field, Field):
        return [field.low, high, -0.5, 0.5, high + 1, float("inf"), float("nan")]
    size = {"u8": 8, "bool": 1}.get(field.kind, int(field.kind[1:]) if field.kind[1:].isdigit() else 8)
    low_end, high_end = (
        (-(1 << size - 1), (1 << size - 1) - 1) if field.kind[0] == "i" else (0, (1 << size) - 1)
    )
    around = [field.low - 1, field.low, field.low + 1, high - 1, high, high + 1, 0x01020304, 0x0102]
    around += [number + step for _, number in field.choices for step in (-1, 0, 1)]
    return sorted({value for value in around if low_end <= value <= high_end})


def payloads(dialect: Dialect, entry: Entry) -> list[bytes]:
    fields = entry.message_type.FIELDS
    right = [
        field.choices[0][1] if isinstance(field, Field) and field.choices else field.low for field in fields
    ]
    return [
        entry.layout.pack(entry.type, *right[:place], value, *right[place + 1 :])
        for place, field in enumerate(fields)
        for value in values(dialect, entry, field)
    ]


def of_frame() -> Expected:
    expected = Expected()
    for vector in to_robot("frame"):
        if "crc" not in vector and "counts" not in vector:
            for first, second in halves(bytes.fromhex(vector["bytes"])):
                frame(expected, vector["dialect"], [(0, first), (0, second)])
    for session in vectors("frame", "sessions"):
        if "counts" in session and "receive" in session["steps"][0]:
            steps = [(step["at_ms"], bytes.fromhex(step["receive"])) for step in session["steps"]]
            frame(expected, session["dialect"], steps)
    for name in SHIPPED:
        of_messages(expected, name)
        of_frames(expected, name)
    of_sequence(expected)
    return expected


def of_messages(expected: Expected, name: str) -> None:
    dialect = shipped(name)
    robot = Telemetry(expected, name)
    layouts = [f"type {entry.type} size {entry.layout.size}" for entry in dialect.entries]
    counts = "".join(f" {name} {number}" for name, number in sorted(dialect.counts.items()))
    named = [
        f"{name} " + " ".join(str(+each) for each in each_of)
        for name, each_of in dialect.enumerations.items()
    ]
    expected.add(
        "constants",
        [*[f"frame {MAX_FRAME} payload {MAX_PAYLOAD}"] * 2, f"baud {dialect.baud}{counts}", *named, *layouts],
    )
    for entry in dialect.entries:
        for payload in payloads(dialect, entry):
            robot.show(payload)
            robot.show(payload + b"\x07")
            robot.show(payload[:-1])
            robot.finish()
    for number in range(256):
        robot.show(bytes([number]))
        robot.show(bytes([number, *range(15)]))
        robot.finish()
    # Up to the last byte that has room: all sizes of what is in the frame already.
    decoded = [entry for entry in dialect.entries if entry.is_decoded]
    right = [next(p for p in payloads(dialect, e) if is_valid(dialect, e, p)) for e in decoded]
    for first, second in product(right, repeat=2):
        for number in range(1, 124 // len(first)):
            for _ in range(number):
                robot.show(first)
            for _ in range(124 // len(second) + 1 if number % 7 == 1 else 1):
                robot.show(second)
            robot.finish()


def of_frames(expected: Expected, name: str) -> None:
    dialect = shipped(name)
    commands = [e for e in dialect.entries if e.goes(TO_ROBOT) and e.is_decoded]
    commands = commands or [e for e in dialect.entries if e.goes(TO_ROBOT)]
    right = [payload for entry in commands for payload in payloads(dialect, entry)]
    steps = [(0, frame_bytes(dialect, seq % 256, some)) for seq, some in enumerate([b"", *right])]
    for size in range(125):
        filled = b"".join(right)[:size]
        steps.append((0, frame_bytes(dialect, size, filled)))
        steps.append((0, frame_bytes(dialect, size, bytes([0xA3] * size))))
    frame(expected, name, steps)
    whole = frame_bytes(dialect, 7, right[0] + right[1])
    for wait_ms, start_ms in product((0, 1, 99, 100, 101, 5000), (0, 1, 2**32 - 50)):
        for place in range(len(whole)):
            at_ms = start_ms + wait_ms
            frame(
                expected,
                name,
                [(start_ms, whole[:place]), (at_ms, b""), (at_ms, whole[place:]), (at_ms, whole)],
            )
    for size in (0x7B, 0x7C, 0x7D, 0x7E, 0xFF):
        for rest in (2, 3, 4, 126, 127, 128, 131):
            frame(
                expected,
                name,
                [(0, bytes([0xA3, 1, size, *[0] * rest])), (50, b""), (100, b""), (200, whole)],
            )
            frame(expected, name, [(0, bytes([0xA3, 1, size]) + b"\xa3" * rest), (0, whole), (100, b"")])
    chance = random.Random(3)
    for _ in range(SEEDS):
        made = [
            frame_bytes(dialect, chance.randrange(4), b"".join(chance.choices(right, k=k))[:124])
            for k in range(8)
        ]
        data = damaged(chance, b"".join(made))
        place = chance.randrange(len(data))
        frame(expected, name, [(0, data[:place]), (chance.choice((0, 99, 100)), data[place:]), (300, b"")])


def of_sequence(expected: Expected) -> None:
    """What a frame's number says, after each that may have come before (F6); gaps add up beyond 16 bits."""
    dialect = shipped("0.1")
    numbers = (0, 1, 2, 3, 127, 128, 254, 255)
    for each in product(numbers, repeat=3):
        frame(expected, "0.1", [(0, frame_bytes(dialect, seq, b"")) for seq in each])
    frame(expected, "0.1", [(0, frame_bytes(dialect, 251 * n % 256 or 1, b"")) for n in range(255)])
