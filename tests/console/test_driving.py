"""Driving by hand: keys, the joystick under a mouse and a finger, buttons, a gamepad; and whatever ends it."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import pytest

from .conftest import wait_until

if TYPE_CHECKING:
    from collections.abc import Callable

    from .conftest import Console, Visitor

    Visit = Callable[..., Visitor]

STICK = ".tw-stick"
# What a gamepad tells, as the browser's own would: there is none at this computer.
GAMEPAD = """
window.pad = {id: "Test pad", index: 0, connected: true, axes: [0, 0, 0, 0],
  buttons: Array.from({length: 17}, () => ({pressed: false, value: 0}))};
Object.defineProperty(navigator, "getGamepads", {value: () => [window.pad.connected ? window.pad : null]});
window.plug = (type) => window.dispatchEvent(Object.assign(new Event(type), {gamepad: window.pad}));
"""


def _way(console: Console, robot: str, before: dict[str, Any]) -> tuple[float, float]:
    """How far ahead of where it was (mm), and how far it has turned clockwise (deg)."""
    pose = console.view(robot)["pose"]
    dx, dy = pose["x_mm"] - before["x_mm"], pose["y_mm"] - before["y_mm"]
    heading = math.radians(before["heading_deg"])
    turn = (pose["heading_deg"] - before["heading_deg"] + 180.0) % 360.0 - 180.0
    return dx * math.sin(heading) + dy * math.cos(heading), turn


def _gone(
    console: Console, robot: str, before: dict[str, Any], *, ahead: int = 0, turn: int = 0
) -> Callable[[], bool]:
    """Whether it has gone at least a little in this direction."""

    def has_gone() -> bool:
        way, turned = _way(console, robot, before)
        return (way * ahead > 3.0 if ahead else True) and (turned * turn > 3.0 if turn else True)

    return has_gone


def _says(visitor: Visitor) -> str:
    return visitor.see(".tw-hand-says").inner_text()


@pytest.mark.parametrize(
    ("layout", "keys"),
    [
        ("arrows", {"ArrowUp": (1, 0), "ArrowDown": (-1, 0), "ArrowLeft": (0, -1), "ArrowRight": (0, 1)}),
        ("wasd", {"w": (1, 0), "s": (-1, 0), "a": (0, -1), "d": (0, 1), "ArrowUp": (1, 0)}),
        ("walter", {"a": (1, 0), "z": (-1, 0), ",": (0, -1), ".": (0, 1), "ArrowDown": (-1, 0)}),
    ],
)
def test_a_key_drives_while_it_is_held(
    console: Console, visit: Visit, layout: str, keys: dict[str, tuple[int, int]]
) -> None:
    visitor = visit(settings={"layout": layout})
    for key, (ahead, turn) in keys.items():
        before = console.view("walter")["pose"]
        with visitor.driving(key, _gone(console, "walter", before, ahead=ahead, turn=turn)):
            visitor.see(".tw-wheel-says:text-is('You drive')").wait_for()
        console.wait_for_rest("walter")


def test_set_points_are_sent_while_something_is_held_and_no_longer(console: Console, visit: Visit) -> None:
    sent: list[dict[str, Any]] = []

    def listen(visitor: Visitor) -> None:
        visitor.page.on(
            "websocket",
            lambda socket: socket.on("framesent", lambda frame: sent.append(_message(frame))),
        )

    visitor = visit(before=listen)
    keyboard, grips = visitor.page.keyboard, []

    def drives() -> list[dict[str, Any]]:
        """Those of the newest grip."""
        said = [each for each in sent if each.get("type") == "drive"]
        return [each for each in said if each["grip"] == said[-1]["grip"]]

    for _ in range(2):
        visitor.drive(
            lambda: keyboard.down("ArrowUp"), lambda: keyboard.up("ArrowUp"), lambda: len(drives()) >= 8
        )
        with visitor.holding("ArrowRight"):  # more of the same grip
            visitor.let_timers_run()
        keyboard.up("ArrowUp")
        visitor.let_timers_run()
        grips.append(drives()[-1]["grip"])
        numbers = [each["number"] for each in drives()]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
        assert all(each["stamp"] > 0 and 0 <= each["age_ms"] < 5000 for each in drives())
        assert all(abs(each["speed"]) <= 0.5 and abs(each["turn"]) <= 0.5 for each in drives())
        said = [each for each in sent if each.get("type") in ("drive", "release")]
        assert [each["type"] for each in said[-2:]] == ["drive", "release"]
    assert grips[0] < grips[1]
    console.wait_for_rest("walter")


def _message(frame: str | bytes) -> dict[str, Any]:
    """A message of the stream; NiceGUI's own are nothing here."""
    try:
        message = json.loads(frame)
    except ValueError:
        return {}
    return message if isinstance(message, dict) else {}


