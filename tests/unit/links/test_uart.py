"""What a UART makes of bytes at another rate: by hand, and for every byte."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from turtlewire.links.uart import ARDUINO, RECEIVERS, Receiver, image

every_receiver = pytest.mark.parametrize("receiver", RECEIVERS)
# What a lone low pulse is heard as: the bits up to its end are 0, those after it 1.
PULSES = {0xFF << shift & 0xFF for shift in range(9)}
EVERY_BYTE = [bytes([byte]) for byte in range(256)]


@every_receiver
@settings(deadline=None)
@given(data=st.binary(max_size=100), ratio=st.floats(0.97, 1.03))
def test_at_the_same_rate_bytes_are_what_they_are(data: bytes, ratio: float, receiver: Receiver) -> None:
    # Clocks 3 percent apart are the same rate: bytes one behind the other, each with a fall of its own to start from.
    assert image(data, ratio, receiver) == data


@every_receiver
def test_each_byte_alone_at_the_same_rate(receiver: Receiver) -> None:
    assert [image(byte, 1.0, receiver) for byte in EVERY_BYTE] == EVERY_BYTE


def test_twice_as_fast_every_bit_is_heard_twice() -> None:
    # 55: the line is low and high by turns, L H L H L H L H L H. Start L, data L HH LL HH L: from the lowest, 01100110.
    # Its stop bit is the second half of an L: broken. The line then rises; it falls next in its middle, and it is
    # the same from there, but that behind its stop bit the line stays high: 01100111.
    assert image(b"\x55", 2.0, ARDUINO) == bytes([0b01100110, 0b11100110])
    assert image(b"\x55", 2.0, Receiver(keeps_broken=False)) == bytes([0b11100110])
    # FF: one bit of start, twice.
    assert image(b"\xff", 2.0) == b"\xfe"


def test_half_as_fast_every_other_bit_is_heard() -> None:
    # Looked at in the middle of two bits of the sender, which is the border: a little faster sees the first of both.
    # 0F: L HHHH LLLL H. In pairs: L. H. H. L. L. H, idle: start 0, then 1 1 0 0 1 1 1 1.
    assert image(b"\x0f", 0.501) == bytes([0b11110011])


def test_a_start_bit_that_is_too_short_is_none() -> None:
    assert image(b"\xff", 0.49) == b""
    assert image(b"\xff", 0.51) == b"\xff"
    # The line of 00 is low for nine bits.
    assert image(b"\x00", 0.055) == b""
    assert image(b"\x00", 0.056) == b"\xff"


@pytest.mark.parametrize(
    ("receiver", "heard"),
    [
        (Receiver(keeps_broken=True, waits_for_high=True), b"\x00"),
        (Receiver(keeps_broken=False, waits_for_high=True), b""),
        # Low for 18 of its bits. The broken stop bit, its tenth, is the next start: nine of it left, as if sent so.
        (Receiver(keeps_broken=True, waits_for_high=False), b"\x00\x00"),
        (Receiver(keeps_broken=False, waits_for_high=False), b"\x00"),
    ],
)
def test_a_break(receiver: Receiver, heard: bytes) -> None:
    assert image(b"\x00", 2.0, receiver) == heard


def test_where_a_bit_is_looked_at_decides_at_the_border() -> None:
    assert image(b"\xff", 0.49, Receiver(sample=0.45)) == b"\xff"
    assert image(b"\xff", 0.49, Receiver(sample=0.55)) == b""


@every_receiver
@settings(deadline=None)
@given(shift=st.integers(0, 8), ratio=st.floats(0.01, 1000.0))
def test_one_pulse_is_heard_as_one_pulse(shift: int, ratio: float, receiver: Receiver) -> None:
    assert set(image(bytes([0xFF << shift & 0xFF]), ratio, receiver)) <= PULSES


@every_receiver
@settings(deadline=None)
@given(data=st.binary(max_size=4), ratio=st.floats(19.0, 400.0))
def test_far_too_fast_hears_nothing_but_pulses(data: bytes, ratio: float, receiver: Receiver) -> None:
    assert set(image(data, ratio, receiver)) <= PULSES


@settings(deadline=None)
@given(data=st.binary(max_size=10), ratio=st.floats(0.01, 100.0))
def test_waiting_and_keeping_only_add(data: bytes, ratio: float) -> None:
    for waits in (True, False):
        kept = image(data, ratio, Receiver(keeps_broken=True, waits_for_high=waits))
        dropped = image(data, ratio, Receiver(keeps_broken=False, waits_for_high=waits))
        rest = iter(kept)
        assert all(byte in rest for byte in dropped)  # in this order
