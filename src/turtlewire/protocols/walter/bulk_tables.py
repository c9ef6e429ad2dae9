"""What the bulk decoder of WALTER looks up: by the first two bytes of a line what it is, by a key what it means."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from turtlewire.protocols.columns import Reasons
from turtlewire.protocols.message import KINDS
from turtlewire.protocols.walter.codec import CR, CommandDecoder, Item, Mode, ReplyDecoder
from turtlewire.protocols.walter.messages import (
    DIRECT_KEYS,
    LOGO_COMMANDS,
    ROBOT_MESSAGES,
    DirectKey,
    EmptyLine,
    SelectDirect,
    WalterMessage,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from turtlewire.protocols.message import Field

NOTHING = 254  # stands where the number of a type would: what is here belongs to something else
NONE = 255  # the number of no type

# Codes of what is wrong: so many for each byte that may stand where RET must be; for each type with a value that is
# none; for each byte that is no key; and then for letters.
WRONG_RET, WRONG_VALUE, WRONG_KEY, _WRONG_LETTERS = range(0, 1024, 256)

Types = tuple[type[WalterMessage], ...]


class Tables(NamedTuple):
    """What is looked up; the number of a type is its index in ``types``. Lines that have fields come first.

    Attributes:
        types: all types, and how long a message of each is, with a lone CR for its RET.
        lines: of the first two bytes of a line, 256 times the place of the byte that decides about it (RET, or a
            wrong letter), plus the number, or ``NONE``.
        wrong_letters: of the first two bytes of a line whose letters are wrong, the code.
        direct: the number of the change to direct control, or ``NOTHING``.
        line_fields: types of lines that have fields, by number.
        narrow: numbers of those of which not every value is one.
        keys: the number of each key, or ``NONE``.
        key_fields: types of keys that take a byte, by number.
        takes: these keys.
        reasons: what is wrong, by code.
    """

    types: dict[type[WalterMessage], int]
    lines: NDArray[np.uint16]
    wrong_letters: NDArray[np.uint16]
    direct: int
    line_fields: dict[int, type[WalterMessage]]
    narrow: frozenset[int]
    keys: bytes
    key_fields: dict[int, type[WalterMessage]]
    takes: bytes
    reasons: Reasons


@cache
def of_commands(groups: frozenset[str]) -> Tables:
    """For the way to a robot that has these groups of commands (W10)."""
    lines = tuple(t for t in LOGO_COMMANDS if not t.GROUP or t.GROUP in groups)
    return _tables(lines, DIRECT_KEYS, lambda data, mode: CommandDecoder(mode, groups).receive_data(data))


@cache
def of_replies() -> Tables:
    """For the way from a robot."""
    return _tables((*ROBOT_MESSAGES, EmptyLine), (), lambda data, _: ReplyDecoder().receive_data(data))


def _length(message_type: type[WalterMessage]) -> int:
    ret = not issubclass(message_type, DirectKey)
    return len(message_type.LETTERS) + sum(KINDS[field.kind][0] for field in message_type.FIELDS) + ret


def _is_narrow(field: Field) -> bool:
    return field.high - field.low + 1 < 1 << 8 * KINDS[field.kind][0]


def _cases(letters: bytes) -> list[list[int]]:
    """Both cases of each letter (W2)."""
    return [sorted({letter, *bytes([letter]).lower()}) for letter in letters]


def _tables(lines: Types, keys: Types, decode: Callable[[bytes, Mode], list[Item]]) -> Tables:
    lines = tuple(sorted(lines, key=lambda t: not t.FIELDS))
    types = (*lines, *keys)
    number = np.full((256, 256), NONE, np.uint16)
    decides = np.zeros((256, 256), np.uint16)
    for at, message_type in enumerate(lines):
        if message_type is EmptyLine:
            number[CR] = at
            continue
        first, *second = _cases(message_type.LETTERS)
        if second:
            decides[first] = np.maximum(decides[first], 1)
        place = np.ix_(first, *second) if second else (first,)
        number[place] = at
        decides[place] = _length(message_type) - 1
    key = bytearray([NONE]) * 256
    key[CR] = types.index(EmptyLine)
    for at, message_type in enumerate(keys, len(lines)):
        for letter in _cases(message_type.LETTERS)[0]:
            key[letter] = at
    key_fields = {at: t for at, t in enumerate(keys, len(lines)) if t.FIELDS}
    wrong_letters = np.empty((256, 256), np.uint16)
    letters: list[bytes] = []
    for byte in range(256):
        # The second one is looked at only if the first may begin a line of two.
        followers = range(256 if decides[byte].min() == 1 else 1)
        wrong_letters[byte] = np.arange(256) % len(followers) + len(letters) + _WRONG_LETTERS
        letters += [bytes([byte, follower]) for follower in followers]
    plain_line = next(t.LETTERS for t in lines if t.LETTERS and not t.FIELDS)

    def reason(code: int) -> str:
        mode = Mode.LOGO
        if code >= _WRONG_LETTERS:
            example = letters[code - _WRONG_LETTERS]
        elif code >= WRONG_KEY:
            example, mode = bytes([code - WRONG_KEY]), Mode.DIRECT
        elif code >= WRONG_VALUE:
            wrong = types[code - WRONG_VALUE]
            example = wrong.LETTERS.ljust(_length(wrong) - 1, b"\xff")
        else:
            example = plain_line + bytes([code - WRONG_RET])
        return str(decode(example + b"\r", mode)[0][2])

    return Tables(
        types={t: _length(t) for t in types},
        lines=(decides << np.uint16(8) | number).ravel(),
        wrong_letters=wrong_letters.ravel(),
        direct=types.index(SelectDirect) if SelectDirect in types else NOTHING,
        line_fields={at: t for at, t in enumerate(lines) if t.FIELDS},
        narrow=frozenset(at for at, t in enumerate(lines) if any(map(_is_narrow, t.FIELDS))),
        keys=bytes(key),
        key_fields=key_fields,
        takes=bytes(letter for letter in range(256) if key[letter] in key_fields),
        reasons=Reasons(_WRONG_LETTERS + len(letters), reason),
    )
