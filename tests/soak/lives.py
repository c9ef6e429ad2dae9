"""Soaks by chance: life after life, until so many commands have been given."""

from __future__ import annotations

import random
import time
from typing import TYPE_CHECKING

from tests.soak.domains import rules_of
from tests.soak.frame.soak import FrameSoak
from tests.soak.report import Report
from tests.soak.simple.soak import CarSoak
from tests.soak.walter.soak import WalterSoak
from tests.soak.wire import ViolationError

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.soak.soak import Soak
    from turtlewire.links.faults import Faults

SOAKS: dict[str, type[Soak]] = {soak.NAME: soak for soak in (CarSoak, FrameSoak, WalterSoak)}
# So many commands before everything begins anew, with other settings.
LIFE_COMMANDS = 1000
# A lost link is waited for nearly always: nothing moves before.
PATIENCE = 0.8


def random_life(soak_type: type[Soak], seed: int, faults: Faults, commands: int) -> Report:
    """Do by chance what a soak can do, until it has given so many commands. Raises ``ViolationError``."""
    chance = random.Random(seed)
    setup = {name: domain.by_chance(chance) for name, domain in soak_type.SETUP.items()}
    soak = soak_type(seed * 1_000_003, faults, **setup)
    rules = [each for each in rules_of(soak_type) if each.weight]
    weights = [each.weight for each in rules]
    while soak.report.commands < commands:
        if soak.driver.link_state != "connected" and chance.random() < PATIENCE:
            soak.step("come_back")
            continue
        (each,) = chance.choices(rules, weights)
        soak.step(each.name, **{name: d.by_chance(chance) for name, d in each.inputs.items()})
    return soak.finish_life()


def random_lives(
    soak_type: type[Soak],
    seed: int,
    faults: Faults,
    commands: int,
    life_commands: int = LIFE_COMMANDS,
    progress: Callable[[Report], None] = lambda _: None,
) -> Report:
    """Lives with one seed after the other. Raises ``ViolationError``, which says how to see it again."""
    total = Report(soak_type.NAME)
    began = time.monotonic()
    while total.commands < commands:
        wanted = min(life_commands, commands - total.commands)
        try:
            total.add(random_life(soak_type, seed, faults, wanted))
        except ViolationError as violation:
            raise ViolationError(f"{violation}\nagain: --seed {seed} --commands {wanted}") from violation
        seed += 1
        total.seconds = time.monotonic() - began
        progress(total)
    return total