def test_a_letter_of_another_layout_does_not_drive(console: Console, visit: Visit) -> None:
    visitor = visit(settings={"layout": "arrows"})
    with visitor.holding("w"):
        visitor.let_timers_run()
        assert console.state("walter")["wheel"]["driver"] is None


def test_keys_can_be_switched_off_but_for_the_stop(console: Console, visit: Visit) -> None:
    visitor = visit()
    visitor.see(".tw-keys select").last.select_option("none")
    visitor.button("Take the wheel").click()
    visitor.page.get_by_text("You drive").wait_for()
    with visitor.holding("ArrowUp"):
        visitor.page.keyboard.press("p")
        assert not console.moves("walter")
    visitor.page.keyboard.press("Escape")
    visitor.page.get_by_text("Nobody drives").wait_for()


def test_a_car_drives_and_steers_at_once(console: Console, visit: Visit) -> None:
    visitor = visit(robot="car")
    before = console.view("car")["pose"]
    keyboard = visitor.page.keyboard

    def press() -> None:
        keyboard.down("w")
        keyboard.down("d")

    def release() -> None:
        keyboard.up("w")
        keyboard.up("d")

    visitor.drive(press, release, _gone(console, "car", before, ahead=1, turn=1))
    release()
    console.wait_for_rest("car")


def test_letters_that_are_typed_do_not_drive(console: Console, visit: Visit) -> None:
    visitor = visit()
    visitor.button("Take the wheel").click()
    visitor.page.get_by_text("You drive").wait_for()
    visitor.button("Settings").click()
    field = visitor.page.get_by_label("Your name")
    field.press_sequentially("wasd w")
    assert field.input_value() == "wasd w"
    assert not console.moves("walter")
    assert console.state("walter")["wheel"]["driver"] is not None
    field.press("Escape")
    wait_until(
        lambda: console.state("walter")["wheel"]["driver"] is None, "Escape to stop, while typing, too"
    )


@pytest.mark.parametrize("by", ["Escape", " ", "button"])
def test_a_stop_ends_the_grip_until_a_new_press(console: Console, visit: Visit, by: str) -> None:
    visitor = visit()
    keyboard = visitor.page.keyboard
    visitor.drive(lambda: keyboard.down("w"), lambda: keyboard.up("w"), lambda: console.moves("walter"))
    if by == "button":
        visitor.press(".tw-stop")
    else:
        keyboard.press(by)
    console.wait_for_rest("walter")
    assert console.state("walter")["wheel"]["driver"] is None
    assert _says(visitor) == "Stopped. Let go, then hold again to drive."
    keyboard.down("w")  # it repeats, as a key that is held does
    visitor.let_timers_run()
    assert console.state("walter")["wheel"]["driver"] is None
    keyboard.up("w")
    with visitor.driving("w", lambda: console.moves("walter")):
        pass
    console.wait_for_rest("walter")


def test_the_stop_of_all_stops_the_others_too(console: Console, visit: Visit) -> None:
    driver, other = visit(robot="car"), visit(robot="walter")
    with driver.driving("w", lambda: console.moves("car")):
        other.press(".tw-stop")  # only walter
        wait_until(lambda: console.state("walter")["wheel"]["driver"] is None, "walter's wheel to be free")
        assert console.state("car")["wheel"]["driver"] is not None
        other.press(".tw-stop-all")
        console.wait_for_rest("car")
        driver.see(".tw-hand-says.ended").wait_for()
    with driver.holding("w"):
        driver.page.get_by_text("Somebody stopped the robot: take the wheel to drive.").wait_for()
        assert not console.moves("car")
    driver.button("Take the wheel").click()
    driver.page.get_by_text("You drive").wait_for()
    with driver.driving("w", lambda: console.moves("car")):
        pass
    console.wait_for_rest("car")


