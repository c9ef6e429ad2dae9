"""The ground that a robot draws on, as far as its driver has to do with it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Sequence

    from turtlewire.trace import Obstacle, Trace


class Paper(Protocol):
    """What is drawn, and on what."""

    @property
    def trace(self) -> Trace:
        """What is drawn there now."""

    @property
    def obstacles(self) -> Sequence[Obstacle]:
        """What stands there."""

    def clear_trace(self) -> None:
        """Put a new sheet there."""
