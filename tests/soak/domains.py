"""What the inputs of a rule may be: drawn by hypothesis, which can shrink them, or by plain chance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from hypothesis import strategies as st

if TYPE_CHECKING:
    import random
    from collections.abc import Callable


class Whole(NamedTuple):
    """Whole numbers, the ends more often than others."""

    low: int
    high: int

    def strategy(self) -> st.SearchStrategy[Any]:
        return st.integers(self.low, self.high)

    def by_chance(self, chance: random.Random) -> Any:
        if chance.random() < 0.1:
            return chance.choice((self.low, self.high))
        return chance.randint(self.low, self.high)


class Real(NamedTuple):
    """Numbers, rounded to three decimals: nobody wants to read more of them."""

    low: float
    high: float

    def strategy(self) -> st.SearchStrategy[Any]:
        return st.integers(round(self.low * 1000), round(self.high * 1000)).map(lambda n: n / 1000)

    def by_chance(self, chance: random.Random) -> Any:
        if chance.random() < 0.05:
            return chance.choice((self.low, self.high))
        return round(chance.uniform(self.low, self.high), 3)


class OneOf(NamedTuple):
    """One of some values, all alike likely; one that stands twice is twice as likely."""

    values: tuple[Any, ...]

    def strategy(self) -> st.SearchStrategy[Any]:
        return st.sampled_from(self.values)

    def by_chance(self, chance: random.Random) -> Any:
        return chance.choice(self.values)


Domain = Whole | Real | OneOf
FLAG, RARELY, MOSTLY = OneOf((False, True)), OneOf((False, False, True)), OneOf((False, True, True))


def one_of(*values: Any) -> OneOf:
    """One of these."""
    return OneOf(values)


class Rule(NamedTuple):
    """Something that a soak can do.

    ``weight`` is how often, among the others; ``name`` is that of the method, ``inputs`` what it is given.
    """

    name: str
    weight: float
    inputs: dict[str, Domain]


def rule(weight: float = 1.0, **inputs: Domain) -> Callable[[Any], Any]:
    """Make a rule of a method."""

    def mark(method: Any) -> Any:
        method.rule = Rule(method.__name__, weight, inputs)
        return method

    return mark


def rules_of(owner: type) -> list[Rule]:
    """The rules of a class, in the order of their names."""
    found = [getattr(getattr(owner, name), "rule", None) for name in sorted(dir(owner))]
    return [each for each in found if each is not None]
