from __future__ import annotations

import random
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from turtlewire.protocols import likelihood
from turtlewire.protocols.catalogue import Packet, Settings, codec
from turtlewire.protocols.checksums import CHECKSUMS, Checksum
from turtlewire.protocols.identify import NONE, SAMPLE_BYTES, identify

if TYPE_CHECKING:
    from collections.abc import Sequence

    from turtlewire.protocols.catalogue import Codec
    from turtlewire.protocols.message import AnyMessage

ROOT = Path(__file__).parents[3]
# Realistic sessions, written by hand.
WALTER = """
query_heading; set_speed 100; pen_down; forward 200; right 90; query_x; forward 3341; right 90; query_y; back 13;
select_direct; stop; select_logo; empty_line; left 45; query_pen; go_to -200 400; turn_to 270; pen_up; go_home;
forward 60; right 60; query_x; forward 60; right 60; query_y; lamp_on; horn_low; horn_off; query_location; lamp_off
"""
KEYS = """
stop; set_move_speed 120; start_forward; move_faster; move_faster; stop; start_left; turn_slower; stop; lower_pen;
start_forward; stop; raise_pen; start_backward; stop; start_right; set_turn_speed 40; turn_faster; stop; start_forward;
stop; start_left; stop; start_forward; move_slower; stop
"""
REPLIES = """
heading_reply 0; x_reply 0; y_reply 0; pen_reply 1; location_reply 0 0; heading_reply 90; x_reply 200; limit_front;
location_reply 200 -13; heading_reply 270; towards_reply 45; y_reply -400
"""
SIMPLE = """
stop; drive_forward 120; steer_left 30; drive_forward 130; steer_left 0; headlights 1 1 0 0; drive_backward 90; stop;
steer_right 255; drive_forward 255; steer_right 0; stop; headlights 0 0 0 0; drive_forward 80; stop
"""


def said(codec: Codec, session: str) -> bytes:
    return b"".join(codec.encode(codec.parse(text)) for text in session.split(";"))


def frames(settings: Settings, count: int = 60, names: Sequence[str] = ()) -> bytes:
    """A host that sets two engines and, now and then, a servo."""
    chance = random.Random(3)
    made = codec("frame", settings)
    data = b""
    for n in range(count):
        speed = chance.randrange(256)
        texts = [f"engine_forward 0 {speed}", f"engine_backward 1 {speed}", f"set_servo_position 0 {n}"]
        messages: tuple[AnyMessage, ...] = tuple(made.parse(text) for text in texts[: chance.randrange(4)])
        data += made.encode(Packet(None, messages))
    return data


SAMPLES = {
    "walter host in Logo control": ("walter", "host", {"mode": "logo"}, said(codec("walter"), WALTER)),
    "walter host in direct control": ("walter", "host", {"mode": "direct"}, said(codec("walter"), KEYS) * 2),
    "walter robot": ("walter", "robot", {}, said(codec("walter"), REPLIES)),
    "simple host": ("simple", "host", {}, said(codec("simple"), SIMPLE) * 3),
    "simple robot": ("simple", "robot", {}, b"KKKKKKFKKKKKKKKKFFKKKKKKKKKKKKKKKKKKKKKKFKKKKKKKKK"),
    "frame host": (
        "frame",
        "host",
        {"crc": "CRC-8/SMBUS", "coverage": "magic", "dialect": "0.1"},
        frames(Settings()),
    ),
}
each_sample = pytest.mark.parametrize("name", SAMPLES)


def damaged(data: bytes, share: float, chance: random.Random) -> bytes:
    """Bytes are lost, come from nowhere, or have a bit turned over."""
    result = bytearray()
    for byte in data:
        draw = chance.random() / share
        if draw < 1 / 3:
            continue
        if draw < 2 / 3:
            result.append(chance.randrange(256))
        result.append(byte ^ (1 << chance.randrange(8)) if 2 / 3 <= draw < 1 else byte)
    return bytes(result)


