"""S7, proven by exhaustion, with the real host against the real robot on a simulated line.

Every command (1,041 of them), every number of its bytes already received, every single byte lost, added or changed, in
command or reply: 4,796,928 faults. A robot treats all bytes alike that are neither digits nor letters of commands
(that is proven first), and faults that leave it with the same bytes and the same replies go on the same: so each
different one is run once, and counted as often as it stands for. The counts are the table in docs/protocols/simple.md.
"""

from __future__ import annotations

from collections import Counter
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tests.unit.protocols.simple.wire import Wire, clean, connected
from turtlewire.protocols.simple.codec import decode, encode, layouts
from turtlewire.protocols.simple.events import Done, InStep, OutOfStep
from turtlewire.protocols.simple.host import Host
from turtlewire.protocols.simple.messages import (
    EMERGENCY_STOP,
    DriveBackward,
    DriveForward,
    Headlights,
    SimpleCommand,
    SteerLeft,
    SteerRight,
    Stop,
)
from turtlewire.protocols.simple.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Iterator

PAGE = Path(__file__).parents[4] / "docs" / "protocols" / "simple.md"

VALUED = (DriveForward, DriveBackward, SteerLeft, SteerRight)
COMMANDS: list[SimpleCommand] = [
    *(command_type(value) for command_type in VALUED for value in range(256)),
    Stop(),
    *(Headlights(*bits) for bits in product((0, 1), repeat=4)),
]
TABLE = layouts()
# Every byte that means something to a robot somewhere, and one for all the others, with how many bytes it stands for.
TELLING = b"0123456789FBLRSH"
OTHER = ord("x")
WEIGHTS = dict.fromkeys(TELLING, 1) | {OTHER: 256 - len(TELLING)}


def test_there_are_so_many_commands() -> None:
    assert len(COMMANDS) == 4 * 256 + 1 + 16 == 1041
    assert len({encode(command) for command in COMMANDS}) == 1041


def test_bytes_that_mean_nothing_are_all_alike() -> None:
    others = [byte for byte in range(256) if byte not in TELLING]
    assert len(others) == WEIGHTS[OTHER] == 240
    for letter in (*b"FBLRSH", OTHER):
        for position in range(7):
            raw = bytearray(bytes([letter]) + b"100000")
            results = set()
            for byte in others:
                raw[position] = byte
                result = decode(bytes(raw), TABLE)
                results.add("invalid" if isinstance(result, str) else str(result))
            assert len(results) == 1


# ------------------------------------------------------------------------------------- a robot left in the middle


def test_from_every_beginning_of_every_command() -> None:
    """A host that went away left the robot with 0 to 6 bytes; the next one connects."""
    cases = completed = 0
    for command in COMMANDS:
        raw = encode(command)
        for received in range(7):
            robot = Robot()
            robot.drive, robot.steer = 200, -100
            assert robot.receive_data(raw[:received]).replies == b""
            wire = Wire(Host(boot_s=0), robot)
            wire.host.connect(0.0)
            wire.run()
            assert [type(event) for event in wire.events] == [InStep]
            # Only what had all of its digits is completed, and stopped again.
            needed = 1 + sum(3 if field.kind == "u8" else 1 for field in command.FIELDS)
            complete = received >= needed
            stops = [Stop(), Stop()] if received == 0 else [Stop()]
            assert wire.executed == ([command] if complete else []) + stops
            assert wire.host.spent == (7 - received) + 7 <= 14
            cases += 1
            completed += complete
    assert cases == 1041 * 7
    # Four digits of F, B, L, R with 4, 5 or 6 bytes; S with 1 to 6; H with 5 or 6.
    assert completed == 4 * 256 * 3 + 6 + 16 * 2


def test_fourteen_stops_at_once_end_every_beginning() -> None:
    for command in COMMANDS:
        raw = encode(command)
        for received in range(7):
            robot = Robot()
            robot.drive, robot.steer = -255, 255
            robot.receive_data(raw[:received])
            actions = robot.receive_data(EMERGENCY_STOP).actions
            assert (robot.drive, robot.steer) == (0, 0)
            assert set(actions) <= {command, Stop()}
            assert actions[-1] == Stop()


