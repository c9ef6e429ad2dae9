"""Every decoder against any bytes in any chunking: briefly here, for 10,000,000 inputs each by ``make nightly``."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.fuzz.fuzz import PIECES, by_chance
from tests.fuzz.targets import TARGETS, chunks

ROOT = Path(__file__).parents[2]
NIGHTLY_INPUTS = 10_000_000
each_target = pytest.mark.parametrize("target", TARGETS)


def fuzz(target: str, runs: int, corpus: Path) -> None:
    """In a process of its own: atheris wants one."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.fuzz.fuzz", target, str(runs), str(corpus)],
        cwd=ROOT,
        capture_output=True,
        check=False,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"Done {runs} runs" in done.stdout + done.stderr


@each_target
@settings(deadline=None, max_examples=60)
@given(data=st.lists(st.sampled_from(PIECES) | st.binary(max_size=6), max_size=40).map(b"".join))
def test_any_pieces(target: str, data: bytes) -> None:
    for chunking in (0, 1, 7, 255):
        TARGETS[target](data, chunking)


@each_target
def test_inputs_by_chance(target: str) -> None:
    for seed in range(200):
        TARGETS[target](by_chance(seed))


@each_target
def test_a_short_run(target: str, tmp_path: Path) -> None:
    fuzz(target, 1500, tmp_path)


@pytest.mark.nightly
@pytest.mark.timeout(6 * 3600)
@each_target
def test_a_long_run(target: str, tmp_path: Path) -> None:
    fuzz(target, NIGHTLY_INPUTS, tmp_path)


@pytest.mark.parametrize("seed", [0, 1, 2, 7, 100, 254, 255])
def test_chunks_are_the_data(seed: int) -> None:
    data = bytes(range(200))
    pieces = list(chunks(data, seed))
    assert b"".join(pieces) == data
    assert all(pieces)
    assert seed not in (0, 255) or len(pieces) == {0: 200, 255: 1}[seed]


def test_a_decoder_that_depends_on_the_chunking_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A line feed at the beginning of a piece is passed over even where it should not."""
    from turtlewire.protocols.walter.codec import CommandDecoder

    right = CommandDecoder.receive_data

    def wrong(self: CommandDecoder, data: bytes) -> object:
        return right(self, data.removeprefix(b"?"))

    monkeypatch.setattr(CommandDecoder, "receive_data", wrong)
    with pytest.raises((AssertionError, ValueError)):
        TARGETS["walter-host"](b"F\0\xc8\r?\r??", chunking=0)