def check(name: str, data: bytes) -> None:
    protocol, sender, settings, _ = SAMPLES[name]
    identification = identify(data)
    best = identification.best
    assert identification.is_sure, identification
    assert (best.protocol, best.sender, dict(best.settings)) == (protocol, sender, settings)
    assert best.score > 0.95
    assert sum(verdict.score for verdict in identification.verdicts) == pytest.approx(1.0)


@each_sample
def test_a_capture_of_each(name: str) -> None:
    check(name, SAMPLES[name][3])


@each_sample
def test_cut_at_arbitrary_places(name: str) -> None:
    data = SAMPLES[name][3]
    for start in range(1, 14):
        check(name, data[start : len(data) - 14 + start])


@each_sample
@pytest.mark.parametrize("seed", range(5))
def test_with_noise(name: str, seed: int) -> None:
    check(name, damaged(SAMPLES[name][3], 0.03, random.Random(seed)))


@each_sample
def test_amid_other_bytes(name: str) -> None:
    chance = random.Random(5)
    check(name, chance.randbytes(24) + SAMPLES[name][3] + chance.randbytes(24))


@each_sample
def test_the_best_is_first_and_has_reasons(name: str) -> None:
    identification = identify(SAMPLES[name][3])
    scores = [verdict.score for verdict in identification.verdicts]
    assert scores == sorted(scores, reverse=True)
    assert {verdict.protocol for verdict in identification.verdicts} == {"simple", "frame", "walter", NONE}
    assert all(verdict.reasons for verdict in identification.verdicts)
    assert "times likelier than" in identification.best.reasons[-1]
    assert identification.size == len(SAMPLES[name][3])


@pytest.mark.parametrize("end", [b"\r", b"\r\n"])
@pytest.mark.parametrize("case", [bytes.upper, bytes.lower])
def test_walter_in_either_case_with_either_end_of_line(end: bytes, case: object) -> None:
    commands = [b"PU", b"PD", b"QH", b"QX", b"CR", b"C0", b"E1", b"E0", b"HL", b"H0", b"QY", b"QP"] * 3
    lines = [command.lower() if case is bytes.lower else command for command in commands]
    best = identify(b"".join(line + end for line in lines)).best
    assert (best.protocol, best.sender, best.settings) == ("walter", "host", {"mode": "logo"})


def test_walter_says_how_much_was_in_which_mode() -> None:
    best = identify(SAMPLES["walter host in Logo control"][3]).best
    assert "28 in Logo control, 2 in direct control" in best.reasons


# ------------------------------------------------------------------------------------------------------- frames


@pytest.mark.parametrize("checksum", CHECKSUMS, ids=str)
def test_every_algorithm_and_coverage_is_found(checksum: Checksum) -> None:
    data = frames(Settings(crc=checksum.algorithm.name, coverage=checksum.coverage.value))
    identification = identify(data)
    assert identification.is_sure
    assert identification.best.settings["crc"] == checksum.algorithm.name
    assert identification.best.settings["coverage"] == checksum.coverage.value
    assert f"{checksum} fits 60 frames, and no other CRC does" in identification.best.reasons


def test_frames_that_fit_several_checksums_say_so() -> None:
    # Leading zeros change no CRC that begins with 0.
    identification = identify(codec("frame", Settings(coverage="seq")).encode(Packet(0)) * 30)
    (reason,) = [reason for reason in identification.best.reasons if "CRC" in reason]
    assert reason.startswith("CRC-8/SMBUS from seq fits 30 frames, but so does ")
    assert reason.endswith("more frames will tell")


def test_frames_whose_crc_nobody_knows() -> None:
    data = bytearray()
    chance = random.Random(1)
    for n in range(60):
        payload = chance.randbytes(chance.randrange(8))
        data += bytes([0xA3, n, len(payload)]) + payload + chance.randbytes(1)
    identification = identify(bytes(data))
    assert identification.is_sure
    assert (identification.best.protocol, identification.best.sender) == ("frame", None)
    assert dict(identification.best.settings) == {}
    assert "frame stands behind frame, but no known CRC-8 fits them" in identification.best.reasons


