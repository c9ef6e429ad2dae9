"""The index of the primitives says what the chapters have, and the chapters are loaded when they are wanted."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tools.generators import primitives
from turtlewire.logo.primitives import PRIMITIVES

CHAPTERS = primitives.chapters()


def test_the_index_is_what_the_chapters_have() -> None:
    names = [name for words in CHAPTERS.values() for name in words]
    assert len(names) == len(set(names)) > 350
    assert list(PRIMITIVES) == names
    for words in CHAPTERS.values():
        for name, there in words.items():
            here = PRIMITIVES[name]
            assert here.function is there.function
            assert here is PRIMITIVES[there.name]
            for each in ("name", "default_inputs", "minimum_inputs", "maximum_inputs"):
                assert getattr(here, each) == getattr(there, each), name


def test_the_generated_index_is_current() -> None:
    for path, text in primitives.files().items():
        assert path.read_text("utf-8") == text, "run `make generate`"


def test_a_chapter_is_loaded_when_a_word_of_it_is_used() -> None:
    program = (
        "import sys, random\n"
        "from turtlewire.logo import Interpreter, ScreenTurtle\n"
        "place = 'turtlewire.logo.primitives.'\n"
        "def chapters():\n"
        "    return [m.removeprefix(place) for m in sys.modules if m.startswith(place)]\n"
        "logo = Interpreter(ScreenTurtle(), print, random.Random(), compiles=False)\n"
        "print(chapters())\n"
        "logo.run('(print \"hello) rt 90')\n"
        "print(chapters())\n"
    )
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    before, *_, after = [set(line[2:-2].split("', '")) for line in told.stdout.splitlines()]
    assert before == {"index"}
    assert {"communication", "graphics"} < after
    assert not {"arithmetic", "files", "marking"} & after


def test_a_primitive_has_no_other_attributes() -> None:
    with pytest.raises(AttributeError, match="primitives have no nonsense"):
        _ = PRIMITIVES["print"].nonsense  # type: ignore[attr-defined]
