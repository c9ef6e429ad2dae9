"""The driver of a robot with two engines: ``AsyncTwoEngine``, and ``TwoEngine`` for programs that are not async."""

from turtlewire.robots.two_engine.driver import AsyncTwoEngine
from turtlewire.robots.two_engine.settings import Settings, Statistics
from turtlewire.robots.two_engine.synchronous import TwoEngine

__all__ = ["AsyncTwoEngine", "Settings", "Statistics", "TwoEngine"]
