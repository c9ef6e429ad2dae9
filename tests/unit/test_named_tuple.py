"""Our NamedTuple is the one of ``typing``, but for the time it takes to load."""

from __future__ import annotations

import copy
import pickle
import typing

import pytest

from turtlewire import named_tuple


class Ours(named_tuple.NamedTuple):
    """A place."""

    x: int
    y: float = 2.0
    name: str = ""

    def sum(self) -> float:
        return self.x + self.y


class Theirs(typing.NamedTuple):
    x: int
    y: float = 2.0
    name: str = ""


def test_it_is_a_tuple_with_names() -> None:
    place = Ours(1, name="a")
    assert tuple in type(place).__mro__
    assert place == (1, 2.0, "a")
    assert place == tuple(Theirs(1, name="a"))
    assert hash(place) == hash((1, 2.0, "a"))
    assert (place.x, place.y, place.name, place.sum()) == (1, 2.0, "a", 3.0)
    x, *rest = place
    assert (x, rest) == (1, [2.0, "a"])
    found: object = place
    match found:
        case Ours(1, y):
            assert y == 2.0
        case _:
            pytest.fail("it has no fields by position")


def test_it_does_what_that_of_typing_does() -> None:
    ours, theirs = Ours(1, 3.0), Theirs(1, 3.0)
    assert repr(ours) == repr(theirs).replace("Theirs", "Ours") == "Ours(x=1, y=3.0, name='')"
    assert ours._replace(y=5.0) == tuple(theirs._replace(y=5.0)) == (1, 5.0, "")
    assert type(ours._replace(y=5.0)) is Ours
    assert ours._asdict() == theirs._asdict()
    assert Ours._make([4, 5.0, "b"]) == Ours(4, 5.0, "b")
    assert Ours._fields == Theirs._fields
    assert Ours._field_defaults == Theirs._field_defaults
    assert Ours.__match_args__ == Theirs.__match_args__
    assert (Ours.__module__, Ours.__qualname__, Ours.__doc__) == (__name__, "Ours", "A place.")
    assert type(copy.deepcopy(ours)) is Ours
    assert copy.copy(ours) == ours
    assert pickle.loads(pickle.dumps(ours)) == ours


@pytest.mark.parametrize("kind", [Ours, Theirs])
def test_it_refuses_what_that_of_typing_refuses(kind: typing.Any) -> None:
    for wrong in ((), (1, 2.0, "", 4)):
        with pytest.raises(TypeError, match="__new__"):
            kind(*wrong)
    with pytest.raises(TypeError):
        kind._make([])
    with pytest.raises(ValueError, match=r"unexpected field names: \['z'\]"):
        kind(1)._replace(z=1)
    with pytest.raises(AttributeError):
        kind(1).x = 2
    with pytest.raises(AttributeError):
        kind(1).z = 2
