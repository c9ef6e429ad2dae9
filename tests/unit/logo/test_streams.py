"""Files and the keyboard: what the vectors cannot hold."""

from __future__ import annotations

import contextlib
import io
import os
import pty
import subprocess
import sys
import termios
from typing import TYPE_CHECKING

import pytest

from turtlewire.logo import LogoError, ScreenTurtle
from turtlewire.logo.keyboard import Keyboard

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from .conftest import Session


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def type_in(session: Session, text: str) -> None:
    session.interpreter.streams.keyboard = Keyboard(io.StringIO(text).readline)


# --- the keyboard ---------------------------------------------------------------------------------------------


def test_lines_words_and_letters_from_the_keyboard(session: Session) -> None:
    type_in(session, "Ada Lovelace\nhello, world\nxyz\n[a\nb] c\n|one\ntwo| a~\nb\n12\n")
    program = (
        "show readlist show readword show readchar show readchars 2 show readchar"
        " show readlist show count readlist show 1 + readword"
    )
    assert session.run(program) == "[Ada Lovelace]\nhello, world\nx\nyz\n\n\n[[a b] c]\n2\n13\n"


def test_the_end_of_the_keyboard_is_that_of_a_file(session: Session) -> None:
    type_in(session, "")
    assert session.run("show readlist show readword show readrawline show readchar show readchars 3") == (
        "\n[]\n[]\n[]\n[]\n"
    )


def test_keyp_knows_what_is_left_of_a_line(session: Session) -> None:
    type_in(session, "ab\n")
    assert session.run("show keyp show readchar show keyp show readlist show keyp") == (
        "false\na\ntrue\n[b]\nfalse\n"
    )


def test_what_is_open_when_the_keyboard_ends_is_an_error(session: Session) -> None:
    type_in(session, "a [b\n")
    error = session.error("print 1\nshow readlist")
    assert (error.number, error.text) == (10, "']' not found")
    assert error.position is not None
    assert error.position.line == 2


def test_standard_input_is_read_and_what_type_asked_stands_before_it(tmp_path: Path) -> None:
    (tmp_path / "ask.logo").write_text('type "name? show readlist show readword', "utf-8")
    command = [sys.executable, "-m", "turtlewire", "logo", "ask.logo"]
    done = subprocess.run(command, input="Käthe\n", capture_output=True, encoding="utf-8", check=True)
    assert done.stdout == "name?[Käthe]\n[]\n"


def test_a_key_at_a_terminal_is_read_as_soon_as_it_is_pressed(tmp_path: Path) -> None:
    program = (
        'print "ready until [keyp] [] show readchar show keyp show (list readchar readchar)'
        " show readlist show readchar"
    )
    (tmp_path / "key.logo").write_text(program, "utf-8")
    outside, inside = pty.openpty()
    try:
        before = termios.tcgetattr(inside)
        with subprocess.Popen(
            [sys.executable, "-m", "turtlewire", "logo", "key.logo"], stdin=inside, stdout=subprocess.PIPE
        ) as logo:
            assert logo.stdout is not None
            assert logo.stdout.readline() == b"ready\n"
            os.write(outside, "qw🐢".encode())  # and no newline
            assert [logo.stdout.readline().decode() for _ in range(3)] == ["q\n", "true\n", "[w 🐢]\n"]
            os.write(outside, b"a line\n")
            assert logo.stdout.readline() == b"[a line]\n"
            os.write(outside, b"x")
            assert logo.stdout.read() == b"x\n"
        assert logo.returncode == 0
        assert termios.tcgetattr(inside) == before
    finally:
        os.close(outside)
        os.close(inside)


# --- text -----------------------------------------------------------------------------------------------------


def test_text_is_unicode_and_positions_are_bytes(session: Session, tmp_path: Path) -> None:
    session.run('openwrite "f setwrite "f print "Grüße print "日本🐢 close "f')
    assert (tmp_path / "f").read_text("utf-8") == "Grüße\n日本🐢\n"
    program = (
        'openread "f setread "f show readchars 4 show readpos show readword show readchar show readchar'
        " show readchar show readchar show readchar"
    )
    assert session.run(program) == "Grüß\n6\ne\n日\n本\n🐢\n\n\n[]\n"


def test_marks_and_line_ends_of_windows_are_no_text(session: Session, tmp_path: Path) -> None:
    (tmp_path / "f").write_bytes(b"\xef\xbb\xbfa b\r\nc\r\n")
    assert session.run('openread "f setread "f show readlist show count readrawline') == "[a b]\n1\n"


