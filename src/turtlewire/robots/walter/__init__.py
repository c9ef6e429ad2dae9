"""The driver of a WALTER: ``AsyncWalter``, and ``Walter`` for those who do not write asynchronous programs."""

from turtlewire.robots.walter.driver import AsyncWalter
from turtlewire.robots.walter.settings import Settings, Statistics
from turtlewire.robots.walter.synchronous import Walter

__all__ = ["AsyncWalter", "Settings", "Statistics", "Walter"]
