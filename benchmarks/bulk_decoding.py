"""How much faster than one byte after the other a whole capture of simple or WALTER is decoded to columns.

The same captures go through ``bulk`` (columns), through the streaming decoders (an object for each message, with its
place and bytes), and through state machines in plain Python that look at one byte after the other, as firmware does,
and give the same as ``bulk``: of each message its place, its type and its fields, of all else its place, its length and
what is wrong with it. All three are compared, item by item, before anything is measured. Rounds alternate, the best of
each counts, and ratios are to the time of ``bulk``. With ``--json`` the numbers come as JSON.
"""

from __future__ import annotations

import argparse
import gc
import json
import random
import struct
import sys
import time
from typing import TYPE_CHECKING, Any, NamedTuple

from turtlewire.protocols.message import Decoded, Malformed
from turtlewire.protocols.simple import bulk as simple_bulk
from turtlewire.protocols.simple import codec as simple
from turtlewire.protocols.simple import messages as simple_messages
from turtlewire.protocols.walter import bulk as walter_bulk
from turtlewire.protocols.walter import codec as walter
from turtlewire.protocols.walter import messages as walter_messages
from turtlewire.protocols.walter.messages import DIRECT_KEYS, EmptyLine, PenReply, SelectDirect, SelectLogo

if TYPE_CHECKING:
    from collections.abc import Callable

    # Of each message its place, type and fields; of all else its place, length, and what is wrong.
    Found = tuple[list[tuple[int, type[Any], tuple[int, ...]]], list[tuple[int, int, str]]]

NOISE = 0.01  # so many bytes are replaced by any others
COMMANDS = tuple(t for t in walter_messages.LOGO_COMMANDS if t is not EmptyLine)
LINES = tuple(t for t in COMMANDS if t is not SelectDirect)
MOVES = (walter_messages.Forward, walter_messages.Right, walter_messages.PenUp, walter_messages.PenDown)
KEYS = tuple(t for t in DIRECT_KEYS if t is not SelectLogo)

CR, LF = 0x0D, 0x0A
LETTERS, SECOND_LETTER, ARGUMENTS, RET, DROP = range(5)
STRUCT = {"u8": "B", "bit": "B", "u16": "H", "i16": "h"}


class Load(NamedTuple):
    """A kind of capture, and the three ways to decode it."""

    title: str
    data: bytes
    bulk: Callable[[bytes], Any]
    streaming: Callable[[bytes], list[Any]]
    plain: Callable[[bytes], Found]


def shown(byte: int) -> str:
    """A byte in the text of what is wrong."""
    return repr(chr(byte)) if 0x20 < byte < 0x7F else f"{byte:02X}"


def plain_commands(data: bytes) -> Found:
    """One byte after the other: a letter, digits, what is don't care."""
    lights = simple_messages.Headlights
    commands = {
        t.LETTER[0]: (t, 0 if not t.FIELDS else 4 if t is lights else 3) for t in simple_messages.COMMANDS
    }
    messages: list[Any] = []
    errors: list[Any] = []
    place = digits = number = 0
    command: Any = None
    wrong = ""
    for at, byte in enumerate(data):
        if place == 0:
            place = 1
            number = 0
            if byte in commands:
                command, digits = commands[byte]
                wrong = ""
            else:
                digits = 0
                wrong = f"unknown letter {shown(byte)}"
            continue
        if place <= digits:
            if 0x30 <= byte <= 0x39:
                number = number * 10 + byte - 0x30
            elif not wrong:
                field = command.FIELDS[place - 1 if digits == 4 else 0]
                wrong = f"{command.name()}: {shown(byte)} where a digit of {field.name} must be"
        if place < 6:
            place += 1
            continue
        place = 0
        if digits == 3 and number > 255 and not wrong:
            wrong = f"{command.name()}: {command.FIELDS[0].name} is {number}, but must be 0 to 255"
        if wrong:
            errors.append((at - 6, 7, wrong))
        elif digits == 3:
            messages.append((at - 6, command, (number,)))
        elif digits == 0:
            messages.append((at - 6, command, ()))
        else:
            bits = (number >= 1000, number % 1000 >= 100, number % 100 >= 10, number % 10 >= 1)
            messages.append((at - 6, command, bits))
    return messages, errors


