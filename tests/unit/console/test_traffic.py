"""What passes on a wire: kept in order, decoded, bounded, and read from any thread."""

from __future__ import annotations

import asyncio
import threading
from typing import TYPE_CHECKING

import pytest

from turtlewire import capture, configuration
from turtlewire.console.traffic import Traffic
from turtlewire.errors import LinkClosedError
from turtlewire.links.faults import Faults, FaultyLink
from turtlewire.links.memory import MemoryLink
from turtlewire.protocols.walter.messages import ATTENTION, EMERGENCY_STOP
from turtlewire.simulator.walter import SimulatedWalter

if TYPE_CHECKING:
    from turtlewire.console.traffic import Piece


class Clock:
    now_ns = 5_000_000_000

    def __call__(self) -> int:
        return self.now_ns


def traffic(url: str = "sim:walter", **options: int) -> tuple[Traffic, Clock]:
    clock = Clock()
    return Traffic(configuration.target(url), clock, **options), clock


def told(piece: Piece) -> list[tuple[str | None, int, str, str]]:
    return [
        (line["from"], line["offset"], line["kind"], line["text"])
        for line in (each.as_json() for each in piece.lines)
    ]


def test_both_directions_stand_in_order_with_time_and_offset() -> None:
    wire, clock = traffic()
    wire.passed(b"F\0\xc8\rQ", "host", 0.0)
    clock.now_ns += 250_000_000
    wire.passed(b"QX\0\x07\r", "robot", 0.25)
    wire.passed(b"H\r", "host", 0.3)
    first, second, third = wire.read(0, 10).lines
    assert first.as_json() == {
        "number": 0,
        "time_s": 0.0,
        "from": "host",
        "offset": 0,
        "raw": "46 00 C8 0D",
        "kind": "message",
        "text": "forward distance_half_mm=200",
        "names": ["forward"],
    }
    assert told(wire.read(1, 10)) == [
        ("robot", 0, "message", "x_reply x_half_mm=7"),
        ("host", 4, "message", "query_heading"),
    ]
    assert (first.t_ns, second.t_ns, third.t_ns) == (0, 250_000_000, 250_000_000)


def test_bad_bytes_are_marked_with_the_reason_and_none_vanishes() -> None:
    wire, _ = traffic()
    data = b"F\0\xc8\r\n?!\rqh\r"
    for byte in data:
        wire.passed(bytes([byte]), "host", 0.0)
    lines = wire.read(0, 10).lines
    assert [(line.kind, line.as_json()["text"]) for line in lines] == [
        ("message", "forward distance_half_mm=200"),
        ("skipped", "the line feed after a RET"),
        ("error", "unknown letter '?'"),
        ("message", "query_heading"),
    ]
    assert b"".join(line.raw for line in lines) == data
    assert lines[2].as_json()["names"] == []


def test_a_stop_is_one_thing_and_what_follows_is_decoded_in_its_mode() -> None:
    wire, _ = traffic()
    wire.passed(EMERGENCY_STOP + EMERGENCY_STOP + b"XG\x80A", "host", 0.0)
    wire.passed(ATTENTION + b"QX\r", "host", 0.0)
    wire.passed(b"QP", "host", 0.0)
    wire.passed(EMERGENCY_STOP, "host", 0.0)  # within a line: it is decoded as the robot does
    assert told(wire.read(0, 20)) == [
        ("host", 0, "message", "emergency stop"),
        ("host", 9, "message", "emergency stop"),
        ("host", 18, "message", "lower_pen"),
        ("host", 19, "message", "set_move_speed speed=128"),
        ("host", 21, "message", "start_forward"),
        ("host", 22, "message", "attention: stop, Logo control"),
        ("host", 33, "message", "query_x"),
        ("host", 36, "error", "00 where RET must be"),
        ("host", 44, "message", "select_direct"),
        ("host", 46, "message", "stop"),
    ]
    assert b"".join(line.raw for line in wire.read(0, 20).lines).endswith(b"QP" + EMERGENCY_STOP)


def test_of_a_frame_every_message_has_its_name() -> None:
    wire, _ = traffic("sim:frame")
    frame = bytes.fromhex("A3 00 06 01 00 C8 01 01 C8 45")
    wire.passed(frame + bytes.fromhex("A3 01 00 E0"), "host", 0.0)
    both, empty = (line.as_json() for line in wire.read(0, 10).lines)
    assert (both["names"], empty["names"]) == (["engine_forward", "engine_forward"], ["frame"])
    assert both["text"].startswith("frame seq=0; engine_forward engine_id=0 speed=200; ")


