"""What terminals send of keys, in any pieces."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from turtlewire.dashboard.keyboard import Answered, Escape, Item, Keyboard, Released, Repeated, Text


@pytest.mark.parametrize(
    ("sent", "items"),
    [
        ("w", [Text("w")]),
        ("å ", [Text("å ")]),
        ("\x1b[A", [Text("\x1b[A")]),
        ("\x1bOA", [Text("\x1bOA")]),
        ("\x1b[97;;97u", [Text("\x1b[97;;97u")]),
        ("\x1b[97;2;65u", [Text("\x1b[97;2;65u")]),
        ("\x1b[97:65:97;2:1;65u", [Text("\x1b[97:65:97;2;65u")]),
        ("\x1b[1;1:1A", [Text("\x1b[1;1A")]),
        ("\x1b[97;1:2;97u", [Repeated("a")]),
        ("\x1b[1;1:2B", [Repeated("down")]),
        ("\x1b[97;1:3u", [Released("a")]),
        ("\x1b[44;1:3u\x1b[46;65:3u", [Released(","), Released(".")]),
        ("\x1b[119;129:3u", [Released("w")]),  # with caps lock
        ("\x1b[32;1:3u", [Released("space")]),
        ("\x1b[27;1:3u", [Released("escape")]),
        ("\x1b[1;1:3C\x1b[1;1:3D", [Released("right"), Released("left")]),
        ("\x1b[3;1:3~", [Released("")]),
        ("\x1b[99999999;1:3u", [Released("")]),
        ("\x1b[?27u", [Answered(tells_events=True)]),
        ("\x1b[?0u\x1b[?25u", [Answered(tells_events=False), Answered(tells_events=False)]),
        ("\x1b[I\x1b[O", [Text("\x1b[I\x1b[O")]),
        ("\x1b[200~wasd\x1b[201~", [Text("\x1b[200~wasd\x1b[201~")]),
        ("\x1b[?2026;2$y", [Text("\x1b[?2026;2$y")]),
        ("\x1bw", [Escape(), Text("w")]),
        ("a\x1b\x1b[Ab", [Text("a"), Escape(), Text("\x1b[Ab")]),
        ("w\x1b[97;1:3ud", [Text("w"), Released("a"), Text("d")]),
    ],
)
def test_what_is_sent_and_what_it_means(sent: str, items: list[Item]) -> None:
    keys = Keyboard()
    assert keys.feed(sent) == items
    assert keys.flush() == []


def test_an_escape_is_the_key_when_nothing_follows() -> None:
    keys = Keyboard()
    assert keys.feed("w\x1b") == [Text("w")]
    assert keys.flush() == [Escape()]
    assert keys.feed("\x1b[") == []
    assert keys.feed("97;1:") == []
    assert keys.flush() == [Text("\x1b[97;1:")]
    assert keys.feed("\x1b") == []
    assert keys.feed("[?2") == []
    assert keys.feed("7u") == [Answered(tells_events=True)]


def joined(items: list[Item]) -> list[Item]:
    """Texts that follow one another as one."""
    done: list[Item] = []
    for item in items:
        if isinstance(item, Text) and done and isinstance(done[-1], Text):
            done[-1] = Text(done[-1].text + item.text)
        else:
            done.append(item)
    return done


PIECES = st.sampled_from(
    ["w", "\x1b[97;1:3u", "\x1b[97;1:2;97u", "\x1b[?27u", "\x1b[A", "\x1bOB", "\x1b[1;1:3A", "å"]
)


@given(st.lists(PIECES), st.lists(st.integers(0, 60)))
def test_pieces_make_no_difference(pieces: list[str], cuts: list[int]) -> None:
    text = "".join(pieces)
    whole = Keyboard()
    wanted = whole.feed(text) + whole.flush()
    cut = Keyboard()
    found: list[Item] = []
    places = sorted({min(place, len(text)) for place in cuts} | {0, len(text)})
    for start, end in itertools.pairwise(places):
        found += cut.feed(text[start:end])
    assert joined(found + cut.flush()) == joined(wanted)


@given(st.text(st.sampled_from("\x1b[?;:0123456789uABw~O")))
def test_anything_may_come(text: str) -> None:
    keys = Keyboard()
    keys.feed(text)
    keys.flush()
