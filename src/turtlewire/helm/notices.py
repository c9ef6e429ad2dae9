"""What people are told: the newest of it."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from turtlewire.errors import LimitReachedError, LinkLostError
from turtlewire.helm.view import Level, Notice
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.errors import TurtlewireError

MAX_NOTICES = 30


class Notices:
    """The last ``MAX_NOTICES``, numbered.

    Attributes:
        elapsed_s: tells how long ago the link was opened, seconds; set when it is.
    """

    def __init__(self) -> None:
        self.elapsed_s: Callable[[], float] = lambda: 0.0
        self._kept: deque[Notice] = deque(maxlen=MAX_NOTICES)
        self._told = 0

    def newest(self) -> tuple[Notice, ...]:
        """Those that are kept, the oldest first."""
        return tuple(self._kept)

    def tell(
        self, text: str, level: Level = "note", *, code: str = "", sensor: str = "", pose: Pose | None = None
    ) -> None:
        """Add one."""
        self._told += 1
        self._kept.append(Notice(self.elapsed_s(), level, text, self._told, code, sensor, pose))

    def warn(self, text: str) -> None:
        """Add a warning."""
        self.tell(text, "warning")

    def tell_of(self, error: TurtlewireError) -> None:
        """Add what an error says, unless that is seen anyway."""
        if isinstance(error, LimitReachedError):
            way = {"front": "back", "back": "ahead"}.get(error.sensor, "ahead or back, or turn")
            self.tell(
                f"{error.sensor} limit: something is in the way at x {error.x_mm:.0f}, y {error.y_mm:.0f} mm. "
                f"The robot stands; drive it {way}",
                "warning",
                code="limit",
                sensor=error.sensor,
                pose=Pose(error.x_mm, error.y_mm, error.heading_deg),
            )
        elif not isinstance(error, LinkLostError):
            self.tell(str(error), "error", code="robot")
