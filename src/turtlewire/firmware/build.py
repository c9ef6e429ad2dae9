"""Building a sketch, by whichever tool is there: arduino-cli, arduino-builder, or avr-gcc and Arduino's core."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.errors import DataError, OutputError, UsageError
from turtlewire.firmware.boards import FREQUENCY_HZ, Board
from turtlewire.firmware.elf import sizes
from turtlewire.firmware.sketches import Sketch, library

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

# Where distributions put Arduino's core; the variable names another place.
CORE_VARIABLE = "ARDUINO_AVR_CORE"
HARDWARE = Path("/usr/share/arduino/hardware")
# Where Debian puts what arduino-builder needs to know about its own helpers.
BUILDER = Path("/usr/share/arduino-builder")
TOOLS_ADVICE = (
    "install arduino-cli (https://arduino.github.io/arduino-cli, then `arduino-cli core install arduino:avr`), or on "
    "Debian and Ubuntu `apt install gcc-avr avr-libc binutils-avr arduino-core-avr avrdude`"
)
TOOLCHAIN = ("avr-gcc", "avr-g++", "avr-gcc-ar", "avr-objcopy")
# What Arduino's own tools use, so that a program is the same whoever builds it.
OPTIMISE = ["-Os", "-ffunction-sections", "-fdata-sections", "-flto", "-fno-fat-lto-objects"]
# The core of 1.8.x names a macro that avr-gcc 5.4 has under another name only.
CPP = ["-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics", "-DDECIMAL_DIG=__DECIMAL_DIG__"]


class Built(NamedTuple):
    """A program for a board.

    Attributes:
        sketch: its name; board: what for; tool: what built it.
        elf, hex: the files, the second for flashing.
        flash_bytes, ram_bytes: what it takes; of RAM, variables only, not the stack.
    """

    sketch: str
    board: Board
    tool: str
    elf: Path
    hex: Path
    flash_bytes: int
    ram_bytes: int


def build(sketch: Sketch, board: Board, folder: Path, tool: str | None = None) -> Built:
    """Build a sketch into a folder.

    Args:
        sketch: what to build.
        board: what for.
        folder: where the files go, made if need be.
        tool: ``arduino-cli``, ``arduino-builder`` or ``avr-gcc``; None: the first of them that is there.

    Raises ``UsageError`` (no tool), ``DataError`` (the sketch does not compile, or does not fit on the board; what the
    compiler said is in the message) or ``OutputError``.
    """
    name = tool or next((name for name in BUILDERS if is_there(name)), None)
    if name is None:
        raise UsageError(f"there is nothing to build firmware with: {TOOLS_ADVICE}")
    if name not in BUILDERS or not is_there(name):
        raise UsageError(f"{name} is not there: {TOOLS_ADVICE}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix="turtlewire-") as work:
            made = BUILDERS[name](sketch, board, Path(work))
            flash_bytes, ram_bytes = sizes(made[0])
            _check_fit(sketch, board, flash_bytes, ram_bytes)
            elf, hex_file = (Path(shutil.copy(path, folder / f"{sketch.name}{path.suffix}")) for path in made)
    except OSError as error:
        raise OutputError(f"cannot build in {error.filename or folder}: {error.strerror or error}") from error
    return Built(sketch.name, board, name, elf, hex_file, flash_bytes, ram_bytes)


def _check_fit(sketch: Sketch, board: Board, flash_bytes: int, ram_bytes: int) -> None:
    for used, most, what in ((flash_bytes, board.flash_bytes, "flash"), (ram_bytes, board.ram_bytes, "RAM")):
        if used > most:
            raise DataError(f"{sketch.name} takes {used} bytes of {what}, but the {board.name} has {most}")


def is_there(tool: str) -> bool:
    """Whether a tool, and what it needs, is on this computer."""
    if tool == "arduino-cli":
        return shutil.which(tool) is not None
    needed = [tool, *TOOLCHAIN]
    return all(shutil.which(each) for each in needed) and core().is_dir()


def core() -> Path:
    """The folder of Arduino's core for AVR."""
    return Path(os.environ.get(CORE_VARIABLE, HARDWARE / "arduino" / "avr"))


def run(command: Sequence[str], failure: str = "") -> str:
    """Run a tool; what it printed. Raises ``DataError`` with what it complained of."""
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    if done.returncode:
        raise DataError(f"{failure or f'{command[0]} failed'}:\n{(done.stderr or done.stdout).strip()}")
    return done.stdout


def _by_arduino_cli(sketch: Sketch, board: Board, work: Path) -> tuple[Path, Path]:
    command = ["arduino-cli", "compile", "--fqbn", board.fqbn, "--library", str(library())]
    run([*command, "--output-dir", str(work), str(sketch.path.parent)], f"{sketch.name} does not compile")
    return work / f"{sketch.path.name}.elf", work / f"{sketch.path.name}.hex"


