"""The firmware's C++ is what cppcheck, clang-tidy and the chip's own compiler want."""

from __future__ import annotations

import re
import shutil
import subprocess
from typing import TYPE_CHECKING

import pytest

from .core import INSTANTIATED, LIBRARY, RUNNER, SOURCES

if TYPE_CHECKING:
    from pathlib import Path

FUZZERS = sorted((LIBRARY / "extras" / "fuzz").glob("*.cpp"))
SKETCHES = sorted((LIBRARY / "examples").glob("*/*.ino"))
CHECKS = (
    "--enable=warning,style,performance,portability",
    "--std=c++11",
    "--inline-suppr",
    "--error-exitcode=1",
)


def run(tool: str, *arguments: str) -> None:
    assert shutil.which(tool), f"no {tool}: make tools installs it"
    done = subprocess.run([tool, *arguments], capture_output=True, text=True, check=False, cwd=LIBRARY)
    assert done.returncode == 0, done.stdout + done.stderr


def test_cppcheck_finds_nothing_in_the_core_and_its_tests() -> None:
    # The models are loops rather than algorithms, to be read beside the protocol's page.
    sources = map(str, [INSTANTIATED, RUNNER, *SOURCES, *FUZZERS])
    run("cppcheck", *CHECKS, "--quiet", "--suppress=useStlAlgorithm", *sources)


@pytest.mark.parametrize("sketch", SKETCHES, ids=lambda sketch: sketch.stem)
def test_cppcheck_finds_nothing_in_a_sketch(sketch: Path) -> None:
    # Arduino's headers are the chip's: cppcheck does without. A setting (WATCHDOG_MS) may make a condition constant.
    chip = ("--platform=avr8", "-D__AVR_ATmega328P__", "-DF_CPU=16000000UL", "-DARDUINO=10808")
    quiet = ("--quiet", "--suppress=missingInclude", "--suppress=knownConditionTrueFalse")
    run("cppcheck", *CHECKS, *quiet, *chip, "--language=c++", "-Isrc", str(sketch))


@pytest.mark.parametrize("source", [INSTANTIATED, *SOURCES], ids=lambda source: source.stem)
def test_clang_tidy_finds_nothing(source: Path) -> None:
    run("clang-tidy", "--quiet", str(source), "--", "-std=c++11")


@pytest.mark.parametrize("chip", ["atmega328p", "atmega2560"])
@pytest.mark.parametrize("source", [INSTANTIATED, *SOURCES], ids=lambda source: source.stem)
def test_the_chips_compiler_warns_of_nothing(source: Path, chip: str, tmp_path: Path) -> None:
    """Where an int has 16 bits, promotions are others."""
    warnings = ("-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Wshadow", "-Werror")
    target = ("-std=c++11", "-Os", f"-mmcu={chip}", "-fno-exceptions", "-c", "-o", str(tmp_path / "object.o"))
    run("avr-g++", *target, *warnings, str(source))


def test_the_core_has_no_heap_no_arduino_and_no_text() -> None:
    for path in sorted((LIBRARY / "src" / "turtlewire").glob("*.*")):
        code = re.sub(r"//.*", "", path.read_text("utf-8"))
        assert set(re.findall(r"#include <(.*)>", code)) <= {"stdint.h", "string.h"}, path
        assert not re.search(r"\b(new|delete|malloc|free|String|virtual|throw|try)\b", code), path


PROPERTIES = "name version author maintainer sentence paragraph category url architectures includes"
CATEGORIES = (
    "Display",
    "Communication",
    "Signal Input/Output",
    "Sensors",
    "Device Control",
    "Timing",
    "Data Storage",
    "Data Processing",
    "Other",
)


def test_the_library_describes_itself_as_arduino_wants() -> None:
    """Arduino's library specification 1.5, as far as arduino-lint's rules are mechanical."""
    lines = (LIBRARY / "library.properties").read_text("utf-8").splitlines()
    described = dict(line.split("=", 1) for line in lines)
    assert len(described) == len(lines)
    # The IDE refuses a library without any of these. The url may be empty: for as long as there is no public page.
    assert set(described) == set(PROPERTIES.split())
    assert all(value.strip() for name, value in described.items() if name != "url")
    assert re.fullmatch(r"[A-Za-z0-9][\w .-]{0,62}", described["name"], re.ASCII)
    assert re.fullmatch(r"\d+\.\d+\.\d+", described["version"])
    assert described["category"] in CATEGORIES
    assert re.fullmatch(r"(https://.+)?", described["url"])
    assert not described["paragraph"].startswith(described["sentence"])
    for header in described["includes"].split(","):
        assert (LIBRARY / "src" / header).is_file()
    for sketch in SKETCHES:
        assert sketch.stem == sketch.parent.name


def test_the_keywords_are_laid_out_with_tabs_and_exist() -> None:
    code = "\n".join(path.read_text("utf-8") for path in sorted((LIBRARY / "src").rglob("*.h")))
    for line in (LIBRARY / "keywords.txt").read_text("utf-8").splitlines():
        assert re.fullmatch(r"\w+\t(KEYWORD1|KEYWORD2|LITERAL1)", line, re.ASCII), line
        assert re.search(rf"\b{line.split()[0]}\b", code), line
