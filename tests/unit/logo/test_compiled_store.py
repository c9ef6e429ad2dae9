"""Programs that are started again are not compiled again, and do the same."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING

import pytest

from turtlewire.logo import Interpreter, LogoError, ScreenTurtle
from turtlewire.logo.compiler.store import contents, packed

if TYPE_CHECKING:
    from pathlib import Path

PROGRAM = """\
to double :x
  output :x * 2
end
to all :list
  foreach :list [print double ?]
  print [one [two]]
  run [print "done]
end
to computed :list
  run :list
end
all [1 2 3]
computed [print double 4]
"""
PRINTED = "2\n4\n6\none [two]\ndone\n8\n"


def run(program: str, folder: Path) -> str:
    written: list[str] = []
    logo = Interpreter(ScreenTurtle(), written.append, random.Random(0), compiled_at=str(folder))
    logo.run(program, "kept.logo")
    return "".join(written)


def kept(folder: Path) -> Path:
    (file,) = folder.glob("*.logo-code")
    return file


def test_what_is_kept_is_what_runs(tmp_path: Path) -> None:
    assert run(PROGRAM, tmp_path) == PRINTED
    file = kept(tmp_path)
    key, procedures = contents(file.read_bytes())
    assert set(procedures) == {"double", "all", "computed"}
    code = compile("def q_double(x_):\n    return x_ + 100\np_double = q_double", "<double>", "exec")
    procedures["double"] = (code, *procedures["double"][1:])
    file.write_bytes(packed(key, procedures))
    assert run(PROGRAM, tmp_path) == "101\n102\n103\none [two]\ndone\n104\n"


def test_an_error_says_the_same_from_what_is_kept(tmp_path: Path) -> None:
    program = "; a comment\n" + PROGRAM + "to wrong :x\n  print 1\n  print double first :x\nend\nwrong []\n"
    said = []
    for _ in range(2):
        with pytest.raises(LogoError) as caught:
            run(program, tmp_path)
        said.append(str(caught.value))
    assert said[0] == said[1]
    assert "kept.logo, line 17, column 16: first doesn't like [] as input in wrong" in said[0]


def test_the_same_procedures_may_stand_elsewhere(tmp_path: Path) -> None:
    run(PROGRAM, tmp_path)
    file, made = kept(tmp_path), kept(tmp_path).stat().st_mtime_ns
    assert run("; moved\n\n" + PROGRAM, tmp_path) == PRINTED
    assert kept(tmp_path) == file
    assert file.stat().st_mtime_ns == made


def test_a_change_anywhere_is_another_program(tmp_path: Path) -> None:
    run(PROGRAM, tmp_path)
    assert run(PROGRAM.replace(":x * 2", ":x * 3"), tmp_path) == PRINTED.translate(
        str.maketrans("2468", "369$")
    ).replace("$", "12")
    assert len(list(tmp_path.glob("*"))) == 2


@pytest.mark.parametrize("damage", [b"", b"short", b"x" * 100])
def test_what_cannot_be_read_is_made_again(tmp_path: Path, damage: bytes) -> None:
    run(PROGRAM, tmp_path)
    file = kept(tmp_path)
    whole = file.read_bytes()
    file.write_bytes(damage)
    assert run(PROGRAM, tmp_path) == PRINTED
    assert len(file.read_bytes()) == len(whole)
    file.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    assert run(PROGRAM, tmp_path) == PRINTED


def test_the_file_of_another_program_is_not_used(tmp_path: Path) -> None:
    """Names of files are short: two programs may have the same."""
    run(PROGRAM, tmp_path)
    file = kept(tmp_path)
    key, entries = contents(file.read_bytes())
    file.write_bytes(packed(key.replace("x * 2", "x * 3"), entries))
    changed(tmp_path, "double", "def q_double(x_):\n    return 'another'\np_double = q_double")
    assert run(PROGRAM, tmp_path) == PRINTED


def test_a_folder_that_cannot_be_is_no_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    assert run(PROGRAM, tmp_path / "file" / "kept") == PRINTED


def test_what_a_program_defines_itself_is_not_kept(tmp_path: Path) -> None:
    program = 'define "made [[x] [output :x + 1]]\nto f\nprint made 2\nend\nf\n'
    assert run(program, tmp_path) == run(program, tmp_path) == "3\n"
    assert not list(tmp_path.glob("*"))


def test_old_files_are_removed(tmp_path: Path) -> None:
    for index in range(205):
        (tmp_path / f"{index}.logo-code").write_bytes(b"old")
    run(PROGRAM, tmp_path)
    assert len(list(tmp_path.glob("*"))) == 200
    assert run(PROGRAM, tmp_path) == PRINTED


def changed(folder: Path, name: str, source: str) -> None:
    """Put other code in the place of what is kept under a name."""
    file = kept(folder)
    key, entries = contents(file.read_bytes())
    entries[name] = (compile(source, f"<{name}>", "exec"), *entries[name][1:])
    file.write_bytes(packed(key, entries))


JUMPS = """\
to even :n
  if :n = 0 [output "true]
  output odd :n - 1
end
to odd :n
  repeat 1 [if :n = 0 [output "false] output even :n - 1]
end
to silent :n
  repeat 1 [if :n > 0 [output loud :n - 1]]
end
to loud :n
  output silent :n
end
"""


def test_calls_that_are_left_to_the_caller_are_kept(tmp_path: Path) -> None:
    assert run(JUMPS + "print even 100001", tmp_path) == "false\n"
    changed(tmp_path, "even", "def q_even(n_):\n    return 'kept'\np_even = q_even")
    assert run(JUMPS + "print odd 100001", tmp_path) == "kept\n"


def test_a_call_that_was_left_to_the_caller_and_fails_has_its_place_when_it_is_kept(tmp_path: Path) -> None:
    said = []
    for _ in range(2):
        with pytest.raises(LogoError) as caught:
            run(JUMPS + "print silent 3", tmp_path)
        said.append(str(caught.value))
    assert said[0] == said[1]
    assert "kept.logo, line 12, column 10: silent didn't output to output in loud" in said[0]


def test_lines_with_loops_are_kept(tmp_path: Path) -> None:
    lines = 'make "x 3\nrepeat 2 [print [a]]\n  repeat :x [print first [b c]]\n'
    printed = "a\na\nb\nb\nb\n"
    assert run(lines, tmp_path) == run(lines, tmp_path) == printed
    first, _ = contents(kept(tmp_path).read_bytes())[1]
    changed(tmp_path, first, "def line():\n    V['x'] = 1")
    assert run(lines, tmp_path) == "b\n"
    assert run(PROGRAM + lines, tmp_path) == PRINTED + printed


def test_an_error_in_a_kept_line_has_its_place(tmp_path: Path) -> None:
    for _ in range(2):
        with pytest.raises(LogoError) as caught:
            run("print 1\n  repeat 2 [print first []]", tmp_path)
        assert "kept.logo, line 2, column 19: first doesn't like []" in str(caught.value)
