"""Signals: each counts at the prompt, none disturbs what is done about the one before, and none is lost."""

from __future__ import annotations

import signal
import sys
import threading
import time
from typing import TYPE_CHECKING

import pytest

from turtlewire.cli.signals import Interrupted, Signals

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(autouse=True)
def _left_as_found(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """As after every signal that ends a program, nothing disturbs the rest of its way out: but here things go on."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def test_after_renewal_every_signal_counts() -> None:
    with Signals() as signals:
        signals.renew()
        for _ in range(3):
            with pytest.raises(Interrupted, match="SIGINT"):
                signal.raise_signal(signal.SIGINT)


def test_while_held_signals_are_noted_and_ctrl_c_is_forgotten() -> None:
    with Signals() as signals:
        signals.renew()
        with pytest.raises(Interrupted):
            signal.raise_signal(signal.SIGINT)
        signals.hold()
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        signals.renew()
        assert signals.received == ""


def test_what_is_to_end_the_program_is_not_forgotten() -> None:
    with Signals() as signals:
        with pytest.raises(Interrupted, match="SIGINT"):
            signal.raise_signal(signal.SIGINT)
        signals.hold()
        signal.raise_signal(signal.SIGTERM)
        with pytest.raises(Interrupted, match="SIGTERM"):
            signals.renew()
        assert signals.received == "SIGTERM"
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        assert getattr(signal.getsignal(number), "__self__", None) is signals


def wait() -> None:
    deadline = time.monotonic() + 20.0
    while time.monotonic() < deadline:
        time.sleep(0.001)


class Tidied:
    """A signal comes while this one is tidied up."""

    def __del__(self) -> None:
        signal.raise_signal(signal.SIGINT)


class Slow:
    """Takes its time to be tidied up."""

    ended = 0

    def __del__(self) -> None:
        try:
            wait()
        finally:
            Slow.ended += 1


def test_an_exception_that_python_ignores_is_raised_again() -> None:
    def tidy() -> None:
        Tidied()
        wait()

    with Signals() as signals, pytest.raises(Interrupted, match="SIGINT"):
        tidy()
    assert signals.received == "SIGINT"


def test_and_again_until_it_is_not_ignored() -> None:
    def tidy() -> None:
        Tidied()
        Slow()
        Slow()
        wait()

    Slow.ended = 0
    with Signals(), pytest.raises(Interrupted):
        tidy()
    assert Slow.ended == 2


def test_one_that_was_ignored_is_not_raised_after_it_has_been_dealt_with(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As at the prompt, which stops the robot and asks again."""
    sent = threading.Event()
    send_again = Signals._send_again

    def send(signals: Signals, number: int) -> None:
        send_again(signals, number)
        sent.set()

    monkeypatch.setattr(Signals, "_send_again", send)
    with Signals() as signals:
        Tidied()
        signals.hold()
        signals.renew()
        assert sent.wait(20.0)
    assert signals.received == ""


def test_other_exceptions_are_ignored_as_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    ignored: list[sys.UnraisableHookArgs] = []
    monkeypatch.setattr(sys, "unraisablehook", ignored.append)

    class Broken:
        def __del__(self) -> None:
            raise ValueError("of somebody else's")

    with Signals():
        Broken()
    assert [str(each.exc_value) for each in ignored] == ["of somebody else's"]
