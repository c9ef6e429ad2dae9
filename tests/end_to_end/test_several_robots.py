"""One program, two robots of different kinds at real ports: every way out stops both of them."""

from __future__ import annotations

import re
import signal
from typing import TYPE_CHECKING

import pytest

from .conftest import points, wait_until
from .test_logo_prompt import CTRL_C, CTRL_D, Prompt, prompt

if TYPE_CHECKING:
    from collections.abc import Callable

    from .conftest import Cli, Process, Simulator

__all__ = ["prompt"]  # the fixture

# Whoever runs it drives both of them at the same time, and further than any test goes.
ENDLESS = "print who\ntell [elsie rosa]\nrepeat 1000000 [fd 50 rt 91]\n"
CAR_MOVES = re.compile("speed=[1-9]")


class Pair:
    """A WALTER called elsie and a car called rosa."""

    def __init__(self, cli: Cli, listen: str = "pty") -> None:
        self.cli = cli
        self.elsie = cli.simulate("--listen", listen, speed="1")
        self.rosa = cli.simulate("--listen", listen, robot="simple", speed="1")

    @property
    def options(self) -> list[str]:
        ports = ["--port", f"elsie={self.elsie.url}", "--port", f"rosa={self.rosa.url}?protocol=simple"]
        return [*ports, "--set", "boot_s=0"]

    def run(self, text: str, *arguments: str) -> Process:
        return self.cli.start("run", self.cli.program(text), *self.options, *arguments)

    def wait_until_both_move(self, *, since: int = 0, way: str = "") -> None:
        """Until elsie goes this way, and the car moves; ``since`` so many actions of it."""
        self.elsie.wait_for_action(f"started forward{way}")
        wait_until(lambda: any(map(CAR_MOVES.search, self.rosa.actions[since:])), "a motion of the car")

    def check_both_stand(self) -> None:
        self.elsie.wait_until_still()
        assert any(action.startswith("stopped") for action in self.elsie.actions)
        check_stands(self.rosa)


def check_stands(car: Simulator) -> None:
    """The last that a car was told is to stand."""
    driven = [action for action in car.actions if "speed=" in action or "stop" in action]
    assert not CAR_MOVES.search(driven[-1]), driven[-3:]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal(cli: Cli, number: signal.Signals) -> None:
    pair = Pair(cli)
    process = pair.run(ENDLESS, "--picture", "drawn.svg")
    pair.wait_until_both_move()
    process.signal(number)
    ended = process.end()
    assert ended.code == 130
    assert ended.out == "elsie\n"
    ended.check_said("elsie was stopped, after", "rosa was stopped, after", "drawn.svg")
    pair.check_both_stand()
    assert 'id="turtle-2"' in cli.text("drawn.svg")


def test_an_error_in_the_program(cli: Cli) -> None:
    pair = Pair(cli)
    ended = pair.run('fd 5000 ask "rosa [fd 50] forwrd 3\n').end()
    assert ended.code == 1
    ended.check_said("Did you mean forward?", "elsie was stopped, after", "rosa was stopped, after")
    pair.check_both_stand()


def test_a_link_that_is_lost_stops_the_others_at_once(cli: Cli) -> None:
    pair = Pair(cli, "socket://127.0.0.1:0")
    process = pair.run(ENDLESS, "--set", "reconnect_s=100000")
    pair.wait_until_both_move()
    pair.rosa.signal(signal.SIGKILL)
    pair.rosa.end()
    process.wait_for_err("Waiting until rosa is reached again, and stopped")
    pair.elsie.wait_for_action("stopped")
    pair.elsie.wait_until_still()
    assert process.popen.poll() is None
    process.signal(signal.SIGINT)
    ended = process.end()
    assert ended.code == 3
    ended.check_said("rosa: the link to", "elsie was stopped, after", "rosa cannot be reached to stop it")


def test_one_that_is_not_there_leaves_the_others_standing(cli: Cli) -> None:
    pair = Pair(cli)
    program = cli.program(ENDLESS)
    ended = cli("run", program, "--port", f"elsie={pair.elsie.url}", "--port", "rosa=/dev/no-such-port")
    assert ended.code == 3
    ended.check_said("there is no port /dev/no-such-port")
    assert not any(action.startswith("started") for action in pair.elsie.actions)
    # And elsie's port is free again.
    assert cli("stop", "--port", pair.elsie.url).code == 0


def test_to_the_end(cli: Cli) -> None:
    pair = Pair(cli)
    program = 'fd 20 rt 90 ask "rosa [pu setpos [20 0] pd fd 30] tell [elsie rosa] fd 10\n'
    ended = pair.run(program, "--picture", "drawn.svg").end()
    assert ended.code == 0
    ended.check_said("\nelsie:\n  sent  ", "\nrosa:\n  sent  ", "\ndrawn: drawn.svg")
    host = re.findall(r"host pose  x (\S+) mm, y (\S+) mm", ended.err)
    assert host == [("10", "20"), ("20", "40")]
    drawn = cli.text("drawn.svg")
    assert len(points(drawn)) >= 3
    assert points(drawn.replace('id="ink"', 'id="first"').replace('id="ink-2"', 'id="ink"'))


def test_ctrl_c_at_the_prompt_stops_both(prompt: Callable[..., Prompt], cli: Cli) -> None:
    pair = Pair(cli)
    at = prompt(*pair.options)
    assert "2 robots: elsie, rosa" in at.screen.shown
    # A busy computer lets a robot be late, which its driver may tell before.
    assert at.enter("print who fd 2")[-1:] == ["elsie"]
    assert at.enter("tell [elsie rosa] fd 3 show who")[-1:] == ["[elsie rosa]"]
    assert at.enter("each [show round ycor]")[-2:] == ["5", "3"]
    before = len(pair.rosa.actions)
    at.screen.press("fd 5000\r")
    pair.wait_until_both_move(since=before, way=" distance_half_mm=10000")
    at.screen.press(CTRL_C)
    pair.elsie.wait_for_action("stopped")
    at.wait_for_prompt()
    pair.check_both_stand()
    at.screen.press(CTRL_D)
    assert at.ended() == 0


def test_what_kills_the_prompt_stops_both(prompt: Callable[..., Prompt], cli: Cli) -> None:
    pair = Pair(cli)
    at = prompt(*pair.options, "--picture", "drawn.svg")
    at.screen.press("tell [elsie rosa] fd 5000\r")
    pair.wait_until_both_move()
    at.process.send_signal(signal.SIGTERM)
    pair.elsie.wait_for_action("stopped")
    assert at.ended() == 130
    pair.check_both_stand()
    assert 'id="turtle-2"' in (at.folder / "drawn.svg").read_text("utf-8")
