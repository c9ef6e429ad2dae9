"""What each part of the dashboard says. Text alone tells everything; colour only helps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.text import Text

from turtlewire.dashboard import chart
from turtlewire.dashboard.controls import FULL_SPEED, STEPS
from turtlewire.helm.wishes import Action

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from turtlewire.dashboard.canvas import Cell
    from turtlewire.dashboard.controls import Controls
    from turtlewire.dashboard.layouts import Layout
    from turtlewire.helm.view import Level, Notice, View
    from turtlewire.helm.wire import Line
    from turtlewire.helm.wishes import Wish

STYLES = {
    chart.PEN_UP: "dim",
    chart.OBSTACLE: "yellow",
    chart.PEN_DOWN: "cyan",
    chart.SCALE: "dim",
    chart.ROBOT: "bold green",
}
LEVELS: dict[Level, str] = {"note": "", "warning": "bold yellow", "error": "bold red"}
LINKS = {
    "connected": "● connected",
    "reconnecting": "○ LINK LOST",
    "stopped": "◐ stopped: R goes on",
    "closed": "✕ NO LINK",
}
BANNERS = {
    "reconnecting": "LINK LOST, trying again ...   The robot may still be moving: keep clear of it.",
    "stopped": "The link is back, and the robot is stopped: press R to go on.",
    "closed": "The link has ended. If the robot still moves, switch it off. Q quits.",
}
CERTAINTIES = {"seen": "", "told": "as it says", "reckoned": "by reckoning"}
# Figures of the connection that tell of something gone wrong, and what to call them.
LOSSES = {
    "retries": "retries",
    "resynchronisations": "resyncs",
    "fences_lost": "answers lost",
    "corrections": "corrections",
    "malformed_replies": "replies damaged",
    "unexpected_replies": "replies too many",
    "frames_ignored": "frames damaged",
    "frames_lost": "frames lost",
    "reconnections": "link losses",
}
ENTRIES = {Action.ASK_MOVE_SPEED: "speed", Action.ASK_TURN_SPEED: "speed of turns"}
# For so long a notice stands out.
NEW_S = 8.0
GAUGE = ("▮", "▯")


def head(title: str, view: View, width: int) -> Text:
    """The first line: which robot, and whether it can be reached."""
    state = LINKS.get(view.link, view.link)
    room = max(0, width - len(state) - 3)
    name = f" {title}"[:room].ljust(room)
    style = "bold" if view.link == "connected" else "bold blink"
    return Text.assemble((name, "bold"), (f" {state}  "[: width - len(name)], style))


def side(view: View, controls: Controls, wish: Wish, *, latched: bool) -> Text:
    """The robot, and the link to it."""
    text = Text(no_wrap=True, overflow="ellipsis")
    _row(text, "keys", _wished(wish, latched=latched), "bold")
    pose = view.pose
    for name, value in (
        ("x", f"{_zero(pose.x_mm):8.1f} mm"),
        ("y", f"{_zero(pose.y_mm):8.1f} mm"),
        ("heading", f"{_zero(pose.heading_deg) % 360.0:8.1f} deg"),
        ("speed", f"{_zero(view.speed_mm_per_s):8.0f} mm/s"),
        ("turning", f"{_zero(view.turn_deg_per_s):8.0f} deg/s"),
    ):
        _row(text, name, value)
    certainty = CERTAINTIES[view.certainty]
    text.append(f"{certainty}\n" if certainty else "", "dim")
    if controls.layout.has_two_speeds:
        _row(text, "set", f"{controls.speed}, of turns {controls.turn_speed}")
    else:
        _row(text, "set", _gauge(controls.speed))
    for name, value in _equipment(view):
        _row(text, name, value)
    for name, value in _figures(view):
        _row(text, name, value)
    return text


def _row(text: Text, name: str, value: str, style: str = "") -> None:
    if value:
        text.append(f"{name:9}", "dim")
        text.append(f"{value}\n", style)


def _zero(value: float) -> float:
    """Without a negative zero."""
    return 0.0 if abs(value) < 0.05 else value


def _wished(wish: Wish, *, latched: bool) -> str:
    words = []
    if wish.speed:
        words.append("▲ ahead" if wish.speed > 0.0 else "▼ back")
    if wish.turn:
        words.append("◀ left" if wish.turn < 0.0 else "▶ right")
    if wish.horn:
        words.append("♪")
    return " ".join([*words, *(["(latched)"] if latched and words else [])]) or "■ stop"


def _gauge(speed: int) -> str:
    full = round(speed * STEPS / FULL_SPEED)
    return f"{GAUGE[0] * full}{GAUGE[1] * (STEPS - full)} {speed}"


def _equipment(view: View) -> Iterator[tuple[str, str]]:
    if view.pen_down is not None:
        yield "pen", "down" if view.pen_down else "up"
    if view.lamp is not None:
        yield "lights", "on" if view.lamp else "off"


def _figures(view: View) -> Iterator[tuple[str, str]]:
    """The figures of the connection: two of bytes, and how long answers take, then what is wrong."""
    figures = view.figures
    if "bytes_sent" in figures:
        yield "sent", f"{figures['bytes_sent']} bytes"
        yield "received", f"{figures['bytes_received']} bytes"
    median_s, longest_s = figures.get("round_trip_median_s"), figures.get("round_trip_max_s")
    if median_s is not None and longest_s is not None:
        yield "answers", f"{median_s * 1000:.0f} ms, at most {longest_s * 1000:.0f}"
    is_walter, is_car = "fences" in figures, "window_commands" in figures
    for key, name in LOSSES.items():
        count = figures.get(key, 0)
        if key == "resynchronisations":
            # WALTER is attended to whenever it is asked; a car is brought in step once at the beginning.
            count = 0 if is_walter else count - 1 if is_car else count
        elif key == "corrections" and not is_walter:
            continue  # by odometry, all the time
        if count > 0:
            yield "noted", f"{count} {name}"


def ground(rows: list[list[Cell]]) -> Text:
    """The chart, in colours."""
    text = Text(no_wrap=True, overflow="crop")
    for number, row in enumerate(rows):
        if number:
            text.append("\n")
        for cell in row:
            text.append(cell.character, STYLES.get(cell.layer, ""))
    return text


def wire(lines: Sequence[Line], height: int) -> Text:
    """The last messages of both sides, the newest at the bottom."""
    text = Text(no_wrap=True, overflow="ellipsis")
    for line in lines[-height:] if height > 0 else ():
        arrow, style = ("→", "cyan") if line.sender == "host" else ("←", "green")
        times = f" x{line.times}" if line.times > 1 else ""
        if text:
            text.append("\n")
        text.append(f"{line.time_s:9.3f} ", "dim")
        text.append(f"{arrow} {line.text}{times}", "red" if line.text.startswith("error") else style)
    return text


def notices(given: Sequence[Notice], controls: Controls, now: float) -> Text:
    """What people should know, the newest first; or what they are typing."""
    text = Text(overflow="ellipsis")
    if controls.entry is not None:
        text.append(f"{ENTRIES[controls.entry.action]}, 1 to 255: {controls.entry.digits}", "bold")
        text.append("_  ", "blink")
        text.append("Enter sets it, Escape does not", "dim")
        return text
    for number, notice in enumerate(reversed(given)):
        if number:
            text.append("\n")
        mark = {"note": "", "warning": "! ", "error": "!! "}[notice.level]
        is_new = not number and now - notice.time_s < NEW_S
        text.append(f"{mark}{notice.text}", LEVELS[notice.level] if is_new else "dim")
    return text


def keys(layout: Layout, features: frozenset[str], width: int, *, latched: bool) -> Text:
    """The keys of this robot, in lines of so many columns."""
    text, column = Text(), 0
    for each in layout.help:
        if each.feature and each.feature not in features:
            continue
        what = each.what
        if what == "drive":
            what = "drive until Space" if latched else "hold to drive"
        size = len(f"{each.keys} {what}")
        if column and column + size > width:
            text.append("\n")
            column = 0
        text.append(each.keys, "bold reverse")
        text.append(f" {what}  ")
        column += size + 2
    text.rstrip()
    return text
