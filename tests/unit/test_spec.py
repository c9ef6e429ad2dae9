"""The description in spec/protocols agrees with the source, and what is generated from it is current."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tools import generate
from tools.generators import walter
from turtlewire.protocols.walter import messages
from turtlewire.protocols.walter.messages import (
    DIRECT_KEYS,
    LOGO_COMMANDS,
    MESSAGES,
    REPLIES,
    ROBOT_MESSAGES,
    EmptyLine,
    LogoCommand,
)

if TYPE_CHECKING:
    import pytest

ROOT = Path(__file__).parents[2]
SPEC: dict[str, Any] = tomllib.loads((ROOT / "spec/protocols/walter.toml").read_text("utf-8"))


class Row(NamedTuple):
    """A row of the source's tables: letters, argument bytes, Logo words (less the third column's swap, W3)."""

    letters: str
    size: int
    logo: str = ""
    star: bool = False


# The source, read by hand. 25 rows to the robot in Logo control (the source's order),
TO_ROBOT = [
    Row("2", 0),
    Row("F", 2, "FD FORWARD"),
    Row("B", 2, "BK BACK"),
    Row("V", 1),
    Row("L", 2, "LT LEFT"),
    Row("R", 2, "RT RIGHT"),
    Row("PU", 0, "PU PENUP"),
    Row("PD", 0, "PD PENDOWN"),
    Row("H0", 0, "HORNOFF", star=True),
    Row("HL", 0, "HORNLO", star=True),
    Row("HH", 0, "HORNHI", star=True),
    Row("E1", 0, "EYESON", star=True),
    Row("E0", 0, "EYESOFF", star=True),
    Row("CR", 0, "", star=True),
    Row("C0", 0, "HOME", star=True),
    Row("CH", 2, "SETH SETHEADING", star=True),
    Row("CL", 4, "SETPOS", star=True),
    Row("CX", 2, "SETX", star=True),
    Row("CY", 2, "SETY", star=True),
    Row("QT", 4, "TOWARDS", star=True),
    Row("QH", 0, "HEADING", star=True),
    Row("QL", 0, "POS", star=True),
    Row("QX", 0, "XCOR", star=True),
    Row("QY", 0, "YCOR", star=True),
    Row("QP", 0, "PENDOWNP PENDOWN?", star=True),
]
# 10 from the robot,
FROM_ROBOT = [
    Row("LF", 0),
    Row("LB", 0),
    Row("LL", 0),
    Row("LR", 0),
    Row("QT", 2),
    Row("QH", 2),
    Row("QL", 4),
    Row("QX", 2),
    Row("QY", 2),
    Row("QP", 1),
]
# and 14 keys of direct control.
KEYS = [
    Row(" ", 0),
    Row("1", 0),
    Row("A", 0),
    Row("Z", 0),
    Row("D", 0),
    Row("C", 0),
    Row("F", 0),
    Row("V", 0),
    Row("S", 0),
    Row("X", 0),
    Row("G", 1),
    Row("B", 1),
    Row(",", 0),
    Row(".", 0),
]
# Ours, no row of the source: a lone RET (section 4).
EMPTY_LINE = Row("", 0)

SIZES = {"u8": 1, "bit": 1, "u16": 2, "i16": 2}


def rows(mode: str) -> list[Row]:
    return [
        Row(
            message["letters"],
            sum(SIZES[field["kind"]] for field in message.get("fields", [])),
            " ".join(message.get("logo", [])),
            "group" in message,
        )
        for message in SPEC["message"]
        if message["mode"] == mode
    ]


def test_every_row_of_the_source_is_there_and_nothing_else() -> None:
    assert (len(TO_ROBOT), len(FROM_ROBOT), len(KEYS)) == (25, 10, 14)
    assert rows("logo") == [*TO_ROBOT, EMPTY_LINE]
    assert rows("robot") == FROM_ROBOT
    assert rows("direct") == KEYS
    assert len(SPEC["message"]) == 25 + 1 + 10 + 14


def test_the_groups_are_the_first_letters() -> None:
    for message in SPEC["message"]:
        if "group" in message:
            assert message["group"] == message["letters"][0]
            assert message["group"] in "CQHE"


def test_what_acts_at_once_and_what_waits() -> None:
    at_once = [message["name"] for message in SPEC["message"] if "acts" in message]
    assert at_once == ["SelectDirect", "EmptyLine"]
    assert [c.__name__ for c in LOGO_COMMANDS if not c.QUEUED] == at_once


# What a field means, by hand: its kind and its greatest value in each message that has one (W5, W14).
FIELDS = {
    "Forward": ["distance_half_mm u16 65535"],
    "Back": ["distance_half_mm u16 65535"],
    "SetSpeed": ["speed u8 255"],
    "Left": ["angle_deg u16 65535"],
    "Right": ["angle_deg u16 65535"],
    "TurnTo": ["heading_deg u16 65535"],
    "GoTo": ["x_half_mm i16 32767", "y_half_mm i16 32767"],
    "GoToX": ["x_half_mm i16 32767"],
    "GoToY": ["y_half_mm i16 32767"],
    "QueryTowards": ["x_half_mm i16 32767", "y_half_mm i16 32767"],
    "SetMoveSpeed": ["speed u8 255"],
    "SetTurnSpeed": ["speed u8 255"],
    "TowardsReply": ["angle_deg u16 359"],
    "HeadingReply": ["heading_deg u16 359"],
    "LocationReply": ["x_half_mm i16 32767", "y_half_mm i16 32767"],
    "XReply": ["x_half_mm i16 32767"],
    "YReply": ["y_half_mm i16 32767"],
    "PenReply": ["down bit 1"],
}


def test_fields_of_every_message() -> None:
    found = {
        message.__name__: [f"{field.name} {field.kind} {field.high}" for field in message.FIELDS]
        for message in MESSAGES
        if message.FIELDS
    }
    assert found == FIELDS


def test_the_classes_say_what_the_description_says() -> None:
    modes = {"logo": LOGO_COMMANDS, "direct": DIRECT_KEYS, "robot": ROBOT_MESSAGES}
    for mode, types in modes.items():
        described = [message for message in SPEC["message"] if message["mode"] == mode]
        assert [t.__name__ for t in types] == [message["name"] for message in described]
        for message_type, message in zip(types, described, strict=True):
            assert message["letters"].encode() == message_type.LETTERS
            assert [f.name for f in message_type.FIELDS] == [f["name"] for f in message.get("fields", [])]
            if issubclass(message_type, LogoCommand):
                assert message.get("group", "") == message_type.GROUP


def test_every_query_has_the_reply_with_its_own_letters() -> None:
    queries = {command for command in LOGO_COMMANDS if command.LETTERS[:1] == b"Q"}
    assert set(REPLIES) == queries
    assert len(REPLIES) == len(set(REPLIES.values())) == 6
    for query, reply in REPLIES.items():
        assert query.LETTERS == reply.LETTERS
    assert {reply for reply in ROBOT_MESSAGES if reply.LETTERS[:1] == b"Q"} == set(REPLIES.values())


def test_no_letters_begin_another_message_of_the_same_direction() -> None:
    for types in (LOGO_COMMANDS, DIRECT_KEYS, ROBOT_MESSAGES):
        letters = [t.LETTERS for t in types if t is not EmptyLine]
        assert len(set(letters)) == len(letters)
        for one in letters:
            assert one == one.upper()
            assert not any(other != one and other.startswith(one) for other in letters)


def test_numbers_and_sequences() -> None:
    assert messages.BAUD == 9600
    assert (messages.MAX_UNFENCED_BYTES, messages.QUEUE_COMMANDS) == (48, 16)
    assert (messages.MM_PER_S_PER_UNIT, messages.DEG_PER_S_PER_UNIT) == (1.0, 1.0)
    assert 0 < messages.DEFAULT_SPEED <= 255
    assert messages.ATTENTION.hex(" ").upper() == SPEC["sequences"]["attention"]
    assert messages.EMERGENCY_STOP.hex(" ").upper() == SPEC["sequences"]["emergency_stop"]
    # W7 and W8: as many zeros as the longest command has arguments, and one more where RET must be.
    longest = max(SIZES[f["kind"]] * len(m["fields"]) for m in SPEC["message"] for f in m.get("fields", []))
    assert messages.ATTENTION.startswith(messages.EMERGENCY_STOP)
    assert bytes(longest + 1) + b"\r2\r " == messages.EMERGENCY_STOP


# ------------------------------------------------------------------------------------------------ tools/generate.py


def test_generated_files_are_current() -> None:
    files: dict[Path, str] = generate.files()
    assert {str(path.relative_to(ROOT)) for path in files} >= {
        "src/turtlewire/protocols/walter/messages.py",
        "docs/protocols/walter-messages.md",
    }
    for path, text in files.items():
        assert path.read_text("utf-8") == text, f"{path.name}: run `make generate`"


def test_the_generated_page_has_a_row_for_every_message() -> None:
    page: str = walter.page(SPEC)
    table = [line for line in page.splitlines() if line.startswith("| `")]
    assert len(table) == len(MESSAGES) == 50
    for message in MESSAGES:
        assert any(line.startswith(f"| `{message.__name__}` | ") for line in table)
    for line in table:
        assert line.count("|") == 6


def test_check_tells_what_is_not_current_and_writes_nothing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "docs" / "page.md"
    monkeypatch.setattr(generate, "ROOT", tmp_path)
    monkeypatch.setattr(generate, "files", lambda: {page: "new\n"})
    monkeypatch.setattr("sys.argv", ["generate.py", "--check"])
    assert generate.main() == 1
    assert not page.exists()
    assert "not current: docs/page.md" in capsys.readouterr().err

    monkeypatch.setattr("sys.argv", ["generate.py"])
    assert generate.main() == 0
    assert page.read_text("utf-8") == "new\n"
    assert capsys.readouterr().out == "written: docs/page.md\n"

    monkeypatch.setattr("sys.argv", ["generate.py", "--check"])
    assert generate.main() == 0
    assert capsys.readouterr() == ("", "")
