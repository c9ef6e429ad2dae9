"""libFuzzer against the core: any bytes, judged by the models in extras/fuzz. 10^8 inputs each by ``make nightly``."""

from __future__ import annotations

import shutil
import subprocess
from typing import TYPE_CHECKING

import pytest

from .core import LIBRARY, SANITIZERS, WARNINGS
from .expected import GROUP_BITS, to_robot

if TYPE_CHECKING:
    from pathlib import Path

SECONDS = 6
NIGHTLY_INPUTS = 100_000_000
LIMITS = ("-max_len=400", "-timeout=10", "-seed=1", "-print_final_stats=1")
TARGETS = ("simple", "walter", "frame")
DIALECTS = {"0.1": 0, "0.1-literal": 1, "telemetry": 2}
# A mistake in the core for each, which has to be found: a file, what stands there, what is made of it.
PLANTED = {
    "simple": ("simple.cpp", "text[at] > '9'", "text[at] > ':'"),
    "walter": ("walter.cpp", "if (byte == LF) {", "if (byte == LF && mode_ == LOGO) {"),
    "frame": ("frame.h", "start[2] > MAX_PAYLOAD", "start[2] > MAX_FRAME"),
}
each_target = pytest.mark.parametrize("target", TARGETS)


def build_fuzzer(folder: Path, target: str, library: Path = LIBRARY) -> Path:
    """Compile a target with the core."""
    clang = shutil.which("clang++")
    assert clang, "no clang++: install clang and libclang-rt-14-dev (make tools)"
    program = folder / f"fuzz-{target}"
    sources = [library / "extras" / "fuzz" / f"{target}.cpp", *(library / "src" / "turtlewire").glob("*.cpp")]
    flags = ["-std=c++11", "-g", "-O2", "-fsanitize=fuzzer", *SANITIZERS, *WARNINGS, "-Wno-sign-conversion"]
    made = subprocess.run(
        [clang, *flags, *map(str, sources), "-o", str(program)], capture_output=True, text=True, check=False
    )
    assert made.returncode == 0, made.stderr
    return program


def seeds(folder: Path, target: str) -> Path:
    """A corpus of the vectors: before each, what the target's input begins with."""
    corpus = folder / "corpus"
    corpus.mkdir()
    for number, vector in enumerate(to_robot(target)):
        if target == "simple":
            head = bytes([vector.get("extensions", False)])
        elif target == "walter":
            groups = sum(GROUP_BITS[group] for group in vector.get("groups", GROUP_BITS))
            head = bytes([(vector["mode"] == "direct") + 2 * groups, *bytes(8)])
        else:
            head = bytes([DIALECTS.get(vector["dialect"], 0), *bytes(8)])
        (corpus / str(number)).write_bytes(head + bytes.fromhex(vector["bytes"]))
    return corpus


def fuzz(program: Path, corpus: Path, *options: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [program, *LIMITS, *options, corpus],
        capture_output=True,
        text=True,
        check=False,
        cwd=program.parent,
        errors="replace",
    )


@each_target
def test_a_short_run(target: str, tmp_path: Path) -> None:
    done = fuzz(build_fuzzer(tmp_path, target), seeds(tmp_path, target), f"-max_total_time={SECONDS}")
    assert done.returncode == 0, done.stderr
    assert "Done " in done.stderr


@pytest.mark.nightly
@pytest.mark.timeout(6 * 3600)
@each_target
def test_a_long_run(target: str, tmp_path: Path) -> None:
    done = fuzz(build_fuzzer(tmp_path, target), seeds(tmp_path, target), f"-runs={NIGHTLY_INPUTS}")
    assert done.returncode == 0, done.stderr
    assert f"Done {NIGHTLY_INPUTS} runs" in done.stderr


@each_target
def test_a_planted_mistake_is_found(target: str, tmp_path: Path) -> None:
    library = tmp_path / "Turtlewire"
    shutil.copytree(LIBRARY, library)
    file, right, wrong = PLANTED[target]
    path = library / "src" / "turtlewire" / file
    text = path.read_text("utf-8")
    assert text.count(right) == 1
    path.write_text(text.replace(right, wrong), "utf-8")
    done = fuzz(build_fuzzer(tmp_path, target, library), seeds(tmp_path, target), "-runs=3000000")
    assert done.returncode != 0
    assert "not true" in done.stderr or "ERROR" in done.stderr or "runtime error" in done.stderr
