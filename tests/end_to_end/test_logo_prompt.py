"""``turtlewire logo`` on a real terminal: somebody writes, looks, and presses Ctrl-C."""

from __future__ import annotations

import re
import resource
import signal
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from .conftest import DEADLINE_S, Cli, wait_until

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Callable, Iterator

    from .terminal import Terminal

MOST = 500_000_000  # bytes of memory
CTRL_C, CTRL_D, TAB, UP = "\x03", "\x04", "\t", "\x1b[A"


class Prompt:
    """Somebody at the prompt; ``at_prompt`` is whether it waits for him."""

    def __init__(self, screen: Terminal, folder: Path, *arguments: str) -> None:
        self.screen = screen
        self.folder = folder
        self.process: subprocess.Popen[bytes] = screen.run(
            ["logo", *arguments],
            folder,
            # pyte does not say where its cursor is.
            {"XDG_STATE_HOME": str(folder / "state"), "PROMPT_TOOLKIT_NO_CPR": "1"},
        )
        self.wait_for_prompt()

    def last_lines(self, count: int) -> list[str]:
        return [line for line in self.screen.lines() if line][-count:]

    def wait_for_prompt(self, prompt: str = "?") -> None:
        wait_until(lambda: self.last_lines(1) == [prompt], f"{prompt} on\n{self.screen.shown}")

    def enter(self, *lines: str) -> list[str]:
        """Write lines; what stands below them when it asks again."""
        for line in lines:
            self.screen.press(line + "\r")
        asked = [f"{prompt} {lines[-1]}" for prompt in "?>"]
        wait_until(lambda: self._below(asked)[-1:] == ["?"], f"an answer on\n{self.screen.shown}")
        return self._below(asked)[:-1]

    def _below(self, asked: list[str]) -> list[str]:
        shown = self.last_lines(30)
        return shown[max((i for i, line in enumerate(shown) if line in asked), default=len(shown)) + 1 :]

    def ended(self) -> int:
        return self.process.wait(DEADLINE_S)


@pytest.fixture
def prompt(terminal: Callable[..., Terminal], tmp_path: Path) -> Iterator[Callable[..., Prompt]]:
    processes: list[subprocess.Popen[bytes]] = []

    def start(*arguments: str) -> Prompt:
        made = Prompt(terminal(100, 30), tmp_path, *arguments)
        processes.append(made.process)
        return made

    yield start
    for process in processes:
        process.kill()
        process.wait()


def test_a_session(prompt: Callable[..., Prompt]) -> None:
    at = prompt()
    assert "turtle on paper" in at.screen.shown
    assert at.enter("print sum 3 4") == ["7"]
    assert at.enter("to greet :who", 'print sentence "hello :who', "end") == []
    assert "> end" in at.screen.shown
    assert at.enter('greet "Ada') == ["hello Ada"]
    assert at.enter("print [a", "b]") == ["a b"]
    assert at.enter('type "unfinished') == ["unfinished"]
    assert at.enter("fd 50 print pos") == ["0 50"]
    at.screen.press(CTRL_D)
    assert at.ended() == 0


def test_the_session_in_the_documentation(prompt: Callable[..., Prompt]) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "logo-tools.md").read_text("utf-8")
    session = re.search(r"^```text\n(\? .*?)^```", page, re.MULTILINE | re.DOTALL)
    assert session is not None
    at = prompt()
    for part in re.split(r"^\? ", session[1], flags=re.MULTILINE)[1:]:
        lines = part.splitlines()
        asked = [lines[0], *(line[2:] for line in lines[1:] if line.startswith("> "))]
        assert at.enter(*asked) == [line for line in lines[1:] if not line.startswith("> ")]


def test_stepping(prompt: Callable[..., Prompt]) -> None:
    at = prompt()
    at.enter("to side :n", "fd :n", "print pos", "end")
    at.screen.press('step "side side 20\r')
    at.wait_for_prompt("[fd :n] >>>")
    at.screen.press("\r")
    at.wait_for_prompt("[print pos] >>>")
    at.screen.press("fd 1\r")
    wait_until(lambda: at.last_lines(2)[0] == "[print pos] >>> fd 1", f"an answer on\n{at.screen.shown}")
    at.wait_for_prompt("[print pos] >>>")
    at.screen.press("\r")
    wait_until(lambda: at.last_lines(2) == ["0 21", "?"], f"the prompt on\n{at.screen.shown}")
    at.screen.press("side 20\r")
    wait_until(lambda: at.last_lines(1) == ["[fd :n] >>>"], f"a line on\n{at.screen.shown}")
    at.screen.press(CTRL_C)
    wait_until(lambda: at.last_lines(2) == ["stopped", "?"], f"the prompt on\n{at.screen.shown}")
    assert at.enter("show pos") == ["[0 21]"]


