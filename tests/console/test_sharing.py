"""Two people, one robot: who drives, who asks, who is handed the wheel; and whoever stops takes it away."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from .conftest import wait_until

if TYPE_CHECKING:
    from collections.abc import Callable

    from .conftest import Console, Visitor

    Visit = Callable[..., Visitor]


@pytest.fixture
def anna(visit: Visit) -> Visitor:
    """She is first, and takes the wheel."""
    visitor = visit(settings={"name": "Anna"})
    visitor.button("Take the wheel").click()
    visitor.page.get_by_text("You drive").wait_for()
    return visitor


@pytest.fixture
def bo(anna: Visitor, visit: Visit) -> Visitor:
    """He is second, on a phone."""
    visitor = visit(settings={"name": "Bo"}, phone=True)
    visitor.page.get_by_text("Anna drives").wait_for()
    assert says(anna) == "You drive"
    return visitor


def says(visitor: Visitor) -> str:
    return visitor.see(".tw-wheel-says").inner_text()


def driver(console: Console) -> str | None:
    name: str | None = console.state("walter")["wheel"]["driver_name"]
    return name


def test_who_looks_on_cannot_drive_but_asks_and_is_handed_the_wheel(
    console: Console, anna: Visitor, bo: Visitor
) -> None:
    bo.page.keyboard.down("ArrowUp")
    bo.page.get_by_text("Somebody else drives").first.wait_for()
    bo.page.keyboard.up("ArrowUp")
    assert not console.moves("walter")
    with anna.driving("ArrowUp", lambda: console.moves("walter")):
        bo.button("Ask for the wheel").tap()
        anna.page.get_by_text("Bo asks for the wheel").wait_for()
        anna.button("Hand over").click()
        console.wait_for_rest("walter")  # though she goes on holding the key
        bo.page.get_by_text("You drive").wait_for()
        assert driver(console) == "Bo"
        with bo.driving("ArrowLeft", lambda: console.moves("walter")):
            pass


def test_who_is_asked_may_keep_it_and_who_says_nothing_loses_it(
    console: Console, anna: Visitor, bo: Visitor
) -> None:
    bo.button("Ask for the wheel").tap()
    anna.button("Keep").click()
    bo.button("Ask for the wheel").wait_for()
    assert says(anna) == "You drive"
    bo.button("Ask for the wheel").tap()
    anna.page.get_by_text("Without an answer it is handed over in").wait_for()
    wait_until(lambda: driver(console) == "Bo", "the wheel to be handed over by itself")
    anna.page.get_by_text("Bo drives").wait_for()


def test_whoever_stops_takes_the_wheel_away_and_only_the_button_gives_it_back(
    console: Console, anna: Visitor, bo: Visitor
) -> None:
    with anna.driving("ArrowUp", lambda: console.moves("walter")):
        bo.press(".tw-stop")
        console.wait_for_rest("walter")
        anna.page.get_by_text("Nobody drives").wait_for()
    # A new press, as after a stop of her own, does not do.
    anna.page.keyboard.down("ArrowUp")
    anna.page.get_by_text("take the wheel to drive").first.wait_for()
    anna.page.keyboard.up("ArrowUp")
    assert driver(console) is None
    anna.button("Take the wheel").click()
    anna.page.get_by_text("You drive").wait_for()
    with anna.driving("ArrowUp", lambda: console.moves("walter")):
        pass
    # Whoever stops with a wheel that is nobody's may take it by a press.
    bo.press(".tw-stop")
    bo.page.get_by_text("Nobody drives").wait_for()
    with bo.driving("ArrowRight", lambda: console.moves("walter")):
        pass
    assert driver(console) == "Bo"


def test_whoever_leaves_lets_go(console: Console, anna: Visitor, bo: Visitor) -> None:
    anna.page.close()
    bo.page.get_by_text("Nobody drives").wait_for()
    with bo.driving("ArrowUp", lambda: console.moves("walter")):
        pass
    assert driver(console) == "Bo"
