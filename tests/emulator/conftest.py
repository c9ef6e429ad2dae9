"""The sketches, built once, and the boards that run them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from turtlewire.firmware import BOARDS, Built, build, find_sketch

if TYPE_CHECKING:
    from collections.abc import Callable

Build = "Callable[[str], Built]"


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Built]:
    """``built("SimpleCar")``: the sketch, built for the Uno."""
    made: dict[str, Built] = {}
    folder = tmp_path_factory.mktemp("firmware")

    def get(name: str) -> Built:
        if name not in made:
            made[name] = build(find_sketch(name), BOARDS["uno"], folder, "avr-gcc")
        return made[name]

    return get
