"""``turtlewire calibrate`` of simulated robots: what it tells, what it writes, what it refuses."""

from __future__ import annotations

import io
import json
import re
import sys
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.cli.main import main
from turtlewire.configuration import target
from turtlewire.robots.calibrating import steps

if TYPE_CHECKING:
    from pathlib import Path

WRITTEN = """\
# Ours.
[elsie]  # she slips
port = "sim:walter"
mm_per_s_per_unit = 1.2    # the robot's, and its driver's
turn_scale = 0.95

[herbie]
port = "sim:simple"
trim_deg = 2.0
wheelbase_mm = 171.0
window = 4                 # it is quick
"""
FILE = "turtlewire/robots.toml"


@pytest.fixture(autouse=True)
def written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    file = tmp_path / FILE
    file.parent.mkdir()
    file.write_text(WRITTEN, "utf-8")
    return file


def deviation(capsys: pytest.CaptureFixture[str], *arguments: str) -> float:
    assert main(["run", "corner.logo", "--json", *arguments]) == 0
    largest: float = json.loads(capsys.readouterr().out)["deviation_mm"]["largest"]
    return largest


def test_a_car_is_measured_and_its_calibration_written(
    capsys: pytest.CaptureFixture[str], written: Path, tmp_path: Path
) -> None:
    (tmp_path / "corner.logo").write_text("REPEAT 4 [FD 200 RT 100]", "utf-8")
    before = deviation(capsys, "--robot", "herbie")
    assert main(["calibrate", "--robot", "herbie", "--write"]) == 0
    out, err = capsys.readouterr()
    rows = {re.split("  +", line)[0]: re.split("  +", line)[1:] for line in out.splitlines()}
    assert rows["trim_deg, degrees"][:2] == ["0", "2"]
    assert rows["wheelbase_mm, mm"] == ["160", "171"]
    assert rows["forward at PWM 255, mm/s"] == ["537.5", "537.5", "± 0"]
    assert "steering: It steers +255 and drives to the right at PWM" in err
    assert f"written to {written}" in err
    text = written.read_text("utf-8")
    assert text.startswith(WRITTEN.rstrip())
    assert "\n[herbie.calibration]\nwheelbase_mm = 171.0\ntrim_deg = 2.0\n" in text
    assert deviation(capsys, "--robot", "herbie") < 0.5 < 20.0 < before


def test_what_is_not_new_is_not_written(capsys: pytest.CaptureFixture[str], written: Path) -> None:
    assert main(["calibrate", "--robot", "herbie", "--steps", "dead_band", "--write"]) == 0
    assert "nothing of that is new" in capsys.readouterr().err
    assert written.read_text("utf-8") == WRITTEN


def test_nothing_is_written_that_nobody_wanted(capsys: pytest.CaptureFixture[str], written: Path) -> None:
    assert main(["calibrate", "--robot", "herbie", "--steps", "steering"]) == 0
    assert "written" not in capsys.readouterr().err
    assert written.read_text("utf-8") == WRITTEN


def test_a_robot_at_a_port_gets_an_entry(capsys: pytest.CaptureFixture[str], written: Path) -> None:
    url = "sim:frame?track_mm=150&slip=0.0&left_engine=1&right_engine=0"
    assert (
        main(["calibrate", "--port", url, "--write", "dot", "--steps", "engines,speed,backward,track"]) == 0
    )
    capsys.readouterr()
    text = written.read_text("utf-8")
    assert text.startswith(WRITTEN)
    assert '\n[dot]\nport = "sim:frame"\ntrack_mm = 150\nslip = 0.0\nleft_engine = 1\n' in text
    assert "\n[dot.calibration]\nleft_engine = 1\nright_engine = 0\ntrack_mm = 150.0\n" in text
    settings: Any = target("dot").settings()
    assert settings.calibration.track_mm == 150.0


