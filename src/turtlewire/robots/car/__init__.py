"""The driver of a car: ``AsyncCar``, and ``Car`` for those who do not write asynchronous programs."""

from turtlewire.robots.car.driver import AsyncCar
from turtlewire.robots.car.settings import Settings, Statistics
from turtlewire.robots.car.synchronous import Car

__all__ = ["AsyncCar", "Car", "Settings", "Statistics"]
