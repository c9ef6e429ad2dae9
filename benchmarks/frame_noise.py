"""How many intact frames a decoder loses among damaged ones.

python benchmarks/frame_noise.py [frames [seeds]]    (a million and ten by default; needs the extra ``bulk``)

Every byte of a stream of 7-byte frames is hit with a probability of 0.1%, or 1%: replaced by a random one, or one bit
of it flipped. A frame none of whose bytes changed is intact and should come out. One is lost only within what is taken
for a frame because its CRC, eight bits, is right by chance, 1 in 256: such a false frame begins with a damaged frame's
magic byte, when its size was hit, or with an A3 among the bytes of a damaged frame, and takes up to 124 bytes with it.
No receiver that keeps to the protocol does better (F3, F5). They are rare, and each takes many frames: so the figure
scatters. Printed are the mean over all seeds with its standard error, the least and the most that a seed gave, what
the CRC alone lets expect of damaged sizes, and what the false frames were.

Beside it, a decoder that throws a bad frame's bytes away instead of looking again after its first one.
"""

from __future__ import annotations

import itertools
import statistics
import sys
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from turtlewire.protocols.frame import bulk
from turtlewire.protocols.frame.codec import Frame, FrameDecoder
from turtlewire.protocols.frame.dialect import Dialect, shipped

if TYPE_CHECKING:
    from numpy.typing import NDArray

LIMITS_PERCENT = {0.001: 0.005, 0.01: 0.02}
SIZE = 7
CHECKED = 20_000  # so many frames of each stream are also decoded in pieces, and thrown away
PIECE = 4096


class Losses(NamedTuple):
    """What became of one stream's intact frames, and the false frames that took some of them.

    ``in_place`` of the false ones began with a frame's own magic byte; ``ignored`` of them said nothing that could be
    carried out.
    """

    intact: int
    lost: int
    false: int
    in_place: int
    ignored: int
    checked: int
    thrown: int


def stream(dialect: Dialect, count: int, chance: np.random.Generator) -> NDArray[np.uint8]:
    """Frames of one message of any type with any values, one row for each."""
    rows = np.empty((count, SIZE), np.uint8)
    rows[:, 0], rows[:, 1], rows[:, 2] = 0xA3, np.arange(count) % 256, 3
    rows[:, 3] = chance.integers(0, 3, count)
    rows[:, 4:6] = chance.integers(0, 256, (count, 2))
    crc = np.frombuffer(dialect.checksum.algorithm.table(), np.uint8)
    register = np.zeros(count, np.uint8)
    for place in range(SIZE - 1):
        register = crc[register ^ rows[:, place]]
    rows[:, 6] = register
    return rows


def damaged(
    rows: NDArray[np.uint8], rate: float, chance: np.random.Generator, *, flip: bool
) -> NDArray[np.uint8]:
    """The same with some of the bytes hit."""
    hit = chance.random(rows.shape) < rate
    bits = np.uint8(1) << chance.integers(0, 8, rows.shape, np.uint8)
    return np.where(hit, rows ^ bits if flip else chance.integers(0, 256, rows.shape, np.uint8), rows)


def throwing_away(dialect: Dialect, data: bytes) -> set[int]:
    """Where frames begin for a decoder that goes on behind a bad frame."""
    crc = dialect.checksum.algorithm.crc
    found, at = set(), data.find(0xA3)
    while 0 <= at < len(data) - 2:
        stop = at + data[at + 2] + 4
        if data[at + 2] > 124:
            stop = at + 3
        elif stop <= len(data) and not crc(data[at:stop]):
            found.add(at)
        at = data.find(0xA3, stop)
    return found


def streamed(dialect: Dialect, data: bytes) -> set[int]:
    """Where frames begin for the streaming decoder, ignored ones left out."""
    decoder = FrameDecoder(dialect)
    items = [
        item for at in range(0, len(data), PIECE) for item in decoder.receive_data(data[at : at + PIECE])
    ]
    return {item.offset for item in items + decoder.end() if isinstance(item, Frame)}


def losses(dialect: Dialect, count: int, rate: float, seed: int, *, flip: bool) -> Losses:
    """One stream."""
    chance = np.random.default_rng(seed)
    rows = stream(dialect, count, chance)
    noisy = damaged(rows, rate, chance, flip=flip)
    intact = np.flatnonzero((rows == noisy).all(axis=1)) * SIZE
    data = noisy.tobytes()
    capture = bulk.decode(data, dialect)
    lost = np.setdiff1d(intact, capture.offset, assume_unique=True)
    # The false frames that intact ones were lost in.
    false = np.unique(np.searchsorted(capture.offset, lost, "right") - 1)
    some = data[: CHECKED * SIZE]
    counted = capture.offset[capture.ignored == bulk.COUNTS]
    far = len(some) - 128  # beyond, a frame may have been cut off
    assert {at for at in streamed(dialect, some) if at < far} == set(counted[counted < far].tolist())
    near = set(intact[intact < len(some)].tolist())
    return Losses(
        len(intact),
        len(lost),
        len(false),
        int((capture.offset[false] % SIZE == 0).sum()),
        int((capture.ignored[false] != bulk.COUNTS).sum()),
        len(near),
        len(near - throwing_away(dialect, some)),
    )


def expected_percent(rate: float) -> float:
    """What damaged sizes alone should cost where bytes are replaced by any: 1 of 256 takes the frames begun within."""
    begun = sum(-(-(size + 4) // SIZE) - 1 for size in range(125) if size != 3)
    return 100 * rate * begun / 256 / 256


def main() -> None:
    """Measure and print; fail where a limit is clearly broken."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    seeds = int(sys.argv[2]) if len(sys.argv) > 2 else 10
    dialect = shipped("0.1").configured(counts={"servos": 256, "engines": 256})
    failed = False
    print(f"{count} frames, {seeds} seeds")
    for (rate, limit), flip in itertools.product(LIMITS_PERCENT.items(), (False, True)):
        found = [losses(dialect, count, rate, seed, flip=flip) for seed in range(seeds)]
        percents = [100 * one.lost / one.intact for one in found]
        percent = statistics.mean(percents)
        lost, false, in_place, ignored, checked, thrown = (
            sum(column) for column in list(zip(*found, strict=True))[1:]
        )
        # Of few seeds, the deviation says little; but false frames are rare, and independent.
        deviation = statistics.stdev(percents) / seeds**0.5 if seeds > 1 else 0.0
        error = max(deviation, percent / max(1, false) ** 0.5)
        print(
            f"{100 * rate:g}% byte errors, {'bits flipped' if flip else 'bytes replaced'}: of the intact frames "
            f"{percent:.4f}% +- {error:.4f} lost (limit {limit}%), by seed {min(percents):.4f}% to {max(percents):.4f}%"
        )
        if not flip:
            print(f"    expected of damaged sizes: {expected_percent(rate):.4f}%")
        print(
            f"    {false} false frames took {lost / max(1, false):.1f} each; {in_place} were frames with another "
            f"size, {false - in_place} began elsewhere; {ignored} were ignored (F3)"
        )
        print(f"    throwing bad frames away: {100 * thrown / checked:.2f}% lost")
        failed |= percent - 2 * error > limit
    if failed:
        sys.exit("more intact frames were lost than may be")


if __name__ == "__main__":
    main()
