"""A program, the driver, the wire and the robot, in processes of their own: all of it draws the same picture."""

from __future__ import annotations

import json
import re
import signal
from typing import TYPE_CHECKING

import pytest

from .conftest import IMPATIENT, Cli, check_same

if TYPE_CHECKING:
    from pathlib import Path

# Rounding in plenty, the pen up and down, absolute moves, and the way home.
PROGRAM = """
PD REPEAT 7 [FD 200 RT 360 / 7]
PU SETPOS [-120 77.3] PD ARC 200 60
SETH 33 BK 40.7 SETX 90 PU HOME PD FD 0.7
PRINT [all drawn]
"""
FIELDS: dict[str, type | tuple[type, ...]] = {
    "outcome": str,
    "exit_code": int,
    "program": str,
    "error": (dict, type(None)),
    "warnings": list,
    "pictures": list,
    "statistics": (dict, type(None)),
    "robot_pose": (dict, type(None)),
    "host_pose": (dict, type(None)),
    "deviation_mm": (dict, type(None)),
    "drawing": (str, type(None)),
    "host_seconds": float,
    "output": str,
}


def checked_json(text: str) -> dict[str, object]:
    """The one object on standard output, with every field that it always has."""
    assert text.count("\n") == 1
    result = json.loads(text)
    assert set(result) == set(FIELDS)
    for name, kind in FIELDS.items():
        assert isinstance(result[name], kind), name
    assert (result["error"] is None) == (result["outcome"] == "done")
    assert isinstance(result, dict)
    return result


@pytest.fixture(scope="module")
def in_process(tmp_path_factory: pytest.TempPathFactory) -> str:
    """What the program draws within one process."""
    cli = Cli(tmp_path_factory.mktemp("in_process"))
    ended = cli("run", cli.program(PROGRAM), "--picture", "drawn.svg")
    ended.check_said("program.logo: done", "times as fast as the robot", "drawn      drawn.svg")
    assert (ended.code, ended.out) == (0, "all drawn\n")
    cli.clean_up()
    return cli.text("drawn.svg")


@pytest.mark.parametrize(
    "options",
    [
        ["--listen", "pty"],
        ["--listen", "socket://127.0.0.1:0"],
        ["--listen", "pty", "--groups", "Q"],
        ["--listen", "pty", "--boot-s", "60"],
    ],
    ids=["pty", "socket", "without-absolute-moves", "still-booting"],
)
def test_over_a_port_it_draws_the_same(cli: Cli, in_process: str, options: list[str]) -> None:
    simulator = cli.simulate(*options, "--picture", "seen.svg")
    ended = cli("run", cli.program(PROGRAM), "--port", simulator.url, "--picture", "drawn.svg")

    ended.check_said("program.logo: done", "host pose  x 0 mm, y 0.7 mm, heading 0 degrees")
    assert re.search(r"robot pose x -?[01](\.5)? mm, y (0\.5|1) mm, heading 0 degrees", ended.err)
    assert "times as fast" not in ended.err
    assert (ended.code, ended.out) == (0, "all drawn\n")
    # Where the last half degree cannot be seen to by an absolute move, it shows at the end of a long one.
    tolerance_mm = 2.0 if "--groups" in options else 1.0
    check_same(cli.text("drawn.svg"), in_process, tolerance_mm)
    # And that is what was on the ground, not only what the driver thought.
    simulator.signal(signal.SIGTERM)
    assert simulator.end().code == 130
    check_same(cli.text("seen.svg"), in_process, tolerance_mm)


def test_a_basic_robot_draws_the_same(cli: Cli, in_process: str) -> None:
    # Paced by the calibration: the robot's time must be the wall's.
    program = "REPEAT 3 [FD 20 RT 120] SETPOS [5 5] PRINT POS"
    simulator = cli.simulate("--basic", "--picture", "seen.svg", speed="1")
    arguments = ["run", cli.program(program), *IMPATIENT, "--set", "speed=200", "--picture", "drawn.svg"]
    over_port = cli(*arguments, "--port", simulator.url)
    over_port.check_said("answers no queries", "run as a basic one", "robot pose it cannot tell")
    inside = cli("run", "program.logo", "--port", "sim:walter?basic=1", "--picture", "inside.svg")

    assert (over_port.code, over_port.out) == (0, "5 5\n")
    assert (inside.code, inside.out) == (0, "5 5\n")
    simulator.signal(signal.SIGINT)
    simulator.end()
    for name in ("drawn.svg", "seen.svg"):
        check_same(cli.text(name), cli.text("inside.svg"))