# ------------------------------------------------------------------------------------- one fault in one exchange


class Fault(NamedTuple):
    """What became of a command on its way, or of its reply, and for how many faults it stands."""

    kind: str
    wire: bytes
    reply: bytes | None  # None: whatever the robot says
    weight: int


def command_faults(raw: bytes) -> Iterator[Fault]:
    for at in range(7):
        yield Fault("lost", raw[:at] + raw[at + 1 :], None, 1)
        for byte, weight in WEIGHTS.items():
            if byte != raw[at]:
                yield Fault("changed", raw[:at] + bytes([byte]) + raw[at + 1 :], None, weight)
    for at in range(8):
        for byte, weight in WEIGHTS.items():
            yield Fault("added", raw[:at] + bytes([byte]) + raw[at:], None, weight)


def reply_faults(raw: bytes) -> Iterator[Fault]:
    yield Fault("reply lost", raw, b"", 1)
    yield Fault("reply changed", raw, b"F", 1)
    yield Fault("reply changed", raw, b"x", 254)
    for byte, weight in ((b"K", 1), (b"F", 1), (b"x", 254)):
        yield Fault("reply added", raw, byte + b"K", weight)
        yield Fault("reply added", raw, b"K" + byte, weight)


def faults(raw: bytes) -> Iterator[Fault]:
    yield from command_faults(raw)
    yield from reply_faults(raw)


# What is sent after a fault that was not noticed at once.
FOLLOWING: list[SimpleCommand] = [SteerLeft(77), DriveBackward(9)]


class Case(NamedTuple):
    """What came of a fault: when it was noticed, and what the robot carried out because of it."""

    noticed: str
    made: str


def made_of(command: SimpleCommand, fault: Fault) -> SimpleCommand | None:
    """The command that a fault, and the S bytes that fill up what it left, make of another; None: none."""
    made = decode((fault.wire + b"SSSSSS")[:7], TABLE)
    return None if isinstance(made, str) or made == command else made


def run_case(wire: Wire, command: SimpleCommand, fault: Fault) -> Case:
    """One exchange with a fault in it, and what follows; begins and ends in step and stopped."""
    host, robot = wire.host, wire.robot
    assert host.idle
    assert robot.pending == b""
    wire.executed, wire.events, wire.sent = [], [], []
    pending = [fault.wire]
    wire.to_robot = lambda data: pending.pop() if pending else data
    if fault.reply is not None:
        said = [fault.reply]
        wire.to_host = lambda data: said.pop() if said else data
    host.submit(command)
    wire.run()
    wire.to_robot = wire.to_host = clean
    submitted = [command]
    noticed = "at once" if noticed_by(wire) else "never"
    if noticed == "never" and robot.pending:
        for after, when in zip(FOLLOWING, ("1 later", "2 later"), strict=True):
            submitted.append(after)
            host.submit(after)
            wire.run()
            if noticed_by(wire):
                noticed = when
                break
    # Nobody is out of step without knowing.
    assert robot.pending == b""
    # The robot carried out what was sent, stops, and what the fault made of the command: nothing else.
    made = made_of(command, fault)
    assert set(wire.executed) <= {*submitted, Stop()} | ({made} if made else set())
    assert made is None or made in wire.executed
    if noticed == "never":
        assert wire.executed == [made or command]
    else:
        # S7: stopped before anything is sent again (the wire sees to that at InStep), in at most 14 bytes,
        assert [type(event) for event in wire.events].count(InStep) == 1
        assert host.spent <= 14
        # and then what is still wanted is sent again: both ends agree.
        assert {event.command for event in wire.events if isinstance(event, Done)} == set(submitted)
        known = (host.state.drive, host.state.steer, host.state.lights)
        lights = tuple(map(int, robot.lights)) if isinstance(command, Headlights) else None
        assert known == (robot.drive, robot.steer, lights)
    # Back to where the next case begins.
    host.submit(Stop())
    wire.run(until=wire.now + 2.0)
    return Case(noticed, "nothing" if made is None else "a stop" if made == Stop() else "another command")


