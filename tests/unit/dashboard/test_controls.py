"""Keys, and what is wished and ordered by them."""

from __future__ import annotations

from typing import Any

import pytest

from turtlewire.dashboard.controls import Controls
from turtlewire.dashboard.layouts import WALTER, WASD, layout
from turtlewire.helm.wishes import Action, Order, Wish


def controls(protocol: str = "frame", *, latched: bool = False, speed: int = 100) -> Controls:
    return Controls(
        layout(protocol),
        speed=speed,
        has_full_lock=protocol == "simple",
        first_s=0.7,
        hold_s=0.25,
        latched=latched,
    )


def wished(one: Controls, now: float) -> tuple[Any, ...]:
    return tuple(one.wish(now)[:3])


@pytest.mark.parametrize(
    ("protocol", "keys", "wish"),
    [
        ("frame", ["w"], (0.4, 0.0)),
        ("frame", ["down"], (-0.4, 0.0)),
        ("frame", ["a"], (0.0, -0.4)),
        ("frame", ["w", "d"], (0.4, 0.2)),  # an arc
        ("simple", ["w"], (0.4, 0.0)),
        ("simple", ["w", "a"], (0.4, -1.0)),  # front wheels: to the lock
        ("simple", ["right"], (0.0, 1.0)),
        ("walter", ["a"], (0.4, 0.0)),
        ("walter", ["z"], (-0.4, 0.0)),
        ("walter", ["a", ","], (0.0, -0.4)),  # one at a time
        ("walter", ["."], (0.0, 0.4)),
        ("walter", ["up", "right"], (0.0, 0.4)),
        ("walter", ["w"], (0.0, 0.0)),
        ("frame", ["z"], (0.0, 0.0)),
    ],
)
def test_keys_that_drive(protocol: str, keys: list[str], wish: tuple[float, float]) -> None:
    one = controls(protocol, speed=102)
    for n, key in enumerate(keys):
        assert one.press(key, n / 10.0) is None
    assert wished(one, len(keys) / 10.0) == (*wish, False)
    assert one.wish(9.0) == Wish(number=one.wish(0.0).number)
    assert not one.wish(9.0).moves


def test_a_wish_ends_and_tells_when() -> None:
    one = controls()
    one.press("w", 1.0)
    assert one.wish(1.0).until == pytest.approx(1.7)
    one.press("h", 1.1)
    assert one.wish(1.2).until == pytest.approx(1.7)
    assert wished(one, 1.2)[2]
    assert wished(one, 1.75) == (0.0, 0.0, True)
    assert one.wish(1.75).until == pytest.approx(1.8)
    assert wished(one, 1.85) == (0.0, 0.0, False)


def test_the_horn_is_never_latched() -> None:
    one = controls(latched=True)
    one.press("w", 0.0)
    one.press("h", 0.0)
    assert one.wish(0.5).horn
    assert not one.wish(1.0).horn
    assert one.wish(1.0).moves


@pytest.mark.parametrize("key", ["space", "escape", "q"])
def test_stopping(key: str) -> None:
    for protocol in ("walter", "simple"):
        one = controls(protocol, latched=True)
        one.press("up", 0.0)
        one.press("h", 0.0)
        order = one.press(key, 0.1)
        assert order == Order(Action.QUIT if key == "q" else Action.STOP)
        assert wished(one, 0.1) == (0.0, 0.0, False)


def test_speeds_in_nine_steps() -> None:
    one = controls(speed=100)
    speeds = []
    for key in ["+", "=", "-", "-", "-", "9", "+", "1", "-", "5"]:
        one.press(key, 0.0)
        speeds.append(one.speed)
        assert one.turn_speed == one.speed
    assert speeds == [113, 142, 113, 85, 57, 255, 255, 28, 28, 142]
    one.press("w", 0.0)
    one.press("9", 0.1)
    assert wished(one, 0.1) == (1.0, 0.0, False)


