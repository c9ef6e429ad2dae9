from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import DataError, MessageError, UsageError
from turtlewire.protocols import catalogue, forms
from turtlewire.protocols.catalogue import NAMES, SENDERS, Packet, Settings, codec
from turtlewire.protocols.message import AnyMessage, Decoded, Malformed, RealField
from turtlewire.protocols.stream import SKIPPED_BYTES, Skipped

if TYPE_CHECKING:
    from turtlewire.protocols.catalogue import Codec, Sender
    from turtlewire.protocols.stream import Item

DIALECTS = {
    "simple": codec("simple"),
    "walter": codec("walter"),
    "frame": codec("frame"),
    "telemetry": codec("frame", Settings(dialect="telemetry", crc="CRC-8/AUTOSAR", coverage="size")),
}
DIRECT = codec("walter", Settings(mode="direct"))
EVERYTHING = [
    pytest.param(each, sender, message_type, id=f"{name}-{sender}-{message_type.name()}")
    for name, each in DIALECTS.items()
    for sender in SENDERS
    for message_type in each.types(sender)
]


def decoded(codec: Codec, sender: Sender, data: bytes, size: int = 1 << 20) -> list[Item]:
    decoder = codec.decoder(sender)
    items = [
        item
        for start in range(0, len(data), size)
        for item in decoder.receive_data(data[start : start + size])
    ]
    return items + decoder.finish()


def extremes(message_type: type[AnyMessage]) -> list[AnyMessage]:
    """The least and the greatest of every field (a robot has one servo, one engine at least)."""
    lows = [f.low if not isinstance(f, RealField) else f.low / 2 + f.high / 2 for f in message_type.FIELDS]
    highs = [0 if f.name in ("servo_id", "engine_id") else f.high for f in message_type.FIELDS]
    choices = [dict(getattr(f, "choices", ())) for f in message_type.FIELDS]
    return [
        message_type(
            *(max(c.values()) if c and v not in c.values() else v for c, v in zip(choices, row, strict=True))
        )
        for row in (lows, highs)
    ]


@pytest.mark.parametrize(("codec", "sender", "message_type"), EVERYTHING)
def test_every_message_of_every_protocol_has_bytes_a_text_and_a_json_form(
    codec: Codec, sender: Sender, message_type: type[AnyMessage]
) -> None:
    for message in extremes(message_type):
        if message_type.name() == "engine_direction_unknown":
            continue
        data = codec.encode(message)
        decoding = DIRECT if "DirectKey" in str(message_type.__mro__) else codec
        (item,) = decoded(decoding, sender, data)
        assert isinstance(item, Decoded)
        assert item.raw == data
        said = item.message.messages[0] if isinstance(item.message, Packet) else item.message
        assert said == message
        assert codec.parse(str(message)) == message
        assert codec.from_json(codec.to_json(message)) == message
        # What is shown of it encodes to the same bytes.
        for again in (
            forms.read_text_line(forms.text_line(item, sender=sender, t_ns=1_500_000), codec),
            forms.read_text_line(forms.text_line(item), codec),
            forms.read_json_line(forms.json_line(item, codec, sender), codec),
        ):
            assert again is not None
            assert codec.encode(again) == data


def test_there_is_nothing_but_these_names_and_settings() -> None:
    assert NAMES == ("simple", "frame", "walter")
    with pytest.raises(UsageError, match="no protocol 'morse'; there are simple, frame, walter"):
        codec("morse")
    for name, settings, words in [
        ("simple", Settings(mode="logo"), "simple has no mode"),
        ("walter", Settings(crc="CRC-8/SMBUS"), "walter has no crc"),
        ("frame", Settings(mode="logo"), "frame has no mode"),
        ("walter", Settings(mode="pascal"), "walter has no mode 'pascal': it is logo or direct"),
    ]:
        with pytest.raises(UsageError, match=words):
            codec(name, settings)


def test_a_protocol_knows_its_baud_rate() -> None:
    assert [codec(name).baud for name in NAMES] == [9600, 115200, 9600]


def test_a_dialect_that_cannot_be_had() -> None:
    with pytest.raises(DataError, match=r"nowhere\.toml"):
        codec("frame", Settings(dialect="nowhere.toml"))
    with pytest.raises(DataError, match="CRC-9"):
        codec("frame", Settings(crc="CRC-9"))
    with pytest.raises(DataError, match="coverage must be"):
        codec("frame", Settings(coverage="everything"))


