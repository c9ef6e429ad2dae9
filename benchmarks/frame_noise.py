"""How many intact frames a decoder loses among damaged ones.

python benchmarks/frame_noise.py [frames]    (one million by default)

Random bytes of a stream are replaced by others, at 0.1% and at 1%. A frame none of whose bytes was touched is intact,
and should come out; what makes one get lost is a false beginning, or damage before it, whose CRC is right by chance.
Beside it, a decoder that throws a bad frame's bytes away instead of looking again after its first.
"""

from __future__ import annotations

import random
import sys

from turtlewire.protocols.frame.codec import Frame, FrameDecoder, FrameEncoder, frame_bytes
from turtlewire.protocols.frame.dialect import Dialect, shipped

LIMITS_PERCENT = {0.001: 0.005, 0.01: 0.02}
PIECE = 4096


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


def main() -> None:
    """Measure and print; fail where a limit is broken."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    dialect = shipped("0.1").configured(counts={"servos": 256, "engines": 256})
    failed = False
    for rate, limit in LIMITS_PERCENT.items():
        chance = random.Random(7)
        encoder = FrameEncoder(dialect)
        lost = thrown = intact = 0
        for begin in range(0, count, 10_000):  # in parts, so that memory stays small
            starts: list[int] = []
            stream = bytearray()
            for _ in range(min(10_000, count - begin)):
                starts.append(len(stream))
                payload = bytes((chance.randrange(3), chance.randrange(256), chance.randrange(181)))
                stream += frame_bytes(dialect, encoder.seq, payload)
                encoder.seq = (encoder.seq + 1) % 256
            hits = set()
            for _ in range(round(rate * len(stream))):
                place = chance.randrange(len(stream))
                byte = stream[place]
                while stream[place] == byte:
                    stream[place] = chance.randrange(256)
                hits.add(place // 7)
            data = bytes(stream)
            whole = {start for n, start in enumerate(starts) if n not in hits}
            decoder = FrameDecoder(dialect)
            items = [
                item
                for at in range(0, len(data), PIECE)
                for item in decoder.receive_data(data[at : at + PIECE])
            ]
            found = {item.offset for item in items + decoder.end() if isinstance(item, Frame)}
            intact += len(whole)
            lost += len(whole - found)
            thrown += len(whole - throwing_away(dialect, data))
        percent = 100 * lost / intact
        print(
            f"{100 * rate:g}% byte errors: {lost} of {intact} intact frames lost, {percent:.4f}% "
            f"(limit {limit}%); throwing bad frames away: {100 * thrown / intact:.2f}%"
        )
        failed |= percent > limit
    if failed:
        sys.exit("more intact frames were lost than may be")


if __name__ == "__main__":
    main()
