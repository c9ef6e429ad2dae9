"""The bytes that are sent before anything is known, and at which rates.

They go one at a time, with a pause behind each: so whatever rate a robot listens at, it hears the image of one byte at
a time. What makes them safe, proven over all ratios of the two rates in tests/unit/examination/test_safety.py:

- 00 and FF are one low pulse each, nine bits and one bit long. A lone pulse is heard as 00, 80, C0, E0, F0, F8, FC, FE
  or FF at any rate: no letter, digit, key, RET or A3. What is not heard of one, too long or too short for the
  robot's UART, is heard of the other; a robot that hears neither hears nothing but pulses of any byte.
- So after ``FLUSH`` a robot has either heard seven of these bytes or more, or it never hears anything else.
  Seven fill up whatever command of simple an earlier host left half sent, and five make a cut-off line of WALTER
  ill-formed (W7).
- What follows, ``LOGO_PROBE``, has no image at any rate that is a letter of simple, or A3; and none that is a key
  which starts a motion, but for ``1``, which is heard as ``a`` at a rate a tenth to a quarter higher.
"""

from __future__ import annotations

from turtlewire.protocols.simple.messages import LENGTH

# Tried in this order: what the protocols' own pages say first (S6, W16, F12), then what people use.
BAUDS = (9600, 115200, 57600, 38400, 19200, 4800, 2400, 1200, 250000, 230400, 500000, 1000000)
# The slowest robot that is thought of.
SLOWEST_BAUD = 300
# Of what is sent at a rate, a robot hears nothing that listens slower than this part of it: the longest low pulse, of
# nine bits, is over before the middle of its start bit.
DEAF_BELOW = 1 / 18
# Computers wake late, adapters send in bursts: pauses are at least so long.
LEAST_PAUSE_S = 0.006
# Behind a socket there may be a serial line of any usual rate.
SOCKET_BAUD = 9600
BITS = 10

PULSES = (b"\x00", b"\xff")
FLUSH = b"".join(PULSES * LENGTH)
# W7 without its zeros, which FLUSH has sent; then the query QP, in lower case (W2). Q is heard as ``a`` by some UARTs;
# of the other queries' letters, L and H are letters of simple, X is a key that moves the pen, and Y is heard as one.
LOGO_PROBE = b"\r2\r 1\rqp\r"
# The same for rates at which ``1`` is not sent: it finds a WALTER that is in Logo control, as after power-on.
MILD_PROBE = b"\rqp\r"
# Above this there are rates a tenth to a quarter higher than others (250000 and 230400, 576000 and 500000).
FASTEST_KEY_BAUD = 115200


def logo_probe(baud: int | None) -> bytes:
    """What makes a WALTER answer that listens at this rate; None: a link without one."""
    return LOGO_PROBE if baud is None or baud <= FASTEST_KEY_BAUD else MILD_PROBE


def pause_s(baud: int | None) -> float:
    """How long a byte sent at this rate has to be followed by silence, seconds.

    Longer than ten bits of any robot that hears it.
    """
    slowest = max(SLOWEST_BAUD, (baud or SOCKET_BAUD) * DEAF_BELOW)
    return max(LEAST_PAUSE_S, 1.1 * BITS / slowest)


def byte_s(baud: int | None) -> float:
    """How long a byte takes, seconds."""
    return BITS / (baud or SOCKET_BAUD)
