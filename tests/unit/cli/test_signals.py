"""Signals at the prompt: each counts, none disturbs what is done about the one before."""

from __future__ import annotations

import signal

import pytest

from turtlewire.cli.signals import Interrupted, Signals


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
    # As after every signal that ends a program, nothing disturbs the rest of its way out.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        assert callable(signal.getsignal(number))
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