def _by_arduino_builder(sketch: Sketch, board: Board, work: Path) -> tuple[Path, Path]:
    command = ["arduino-builder", "-compile", "-fqbn", board.fqbn, "-build-path", str(work)]
    for folder in (core().parents[1], BUILDER):
        command += ["-hardware", str(folder)]
    command += ["-tools", str(BUILDER), "-tools", "/usr/bin", "-libraries", str(library().parent)]
    command += ["-prefs=runtime.tools.avr-gcc.path=/usr"]
    command += ["-prefs=compiler.cpp.extra_flags=-DDECIMAL_DIG=__DECIMAL_DIG__", str(sketch.path)]
    run(command, f"{sketch.name} does not compile")
    return work / f"{sketch.path.name}.elf", work / f"{sketch.path.name}.hex"


def _by_avr_gcc(sketch: Sketch, board: Board, work: Path) -> tuple[Path, Path]:
    """Arduino's core as an archive, our sources with all warnings, the sketch; linked together."""
    archive = _core_archive(board)
    (work / "library").mkdir()
    beside = sorted(path for path in sketch.path.parent.iterdir() if path.suffix in (".c", ".cpp", ".S"))
    ours = sorted((library() / "src" / "turtlewire").glob("*.cpp"))
    sources = [(path, work) for path in (_joined(sketch, work), *beside)]
    sources += [(path, work / "library") for path in ours]
    objects = [
        str(_compiled(source, board, place, "-Wall", "-Wextra", f"-I{sketch.path.parent}", name=sketch.name))
        for source, place in sources
    ]
    elf, hex_file = work / f"{sketch.name}.elf", work / f"{sketch.name}.hex"
    link = ["avr-gcc", "-Os", "-flto", "-fuse-linker-plugin", "-Wl,--gc-sections", f"-mmcu={board.chip}"]
    try:
        run([*link, "-o", str(elf), *objects, str(archive), "-lm"], f"{sketch.name} does not link")
    except DataError as error:
        _, _, said = str(error).partition("\n")
        if re.search("region `(text|data)'", said):
            raise DataError(f"{sketch.name} is too big for the {board.name}:\n{said}") from None
        raise
    run(["avr-objcopy", "-O", "ihex", "-R", ".eeprom", str(elf), str(hex_file)])
    return elf, hex_file


def _joined(sketch: Sketch, work: Path) -> Path:
    """A sketch as C++: Arduino's header, its main file, then the others by name. Prototypes it has to write itself."""
    others = sorted(path for path in sketch.path.parent.glob("*.ino") if path.name != sketch.path.name)
    made = work / f"{sketch.name}.ino.cpp"
    text = "".join(
        f"#line 1 {json.dumps(str(path))}\n{path.read_text('utf-8', 'replace')}\n"
        for path in (sketch.path, *others)
    )
    made.write_text(f"#include <Arduino.h>\n{text}", "utf-8")
    return made


def _compiled(source: Path, board: Board, work: Path, *flags: str, name: str) -> Path:
    made = work / f"{source.name}.o"
    is_c = source.suffix == ".c"
    language = ["avr-gcc", "-std=gnu11"] if is_c else ["avr-g++", *CPP]
    if source.suffix == ".S":
        language = ["avr-gcc", "-x", "assembler-with-cpp"]
    defines = [
        f"-DF_CPU={FREQUENCY_HZ}L",
        "-DARDUINO=10819",
        f"-DARDUINO_{board.macro}",
        "-DARDUINO_ARCH_AVR",
    ]
    folders = [core() / "cores" / "arduino", core() / "variants" / board.variant, library() / "src"]
    includes = [f"-I{folder}" for folder in folders]
    optimise = [] if source.suffix == ".S" else OPTIMISE
    command = [*language, *flags, *optimise, f"-mmcu={board.chip}", *defines, *includes]
    run([*command, "-c", str(source), "-o", str(made)], f"{name} does not compile")
    return made


def _core_archive(board: Board) -> Path:
    """Arduino's core for a board, built once and kept."""
    sources = sorted(
        path for path in (core() / "cores" / "arduino").iterdir() if path.suffix in (".c", ".cpp", ".S")
    )
    newest = max(path.stat().st_mtime_ns for path in sources)
    kept = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "turtlewire"
    archive = kept / f"arduino-{board.name}-{newest:x}.a"
    if archive.exists():
        return archive
    kept.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(prefix="new-", dir=kept) as work:
        objects = [
            str(_compiled(source, board, Path(work), "-w", name="Arduino's core")) for source in sources
        ]
        made = Path(work) / archive.name
        run(["avr-gcc-ar", "rcs", str(made), *objects])
        # One that is there already may be in use: the linker opens it again and again, and no two are the same.
        try:
            os.link(made, archive)
        except FileExistsError:
            pass
        except OSError:  # a file system without links
            made.replace(archive)
    return archive


BUILDERS: dict[str, Callable[[Sketch, Board, Path], tuple[Path, Path]]] = {
    "arduino-cli": _by_arduino_cli,
    "avr-gcc": _by_avr_gcc,
    "arduino-builder": _by_arduino_builder,
}