def test_the_joystick_under_a_mouse(console: Console, visit: Visit) -> None:
    visitor = visit()
    mouse = visitor.page.mouse
    before = console.view("walter")["pose"]
    x, y, radius = visitor.middle(STICK)

    def press() -> None:
        mouse.move(x, y)
        mouse.down()
        mouse.move(x, y - radius * 0.8, steps=4)

    visitor.drive(press, mouse.up, _gone(console, "walter", before, ahead=1))
    mouse.move(x, y)
    console.wait_for_rest("walter")  # in the middle, and held still
    mouse.up()
    visitor.see(".tw-stick:not(.held)").wait_for()


@pytest.mark.parametrize("end", ["touchEnd", "touchCancel"])
def test_the_joystick_under_a_finger(console: Console, visit: Visit, end: str) -> None:
    visitor = visit(phone=True)
    before = console.view("walter")["pose"]
    x, y, radius = visitor.middle(STICK)

    def press() -> None:
        visitor.touch("touchStart", (x, y))
        for part in (0.3, 0.6, 0.9):
            visitor.touch("touchMove", (x - radius * part, y))

    visitor.drive(press, lambda: visitor.touch(end), _gone(console, "walter", before, turn=-1))
    visitor.touch(end)
    console.wait_for_rest("walter")
    visitor.see(".tw-stick:not(.held)").wait_for()


def test_the_stop_under_another_finger_ends_the_joystick_too(console: Console, visit: Visit) -> None:
    visitor = visit(phone=True)
    x, y, radius = visitor.middle(STICK)
    stop_x, stop_y, _ = visitor.middle(".tw-stop")

    def press() -> None:
        visitor.touch("touchStart", (x, y))
        visitor.touch("touchMove", (x, y - radius * 0.8))

    visitor.drive(press, lambda: visitor.touch("touchEnd"), lambda: console.moves("walter"))
    visitor.touch("touchStart", (x, y - radius * 0.8), (stop_x, stop_y))
    console.wait_for_rest("walter")
    visitor.touch("touchMove", (x, y - radius * 0.5), (stop_x, stop_y))  # held still: it drives no more
    console.wait_for_rest("walter")
    assert console.state("walter")["wheel"]["driver"] is None
    visitor.touch("touchEnd")


def test_buttons_instead_of_the_joystick(console: Console, visit: Visit) -> None:
    visitor = visit(phone=True)
    visitor.see(".tw-keys select").first.select_option("pad")
    visitor.see(".tw-pad").scroll_into_view_if_needed()
    before = console.view("walter")["pose"]
    x, y, _ = visitor.middle(".tw-pad-button.right")
    visitor.drive(
        lambda: visitor.touch("touchStart", (x, y)),
        lambda: visitor.touch("touchEnd"),
        _gone(console, "walter", before, turn=1),
    )
    visitor.touch("touchEnd")
    console.wait_for_rest("walter")


@pytest.mark.parametrize("event", ["window.dispatchEvent(new Event('blur'))", "plug('gamepaddisconnected')"])
def test_what_takes_the_hand_away_stops_the_robot(console: Console, visit: Visit, event: str) -> None:
    visitor = visit(before=lambda visitor: visitor.page.add_init_script(GAMEPAD))
    page = visitor.page
    page.evaluate("plug('gamepadconnected')")
    page.get_by_text("Gamepad: Test pad").wait_for()
    before = console.view("walter")["pose"]
    page.evaluate("pad.axes[1] = -0.1")  # within the dead zone
    visitor.let_timers_run()
    assert console.state("walter")["wheel"]["driver"] is None
    _push(visitor, 1, -1, _gone(console, "walter", before, ahead=1))
    page.evaluate(event)
    console.wait_for_rest("walter")
    visitor.let_timers_run()  # the stick is still out: only leaving the middle anew begins
    assert not console.moves("walter")


