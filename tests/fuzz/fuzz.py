"""Fuzz a decoder: ``python -m tests.fuzz.fuzz TARGET [RUNS [CORPUS]]``.

With atheris (``pip install -e '.[fuzz]'``) the inputs are led by what they reach in the code; without it they are
made by chance from pieces of real traffic, from a fixed seed. Either way RUNS inputs are tried, or for ever. CORPUS is
a folder: inputs made by chance are put there for atheris to begin with, and it adds what leads somewhere new.
"""

from __future__ import annotations

import importlib
import importlib.util
import random
import sys
from itertools import count
from pathlib import Path
from types import FunctionType
from typing import TYPE_CHECKING, Any

from turtlewire.protocols.frame.codec import frame_bytes
from turtlewire.protocols.frame.dialect import shipped

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import ModuleType

    from turtlewire.protocols.frame.dialect import Dialect

MAX_INPUT_BYTES = 512
BY_CHANCE = 500
# Modules whose branches tell atheris which inputs lead somewhere new.
LEADING = (
    "turtlewire.capture",
    "turtlewire.protocols.stream",
    "turtlewire.protocols.frame.codec",
    "turtlewire.protocols.frame.runs",
    "turtlewire.protocols.simple.codec",
    "turtlewire.protocols.walter.codec",
)


def in_a_row(dialect: Dialect, payload: bytes) -> bytes:
    """So many frames that they are decoded together."""
    return b"".join(frame_bytes(dialect, seq, payload) for seq in range(20))


# What each protocol is full of: the beginnings of most inputs that lead anywhere.
PIECES = (
    b"F\0\xc8\r", b"2\r", b"1", b" ", b"QH\0\x5a\r", b"LF\r", b"\r\n", b"CL\0\0\0\0\r", b"S000000", b"F120000",
    b"H1100--", b"K", b"\xa3\0\0\0", b"\xa3\0\x03\x01\0\xc8\x8b", b"\xa3\x05\x7c", b"\xa3", b"\x10", b"\0",
    b'{"t_ns":1,"from":"host","raw":"46"}\n', in_a_row(shipped("0.1"), b""), in_a_row(shipped("0.1"), b"\1\0\xc8"),
    in_a_row(shipped("telemetry").configured(coverage="payload"), b""),
)  # fmt: skip


def by_chance(seed: int) -> bytes:
    """One input: pieces of traffic, whole or damaged, and noise."""
    chance = random.Random(seed)
    data = bytearray()
    for _ in range(chance.randrange(30)):
        piece = bytearray(
            chance.choice(PIECES) if chance.random() < 0.7 else chance.randbytes(chance.randrange(9))
        )
        if piece and chance.random() < 0.2:
            piece[chance.randrange(len(piece))] = chance.randrange(256)
        data += piece
    return bytes(data[:MAX_INPUT_BYTES])


def functions(module: ModuleType) -> Iterator[FunctionType]:
    """All functions and methods of a module."""
    for value in vars(module).values():
        if getattr(value, "__module__", None) == module.__name__:
            members = vars(value).values() if isinstance(value, type) else [value]
            yield from (member for member in members if isinstance(member, FunctionType))


def main(target: str, runs: int | None, corpus: Path | None) -> None:
    """Try inputs; the first that breaks what must hold ends this with a traceback."""
    if importlib.util.find_spec("atheris") is not None:
        _led(target, runs, corpus)
        return
    from tests.fuzz.targets import TARGETS

    for seed in count() if runs is None else range(runs):
        TARGETS[target](by_chance(seed))
    print(f"Done {runs} runs, by chance")


def _led(target: str, runs: int | None, corpus: Path | None) -> None:
    # They have no types.
    atheris: Any = importlib.import_module("atheris")
    patch_code: Any = importlib.import_module("atheris.instrument_bytecode").patch_code
    from tests.fuzz.targets import TARGETS

    # Only decoders lead. The values that they compare do not: these are single bytes, and found by chance as well.
    for name in LEADING:
        for function in functions(importlib.import_module(name)):
            function.__code__ = patch_code(function.__code__, trace_dataflow=False)
    # A branch is reported once for each input: how often it is taken would more than double the time.
    reached: set[int] = set()
    report = atheris._trace_branch
    atheris._trace_branch = reached.add
    check = TARGETS[target]

    def check_and_report(data: bytes) -> None:
        reached.clear()
        check(data)
        for branch in reached:
            report(branch)

    options = [sys.argv[0], f"-max_len={MAX_INPUT_BYTES}", "-timeout=10", "-seed=1", "-print_final_stats=1"]
    if runs is not None:
        options.append(f"-runs={runs}")
    if corpus is not None:
        corpus.mkdir(parents=True, exist_ok=True)
        for seed in range(BY_CHANCE):
            (corpus / f"{seed}").write_bytes(by_chance(seed))
        options.append(str(corpus))
    atheris.Setup(options, check_and_report)
    atheris.Fuzz()


if __name__ == "__main__":
    given = dict(enumerate(sys.argv))
    main(given[1], int(given[2]) if 2 in given else None, Path(given[3]) if 3 in given else None)