def test_bye_leaves_whatever_catches(prompt: Callable[..., Prompt]) -> None:
    at = prompt("--picture", "drawn.svg")
    at.enter("fd 50 rt 90 fd 20")
    at.screen.press('catch "toplevel [bye] print 1\r')
    assert at.ended() == 0
    assert 'id="ink"' in (at.folder / "drawn.svg").read_text("utf-8")


def test_errors_are_marked_at_their_place(prompt: Callable[..., Prompt]) -> None:
    at = prompt()
    assert at.enter("fd 10 forwrd 20") == [
        "I don't know how to forwrd",
        "    fd 10 forwrd 20",
        "          ^",
        "Did you mean forward?",
    ]
    assert re.search(r"\x1b\[0;[\d;]*31[\d;]*mforwrd", at.screen.text)
    at.enter("to wrong", "print :nothing", "end")
    assert at.enter("wrong")[:2] == ["nothing has no value in wrong", "    print :nothing"]
    assert at.enter("print pos") == ["0 10"]
    assert "in line" not in at.screen.shown


def test_ctrl_c_ends_a_tight_loop_and_leaves_the_workspace(prompt: Callable[..., Prompt]) -> None:
    at = prompt()
    at.enter('make "kept 5')
    at.enter("to around", "around", "end")
    for number, loop in enumerate(("repeat 1e9 []", "forever []", "around", "while [1 = 1] [fd 1 rt 1]")):
        at.screen.press(f'(print "loop {number}) {loop}\r')
        at.screen.wait_for(f"\nloop {number}")
        at.screen.press(CTRL_C)
        wait_until(lambda: at.last_lines(2) == ["stopped", "?"], f"the prompt on\n{at.screen.shown}")
        assert at.enter(f"print {number} + :kept") == [str(number + 5)]
    at.screen.press("half a line" + CTRL_C)
    at.wait_for_prompt()
    assert at.process.poll() is None


def test_a_signal_from_elsewhere_at_the_prompt(prompt: Callable[..., Prompt]) -> None:
    at = prompt()
    at.screen.press("half a li")
    at.screen.wait_for("half a li")
    at.process.send_signal(signal.SIGINT)
    wait_until(lambda: at.last_lines(2) == ["stopped", "?"], f"the prompt on\n{at.screen.shown}")
    assert at.enter("print [and on]") == ["and on"]
    at.screen.press("print :un" + TAB + "\x1b[D" * 3 + CTRL_C)
    at.wait_for_prompt()
    at.screen.press(CTRL_D)
    assert at.ended() == 0


def test_completion_and_history(prompt: Callable[..., Prompt]) -> None:
    at = prompt()
    at.enter('make "circumference 12', "to hexagon", "repeat 6 [fd 10 rt 60]", "end")
    at.screen.press("print :circ" + TAB)
    at.screen.wait_for("print :circumference")
    at.screen.press("\r")
    at.screen.wait_for("\n12 ")
    at.wait_for_prompt()
    at.screen.press("HEXA" + TAB)
    at.screen.wait_for("HEXAGON")
    at.screen.press("\r")
    at.wait_for_prompt()
    at.screen.press("PRINT BUTF" + TAB)
    at.screen.wait_for("PRINT BUTFIRST")
    at.screen.press(CTRL_C + CTRL_D)
    assert at.ended() == 0
    again = prompt()
    again.screen.press(UP)
    again.screen.wait_for("HEXAGON")
    history = again.folder / "state" / "turtlewire" / "logo_history"
    assert history.stat().st_mode & 0o777 == 0o600
    again.screen.press(UP)
    again.screen.wait_for("print :circumference")


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 130), (signal.SIGHUP, 130)])
@pytest.mark.parametrize("busy", [True, False])
def test_other_signals_end_it(prompt: Callable[..., Prompt], number: int, code: int, busy: bool) -> None:
    at = prompt("--picture", "drawn.svg")
    at.enter("fd 50")
    if busy:
        at.screen.press('print "off forever []\r')
        at.screen.wait_for("\noff")
    at.process.send_signal(number)
    assert at.ended() == code
    assert (at.folder / "drawn.svg").exists()
    assert "Traceback" not in at.screen.text