def plain_replies(data: bytes) -> Found:
    """One byte after the other."""
    replies = {t.LETTER[0]: t for t in simple_messages.REPLIES}
    messages: list[Any] = []
    errors: list[Any] = []
    for at, byte in enumerate(data):
        if byte in replies:
            messages.append((at, replies[byte], ()))
        else:
            errors.append((at, 1, f"no reply {shown(byte)}"))
    return messages, errors


def plain_walter(lines: tuple[Any, ...], mode: walter.Mode = walter.Mode.LOGO) -> Callable[[bytes], Found]:
    """One byte after the other: letters, arguments, RET, or a line to drop; or keys."""
    first: dict[int, Any] = {}
    seconds: dict[int, dict[int, Any]] = {}
    for line in lines:
        arguments = struct.Struct(">" + "".join(STRUCT[field.kind] for field in line.FIELDS))
        highest = min(
            (field.high for field in line.FIELDS if field.kind == "bit" or field.high == 359), default=None
        )
        for letters in {line.LETTERS, line.LETTERS.lower()}:
            form = (line, arguments.size, arguments.unpack, highest)
            if len(letters) == 1:
                first[letters[0]] = form
            else:
                for letter in {letters[:1].upper()[0], letters[:1].lower()[0]}:
                    seconds.setdefault(letter, {})[letters[1]] = form
    keys = {
        letter: key for key in DIRECT_KEYS if not key.FIELDS for letter in key.LETTERS + key.LETTERS.lower()
    }
    taking = {
        letter: key for key in DIRECT_KEYS if key.FIELDS for letter in key.LETTERS + key.LETTERS.lower()
    }

    def decode(data: bytes) -> Found:
        messages: list[Any] = []
        errors: list[Any] = []
        direct = mode is walter.Mode.DIRECT
        key: Any = None
        state = LETTERS
        start = left = size = 0
        behind_ret = -1
        line: Any = None
        unpack: Any = None
        highest: Any = None
        second: dict[int, Any] = {}
        wrong = ""
        for at, byte in enumerate(data):
            if direct:
                if key is not None:
                    messages.append((at - 1, key, (byte,)))
                    key = None
                elif byte in keys:
                    messages.append((at, keys[byte], ()))
                    direct = byte != 0x31
                elif byte in taking:
                    key = taking[byte]
                elif byte == CR:
                    messages.append((at, EmptyLine, ()))
                    behind_ret = at + 1
                elif byte != LF or at != behind_ret:
                    errors.append((at, 1, f"no key {byte:02X}"))
            elif state == ARGUMENTS:
                left -= 1
                if not left:
                    state = RET
            elif state == RET:
                if byte != CR:
                    wrong = f"{byte:02X} where RET must be"
                    state = DROP
                    continue
                state = LETTERS
                behind_ret = at + 1
                values = unpack(data[at - size : at])
                if highest is not None:
                    if line is PenReply and values[0] in b"01":
                        values = (values[0] - 0x30,)
                    if values[0] > highest:
                        errors.append((start, at + 1 - start, f"{line.name()}: value out of range"))
                        continue
                messages.append((start, line, values))
                direct = line is SelectDirect
            elif state == LETTERS:
                start = at
                if byte in first:
                    line, size, unpack, highest = first[byte]
                    left = size
                    state = ARGUMENTS if size else RET
                elif byte in seconds:
                    second = seconds[byte]
                    state = SECOND_LETTER
                elif byte == CR:
                    messages.append((at, EmptyLine, ()))
                    behind_ret = at + 1
                elif byte != LF or at != behind_ret:
                    wrong = f"unknown letter {shown(byte)}"
                    state = DROP
            elif state == SECOND_LETTER:
                if byte in second:
                    line, size, unpack, highest = second[byte]
                    left = size
                    state = ARGUMENTS if size else RET
                elif byte == CR:
                    errors.append((start, 2, f"RET after {chr(data[start])!r}"))
                    state = LETTERS
                    behind_ret = at + 1
                else:
                    wrong = f"unknown letter {shown(byte)} after {chr(data[start])!r}"
                    state = DROP
            elif byte == CR:
                errors.append((start, at + 1 - start, wrong))
                state = LETTERS
                behind_ret = at + 1
            elif at - start == walter.MAX_RAW - 1:
                errors.append((start, walter.MAX_RAW, wrong))
                start = at + 1
        return messages, errors

    return decode


def capture(
    types: tuple[Any, ...], encode: Callable[[Any], bytes], count: int, chance: random.Random
) -> bytes:
    """Messages of all types, with all values, one as likely as the other."""
    made = chance.choices(types, k=count)
    return b"".join(encode(t(*(chance.randint(f.low, f.high) for f in t.FIELDS))) for t in made)