def test_for_programs(capsys: pytest.CaptureFixture[str], written: Path) -> None:
    assert main(["calibrate", "--port", "sim:walter?turn_scale=1.05", "--json", "--write", "w"]) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert out.count("\n") == 1
    assert told["robot"] == "sim:walter?turn_scale=1.05"
    assert told["protocol"] == "walter"
    scale = next(found for found in told["found"] if found["name"] == "turn_scale")
    assert scale["new"] == pytest.approx(1.05, rel=0.001)
    assert len(scale["values"]) == 2
    assert set(scale) == {"name", "unit", "old", "new", "spread", "values"}
    assert told["lines"] == {"calibration": {"turn_scale": pytest.approx(1.05, rel=0.001)}}
    assert told["written"] == [str(written)]
    assert "drives" not in err
    # Simulated robot and driver have a value of the same name.
    assert "turn_scale = 1.05\n\n[w.calibration]\nturn_scale = 1.05\n" in written.read_text("utf-8")
    assert target("w").settings()._asdict()["turn_scale"] == 1.05


@pytest.mark.parametrize("protocol", ["walter", "simple", "frame"])
def test_each_step_can_be_made_alone(capsys: pytest.CaptureFixture[str], protocol: str) -> None:
    for step in steps(protocol):
        if step == "ticks":
            continue  # without an encoder
        assert main(["calibrate", "--robot", protocol, "--steps", step, "--json", "--repeats", "1"]) == 0
        told = json.loads(capsys.readouterr().out)
        assert told["found"], step


def test_how_badly_somebody_measures(capsys: pytest.CaptureFixture[str]) -> None:
    def spreads(*arguments: str) -> list[float]:
        command = ["calibrate", "--robot", "walter", "--json", "--repeats", "4", *arguments]
        assert main(command) == 0
        return [found["spread"] for found in json.loads(capsys.readouterr().out)["found"]]

    assert max(spreads()) < 1e-6
    noisy = spreads("--noise", "3", "--seed", "1")
    assert min(noisy) > 1e-4
    assert spreads("--noise", "3", "--seed", "1") == noisy
    assert spreads("--noise", "3", "--seed", "2") != noisy


