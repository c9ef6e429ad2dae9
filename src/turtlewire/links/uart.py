"""What a UART hears that listens at another rate than the bytes were sent at: their image.

Bytes sent 8N1 are a waveform: a low start bit, eight data bits with the lowest first, a high stop bit; between bytes
the line is high. A receiver waits for the line to fall, looks in the middle of what should be the start bit whether
it is still low, and then once in each bit *of its own* rate. At the same rate these are the bits that were sent. At
another they are other bits: another byte, several bytes, or none.

Only the ratio of the two rates matters.
"""

from __future__ import annotations

from typing import NamedTuple

BITS = 10  # 8N1: a start bit, eight of data, a stop bit
_DATA_BITS = 8


class Receiver(NamedTuple):
    """What UARTs do differently. The default is what an Arduino does, and what Linux does with a 16550.

    Attributes:
        sample: where within a bit the line is looked at, as a part of the bit; 0.5 is the middle.
        keeps_broken: whether a byte whose stop bit is low (a framing error) is delivered all the same.
        waits_for_high: whether after such a byte the line must be high before it can fall again; otherwise the low
            stop bit is taken for the next start bit.
    """

    sample: float = 0.5
    keeps_broken: bool = True
    waits_for_high: bool = True


ARDUINO = Receiver()
RECEIVERS = tuple(Receiver(0.5, keeps, waits) for keeps in (True, False) for waits in (True, False))


def image(data: bytes, ratio: float, receiver: Receiver = ARDUINO) -> bytes:
    """What is heard of bytes that were sent one directly behind the other on an idle line, which is idle afterwards.

    Args:
        data: the bytes that were sent.
        ratio: the receiver's rate, in units of the sender's: 2.0 is a receiver that listens twice as fast. Above 0.
        receiver: what kind of UART listens.
    """
    line = _levels(data)
    falls = [at for at in range(1, len(line)) if line[at] < line[at - 1]]
    bit = 1.0 / ratio  # of the receiver, in bits of the sender
    middle = receiver.sample * bit
    heard = bytearray()
    next_fall = 0
    at = -1.0  # when the receiver was ready for a start bit
    while True:
        while next_fall < len(falls) and falls[next_fall] <= at:
            next_fall += 1
        if next_fall == len(falls):
            return bytes(heard)
        start = float(falls[next_fall])
        at = start + middle
        if _is_high(line, at):
            continue  # a pulse too short for a start bit
        while True:
            byte = 0
            for number in range(_DATA_BITS):
                byte |= _is_high(line, start + middle + (1 + number) * bit) << number
            at = start + middle + (BITS - 1) * bit
            is_whole = _is_high(line, at)
            if is_whole or receiver.keeps_broken:
                heard.append(byte)
            if is_whole or receiver.waits_for_high:
                break
            start = at - middle


def _levels(data: bytes) -> list[int]:
    """The line bit by bit: idle, then the bytes; idle afterwards is not in it."""
    levels = [1]
    for byte in data:
        levels.append(0)
        levels += [byte >> number & 1 for number in range(_DATA_BITS)]
        levels.append(1)
    return levels


def _is_high(line: list[int], at: float) -> bool:
    return at >= len(line) or line[int(at)] == 1
