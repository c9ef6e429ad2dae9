"""Fuzz a decoder: ``python -m tests.fuzz.fuzz TARGET [RUNS]``.

With atheris (``pip install -e '.[fuzz]'``) the inputs are led by what they reach in the code; without it they are
made by chance from pieces of real traffic, from a fixed seed. Either way RUNS inputs are tried, or for ever.
"""

from __future__ import annotations

import importlib
import importlib.util
import random
import sys
from itertools import count
from typing import Any

MAX_INPUT_BYTES = 512
# What each protocol is full of: the beginnings of most inputs that lead anywhere.
PIECES = (
    b"F\0\xc8\r", b"2\r", b"1", b" ", b"QH\0\x5a\r", b"LF\r", b"\r\n", b"CL\0\0\0\0\r", b"S000000", b"F120000",
    b"H1100--", b"K", b"\xa3\0\0\0", b"\xa3\0\x03\x01\0\xc8\x8b", b"\xa3\x05\x7c", b"\xa3", b"\x10", b"\0",
    b'{"t_ns":1,"from":"host","raw":"46"}\n',
)  # fmt: skip


def by_chance(seed: int) -> bytes:
    """One input: pieces of traffic, whole or damaged, and noise."""
    chance = random.Random(seed)
    data = bytearray(chance.randbytes(1))
    for _ in range(chance.randrange(30)):
        piece = bytearray(
            chance.choice(PIECES) if chance.random() < 0.7 else chance.randbytes(chance.randrange(9))
        )
        if piece and chance.random() < 0.2:
            piece[chance.randrange(len(piece))] = chance.randrange(256)
        data += piece
    return bytes(data[:MAX_INPUT_BYTES])


def main(target: str, runs: int | None) -> None:
    """Try inputs; the first that breaks what must hold ends this with a traceback."""
    if importlib.util.find_spec("atheris") is not None:
        _led(target, runs)
        return
    from tests.fuzz.targets import TARGETS

    for seed in count() if runs is None else range(runs):
        TARGETS[target](by_chance(seed))
    print(f"Done {runs} runs, by chance")


def _led(target: str, runs: int | None) -> None:
    # It has no types.
    atheris: Any = importlib.import_module("atheris")
    with atheris.instrument_imports(include=["turtlewire.protocols", "turtlewire.capture"]):
        from tests.fuzz.targets import TARGETS
    options = [sys.argv[0], f"-max_len={MAX_INPUT_BYTES}", "-timeout=10", "-seed=1", "-print_final_stats=1"]
    if runs is not None:
        options.append(f"-runs={runs}")
    atheris.Setup(options, TARGETS[target])
    atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else None)
