"""The firmware's core does what the Python ends of the robots do: on every vector, and on any bytes.

Compiled with all warnings as errors, and run under the address and undefined behaviour sanitizers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from turtlewire.protocols.frame.codec import INTER_BYTE_S, frame_bytes
from turtlewire.protocols.frame.dialect import TO_ROBOT, shipped
from turtlewire.protocols.walter.codec import Mode, encode

from .core import SANITIZERS, Core, arrive, build, run
from .expected import (
    GROUP_BITS,
    IDS,
    INTER_BYTE_MS,
    Expected,
    cut,
    frame,
    simple,
    to_robot,
    vectors,
    walter,
)
from .fixed_inputs import fixed

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from turtlewire.protocols.frame.dialect import Dialect

FEW = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(tmp_path_factory.mktemp("core"), "-g", "-O1", *SANITIZERS)


@pytest.fixture(scope="module")
def core(program: Path) -> Iterator[Core]:
    with Core(program) as core:
        yield core


def test_the_fixed_inputs(program: Path) -> None:
    for expected in fixed().values():
        expected.compare(run(program, expected.commands))


# ------------------------------------------------------------------------------------------------------ simple


@pytest.mark.parametrize("vector", to_robot("simple"), ids=lambda vector: vector["id"])
def test_the_vectors_of_simple(core: Core, vector: dict[str, Any]) -> None:
    data, extended = bytes.fromhex(vector["bytes"]), vector.get("extensions", False)
    _, (events, state) = core.do([f"simple {'V' * extended}", arrive(data)])
    answers = [event for event in events if event.startswith("answer")]
    assert answers == [f"answer {chr(reply)}" for reply in bytes.fromhex(vector["replies"])]
    assert state["pending"] == str(vector["pending"])
    expected = Expected()
    for number in range(len(data) + 1):
        simple(expected, [data[:number], data[number:]], extended)
    expected.check(core)


LETTERS = st.sampled_from(b"FBLRSHVKfb\x00\xff")
DIGITS = st.sampled_from(b"0125679/:;A \x00\xff")
COMMANDS = st.builds(
    lambda letter, rest: bytes([letter, *rest]), LETTERS, st.lists(DIGITS, min_size=6, max_size=6)
)
SIMPLE_BYTES = st.lists(COMMANDS | st.binary(max_size=9), max_size=12).map(b"".join)


@given(SIMPLE_BYTES, st.lists(st.integers(0, 200), max_size=4), st.booleans())
@FEW
def test_any_bytes_of_simple(core: Core, data: bytes, cuts: list[int], extended: bool) -> None:
    expected = Expected()
    simple(expected, cut(data, cuts), extended)
    expected.check(core)


# ------------------------------------------------------------------------------------------------------ walter


@pytest.mark.parametrize("vector", to_robot("walter"), ids=lambda vector: vector["id"])
def test_the_vectors_of_walter(core: Core, vector: dict[str, Any]) -> None:
    data, mode = bytes.fromhex(vector["bytes"]), Mode(vector["mode"])
    groups = frozenset(vector.get("groups", "CQHE"))
    mask = sum(GROUP_BITS[group] for group in groups)
    _, (_, state) = core.do([f"walter {mode.value} {mask}", arrive(data)])
    assert (state["mode"], state["pending"]) == (vector["mode_after"], str(vector["pending"]))
    items = vector["items"]
    assert int(state["malformed"]) == sum("error" in item for item in items)
    assert int(state["heard"]) == sum("message" in item for item in items)
    expected = Expected()
    for number in range(len(data) + 1):
        walter(expected, [data[:number], data[number:]], mode, groups, [20, 20])
    expected.check(core)


WALTER_BYTES = st.lists(
    st.sampled_from([encode(t(*(0 for _ in t.FIELDS))) for t in IDS])
    | st.sampled_from(
        [b"2\r", b"\r", b"\r\n", b"1", b"F\x0d\x0a\x0d", b"q", b"x" * 70, b"fd", b"CL\x01\x02\x03\x04\r"]
    )
    | st.lists(st.sampled_from(b"2FBVLRPUDHECXYQT01LHSAZGf\r\n\x00 ,.\xff"), max_size=8).map(bytes)
    | st.binary(max_size=4),
    max_size=30,
).map(b"".join)


@given(
    WALTER_BYTES,
    st.lists(st.integers(0, 400), max_size=6),
    st.sampled_from(Mode),
    st.sets(st.sampled_from("CQHE")),
    st.lists(st.integers(0, 5), max_size=6),
)
@FEW
def test_any_bytes_of_walter(
    core: Core, data: bytes, cuts: list[int], mode: Mode, groups: set[str], takes: list[int]
) -> None:
    expected = Expected()
    walter(expected, cut(data, cuts), mode, frozenset(groups), takes)
    expected.check(core)


# ------------------------------------------------------------------------------------------------------- frame


def test_a_frames_robot_has_the_same_patience() -> None:
    assert INTER_BYTE_S * 1000 == INTER_BYTE_MS


@pytest.mark.parametrize(
    "vector",
    [v for v in to_robot("frame") if "crc" not in v and "counts" not in v],
    ids=lambda vector: vector["id"],
)
def test_the_vectors_of_frame(core: Core, vector: dict[str, Any]) -> None:
    data = bytes.fromhex(vector["bytes"])
    _, (_, state) = core.do([f"frame {vector['dialect']}", arrive(data)])
    assert int(state["frames"]) == sum("messages" in item for item in vector["items"])
    assert state["pending"] == str(vector["pending"])
    expected = Expected()
    for number in range(len(data) + 1):
        frame(expected, vector["dialect"], [(0, data[:number]), (0, data[number:])])
    expected.check(core)


@pytest.mark.parametrize(
    "session",
    [v for v in vectors("frame", "sessions") if "counts" in v and "receive" in v["steps"][0]],
    ids=lambda session: session["id"],
)
def test_the_timed_sessions_of_frame(core: Core, session: dict[str, Any]) -> None:
    steps = [(step["at_ms"], bytes.fromhex(step["receive"])) for step in session["steps"]]
    expected = Expected()
    frame(expected, session["dialect"], steps)
    expected.check(core)


def frames(dialect: Dialect) -> st.SearchStrategy[bytes]:
    """Frames with right CRCs, of messages and of nonsense."""
    types = st.sampled_from([*(entry.type for entry in dialect.entries), 0x02, 0x77, 0xA3])
    nonsense = st.builds(lambda number, rest: bytes([number]) + rest, types, st.binary(max_size=12))
    sizes = {entry.type: entry.layout.size for entry in dialect.entries if entry.goes(TO_ROBOT)}
    right = st.sampled_from(sorted(sizes)).flatmap(
        lambda number: st.binary(min_size=sizes[number] - 1, max_size=sizes[number] - 1).map(
            lambda fields: bytes([number]) + fields
        )
    )
    payloads = st.lists(right, max_size=12) | st.lists(nonsense, max_size=4)
    seq = st.integers(0, 255) | st.sampled_from([0, 1, 2, 3])
    return st.builds(lambda number, parts: frame_bytes(dialect, number, b"".join(parts)[:124]), seq, payloads)


@pytest.mark.parametrize("name", ["0.1", "0.1-literal", "telemetry"])
@given(data=st.data())
@FEW
def test_any_bytes_of_frame(core: Core, name: str, data: st.DataObject) -> None:
    whole = frames(shipped(name))
    odd = [b"", b"\xa3", b"\xa3" * 130, b"\xa3\x00\x7c", b"\xa3\x00\x7d", b"\xa3\x00\xff", bytes(128)]
    cut_off = st.builds(lambda some, less: some[: len(some) - less], whole, st.integers(1, 8))
    piece = whole | cut_off | st.binary(max_size=6) | st.sampled_from(odd)
    waits = st.sampled_from([0, 0, 0, 1, 99, 100, 101, 5000])
    at_ms, steps = 2**32 - 300, []  # the clock of a robot wraps
    for wait_ms, some in data.draw(st.lists(st.tuples(waits, piece), max_size=12)):
        at_ms += wait_ms
        steps.append((at_ms, some))
    expected = Expected()
    frame(expected, name, steps)
    expected.check(core)
