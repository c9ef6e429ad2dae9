"""How many bits bytes take to write down, by what they are taken for: the fewer, the likelier that is."""

from __future__ import annotations

import math
import string
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections import Counter
    from collections.abc import Iterable, Mapping, Sequence

# Bytes are few bytes over and over when so many different ones are this part of them. It takes more than chance to
# believe that of a wire: so many bits.
FEW_DIFFERENT = 4
FEW_SHARE = 0.9
FEW_BITS = 12.0
# What it takes to say that frequencies are learned, or settled.
CHOICE_BITS = (1.0, 2.0)


def _bits(counts: Mapping[int, int], expected: Sequence[float]) -> float:
    """What symbols cost whose frequencies are learned on the way: each as if it had been seen so often before."""
    total = sum(expected)
    bits = math.lgamma(sum(counts.values()) + total) - math.lgamma(total)
    for symbol, n in counts.items():
        bits -= math.lgamma(n + expected[symbol]) - math.lgamma(expected[symbol])
    return bits / math.log(2.0)


def learned_bits(counts: Iterable[int], symbols: int) -> float:
    """Of so many symbols, nothing known beforehand: half a time each."""
    return _bits(dict(enumerate(counts)), [0.5] * symbols)


def settled_bits(counts: Iterable[int], symbols: int) -> float:
    """Of so many symbols, of which those that come are likeliest to come again."""
    return _bits(dict(enumerate(counts)), [1.0 / symbols] * symbols)


def opaque_bits(counts: Counter[int], *, doubts_few: bool = False) -> float:
    """Of bytes without structure: all alike, some more frequent than others, or few of them over and over."""
    learned, settled = CHOICE_BITS
    frequencies = counts.values()
    return min(
        8.0 * counts.total(),
        learned_bits(frequencies, 256) + learned,
        settled_bits(frequencies, 256) + (FEW_BITS if doubts_few and _are_few(counts) else settled),
    )


def text_bits(counts: Counter[int]) -> float:
    """Of logs and prose."""
    return _bits(counts, _TEXT)


def resemblance(counts: Counter[int]) -> str:
    """What bytes look like that are of no protocol."""
    if _are_few(counts):
        return "a few bytes over and over"
    printable = sum(n for byte, n in counts.items() if byte in _PRINTABLE)
    return "text" if printable >= 0.95 * counts.total() else "bytes without structure"


def _are_few(counts: Counter[int]) -> bool:
    return sum(n for _, n in counts.most_common(FEW_DIFFERENT)) >= FEW_SHARE * counts.total()


def _text_frequencies() -> tuple[float, ...]:
    """What logs and prose are made of, as if so many bytes of it had been seen: shares are in thousandths."""
    shares = {
        " ": 150, string.digits: 130, string.ascii_uppercase: 50, ".,:;-_/()[]='\"<>": 100, "\n": 25, "\r": 8, "\t": 5,
    }  # fmt: skip
    expected = [0.02] * 32 + [0.2] * 95 + [0.02] + [0.1] * 128
    for characters, share in shares.items():
        for character in characters:
            expected[ord(character)] = share / len(characters)
    for letter, share in zip("etaoinsrhldcumfpgwybvkxjqz", range(54, 2, -2), strict=True):
        expected[ord(letter)] = share * 0.72
    return tuple(expected)


_PRINTABLE = frozenset(string.printable.encode())
_TEXT = _text_frequencies()
