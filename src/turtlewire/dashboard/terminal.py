"""The terminal: textual's, made fit for somebody who drives.

What it is shown never keeps anybody waiting: a terminal that does not take it (a stalled ssh) gets the whole picture
anew when it does. It is asked to tell releases of keys. Ctrl-C is a signal, whatever the dashboard is doing.
"""

from __future__ import annotations

import codecs
import os
import selectors
import signal
import sys
import threading
from typing import TYPE_CHECKING, Any

from textual._xterm_parser import XTermParser
from textual.drivers.linux_driver import LinuxDriver
from textual.events import Key
from textual.message import Message

from turtlewire.dashboard import keyboard

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

# What may wait for the terminal: some whole screens.
MAX_WAITING = 1 << 18
# How long the last picture may take to leave.
LAST_S = 0.5
# How long to wait for the rest of what looks like a part of something; and for a reason to end.
REST_S, LOOK_S = 0.03, 0.1
CTRL_C = ("\x03", "\x1b[99;5u")


class KeyEvent(Message):
    """What a terminal tells of keys beside their presses."""

    def __init__(self, item: keyboard.Item) -> None:
        super().__init__()
        self.item = item


class Shown(Message):
    """The terminal takes what it is shown again: some of it got lost meanwhile."""


class HungUp(Message):
    """There is no terminal any more."""


class Output:
    """Writes in a thread of its own; nobody waits for it.

    Args:
        descriptor: of the terminal.
        caught_up: called, in that thread, when everything is written after something had to be left out.
    """

    def __init__(self, descriptor: int, caught_up: Callable[[], None]) -> None:
        self._descriptor = descriptor
        self._caught_up = caught_up
        self._waiting: list[bytes] = []
        self._size = 0
        self._has_left_out = False
        self._is_over = False
        self._changed = threading.Condition()
        # A daemon: a terminal that takes nothing any more keeps no program alive.
        self._thread = threading.Thread(target=self._run, name="turtlewire terminal", daemon=True)
        self._thread.start()

    def write(self, text: str) -> None:
        """Have text written."""
        data = text.encode("utf-8", "replace")
        with self._changed:
            if self._size > MAX_WAITING:
                self._waiting.clear()
                self._size = 0
                self._has_left_out = True
            self._waiting.append(data)
            self._size += len(data)
            self._changed.notify_all()

    def finish(self) -> None:
        """Write what waits, if that does not take too long."""
        with self._changed:
            self._is_over = True
            self._changed.notify_all()
        self._thread.join(LAST_S)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._is_over)
                data, self._waiting, self._size = b"".join(self._waiting), [], 0
                if not data:
                    return
                has_caught_up, self._has_left_out = self._has_left_out, False
            try:
                while data:
                    data = data[os.write(self._descriptor, data) :]
            except OSError:
                return  # the terminal is gone; a signal tells the dashboard
            if has_caught_up:
                self._caught_up()


class Terminal(LinuxDriver):
    """The driver of textual for a terminal."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        # Not standard error, which may be kept in a file.
        self._file = sys.__stdout__
        self._output: Output | None = None

    # ------------------------------------------------------------------ what it is shown

    def write(self, data: str) -> None:
        """Show something, sooner or later."""
        if self._output is not None:
            self._output.write(data)

    def start_application_mode(self) -> None:
        """Take the terminal, and have it tell of releases if it can."""
        self._output = Output(1, lambda: self.send_message(Shown()))
        super().start_application_mode()  # type: ignore[no-untyped-call] # textual's
        self.write(keyboard.TELL_EVENTS + keyboard.ASK)

    def close(self) -> None:
        """Show the last of it."""
        if self._output is not None:
            self._output.finish()
        super().close()

    def ask(self) -> None:
        """Ask the terminal whether it is there."""
        self.write(keyboard.ASK)

    # ------------------------------------------------------------------ what it tells

    def run_input_thread(self) -> None:
        """Read until the dashboard ends."""
        keys, parser = keyboard.Keyboard(), XTermParser(self._debug)
        decode = codecs.getincrementaldecoder("utf-8")("replace").decode
        with selectors.DefaultSelector() as selector:
            selector.register(self.fileno, selectors.EVENT_READ)
            wait_s = LOOK_S
            while not self.exit_event.is_set():
                if selector.select(wait_s):
                    try:
                        data = os.read(self.fileno, 4096)
                    except OSError:
                        data = b""
                    if not data:
                        self.process_message(HungUp())
                        return
                    self._take(keys.feed(decode(data)), parser)
                    wait_s = REST_S
                else:
                    self._take(keys.flush(), parser)
                    wait_s = LOOK_S
                self._pass_on(parser.tick())

    def _take(self, items: Iterable[keyboard.Item], parser: XTermParser) -> None:
        for item in items:
            if isinstance(item, keyboard.Escape):
                self.process_message(Key("escape", keyboard.ESCAPE))
                continue
            if not isinstance(item, keyboard.Text):
                self.process_message(KeyEvent(item))
                continue
            if any(key in item.text for key in CTRL_C):
                # A dashboard that hangs would not see a key.
                os.kill(os.getpid(), signal.SIGINT)
            self._pass_on(parser.feed(item.text))

    def _pass_on(self, messages: Iterable[Message]) -> None:
        for message in messages:
            self.process_message(message)

    # ------------------------------------------------------------------ when it is taken away for a while

    def _sigtstp_application(self, *_: object) -> None:
        stop = getattr(self._app, "stop_before_pause", None)
        if stop is not None:
            stop()
        super()._sigtstp_application()
