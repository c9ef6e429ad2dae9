"""What the simulator's tests share."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from turtlewire.simulator.walter import SimulatedWalter

Run = Callable[..., bytes]


@pytest.fixture
def run() -> Run:
    """Send bytes now, let some of the robot's time pass, and return all that came back."""

    def run_for(robot: SimulatedWalter, data: bytes = b"", seconds: float = 1000.0) -> bytes:
        end = robot.now + seconds
        robot.write(data)
        replies = b""
        while robot.now < end:
            replies += robot.read(end)
        return replies

    return run_for