def test_a_dialect_of_the_simulated_robot_is_understood() -> None:
    wire, _ = traffic("sim:frame?dialect=telemetry")
    frame = wire.codec.encode(wire.codec.parse("set_lamp on=1"))
    wire.passed(frame, "host", 0.0)
    assert wire.read(0, 1).lines[0].as_json()["names"] == ["set_lamp"]


def test_time_ends_a_frame_that_does_not_go_on() -> None:
    wire, _ = traffic("sim:frame")
    wire.passed(b"\xa3\0\6\1\2", "robot", 0.0)
    assert wire.count == 0
    wire.passed(b"", "robot", 1.0)
    assert wire.read(0, 10).lines[0].kind == "error"


def test_it_is_bounded_and_says_what_is_gone() -> None:
    wire, _ = traffic(max_lines=10)
    for _ in range(25):
        wire.passed(b"QX\r", "host", 0.0)
    assert wire.count == 25
    piece = wire.read(3, 4)
    assert ([line.number for line in piece.lines], piece.lost, piece.following) == ([15, 16, 17, 18], 12, 19)
    newest = wire.newest(3, 4)
    assert ([line.number for line in newest.lines], newest.lost) == ([21, 22, 23, 24], 18)
    assert [line.number for line in wire.newest(22, 10).lines] == [22, 23, 24]
    for nothing in (wire.read(25, 4), wire.newest(25, 4), wire.read(1000, 4)):
        assert (nothing.lines, nothing.lost, nothing.following) == ([], 0, None)


def test_a_recording_is_read_by_decode_byte_for_byte() -> None:
    wire, clock = traffic(max_lines=4)
    for data in (b"QX\r", b"QY\r", b"F\0\xc8\r\n", b"\xff\r"):
        clock.now_ns += 1_000_000
        wire.passed(data, "host", 0.0)
    wire.note("the link is open again")
    parser = capture.Parser("it")
    records = parser.receive_data(wire.recording())
    assert parser.header is not None
    assert (parser.header.protocol, parser.header.baud) == ("walter", 9600)
    assert records == [
        capture.Note(3_000_000, "2 messages before these were not kept"),
        capture.Chunk(3_000_000, "host", b"F\0\xc8\r"),
        capture.Chunk(4_000_000, "host", b"\n"),
        capture.Chunk(4_000_000, "host", b"\xff\r"),
        capture.Note(4_000_000, "the link is open again"),
    ]
    assert parser.close() == ([], "")


def test_of_a_link_it_hears_everything_and_how_it_ends() -> None:
    async def use() -> None:
        wire, _ = traffic()
        faulty = FaultyLink(MemoryLink(SimulatedWalter(), "sim:walter"), Faults())
        link = wire.listen(faulty)
        link.write(b"QP\r")
        answer = b""
        while len(answer) < 4:
            answer += await link.read(link.now() + 1.0)
        link.write_urgent(EMERGENCY_STOP)
        link.write(b"1\rF\0")
        faulty.unplug(1.0)
        for _ in range(3):
            with pytest.raises(LinkClosedError):
                await link.read(link.now() + 1.0)
        await link.close()
        await link.sleep(link.now() + 2.0)
        await link.reopen()
        link.write(b"QX\r")
        assert told(wire.read(0, 20)) == [
            ("host", 0, "message", "query_pen"),
            ("robot", 0, "message", "pen_reply down=0"),
            ("host", 3, "message", "emergency stop"),
            ("host", 12, "message", "select_logo"),
            ("host", 13, "message", "empty_line"),
            ("host", 14, "error", "the stream ends within a message"),
            (None, 0, "note", "the link to sim:walter ended: a fault that was asked for"),
            (None, 0, "note", "the link is open again"),
            ("host", 0, "message", "query_x"),
        ]

    asyncio.run(use())


def test_it_is_read_while_it_is_written() -> None:
    wire, _ = traffic(max_lines=50)

    def write() -> None:
        for _ in range(5_000):
            wire.passed(b"QX\rQY\r", "host", 0.0)

    writer = threading.Thread(target=write)
    writer.start()
    at = seen = lost = 0
    while writer.is_alive() or at < wire.count:
        piece = wire.read(at, 7)
        assert [line.number for line in piece.lines] == list(
            range(at + piece.lost, at + piece.lost + len(piece.lines))
        )
        seen, lost, at = seen + len(piece.lines), lost + piece.lost, piece.following or at
    writer.join()
    assert seen + lost == 10_000
