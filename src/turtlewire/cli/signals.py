"""Ctrl-C, SIGTERM and SIGHUP: one way out for all, taken once, and disturbed by no other."""

from __future__ import annotations

import _thread
import sys
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    import signal
    from collections.abc import Callable
    from types import FrameType
    from typing import Any, Self
else:
    import _signal as signal  # signal itself makes enumerations of what is in it: enum takes 5 ms to load

INTERRUPTED = 130
# What ends a program; SIGBREAK is Windows' Ctrl-Break.
NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
# An exception that was lost is raised once more after so long: by then Python has tidied up.
AGAIN_S = 0.01


class Interrupted(KeyboardInterrupt):
    """A signal asks this program to end. ``str`` of it names the signal."""


class Signals:
    """The first signal raises ``Interrupted``, or does what ``then`` says; every later one is only noted.

    So a second Ctrl-C never keeps the first one from stopping the robot. Whatever was ignored before (``nohup``)
    stays so. Where Python ignores exceptions (while it imports, and while it tidies up: callbacks of weak references,
    ``__del__``) one is not lost: it is raised again.

    Attributes:
        received: the name of the first signal, or ``""``.
    """

    def __init__(self) -> None:
        self.received = ""
        self._later: list[str] = []
        self._acts_always = False
        self._is_lost = False
        self._act: Callable[[], object] = self._raise
        self._ignore = sys.unraisablehook
        self._before: dict[int, Any] = {}  # the handlers
        self._names: dict[int, str] = {}

    def __enter__(self) -> Self:
        for name in NAMES:
            number: int | None = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) not in (signal.SIG_IGN, None):
                self._names[number] = name
                self._before[number] = signal.signal(number, self._handle)
        self._ignore, sys.unraisablehook = sys.unraisablehook, self._ignored
        return self

    def __exit__(self, *_: object) -> None:
        # After a signal nothing may disturb what little is left of the way out.
        if not self.received:
            for number, handler in self._before.items():
                signal.signal(number, handler)
            sys.unraisablehook = self._ignore

    def then(self, act: Callable[[], object]) -> None:
        """Have this called on the first signal, in the main thread, instead of an exception."""
        self._act = act

    def hold(self) -> None:
        """From now on signals are only noted: the way out has begun."""
        self._act = lambda: None
        self._acts_always = self._is_lost = False

    def renew(self) -> None:
        """What came has been dealt with: from now on every signal raises ``Interrupted``, not only the first.

        Raises ``Interrupted`` if during ``hold`` a signal came that asks this program to end: not Ctrl-C once more.
        """
        later, self._later, self.received = self._later, [], ""
        self._act, self._acts_always = self._raise, True
        for name in later:
            if name != "SIGINT":
                self.received = name
                self._raise()

    def _handle(self, number: int, frame: FrameType | None) -> None:
        del frame
        name = self._names[number]
        if self.received and not (self._acts_always or self._is_lost):
            self._later.append(name)
        else:
            self.received, self._is_lost = name, False
            self._act()

    def _ignored(self, what: sys.UnraisableHookArgs) -> None:
        """Python ignores an exception: not one of ours."""
        number = getattr(signal, str(what.exc_value), None)
        if isinstance(what.exc_value, Interrupted) and number in self._names:
            self._is_lost = True
            # Not from here: this is called while Python tidies up.
            _thread.start_new_thread(self._send_again, (number,))
        else:
            self._ignore(what)

    def _send_again(self, number: Any) -> None:
        time.sleep(AGAIN_S)
        if self._is_lost:  # no other signal has come meanwhile
            _thread.interrupt_main(number)

    def _raise(self) -> None:
        raise Interrupted(self.received)