def test_a_basic_robot_is_refused_where_replies_are_required(cli: Cli) -> None:
    simulator = cli.simulate("--basic")
    arguments = ["run", cli.program("FD 10"), "--port", simulator.url, "--require-replies"]
    ended = cli(*arguments, *IMPATIENT, "--json")
    result = checked_json(ended.out)
    assert (ended.code, result["exit_code"], result["outcome"]) == (3, 3, "error")
    assert "does not answer" in str(result["error"])
    assert "started" not in "".join(simulator.actions)
    stopped = cli("stop", "--port", simulator.url, "--require-replies", *IMPATIENT)
    assert stopped.code == 3
    stopped.check_said("does not answer", "The stop was sent to")


def test_json_tells_all_of_a_run_over_a_port(cli: Cli) -> None:
    simulator = cli.simulate()
    program = cli.program('PRINT "Grüße FD 100 RT 90 PRINT HEADING')
    ended = cli("run", program, "--port", simulator.url, "--json", "--picture", "a.svg", "--picture", "b.png")
    result = checked_json(ended.out)
    assert (ended.code, ended.err) == (0, "")
    assert result["outcome"] == "done"
    assert result["output"] == "Grüße\n90\n"
    assert result["pictures"] == ["a.svg", "b.png"]
    assert result["robot_pose"] == result["host_pose"] == {"x_mm": 0.0, "y_mm": 100.0, "heading_deg": 90.0}
    statistics = result["statistics"]
    assert isinstance(statistics, dict)
    assert statistics["distance_mm"] == 100.0
    assert statistics["bytes_sent"] > statistics["commands"] > 0
    assert (cli.folder / "b.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("program", "code", "kind", "line"),
    [
        ("FD 10\nFDD 20\n", 1, "LogoError", 2),
        ("FD 10\nHORNLO\n", 3, "NotSupportedError", 2),
        ("[", 1, "LogoError", 1),
        (None, 1, "DataError", None),
    ],
)
def test_json_tells_of_an_error(
    cli: Cli, program: str | None, code: int, kind: str, line: int | None
) -> None:
    name = "missing.logo" if program is None else cli.program(program)
    robot = ["--port", "sim:walter?groups=Q", "--set", "groups=Q"]
    ended = cli("run", name, *robot, "--json", "--picture", "p.svg")
    result = checked_json(ended.out)
    assert (ended.code, result["exit_code"], result["outcome"]) == (code, code, "error")
    assert ended.err == ""
    error = result["error"]
    assert isinstance(error, dict)
    assert error["type"] == kind
    assert (error["position"] or {}).get("line") == line
    assert result["pictures"] == ([] if program is None else ["p.svg"])


@pytest.mark.parametrize("imperfection", ["slip=0.1", "noise=0.5"])
def test_the_same_seed_gives_the_same_bytes(cli: Cli, imperfection: str) -> None:
    def drawn(seed: int, name: str) -> bytes:
        port = ["--port", f"sim:walter?{imperfection}"]
        ended = cli("run", "p.logo", *port, "--seed", str(seed), "--picture", name)
        assert ended.code == 0
        return (cli.folder / name).read_bytes()

    cli.program("REPEAT 4 [FD 100 + RANDOM 50 RT 90]", "p.logo")
    first = drawn(1, "a.svg")
    assert drawn(1, "b.svg") == first
    assert drawn(2, "c.svg") != first


def test_the_seed_of_random_counts_at_a_port_too(cli: Cli) -> None:
    simulator = cli.simulate()
    cli.program("REPEAT 8 [TYPE RANDOM 10]", "p.logo")
    ways = [["--seed", "1"], ["--seed", "1", "--port", simulator.url], ["--seed", "2"]]
    one, same, other = (cli("run", "p.logo", *way).out for way in ways)
    assert re.fullmatch(r"\d{8}", one)
    assert one == same != other


def test_real_speed_lets_the_wall_clock_lead(cli: Cli) -> None:
    """At its real pace the program is still under way when a signal comes; at full speed it is through long before."""
    cli.program("PRINT 1 FD 60000 PRINT 2 WAIT 1 PRINT 3", "p.logo")
    assert cli("run", "p.logo").out == "1\n2\n3\n"
    process = cli.start("run", "p.logo", "--speed", "real")
    process.wait_for_out("1\n")
    process.signal(signal.SIGINT)
    ended = process.end()
    assert ended.code == 130
    assert "3" not in ended.out
    ended.check_said("interrupted (SIGINT) at p.logo, line 1")