def test_a_dialect_of_ones_own(tmp_path: Path) -> None:
    shipped = Path(catalogue.__file__).parent / "frame" / "dialects" / "0.1.toml"
    own = tmp_path / "own.toml"
    own.write_text(shipped.read_text("utf-8").replace('"EngineForward"', '"TurnWheel"'), "utf-8")
    codec_of_own = codec("frame", Settings(dialect=str(own)))
    frames = codec("frame")
    expected = frames.encode(frames.parse("engine_forward 0 200"))
    assert codec_of_own.encode(codec_of_own.parse("turn_wheel 0 200")) == expected


def test_a_message_of_another_protocol_is_refused() -> None:
    stop = codec("simple").parse("stop")
    for name in ("walter", "frame"):
        with pytest.raises(MessageError, match=f"stop is no message of {name}"):
            codec(name).encode(stop)
    with pytest.raises(MessageError, match="pen_up is no message of simple"):
        codec("simple").encode(codec("walter").parse("pen_up"))


# ---------------------------------------------------------------------------------------------- no byte vanishes


def test_a_line_feed_after_ret_has_an_item_of_its_own() -> None:
    assert decoded(codec("walter"), "host", b"PU\r\n\nPD\r\n") == [
        Decoded(0, b"PU\r", codec("walter").parse("pen_up")),
        Skipped(3, b"\n", "the line feed after a RET"),
        Malformed(4, b"\nPD\r", "unknown letter 0A"),
        Skipped(8, b"\n", "the line feed after a RET"),
    ]


def test_a_message_is_not_kept_back_for_a_line_feed() -> None:
    decoder = codec("walter").decoder("host")
    assert len(decoder.receive_data(b"PU\r")) == 1
    assert decoder.receive_data(b"\n") == []
    assert (decoder.offset, decoder.kept) == (3, b"\n")


@pytest.mark.parametrize(
    ("name", "sender", "data", "pending"),
    [("walter", "host", b"PU\rF\0", 2), ("simple", "host", b"S000000F1", 2), ("walter", "robot", b"QH\0", 3)],
)
def test_a_stream_that_ends_within_a_message(name: str, sender: Sender, data: bytes, pending: int) -> None:
    last = decoded(codec(name), sender, data)[-1]
    assert last == Malformed(len(data) - pending, data[-pending:], "the stream ends within a message")


def test_noise_between_frames_comes_in_pieces_for_every_chunking() -> None:
    frame = codec("frame").encode(Packet(None))
    noise = bytes(2 * SKIPPED_BYTES + 5)
    expected = [
        Skipped(0, noise[:SKIPPED_BYTES], "no frame begins here"),
        Skipped(SKIPPED_BYTES, noise[:SKIPPED_BYTES], "no frame begins here"),
        Skipped(2 * SKIPPED_BYTES, noise[:5], "no frame begins here"),
        Decoded(len(noise), frame, Packet(0)),
    ]
    for size in (1, 2, 63, 64, 65, 1000):
        assert decoded(codec("frame"), "host", noise + frame, size) == expected


def test_noise_without_end_is_not_kept() -> None:
    decoder = codec("frame").decoder("host")
    for _ in range(100):
        decoder.receive_data(bytes(1000))
        assert len(decoder.kept) < SKIPPED_BYTES
    assert decoder.offset == 100_000 - len(decoder.kept)
    assert sum(len(item.raw) for item in decoder.finish()) == 100_000 % SKIPPED_BYTES


def test_a_frame_within_what_was_none_leaves_it_only_the_bytes_before() -> None:
    frame = codec("frame").encode(Packet(7))
    data = b"\xa3\x00\x05" + frame + b"!" * 9
    expected: list[Item] = [
        Malformed(0, b"\xa3\x00\x05", "CRC is 21, but must be 1D"),
        Decoded(3, frame, Packet(7)),
        Skipped(7, b"!" * 9, "no frame begins here"),
    ]
    for size in range(1, 17):
        items = decoded(codec("frame"), "host", data, size)
        assert [item.raw for item in items] == [item.raw for item in expected]
        assert items[1:] == expected[1:]
        assert isinstance(items[0], Malformed)


