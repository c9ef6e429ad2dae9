"""A progress bar on the terminal, and the program's output past it."""

from __future__ import annotations

import contextlib
import os
import sys
from typing import TYPE_CHECKING

from turtlewire.cli import output

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence
    from typing import Self

    from rich.console import RenderableType
    from rich.progress import Progress

    from turtlewire.connect import Robot


_LINE_TAKEN_BACK = "\r\x1b[2K"


def duration(seconds: float) -> str:
    """A time as people write it."""
    minutes, rest = divmod(seconds, 60.0)
    hours, minutes = divmod(minutes, 60.0)
    if hours:
        return f"{hours:.0f} h {minutes:.0f} min"
    return f"{minutes:.0f} min {rest:.1f} s" if minutes else f"{rest:.2f} s"


class Bar:
    """The bar; on no terminal it shows nothing, and ``write`` only writes.

    Args:
        robots: whose figures are shown: what they have driven and were told together, and the longest time.
        progress: how far the program is, 0 to 1; None: it has not begun. Asked from another thread.
        shown: whether there may be a bar at all.
    """

    def __init__(self, robots: Sequence[Robot], progress: Callable[[], float | None], *, shown: bool) -> None:
        self._robots = robots
        self._progress = progress
        self._is_done = False
        # What the program has written of its current line, where the bar has to stay below it.
        self._line = ""
        self._bar = self._make() if shown and sys.stderr.isatty() else None
        self._is_shared = self._bar is not None and sys.stdout.isatty() and _same_file(1, 2)

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._bar is None:
            return
        self._is_done = kind is None
        rest, self._line = self._line, ""
        # OSError: the terminal is gone.
        with contextlib.suppress(OSError):
            if rest:
                self._bar.console.out(rest, highlight=False)
            self._bar.stop()

    def write(self, text: str) -> None:
        """Output of the program. Raises ``OutputError``."""
        if self._bar is None or not self._is_shared:
            output.write(text)
            return
        whole, newline, self._line = (self._line + text).rpartition("\n")
        if newline:
            self._bar.console.out(whole, highlight=False)

    @contextlib.contextmanager
    def away(self, *, ends_line: bool) -> Iterator[None]:
        """While somebody types, the bar is gone, and what the program has written of its line stands there.

        Args:
            ends_line: what is typed ends this line; otherwise the program goes on in it.
        """
        if self._bar is None:
            yield
            return
        rest, self._line = self._line, ""
        self._bar.live.transient = True
        self._bar.stop()
        self._bar.live.transient = False
        if rest:
            output.write(rest)
        try:
            yield
        finally:
            if rest and not ends_line:
                output.write(_LINE_TAKEN_BACK)
                self._line = rest
            self._bar.start()

    def _make(self) -> Progress:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
        from rich.text import Text

        bar = self

        class WithLine(Progress):
            """The figures are looked up whenever it is drawn, ten times a second."""

            def get_renderables(self) -> Iterable[RenderableType]:
                if bar._line:
                    yield Text(bar._line)
                for task in self.task_ids:
                    self.update(task, completed=bar._share(), description=bar._figures())
                yield self.make_tasks_table(self.tasks)

        progress = WithLine(
            BarColumn(bar_width=24),
            TaskProgressColumn(),
            TextColumn("{task.description}", markup=False),
            console=Console(stderr=True, soft_wrap=True),
            redirect_stdout=False,
            redirect_stderr=False,
        )
        progress.add_task("", total=1.0)
        return progress

    def _share(self) -> float:
        return 1.0 if self._is_done else self._progress() or 0.0

    def _figures(self) -> str:
        figures = [robot.statistics for robot in self._robots]
        # What is driven by set-points has no commands to count.
        commands: list[int | None] = [getattr(each, "commands", None) for each in figures]
        counts = [count for count in commands if count is not None]
        counted = f"{sum(counts)} commands, " if counts else ""
        distance_mm = sum(each.distance_mm for each in figures)
        return f"{distance_mm / 1000:.2f} m, {counted}{duration(max(each.seconds for each in figures))}"


def _same_file(one: int, other: int) -> bool:
    try:
        return os.path.sameopenfile(one, other)
    except OSError:
        return False