def test_a_limit_without_a_handler_names_sensor_pose_and_line(cli: Cli, tmp_path: Path) -> None:
    cli.program("[[wall]]\npoints = [[-500, 200], [500, 200]]\n", "arena.toml")
    simulator = cli.simulate("--arena", "arena.toml")
    cli.program("PRINT 1\nFD 300\nREPEAT 100 [FD 20]\nPRINT 2\n", "p.logo")
    ended = cli("run", "p.logo", "--port", simulator.url, "--picture", "p.svg")
    assert (ended.code, ended.out) == (3, "1\n")
    ended.check_said(
        "the front limit sensor stopped the robot at x 0 mm, y 110 mm", "in p.logo, line 3, FD", "p.svg"
    )
    assert "The robot was stopped, after 0.11 m" in ended.err
    simulator.wait_until_still()
    # In the end the last motions of a program, too, have a place.
    ended = cli("run", cli.program("\nFD 300"), "--port", "sim:walter?arena=arena.toml")
    ended.check_said("the front limit sensor", "the last motions of program.logo, whose end is line 2")
    assert ended.code == 3


# A machine with much to do may take longer for an answer than a robot does.
PATIENT = {"simple": "&reply_delay_s=1", "frame": ""}


@pytest.mark.parametrize("robot", PATIENT)
def test_the_other_robots_are_served_and_driven_too(cli: Cli, robot: str) -> None:
    simulator = cli.simulate("--picture", "seen.svg", robot=robot, speed="1")
    ended = cli(
        "run", cli.program("FD 30 RT 90 FD 20"), "--port", f"{simulator.url}?protocol={robot}{PATIENT[robot]}"
    )
    assert ended.code == 0
    ended.check_said("program.logo: done", "x 20 mm, y 30 mm, heading 90 degrees")
    simulator.signal(signal.SIGTERM)
    assert simulator.end().code == 130
    assert (cli.folder / "seen.svg").read_text("utf-8").count("<path") > 2


def test_an_option_of_another_robot_is_refused(cli: Cli) -> None:
    ended = cli("simulate", "simple", "--basic")
    assert ended.code == 2
    ended.check_said("unknown option 'basic'")


@pytest.mark.parametrize("ghosts", [False, True])
def test_several_robots_on_one_floor(cli: Cli, ghosts: bool) -> None:
    """Each at a port and a place of its own, solid unless they are ghosts, and one picture of what all drew."""
    simulator = cli.simulate(
        *(["--ghosts"] if ghosts else []),
        "--json",
        "--listen",
        "socket://127.0.0.1:0",
        "--picture",
        "all.svg",
        robot="walter walter?start=0,500,0 simple",
    )
    robots = simulator.json_lines(3)
    assert [(robot["robot"], *robot["start"].values()) for robot in robots] == [
        ("walter", 0.0, 0.0, 0.0),
        ("walter", 0.0, 500.0, 0.0),
        ("simple", 1000.0, 0.0, 0.0),
    ]
    first, second, car = (robot["url"] for robot in robots)
    assert cli("run", cli.program("BK 40"), "--port", f"{car}?protocol=simple&reply_delay_s=1").code == 0
    assert cli("run", cli.program("RT 90 FD 50"), "--port", second).code == 0
    ended = cli("run", cli.program("FD 400"), "--port", first)
    assert ended.code == (0 if ghosts else 3)
    ended.check_said("done" if ghosts else "the front limit sensor")
    assert "robot 2: started right angle_deg=90" in simulator.err
    simulator.signal(signal.SIGTERM)
    assert simulator.end().code == 130
    drawn = (cli.folder / "all.svg").read_text("utf-8")
    assert [f'id="ink{n}"' in drawn for n in ("", "-2", "-3", "-4")] == [True, True, True, False]


def test_a_crowd_has_no_room(cli: Cli) -> None:
    (cli.folder / "cell.toml").write_text(
        "[[polygon]]\npoints = [[-200, -200], [200, -200], [200, 200], [-200, 200]]\n"
    )
    ended = cli("simulate", "walter", "--count", "5", "--arena", "cell.toml", "--spacing", "200")
    assert ended.code == 2
    ended.check_said("there is no room for robot 2 in this arena")