@pytest.mark.parametrize(
    "reading", ["readlist", "readword", "readrawline", "readchar", "readchars 5", '(list load "f)']
)
def test_what_is_no_text_is_said_to_be_none(session: Session, tmp_path: Path, reading: str) -> None:
    (tmp_path / "f").write_bytes(b"\xff\xfeabc\n")
    error = session.error(f'openread "f setread "f show {reading}')
    assert (error.number, error.text) == (18, "File system error")
    assert "f: this is not text in UTF-8: there is a byte FF. Save the file as UTF-8." in error.explain()


def test_a_letter_that_ends_too_early_is_no_text(session: Session, tmp_path: Path) -> None:
    (tmp_path / "f").write_bytes(b"a\xe6\x97")
    assert session.error('openread "f setread "f show readchar show readchar').number == 18


# --- what goes wrong ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("program", "hint"),
    [
        ('openread "nofile', "There is no such file in "),
        ('load "nofile', "There is no such file in "),
        ('openwrite "nodir/f', "There is no folder "),
        ('save "nodir/f', "There is no folder "),
        ('openread "folder', "folder is a folder."),
        ('load "folder', "folder is a folder."),
        ('erasefile "folder', "folder is a folder."),
        ('openread word "a char 0', "no file can have this name"),
        ('load word "a char 0', "no file can have this name"),
    ],
)
def test_files_that_cannot_be_opened(session: Session, tmp_path: Path, program: str, hint: str) -> None:
    (tmp_path / "folder").mkdir()
    error = session.error(program)
    assert error.number == 40
    assert error.text.startswith("I can't open file ")
    assert hint in error.hint


@pytest.mark.parametrize(
    ("program", "hint"),
    [
        ('setread "f', 'openread "f'),
        ('setwrite "f', 'openwrite "f'),
        ('close "f', "ALLOPEN"),
        ("close [a 3]", "the same list"),
        ("setread [a 3]", "Only files are read"),
    ],
)
def test_files_that_are_not_open(session: Session, program: str, hint: str) -> None:
    error = session.error(program)
    assert error.number == 42
    assert hint in error.hint


@pytest.mark.parametrize("ending", ["", 'close "/dev/full', 'throw "toplevel', "print readpos setread []"])
def test_a_disk_that_is_full(session: Session, ending: str) -> None:
    error = session.error(f'openwrite "/dev/full setwrite "/dev/full print "x setwrite []\n{ending}')
    assert (error.number, error.hint) == (18, "/dev/full: No space left on device.")


def test_the_first_error_is_the_one_that_is_told(session: Session) -> None:
    assert session.error('openwrite "/dev/full setwrite "/dev/full print "x setwrite [] foo').number == 13


def test_all_files_are_closed_though_one_cannot_be(session: Session, tmp_path: Path) -> None:
    link = tmp_path / "full"
    link.symlink_to("/dev/full")
    program = 'foreach [f /dev/full g full] [openwrite ? setwrite ? print "x] setwrite []'
    assert session.error(program).hint == "/dev/full: No space left on device."
    assert (tmp_path / "f").read_text("utf-8") == (tmp_path / "g").read_text("utf-8") == "x\n"
    assert session.run("show allopen") == "[]\n"


# --- every way out --------------------------------------------------------------------------------------------

WRITING = 'dribble "d print "before openwrite "f setwrite "f print "written\n'


@pytest.mark.parametrize("ending", ["", "foo", "bye", 'throw "toplevel', 'throw "nowhere', "fd 1"])
def test_files_are_closed_and_the_screen_is_back_whatever_the_end(
    make_session: Callable[..., Session], tmp_path: Path, ending: str
) -> None:
    class Interrupted(ScreenTurtle):
        def forward(self, distance_mm: float) -> None:
            raise KeyboardInterrupt

    session = make_session(Interrupted())
    write = session.interpreter.write
    with contextlib.suppress(LogoError, KeyboardInterrupt):
        session.interpreter.run(WRITING + ending, "test.logo")
    assert session.interpreter.write == write
    assert (tmp_path / "f").read_text("utf-8") == "written\n"
    assert (tmp_path / "d").read_text("utf-8") == "before\n"
    assert session.run("show allopen show writer print 1") == "[]\n[]\n1\n"


def test_files_stay_open_from_line_to_line_when_wanted(session: Session, tmp_path: Path) -> None:
    interpreter = session.interpreter
    interpreter.run('openwrite "f setwrite "f', keeps_files=True)
    interpreter.run("print 1", keeps_files=True)
    with pytest.raises(LogoError):
        interpreter.run("foo", keeps_files=True)
    interpreter.run('show writer setwrite "f print 2', keeps_files=True)
    interpreter.streams.finish(failed=False)
    assert "".join(session.written) == "[]\n"
    assert (tmp_path / "f").read_text("utf-8") == "1\n2\n"


# --- what is written ------------------------------------------------------------------------------------------


