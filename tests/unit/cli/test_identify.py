"""``turtlewire identify`` of files; of ports: tests/end_to_end."""

from __future__ import annotations

import json
import random
import sys
from typing import TYPE_CHECKING

import pytest

from turtlewire.capture import Chunk, Header, encode_header, encode_record
from turtlewire.cli.main import main

if TYPE_CHECKING:
    from pathlib import Path

HOST = b"QH\rV\x64\rPD\rF\0\xc8\rR\0\x5a\rQX\rF\x0d\x0d\rR\0\x5a\rQY\rPU\rB\0\x07\rQP\r"
ROBOT = b"QH\0\0\rQX\0\xc8\rQY\0\x64\rQP\x01\rLF\rQL\0\xc8\0\x64\rQH\0\x5a\r"
RECORDING = (
    encode_header(Header.of(0, protocol="", baud=0, host="", robot=""))
    + encode_record(Chunk(0, "host", HOST))
    + encode_record(Chunk(1, "robot", ROBOT))
)


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)


def identify(data: bytes, tmp_path: Path, *options: str) -> int:
    (tmp_path / "wire.bin").write_bytes(data)
    return main(["identify", "wire.bin", *options])


def test_bytes_of_one_direction(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert identify(HOST, tmp_path) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "walter, from the host, mode logo (more than 99.9% sure)"
    assert (
        lines[1]
        == "  100.0% of 41 bytes are in 12 messages (forward 2, right 2, query_heading 1, set_speed 1)"
    )
    assert lines[2] == "  12 in Logo control, 0 in direct control"
    assert len(lines) == 4


def test_both_directions_of_a_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert identify(RECORDING, tmp_path) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")]
    assert lines == [
        "recorded from the host:",
        "walter, from the host, mode logo (more than 99.9% sure)",
        "recorded from the robot:",
        "walter, from the robot (more than 99.9% sure)",
    ]


def test_for_programs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert identify(RECORDING, tmp_path, "--json") == 0
    host, robot = map(json.loads, capsys.readouterr().out.splitlines())
    assert (host["recorded_from"], host["bytes"], host["is_sure"]) == ("host", 41, True)
    best = host["verdicts"][0]
    assert (best["protocol"], best["sender"], best["settings"]) == ("walter", "host", {"mode": "logo"})
    assert best["score"] > 0.99
    assert robot["verdicts"][0]["sender"] == "robot"


def test_hexadecimal_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert identify(HOST.hex(" ").encode(), tmp_path, "--hex") == 0
    assert capsys.readouterr().out.startswith("walter, from the host")


@pytest.mark.parametrize(
    ("data", "first", "second"),
    [
        (
            random.Random(1).randbytes(500),
            "none of the three protocols",
            "  they are likeliest bytes without structure",
        ),
        (
            b"All work and no play makes Jack a dull boy.\n" * 9,
            "none of the three protocols",
            "  they are likeliest text",
        ),
        (b"", "none of the three protocols", "  there are no bytes"),
        (b"PU\rPD", "none of the three protocols", "  they are likeliest"),
        (HOST[:6], "cannot tell; perhaps walter", "  100.0% of 6 bytes"),
    ],
    ids=["random", "text", "nothing", "little", "perhaps"],
)
def test_it_says_so_when_it_cannot_tell(
    data: bytes, first: str, second: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert identify(data, tmp_path) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(first)
    assert lines[1].startswith(second)


def test_what_else_it_may_be_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    identify(HOST[:6], tmp_path)
    assert "  or none (" in capsys.readouterr().out


def test_a_torn_recording_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert identify(RECORDING + b'{"t_ns":', tmp_path) == 0
    assert "line 4, the last one, is torn" in capsys.readouterr().err


def test_a_recording_of_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert identify(RECORDING.split(b"\n")[0] + b"\n", tmp_path) == 1
    assert "there are no bytes" in capsys.readouterr().out


def test_no_more_is_read_than_it_takes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert identify(HOST * 20_000, tmp_path, "--json") == 0
    assert json.loads(capsys.readouterr().out)["bytes"] == 1 << 16


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["nowhere.bin"], 1, "cannot read nowhere.bin: No such file"),
        (["."], 1, "it is a folder"),
        (["/dev/ttyNOTHERE"], 3, "there is no port /dev/ttyNOTHERE"),
        (["socket://127.0.0.1:1"], 3, "nobody listens at socket://127.0.0.1:1"),
        (["telnet://x"], 2, "there is no 'telnet' port"),
    ],
)
def test_one_clear_paragraph(
    arguments: list[str], code: int, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["identify", *arguments]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err
    assert len(err.splitlines()) == 1


def test_a_device_that_is_no_terminal_is_read_as_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["identify", "/dev/null"]) == 1
    assert "there are no bytes" in capsys.readouterr().out


@pytest.mark.parametrize("baud", ["fast", "0", "9600.0", "99999999"])
def test_a_rate_that_is_none(baud: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["identify", "/dev/ttyUSB0", "--baud", baud])
    assert ended.value.code == 2
