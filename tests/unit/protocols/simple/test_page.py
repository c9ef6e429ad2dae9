"""docs/protocols/simple.md: its worked example is what both ends do; every decision is there."""

from __future__ import annotations

import re
from pathlib import Path

from turtlewire.protocols.simple.events import InStep
from turtlewire.protocols.simple.host import Host
from turtlewire.protocols.simple.messages import COMMANDS, SimpleCommand
from turtlewire.protocols.simple.robot import Robot

FOLDER = Path(__file__).parents[4] / "docs" / "protocols"


def test_the_worked_example_is_what_both_ends_do() -> None:
    text = (FOLDER / "simple.md").read_text("utf-8")
    rows = re.findall(r"^\| `([0-9A-F ]+)` \| (to|from) robot \| .* \|$", text, flags=re.MULTILINE)
    assert len(rows) == 16
    robot = Robot()
    assert robot.receive_data(b"F2").replies == b""
    host = Host()
    host.connect(0.0)
    wanted = [COMMANDS[0](255), COMMANDS[2](128), COMMANDS[5](0, 0, 1, 0), COMMANDS[4]()]
    now = 0.0
    expected_reply = b""
    events: list[object] = []
    for wire, direction in rows:
        data = bytes.fromhex(wire)
        if direction == "from":
            assert data == expected_reply
            now += 0.01
            events += host.receive_data(data, now)
            continue
        sent = host.data_to_send(now)
        while not sent:
            if host.in_step:
                host.submit(wanted.pop(0))
            else:
                now = max(now, host.next_timeout())
                events += host.timed_out(now)
            sent = host.data_to_send(now)
        assert sent == data
        expected_reply = robot.receive_data(data).replies
    assert wanted == []
    assert host.idle
    assert len([event for event in events if isinstance(event, InStep)]) == 1
    assert (robot.drive, robot.steer, robot.lights) == (0, 0, (False, False, True, False))


def test_the_text_form_of_the_example_is_named() -> None:
    text = (FOLDER / "simple.md").read_text("utf-8")
    commands: list[SimpleCommand] = [
        COMMANDS[0](255),
        COMMANDS[2](128),
        COMMANDS[5](0, 0, 1, 0),
        COMMANDS[4](),
    ]
    for command in commands:
        assert f"`{command}`" in text


def test_every_decision_is_there() -> None:
    text = (FOLDER / "decisions.md").read_text("utf-8")
    assert [int(number) for number in re.findall(r"^### S(\d+)\. ", text, flags=re.MULTILINE)] == list(
        range(1, 11)
    )