def test_the_dribble_file_has_what_is_typed_and_what_is_on_the_screen(
    session: Session, tmp_path: Path
) -> None:
    type_in(session, "Ada\n")
    program = (
        'dribble "d type "name? print readlist openwrite "f setwrite "f print "no setwrite []'
        " print 1 nodribble print 2"
    )
    assert session.run(program) == "name?Ada\n1\n2\n"
    assert (tmp_path / "d").read_text("utf-8") == "name?Ada\nAda\n1\n"


def test_the_screen_may_change_while_a_file_is_written(session: Session) -> None:
    interpreter = session.interpreter
    interpreter.run('openwrite "f setwrite "f print 1', keeps_files=True)
    seen: list[str] = []
    interpreter.write = seen.append
    interpreter.run("setwrite [] print 2", keeps_files=True)
    interpreter.streams.finish(failed=False)
    assert seen == ["2\n"]


def test_buffers(session: Session) -> None:
    program = (
        'make "b [text 100] openwrite :b setwrite :b print 1 show equalp writer :b show writepos'
        " show readpos setwritepos 0 print 2 closeall print :text show allopen"
    )
    assert session.run(program) == "1\ntrue\n7\n0\n2\n\n[]\n"
    assert session.error('make "b [text 100] openwrite :b openwrite :b').number == 41
    assert session.error('make "b [text 100] openwrite :b setwrite [text 0]').number == 4


def test_a_buffer_that_setwrite_opened_is_closed_by_the_next_one(session: Session) -> None:
    program = "setwrite [one 10] print 1 setwrite [two 10] print 2 setwrite [] (type :one :two)"
    assert session.run(program) == "1\n2\n"


def test_closeall_and_allopen(session: Session) -> None:
    assert session.run('openwrite "f openwrite "g show allopen closeall show allopen') == "[g f]\n[]\n"


# --- loading and saving ---------------------------------------------------------------------------------------


def test_an_error_in_a_loaded_file_has_its_place_there(session: Session, tmp_path: Path) -> None:
    (tmp_path / "lib").write_text("to f :x\n  print :x\n  foo\nend\nf 1\n", "utf-8")
    error = session.error('print 0\nload "lib\nprint 2')
    assert (error.text, error.procedure) == ("I don't know how to foo", "f")
    assert error.position is not None
    assert (error.position.file, error.position.line, error.position.column) == ("lib", 3, 3)


def test_startup_is_run_once_it_was_loaded(session: Session, tmp_path: Path) -> None:
    (tmp_path / "lib").write_text('make "startup [print "started]\nprint "loading\n', "utf-8")
    assert session.run('load "lib') == "loading\nstarted\n"
    (tmp_path / "other").write_text('print "loading\n', "utf-8")
    assert session.run('load "other') == "loading\n"


def test_loadnoisily_tells_what_is_defined(session: Session, tmp_path: Path) -> None:
    (tmp_path / "lib").write_text("to f\nend\nto G\nend\n", "utf-8")
    assert session.run('load "lib') == ""
    assert session.run('make "loadnoisily "true load "lib') == "f defined\nG defined\n"


def test_a_loaded_file_is_at_top_level(session: Session, tmp_path: Path) -> None:
    (tmp_path / "lib").write_text("output 3\n", "utf-8")
    assert session.error('to f\nload "lib\nend\nf').number == 31
    assert session.run('to f\ncatch "error [load "lib]\noutput 4\nend\nprint f') == "4\n"


def test_save_without_a_name_takes_the_last_one(session: Session, tmp_path: Path) -> None:
    assert session.error("(save)").hint.startswith("(save) takes the file")
    session.run('make "v 1 save "ws\nmake "v 2 save')
    assert (tmp_path / "ws").read_text("utf-8") == 'Make "v 2\n'
    (tmp_path / "other").write_text('make "w 3\n', "utf-8")
    session.run('load "other\nsave')
    assert (tmp_path / "other").read_text("utf-8") == 'Make "v 2\nMake "w 3\n'


def test_what_cannot_be_saved_leaves_the_file_as_it_was(session: Session, tmp_path: Path) -> None:
    (tmp_path / "ws").write_text("old\n", "utf-8")
    assert session.error('savel [print] "ws').number == 22
    assert (tmp_path / "ws").read_text("utf-8") == "old\n"


def test_prefixes(session: Session, tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    session.run('setprefix "sub make "v 1 save "ws openwrite "f setwrite "f print 1 setprefix []')
    assert sorted(path.name for path in (tmp_path / "sub").iterdir()) == ["f", "ws"]
    assert session.run('setprefix "sub show filep "f erf "f show filep "f show filep "sub show prefix') == (
        "true\nfalse\nfalse\nsub\n"
    )
