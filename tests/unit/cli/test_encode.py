"""``turtlewire encode``, as a process of its own."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

# Commands in every shape that a robot takes, and things that are no commands.
WALTER = b"\0\0\0\r2\r 1\rF\0\xc8\r\nqh\rcl\xff\xff\x80\0\r\nPu\r?!\rE1\r"


def turtlewire(*arguments: str, data: bytes = b"") -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-m", "turtlewire", *arguments],
        input=data,
        capture_output=True,
        check=False,
        env={**os.environ, "PYTHONWARNINGS": "error"},
        timeout=60,
    )


@pytest.mark.parametrize(
    ("arguments", "lines"),
    [
        (["walter", "forward distance_half_mm=200"], ["46 00 C8 0D"]),
        (["walter", "forward", "200"], ["46 00 C8 0D"]),
        (
            ["walter", "forward", "200", "PEN_UP", "go_to", "x_half_mm=-1", "-2"],
            ["46 00 C8 0D", "50 55 0D", "43 4C FF FF FF FE 0D"],
        ),
        (["simple", "drive_forward 7", "stop"], ["46 30 30 37 30 30 30", "53 30 30 30 30 30 30"]),
        (["frame", "frame", "frame 9;", "engine_forward", "0", "1"], ["A3 00 00 FA", "A3 09 03 01 00 01 C2"]),
    ],
)
def test_arguments_are_messages(arguments: list[str], lines: list[str]) -> None:
    done = turtlewire("encode", *arguments)
    assert (done.returncode, done.stderr) == (0, b"")
    assert [line[:-3] if arguments[0] == "frame" else line for line in done.stdout.decode().splitlines()] == [
        line[:-3] if arguments[0] == "frame" else line for line in lines
    ]


def test_the_bytes_themselves() -> None:
    done = turtlewire("encode", "walter", "forward 2573", "set_speed 255", "go_to -1 -32768", "--raw")
    assert done.stdout == b"F\x0a\x0d\rV\xff\rCL\xff\xff\x80\x00\r"


@pytest.mark.parametrize("form", [[], ["--json"]])
def test_what_decode_printed_encodes_to_the_canonical_bytes(form: list[str]) -> None:
    shown = turtlewire("decode", "walter", *form, data=WALTER)
    done = turtlewire("encode", "walter", "--raw", *form, data=shown.stdout)
    assert done.returncode == 0
    assert done.stdout == b"2\r 1\rF\0\xc8\rQH\rCL\xff\xff\x80\0\rPU\rE1\r"
    assert done.stderr == b"turtlewire: 4 lines left out: no message, or one that no host sends\n"


def test_lines_are_encoded_as_they_come() -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "turtlewire", "encode", "walter", "--raw"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        bufsize=0,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    with process:
        for line, data in (
            (b"pen_up\n", b"PU\r"),
            (b"\n pen_down # now\n", b"PD\r"),
            (b"# nothing\nquery_x\n", b"QX\r"),
        ):
            process.stdin.write(line)
            assert process.stdout.read(3) == data
        process.stdin.write(b"query_y")
        process.stdin.close()
        assert process.stdout.read() == b"QY\r"
    assert process.returncode == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["walter", "fly"], "there is no message 'fly'; known are select_direct"),
        (["walter", "forward"], "'forward' lacks distance_half_mm"),
        (["walter", "forward 70000"], "must be a whole number from 0 to 65535"),
        (["walter", "forward", "far"], "'far' is not a whole number"),
        (["walter", "forward speed=3"], "'speed=3' fits no field; forward has distance_half_mm"),
        (["simple", "drive_forward 256"], "0 to 255"),
        (["frame", "engine_forward 2 1"], "has 2 engines"),
    ],
)
def test_what_cannot_be_encoded_leaves_no_byte(arguments: list[str], words: str) -> None:
    done = turtlewire("encode", arguments[0], *["stop"] * (arguments[0] != "frame"), *arguments[1:], "--raw")
    assert (done.returncode, done.stdout) == (1, b"")
    assert words in done.stderr.decode()
    assert done.stderr.count(b"\n") == 1


@pytest.mark.parametrize(
    ("form", "data", "words"),
    [
        ([], b"pen_up\nfly\npen_down\n", "no message 'fly'"),
        (["--json"], b'{"message":{"name":"pen_up"}}\nnonsense\n', "'nonsense' is not JSON"),
        ([], b"pen_up\nforward 1 2\n", "'2' fits no field"),
    ],
)
def test_a_line_that_is_wrong_is_named_and_those_before_it_are_encoded(
    form: list[str], data: bytes, words: str
) -> None:
    done = turtlewire("encode", "walter", *form, data=data)
    assert (done.returncode, done.stdout) == (1, b"50 55 0D\n")
    assert words in done.stderr.decode()
    assert "It stands in line 2 of the standard input." in done.stderr.decode()


def test_a_line_without_end() -> None:
    done = turtlewire("encode", "walter", data=b"pen_up\n" + b"x" * 1_100_000)
    assert (done.returncode, done.stdout) == (1, b"50 55 0D\n")
    assert b"line 2 of the standard input is too long for a message" in done.stderr


GUIDE = Path(__file__).parents[3] / "docs" / "wire-tools.md"


@pytest.mark.parametrize(
    "block", re.findall(r"^```console\n\$ (.*?)^```", GUIDE.read_text("utf-8"), re.MULTILINE | re.DOTALL)
)
def test_the_guide_shows_what_is_printed(block: str, tmp_path: Path) -> None:
    command, _, shown = block.partition("\n")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-c", command],
        cwd=tmp_path,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == shown
