"""How much faster than one byte after the other a whole capture of simple or WALTER is decoded to columns.

The same captures go through ``bulk`` (columns), through the streaming decoders (an object for each message, with its
place and bytes), and through state machines as short as they can be written (an object for each message, and not a word
about what is wrong). All three must find the same messages. Rounds alternate,
the best of each counts, and ratios are to that of ``bulk``. With ``--json`` the numbers come as JSON.
"""

from __future__ import annotations

import argparse
import gc
import json
import random
import sys
import time
from typing import TYPE_CHECKING, Any, NamedTuple

from turtlewire.protocols.message import KINDS, Decoded
from turtlewire.protocols.simple import bulk as simple_bulk
from turtlewire.protocols.simple import codec as simple
from turtlewire.protocols.simple import messages as simple_messages
from turtlewire.protocols.walter import bulk as walter_bulk
from turtlewire.protocols.walter import codec as walter
from turtlewire.protocols.walter import messages as walter_messages

if TYPE_CHECKING:
    from collections.abc import Callable

NOISE = 0.01  # so many bytes are replaced by any others
COMMANDS = tuple(t for t in walter_messages.LOGO_COMMANDS if t is not walter_messages.EmptyLine)
LINES = tuple(t for t in COMMANDS if t is not walter_messages.SelectDirect)
MOVES = (walter_messages.Forward, walter_messages.Right, walter_messages.PenUp, walter_messages.PenDown)
KEYS = tuple(t for t in walter_messages.DIRECT_KEYS if t is not walter_messages.SelectLogo)


class Load(NamedTuple):
    """A kind of capture, and the three ways to decode it."""

    title: str
    data: bytes
    bulk: Callable[[bytes], Any]
    streaming: Callable[[bytes], list[Any]]
    plain: Callable[[bytes], list[Any]]


def plain_simple(data: bytes) -> list[Any]:
    """One byte after the other, as firmware would."""
    types: dict[int, Any] = {t.LETTER[0]: t for t in simple_messages.COMMANDS}
    lights = types[ord("H")]
    out: list[Any] = []
    count = number = 0
    good = False
    bits: list[int] = []
    made: Any = None
    for byte in data:
        if count == 0:
            made = types.get(byte)
            good = made is not None
            number = 0
            bits = []
        elif made is None or not made.FIELDS:
            pass
        elif made is lights:
            if count <= 4:
                good = good and 48 <= byte <= 57
                bits.append(1 if byte != 48 else 0)
        elif count <= 3:
            good = good and 48 <= byte <= 57
            number = number * 10 + byte - 48
        count += 1
        if count == 7:
            count = 0
            if good and number <= 255:
                out.append(made(*bits) if bits else made(number) if made.FIELDS else made())
    return out


def plain_replies(data: bytes) -> list[Any]:
    """One byte after the other."""
    types: dict[int, Any] = {t.LETTER[0]: t for t in simple_messages.REPLIES}
    out = []
    for byte in data:
        made = types.get(byte)
        if made is not None:
            out.append(made())
    return out


def plain_walter(
    lines: tuple[Any, ...], mode: walter.Mode = walter.Mode.LOGO
) -> Callable[[bytes], list[Any]]:
    """One byte after the other: letters, arguments, RET, or a line to drop; or keys."""
    forms: dict[bytes, Any] = {}
    for t in lines:
        for letters in (t.LETTERS, t.LETTERS.lower()):
            forms[letters] = (t, sum(KINDS[f.kind][0] for f in t.FIELDS))
    prefixes = {letters[:1] for letters in forms}
    keys: dict[int, Any] = {}
    for key in walter_messages.DIRECT_KEYS:
        keys[key.LETTERS[0]] = keys[key.LETTERS.lower()[0]] = key

    def decode(data: bytes) -> list[Any]:
        direct = mode is walter.Mode.DIRECT
        state = size = 0
        out: list[Any] = []
        letters = b""
        arguments: list[int] = []
        made: Any = None
        after_ret = False
        for byte in data:
            if after_ret:
                after_ret = False
                if byte == 10:
                    continue
            if direct:
                if made is not None:
                    out.append(made(byte))
                    made = None
                    continue
                made = keys.get(byte)
                if made is None:
                    if byte == 13:
                        out.append(walter_messages.EmptyLine())
                        after_ret = True
                elif not made.FIELDS:
                    out.append(made())
                    direct = made is not walter_messages.SelectLogo
                    made = None
            elif state == 0:
                if byte == 13:
                    if not letters:
                        out.append(walter_messages.EmptyLine())
                    letters = b""
                    after_ret = True
                    continue
                letters += bytes((byte,))
                form = forms.get(letters) or forms.get(letters.upper())
                if form is not None:
                    made, size = form
                    arguments = []
                    letters = b""
                    state = 1 if size else 2
                elif len(letters) > 1 or letters not in prefixes:
                    letters = b""
                    state = 3
            elif state == 1:
                arguments.append(byte)
                if len(arguments) == size:
                    state = 2
            elif state == 2:
                if byte != 13:
                    state = 3
                    continue
                state = 0
                after_ret = True
                values = []
                at = 0
                for field in made.FIELDS:
                    value = arguments[at]
                    at += 1
                    if field.kind in ("u16", "i16"):
                        value = value << 8 | arguments[at]
                        at += 1
                        if field.kind == "i16" and value > 32767:
                            value -= 65536
                    elif field.kind == "bit" and value in (48, 49):
                        value -= 48
                    if not field.low <= value <= field.high:
                        break
                    values.append(value)
                else:
                    out.append(made(*values))
                    direct = made is walter_messages.SelectDirect
                made = None
            elif byte == 13:
                state = 0
                after_ret = True
        return out

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
            plain_simple,
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
    """How long one round takes, without the collector."""
    gc.collect()
    gc.disable()
    try:
        begin = time.perf_counter()
        made = decode(data)
        taken = time.perf_counter() - begin
        del made
    finally:
        gc.enable()
    return taken


def measured(load: Load, data: bytes, rounds: int) -> dict[str, float]:
    """Nanoseconds for a byte, by way; all must find the same messages."""
    items = load.streaming(data)
    messages = [item.message for item in items if isinstance(item, Decoded)]
    assert load.bulk(data).items() == items, load.title
    assert load.plain(data) == messages, load.title
    del items, messages
    ways = {"bulk": load.bulk, "streaming": load.streaming, "plain": load.plain}
    best = dict.fromkeys(ways, float("inf"))
    for _ in range(rounds):
        for name, way in ways.items():
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
