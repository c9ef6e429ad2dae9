"""What a calibration is made of: trials, in each of which the robot does something and a person measures it."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from enum import Enum, auto
from statistics import fmean
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeAlias

# Skipped: None.
Answer: TypeAlias = "float | bool | str | None"
# How a robot tells that the moment has come at which the person has to look: a bell rings.
Signal: TypeAlias = "Callable[[], None]"

MM = {"": 1.0, "mm": 1.0, "cm": 10.0, "m": 1000.0}
DEGREES = {"": 1.0, "deg": 1.0, "degrees": 1.0, "°": 1.0}


class Quantity(Enum):
    """What is to be measured."""

    DISTANCE = auto()
    """From where it stood to where it stands, in mm."""
    AHEAD = auto()
    """How far of that is ahead, as it looked at the start, in mm; negative: back."""
    BACK = auto()
    """How far of that is back, as it looked at the start, in mm."""
    ASIDE = auto()
    """How far of that is to its right, as it looked at the start, in mm; negative: to its left."""
    TURNED = auto()
    """By how much it has turned, clockwise, in degrees, whole turns too; negative: counter-clockwise."""
    WHEELBASE = auto()
    """From the rear axle to the front axle, in mm."""
    MOVED = auto()
    """Whether it has moved at all."""
    WHEELS = auto()
    """Which wheels have turned: a choice of none, left, right, both."""
    WHEEL_WAY = auto()
    """Which wheel has turned, and which way: a choice of left, left back, right, right back, none."""
    STILL_MOVING = auto()
    """Whether anything of it was still moving when the bell rang."""
    PEN_MOVED = auto()
    """Whether the pen has moved up or down."""
    PEN_TOUCHES = auto()
    """Whether the pen touches the paper."""


DISTANCES = (Quantity.DISTANCE, Quantity.AHEAD, Quantity.BACK, Quantity.ASIDE, Quantity.WHEELBASE)


class ImplausibleError(ValueError):
    """An answer that cannot be right, or hardly can: ``str`` of it is the reason.

    Attributes:
        value: what it would mean, if a person insists; None: it means nothing.
    """

    def __init__(self, reason: str, value: float | None = None) -> None:
        super().__init__(reason)
        self.value = value


@dataclass(frozen=True, kw_only=True)
class Question:
    """What a person is asked after a trial.

    Attributes:
        text: the question.
        quantity: what it is about.
        low, high: between these, a number is plausible.
        why: why a number outside is not, as the end of a sentence.
        choices: the answers that there are, where it is no number; empty: yes or no, or a number.
    """

    text: str
    quantity: Quantity
    low: float = -math.inf
    high: float = math.inf
    why: str = ""
    choices: tuple[str, ...] = ()

    @property
    def unit(self) -> str:
        """``"mm"``, ``"degrees"``, or ``""`` where it is not about a number."""
        if self.quantity is Quantity.TURNED:
            return "degrees"
        return "mm" if self.quantity in DISTANCES else ""

    @property
    def hint(self) -> str:
        """What an answer looks like."""
        return self.unit or ("/".join(self.choices) if self.choices else "y/n")

    def read(self, text: str) -> float | bool | str:
        """The answer that a text means. Raises ``ImplausibleError``."""
        text = text.strip().lower()
        if self.choices:
            found = [choice for choice in self.choices if choice == text]
            found = found or [choice for choice in self.choices if text and choice.startswith(text)]
            if len(found) == 1:
                return found[0]
            raise ImplausibleError(f"the answers are {', '.join(self.choices)}")
        if not self.unit:
            if text in ("y", "yes", "n", "no"):
                return text.startswith("y")
            raise ImplausibleError("the answers are y and n")
        return self._number(text)

    def _number(self, text: str) -> float:
        units = MM if self.unit == "mm" else DEGREES
        match = re.fullmatch(r"([-+]?(?:\d+[.,]?\d*|[.,]\d+))\s*([a-z°]*)", text)
        if match is None or match[2] not in units:
            raise ImplausibleError(f"write a number of {self.unit}")
        value = float(match[1].replace(",", ".")) * units[match[2]]
        if not self.low <= value <= self.high:
            reason = (
                f"{value:g} {self.unit} is not plausible: it should be from {self.low:.0f} to {self.high:.0f}"
            )
            raise ImplausibleError(f"{reason}{', ' if self.why else ''}{self.why}", value)
        return value


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One thing that the robot does, and what is measured then.

    Attributes:
        step: the step of the calibration that it belongs to.
        does: what the robot will do, how far it will get.
        needs: where to put it, and what space it needs.
        act: lets it do that, and returns when it stands; given how to ring the bell, returns what the robot itself has
            measured. None: the robot does nothing.
        questions: what is measured then.
    """

    step: str
    does: str
    needs: str = ""
    act: Callable[[Signal], object] | None = None
    questions: tuple[Question, ...] = ()


class Outcome(NamedTuple):
    """What came of a trial: an answer for each question, None where it was skipped; and what ``act`` has returned."""

    answers: tuple[Answer, ...]
    reading: object = None


@dataclass(frozen=True)
class Finding:
    """One value that was measured.

    Attributes:
        name: as the calibration calls it.
        unit: of the values.
        old: the present value; None: there is none.
        values: what each repetition has come to.
    """

    name: str
    unit: str
    old: float | str | None
    values: tuple[float | str, ...] = field(default=())

    @property
    def new(self) -> float | str | None:
        """What all repetitions together have come to; None: it was not measured."""
        numbers = [value for value in self.values if not isinstance(value, str)]
        return fmean(numbers) if numbers else self.values[-1] if self.values else None

    @property
    def spread(self) -> float | None:
        """Half of the range of the repetitions; None where there are no two numbers."""
        numbers = [value for value in self.values if not isinstance(value, str)]
        return (max(numbers) - min(numbers)) / 2.0 if len(numbers) > 1 else None


class Plan(NamedTuple):
    """How to go about it.

    Attributes:
        space_mm: no drive is to be longer; 200 or more.
        repeats: how often each measurement is made; 1 or more.
        steps: the names of the steps to make; None: all of them.
    """

    space_mm: float = 1000.0
    repeats: int = 2
    steps: frozenset[str] | None = None