def test_the_direction_of_a_dialect_with_telemetry() -> None:
    telemetry = codec("frame", Settings(dialect="telemetry"))
    data = b"".join(
        telemetry.encode(telemetry.parse(f"distance {n} {n * 10}; odometry {n} {n} -{n}")) for n in range(9)
    )
    best = identify(data).best
    assert (best.protocol, best.sender, best.settings["dialect"]) == ("frame", "robot", "telemetry")


def test_frames_without_messages_have_no_direction() -> None:
    made = codec("frame")
    identification = identify(b"".join(made.encode(Packet(None)) for _ in range(40)))
    assert identification.is_sure
    assert identification.best.sender is None
    assert "dialect" not in identification.best.settings


# -------------------------------------------------------------------------------------------- none of the three


@pytest.mark.parametrize("size", [1, 2, 7, 20, 100, 1000, 10_000, SAMPLE_BYTES])
def test_random_bytes_are_none_of_the_three(size: int) -> None:
    for seed in range(20 if size <= 1000 else 3):
        identification = identify(random.Random(seed).randbytes(size))
        assert identification.best.protocol == NONE
        assert not identification.is_sure


TEXTS = [
    ROOT / "README.md",
    ROOT / "pyproject.toml",
    Path(__file__),
    *sorted((ROOT / "docs/pictures").glob("*.svg"))[:2],
]


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.name)
@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_text_is_none_of_the_three(path: Path, end: bytes) -> None:
    text = path.read_bytes().replace(b"\n", end)
    for piece in (text, text.upper(), text[100:400], text[:40]):
        identification = identify(piece)
        assert identification.best.protocol == NONE
        assert not identification.is_sure
    assert "they are likeliest text" in identify(text).best.reasons


@pytest.mark.parametrize("size", [40, 300, 3000])
def test_logs_are_none_of_the_three(size: int) -> None:
    lines = [
        f"2026-11-22T11:{n // 60:02}:{n % 60:02} [INFO ] motor {n % 4}: F={n * 7 % 255} R={n % 90} OK\r\n"
        for n in range(60)
    ]
    assert identify("".join(lines).encode()[:size]).best.protocol == NONE


@pytest.mark.parametrize("byte", [0x00, 0x0D, 0x20, 0x2E, 0x53, 0xA3, 0xFF])
def test_one_byte_over_and_over_is_none_of_the_three(byte: int) -> None:
    identification = identify(bytes([byte]) * 300)
    assert identification.best.protocol == NONE
    assert "they are likeliest a few bytes over and over" in identification.best.reasons


def test_too_little_is_not_called_anything() -> None:
    assert identify(b"").best.reasons == ("there are no bytes",)
    assert not identify(b"").is_sure
    for name, (_, _, _, data) in SAMPLES.items():
        identification = identify(data[:2])
        assert not identification.is_sure, name
        assert identification.best.reasons[-1].endswith("and there are only 2 bytes")
    assert identify(b"K").best.reasons[-1].endswith("and there are only 1 byte")


def test_no_more_than_a_sample_is_looked_at() -> None:
    data = SAMPLES["simple host"][3]
    sample = (data * (SAMPLE_BYTES // len(data) + 1))[:SAMPLE_BYTES]
    assert identify(sample + bytes(100_000)) == identify(sample)


# -------------------------------------------------------------------------------------------------------- costs


def test_bits_are_those_of_a_code() -> None:
    """What all sequences of a length are worth together is one: a code can do no better."""
    for cost in (likelihood.learned_bits, likelihood.settled_bits):
        total = 0.0
        for zeros in range(7):
            sequences = [1, 6, 15, 20, 15, 6, 1][zeros]
            total += sequences * 2 ** -cost((zeros, 6 - zeros), 2)
        assert total == pytest.approx(1.0)
