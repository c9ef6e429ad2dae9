"""Programs in the folder of the server, and the files of programs: nothing outside it is read or written."""

from __future__ import annotations

import random
import threading
from typing import TYPE_CHECKING

import pytest

from turtlewire.console.confined import MOST_WRITTEN, ConfinedStreams
from turtlewire.console.programs import LARGEST, Programs, default_folder, examples
from turtlewire.console.refusals import Refused
from turtlewire.logo import Interpreter, LogoError, ScreenTurtle

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The programs' folder, in a place with something that is none of their business."""
    (tmp_path / "secret.logo").write_text('print "secret', "utf-8")
    (tmp_path / "secret.txt").write_text("secret", "utf-8")
    made = tmp_path / "programs"
    made.mkdir()
    (made / "out").symlink_to(tmp_path)
    (made / "link.logo").symlink_to(tmp_path / "secret.logo")
    (made / ".hidden").write_text("hidden", "utf-8")
    return made


# ---------------------------------------------------------------------- kept programs


def test_a_program_is_kept_and_comes_back(tmp_path: Path) -> None:
    programs = Programs(tmp_path / "not" / "there" / "yet")
    assert programs.all() == []
    kept = programs.write("Blåsippa 2.logo", "fd 10 ; å\n", instead_of=None)
    assert programs.read("Blåsippa 2.logo") == kept
    assert (tmp_path / "not" / "there" / "yet" / "Blåsippa 2.logo").read_text("utf-8") == "fd 10 ; å\n"
    assert [(entry.name, entry.size) for entry in programs.all()] == [("Blåsippa 2.logo", 11)]
    programs.delete("Blåsippa 2.logo", instead_of=kept.etag)
    assert programs.all() == []


@pytest.mark.parametrize(
    "name",
    ["", ".logo", "..logo", "../secret.logo", "a/b.logo", "/etc/x.logo", "a\\b.logo", "a.txt", "a\0.logo", ".a.logo",
     " a.logo", "a .logo", "a" * 65 + ".logo", "a\n.logo", "-rf.logo", "a.logo/", "con:.logo", "a.LOGO\n"],
)  # fmt: skip
def test_names_that_are_none(folder: Path, name: str) -> None:
    programs = Programs(folder)
    for attempt in (
        lambda: programs.read(name),
        lambda: programs.write(name, "", instead_of=None),
        lambda: programs.delete(name, instead_of=""),
    ):
        with pytest.raises(Refused) as refused:
            attempt()
        assert (refused.value.status, refused.value.code) == (422, "name")


@pytest.mark.parametrize("name", ["a.logo", "Ä ö-1.logo", "x(1).logo", "1.2.logo", "a" * 64 + ".logo"])
def test_names_that_are_fine(folder: Path, name: str) -> None:
    Programs(folder).write(name, "fd 1", instead_of=None)
    assert name in [entry.name for entry in Programs(folder).all()]


def test_links_are_not_followed(folder: Path) -> None:
    programs = Programs(folder)
    assert "link.logo" not in [entry.name for entry in programs.all()]
    with pytest.raises(Refused, match="not followed"):
        programs.read("link.logo")
    with pytest.raises(Refused, match="not followed"):
        programs.write("link.logo", "fd 1", instead_of=None)
    assert (folder.parent / "secret.logo").read_text("utf-8") == 'print "secret'


def test_nobodys_work_is_lost(folder: Path) -> None:
    programs = Programs(folder)
    first = programs.write("a.logo", "fd 1", instead_of=None)
    with pytest.raises(Refused) as exists:
        programs.write("a.logo", "fd 2", instead_of=None)
    assert (exists.value.status, exists.value.code) == (412, "exists")
    second = programs.write("a.logo", "fd 2", instead_of=first.etag)
    for late in (lambda: programs.write("a.logo", "fd 3", instead_of=first.etag),
                 lambda: programs.delete("a.logo", instead_of=first.etag)):  # fmt: skip
        with pytest.raises(Refused) as changed:
            late()
        assert (changed.value.status, changed.value.code) == (412, "changed")
    assert programs.read("a.logo") == second
    programs.delete("a.logo", instead_of=second.etag)
    with pytest.raises(Refused) as gone:
        programs.write("a.logo", "fd 4", instead_of=second.etag)
    assert (gone.value.status, gone.value.code) == (412, "gone")


