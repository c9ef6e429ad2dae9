"""``turtlewire logo`` without a terminal: scripts, pictures, --check and fmt."""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest

from turtlewire import picture
from turtlewire.cli.main import main
from turtlewire.logo.formatting import formatted

UNTIDY = "to  f :x\nfd :x*2   ; twice\nend\n\nf 3-2\n"


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    Path("square.logo").write_text("repeat 4 [fd first :commandline rt 90]\nshow :commandline\n", "utf-8")
    Path("wrong.logo").write_text("fd 10\nfdd 20\n", "utf-8")
    Path("unused.logo").write_text("to f :x\nend\n", "utf-8")
    Path("untidy.logo").write_text(UNTIDY, "utf-8")


def run(*arguments: str) -> int:
    try:
        return main(["logo", *arguments])
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else -1


def stdin(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))


# --- scripts


def test_a_script_has_its_arguments(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("square.logo", "50", "--picture", "a b", "-h") == 0
    assert capsys.readouterr().out == "[50 --picture a b -h]\n"
    assert not Path("a b").exists()


def test_the_standard_input(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    stdin(monkeypatch, "print 3 + 4\nprint :nothing\n")
    assert run() == 1
    said = capsys.readouterr()
    assert said.out == "7\n"
    assert "standard input, line 2, column 7: nothing has no value" in said.err
    stdin(monkeypatch, "show :commandline")
    assert run("-", "5") == 0
    assert capsys.readouterr().out == "[5]\n"


def test_a_script_by_itself(tmp_path: Path) -> None:
    script = tmp_path / "script"
    script.write_text("#!/usr/bin/env -S turtlewire logo --seed 1\nprint first :commandline\n", "utf-8")
    script.chmod(0o755)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [script, "Ada"], env={**os.environ, "PATH": path}, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "Ada\n", "")


def test_the_seed_decides(capsys: pytest.CaptureFixture[str]) -> None:
    Path("chance.logo").write_text("print random 1000000", "utf-8")
    outputs = []
    for seed in (["--seed", "1"], ["--seed", "1"], ["--seed", "2"], [], []):
        assert run(*seed, "chance.logo") == 0
        outputs.append(capsys.readouterr().out)
    assert outputs[0] == outputs[1]
    assert len(set(outputs)) == 4


def test_a_script_that_fails_leaves_its_picture(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--picture", "drawn.svg", "wrong.logo") == 1
    assert "wrong.logo, line 2, column 1: I don't know how to fdd" in capsys.readouterr().err
    assert 'id="ink"' in Path("drawn.svg").read_text("utf-8")


def test_pictures_large_and_moving() -> None:
    options = ["--picture", "a.svg", "--picture", "a.png", "--picture", "still.svg"]
    assert run(*options, "--animate", "--step-mm", "2", "square.logo", "50") == 0
    text = Path("a.svg").read_text("utf-8")
    assert "prefers-reduced-motion: no-preference" in text
    assert "<script" not in text
    assert Path("a.png").read_bytes().startswith(b"\x89PNG")
    assert "<title>2 cm</title>" in text  # the scale: a side has 100 mm


def test_what_moves_is_all_within_the_media_query() -> None:
    """Whoever has asked for less motion sees the finished picture."""
    Path("lines.logo").write_text("fd 30 pu rt 90 fd 20 pd fd 10 fd 0 pu home pd fd 0", "utf-8")
    assert run("--picture", "moving.svg", "--animate", "lines.logo") == 0
    assert run("--picture", "still.svg", "lines.logo") == 0
    moving, still = (Path(name).read_text("utf-8") for name in ("moving.svg", "still.svg"))
    style = re.search(r"<style>.*</style>", moving, re.DOTALL)
    assert style is not None
    outside = re.sub(r"@media[^{]*\{(?:[^{}]|\{[^{}]*\})*\}", "", style[0])
    assert "animation" not in outside
    assert "visibility" not in outside
    # Lines are drawn one after the other, at one speed.
    times = [(float(t), float(d)) for t, d in re.findall(r'"--t:([\d.]+)s;--d:([\d.]+)s"', moving)]
    begins = sorted(times)
    assert begins[0][0] == 0.0
    for (t, d), (following, _) in pairwise(begins):
        assert t + d == pytest.approx(following, abs=0.002)
    lengths = dict(begins)
    assert lengths[0.0] / (begins[-1][0] + begins[-1][1]) == pytest.approx(
        30 / (30 + 20 + 10 + 42.43), abs=0.01
    )
    # What knows no animation draws the still one: the turtle on its way is hidden.
    assert picture.png(moving) == picture.png(still)
    # Without the style sheet and what it speaks of, it is the still one.
    plain = re.sub(r'<style>.*</style>\n|<g id="moving".*?</g>\n', "", moving, flags=re.DOTALL)
    plain = re.sub(r' (?:class|style|pathLength)="[^"]*"', "", plain)
    assert plain == still


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("--animate square.logo", "--animate says how a picture looks: say where by --picture FILE.svg"),
        ("--animate --picture a.png square.logo", "--animate is for .svg: a .png cannot move"),
        ("--picture a.gif square.logo", "unknown picture format '.gif'"),
        ("--json square.logo", "--json goes with --check"),
        ("--robot walter square.logo", "`turtlewire run` runs programs on robots"),
        ("--port sim:walter", "which needs a terminal"),
        ("--step-mm 0 square.logo", "'0' is not a number above 0"),
        ("fmt", "the following arguments are required: PROGRAM.logo"),
        ("fmt --tabs square.logo", "unrecognized arguments: --tabs"),
    ],
)
def test_wrong_usage(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: str, message: str
) -> None:
    stdin(monkeypatch, "")
    assert run(*arguments.split()) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("how", [[], ["--check"], ["fmt"]])
