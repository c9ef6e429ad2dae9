"""The robots' firmware: building the sketches of the Arduino library, and flashing them to a board."""

from turtlewire.firmware.boards import BOARDS, Board
from turtlewire.firmware.build import Built, build
from turtlewire.firmware.flash import flash
from turtlewire.firmware.sketches import SKETCHES, Sketch, find_sketch, library

__all__ = [
    "BOARDS",
    "SKETCHES",
    "Board",
    "Built",
    "Sketch",
    "build",
    "find_sketch",
    "flash",
    "library",
]
