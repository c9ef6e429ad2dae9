"""Programs that run in a process of their own, on a simulated robot that the helm lends: real processes, real pipes."""

from __future__ import annotations

import io
import json
import os
import signal
import threading
import time
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.configuration import target
from turtlewire.console.runs import Program, Run, Runs
from turtlewire.console.said import KEPT, Output
from turtlewire.console.worker import PIECE, Work
from turtlewire.errors import LinkClosedError
from turtlewire.helm.helm import Helm

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from turtlewire.helm.lease import Lease

DEADLINE_S = 40.0


def wait_until(condition: Callable[[], object], what: str) -> None:
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.002)


class Owner:
    """Who has a robot: a helm, and no more."""

    def __init__(self, url: str, pace: float) -> None:
        self.helm = Helm(target(url), pace=pace, announce=lambda _text: None)
        self.helm.connect()

    def borrow(self) -> Lease:
        return self.helm.lend()

    def halt(self) -> None:
        self.helm.stop()

    @property
    def stands(self) -> bool:
        view = self.helm.view
        return abs(view.speed_mm_per_s) < 0.5 and abs(view.turn_deg_per_s) < 0.5

    def wait_for_rest(self) -> None:
        """Until it is seen at one and the same place for a while of its own time."""
        since, pose = self.helm.view.time_s, None

        def rests() -> bool:
            nonlocal since, pose
            view = self.helm.view
            if view.pose != pose:
                since, pose = view.time_s, view.pose
            return view.time_s - since > 3.0

        wait_until(rests, "the robot to stand")


@pytest.fixture(scope="module")
def owner() -> Iterator[Owner]:
    """A WALTER who lives ten times as fast as we do."""
    made = Owner("sim:walter", 10.0)
    yield made
    made.helm.close()


@pytest.fixture
def runs(owner: Owner, tmp_path: Path) -> Iterator[Runs]:
    made = Runs(owner, tmp_path)
    yield made
    made.close()


def start(runs: Runs, source: str, **how: Any) -> Run:
    return runs.start(Program(source, "p.logo", **how))


def phase(run: Run, *names: str) -> None:
    def is_there() -> bool:
        now = run.state["phase"]
        assert now in names or not run.is_over, run.state
        return now in names

    wait_until(is_there, f"phase {names}, not {run.state}")


def ran(runs: Runs, source: str, **how: Any) -> Run:
    run = start(runs, source, **how)
    wait_until(lambda: run.is_over, f"its end: {run.state}")
    return run


def written(run: Run) -> str:
    return run.output(0)[1]


def stop(owner: Owner, run: Run) -> None:
    """As a station does it: the robot first."""
    owner.halt()
    run.stop()


# ---------------------------------------------------------------------- the way it should go


def test_the_robot_does_what_the_program_says(owner: Owner, runs: Runs) -> None:
    run = ran(runs, 'cs seth 0 print pos repeat 2 [fd 30 rt 90] print pos\nprint "Ärtor')
    assert run.state["phase"] == "ended"
    assert run.state["error"] is None
    assert written(run) == "0 0\n30 30\nÄrtor\n"
    assert owner.helm.view.pose[:2] == pytest.approx((30, 30), abs=1)
    assert runs.state() is run.state
    assert not runs.is_running


def test_it_goes_on_from_where_the_robot_stands(runs: Runs) -> None:
    assert written(ran(runs, "cs fd 40 pu print pendownp")) == "false\n"
    assert written(ran(runs, "print pendownp print pos pd")) == "false\n0 40\n"


def test_the_line_that_is_told_is_the_one_whose_motion_is_seen(owner: Owner, runs: Runs) -> None:
    run = start(runs, "cs\nto go\n  fd 100\nend\ngo\nbk 100\n")
    wait_until(lambda: run.state["line"] == 3, "line 3")
    assert run.state["procedure"] == "go"
    assert run.state["depth"] == 1
    wait_until(lambda: run.state["line"] == 6, "line 6")
    # It has gone all the way before the next line began; a view would be older than that.
    assert owner.helm._robot.trace.pose.y_mm > 97
    phase(run, "ended")


def test_an_error_is_told_with_its_number_procedure_and_place(owner: Owner, runs: Runs) -> None:
    run = ran(runs, 'to half :n\n  output :n / "x\nend\nfd 5 print half 3')
    assert run.state["phase"] == "failed"
    error = run.state["error"]
    assert error["text"] == "/ doesn't like x as input"
    assert (error["number"], error["procedure"], error["file"], error["line"]) == (7, "half", "p.logo", 2)
    owner.wait_for_rest()


