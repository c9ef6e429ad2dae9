"""Both ends and the codec: what the vectors do not say."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from turtlewire.errors import MessageError, UsageError
from turtlewire.protocols.frame.codec import Frame, FrameDecoder, FrameEncoder, frame_bytes
from turtlewire.protocols.frame.dialect import FROM_ROBOT, TO_ROBOT, read_dialect, shipped
from turtlewire.protocols.frame.header import header
from turtlewire.protocols.frame.host import Host
from turtlewire.protocols.frame.messages import EngineForward, SetServoPosition
from turtlewire.protocols.frame.page import page
from turtlewire.protocols.frame.robot import Robot

DIALECT = shipped("0.1")
TELEMETRY = shipped("telemetry")
PAGE = Path(__file__).parents[4] / "docs/protocols/frame.md"
BYTE_S = 10 / 115200


def connected(**settings: float) -> Host:
    """A host whose stop has left the line."""
    host = Host(DIALECT, **settings)  # type: ignore[arg-type]
    host.connect(0.0)
    assert len(host.urgent_to_send()) == 150
    return host


def test_nothing_is_sent_before_connect_nor_after_exit() -> None:
    host = Host(DIALECT, heartbeat_s=0.1, repeat_s=0.1)
    assert (host.connected, host.next_timeout()) == (False, math.inf)
    assert host.data_to_send(10.0) == b""
    with pytest.raises(UsageError, match="the host is not connected"):
        host.send(EngineForward(0, 1))
    host.connect(10.0)
    assert host.connected
    host.exit(11.0)
    assert host.urgent_to_send()
    assert host.idle
    assert host.data_to_send(12.0) == b""
    assert host.next_timeout() == math.inf


@pytest.mark.parametrize("name", ["repeat", "heartbeat"])
@pytest.mark.parametrize("interval", [0.0, -1.0, math.nan])
def test_intervals_are_more_than_nothing(name: str, interval: float) -> None:
    with pytest.raises(UsageError, match=f"the {name} interval must be more than 0 s"):
        Host(DIALECT, **{f"{name}_s": interval})  # type: ignore[arg-type]


def test_a_wrong_message_keeps_all_of_its_call_back() -> None:
    host = connected()
    for wrong in (EngineForward(2, 0), SetServoPosition(0, 181), TELEMETRY["Beep"](0, 0)):
        with pytest.raises(MessageError):
            host.send(EngineForward(0, 9), wrong)
    assert (host.unsent, host.idle) == (0, True)
    assert host.data_to_send(1.0) == b""


def test_the_next_frame_waits_until_the_line_is_free() -> None:
    host = connected()
    free = 150 * BYTE_S
    assert host.next_timeout() == math.inf
    host.send(EngineForward(0, 1))
    assert host.next_timeout() == free
    assert host.data_to_send(free - 1e-6) == b""
    host.send(EngineForward(0, 2))
    assert host.unsent == 1
    assert host.data_to_send(free)[3:6] == b"\x01\x00\x02"
    host.send(EngineForward(1, 3))
    assert host.next_timeout() == free + 7 * BYTE_S
    assert host.data_to_send(host.next_timeout())[3:6] == b"\x01\x01\x03"


def test_the_line_may_be_slower() -> None:
    host = Host(DIALECT, baud=9600)
    host.connect(0.0)
    host.send(EngineForward(0, 1))
    assert host.next_timeout() == pytest.approx(150 * 10 / 9600)


def test_what_does_not_fit_one_frame_follows_in_order() -> None:
    host = Host(TELEMETRY)
    host.connect(0.0)
    beeps = [TELEMETRY["Beep"](1, n) for n in range(70)]
    host.send(*beeps)
    assert host.unsent == 70
    got = []
    robot = Robot(TELEMETRY)
    now = 1.0
    while not host.idle:
        host.urgent_to_send()
        data = host.data_to_send(now)
        assert len(data) <= 128
        got += robot.receive_data(data, now)
        now = host.next_timeout() if host.unsent else now
    assert got == beeps
    assert robot.heard == 3


def test_timeouts_of_repeats_and_heartbeats() -> None:
    host = connected(repeat_s=0.5, heartbeat_s=0.2)
    assert host.next_timeout() == 0.2
    assert host.data_to_send(0.2) == frame_bytes(DIALECT, 15, b"")
    host.send(EngineForward(0, 1))
    host.data_to_send(0.45)
    assert host.next_timeout() == 0.5
    assert host.data_to_send(0.5) == frame_bytes(DIALECT, 17, b"\x01\x00\x01")
    assert host.next_timeout() == pytest.approx(0.7)
    host.emergency_stop(0.6)
    assert host.next_timeout() == pytest.approx(0.8)


def test_a_stop_forgets_what_waits_and_what_is_repeated() -> None:
    host = connected(repeat_s=0.1)
    host.send(EngineForward(0, 1))
    host.emergency_stop(0.01)
    assert host.unsent == 0
    stop = host.urgent_to_send()
    assert stop
    assert host.urgent_to_send() == b""
    assert host.data_to_send(1.0) == b""


def test_telemetry_comes_in_and_what_was_held_back_comes_by_the_timer() -> None:
    host = Host(TELEMETRY)
    robot = Robot(TELEMETRY)
    state = TELEMETRY.enumerations["state"]
    status = TELEMETRY["Status"](state["driving"], 7.5, False)  # noqa: FBT003
    assert host.receive_data(robot.send(status), 0.0) == [status]
    assert host.receive_data(b"\xa3\x00\x40" + robot.send(status, status), 1.0) == []
    assert host.next_timeout() == 1.1
    assert host.timed_out(1.05) == []
    assert host.timed_out(1.1) == [status, status]
    assert (host.statistics.frames, host.statistics.incomplete) == (2, 1)
    assert host.receive_data(robot.send(), 2.0) == []
    with pytest.raises(MessageError, match="beep goes to robot, not from robot"):
        robot.send(TELEMETRY["Beep"](0, 0))


def test_a_robot_tells_when_it_wants_to_be_called() -> None:
    robot = Robot(DIALECT, timeout_s=0.05)
    assert robot.next_timeout() == math.inf
    assert robot.receive_data(b"\xa3", 3.0) == []
    assert robot.next_timeout() == 3.05
    assert robot.pending == 1
    assert robot.receive_data(b"\x00", 3.04) == []
    assert robot.next_timeout() == pytest.approx(3.09)
    assert robot.receive_data(b"", 3.09) == []
    assert robot.pending == 0
    assert robot.statistics.incomplete == 1
    # Without a time nothing is given up.
    assert robot.receive_data(frame_bytes(DIALECT, 0, b"\x01\x00\x05")[:4]) == []
    assert robot.receive_data(frame_bytes(DIALECT, 0, b"\x01\x00\x05")[4:]) == [EngineForward(0, 5)]


def test_numbers_of_an_encoder() -> None:
    encoder = FrameEncoder(DIALECT, seq=255)
    assert [frame[1] for frame in encoder.encode([EngineForward(0, 1)] * 42)] == [255, 0]
    with pytest.raises(MessageError):
        encoder.encode([EngineForward(0, 1), EngineForward(9, 1)])
    assert encoder.seq == 1
    assert encoder.encode() == [frame_bytes(DIALECT, 1, b"")]


def runs(payloads: list[bytes]) -> bytes:
    return b"".join(frame_bytes(DIALECT, n % 256, payload) for n, payload in enumerate(payloads))


@pytest.mark.parametrize("place", [0, 1, 9, 30, 100, 255, 256, 299])
def test_one_of_many_alike_is_different(place: int) -> None:
    """Whatever is different about one of many frames in a row, it alone is treated so."""
    like = [b"\x01\x00" + bytes([n % 256]) for n in range(300)]
    refused = FrameDecoder(DIALECT)
    refused.receive_data(runs([*like[:place], b"\x01\x02\x05", *like[place + 1 :]]))
    assert refused.statistics.refused == {"engine_forward": 1}
    assert (refused.statistics.frames, refused.statistics.messages) == (300, 299)
    other = FrameDecoder(DIALECT)
    items = other.receive_data(runs([*like[:place], b"\x02\x01\x05", *like[place + 1 :]]))
    assert [n for n, item in enumerate(items) if "EngineBackward" in repr(item)] == [place]
    damaged = bytearray(runs(like))
    damaged[7 * place + 5] ^= 0x10
    wrong = FrameDecoder(DIALECT)
    wrong.receive_data(bytes(damaged))
    assert (wrong.statistics.frames, wrong.statistics.wrong_crc) == (299, 1)
    gap = FrameDecoder(DIALECT)
    numbers = [n + (n >= place) for n in range(300)]
    stream = b"".join(frame_bytes(DIALECT, n % 256, like[0]) for n in numbers)
    found = [item for item in gap.receive_data(stream) if isinstance(item, Frame)]
    assert [item.seq for item in found] == [n % 256 for n in numbers]
    # A gap that ends at 0 cannot be told from a restart.
    assert gap.statistics.lost == (place not in (0, 255))
    assert gap.statistics.restarts == (place == 255)
    assert [n for n, item in enumerate(found) if item.order] == ([place] if place else [])


def test_one_of_many_says_another_size() -> None:
    """Though its bytes would be a frame of the size of the others, CRC and all: its size is what it says."""
    frames = [frame_bytes(DIALECT, n, b"\x01\x00\x05") for n in range(40)]
    body = b"\xa3\x14\x05\x01\x00\x05"
    frames[20] = body + bytes([DIALECT.checksum.algorithm.crc(body)])
    decoder = FrameDecoder(DIALECT)
    items = decoder.receive_data(b"".join(frames))
    assert [item.offset for item in items if not isinstance(item, Frame)] == [140]
    assert (decoder.statistics.frames, decoder.statistics.wrong_crc, decoder.statistics.lost) == (39, 1, 1)


def test_one_of_many_has_no_number_of_the_enumeration() -> None:
    payloads = [bytes([0x12, 3 if n == 20 else n % 3, 0, 1]) for n in range(40)]
    stream = b"".join(frame_bytes(TELEMETRY, n, payload) for n, payload in enumerate(payloads))
    decoder = FrameDecoder(TELEMETRY)
    items = decoder.receive_data(stream)
    assert [item.seq for item in items if isinstance(item, Frame) and item.refused] == [20]
    assert decoder.statistics.refused == {"beep": 1}


def test_a_frame_is_filled_to_its_last_byte() -> None:
    beeps = [TELEMETRY["Beep"](0, n) for n in range(32)]
    assert [len(frame) for frame in FrameEncoder(TELEMETRY).encode(beeps)] == [128, 8]
    host = Host(TELEMETRY)
    host.connect(0.0)
    host.send(*beeps)
    assert len(host.data_to_send(1.0)) == 128


def test_every_other_frame_refused() -> None:
    """Looking ahead in vain does not cost more and more; the counts are right all the same."""
    decoder = FrameDecoder(DIALECT)
    decoder.receive_data(runs([bytes([1, 2 * (n % 2), 9]) for n in range(5000)]))
    assert (decoder.statistics.messages, decoder.statistics.refused) == (2500, {"engine_forward": 2500})


# ------------------------------------------------------------------------------------------------------- the page


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)


def test_the_pages_python_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (dialect,) = blocks("toml")
    Path("lawn-mower.toml").write_text(dialect)
    codes = blocks("python")
    assert len(codes) == 3
    for code in codes:
        exec(compile(code, PAGE.name, "exec"), {})
    made = read_dialect(dialect)
    assert "SetWheelSpeed" in header(made)
    assert "SetBlade" in page(made)
    assert [str(message) for message in made.stop_messages()] == [
        *(f"set_wheel_speed wheel_id={n} speed_mm_per_s=0" for n in range(4)),
        "set_blade blade_speed=off",
    ]


def test_the_pages_bytes_are_what_they_say() -> None:
    text = PAGE.read_text("utf-8")
    tables = [re.findall(r"^\| `([0-9A-F ]+)` \|", part, flags=re.MULTILINE) for part in text.split("\n## ")]
    first, telemetry = (bytes.fromhex(" ".join(table)) for table in tables if table)
    (frame,) = FrameDecoder(DIALECT, TO_ROBOT).receive_data(first)
    assert isinstance(frame, Frame)
    assert len(frame.messages) == 3
    (frame,) = FrameDecoder(TELEMETRY, FROM_ROBOT).receive_data(telemetry)
    assert isinstance(frame, Frame)
    assert [f"`{message}`" in text for message in frame.messages] == [True] * 3
    for reason in ("size 200 is above 124", "unknown type 77 at byte 3"):
        assert f"`{reason}`" in text
    for wrong, line in (("max = 50000", 25), ("feilds", 35)):
        right = {"max = 50000": "max = 500", "feilds": 'fields = [{ name = "blade'}[wrong]
        broken = blocks("toml")[0].replace(right, wrong if wrong != "feilds" else 'feilds = [{ name = "blade')
        with pytest.raises(Exception, match=f"lawn-mower.toml, line {line}: ") as caught:
            read_dialect(broken, "lawn-mower.toml")
        assert str(caught.value) in text
