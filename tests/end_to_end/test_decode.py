"""``turtlewire decode`` on live pipes, long streams and terminals."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
from pathlib import Path
from typing import IO, TYPE_CHECKING

import pytest

from tests.end_to_end.conftest import COMMAND, DEADLINE_S

if TYPE_CHECKING:
    from collections.abc import Iterator

MEGABYTE = 1 << 20
# What the interpreter and what it imports take, and some room.
MAX_MEMORY = 60 * MEGABYTE


def start(
    *arguments: str, folder: Path | None = None, stdout: int = subprocess.PIPE
) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [*COMMAND, *arguments],
        stdin=subprocess.PIPE,
        stdout=stdout,
        stderr=subprocess.PIPE,
        cwd=folder,
        bufsize=0,
    )


def line_of(stream: IO[bytes] | None) -> bytes:
    assert stream is not None
    assert select.select([stream], [], [], DEADLINE_S)[0], "waited in vain for a line"
    return stream.readline()


def test_a_live_pipe_is_shown_byte_by_byte() -> None:
    with start("decode", "walter") as process:
        assert process.stdin is not None
        for data, text in (
            (b"F\0\xc8\r", b"forward"),
            (b"\nPU\r", b"skipped"),
            (b"", b"pen_up"),
            (b"?\r", b"error"),
        ):
            for byte in data:
                process.stdin.write(bytes([byte]))
            assert text in line_of(process.stdout)
        process.send_signal(signal.SIGINT)
        assert process.wait(DEADLINE_S) == 130


def test_it_ends_when_nobody_reads() -> None:
    """`turtlewire decode ... | head -1`, on a stream that never ends."""
    with start("decode", "simple", "--from", "robot") as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(b"K")
        assert b"accepted" in line_of(process.stdout)
        process.stdout.close()
        process.stdin.write(b"K")
        assert process.wait(DEADLINE_S) == 1
        assert process.stderr is not None
        assert b"the output is no longer read" in process.stderr.read()


def stream(size: int) -> Iterator[bytes]:
    """Long frames, now and then an error and noise: every way of the decoder."""
    payload = b"\x01\x00\xc8" * 41
    body = bytes([0xA3, 0, len(payload)]) + payload
    made = subprocess.run(
        [*COMMAND, "encode", "frame", "--raw", "frame 0;" + ";".join(["engine_forward 0 200"] * 41)],
        check=True,
        capture_output=True,
    ).stdout
    assert made.startswith(body)
    piece = (made * 60 + b"\xa3\x05noise" + bytes(100_000) + body) * 4
    for _ in range(0, size, len(piece)):
        yield piece


def peak_of(arguments: list[str], pieces: Iterator[bytes]) -> int:
    """The most memory that a command takes while a stream goes through it."""
    with start(*arguments, stdout=subprocess.DEVNULL) as process:
        assert process.stdin is not None
        for piece in pieces:
            process.stdin.write(piece)
        # Not ru_maxrss of wait4: that counts this process, too, which the child was for a moment.
        status = Path(f"/proc/{process.pid}/status").read_text("ascii")
        peak = next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM:"))
        process.stdin.close()
    assert process.wait() == 0
    return peak * 1024


def test_a_long_stream_takes_constant_memory() -> None:
    short = peak_of(["decode", "frame"], stream(MEGABYTE))
    long = peak_of(["decode", "frame"], stream(50 * MEGABYTE))
    assert long < MAX_MEMORY
    assert long < short + 10 * MEGABYTE


@pytest.mark.nightly
@pytest.mark.timeout(1800)
@pytest.mark.parametrize(
    "arguments", [["frame"], ["walter"], ["simple"], ["walter", "--from", "robot"]], ids=str
)
def test_a_very_long_stream_takes_constant_memory(arguments: list[str]) -> None:
    assert peak_of(["decode", *arguments], stream(200 * MEGABYTE)) < MAX_MEMORY


# ---------------------------------------------------------------------------------------------- on a terminal


def on_a_terminal(arguments: list[str], folder: Path, *, stdout_too: bool) -> tuple[int, str, bytes]:
    """Run with a terminal as standard error, and perhaps as standard output: exit code, terminal, output."""
    near, far = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, *arguments],
        stdin=subprocess.DEVNULL,
        stdout=far if stdout_too else subprocess.PIPE,
        stderr=far,
        cwd=folder,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "100"},
    )
    os.close(far)
    shown = bytearray()
    out = b""
    fds = [near] + ([process.stdout.fileno()] if process.stdout else [])
    while fds:
        for fd in select.select(fds, [], [], DEADLINE_S)[0]:
            try:
                data = os.read(fd, 65536)
            except OSError:
                data = b""
            if not data:
                fds.remove(fd)
            elif fd == near:
                shown += data
            else:
                out += data
    with process:
        process.wait(DEADLINE_S)
    os.close(near)
    return process.returncode, shown.decode(), out


@pytest.mark.parametrize("stdout_too", [True, False])
def test_a_file_has_a_progress_bar_on_a_terminal(tmp_path: Path, stdout_too: bool) -> None:
    (tmp_path / "wire.bin").write_bytes(b"F\0\xc8\r" * 20_000)
    code, shown, out = on_a_terminal(["decode", "walter", "wire.bin"], tmp_path, stdout_too=stdout_too)
    assert code == 0
    assert "━" in shown
    assert "kB" in shown
    lines = shown if stdout_too else out.decode()
    assert lines.count("forward distance_half_mm=200") == 20_000


def test_no_bar_without_a_terminal(tmp_path: Path) -> None:
    (tmp_path / "wire.bin").write_bytes(b"PU\r")
    done = subprocess.run(
        [*COMMAND, "decode", "walter", "wire.bin"], cwd=tmp_path, capture_output=True, check=True
    )
    assert done.stderr == b""