def test_walter_has_two_speeds_with_keys_of_their_own() -> None:
    one = controls("walter", speed=254)
    assert one.press("d", 0.0) == Order(Action.MOVE_FASTER, 255)
    assert one.press("d", 0.0) is None  # it cannot be more
    assert one.press("v", 0.0) == Order(Action.TURN_SLOWER, 253)
    assert one.press("c", 0.0) == Order(Action.MOVE_SLOWER, 254)
    assert one.press("f", 0.0) == Order(Action.TURN_FASTER, 254)
    one.turn_speed = one.speed = 1
    assert one.press("c", 0.0) is None
    assert one.press("v", 0.0) is None
    one.speed = 51
    one.press("a", 1.0)
    assert wished(one, 1.0) == (0.2, 0.0, False)
    one.press(".", 1.0)
    assert wished(one, 1.0) == (0.0, 1 / 255, False)
    assert one.press("s", 2.0) == Order(Action.RAISE_PEN)
    assert one.press("x", 2.0) == Order(Action.LOWER_PEN)


def test_walter_s_speeds_are_typed() -> None:
    one = controls("walter")
    one.press("a", 0.0)
    assert one.press("g", 0.1) == Order(Action.STOP)
    assert not one.wish(0.1).moves
    for key in ["2", "9", "0", "a"]:  # 290 is too much; the letter ends it, and drives
        one.press(key, 1.0)
    assert one.entry is None
    assert one.speed == 100
    assert one.wish(1.0).moves
    for key in ["g", "1", "2", "backspace", "7", "enter", "b", "2", "5", "5", "enter"]:
        one.press(key, 3.0)
    assert (one.speed, one.turn_speed) == (17, 255)
    for keys in (["g", "enter"], ["g", "0", "enter"], ["g", "5", "escape"], ["b", "5", "space"]):
        for key in keys[:-1]:
            one.press(key, 4.0)
        order = one.press(keys[-1], 4.0)
        assert one.entry is None
        assert (one.speed, one.turn_speed) == (17, 255)
        assert order == (None if keys[-1] == "enter" else Order(Action.STOP))
    one.press("g", 5.0)
    one.let_go(5.0)
    assert one.entry is None


def test_what_is_done_once_is_done_once_while_its_key_is_held() -> None:
    one = controls()
    assert one.press("l", 0.0) == Order(Action.LAMP)
    now = 0.5
    for _ in range(30):
        assert one.press("l", now) is None
        now += 0.033
    assert one.press("l", now + 1.0) == Order(Action.LAMP)
    assert one.press("p", now) == Order(Action.PEN)
    assert one.press("r", now) == Order(Action.RESUME)
    one.sees_releases = True  # there, repetitions are told apart
    assert one.press("l", now + 1.1) == Order(Action.LAMP)
    assert one.repeat("l", now + 1.2) is None


def test_repetitions_that_are_told_apart() -> None:
    one = controls("walter")
    one.sees_releases = True
    assert one.press("d", 0.0) == Order(Action.MOVE_FASTER, 101)
    assert one.repeat("d", 0.5) == Order(Action.MOVE_FASTER, 102)
    one.press("a", 1.0)
    one.press("h", 1.0)
    one.repeat("a", 1.6)
    one.repeat("h", 1.6)
    assert one.wish(1.8)[:3] == (102 / 255, 0.0, True)
    one.answered(1.8)
    assert one.wish(2.0)[:3] == (102 / 255, 0.0, True)
    one.release("h", 2.0)
    assert one.wish(2.0)[:3] == (102 / 255, 0.0, False)
    one.release("a", 2.0)
    assert not one.wish(2.0).moves
    one.press("g", 3.0)
    assert one.repeat("d", 3.1) is None  # not while something is typed


def test_every_key_is_explained_and_none_has_two_meanings() -> None:
    for keys in (WALTER, WASD):
        assert not set(keys.moves) & (set(keys.actions) | set("123456789h"))
        told = " ".join(each.keys for each in keys.help).lower()
        for key in (*keys.moves, *keys.actions):
            if len(key) == 1 and key not in "=r":  # R is told when it is needed
                assert key in told, key
