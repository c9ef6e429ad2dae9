"""Makes what is generated from the tables in spec/, or with --check says what is not current.

python -m tools.generate [--check]
"""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from tools.generators import coverage, frame, primitives, simple, walter, words
from tools.generators.python import ROOT

if TYPE_CHECKING:
    from pathlib import Path

GENERATORS = (coverage, frame, primitives, simple, walter, words)


def files() -> dict[Path, str]:
    """All generated files and what they must contain."""
    return {path: text for generator in GENERATORS for path, text in generator.files().items()}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit 1 if something is not current"
    )
    check = parser.parse_args().check
    stale = [
        (path, text) for path, text in files().items() if not path.exists() or path.read_text("utf-8") != text
    ]
    for path, text in stale:
        if check:
            print(f"not current: {path.relative_to(ROOT)} (run `make generate`)", file=sys.stderr)
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, "utf-8")
            print(f"written: {path.relative_to(ROOT)}")
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
