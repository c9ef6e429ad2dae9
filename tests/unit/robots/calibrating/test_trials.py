"""What people answer, and what it means."""

from __future__ import annotations

import pytest

from turtlewire.robots.calibrating import Finding, ImplausibleError, Quantity, Question

FAR = Question(text="How far?", quantity=Quantity.DISTANCE, low=100.0, high=500.0, why="by what is known")
TURNED = Question(text="How far?", quantity=Quantity.TURNED, low=-400.0, high=400.0)
MOVED = Question(text="Did it?", quantity=Quantity.MOVED)
WHICH = Question(text="Which?", quantity=Quantity.WHEEL_WAY, choices=("left", "left back", "right", "none"))


@pytest.mark.parametrize(
    ("question", "text", "answer"),
    [
        (FAR, "312", 312.0),
        (FAR, " 312.5 mm ", 312.5),
        (FAR, "31,25 cm", 312.5),
        (FAR, "0.3m", 300.0),
        (FAR, "+.2 M", 200.0),
        (TURNED, "-361", -361.0),
        (TURNED, "90°", 90.0),
        (TURNED, "90 degrees", 90.0),
        (MOVED, "y", True),
        (MOVED, "No", False),
        (WHICH, "left", "left"),
        (WHICH, "left b", "left back"),
        (WHICH, "n", "none"),
    ],
)
def test_answers(question: Question, text: str, answer: object) -> None:
    assert question.read(text) == answer


@pytest.mark.parametrize(
    ("question", "text", "reason", "value"),
    [
        (FAR, "501", "501 mm is not plausible: it should be from 100 to 500, by what is known", 501.0),
        (FAR, "50 cm 3", "write a number of mm", None),
        (FAR, "300 degrees", "write a number of mm", None),
        (FAR, "nan", "write a number of mm", None),
        (FAR, "1e3", "write a number of mm", None),
        (FAR, "-", "write a number of mm", None),
        (TURNED, "9 m", "write a number of degrees", None),
        (TURNED, "500", "500 degrees is not plausible: it should be from -400 to 400", 500.0),
        (MOVED, "1", "the answers are y and n", None),
        (WHICH, "l", "the answers are left, left back, right, none", None),
        (WHICH, "", "the answers are left, left back, right, none", None),
    ],
)
def test_what_is_no_answer(question: Question, text: str, reason: str, value: float | None) -> None:
    with pytest.raises(ImplausibleError) as caught:
        question.read(text)
    assert str(caught.value) == reason
    assert caught.value.value == value


def test_hints() -> None:
    assert [question.hint for question in (FAR, TURNED, MOVED, WHICH)] == [
        "mm",
        "degrees",
        "y/n",
        "left/left back/right/none",
    ]


def test_what_several_measurements_come_to() -> None:
    assert Finding("x", "mm", 1.0, (2.0, 4.0, 3.0)).new == 3.0
    assert Finding("x", "mm", 1.0, (2.0, 4.0, 3.0)).spread == 1.0
    assert Finding("x", "mm", 1.0, (2.0,)).spread is None
    assert Finding("x", "mm", 1.0).new is None
    assert Finding("x", "", "0", ("1",)).new == "1"
    assert Finding("x", "", "0", ("1",)).spread is None
