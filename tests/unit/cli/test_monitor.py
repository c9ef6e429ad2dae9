"""What ``turtlewire monitor`` refuses, and its parts. The whole of it: tests/end_to_end/test_monitor.py."""

from __future__ import annotations

import os
import sys
import threading
from typing import TYPE_CHECKING

import pytest

from turtlewire.capture import Chunk, Note, Record
from turtlewire.cli import monitor
from turtlewire.cli.main import main
from turtlewire.cli.monitor import Follower, Printer
from turtlewire.errors import OutputError
from turtlewire.protocols.catalogue import codec

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        ([], 2, "monitor stands between two ports: --port A --port B"),
        (["--port", "/dev/x"], 2, "monitor stands between two ports"),
        (["--port", "/dev/x", "--port", "/dev/y", "--listen", "pty"], 2, "monitor stands between two ports"),
        (["--listen", "pty", "--port", "nonsense"], 2, "'nonsense' is no port"),
        (
            ["--listen", "/dev/x", "--port", "pty"],
            2,
            "cannot listen at '/dev/x': write pty, or socket://host:port",
        ),
        (["--listen", "x", "--port", "pty"], 2, "cannot listen at 'x': write pty, or socket://host:port"),
        (["--listen", "pty", "--port", "/dev/ttyNOTHERE"], 3, "there is no port /dev/ttyNOTHERE"),
        (["--port", "/dev/ttyNOTHERE", "--port", "pty"], 3, "there is no port /dev/ttyNOTHERE"),
        (["--listen", "pty", "--port", "socket://127.0.0.1:1"], 3, "nobody listens at socket://127.0.0.1:1"),
        (["--listen", "socket://256.0.0.1:1", "--port", "pty"], 3, "cannot listen at socket://256.0.0.1:1"),
        (["--listen", "pty", "--port", "pty", "--record", "there"], 1, "there is there already"),
        (["--listen", "pty", "--port", "pty", "--record", "no/where"], 1, "cannot record to no/where"),
        (
            ["--listen", "pty", "--port", "pty", "--mode", "logo", "--protocol", "simple"],
            2,
            "simple has no mode",
        ),
        (["--listen", "pty", "--port", "/dev/null"], 3, "/dev/null"),
    ],
)
def test_one_clear_paragraph(
    arguments: list[str], code: int, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "there").touch()
    assert main(["monitor", *arguments]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err
    assert len(err.splitlines()) == 1


# ------------------------------------------------------------------------------------------------------ printing


def test_lines_of_both_directions(capfd: pytest.CaptureFixture[str]) -> None:
    printer = Printer(codec("walter"), as_json=False)
    printer(Chunk(1_000_000, "host", b"QH"))
    printer(Chunk(2_000_000, "robot", b"QH\0\x5a\r"))
    printer(Chunk(3_000_000, "host", b"\rF"))
    printer(Note(4_000_000, "the host has left"))
    printer.quiet(5_000_000)
    printer.finish(6_000_000)
    assert [" ".join(line.split()) for line in capfd.readouterr().out.splitlines()] == [
        "0.002000 robot 0 heading_reply heading_deg=90 # 51 48 00 5A 0D",
        "0.003000 host 0 query_heading # 51 48 0D",
        "0.004000 # the host has left",
        "0.006000 host 3 error: the stream ends within a message # 46",
    ]


def test_lines_for_programs(capfd: pytest.CaptureFixture[str]) -> None:
    printer = Printer(codec("simple"), as_json=True)
    printer(Note(0, "nothing of this"))
    printer(Chunk(1, "robot", b"K"))
    assert capfd.readouterr().out == (
        '{"t_ns":1,"offset":0,"raw":"4B","from":"robot","message":{"name":"accepted","fields":{}}}\n'
    )


def test_colours_on_a_terminal_only(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.delenv("NO_COLOR", raising=False)
    printer = Printer(codec("walter"), as_json=False)
    printer(Chunk(0, "host", b"PU\r\n?\r"))
    printer(Chunk(0, "robot", b"LF\r"))
    printer(Note(0, "a note"))
    colours = [line[:5] for line in capfd.readouterr().out.splitlines()]
    assert colours == ["\x1b[36m", "\x1b[2m ", "\x1b[31m", "\x1b[32m", "\x1b[2m "]
    monkeypatch.setenv("NO_COLOR", "1")
    Printer(codec("walter"), as_json=False)(Chunk(0, "host", b"PU\r"))
    assert "\x1b" not in capfd.readouterr().out


def test_what_a_protocol_gives_up_is_shown_when_it_is_quiet(capfd: pytest.CaptureFixture[str]) -> None:
    printer = Printer(codec("frame"), as_json=False)
    printer(Chunk(0, "host", b"\xa3\x00\x09"))
    printer.quiet(50_000_000)
    assert capfd.readouterr().out == ""
    printer.quiet(150_000_000)
    assert "incomplete: 3 bytes and no more" in capfd.readouterr().out


# ----------------------------------------------------------------------------------------------------- following


def follow(records: list[Record], act: object, done: str = "recorded") -> Follower:
    follower = Follower(act, done, 10.0)  # type: ignore[arg-type]  # a list's append, and the like
    follower.start(lambda: 7)
    for record in records:
        follower.put(record)
    follower.finish()
    return follower


def test_a_follower_gets_everything_in_order() -> None:
    records: list[Record] = [Chunk(n, "host", bytes([n])) for n in range(200)]
    got: list[Record] = []
    assert follow(records, got.append).failure is None
    assert got == records


def test_what_a_follower_cannot_take_in_time_is_left_out_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is blocked until all has been put; then it says what is missing. What it has taken makes room again."""
    monkeypatch.setattr(monitor, "MAX_BACKLOG_BYTES", 1000)
    may_go_on = threading.Event()
    has_taken = threading.Event()
    got: list[Record] = []

    def act(record: Record) -> None:
        may_go_on.wait()
        got.append(record)
        if len(got) == 3:
            has_taken.set()

    follower = Follower(act, "shown", 10.0)
    follower.start(lambda: 0)
    for n in range(10):
        follower.put(Chunk(n, "host", bytes(100)))
    may_go_on.set()
    has_taken.wait()
    follower.finish()
    assert got == [Chunk(n, "host", bytes(100)) for n in range(3)]


def test_what_was_left_out_is_noted_when_there_is_room_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(monitor, "MAX_BACKLOG_BYTES", 1000)
    got: list[Record] = []
    follower = Follower(got.append, "shown", 10.0)
    for n in range(10):
        follower.put(Chunk(n, "host", bytes(100)))
    follower.start(lambda: 0)
    while len(got) < 3:
        pass
    while not any(isinstance(record, Note) for record in got):
        follower.put(Chunk(99, "robot", b"K"))
    follower.finish()
    assert got[3:5] == [
        Note(99, f"{follower_left_out(got)} records before this were not shown: that took too long"),
        Chunk(99, "robot", b"K"),
    ]


def follower_left_out(got: list[Record]) -> int:
    """At least the seven of the first ten; more if it was still counting down when the next came."""
    note = next(record for record in got if isinstance(record, Note))
    count = int(note.text.split()[0])
    assert count >= 7
    return count


def test_what_fails_is_said_once_and_nothing_more_is_taken(capsys: pytest.CaptureFixture[str]) -> None:
    def act(record: Record) -> None:
        raise OutputError(f"the disk is full at {record.t_ns}")

    follower = follow([Chunk(n, "host", b"x") for n in range(5)], act)
    assert str(follower.failure) == "the disk is full at 0"
    assert capsys.readouterr().err == (
        "turtlewire: the disk is full at 0. Nothing more is recorded; bytes are passed on until Ctrl-C\n"
    )


def test_a_follower_that_does_not_end_is_left_behind(capsys: pytest.CaptureFixture[str]) -> None:
    release = threading.Event()
    follower = Follower(lambda _: release.wait(), "shown", 0.01)
    follower.start(lambda: 0)
    follower.put(Chunk(0, "host", b"x"))
    follower.finish()
    release.set()
    assert capsys.readouterr().err == "turtlewire: not everything was shown: that took too long\n"


def test_output_that_cannot_be_written_is_an_error(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(descriptor: int, data: bytes) -> int:
        raise BrokenPipeError(32, "Broken pipe")

    with monkeypatch.context() as patched:
        patched.setattr(os, "write", refuse)
        with pytest.raises(OutputError, match="cannot write the output: Broken pipe"):
            Printer(codec("simple"), as_json=False)(Chunk(0, "robot", b"K"))