def test_an_error_of_the_robot_is_told_with_the_place(tmp_path: Path) -> None:
    arena = tmp_path / "wall.toml"
    arena.write_text("[[wall]]\npoints = [[-500, 300], [500, 300]]\n", "utf-8")
    owner = Owner(f"sim:walter?arena={arena}", 10.0)
    try:
        run = ran(Runs(owner, None), "rt 0\nfd 1000\n")
        assert run.state["error"]["kind"] == "LimitReachedError"
        assert run.state["error"]["line"] == 2
        caught = ran(Runs(owner, None), "bk 50\nonlimit [print limitsensor]\nfd 1000\nprint [on it goes]\n")
        assert caught.state["phase"] == "ended"
        assert written(caught) == "front\non it goes\n"
    finally:
        owner.helm.close()


def test_a_robot_that_is_not_reached_is_told(tmp_path: Path) -> None:
    class Nobody:
        def borrow(self) -> Lease:
            raise LinkClosedError("the robot is not reached")

        def halt(self) -> None:
            """There is none."""

    run = ran(Runs(Nobody(), tmp_path), "fd 10")
    assert run.state["phase"] == "failed"
    assert run.state["error"]["text"] == "the robot is not reached"


def test_a_car_whose_clock_is_the_hosts_runs_programs_too(tmp_path: Path) -> None:
    owner = Owner("sim:simple", 10.0)
    try:
        run = ran(Runs(owner, tmp_path), "fd 50 rt 90 eyeson print heading")
        assert written(run) == "90\n"
    finally:
        owner.helm.close()


# ---------------------------------------------------------------------- stopping


@pytest.mark.parametrize(
    "source",
    [
        "forever []",
        "forever [fd 0]",
        'forever [print "flood]',
        "to again\n  again\nend\nagain",
        "fd 100000",
        "wait 600000",
        "print readlist",
        'catch "error [fd 100000] forever [catch "error [fd 100]]',
        "onlimit [forever []] fd 100000",
    ],
)
def test_a_stop_ends_it_whatever_it_is_doing(owner: Owner, runs: Runs, source: str) -> None:
    run = start(runs, source)
    phase(run, "running", "asking")
    wait_until(lambda: run.state["line"] is not None or run.state["phase"] == "asking", "the first line")
    assert runs.is_running
    stop(owner, run)
    assert run.is_stopping or run.is_over
    phase(run, "stopped")
    assert not owner.helm._robot._step_by_step  # what comes next is as it was
    owner.wait_for_rest()


def test_a_stop_ends_it_where_it_stands(owner: Owner, runs: Runs) -> None:
    run = start(runs, "fd 10", is_paused=True)
    phase(run, "paused")
    stop(owner, run)
    phase(run, "stopped")
    assert run.state["paused"] is None


def test_a_stop_before_it_has_begun(owner: Owner, runs: Runs) -> None:
    run = start(runs, "forever [fd 100]")
    stop(owner, run)
    phase(run, "stopped")
    owner.wait_for_rest()


def test_last_words_are_said_and_nothing_in_them_moves(owner: Owner, runs: Runs) -> None:
    run = start(runs, 'onstop [print "bye hornhi wait 6 hornoff print "silence fd 100 print "no]\nfd 100000')
    wait_until(lambda: run.state["line"] == 2, "the motion")
    stop(owner, run)
    phase(run, "stopped")
    assert written(run).startswith("bye\nsilence\n")
    assert "\nno\n" not in written(run)
    owner.wait_for_rest()


@pytest.mark.parametrize(
    "source", ["forever []", "print readlist", "to again\n  again\nend\nagain", "wait 600000"]
)
def test_wherever_it_is_stopped_it_says_its_last_words(owner: Owner, runs: Runs, source: str) -> None:
    run = start(runs, f'onstop [print "bye]\n{source}')
    wait_until(lambda: (run.state["line"] or 0) >= 2, "what stands behind it")
    stop(owner, run)
    phase(run, "stopped")
    assert written(run) == "bye\n"


def test_a_paused_program_says_its_last_words_too(owner: Owner, runs: Runs) -> None:
    run = start(runs, 'onstop [print "bye]\nprint 1', breakpoints=(2,))
    phase(run, "paused")
    stop(owner, run)
    phase(run, "stopped")
    assert written(run) == "bye\n"


