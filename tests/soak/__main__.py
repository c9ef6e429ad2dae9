"""Soak a driver: ``python -m tests.soak simple --commands 100000``. Everything is decided by the seed."""

from __future__ import annotations

import argparse
import json
import sys
from typing import TYPE_CHECKING

from tests.soak.lives import LIFE_COMMANDS, SOAKS, random_lives
from tests.soak.wire import ViolationError
from turtlewire.links.faults import Faults

if TYPE_CHECKING:
    from tests.soak.report import Report

ONE_PERCENT = "lose:0.0033,add:0.0033,flip:0.0034"


def main() -> int:
    """Returns 0, or 1 when something happened that must not."""
    parser = argparse.ArgumentParser(prog="python -m tests.soak", description=__doc__)
    parser.add_argument("robot", choices=list(SOAKS))
    parser.add_argument("--commands", type=int, default=100_000, help="of the driver (default %(default)s)")
    parser.add_argument(
        "--faults", type=Faults.parse, default=ONE_PERCENT, help="as in a URL (default %(default)s)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the first life (default %(default)s)")
    parser.add_argument(
        "--life", type=int, default=LIFE_COMMANDS, help="commands of a life (default %(default)s)"
    )
    parser.add_argument("--json", action="store_true", help="the figures as JSON")
    options = parser.parse_args()

    def progress(report: Report) -> None:
        if sys.stderr.isatty():
            print(f"\r{report.robot}: {report.commands:,} commands", end="", file=sys.stderr, flush=True)

    try:
        report = random_lives(
            SOAKS[options.robot], options.seed, options.faults, options.commands, options.life, progress
        )
    except ViolationError as violation:
        print(f"\n{violation} --life {options.life}", file=sys.stderr)
        return 1
    if sys.stderr.isatty():
        print(file=sys.stderr)
    print(json.dumps(report.as_dict(), indent=2) if options.json else report.table())
    return 0


if __name__ == "__main__":
    sys.exit(main())