def test_a_frame_that_does_not_go_on_is_given_up_in_time() -> None:
    decoder = codec("frame").decoder("host")
    frame = codec("frame").encode(Packet(7))
    assert decoder.receive_data(b"\xa3\x00\x7c" + frame, 1.0) == []
    assert decoder.receive_data(b"", 1.05) == []
    items = decoder.receive_data(b"", 1.2)
    assert [item.raw for item in items] == [b"\xa3\x00\x7c", frame]


# ------------------------------------------------------------------------------------------------- frames


def test_frames_are_numbered_unless_they_say_their_number() -> None:
    frames = codec("frame")
    numbers = [
        frames.encode(frames.parse(text))[1]
        for text in (
            "frame",
            "engine_forward 0 1",
            "frame seq=255",
            "engine_forward 0 1; engine_backward 1 2",
            "frame 9",
        )
    ]
    assert numbers == [0, 1, 255, 0, 9]


def test_the_text_of_a_frame_says_what_is_odd_about_it_and_encodes_all_the_same() -> None:
    frames = codec("frame")
    data = b"".join(frames.encode(Packet(seq)) for seq in (0, 1, 1, 5, 0))
    texts = [forms.says(item) for item in decoded(frames, "host", data)]
    assert texts == [
        "frame seq=0",
        "frame seq=1",
        "frame seq=1 (repeat)",
        "frame seq=5 (3 lost before it)",
        "frame seq=0 (restart)",
    ]
    assert b"".join(frames.encode(frames.parse(text)) for text in texts) == data


def test_a_frame_with_refused_messages_shows_them_and_cannot_be_sent() -> None:
    frames = codec("frame")
    good = frames.encode(frames.parse("frame 3; engine_forward 1 200"))
    from turtlewire.protocols.checksums import CHECKSUMS

    smbus = next(c for c in CHECKSUMS if str(c) == "CRC-8/SMBUS from magic")
    body = good[:-1].replace(b"\x01\x01\xc8", b"\x01\x09\xc8")
    (item,) = decoded(frames, "host", body + bytes([smbus.algorithm.crc(body)]))
    assert isinstance(item, Decoded)
    assert forms.says(item) == "frame seq=3; refused engine_forward engine_id=9 speed=200"
    with pytest.raises(MessageError, match="breaks its restriction: it cannot be sent"):
        frames.encode(item.message)
    assert frames.from_json(frames.to_json(item.message)) == frames.parse(str(item.message)) == item.message
    assert forms.read_text_line(forms.text_line(item), frames) is None
    assert forms.read_json_line(forms.json_line(item, frames, "host"), frames) is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("frame seq=256", "N from 0 to 255"),
        ("frame x", "write frame seq=N"),
        ("frame ٣", "write frame seq=N"),
        ("frame 1; nonsense", "no message 'nonsense'"),
        ("frame;" + ";".join(["engine_forward 0 1"] * 42), "124 bytes of messages, and these are 126"),
        ("engine_forward 2 1", "this robot has 2 engines"),
        ("", "empty text"),
    ],
)
def test_frames_that_cannot_be(text: str, words: str) -> None:
    frames = codec("frame")
    with pytest.raises(MessageError, match=words):
        frames.encode(frames.parse(text))


def test_a_frame_goes_one_way() -> None:
    telemetry = DIALECTS["telemetry"]
    both = telemetry.parse("set_lamp 1; distance 0 10")
    with pytest.raises(MessageError, match="do not all go the same"):
        telemetry.encode(both)


@pytest.mark.parametrize(
    ("form", "words"),
    [
        ([], "must have a name"),
        ({"name": 3}, "must have a name"),
        ({"name": "forward", "fields": []}, "must have a name and fields"),
        ({"name": "fly"}, "no message 'fly'"),
        ({"name": "forward"}, "must have the fields distance_half_mm, and has none"),
        ({"name": "pen_up", "fields": {"x": 1}}, "must have no fields, and has x"),
        ({"name": "forward", "fields": {"distance_half_mm": 70000}}, "0 to 65535"),
        ({"name": "forward", "fields": {"distance_half_mm": "far"}}, "0 to 65535"),
    ],
)
def test_json_that_is_no_message(form: object, words: str) -> None:
    with pytest.raises(MessageError, match=words):
        codec("walter").from_json(form)


@pytest.mark.parametrize(
    "fields",
    [{"seq": 256, "messages": []}, {"seq": "1", "messages": []}, {"seq": 1, "messages": [], "refused": 3}],
)
def test_json_that_is_no_frame(fields: object) -> None:
    with pytest.raises(MessageError):
        codec("frame").from_json({"name": "frame", "fields": fields})


