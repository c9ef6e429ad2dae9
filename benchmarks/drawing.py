"""What a drawing costs: its closure error, its pace, and the time from start to picture.

    python benchmarks/drawing.py [--json]

Each figure stands beside its yardstick, measured in the same run:

- How far from its start does the robot end after ``REPEAT 720 [FD 0.7 RT 0.5]``, and how far is it from the exact
  turtle on the way? Against rounding each command by itself.
- How many commands per second does a simulated drawing make? Against the robot's own time.
- How long does ``turtlewire run`` take from start to picture? As a multiple of ``python -c pass``.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from turtlewire.configuration import target
from turtlewire.connect import connect
from turtlewire.logo import Interpreter
from turtlewire.protocols.walter.codec import encode
from turtlewire.protocols.walter.messages import Forward, Right
from turtlewire.simulated import simulated
from turtlewire.turtle import HOME, Pose

ROSE = Path(__file__).parent.parent / "examples" / "rose.logo"
SIDES, SIDE_MM, TURN_DEG = 720, 0.7, 0.5
RUNS = 7

Figures = dict[str, float]


def closure() -> Figures:
    """The true robot against the exact turtle: at the end, and at worst on the way. In mm."""
    robot = simulated(target("sim:walter?baud=0")).robot
    exact, rounded_worst_mm = HOME, 0.0
    # Python rounds half a degree to none: the way never bends. Rounded up it would be a circle half as wide.
    naive = encode(Forward(round(SIDE_MM * 2))) + encode(Right(round(TURN_DEG)))
    for _ in range(SIDES):
        exact = exact.moved(SIDE_MM).turned(TURN_DEG)
        robot.write(naive)
        robot.read(robot.now + 1.0)
        rounded_worst_mm = max(rounded_worst_mm, _apart(robot.pose, exact))
    rounded_end_mm = _apart(robot.pose, exact)
    driver_worst_mm = 0.0
    with connect("sim:walter?baud=0") as turtle:
        turtle.set_step_by_step(True)
        for _ in range(SIDES):
            turtle.forward(SIDE_MM)
            turtle.right(TURN_DEG)
            # A simulated robot without slip is where it says, to half a unit.
            driver_worst_mm = max(driver_worst_mm, _apart(turtle.reported_pose(), turtle.pose))
        turtle.finish()
        driver_end_mm = _apart(turtle.reported_pose(), HOME)
    return {
        "driver_end_mm": driver_end_mm,
        "driver_worst_mm": driver_worst_mm,
        "rounded_end_mm": rounded_end_mm,
        "rounded_worst_mm": rounded_worst_mm,
    }


def _apart(pose: Pose, other: Pose) -> float:
    return pose.distance_to(other.x_mm, other.y_mm)


def pace() -> Figures:
    """A simulated drawing: commands per second on the wall, and how many times as fast as the robot."""
    runs: list[Figures] = []
    for _ in range(RUNS):
        started = time.perf_counter()
        with connect("sim:walter") as turtle:
            Interpreter(turtle, write=lambda _: None, random=random.Random(0)).run(ROSE.read_text("utf-8"))
            turtle.finish()
            took_s, figures = time.perf_counter() - started, turtle.statistics
        runs.append(
            {
                "commands": float(figures.commands),
                "commands_per_s": figures.commands / took_s,
                "times_real_time": figures.seconds / took_s,
            }
        )
    return {name: statistics.median(run[name] for run in runs) for name in runs[0]}


def start_to_picture() -> Figures:
    """``turtlewire run`` with an SVG and a PNG against an interpreter that does nothing, in turn. In s."""
    with tempfile.TemporaryDirectory() as folder:
        pictures = [word for kind in ("svg", "png") for word in ("--picture", str(Path(folder, f"x.{kind}")))]
        run = [sys.executable, "-m", "turtlewire.cli.main", "run", str(ROSE), *pictures]
        console_script = Path(sys.executable).with_name("turtlewire")
        if console_script.exists():
            run[:3] = [str(console_script)]
        nothing_s, run_s = [], []
        for _ in range(RUNS):
            nothing_s.append(_seconds([sys.executable, "-c", "pass"]))
            run_s.append(_seconds(run))
    nothing, picture = statistics.median(nothing_s), statistics.median(run_s)
    return {"python_s": nothing, "picture_s": picture, "times_python": picture / nothing}


def _seconds(command: list[str]) -> float:
    started = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    return time.perf_counter() - started


def slowest_imports(number: int = 5) -> Figures:
    """Where the start goes: the packages whose import takes longest by itself, in ms."""
    program = "import turtlewire, turtlewire.logo, turtlewire.picture, turtlewire.simulator.walter"
    told = subprocess.run(
        [sys.executable, "-X", "importtime", "-c", program],
        check=True,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
    ).stderr
    took: Figures = {}
    for self_us, module in re.findall(r"import time:\s+(\d+) \|\s+\d+ \|\s+(\S+)", told):
        package = ".".join(module.split(".")[:2]) if module.startswith("turtlewire") else module.split(".")[0]
        took[package] = took.get(package, 0.0) + int(self_us) / 1000.0
    return dict(sorted(took.items(), key=lambda item: -item[1])[:number])


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="what a drawing costs")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    as_json: bool = parser.parse_args().json
    result = {
        "closure": closure(),
        "pace": pace(),
        "start_to_picture": start_to_picture(),
        "imports_ms": slowest_imports(),
    }
    if as_json:
        print(json.dumps(result))
        return
    error, speed, start = result["closure"], result["pace"], result["start_to_picture"]
    print(f"REPEAT {SIDES} [FD {SIDE_MM} RT {TURN_DEG}]         at its end   at worst on the way")
    print(f"  turtlewire              {error['driver_end_mm']:10.2f} mm {error['driver_worst_mm']:12.2f} mm")
    print(
        f"  each command rounded    {error['rounded_end_mm']:10.2f} mm {error['rounded_worst_mm']:12.2f} mm"
    )
    print(f"{ROSE.name}, simulated")
    print(
        f"  {speed['commands_per_s']:.0f} commands/s, {speed['times_real_time']:.0f} times as fast as the robot"
    )
    print(f"turtlewire run {ROSE.name}, with an SVG and a PNG")
    print(f"  {start['picture_s'] * 1000:.0f} ms: {start['times_python']:.1f} times `python -c pass`")
    print("  slowest imports: " + ", ".join(f"{n} {ms:.0f} ms" for n, ms in result["imports_ms"].items()))


if __name__ == "__main__":
    main()