def test_a_bad_line_costs_trials_not_the_calibration(capsys: pytest.CaptureFixture[str]) -> None:
    url = "sim:simple?trim_deg=2&faults=lose:0.001,seed:5"
    assert main(["calibrate", "--port", url, "--steps", "steering,speed"]) == 0
    out, err = capsys.readouterr()
    assert "this does not count: bytes got lost or damaged" in err
    assert re.search(r"^trim_deg, degrees +0 +(2|1\.99\d|2\.00\d)  ", out, re.MULTILINE)


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (
            ["--steps", "speed,foo"],
            2,
            "there is no step foo; this robot has\n  speed          how fast it drives",
        ),
        (["--robot", "frame", "--write"], 2, "--write: under which name?"),
        (["--robot", "frame", "--write", "pty"], 2, "'pty' cannot be the name of a robot"),
        (["--robot", "frame", "--write", "elsie"], 2, "has a robot of that name already"),
        (["--robot", "elsie", "--write", "herbie"], 2, "name different robots"),
        (
            ["--port", "/dev/null", "--measure", "simulated"],
            2,
            "--measure simulated is for a simulated robot",
        ),
        (["--port", "/dev/no-such-port"], 3, "there is no port /dev/no-such-port"),
        (["--port", "sim:frame?right_factor=0.2"], 1, "too far from how it is driven"),
    ],
)
def test_what_is_refused(
    capsys: pytest.CaptureFixture[str], written: Path, arguments: list[str], code: int, says: str
) -> None:
    assert main(["calibrate", *arguments]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert says in err
    assert "Traceback" not in err
    assert written.read_text("utf-8") == WRITTEN


@pytest.mark.parametrize(
    "arguments",
    [["--space-mm", "100"], ["--space-mm", "x"], ["--repeats", "0"], ["--repeats", "21"], ["--noise", "-1"]],
)
def test_numbers_that_are_none(capsys: pytest.CaptureFixture[str], arguments: list[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["calibrate", *arguments])
    assert f"{arguments[1]!r} is not a" in capsys.readouterr().err


# ------------------------------------------------------------------ somebody answers, from a file


def answered(monkeypatch: pytest.MonkeyPatch, *lines: str) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO("".join(f"{line}\n" for line in lines)))


STEP = ["calibrate", "--robot", "simple", "--measure", "person", "--steps", "speed", "--repeats", "1"]


def test_a_person_measures(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    # Go, far: to get to know it, a short and a long drive, fast and slow.
    answered(monkeypatch, "", "25 cm", "", "250", "", "750 mm", "", "750,0", "", "0.75m")
    assert main(STEP) == 0
    out, err = capsys.readouterr()
    assert "1. speed" not in err  # the third of a car's steps
    assert "3. speed: how fast it drives ahead, and how it starts and stops" in err
    assert "It drives ahead at PWM 148 for 0.93 s: about 251 mm." in err
    assert "Put it on the start line, with 0.4 m free before it." in err
    # No key is seen that comes from a file, nor while a simulated robot lives in virtual time.
    assert "While it moves, Ctrl-C stops it" in err
    assert re.search(r"^overrun_s, s +0 +0$", out, re.MULTILINE)
    assert re.search(r"^forward at PWM 148, mm/s +270 +26\d\.\d", out, re.MULTILINE)


def test_answers_that_make_no_sense_are_asked_again(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = ["x", "", "far", "3 m", "2,5 dm", "250", "", "250", "", "7500", "r", "", "750"]
    answered(monkeypatch, *lines, "s", "s")
    assert main(STEP) == 0
    out, err = capsys.readouterr()
    assert "press Enter alone, or one of s, b and q before it" in err
    assert err.count("write a number of mm") == 2
    assert (
        "3000 mm is not plausible: it should be from 50 to 1256, or its motors are off. Measure again" in err
    )
    assert "7500 mm is not plausible" in err
    assert err.count("It drives ahead at PWM 148 for 2.79 s: about 750 mm") == 2  # once more, after r
    assert "forward at PWM 255" not in out  # skipped


def test_a_person_may_insist(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    answered(monkeypatch, "", "20", "20", "q")
    assert main(STEP) == 0
    out, err = capsys.readouterr()
    assert err.count("20 mm is not plausible") == 1
    # It is that slow: the next drive is as long as any.
    assert "It drives ahead at PWM 148 for 3.2 s: about 69 mm." in err
    assert "nothing was measured" in out


def test_back_and_enough(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    # The first drive again, and once more; and in the middle of the third step it is enough.
    lines = ["", "300", "b", "", "", "b", "b", "", "250", "", "250", "", "750", "", "750", "s", "", "q"]
    answered(monkeypatch, *lines)
    assert main([*STEP[:-4], "--steps", "speed,backward", "--repeats", "1"]) == 0
    out, err = capsys.readouterr()
    assert err.count("It drives ahead at PWM 148 for 0.93 s: about 251 mm") == 4
    # The step that was done counts.
    assert re.search(r"^forward at PWM 148, mm/s +270 +268\.8$", out, re.MULTILINE)
    assert "backward" not in out


@pytest.mark.parametrize("count", [0, 1, 4])
def test_nobody_answers_any_more(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, written: Path, count: int
) -> None:
    answered(monkeypatch, *["", "250", "", "250", ""][:count])
    assert main([*STEP, "--write", "new"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert "nobody answers any more" in err
    assert "Nothing was written." in err
    assert written.read_text("utf-8") == WRITTEN


def test_what_makes_no_robot_is_left_out(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Faster at 103 than at 148, however often it is asked.
    answered(monkeypatch, "", "250", "", "250", "", "750", "s", "", "1500", "1500", "")
    assert main(STEP) == 0
    out, err = capsys.readouterr()
    assert "What was measured in this step makes no robot, and is left out" in err
    assert out == "nothing was measured\n"
