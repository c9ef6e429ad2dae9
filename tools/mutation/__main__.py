"""Mutate the firmware's core: ``python -m tools.mutation [--sample N] [--file NAME] [--json]``.

Reports the score, and file and line of each mistake that the fixed inputs of tests/firmware do not notice. Those in
``equivalent.toml`` are no mistakes: they do the same, for the reason that stands there. Exit code 0 if no other
survived and the list is true, 1 otherwise.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

from tests.firmware.fixed_inputs import fixed
from tools.mutation.core import FILES, Report, all_mutants, equivalents
from tools.mutation.trial import Trials, Verdict


def main() -> int:
    """Try the mutants and report."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.mutation", description="mutate the firmware's core"
    )
    parser.add_argument("--sample", type=int, help="only so many mutants, always the same")
    parser.add_argument("--file", choices=FILES, action="append", help="only mutants of this file")
    parser.add_argument("--json", action="store_true", help="report as JSON")
    given = parser.parse_args()
    mutants = [mutant for mutant in all_mutants() if not given.file or mutant.file in given.file]
    if given.sample is not None:
        mutants = random.Random(1).sample(mutants, min(given.sample, len(mutants)))
    inputs = fixed()
    trials: SimpleQueue[Trials] = SimpleQueue()
    with tempfile.TemporaryDirectory(prefix="turtlewire-mutation-") as folder:
        workers = os.cpu_count() or 1
        for number in range(workers):
            trials.put(Trials(Path(folder) / str(number), inputs))
        with ThreadPoolExecutor(workers) as pool:

            def tried(place: int) -> Verdict:
                mine = trials.get()
                try:
                    verdict = mine.try_out(mutants[place])
                finally:
                    trials.put(mine)
                # It takes minutes: what survives is told at once.
                if verdict is Verdict.SURVIVED:
                    print(
                        f"{place + 1} of {len(mutants)} survived: {mutants[place]}",
                        file=sys.stderr,
                        flush=True,
                    )
                return verdict

            verdicts = list(pool.map(tried, range(len(mutants))))
    report = Report(dict(zip(mutants, verdicts, strict=True)), equivalents())
    print(json.dumps(report.data(), indent=2) if given.json else report.text())
    return 0 if report.is_good() else 1


if __name__ == "__main__":
    sys.exit(main())