def test_what_cannot_be_read(capsys: pytest.CaptureFixture[str], how: list[str]) -> None:
    assert run(*how, "none.logo") == 1
    assert "cannot read the program none.logo: No such file or directory" in capsys.readouterr().err
    Path("latin.logo").write_bytes(b'PRINT "Gr\xfc\xdfe\n')
    assert run(*how, "latin.logo") == 1
    assert "latin.logo is not text in UTF-8" in capsys.readouterr().err


# --- --check


def test_check(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--check", "square.logo") == 0
    assert capsys.readouterr().out == ""
    assert run("--check", "square.logo", "wrong.logo", "unused.logo") == 1
    said = capsys.readouterr()
    assert said.out.startswith("wrong.logo, line 2, column 1: I don't know how to fdd\n    fdd 20\n    ^\n")
    assert "unused.logo, line 1, column 6: f never uses its input x\n" in said.out
    assert said.err == ""


def test_check_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--check", "--json", "wrong.logo") == 1
    (finding,) = json.loads(capsys.readouterr().out)["findings"]
    assert finding == {
        "file": "wrong.logo",
        "line": 2,
        "column": 1,
        "kind": "unknown procedure",
        "message": "I don't know how to fdd",
        "hint": finding["hint"],
    }
    assert finding["hint"].startswith("Did you mean fd")
    stdin(monkeypatch, "print [")
    assert run("--json", "--check", "-") == 1
    (finding,) = json.loads(capsys.readouterr().out)["findings"]
    assert (finding["kind"], finding["file"]) == ("syntax", "standard input")
    assert run("--check", "--json", "square.logo") == 0
    assert json.loads(capsys.readouterr().out) == {"findings": []}


# --- fmt


def test_fmt(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("fmt", "--check", "square.logo", "untidy.logo") == 1
    assert capsys.readouterr().out == "untidy.logo would change\n"
    assert Path("untidy.logo").read_text("utf-8") == UNTIDY
    assert run("fmt", "untidy.logo", "square.logo") == 0
    assert capsys.readouterr().out == "untidy.logo changed\n"
    assert Path("untidy.logo").read_text("utf-8") == formatted(UNTIDY) != UNTIDY
    assert run("fmt", "--check", "untidy.logo") == 0
    assert capsys.readouterr().out == ""


def test_fmt_from_the_standard_input(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    stdin(monkeypatch, UNTIDY)
    assert run("fmt", "-") == 0
    assert capsys.readouterr().out == formatted(UNTIDY)
    stdin(monkeypatch, UNTIDY)
    assert run("fmt", "-", "--check") == 1
    assert capsys.readouterr().out == "standard input would change\n"


def test_fmt_keeps_what_other_editors_want() -> None:
    Path("notepad.logo").write_bytes(b"\xef\xbb\xbf" + UNTIDY.replace("\n", "\r\n").encode())
    assert run("fmt", "notepad.logo") == 0
    assert (
        Path("notepad.logo").read_bytes()
        == b"\xef\xbb\xbf" + formatted(UNTIDY).replace("\n", "\r\n").encode()
    )


def test_fmt_touches_nothing_that_it_cannot_read(capsys: pytest.CaptureFixture[str]) -> None:
    Path("open.logo").write_text("repeat   4 [\n", "utf-8")
    assert run("fmt", "open.logo") == 1
    assert "open.logo, line 1, column 12: ']' not found" in capsys.readouterr().err
    assert Path("open.logo").read_text("utf-8") == "repeat   4 [\n"


# --- as Python


def test_procedures_are_shown_as_python_and_nothing_runs(capsys: pytest.CaptureFixture[str]) -> None:
    Path("two.logo").write_text(
        "to double :x\noutput :x * 2.5\nend\nprint 1\nto Do :list\nrun :list\nend\n", "utf-8"
    )
    assert run("--show-python", "two.logo") == 0
    assert capsys.readouterr().out == (
        "# double\ndef q_double(x_):\n    return +x_ * 2.5\np_double = q_double\n\n"
        "# Do is left to the evaluator: a list that is computed is run\n"
    )
    assert run("--show-python", "square.logo") == 0
    assert not capsys.readouterr().out
