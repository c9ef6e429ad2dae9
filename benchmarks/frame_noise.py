"""How many intact frames a decoder loses among damaged ones.

python benchmarks/frame_noise.py [frames]    (one million by default)

Every byte of a stream of 7-byte frames is hit with a probability of 0.1%, or 1%: replaced by a random one, or one bit
of it flipped. A frame none of whose bytes changed is intact and should come out; what makes one get lost is a false
beginning, or a damaged size, with a CRC that is right by chance (1 in 256), and then several frames at once. So the
figure scatters: its standard error is printed. Beside it, a decoder that throws a bad frame's bytes away instead of
looking again after its first one.
"""

from __future__ import annotations

import itertools
import random
import statistics
import sys

from turtlewire.protocols.frame.codec import Frame, FrameDecoder, frame_bytes
from turtlewire.protocols.frame.dialect import Dialect, shipped

LIMITS_PERCENT = {0.001: 0.005, 0.01: 0.02}
PIECE = 4096
PART = 10_000


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


def damaged(data: bytes, rate: float, chance: random.Random, *, flip: bool) -> bytes:
    """A stream with some of its bytes hit."""
    out = bytearray(data)
    for place in range(len(out)):
        if chance.random() < rate:
            out[place] = out[place] ^ 1 << chance.randrange(8) if flip else chance.randrange(256)
    return bytes(out)


def main() -> None:
    """Measure and print; fail where a limit is clearly broken."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    dialect = shipped("0.1").configured(counts={"servos": 256, "engines": 256})
    failed = False
    for (rate, limit), flip in itertools.product(LIMITS_PERCENT.items(), (False, True)):
        chance = random.Random(7)
        thrown = 0
        lost: list[int] = []
        intact: list[int] = []
        for _ in range(0, count, PART):
            data = b"".join(
                frame_bytes(dialect, n % 256, bytes((chance.randrange(3), *chance.randbytes(2))))
                for n in range(PART)
            )
            noisy = damaged(data, rate, chance, flip=flip)
            whole = {at for at in range(0, len(data), 7) if data[at : at + 7] == noisy[at : at + 7]}
            decoder = FrameDecoder(dialect)
            items = [
                item
                for at in range(0, len(noisy), PIECE)
                for item in decoder.receive_data(noisy[at : at + PIECE])
            ]
            found = {item.offset for item in items + decoder.end() if isinstance(item, Frame)}
            intact.append(len(whole))
            lost.append(len(whole - found))
            thrown += len(whole - throwing_away(dialect, noisy))
        total = sum(intact)
        percent = 100 * sum(lost) / total
        error = 100 * statistics.stdev(lost) * len(lost) ** 0.5 / total
        print(
            f"{100 * rate:g}% byte errors, {'bits flipped' if flip else 'bytes replaced'}: of {total} intact frames "
            f"{percent:.4f}% lost, +- {error:.4f} (limit {limit}%); throwing bad frames away: "
            f"{100 * thrown / total:.2f}%"
        )
        failed |= percent - 2 * error > limit
    if failed:
        sys.exit("more intact frames were lost than may be")


if __name__ == "__main__":
    main()
