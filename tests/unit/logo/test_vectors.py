"""Every program in tests/vectors/logo does what UCBLogo does, or differs for the reason that its case gives."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import pytest

from turtlewire.logo import Interpreter, LogoError, ScreenTurtle

VECTORS = Path(__file__).resolve().parents[2] / "vectors" / "logo"


def assert_is_placed(error: LogoError) -> None:
    assert error.position is not None
    assert error.position.marked() in str(error)


def cases() -> list[Any]:
    return [
        pytest.param(case, id=case["id"])
        for path in sorted(VECTORS.glob("*.json"))
        for case in json.loads(path.read_text(encoding="utf-8"))["cases"]
    ]


@pytest.mark.parametrize("compiles", [True, False], ids=["compiled", "evaluated"])
@pytest.mark.parametrize("case", cases())
def test_program(
    case: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, compiles: bool
) -> None:
    monkeypatch.chdir(tmp_path)  # for the files that programs write
    written: list[str] = []
    error = None
    interpreter = Interpreter(ScreenTurtle(), written.append, random.Random(0), compiles=compiles)
    try:
        interpreter.run(case["program"] + "\n", "case.logo")
    except LogoError as caught:
        assert_is_placed(caught)
        error = {"number": caught.number, "text": caught.text, "procedure": caught.procedure}
    expected = case["ours"] if "differs" in case else case
    assert ("".join(written), error) == (expected["output"], expected["error"])


@pytest.mark.parametrize("case", cases()[::5])
def test_program_that_is_started_again(
    case: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    seen: list[tuple[str, str]] = []
    for _ in range(2):
        written: list[str] = []
        logo = Interpreter(
            ScreenTurtle(), written.append, random.Random(0), compiled_at=str(tmp_path / "kept")
        )
        said = ""
        try:
            logo.run(case["program"] + "\n", "case.logo")
        except LogoError as error:
            said = str(error)
        seen.append(("".join(written), said))
        for file in tmp_path.iterdir():
            if file.is_file():
                file.unlink()  # what the program wrote
    assert seen[0] == seen[1]


def test_there_are_many_and_each_has_its_own_id() -> None:
    ids = [case.values[0]["id"] for case in cases()]
    assert len(ids) == len(set(ids)) > 1400
