"""``turtlewire decode``, as a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from turtlewire.capture import Chunk, Header, Note, encode_header, encode_record
from turtlewire.cli.main import main

if TYPE_CHECKING:
    from pathlib import Path

SESSION = b"\0\0\0\0\0\r2\r 1\rF\0\xc8\r\nqh\r?!\rF\r"
RECORDING = encode_header(Header.of(0, protocol="walter", baud=9600, host="a", robot="b")) + b"".join(
    encode_record(record)
    for record in (
        Chunk(1_000_000, "host", b"Q"),
        Chunk(1_500_000, "host", b"H\rF\0"),
        Chunk(2_000_000, "robot", b"QH\0\x5a\r"),
        Note(3_000_000, "the host has left"),
    )
)


def turtlewire(
    *arguments: str, data: bytes = b"", folder: Path | None = None
) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-m", "turtlewire", *arguments],
        input=data,
        capture_output=True,
        check=False,
        cwd=folder,
        env={**os.environ, "PYTHONWARNINGS": "error"},
        timeout=60,
    )


def decode(*arguments: str, data: bytes = b"", folder: Path | None = None) -> list[str]:
    done = turtlewire("decode", *arguments, data=data, folder=folder)
    assert (done.returncode, done.stderr) == (0, b"")
    return done.stdout.decode().splitlines()


def test_one_line_a_message_or_error_with_its_offset() -> None:
    lines = decode("walter", data=SESSION)
    assert [line.split("  # ")[0].strip() for line in lines] == [
        "0  error: unknown letter 00",
        "6  select_direct",
        "8  stop",
        "9  select_logo",
        "10  empty_line",
        "11  forward distance_half_mm=200",
        "15  skipped: the line feed after a RET",
        "16  query_heading",
        "19  error: unknown letter '?'",
        "22  error: the stream ends within a message",
    ]
    assert b"".join(bytes.fromhex(line.split("#")[1]) for line in lines) == SESSION


def test_json_lines_hold_every_byte_of_the_stream() -> None:
    forms = [json.loads(line) for line in decode("walter", "--json", data=SESSION)]
    assert b"".join(bytes.fromhex(form["raw"]) for form in forms) == SESSION
    end = 0
    for form in forms:
        assert form["offset"] == end
        assert form["from"] == "host"
        assert len({"message", "error", "skipped"} & form.keys()) == 1
        end += len(bytes.fromhex(form["raw"]))


def test_who_sent_the_bytes_and_in_which_mode() -> None:
    assert "heading_reply heading_deg=90" in decode("walter", "--from", "robot", data=b"QH\0\x5a\r")[0]
    assert "start_forward" in decode("walter", "--mode", "direct", data=b"a")[0]
    assert "accepted" in decode("simple", "-", "--from", "robot", data=b"K")[0]


def test_hexadecimal_text(tmp_path: Path) -> None:
    (tmp_path / "wire.hex").write_text("46 00\nC80D\n 5\n055 0d")
    lines = decode("walter", "--hex", "wire.hex", folder=tmp_path)
    assert [line.split()[1] for line in lines] == ["forward", "pen_up"]


def test_a_dialect_and_a_crc() -> None:
    done = turtlewire(
        "encode", "frame", "set_lamp 1; beep low 200", "--dialect", "telemetry", "--crc", "rohc", "--raw"
    )
    lines = decode("frame", "--dialect", "telemetry", "--crc", "CRC-8/ROHC", data=done.stdout)
    assert "frame seq=0; set_lamp on=1; beep tone=low duration_ms=200" in lines[0]


# ------------------------------------------------------------------------------------------------- recordings


def test_both_directions_of_a_recording(tmp_path: Path) -> None:
    (tmp_path / "wire.jsonl").write_bytes(RECORDING)
    assert [" ".join(line.split()) for line in decode("walter", "wire.jsonl", folder=tmp_path)] == [
        "0.001500 host 0 query_heading # 51 48 0D",
        "0.002000 robot 0 heading_reply heading_deg=90 # 51 48 00 5A 0D",
        "0.003000 # the host has left",
        "0.003000 host 3 error: the stream ends within a message # 46 00",
    ]


def test_one_direction_of_a_recording_for_programs() -> None:
    lines = decode("walter", "--from", "robot", "--json", data=RECORDING)
    assert [json.loads(line) for line in lines] == [
        {
            "t_ns": 2_000_000,
            "offset": 0,
            "raw": "51 48 00 5A 0D",
            "from": "robot",
            "message": {"name": "heading_reply", "fields": {"heading_deg": 90}},
        }
    ]


def test_times_of_a_recording_count_for_frames_that_do_not_go_on(tmp_path: Path) -> None:
    records = [Chunk(0, "host", b"\xa3\x00\x7c"), Chunk(200_000_000, "host", b"\xa3\x05\x00")]
    crc = turtlewire("encode", "frame", "frame 5", "--raw").stdout[3:]
    data = encode_header(Header.of(0, protocol="frame", baud=1, host="", robot=""))
    data += b"".join(map(encode_record, [*records, Chunk(200_000_001, "host", crc)]))
    assert [line.split("#")[0].split(maxsplit=3)[3].strip() for line in decode("frame", data=data)] == [
        "error: incomplete: 3 bytes and no more",
        "frame seq=5",
    ]


def test_a_torn_recording_is_shown_up_to_there_and_said(tmp_path: Path) -> None:
    done = turtlewire("decode", "walter", data=RECORDING[:-20])
    assert done.returncode == 1
    assert b"heading_reply" in done.stdout
    assert b"line 5, the last one, is torn" in done.stderr
    assert done.stderr.count(b"\n") == 1


def test_what_only_looks_like_a_recording() -> None:
    assert len(decode("walter", data=b'{"format"')) == 1
    done = turtlewire("decode", "walter", data=b'{"format":"turtlewire-capture","version":9}\n')
    assert (done.returncode, done.stdout) == (1, b"")
    assert b"version 9" in done.stderr


# --------------------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["walter", "nowhere.bin"], 1, "turtlewire: cannot read nowhere.bin: No such file or directory"),
        (["walter", "."], 1, "turtlewire: cannot read .: it is a folder"),
        (["simple", "--mode", "logo"], 2, "turtlewire: simple has no mode"),
        (["walter", "--crc", "rohc"], 2, "turtlewire: walter has no crc"),
        (["frame", "--crc", "nonsense"], 1, "turtlewire: there is no CRC 'nonsense'"),
        (["frame", "--coverage", "all"], 1, "turtlewire: coverage must be"),
        (["frame", "--dialect", "nowhere.toml"], 1, "turtlewire: nowhere.toml: No such file"),
        (["frame", "--dialect", "broken.toml"], 1, "broken.toml"),
    ],
)
def test_one_clear_paragraph(
    arguments: list[str],
    code: int,
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    (tmp_path / "broken.toml").write_text("protocol = [")
    assert main(["decode", *arguments]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"46 0g", b"standard input is not hexadecimal"),
        (b"46 0", b"ends with half a byte, '0'"),
        (b"4\xe6", b"not hexadecimal"),
    ],
)
def test_what_is_not_hexadecimal(data: bytes, words: bytes) -> None:
    done = turtlewire("decode", "walter", "--hex", data=data)
    assert done.returncode == 1
    assert words in done.stderr


def test_an_unknown_protocol_is_wrong_usage() -> None:
    done = turtlewire("decode", "morse")
    assert done.returncode == 2
    assert b"invalid choice: 'morse'" in done.stderr


def test_nothing_is_no_line() -> None:
    assert decode("walter") == []