# -------------------------------------------------------------------------------------------------- lines


def test_lines_of_json_have_what_they_promise() -> None:
    items = decoded(codec("walter"), "host", b"F\0\xc8\r\n?\r")
    lines = [json.loads(forms.json_line(item, codec("walter"), "host", 5)) for item in items]
    assert lines == [
        {
            "t_ns": 5,
            "offset": 0,
            "raw": "46 00 C8 0D",
            "from": "host",
            "message": {"name": "forward", "fields": {"distance_half_mm": 200}},
        },
        {
            "t_ns": 5,
            "offset": 4,
            "raw": "0A",
            "from": "host",
            "skipped": {"reason": "the line feed after a RET"},
        },
        {"t_ns": 5, "offset": 5, "raw": "3F 0D", "from": "host", "error": {"reason": "unknown letter '?'"}},
    ]
    assert "t_ns" not in forms.json_line(items[0], codec("walter"), "host")


def test_lines_of_text_have_what_they_promise() -> None:
    items = decoded(codec("walter"), "host", b"F\0\xc8\r\n?\r")
    assert [forms.text_line(item) for item in items] == [
        "       0  forward distance_half_mm=200                      # 46 00 C8 0D",
        "       4  skipped: the line feed after a RET                # 0A",
        "       5  error: unknown letter '?'                         # 3F 0D",
    ]
    assert forms.text_line(items[0], sender="host", t_ns=1_234_567_890) == (
        "    1.234568  host          0  forward distance_half_mm=200                      # 46 00 C8 0D"
    )


@pytest.mark.parametrize(
    "line", ["", "  ", "# a note", "   3  error: unknown letter '?'   # 3F 0D", "4 skipped: x # 0A"]
)
def test_lines_of_text_without_a_message(line: str) -> None:
    assert forms.read_text_line(line, codec("walter")) is None


@pytest.mark.parametrize("line", ["", " \n", '{"error":{"reason":"x"}}', '{"skipped":{"reason":"x"}}'])
def test_lines_of_json_without_a_message(line: str) -> None:
    assert forms.read_json_line(line, codec("walter")) is None


@pytest.mark.parametrize(
    ("line", "words"),
    [("nonsense", "is not JSON"), ("{}", "neither a message nor an error"), ("3", "neither")],
)
def test_lines_of_json_that_are_none(line: str, words: str) -> None:
    with pytest.raises(DataError, match=words):
        forms.read_json_line(line, codec("walter"))


@pytest.mark.parametrize(
    ("protocol", "text", "wrong"),
    [
        ("walter", "  fordward 200", "fordward"),
        ("walter", "forward 20 speed=3", "speed=3"),
        ("walter", "forward 20 30", "30"),
        ("walter", "forward  distance_half_mm=70000", "distance_half_mm=70000"),
        ("walter", "forward far", "far"),
        ("simple", "headlights 1 1 2 0", "2"),
        ("frame", "engine_forward 0 200; engine_foward 1 200", "engine_foward"),
        ("frame", "frame seq=3;  engine_forward 0 200 ; engine_forward 0 256; set_servo_position 0 1", "256"),
        ("frame", " frame seq=x; engine_forward 0 200", "frame seq=x"),
        ("frame", "frame; refused engine_forward 0 x", "x"),
    ],
)
def test_an_error_of_a_text_has_its_place(protocol: str, text: str, wrong: str) -> None:
    with pytest.raises(MessageError) as caught:
        codec(protocol).parse(text)
    assert caught.value.place is not None
    start, end = caught.value.place
    assert text[start:end] == wrong
    assert start == text.rindex(wrong)


@pytest.mark.parametrize(
    ("protocol", "text", "place"),
    [
        ("walter", "forward", (7, 7)),
        ("walter", "go_to x_half_mm=3 ", (17, 17)),
        ("frame", "engine_forward 0 1; engine_forward 1", (36, 36)),
        ("frame", "engine_forward 0 1;;", (19, 19)),
        ("walter", "", None),
    ],
)
def test_what_is_missing_has_its_place_too(protocol: str, text: str, place: tuple[int, int] | None) -> None:
    with pytest.raises(MessageError) as caught:
        codec(protocol).parse(text)
    assert caught.value.place == place
