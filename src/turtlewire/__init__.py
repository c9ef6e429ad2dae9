"""turtlewire: drive, program and trust any small serial robot."""

from turtlewire.connect import connect, connect_async
from turtlewire.errors import TurtlewireError
from turtlewire.turtle import Pose, Turtle

__all__ = ["Pose", "Turtle", "TurtlewireError", "connect", "connect_async"]