def test_a_process_that_hears_nothing_is_ended(
    owner: Owner, runs: Runs, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("turtlewire.console.runs.LAST_WORDS_S", 0.1)
    run = start(runs, "forever []")
    phase(run, "running")
    assert run._worker is not None
    os.kill(run._worker.pid, signal.SIGSTOP)
    stop(owner, run)
    phase(run, "stopped")


def test_last_words_that_go_on_and_on_are_ended(owner: Owner, runs: Runs) -> None:
    run = start(runs, "onstop [forever [wait 1]]\nfd 100000")
    wait_until(lambda: run.state["line"] == 2, "the motion")
    stop(owner, run)
    assert run.is_stopping
    other = start(runs, 'print "next')  # whoever begins the next one does not wait for them
    phase(other, "ended")
    assert run.is_over


def test_closing_ends_the_process_and_stops_the_robot(owner: Owner, runs: Runs) -> None:
    run = start(runs, "fd 100000")
    wait_until(lambda: not owner.stands, "motion")
    worker = run._worker
    assert worker is not None
    run.close()
    assert run.state["phase"] == "stopped"
    assert worker.wait() == -signal.SIGKILL
    owner.wait_for_rest()


@pytest.mark.parametrize("source", ["fd 100000", "forever []"])
def test_a_process_that_is_killed_stops_the_robot(owner: Owner, runs: Runs, source: str) -> None:
    run = start(runs, source)
    wait_until(lambda: run.state["line"] == 1, "the first line")
    assert run._worker is not None
    os.kill(run._worker.pid, signal.SIGKILL)
    phase(run, "failed")
    assert run.state["error"]["kind"] == "process"
    owner.wait_for_rest()


def test_the_process_ends_when_the_server_does(owner: Owner, runs: Runs) -> None:
    run = start(runs, "forever []")
    phase(run, "running")
    worker = run._worker
    assert worker is not None
    worker.stdin.close()  # as the system does it for a server that was killed
    assert worker.wait() == 1
    phase(run, "failed")


# ---------------------------------------------------------------------- bounds


def test_memory_is_bounded(runs: Runs) -> None:
    run = ran(runs, 'make "a "x\nrepeat 40 [make "a word :a :a]')
    assert run.state["phase"] == "failed"
    assert run.state["error"]["text"] == "out of space"
    assert run.state["error"]["line"] == 2


def test_memory_that_is_taken_little_by_little_is_bounded(runs: Runs) -> None:
    run = ran(runs, 'make "a []\nforever [make "a fput array 1000 :a]')
    assert run.state["phase"] == "failed"
    assert run.state["error"]["text"] == "out of space"
    assert run.state["error"]["line"] == 2


def test_a_program_that_prints_and_prints_is_slowed_down_and_its_end_is_kept(
    owner: Owner, runs: Runs
) -> None:
    run = start(runs, 'make "n 0\nforever [make "n :n + 1 print :n]')
    wait_until(lambda: run.state["written"] > 2 * KEPT, "a lot of output")
    stop(owner, run)
    phase(run, "stopped")
    first, text = run.output(0)
    assert len(text) == KEPT
    assert first + len(text) == run.state["written"]
    last = text.split("\n")
    assert int(last[-2]) - int(last[-102]) == 100  # nothing within is lost


def test_what_is_not_handed_on_yet_has_a_bound() -> None:
    """Or a program that prints faster than anybody takes it would fill the memory."""
    job = {
        "source": "", "name": "p.logo", "paused": False, "breakpoints": [], "folder": None, "pose": [0, 0, 0],
        "pen": True, "step_mm": 1.0,
    }  # fmt: skip
    sent = io.BytesIO()
    work = Work(job, io.BytesIO(), sent)
    work.write("x" * PIECE)  # so much is no reason to wait
    thread = threading.Thread(target=work.write, args=("yz",))
    thread.start()
    wait_until(lambda: work._room._waiters, "the program to wait")  # type: ignore[attr-defined]
    assert thread.is_alive()
    work.flush()
    thread.join(DEADLINE_S)
    assert not thread.is_alive()
    said = "".join(json.loads(line)["wrote"] for line in sent.getvalue().splitlines())
    assert said == "x" * PIECE + "yz"


def test_output_from_any_place_on() -> None:
    output = Output()
    output.add("abc")
    assert [output.since(index) for index in (0, 2, 3, 9)] == [(0, "abc"), (2, "c"), (3, ""), (3, "")]
    output.add("x" * KEPT)
    assert output.since(0) == (3, "x" * KEPT)
    assert output.written == KEPT + 3


# ---------------------------------------------------------------------- typed, paused, stepped


def test_what_it_reads_somebody_types(runs: Runs) -> None:
    run = start(runs, "print sum readword 1\nshow readchar\nshow eofp show readlist show readlist")
    phase(run, "asking")
    run.type("41")
    wait_until(lambda: "42" in written(run), "the sum")
    phase(run, "asking")
    run.type("xyz")
    phase(run, "ended", "asking")
    run.type(None)
    phase(run, "ended")
    assert "x\n" in written(run)


def test_a_pause_does_not_wait_for_the_end_of_a_long_line(owner: Owner, runs: Runs) -> None:
    run = start(runs, "fd 5 bk 5 " * 500)
    wait_until(lambda: run.state["line"] == 1, "the line")
    run.pause()
    phase(run, "paused")
    owner.wait_for_rest()
    assert run.state["line"] == 1
    run.go("on")
    phase(run, "running")
    wait_until(lambda: not owner.stands, "motion")


def test_a_tight_loop_can_be_paused_too(runs: Runs) -> None:
    run = start(runs, 'forever [\n  make "a 1\n]')
    wait_until(lambda: run.state["line"] == 2, "the loop")
    run.pause()
    phase(run, "paused")
    assert run.state["paused"]["reason"] == "pause"


def test_steps_breakpoints_variables_and_instructions_meanwhile(runs: Runs) -> None:
    source = 'to inner :x\n  print :x\n  print :x + 1\nend\ninner 5\ninner 7\nprint "end\n'
    run = start(runs, source, is_paused=True, breakpoints=(7,))

    def at(line: int) -> None:
        wait_until(
            lambda: run.state["phase"] == "paused" and run.state["line"] == line, f"line {line}: {run.state}"
        )

    at(5)
    run.go("into")
    at(2)
    assert run.state["paused"] == {"reason": "step", "variables": {"x": "5"}}
    run.do('make "x 50')
    wait_until(lambda: run.state["paused"]["variables"] == {"x": "50"}, "the other value")
    run.do("print 1 / 0")
    wait_until(lambda: "doesn't like 0" in written(run), "the error, which ends nothing")
    run.go("over")
    at(3)
    run.go("out")
    at(6)
    run.go("over")
    at(7)
    run.go("on")
    phase(run, "ended")
    assert written(run).split("\n")[-5:] == ["51", "7", "8", "end", ""]


def test_a_breakpoint_that_is_set_while_it_runs(runs: Runs) -> None:
    run = start(runs, 'forever [\n  make "a 1\n  make "b 2\n]')
    phase(run, "running")
    run.set_breakpoints((3,))
    phase(run, "paused")
    assert run.state["line"] == 3
    assert run.state["paused"]["reason"] == "breakpoint"
    assert run.state["breakpoints"] == (3,)
    run.set_breakpoints(())
    run.go("on")
    phase(run, "running")


# ---------------------------------------------------------------------- what it may not


def test_its_files_are_those_of_the_folder(runs: Runs, tmp_path: Path) -> None:
    run = ran(
        runs, 'openwrite "a.txt setwrite "a.txt print "kept setwrite [] close "a.txt\nopenread "/etc/hostname'
    )
    assert (tmp_path / "a.txt").read_text("utf-8") == "kept\n"
    assert run.state["error"]["text"] == "I can't open file /etc/hostname"
    assert "programs folder" in run.state["error"]["hint"]


def test_a_file_has_a_bound(runs: Runs, tmp_path: Path) -> None:
    run = ran(
        runs, 'make "a "x\nrepeat 22 [make "a word :a :a]\nopenwrite "big setwrite "big repeat 5 [print :a]'
    )
    assert run.state["phase"] == "failed"
    assert (tmp_path / "big").stat().st_size <= 10_000_000


def test_no_file_of_a_program_is_taken_for_one_of_pythons(runs: Runs, tmp_path: Path) -> None:
    """A class may write what it likes into the folder, and none of it is ever run as Python."""
    proof = tmp_path / "proof"
    for name in ("turtlewire", "json", "random", "sitecustomize", "queue"):
        (tmp_path / f"{name}.py").write_text(f"open({str(proof)!r}, 'w')\nraise SystemExit", "utf-8")
    assert written(ran(runs, "print random 1")) == "0\n"
    assert not proof.exists()


def test_half_a_character_breaks_nothing(runs: Runs) -> None:
    run = ran(runs, 'catch "error [print char 55296] print "fine')
    written(run).encode("utf-8")
    assert written(run).endswith("fine\n")