def test_w8_ctrl_c_stops_the_robot_at_once_and_asks_again(prompt: Callable[..., Prompt], cli: Cli) -> None:
    robot = cli.simulate("--listen", "pty", speed="1")
    at = prompt("--port", robot.url, "--set", "boot_s=0")
    assert at.enter("fd 2 print pos") == ["0 2"]
    at.screen.press('print "off fd 5000\r')
    robot.wait_for_action("started forward distance_half_mm=10000")
    at.screen.press(CTRL_C)
    robot.wait_for_action("stopped")
    at.wait_for_prompt()
    y = float(at.enter("print ycor")[-1])
    assert 2 <= y < 1000
    at.enter("bk 1")
    assert robot.actions[-1].startswith("ended back")
    at.screen.press("fd 5000\r")
    started = "started forward distance_half_mm=10000"
    wait_until(lambda: sum(each.startswith(started) for each in robot.actions) == 2, "the second way")
    at.screen.press(CTRL_C + CTRL_C + CTRL_C)
    wait_until(lambda: sum(action.startswith("stopped") for action in robot.actions) >= 2, "a second stop")
    at.wait_for_prompt()
    at.screen.press(CTRL_D)
    assert at.ended() == 0
    robot.wait_until_still()


def test_w8_whoever_ends_it_stops_the_robot(prompt: Callable[..., Prompt], cli: Cli) -> None:
    robot = cli.simulate("--listen", "pty", speed="1")
    at = prompt("--port", robot.url, "--set", "boot_s=0")
    at.screen.press("fd 5000\r")
    robot.wait_for_action("started forward")
    at.process.send_signal(signal.SIGTERM)
    robot.wait_for_action("stopped")
    assert at.ended() == 130


def test_a_link_that_is_lost(prompt: Callable[..., Prompt], cli: Cli) -> None:
    robot = cli.simulate("--listen", "socket://127.0.0.1:0", speed="1")
    url = robot.url
    at = prompt("--port", url)
    at.screen.press("fd 5000\r")
    robot.wait_for_action("started forward")
    robot.clean_up()
    at.wait_for_prompt()
    assert "turtlewire: the link to socket://" in at.screen.shown
    assert at.enter("print [still here]") == ["still here"]
    robot = cli.simulate("--listen", url, speed="1")
    at.screen.wait_for("was reached again")
    at.wait_for_prompt()
    assert not any(action.startswith("started") for action in robot.actions)
    at.enter("fd 2")
    robot.wait_for_action("started forward")
    assert "the link is back" in at.screen.shown


def test_an_error_of_the_robot_ends_no_session(prompt: Callable[..., Prompt]) -> None:
    at = prompt("--port", "sim:walter?groups=CQ", "--set", "groups=CQ")
    assert "has no horn" in " ".join(at.enter("hornhi"))
    assert at.enter("fd 20 print pos") == ["0 20"]


def test_the_keyboard_and_files_of_a_program(prompt: Callable[..., Prompt]) -> None:
    at = prompt()
    at.screen.press('print "who? make "name readlist print :name\r')
    at.screen.wait_for("\nwho?")  # before that, what is typed is typed at the prompt
    at.screen.press("Ada Lovelace\r")
    wait_until(lambda: at.last_lines(2) == ["Ada Lovelace", "?"], f"the answer on\n{at.screen.shown}")
    at.enter('openwrite "notes setwrite "notes')
    at.enter("print [one line]")
    at.enter("setwrite []")
    at.screen.press(CTRL_D)
    assert at.ended() == 0
    assert (at.folder / "notes").read_text("utf-8") == "one line\n"


def test_pause_asks_within_the_procedure(prompt: Callable[..., Prompt]) -> None:
    at = prompt()
    at.enter("to deep :n", "pause", "print :n", "end")
    at.screen.press("deep 7\r")
    at.wait_for_prompt("deep?")
    at.screen.press("print :n + 1 continue\r")
    at.screen.wait_for("\n8 ")
    at.wait_for_prompt()
    assert at.last_lines(3)[-2:] == ["7", "?"]


def test_after_a_program_that_took_all_memory_it_goes_on(prompt: Callable[..., Prompt]) -> None:
    at = prompt()
    resource.prlimit(at.process.pid, resource.RLIMIT_AS, (MOST, MOST))
    said = at.enter('make "a [] forever [make "a fput repcount / 7 :a]')
    assert any("out of space" in line for line in said)
    assert at.enter("print 3 + 4") == ["7"]
    assert at.enter('make "a []') == []
    assert at.enter("print count :a") == ["0"]
    at.screen.press(CTRL_D)
    assert at.ended() == 0
