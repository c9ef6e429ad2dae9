"""The dashboard: keys in, a picture out. What it wants of the robot, the helm carries out."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from typing import TYPE_CHECKING, ClassVar

from rich.text import Text
from textual.app import App
from textual.containers import Horizontal
from textual.widget import Widget

from turtlewire.dashboard import keyboard, panels
from turtlewire.dashboard.chart import Chart, Path
from turtlewire.helm.wishes import Action, Wish
from turtlewire.turtle import HOME

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from textual import events
    from textual.driver import Driver

    from turtlewire.dashboard.controls import Controls
    from turtlewire.dashboard.terminal import KeyEvent
    from turtlewire.helm.helm import Helm
    from turtlewire.helm.view import View
    from turtlewire.helm.wishes import Order

# How often keys are looked at whose time may be over, and how often a wish that goes on is sent again.
TICK_S, RENEW_S = 0.03, 0.1
# How often the picture is made anew.
SHOW_S = 0.1
# How often a terminal that tells releases is asked whether it is there, while something is held.
ASK_S = 0.1
# How long a stop may take to leave before the program is suspended.
PAUSE_S = 0.5
HOLD = "Hold a key to drive; the robot stops when you let go."
LATCHED = "What a key began goes on until Space, or until this terminal loses the keyboard."
# Smaller terminals do without the chart, or without the messages.
LEAST_COLUMNS, LEAST_ROWS = 56, 17


class Panel(Widget):
    """A part of the screen: what it says is made for its size, and shown when it has changed.

    Args:
        content: makes it, given columns and rows.
        name: of the part.
    """

    def __init__(self, content: Callable[[int, int], Text], name: str) -> None:
        super().__init__(id=name)
        self._content = content
        self._text = Text()

    def look(self) -> None:
        """Make it anew."""
        text = self._content(self.size.width, self.size.height)
        if text != self._text:
            self._text = text
            self.refresh(layout=self.styles.auto_dimensions)

    def render(self) -> Text:
        """What it says."""
        return self._text


class Dashboard(App[None], inherit_bindings=False):
    """Drives one robot.

    Args:
        helm: of the robot, connected.
        controls: what the keys mean.
        latched: what was begun goes on until it is stopped.
        driver_class: of the terminal; None: textual's own.

    Attributes:
        failure: a mistake of ours that ended it.
        has_hung_up: the terminal is gone.
    """

    ENABLE_COMMAND_PALETTE = False
    TITLE = "turtlewire drive"
    CSS: ClassVar[str] = """
    Screen { layout: vertical; overflow: hidden; }
    #head { height: 1; background: $primary-background; }
    #banner { height: 3; padding: 1 2; text-style: bold reverse; display: none; }
    #middle { height: 1fr; }
    #ground { width: 1fr; padding: 0 1; }
    #side { width: 30; padding: 0 1; border-left: solid $panel-lighten-2; }
    #ground, #side, #wire { text-wrap: nowrap; text-overflow: ellipsis; }
    #wire { height: 30%; min-height: 4; padding: 0 1; border-top: solid $panel-lighten-2; }
    #notices { height: auto; min-height: 2; max-height: 4; padding: 0 1; background: $panel; }
    #keys { height: 2; padding: 0 1; }
    """

    def __init__(
        self,
        helm: Helm,
        controls: Controls,
        *,
        latched: bool = False,
        driver_class: type[Driver] | None = None,
    ) -> None:
        super().__init__(driver_class=driver_class)
        self.failure: Exception | None = None
        self.has_hung_up = False
        self._helm = helm
        self._controls = controls
        self._latched = latched
        self._wish = Wish()
        self._wished_s = self._asked_s = 0.0
        self._path = Path()
        self._jumps = 0
        self._chart = Chart()
        self._serving: asyncio.AbstractEventLoop | None = None
        self._is_over = False

    # ------------------------------------------------------------------ the screen

    def compose(self) -> Iterable[Widget]:
        """The parts."""
        helm, controls = self._helm, self._controls
        yield Panel(lambda width, _: panels.head(helm.title, self._view, width), "head")
        yield Panel(lambda *_: Text(panels.BANNERS.get(self._view.link, "")), "banner")
        with Horizontal(id="middle"):
            yield Panel(self._ground, "ground")
            yield Panel(
                lambda *_: panels.side(self._view, controls, self._wish, latched=self._latched), "side"
            )
        yield Panel(lambda _, height: panels.wire(self._view.lines, height), "wire")
        yield Panel(lambda *_: panels.notices(self._view.notices, controls, self._view.time_s), "notices")
        yield Panel(lambda width, _: self._keys(width), "keys")

    @property
    def _view(self) -> View:
        return self._helm.view

    def _ground(self, width: int, height: int) -> Text:
        if width < 2 or height < 2:
            return Text()
        view = self._view
        return panels.ground(self._chart.draw(width, height, self._path, view.pose, self._helm.obstacles))

    def _keys(self, width: int) -> Text:
        return panels.keys(self._controls.layout, self._helm.features, width, latched=self._latched)

    def on_mount(self) -> None:
        """It begins."""
        self._serving = asyncio.get_running_loop()
        self._path.move(HOME, pen_down=self._view.pen_down is not False)
        self.set_interval(TICK_S, self._tick)
        self.set_interval(SHOW_S, self.show_all)
        self.call_after_refresh(self.show_all)
        self._helm.note(LATCHED if self._latched else HOLD)
        if self._is_over:
            self.exit()

    def on_resize(self, event: events.Resize) -> None:
        """Another size."""
        self.query_one("#ground").display = event.size.width >= LEAST_COLUMNS
        self.query_one("#wire").display = event.size.height >= LEAST_ROWS
        self.call_after_refresh(self.show_all)

    def show_all(self) -> None:
        """Make all of the picture anew that has changed."""
        view = self._view
        if view.jumped != self._jumps:
            self._jumps = view.jumped
            self._path.jump(view.pose)
        self._path.move(view.pose, pen_down=view.pen_down is not False)
        banner = self.query_one("#banner")
        banner.display = view.link in panels.BANNERS
        for panel in self.query(Panel):
            panel.look()

    # ------------------------------------------------------------------ keys

    def on_key(self, event: events.Key) -> None:
        """A key was pressed, or repeats."""
        character = event.character
        is_typed = character is not None and character.isprintable() and character != " "
        name = character.lower() if character is not None and is_typed else event.key
        if name == "ctrl+c" and os.name == "nt":  # elsewhere the terminal has seen to it
            signal.raise_signal(signal.SIGINT)
        self._take(self._controls.press(name, time.monotonic()))

    def on_key_event(self, event: KeyEvent) -> None:
        """The terminal tells more of its keys."""
        now, item = time.monotonic(), event.item
        order = None
        if isinstance(item, keyboard.Answered):
            self._controls.sees_releases = item.tells_events
            self._controls.answered(now)
        elif isinstance(item, keyboard.Released):
            self._controls.release(item.key, now)
        elif isinstance(item, keyboard.Repeated):
            order = self._controls.repeat(item.key, now)
        self._take(order)

    def _take(self, order: Order | None) -> None:
        """Do at once what has to be done at once."""
        if order is not None and order.action in (Action.STOP, Action.QUIT):
            self._helm.stop()
        self._tick()
        if order is None:
            return
        if order.action is Action.QUIT:
            self.exit()
        elif order.action is not Action.STOP:
            self._helm.do(order)

    def on_app_blur(self) -> None:
        """The keyboard belongs to somebody else now."""
        self._let_go()

    def _let_go(self) -> None:
        moved = self._controls.wish(time.monotonic()).moves
        self._controls.let_go(time.monotonic())
        if moved:
            self._helm.stop()
        self._tick()

    def _tick(self) -> None:
        """See what is wished now, and pass it on."""
        now = time.monotonic()
        wish = self._controls.wish(now)
        if wish.moves and wish.number == self._helm.refused:
            # Whatever ended it, only a new key begins anything.
            self._controls.let_go(now)
            wish = self._controls.wish(now)
        is_active = wish.moves or wish.horn
        if wish[:3] != self._wish[:3] or (is_active and now - self._wished_s >= RENEW_S):
            self._wished_s = now
            self._helm.steer(wish)
        self._wish = wish
        if is_active and self._controls.sees_releases and now - self._asked_s >= ASK_S:
            self._asked_s = now
            ask = getattr(self._driver, "ask", None)
            if ask is not None:
                ask()

    # ------------------------------------------------------------------ the ways out

    def interrupt(self) -> None:
        """End, from a signal's handler."""
        self._helm.stop()
        self._is_over = True
        if self._serving is not None:
            self._serving.call_soon_threadsafe(self.exit)

    def on_hung_up(self) -> None:
        """The terminal is gone, and no signal has told."""
        self._helm.stop()
        self.has_hung_up = True
        self.exit()

    def on_shown(self) -> None:
        """The terminal has missed some of what it was shown."""
        self.refresh(layout=True)

    def stop_before_pause(self) -> None:
        """The program is about to be suspended (SIGTSTP): nobody drives then."""
        self._controls.let_go(time.monotonic())
        self._helm.stop_and_wait(PAUSE_S)

    def _handle_exception(self, error: Exception) -> None:
        # A mistake of ours. textual would print pages; the command line says it in a paragraph.
        self._helm.stop()
        self.failure = self.failure or error
        self._return_code = 1
        self._close_messages_no_wait()
