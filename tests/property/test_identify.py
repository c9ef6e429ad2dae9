"""What holds of ``identify`` for all bytes, and of decoders for all streams of all protocols."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from turtlewire.protocols import forms
from turtlewire.protocols.catalogue import Packet, Settings, codec
from turtlewire.protocols.identify import NONE, identify
from turtlewire.protocols.message import AnyMessage, Decoded, RealField

if TYPE_CHECKING:
    from turtlewire.protocols.catalogue import Codec, Sender

CODECS: dict[str, tuple[Codec, Sender]] = {
    "walter": (codec("walter"), "host"),
    "simple": (codec("simple"), "host"),
    "frame": (codec("frame"), "host"),
    "telemetry": (codec("frame", Settings(dialect="telemetry")), "robot"),
}


@st.composite
def messages(draw: st.DrawFn, codec: Codec, sender: Sender) -> AnyMessage:
    """Any message that leaves walter in Logo control."""
    types = [
        t for t in codec.types(sender)
        if t.name() not in ("select_direct", "engine_direction_unknown") and "DirectKey" not in str(t.__mro__)
    ]  # fmt: skip
    message_type = draw(st.sampled_from(types))
    values: list[object] = []
    for field in message_type.FIELDS:
        if isinstance(field, RealField):
            values.append(draw(st.floats(field.low, field.high, width=32)))
        elif field.choices:
            values.append(draw(st.sampled_from([number for _, number in field.choices])))
        else:
            values.append(draw(st.integers(field.low, 1 if field.name.endswith("_id") else field.high)))
    return message_type(*values)


@settings(deadline=None)
@given(st.binary(max_size=300))
def test_any_bytes_are_explained(data: bytes) -> None:
    identification = identify(data)
    assert identification.size == len(data)
    assert {verdict.protocol for verdict in identification.verdicts} == {"simple", "frame", "walter", NONE}
    assert sum(verdict.score for verdict in identification.verdicts) == pytest.approx(1.0)
    assert all(verdict.reasons and 0.0 <= verdict.score <= 1.0 for verdict in identification.verdicts)


# Many messages take their time to draw on a busy machine.
@settings(deadline=None, max_examples=40, suppress_health_check=[HealthCheck.too_slow])
@given(st.data(), st.sampled_from(["walter", "telemetry", "frame"]), st.binary(max_size=5))
def test_enough_messages_are_told_from_everything_else(data: st.DataObject, name: str, noise: bytes) -> None:
    """``simple`` says too little in a command of zeros to be told in so few of them from bytes over and over."""
    made, sender = CODECS[name]
    said = data.draw(st.lists(messages(made, sender), min_size=20, max_size=30, unique_by=str))
    identification = identify(noise + b"".join(map(made.encode, said)))
    assert identification.is_sure
    assert identification.best.protocol == made.name
    assert identification.best.sender in (sender, None)


@settings(deadline=None)
@given(st.data(), st.sampled_from(sorted(CODECS)))
def test_what_is_shown_encodes_to_the_same_bytes(data: st.DataObject, name: str) -> None:
    made, sender = CODECS[name]
    stream = b"".join(map(made.encode, data.draw(st.lists(messages(made, sender), max_size=12))))
    decoder = made.decoder(sender)
    items = [*decoder.receive_data(stream), *decoder.finish()]
    assert all(isinstance(item, Decoded) for item in items)
    texts = [forms.read_text_line(forms.text_line(item), made) for item in items]
    jsons = [forms.read_json_line(forms.json_line(item, made, sender), made) for item in items]
    assert b"".join(made.encode(message) for message in texts if message is not None) == stream
    assert b"".join(made.encode(message) for message in jsons if message is not None) == stream


@settings(deadline=None)
@given(st.data(), st.integers(0, 255))
def test_a_frame_keeps_its_messages_together(data: st.DataObject, seq: int) -> None:
    made, sender = CODECS["telemetry"]
    packet = Packet(seq, tuple(data.draw(st.lists(messages(made, sender), max_size=9))))
    assert made.parse(str(packet)) == packet
    assert made.from_json(made.to_json(packet)) == packet
