"""``turtlewire logo`` on a terminal: one instruction after the other. Ctrl-C stops the robots, and what runs."""

from __future__ import annotations

import contextlib
import sys

from turtlewire.cli import options, output
from turtlewire.cli.connected import Connected, as_turtles, save_picture
from turtlewire.cli.signals import Interrupted
from turtlewire.errors import TurtlewireError

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from collections.abc import Mapping
    from pathlib import Path
    from typing import NoReturn

    from turtlewire.cli.signals import Signals
    from turtlewire.configuration import Target
    from turtlewire.logo import Interpreter
    from turtlewire.turtle import Turtle

GREETING = "Logo with {}. BYE or Ctrl-D leaves, Ctrl-C stops."


def execute(arguments: argparse.Namespace, pictures: list[Path], signals: Signals) -> int:
    """Ask and do until somebody leaves. Whatever happens, the robots are stopped and the pictures are written."""
    from turtlewire.cli.logo_script import interpreter, save_pictures
    from turtlewire.logo import ScreenTurtle

    targets = options.targets(arguments)
    robots = _connected(targets)
    turtle: Turtle | Mapping[str, Turtle] = (
        as_turtles(robots.robots) if robots is not None else ScreenTurtle()
    )
    try:
        # Two of them, because the first one's finally may be hit by a signal itself; the second cannot.
        try:
            logo = interpreter(turtle, [], arguments.seed, arguments.step_mm)
            _Prompt(logo, robots, signals).greet(targets).go()
        finally:
            signals.hold()
    finally:
        try:
            if robots is not None:
                robots.close()
        finally:
            if robots is not None:
                for path in pictures:
                    save_picture([*robots.robots.values()], path, "Logo", moves=arguments.animate)
            elif isinstance(turtle, ScreenTurtle):
                save_pictures(turtle, pictures, "Logo", moves=arguments.animate)
    return 0


def _connected(targets: Mapping[str, Target]) -> Connected | None:
    """The robots, if any is wanted."""
    if not targets:
        return None

    def notify(name: str, text: str) -> None:
        output.tell(f"turtlewire: {text}" if len(targets) == 1 else f"turtlewire: {name}: {text}")

    return Connected(targets, notify, _announce)


def _announce(path: str) -> None:
    output.tell(f"waiting for the robot at {path}")


class _Left(BaseException):
    """BYE: no CATCH of a program keeps anybody."""


def _bye(_logo: Interpreter) -> NoReturn:
    raise _Left


class _Prompt:
    """The loop of asking and doing.

    Args:
        logo: what does it.
        robots: what it is done with; None: a turtle on paper.
        signals: those of this process.
    """

    def __init__(self, logo: Interpreter, robots: Connected | None, signals: Signals) -> None:
        from turtlewire.logo.procedures import Primitive
        from turtlewire.prompt.editor import Editor

        self._logo = logo
        self._robots = robots
        self._signals = signals
        self._editor = Editor(logo.procedures, logo.variables)
        self._line_is_open = False
        logo.write = self._write
        logo.ask = self._ask_within
        bye = logo.procedures["bye"] = Primitive("bye", 0, 0, 0)
        bye.function = _bye

    def greet(self, targets: Mapping[str, Target]) -> _Prompt:
        """Say what this is."""
        if not targets:
            what = "a turtle on paper"
        elif len(targets) == 1:
            what = f"a robot: {next(iter(targets.values())).name}"
        else:
            what = f"{len(targets)} robots: {', '.join(targets)}"
        output.write(GREETING.format(what) + "\n")
        return self

    def go(self) -> None:
        """Until somebody leaves, then close the files that are open.

        Raises ``Interrupted`` for a signal that is no Ctrl-C, ``LogoError`` for a file that cannot be finished.
        """
        failed = True
        try:
            self._signals.renew()
            while self._goes_on():
                pass
            failed = False
        finally:
            self._logo.streams.finish(failed=failed)

    def _goes_on(self) -> bool:
        """Take a turn, from which Ctrl-C comes back; whether there is to be another."""
        try:
            try:
                self._turn()
            except Interrupted as interrupted:
                self._come_back(interrupted)
        except (EOFError, _Left):
            return False
        except Interrupted as again:  # before the first one was dealt with
            self._come_back(again)
        return True

    def _come_back(self, interrupted: Interrupted) -> None:
        """After Ctrl-C: stop the robots, undisturbed. Raises ``Interrupted`` for any other signal."""
        self._signals.hold()
        if str(interrupted) != "SIGINT":
            raise interrupted
        self._stop()
        output.write("\nstopped\n")
        self._line_is_open = False
        self._signals.renew()

    def _turn(self) -> None:
        """Ask for an instruction and carry it out. Raises ``EOFError`` when somebody leaves."""
        text = self._ask("? ")
        if text is None:
            raise EOFError
        if text.strip():
            self._carry_out(text)

    def _ask(self, prompt: str) -> str | None:
        """What somebody writes behind a prompt; None at the end of it, by Ctrl-D."""
        self._end_line()
        while True:
            try:
                return self._editor.ask(prompt)
            except EOFError:
                return None
            except Interrupted:
                raise
            except KeyboardInterrupt:  # the key, while the terminal is in the editor's hands
                self._stop()

    def _ask_within(self, prompt: str) -> str | None:
        """The same while a program runs, which Ctrl-C ends."""
        self._end_line()
        try:
            return self._editor.ask(prompt)
        except EOFError:
            return None
        except Interrupted:
            raise
        except KeyboardInterrupt:
            raise Interrupted("SIGINT") from None

    def _carry_out(self, text: str) -> None:
        """Run it, and let the robots end their motion: what goes wrong there belongs to this instruction."""
        from turtlewire.logo import LogoError
        from turtlewire.prompt import marking

        robots = self._robots.robots if self._robots is not None else {}
        try:
            for name, robot in robots.items():
                if robot.link_state == "stopped":
                    robot.resume()
                    which = "the robot" if len(robots) == 1 else name
                    output.tell(f"turtlewire: the link is back; {which} goes on from where it was stopped")
            self._logo.run(text, marking.INPUT, keeps_files=True)
            for robot in robots.values():
                if robot.link_state == "connected":
                    robot.finish()
        except LogoError as error:
            self._stop()
            self._end_line()
            marking.show(error)
        except TurtlewireError as error:
            self._stop()
            self._end_line()
            output.tell("\n".join([f"turtlewire: {error}", *getattr(error, "__notes__", [])]))

    def _stop(self) -> None:
        """Stop the robots, if there are any, and learn where they stand.

        Of one that cannot be reached its driver says so, and stops it when it is.
        """
        if self._robots is not None:
            self._robots.stop()
            for robot in self._robots.robots.values():
                with contextlib.suppress(TurtlewireError):
                    robot.finish()

    def _write(self, text: str) -> None:
        if text:
            output.write(text)
            self._line_is_open = not text.endswith("\n")

    def _end_line(self) -> None:
        if self._line_is_open:
            self._write("\n")
        sys.stdout.flush()
