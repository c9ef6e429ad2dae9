"""Starting: what a script is started with, and that it loads nothing which it has no use for."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from turtlewire.cli import command_line, logo_script, main

ENVIRONMENT = {**os.environ, "PYTHONDONTWRITEBYTECODE": ""}
PROGRAM = "print :commandline\nprint random 1\nlocal 1\n"

# --- with the parser and without it


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    Path("a.logo").write_text(PROGRAM, "utf-8")
    Path("logo").write_text("show :commandline", "utf-8")
    Path("-5").write_text("show :commandline", "utf-8")


LINES = [
    ["logo"],
    ["logo", "a.logo"],
    ["logo", "a.logo", "5", "80"],
    ["logo", "a.logo", ""],
    ["logo", ""],
    ["logo", "a.logo", "a b", "[c d]", "e=f", "@g"],
    ["logo", "logo", "logo"],
    ["logo", "a.logo", "fmt"],
    ["logo", "none.logo"],
    ["logo", "fmt"],
    ["logo", "fmt", "none.logo"],
    ["logo", "fmt", "--check", "a.logo"],
    ["logo", "a.logo", "-"],
    ["logo", "-", "a"],
    ["logo", "a.logo", "-5"],
    ["logo", "-5"],
    ["logo", "--", "-5"],
    ["logo", "a.logo", "--", "b"],
    ["logo", "a.logo", "--seed", "1"],
    ["logo", "a.logo", "--se", "1"],
    ["logo", "--seed", "1", "a.logo"],
    ["logo", "--seed", "x", "a.logo"],
    ["logo", "--check", "a.logo"],
    ["logo", "--picture", "a.svg", "a.logo", "1"],
    ["logo", "--none", "a.logo"],
    ["logo", "-h"],
    ["logo", "a.logo", "-h"],
    ["log", "a.logo"],
    ["Logo", "a.logo"],
    ["--version"],
    ["-h"],
    ["none"],
]


@pytest.mark.parametrize("line", LINES, ids=" ".join)
def test_a_script_is_the_same_without_the_parser(
    line: list[str], capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def told() -> tuple[int | str | None, str, str]:
        try:
            code: int | str | None = main.main(line)
        except SystemExit as end:
            code = end.code
        return code, *capfd.readouterr()

    first = told()
    monkeypatch.setattr(main, "script_of", lambda _arguments: None)
    assert told() == first


@pytest.mark.parametrize("line", LINES, ids=" ".join)
def test_it_has_no_option_that_is_not_as_it_is_without(
    line: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    script = main.script_of(line)
    if script is None:
        return
    parsed = vars(command_line.parse(line))
    assert parsed.pop("words") == list(script)
    assert parsed == {
        name: value for name, value in vars(command_line.parse(["logo"])).items() if name != "words"
    }
    options = logo_script.run.__kwdefaults__
    assert options is not None
    assert (parsed["animate"], parsed["seed"], parsed["step_mm"]) == (
        options["moves"],
        options["seed"],
        options["step_mm"],
    )


def test_most_scripts_need_no_parser() -> None:
    plain = [line for line in LINES if main.script_of(line) is not None]
    assert plain == LINES[1:9]


# --- what is loaded

# The command that pip makes, but for what pip itself loads for it.
COMMAND = "import sys; from turtlewire.cli.main import main; sys.exit(main())"


def loaded(*command: str) -> set[str]:
    """The modules that a command has loaded, beside those that Python has loaded itself."""
    told = [
        subprocess.run(
            [sys.executable, "-X", "importtime", *each],
            env=ENVIRONMENT,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=True,
        ).stderr
        for each in (command, ("-c", "pass"))
    ]
    mine, pythons = ({line.rpartition("|")[2].strip() for line in each.splitlines()} for each in told)
    return mine - pythons


def test_an_empty_program_loads_little() -> None:
    Path("empty.logo").write_text("", "utf-8")
    modules = loaded("-c", COMMAND, "logo", "empty.logo")
    foreign = {each for each in modules if each.partition(".")[0] != "turtlewire"}
    assert foreign <= {
        "__future__",
        "_collections",
        "errno",
        "gc",
        "itertools",
        "math",
        "resource",
    }  # each is a small one
    assert "turtlewire.logo.compiler" not in modules
    assert "turtlewire.logo.debugging" not in modules


def test_a_program_that_was_compiled_before_loads_little_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("double.logo").write_text("to double :x\n  output :x * 2\nend\nprint double 21\n", "utf-8")
    monkeypatch.setitem(ENVIRONMENT, "XDG_CACHE_HOME", str(tmp_path / "cache"))
    modules = loaded("-c", COMMAND, "logo", "double.logo")
    assert {"turtlewire.logo.compiler.writing", "ast"} <= modules
    modules = loaded("-c", COMMAND, "logo", "double.logo")
    assert "turtlewire.logo.compiler.writing" not in modules
    foreign = {each for each in modules if each.partition(".")[0] != "turtlewire"}
    assert foreign <= {
        "__future__",
        "_collections",
        "encodings.utf_8_sig",
        "errno",
        "gc",
        "itertools",
        "math",
        "resource",
        "zlib",
    }


# --- signals


def test_a_signal_has_its_name_without_the_enumeration_of_them() -> None:
    """What a script that is ended by a signal says; ``signal`` itself is not loaded for it."""
    Path("forever.logo").write_text('print "begun forever []\n', "utf-8")
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        with subprocess.Popen(
            [sys.executable, "-m", "turtlewire", "logo", "forever.logo"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as process:
            assert process.stdout is not None
            assert process.stderr is not None
            assert process.stdout.readline() == "begun\n"
            process.send_signal(number)
            said = process.stderr.read()
        assert process.returncode == 130
        assert said == f"turtlewire: interrupted ({number.name})\nin forever.logo, line 1\n"


# --- and ending


@pytest.mark.parametrize("options", [[], ["-X", "dev"]], ids=["at once", "taken apart"])
def test_all_is_written_when_a_script_has_ended(options: list[str]) -> None:
    Path("writes.logo").write_text(
        'openwrite "kept setwrite "kept repeat 5000 [print repcount] setwrite []\nrepeat 5000 [type repcount]',
        "utf-8",
    )
    ended = subprocess.run(
        [sys.executable, *options, "-c", COMMAND, "logo", "writes.logo"],
        env={**ENVIRONMENT, "PYTHONWARNINGS": ""},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=True,
    )
    assert ended.stdout == "".join(str(number) for number in range(1, 5001))
    assert Path("kept").read_text("utf-8").split() == [str(number) for number in range(1, 5001)]
    assert ended.stderr == ""


def test_a_script_whose_output_nobody_reads_says_so() -> None:
    Path("long.logo").write_text("repeat 100000 [print repcount]", "utf-8")
    ended = subprocess.run(
        [
            "bash",
            "-c",
            f"'{sys.executable}' -c '{COMMAND}' logo long.logo | head -1; exit ${{PIPESTATUS[0]}}",
        ],
        env={**ENVIRONMENT, "PYTHONWARNINGS": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.stdout == "1\n"
    assert "no longer read" in ended.stderr
    assert ended.returncode not in (0, 120)


def test_called_as_a_function_it_comes_back() -> None:
    assert main.main(["logo", "a.logo"]) == 0
