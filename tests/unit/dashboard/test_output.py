"""What a terminal is shown: nobody waits for it, and what was left out is made good."""

from __future__ import annotations

import contextlib
import os
import threading
import time
from typing import TYPE_CHECKING

import pytest

from turtlewire.dashboard import terminal
from turtlewire.dashboard.terminal import Output

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


def wait_until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.002)


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    near, far = os.pipe()
    yield near, far
    for end in (near, far):
        os.close(end)


def test_everything_is_written_in_order(pipe: tuple[int, int]) -> None:
    near, far = pipe
    caught_up = threading.Event()
    output = Output(far, caught_up.set)
    for n in range(100):
        output.write(f"{n}å ")
    output.finish()
    assert os.read(near, 65536).decode() == "".join(f"{n}å " for n in range(100))
    assert not caught_up.is_set()


def test_a_terminal_that_takes_nothing_keeps_nobody_waiting_and_is_shown_all_of_it_later(
    pipe: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    near, far = pipe
    monkeypatch.setattr(terminal, "LAST_S", 0.05)
    caught_up = threading.Event()
    output = Output(far, caught_up.set)
    piece = "x" * 1000
    for _ in range(2000):  # far more than anybody keeps
        output.write(piece)
    assert output._size <= terminal.MAX_WAITING + 1000
    output.write("the end")
    seen = b""
    while not seen.endswith(b"the end"):
        seen += os.read(near, 65536)
    wait_until(caught_up.is_set)
    assert 1000 <= len(seen) < 1_000_000
    output.finish()
    assert not output._thread.is_alive()
    # Stalled for good: it ends all the same.
    output = Output(far, caught_up.set)
    for _ in range(200):
        output.write(piece)
    output.finish()
    assert output._thread.is_alive()
    assert output._thread.daemon
    # What it still writes is taken without waiting for more: nobody says which is the last of it.
    os.set_blocking(near, False)
    while output._thread.is_alive():
        with contextlib.suppress(BlockingIOError):
            os.read(near, 65536)
        output._thread.join(0.002)


def test_a_terminal_that_is_gone_is_no_error() -> None:
    near, far = os.openpty()
    output = Output(far, lambda: None)
    os.close(near)
    output.write("x")
    wait_until(lambda: not output._thread.is_alive())
    output.write("y")
    output.finish()
    os.close(far)