def test_of_many_who_save_at_once_one_does(folder: Path) -> None:
    programs = Programs(folder)
    before = programs.write("a.logo", "fd 0", instead_of=None)
    saved: list[int] = []

    def save(number: int) -> None:
        try:
            programs.write("a.logo", f"fd {number}", instead_of=before.etag)
        except Refused:
            return
        saved.append(number)

    threads = [threading.Thread(target=save, args=(number,)) for number in range(1, 17)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(saved) == 1
    assert programs.read("a.logo").source == f"fd {saved[0]}"
    assert sorted(path.name for path in folder.iterdir()) == [".hidden", "a.logo", "link.logo", "out"]


def test_sizes_and_what_is_no_text(folder: Path) -> None:
    programs = Programs(folder)
    with pytest.raises(Refused) as refused:
        programs.write("a.logo", "ö" * LARGEST, instead_of=None)
    assert refused.value.status == 413
    (folder / "big.logo").write_bytes(b"x" * (LARGEST + 1))
    (folder / "odd.logo").write_bytes(b"print \xff")
    for name, status in (("big.logo", 413), ("odd.logo", 415), ("none.logo", 404)):
        with pytest.raises(Refused) as refused:
            programs.read(name)
        assert refused.value.status == status
    (folder / "windows.logo").write_bytes(b"\xef\xbb\xbffd 1\r\nrt 2\r\n")
    assert programs.read("windows.logo").source == "fd 1\nrt 2\n"


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", "utf-8")
    programs = Programs(tmp_path / "file")
    with pytest.raises(Refused, match="cannot be"):
        programs.write("a.logo", "fd 1", instead_of=None)
    with pytest.raises(Refused, match="cannot be read"):
        programs.all()


def test_the_folder_unless_somebody_says_otherwise(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert default_folder() == tmp_path / "turtlewire" / "programs"
    monkeypatch.setenv("XDG_DATA_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert default_folder() == tmp_path / ".local" / "share" / "turtlewire" / "programs"


def test_the_examples_come_along() -> None:
    found = {example.name: example.source for example in examples()}
    assert "rose.logo" in found
    assert len(found) >= 10


# ---------------------------------------------------------------------- files of a program


@pytest.fixture
def logo(folder: Path) -> Interpreter:
    written: list[str] = []
    made = Interpreter(ScreenTurtle(), written.append, random.Random(0))
    made.streams = ConfinedStreams(made, folder)
    made.variables["output"] = 0
    return made


@pytest.mark.parametrize(
    "name",
    [
        "../secret.txt",
        "/etc/passwd",
        "out/secret.txt",
        "out",
        ".hidden",
        "..",
        ".",
        "sub/../../secret.txt",
    ],
)
@pytest.mark.parametrize(
    "word",
    ["openread", "openwrite", "openappend", "openupdate", "load", "save", "erasefile", "dribble", "filep"],
)
def test_no_file_word_leads_out_of_the_folder(logo: Interpreter, folder: Path, word: str, name: str) -> None:
    before = sorted(str(path) for path in folder.parent.rglob("*"))
    with pytest.raises(LogoError) as refused:
        logo.run(f'{"print " if word == "filep" else ""}{word} "|{name}|')
    assert refused.value.number == 40
    assert sorted(str(path) for path in folder.parent.rglob("*")) == before
    assert (folder.parent / "secret.txt").read_text("utf-8") == "secret"


def test_a_prefix_leads_nowhere_else(logo: Interpreter) -> None:
    for prefix in ("..", "/etc", "out"):
        with pytest.raises(LogoError, match="can't open"):
            logo.run(f'setprefix "{prefix} openread "secret.txt')


def test_within_the_folder_files_are_as_they_always_are(logo: Interpreter, folder: Path) -> None:
    logo.run(
        'openwrite "a.txt setwrite "a.txt print [some words] setwrite [] closeall\n'
        'openread "a.txt setread "a.txt make "line readlist setread [] closeall\n'
        'to square\nend\nsave "mine.logo erasefile "a.txt make "there filep "mine.logo'
    )
    assert logo.variables["there"] == "true"
    assert not (folder / "a.txt").exists()
    assert "to square" in (folder / "mine.logo").read_text("utf-8")


def test_so_many_files_and_no_more(logo: Interpreter, folder: Path) -> None:
    with pytest.raises(LogoError, match="can't open"):
        logo.run(f'for [i 1 {MOST_WRITTEN + 1}] [openwrite word "f :i close word "f :i]')
    assert len(list(folder.glob("f*"))) == MOST_WRITTEN


def test_without_a_folder_there_are_no_files() -> None:
    logo = Interpreter(ScreenTurtle(), lambda _text: None, random.Random(0))
    logo.streams = ConfinedStreams(logo, None)
    with pytest.raises(LogoError, match="can't open"):
        logo.run('openread "a.txt')
