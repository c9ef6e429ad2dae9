"""The figures of a connection, for a bug report: round trip, window, retries, resynchronisations, what was skipped."""

from __future__ import annotations

import contextlib
from typing import Any

import pytest

from turtlewire.configuration import target
from turtlewire.connect import connect
from turtlewire.errors import RobotError
from turtlewire.links.memory import MemoryLink
from turtlewire.protocols.frame.dialect import shipped
from turtlewire.robots.runner import InlineRunner
from turtlewire.robots.two_engine import AsyncTwoEngine, Settings
from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot

BYTE_S = 10.0 / 9600.0


def figures(url: str, moves: int = 3) -> Any:
    robot: Any = connect(url, notify=lambda _: None)
    for _ in range(moves):
        with contextlib.suppress(RobotError):
            robot.forward(60)
            robot.right(90)
            robot.finish()
    found = robot.statistics
    robot.close(finish=False)
    return found


@pytest.mark.parametrize("option", ["", "?max_unfenced=32"])
def test_walter_on_a_clean_line(option: str) -> None:
    found = figures(f"sim:walter{option}")
    assert found.window_bytes == (32 if option else 48)
    assert (found.retries, found.skipped_bytes, found.resynchronisations) == (0, 0, 1)
    # A query is three bytes, its answer at least four, and the robot takes no time.
    assert 7 * BYTE_S <= found.round_trip_median_s <= 10 * BYTE_S
    # The first query stands behind an attention of 12 bytes.
    assert 12 * BYTE_S < found.round_trip_max_s < 25 * BYTE_S


def test_walter_on_a_noisy_line() -> None:
    found = figures("sim:walter?faults=lose:0.02,flip:0.01,add:0.02,seed:3", moves=20)
    assert found.retries > 0
    assert found.resynchronisations >= 1
    assert found.skipped_bytes >= found.malformed_replies > 0


def test_a_walter_that_answers_nothing_has_no_round_trip() -> None:
    found = figures("sim:walter?basic=1")
    assert (found.round_trip_median_s, found.round_trip_max_s) == (None, None)


@pytest.mark.parametrize("window", [1, 4])
def test_a_car_on_a_clean_line(window: int) -> None:
    found = figures(f"sim:simple?window={window}")
    assert found.window_commands == window
    assert (found.retries, found.skipped_bytes, found.resynchronisations) == (0, 0, 1)
    assert found.round_trip_median_s == pytest.approx(8 * BYTE_S, abs=1e-6)  # seven bytes, and one back
    assert found.round_trip_max_s < 16 * BYTE_S


def test_a_car_on_a_noisy_line() -> None:
    found = figures("sim:simple?faults=lose:0.02,flip:0.02,seed:5", moves=20)
    assert found.resynchronisations > 2
    assert found.retries > 0
    assert found.skipped_bytes == found.malformed_replies > 0


def test_a_two_engine_robot_that_reports() -> None:
    found = figures("sim:frame?dialect=telemetry")
    assert (found.resynchronisations, found.skipped_bytes) == (0, 0)
    noisy = figures("sim:frame?dialect=telemetry&faults=flip:0.005,seed:1", moves=8)
    assert noisy.resynchronisations > 0
    assert noisy.skipped_bytes > 0
    assert noisy.frames_ignored >= noisy.resynchronisations


def test_set_points_that_are_repeated_are_counted() -> None:
    robot = SimulatedFrameRobot(FrameRobotSettings(dialect=shipped("0.1")))
    runner, driver = InlineRunner(), AsyncTwoEngine(MemoryLink(robot), Settings(boot_s=0.0, repeat_s=0.25))
    runner.run(driver.connect())
    before = driver.statistics.repeats
    runner.run(driver.drive(1, 0))
    runner.run(driver._pause(2.05))
    assert driver.statistics.repeats - before == 8
    runner.run(driver.close(finish=False))


def test_all_have_names_in_common() -> None:
    common = {
        "bytes_sent",
        "bytes_received",
        "distance_mm",
        "resynchronisations",
        "skipped_bytes",
        "reconnections",
    }
    for protocol in ("walter", "simple", "frame"):
        assert target(f"sim:{protocol}").protocol == protocol
        assert common < set(figures(f"sim:{protocol}", moves=0)._fields)