def _push(visitor: Visitor, axis: int, value: int, until: Callable[[], bool]) -> None:
    def centre() -> None:
        visitor.page.evaluate(f"pad.axes[{axis}] = 0")
        visitor.let_timers_run()

    visitor.drive(lambda: visitor.page.evaluate(f"pad.axes[{axis}] = {value}"), centre, until)


def test_a_gamepad_drives_and_its_buttons_do(console: Console, visit: Visit) -> None:
    visitor = visit(before=lambda visitor: visitor.page.add_init_script(GAMEPAD))
    page = visitor.page
    page.evaluate("pad.axes[0] = 1; plug('gamepadconnected')")
    visitor.let_timers_run()  # it was out already when it was plugged in
    assert console.state("walter")["wheel"]["driver"] is None
    page.evaluate("pad.axes[0] = 0")
    visitor.let_timers_run()
    _push(visitor, 0, 1, _gone(console, "walter", console.view("walter")["pose"], turn=1))
    page.evaluate("pad.buttons[1].pressed = true")
    console.wait_for_rest("walter")
    page.get_by_text("Stopped. Let go, then hold again to drive.").wait_for()
    page.evaluate("pad.axes[0] = 0; pad.buttons[1].pressed = false")
    is_down = console.view("walter")["pen_down"]
    page.evaluate("pad.buttons[3].pressed = true")
    wait_until(lambda: console.view("walter")["pen_down"] is not is_down, "the pen to move")


def test_the_speed_has_a_limit(console: Console, visit: Visit) -> None:
    visitor = visit(robot="frame")
    slider = visitor.page.get_by_role("slider", name="Speed")

    def speed() -> float:
        """When it has become steady."""
        seen = [0.0]

        def is_steady() -> bool:
            seen.append(console.view("frame")["speed_mm_per_s"])
            return seen[-1] > 1.0 and max(seen[-8:]) - min(seen[-8:]) < 0.02 * seen[-1]

        with visitor.driving("ArrowUp", is_steady):
            pass
        console.wait_for_rest("frame")
        return seen[-1]

    slider.fill("100")
    slider.blur()
    fast = speed()
    visitor.page.keyboard.press("3")
    assert slider.input_value() == "33"
    assert 0.2 * fast < speed() < 0.5 * fast


def test_what_the_robot_has_besides_wheels(console: Console, visit: Visit) -> None:
    visitor = visit(phone=True)
    before = console.view("walter")
    visitor.press(".tw-equipment button:has-text('Pen')")
    wait_until(lambda: console.view("walter")["pen_down"] is not before["pen_down"], "the pen to move")
    pressed = "false" if before["pen_down"] else "true"
    visitor.see(f".tw-equipment button[aria-pressed={pressed}]:has-text('Pen')").wait_for()
    visitor.press(".tw-equipment button:has-text('Lamp')")
    wait_until(lambda: console.view("walter")["lamp"] is not before["lamp"], "the lamp to change")
    x, y, _ = visitor.middle(".tw-equipment button:has-text('Horn')")
    visitor.drive(
        lambda: visitor.touch("touchStart", (x, y)),
        lambda: visitor.touch("touchEnd"),
        lambda: console.view("walter")["horn"],
    )
    visitor.touch("touchEnd")
    wait_until(lambda: not console.view("walter")["horn"], "the horn to fall silent")
    assert visitor.see(".tw-chip:has-text('Lights')").count() == 1


def test_each_robot_shows_what_it_has(visit: Visit) -> None:
    visitor = visit(robot="car")
    assert visitor.see(".tw-equipment button").all_inner_texts() == ["Headlights", "Clean map"]
    assert visitor.see(".tw-slider").count() == 1  # its front wheels turn fully or not at all
    visitor.see(".tw-robot select").select_option("walter")
    wait_until(lambda: visitor.see(".tw-equipment button").count() == 4, "what walter has")
