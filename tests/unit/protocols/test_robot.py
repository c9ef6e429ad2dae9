from __future__ import annotations

import pytest

from turtlewire.protocols.walter.codec import Mode, encode
from turtlewire.protocols.walter.messages import (
    DIRECT_KEYS,
    LOGO_COMMANDS,
    MAX_UNFENCED_BYTES,
    QUEUE_COMMANDS,
    DirectKey,
    EmptyLine,
    Forward,
    LogoCommand,
    PenUp,
    QueryHeading,
    SelectDirect,
    SelectLogo,
)
from turtlewire.protocols.walter.robot import Robot

QUEUED = [command for command in LOGO_COMMANDS if command not in (SelectDirect, EmptyLine)]


def test_a_new_robot_is_in_logo_control_and_has_nothing_to_do() -> None:
    robot = Robot()
    assert (robot.mode, robot.queued, robot.next_command()) == (Mode.LOGO, 0, None)
    assert (robot.heard, robot.malformed, robot.overflowed) == (0, 0, 0)


@pytest.mark.parametrize("command", QUEUED, ids=lambda command: command.name())
def test_every_logo_command_waits_for_its_turn(command: type[LogoCommand]) -> None:
    assert command.QUEUED
    message = command(*(0 for _ in command.FIELDS))
    robot = Robot()
    assert robot.receive_data(encode(message)) == []
    assert (robot.queued, robot.heard) == (1, 1)
    assert robot.next_command() == message
    assert (robot.queued, robot.next_command()) == (0, None)


@pytest.mark.parametrize("key", DIRECT_KEYS, ids=lambda key: key.name())
def test_every_key_acts_at_once(key: type[DirectKey]) -> None:
    message = key(*(7 for _ in key.FIELDS))
    robot = Robot(Mode.DIRECT)
    assert robot.receive_data(encode(message)) == [message]
    assert (robot.queued, robot.heard) == (0, 1)
    assert robot.mode is (Mode.LOGO if key is SelectLogo else Mode.DIRECT)


def test_commands_come_out_in_order_and_more_can_follow() -> None:
    robot = Robot()
    robot.receive_data(encode(Forward(1)) + encode(Forward(2)))
    assert robot.next_command() == Forward(1)
    robot.receive_data(encode(QueryHeading()))
    assert [robot.next_command() for _ in range(3)] == [Forward(2), QueryHeading(), None]


def test_select_direct_abandons_what_came_before_and_not_what_comes_after() -> None:
    robot = Robot()
    data = encode(Forward(1)) + encode(SelectDirect()) + encode(SelectLogo()) + encode(Forward(2))
    assert robot.receive_data(data) == [SelectDirect(), SelectLogo()]
    assert [robot.next_command(), robot.next_command()] == [Forward(2), None]


def test_the_unfenced_bytes_always_fit_the_queue() -> None:
    shortest = min((encode(c(*(0 for _ in c.FIELDS))) for c in QUEUED), key=len)
    assert len(shortest) * QUEUE_COMMANDS == MAX_UNFENCED_BYTES == 48
    robot = Robot()
    robot.receive_data(shortest * QUEUE_COMMANDS)
    assert (robot.queued, robot.overflowed) == (16, 0)


def test_beyond_the_queue_the_newest_is_dropped_and_counted() -> None:
    robot = Robot()
    for n in range(QUEUE_COMMANDS + 2):
        robot.receive_data(encode(Forward(n)))
    assert (robot.queued, robot.overflowed, robot.heard) == (16, 2, 18)
    assert robot.next_command() == Forward(0)
    robot.receive_data(encode(PenUp()))
    assert (robot.queued, robot.overflowed) == (16, 2)
    assert [robot.next_command() for _ in range(16)] == [*(Forward(n) for n in range(1, 16)), PenUp()]


def test_empty_lines_are_heard_and_never_queued() -> None:
    robot = Robot()
    for _ in range(QUEUE_COMMANDS + 1):
        assert robot.receive_data(b"\r\n") == []
    assert (robot.queued, robot.heard, robot.overflowed, robot.malformed) == (0, 17, 0, 0)


def test_ill_formed_lines_are_counted_and_not_heard() -> None:
    robot = Robot()
    assert robot.receive_data(b"?\rF\x00\xc8\xc8\r") == []
    assert (robot.malformed, robot.heard, robot.queued) == (2, 0, 0)


@pytest.mark.parametrize(
    ("sensor", "event"), [("front", b"LF\r"), ("back", b"LB\r"), ("left", b"LL\r"), ("right", b"LR\r")]
)
@pytest.mark.parametrize("mode", Mode)
def test_a_limit_abandons_the_queue_and_is_told_in_both_modes(mode: Mode, sensor: str, event: bytes) -> None:
    robot = Robot(mode)
    if mode is Mode.LOGO:
        robot.receive_data(encode(Forward(1)) * 3)
    assert robot.limit_tripped(sensor) == event
    assert (robot.queued, robot.next_command(), robot.mode) == (0, None, mode)


def test_a_robot_without_groups_does_not_know_them() -> None:
    robot = Robot(groups=frozenset("H"))
    robot.receive_data(b"QH\rHH\rCR\rE1\r")
    assert (robot.queued, robot.malformed) == (1, 3)