def noticed_by(wire: Wire) -> bool:
    return any(isinstance(event, OutOfStep) for event in wire.events)


def survey() -> Counter[tuple[str, ...]]:
    """How many faults of each kind were noticed when, and what they made the robot do."""
    counts: Counter[tuple[str, ...]] = Counter()
    for command in COMMANDS:
        wire = connected()  # a host that knows nothing yet
        seen: dict[tuple[object, ...], Case] = {}
        for fault in faults(encode(command)):
            robot = Robot()
            reaction = robot.receive_data(fault.wire)
            key = (reaction.replies, tuple(reaction.actions), robot.pending, fault.reply)
            if key not in seen:
                seen[key] = run_case(wire, command, fault)
            counts[fault.kind, *seen[key]] += fault.weight
    return counts


# Those that are never noticed, counted by hand. Drive and steer: a letter becomes another of the four (3 * 1024), H
# (1024) or S (1024); of a value's digits, 424 changes of the first, 2060 of the second and 2280 of the third leave
# 0..255. Headlights: a letter becomes F, B, L, R (16 * 4) or S (16); 8 * 9 + 8 * 1 changes of each of four digits
# switch it. Stop: another letter makes one of five commands of its zeros.
CHANGED_TO_A_STOP = 1024 + 16
CHANGED_TO_ANOTHER = 4 * 1024 + 4 * (424 + 2060 + 2280) + 16 * 4 + 4 * 80 + 5
EXPECTED = {
    ("lost", "at once", "nothing"): 1041 * 7 - 2209,
    ("lost", "at once", "another command"): 2209,
    ("added", "at once", "nothing"): 1_045_071,
    ("added", "1 later", "nothing"): 1_062_906,
    ("added", "1 later", "a stop"): 1040,  # an S in front
    ("added", "1 later", "another command"): 21_910,
    ("added", "2 later", "nothing"): 1041,  # an S behind: it makes a stop of the next command
    ("changed", "at once", "nothing"): 1_040_298,
    ("changed", "never", "nothing"): 793_306,
    ("changed", "never", "a stop"): CHANGED_TO_A_STOP,
    ("changed", "never", "another command"): CHANGED_TO_ANOTHER,
    ("reply lost", "at once", "nothing"): 1041,
    ("reply added", "at once", "nothing"): 1041 * 4,  # K or F, in front or behind
    ("reply added", "never", "nothing"): 1041 * 2 * 254,  # what is no reply is ignored and counted
    ("reply changed", "at once", "nothing"): 1041 * 255,
}
NOTICED = {
    "at once": "at once",
    "1 later": "at the next command",
    "2 later": "at the next but one",
    "never": "never",
}


def table(counts: Counter[tuple[str, ...]]) -> list[str]:
    rows = ["| fault | noticed | makes the robot carry out | cases |", "| --- | --- | --- | --- |"]
    order = ["lost", "added", "changed", "reply lost", "reply added", "reply changed"]
    for kind in order:
        for noticed, words in NOTICED.items():
            for made in ("nothing", "a stop", "another command"):
                count = counts[kind, noticed, made]
                if count:
                    rows.append(f"| {kind} | {words} | {made} | {count:,} |")
    return rows


def test_every_single_fault_in_every_command_and_reply() -> None:
    counts = survey()
    totals: Counter[str] = Counter()
    for (kind, *_), count in counts.items():
        totals[kind] += count
    assert totals == {
        "lost": 1041 * 7,
        "changed": 1041 * 7 * 255,
        "added": 1041 * 8 * 256,
        "reply lost": 1041,
        "reply changed": 1041 * 255,
        "reply added": 1041 * 2 * 256,
    }
    assert sum(totals.values()) == 1041 * 4608 == 4_796_928
    assert counts == EXPECTED
    page = PAGE.read_text("utf-8").splitlines()
    for row in table(counts):
        assert row in page