def noisy(data: bytes, chance: random.Random) -> bytes:
    """The same with some bytes replaced."""
    return bytes(chance.randrange(256) if chance.random() < NOISE else byte for byte in data)


def loads(count: int) -> list[Load]:
    """All of them."""
    chance = random.Random(1)
    direct = walter.Mode.DIRECT

    def walter_load(title: str, types: tuple[Any, ...]) -> Load:
        return Load(
            title,
            capture(types, walter.encode, count, chance),
            walter_bulk.decode_commands,
            lambda data: list(walter.CommandDecoder().receive_data(data)),
            plain_walter(COMMANDS),
        )

    return [
        Load(
            "simple, commands",
            capture(simple_messages.COMMANDS, simple.encode, count, chance),
            simple_bulk.decode_commands,
            lambda data: list(simple.CommandDecoder().receive_data(data)),
            plain_commands,
        ),
        Load(
            "simple, replies",
            capture(simple_messages.REPLIES, simple.encode, count, chance),
            simple_bulk.decode_replies,
            lambda data: list(simple.ReplyDecoder().receive_data(data)),
            plain_replies,
        ),
        walter_load("walter, moves", MOVES),
        walter_load("walter, all lines", LINES),
        Load(
            "walter, direct control",
            capture(KEYS, walter.encode, count, chance),
            lambda data: walter_bulk.decode_commands(data, direct),
            lambda data: list(walter.CommandDecoder(direct).receive_data(data)),
            plain_walter(COMMANDS, direct),
        ),
        Load(
            "walter, replies",
            capture(walter_messages.ROBOT_MESSAGES, walter.encode, count, chance),
            walter_bulk.decode_replies,
            lambda data: list(walter.ReplyDecoder().receive_data(data)),
            plain_walter(walter_messages.ROBOT_MESSAGES),
        ),
    ]


def seconds(decode: Callable[[bytes], Any], data: bytes) -> float:
    """The processor's time for one round, without the collector."""
    gc.collect()
    gc.disable()
    try:
        begin = time.process_time()
        made = decode(data)
        taken = time.process_time() - begin
        del made
    finally:
        gc.enable()
    return taken


def found(items: list[Any]) -> Found:
    """The same as the plain machines give."""
    messages = [(i.offset, type(i.message), i.message.values()) for i in items if isinstance(i, Decoded)]
    return messages, [(i.offset, len(i.raw), i.reason) for i in items if isinstance(i, Malformed)]


def measured(load: Load, data: bytes, rounds: int) -> dict[str, float]:
    """Nanoseconds for a byte, by way; all must find the same."""
    items = load.streaming(data)
    assert load.bulk(data).items() == items, load.title
    assert load.plain(data) == found(items), load.title
    del items
    ways = {"bulk": load.bulk, "streaming": load.streaming, "plain": load.plain}
    best = dict.fromkeys(ways, float("inf"))
    for _ in range(rounds):
        for name, way in ways.items():
            # It takes so little time that whatever else the machine does could be most of it.
            for _ in range(5 if name == "bulk" else 1):
                best[name] = min(best[name], seconds(way, data))
    return {name: taken / len(data) * 1e9 for name, taken in best.items()}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--messages", type=int, default=200_000, help="how many messages a capture has")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    chance = random.Random(2)
    results: list[dict[str, Any]] = []
    for load in loads(options.messages):
        for noise, data in ((0.0, load.data), (NOISE, noisy(load.data, chance))):
            ns = measured(load, data, options.rounds)
            result: dict[str, Any] = {"capture": load.title, "noise": noise}
            result |= {f"{name}_ns_per_byte": round(taken, 2) for name, taken in ns.items()}
            result |= {f"times_{name}": round(ns[name] / ns["bulk"], 1) for name in ("streaming", "plain")}
            results.append(result)
    if options.json:
        json.dump({"python": sys.version.split()[0], "results": results}, sys.stdout, indent=1)
        print()
        return
    print(f"  {'':24}{'noise':>6}{'bulk':>14}{'streaming':>16}{'plain':>16}")
    for result in results:
        print(f"  {result['capture']:24}{result['noise']:>6.0%}{result['bulk_ns_per_byte']:>9} ns/B", end="")
        print("".join(f"{result[f'times_{name}']:>14} x" for name in ("streaming", "plain")))


if __name__ == "__main__":
    main()
