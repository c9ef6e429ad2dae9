"""``turtlewire dialect``: checked, as a page, as a header; and every way to get it wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from turtlewire.cli.main import main
from turtlewire.protocols.frame.dialect import shipped
from turtlewire.protocols.frame.header import header
from turtlewire.protocols.frame.page import page

DOCS = Path(__file__).parents[3] / "docs" / "protocols" / "frame.md"
OWN = """
protocol = "frame"
dialect = "own"
title = "My own"
[[message]]
name = "Ping"
type = 7
direction = "both"
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("own.toml").write_text(OWN, "utf-8")


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = main(["dialect", *arguments])
    return code, *capsys.readouterr()


def test_check_says_what_there_is(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = said(capsys, "check", "0.1-literal", "--count", "engines=4")
    assert code == 0
    first, *rest = out.splitlines()
    assert first.endswith("(115200 baud, CRC-8/SMBUS from magic, 2 servos, 4 engines)")
    assert rest == [
        "  00  to robot    set_servo_position servo_id position_deg",
        "  01  to robot    engine_forward engine_id speed; stops",
        "  01  to robot    engine_backward engine_id speed",
        "  01  to robot    engine_direction_unknown engine_id speed",
    ]


def test_a_dialect_that_cannot_stop_is_told_of(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = said(capsys, "check", "own.toml")
    assert (code, out.splitlines()[1]) == (0, "  07  both        ping")
    assert "no message has a stop" in out


def test_the_page_of_the_documentation_is_what_check_says(capsys: pytest.CaptureFixture[str]) -> None:
    text = DOCS.read_text("utf-8")
    Path("lawn-mower.toml").write_text(text.partition("```toml\n")[2].partition("```")[0], "utf-8")
    shown = text.partition("$ turtlewire dialect check lawn-mower.toml\n")[2].partition("$ ")[0]
    assert said(capsys, "check", "lawn-mower.toml") == (0, shown, "")


def test_header_and_page_with_settings(capsys: pytest.CaptureFixture[str]) -> None:
    own = shipped("telemetry").configured(crc="ROHC", coverage="payload", counts={"servos": 3})
    settings = ("--crc", "ROHC", "--coverage", "payload", "--count", "servos=3")
    assert said(capsys, "header", "telemetry", *settings) == (0, header(own), "")
    code, out, _ = said(capsys, "page", "telemetry", *settings)
    assert (code, out.strip()) == (0, page(own).strip())


def test_into_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert said(capsys, "header", "own.toml", "--output", "own.h") == (0, "", "written own.h\n")
    assert "namespace frame_own" in Path("own.h").read_text("utf-8")


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["check", "none.toml"], 1, "none.toml: No such file"),
        (["header", "0.1", "--count", "engines"], 2, "--count engines: write NAME=NUMBER"),
        (["header", "0.1", "--count", "wheels=3"], 2, "0.1 counts no 'wheels'"),
        (["header", "0.1", "--crc", "CRC-9"], 2, "CRC-9"),
        (["header", "0.1", "--coverage", "all"], 2, "coverage must be"),
        (["header", "0.1", "--output", "no/such.h"], 1, "cannot write no/such.h: No such file"),
        (["check", "wrong.toml"], 1, "wrong.toml, line 5: "),
    ],
)
def test_what_is_wrong(
    capsys: pytest.CaptureFixture[str], arguments: list[str], code: int, message: str
) -> None:
    Path("wrong.toml").write_text(OWN.replace("[[message]]", "[[mesage]]"), "utf-8")
    found, out, err = said(capsys, *arguments)
    assert (found, out) == (code, "")
    assert message in err
    assert len(err.splitlines()) == 1
