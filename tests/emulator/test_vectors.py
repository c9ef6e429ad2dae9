"""The vectors of walter and frame on the chip; those of simple stand with the other tests of SimpleCar.

Left to the core's own tests on a PC (tests/firmware), since no sketch is built so: vectors of robots that have some of
the groups of ``*`` commands, of other dialects than Serial Protocol 0.1, of other CRCs and other numbers of engines.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from .board import Board
from .test_differential import BOOTED_S, Machine, Piece, check_turtle, seen, wait_for
from .test_frame_robot import BUMPER, DIALECT

if TYPE_CHECKING:
    from collections.abc import Iterable

    from .conftest import Build

VECTORS = Path(__file__).parents[2] / "spec" / "vectors"
# When a vector's bytes have come, a robot goes on for so long, then gets a key that means nothing in Logo control.
LOOK_S = 0.02


def entries(protocol: str, what: str) -> list[dict[str, Any]]:
    paths = sorted((VECTORS / protocol).glob("*.json"))
    return [entry for path in paths for entry in json.loads(path.read_text("utf-8")).get(what, [])]


def of_walter(groups: set[str]) -> list[dict[str, Any]]:
    return [
        vector
        for vector in entries("walter", "vectors")
        if vector["direction"] == "to robot" and set(vector.get("groups", "CQHE")) == groups
    ]


def check_vector(built: Build, name: str, vector: dict[str, Any]) -> None:
    """The same is done, said, and after it understood as by the simulated robot, which the vectors are run on too."""
    begin = [Piece(b"2\r")] if vector["mode"] == "direct" else []
    check_turtle(built, name, [*begin, Piece(bytes.fromhex(vector["bytes"]), LOOK_S), Piece(b"A", LOOK_S)])


@pytest.mark.parametrize("vector", of_walter(set("CQHE")), ids=lambda vector: vector["id"])
def test_walter(built: Build, vector: dict[str, Any]) -> None:
    check_vector(built, "Walter", vector)


@pytest.mark.parametrize("vector", of_walter(set()), ids=lambda vector: vector["id"])
def test_walter_without_groups(built: Build, vector: dict[str, Any]) -> None:
    check_vector(built, "WalterBasic", vector)


def of_frame(what: str) -> list[dict[str, Any]]:
    return [
        entry
        for entry in entries("frame", what)
        if entry.get("direction", "to robot") == "to robot"
        and entry["dialect"] == "0.1"
        and not {"crc", "counts"} & set(entry) - ({"counts"} if what == "sessions" else set())
        and (what == "vectors" or "receive" in entry["steps"][0])
    ]


def check_frame(built: Build, steps: Iterable[tuple[float, bytes, list[str]]]) -> None:
    """Bytes at times, and the messages that they lead to."""
    machine = Machine()
    with Board(built("FrameRobot").elf, DIALECT.baud) as chip:
        chip.press(BUMPER, 1)
        chip.run(BOOTED_S)
        start_s = chip.now_s
        for at_s, data, texts in steps:
            chip.run(max(0.0, start_s + at_s - chip.now_s))
            chip.receive(data)
            chip.run(len(data) * 10 / DIALECT.baud)
            for text in texts:
                message = DIALECT.parse(text)
                machine.carry_out(type(message).__name__, *map(int, message.values()))
            wait_for(chip, machine)
        chip.run(0.003)
        assert seen(chip) == machine.state


@pytest.mark.parametrize("vector", of_frame("vectors"), ids=lambda vector: vector["id"])
def test_frame(built: Build, vector: dict[str, Any]) -> None:
    texts = [text for item in vector["items"] for text in item.get("messages", [])]
    check_frame(built, [(0.0, bytes.fromhex(vector["bytes"]), texts)])


@pytest.mark.parametrize("session", of_frame("sessions"), ids=lambda session: session["id"])
def test_frame_in_time(built: Build, session: dict[str, Any]) -> None:
    """F5: what was begun is given up after a pause, and not before."""
    check_frame(
        built,
        [
            (step["at_ms"] / 1000, bytes.fromhex(step["receive"]), step["carries_out"])
            for step in session["steps"]
        ],
    )


def test_how_many_there_are() -> None:
    """None has been left out by a mistake."""
    counts = [
        len(of_walter(set("CQHE"))),
        len(of_walter(set())),
        len(of_frame("vectors")),
        len(of_frame("sessions")),
    ]
    assert counts == [201, 7, 47, 7]
