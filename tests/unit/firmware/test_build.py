"""Building, by the real tools: every sketch for every board, sketches of one's own, and what is wrong with some."""

from __future__ import annotations

import re
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.emulator.bootloader import intel_hex
from turtlewire.errors import DataError, OutputError, UsageError
from turtlewire.firmware import BOARDS, SKETCHES, build, find_sketch, library
from turtlewire.firmware.elf import sizes

if TYPE_CHECKING:
    from collections.abc import Callable

    from .conftest import ArduinoCli

AVR = 83  # EM_AVR
EMPTY = "void setup() {}\nvoid loop() {}\n"
# So many bytes, and what little it takes to use them.
HUGE = """\
#include <avr/pgmspace.h>
const char big[{0}] PROGMEM = {{1}};
void setup() {{ PORTB = pgm_read_byte(big + millis() % {0}); }}
void loop() {{}}
"""


def told_by_avr_size(elf: Path) -> tuple[int, int]:
    """Flash and RAM, as the compiler's own tool counts them."""
    told = subprocess.run(["avr-size", "-A", elf], capture_output=True, text=True, check=True).stdout
    parts = {name: int(size) for name, size in re.findall(r"^\.(\w+)\s+(\d+)", told, re.MULTILINE)}
    data = parts.get("data", 0)
    return parts["text"] + data, data + parts.get("bss", 0) + parts.get("noinit", 0)


@pytest.mark.parametrize("board", ["uno", "nano", "mega"])
@pytest.mark.parametrize("name", SKETCHES)
def test_every_sketch_for_every_board(name: str, board: str, tmp_path: Path) -> None:
    built = build(SKETCHES[name], BOARDS[board], tmp_path, "avr-gcc")
    assert built[:3] == (name, BOARDS[board], "avr-gcc")
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.elf", f"{name}.hex"}
    elf = built.elf.read_bytes()
    assert int.from_bytes(elf[18:20], "little") == AVR
    assert (built.flash_bytes, built.ram_bytes) == told_by_avr_size(built.elf)
    (piece,) = intel_hex(built.hex)
    assert (piece.address, len(piece.data)) == (0, built.flash_bytes)


def test_the_boards_are_those_of_the_core() -> None:
    """What we say of a board is what Arduino's own list says."""
    text = Path("/usr/share/arduino/hardware/arduino/avr/boards.txt").read_text("utf-8")
    known = dict(line.split("=", 1) for line in text.splitlines() if "=" in line and not line.startswith("#"))
    menus = {"nano": "atmega328", "nano-old": "atmega328old", "mega": "atmega2560"}
    for board in BOARDS.values():
        name = board.fqbn.split(":")[2]
        found = {key[len(name) + 1 :]: value for key, value in known.items() if key.startswith(f"{name}.")}
        menu = f"menu.cpu.{menus.get(board.name)}."
        found |= {key.removeprefix(menu): value for key, value in found.items() if key.startswith(menu)}
        assert board.chip == found["build.mcu"]
        assert board.macro == found["build.board"]
        assert board.variant == found["build.variant"]
        assert board.flash_bytes == int(found["upload.maximum_size"])
        assert board.ram_bytes == int(found["upload.maximum_data_size"])
        assert board.bootloader == found["upload.protocol"]
        assert board.baud == int(found["upload.speed"])


def test_arduino_builder_makes_as_much(tmp_path: Path) -> None:
    """Who builds in Arduino's IDE has what was tested here, but for the order in which it is linked."""
    made = [
        build(SKETCHES["SimpleCar"], BOARDS["uno"], tmp_path / tool, tool)
        for tool in ("avr-gcc", "arduino-builder")
    ]
    assert made[1].tool == "arduino-builder"
    assert made[0][-2:] == made[1][-2:]


@pytest.mark.parametrize("as_file", [False, True])
def test_a_sketch_of_ones_own(sketch: Callable[..., Path], tmp_path: Path, *, as_file: bool) -> None:
    """With what may lie beside it: another tab, C and C++, one of them named as a file of the library is."""
    folder = sketch(
        "Mine",
        '#include <Turtlewire.h>\n#include <avr/eeprom.h>\n#include "mine.h"\n'
        'uint8_t kept[7] __attribute__((section(".noinit")));\n'
        "uint16_t EEMEM stored = 5;\n"
        "void setup() { kept[0] = from_c() + from_cpp(); from_tab(); eeprom_update_word(&stored, kept[0]); }\n"
        "void loop() {}\n",
    )
    (folder / "mine.h").write_text(
        '#pragma once\n#include <stdint.h>\nint from_cpp();\nextern "C" int from_c(void);\nvoid from_tab();\n'
    )
    (folder / "simple.cpp").write_text('#include "mine.h"\nint from_cpp() { return 2; }\n')
    (folder / "plain.c").write_text("int from_c(void) { return 1; }\n")
    (folder / "tab.ino").write_text("void from_tab() { Serial.begin(turtlewire::simple::BAUD); }\n")
    found = find_sketch(str(folder / "Mine.ino" if as_file else folder))
    built = build(found, BOARDS["uno"], tmp_path / "out" / "deep", "avr-gcc")
    assert built.hex == tmp_path / "out" / "deep" / "Mine.hex"
    assert (built.flash_bytes, built.ram_bytes) == told_by_avr_size(built.elf)
    assert b"kept" in built.elf.read_bytes()


@pytest.mark.parametrize(
    ("text", "pieces"),
    [
        (
            "void setup() {\n  whatever();\n}\nvoid loop() {}\n",
            ("does not compile", "Broken.ino:2:", "whatever"),
        ),
        ("void nowhere();\nvoid setup() { nowhere(); }\nvoid loop() {}\n", ("does not link", "nowhere")),
        (
            "volatile char big[3000];\nvoid setup() { big[0] = 1; }\nvoid loop() {}\n",
            ("Broken is too big for the uno:\n", "region `data'"),
        ),
        (
            HUGE.format(31900),
            ("Broken takes 32", "bytes of flash, but the uno has 32256"),
        ),
        (
            HUGE.format(32767),
            ("Broken is too big for the uno:\n", "region `text'"),
        ),
    ],
)
def test_a_sketch_that_is_wrong(
    sketch: Callable[..., Path], tmp_path: Path, text: str, pieces: tuple[str, ...]
) -> None:
    with pytest.raises(DataError) as caught:
        build(find_sketch(str(sketch("Broken", text))), BOARDS["uno"], tmp_path / "out", "avr-gcc")
    for piece in pieces:
        assert piece in str(caught.value)
    assert not list((tmp_path / "out").iterdir()), "nothing to flash by mistake"


def test_too_many_variables(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"SimpleCar takes 2\d\d bytes of RAM, but the uno has 200"):
        build(SKETCHES["SimpleCar"], BOARDS["uno"]._replace(ram_bytes=200), tmp_path, "avr-gcc")


def test_what_fits_on_an_uno_does_not_on_a_nano(sketch: Callable[..., Path], tmp_path: Path) -> None:
    """Their bootloaders differ: a Nano's takes 2 KB."""
    found = find_sketch(str(sketch("Big", HUGE.format(30500))))
    assert 30720 < build(found, BOARDS["uno"], tmp_path, "avr-gcc").flash_bytes < 32256
    for board in ("nano", "nano-old"):
        with pytest.raises(DataError, match=f"the {board} has 30720"):
            build(found, BOARDS[board], tmp_path, "avr-gcc")


@pytest.mark.parametrize("text", ["Nonsense", "simplecar", "/nowhere/x.ino", str(library())])
def test_there_is_no_such_sketch(text: str) -> None:
    with pytest.raises(UsageError, match="FrameRobot, SimpleCar, Walter, WalterBasic, or the path") as caught:
        find_sketch(text)
    assert repr(text) in str(caught.value)


def test_nothing_to_build_with(no_tools: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for tool in (None, "avr-gcc", "arduino-builder", "arduino-cli"):
        with pytest.raises(UsageError, match="apt install gcc-avr") as caught:
            build(SKETCHES["SimpleCar"], BOARDS["uno"], tmp_path, tool)
        assert (tool or "nothing to build") in str(caught.value)
    monkeypatch.undo()
    monkeypatch.setenv("ARDUINO_AVR_CORE", str(tmp_path / "no-core"))
    with pytest.raises(UsageError, match="avr-gcc is not there"):
        build(SKETCHES["SimpleCar"], BOARDS["uno"], tmp_path, "avr-gcc")


def test_many_at_once_with_nothing_kept_yet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Arduino's core is made once for them all, and is not exchanged under the linker of another."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "empty"))
    with ThreadPoolExecutor(4) as threads:
        made = list(
            threads.map(
                lambda name: build(SKETCHES[name], BOARDS["uno"], tmp_path / name, "avr-gcc"), SKETCHES
            )
        )
    assert [built.sketch for built in made] == list(SKETCHES)
    (kept,) = (tmp_path / "empty" / "turtlewire").iterdir()
    assert kept.suffix == ".a"
    before = kept.stat()
    build(SKETCHES["SimpleCar"], BOARDS["uno"], tmp_path / "again", "avr-gcc")
    assert (kept.stat().st_ino, kept.stat().st_mtime_ns) == (before.st_ino, before.st_mtime_ns)


def test_a_home_without_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """FAT and some network drives have none."""

    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "empty"))
    monkeypatch.setattr("os.link", refuse)
    build(SKETCHES["SimpleCar"], BOARDS["uno"], tmp_path, "avr-gcc")
    assert [path.suffix for path in (tmp_path / "empty" / "turtlewire").iterdir()] == [".a"]


def test_a_compiler_that_is_not_all_there(no_tools: Path, tmp_path: Path) -> None:
    for name in ("avr-gcc", "avr-g++", "avr-gcc-ar"):
        (no_tools / name).symlink_to(f"/usr/bin/{name}")
    with pytest.raises(UsageError, match="avr-gcc is not there"):
        build(SKETCHES["SimpleCar"], BOARDS["uno"], tmp_path, "avr-gcc")


def test_nowhere_to_write(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=r"cannot build in .*file/folder: Not a directory"):
        build(SKETCHES["SimpleCar"], BOARDS["uno"], tmp_path / "file" / "folder", "avr-gcc")


def test_by_arduino_cli(arduino_cli: ArduinoCli, tmp_path: Path, sketch: Callable[..., Path]) -> None:
    folder = sketch("Mine", EMPTY)
    built = build(find_sketch(str(folder)), BOARDS["nano-old"], tmp_path / "out")
    assert built.tool == "arduino-cli"
    assert built.flash_bytes > 2000
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"Mine.elf", "Mine.hex"}
    ((command, *options),) = arduino_cli.calls
    assert command == "compile"
    assert options[:4] == ["--fqbn", "arduino:avr:nano:cpu=atmega328old", "--library", str(library())]
    assert options[-1] == str(folder)
    arduino_cli.then("Mine.ino:1: error: it is monday", 1)
    with pytest.raises(DataError, match=r"(?s)Mine does not compile:\n.*it is monday"):
        build(find_sketch(str(folder)), BOARDS["uno"], tmp_path / "out")


@pytest.mark.parametrize("damage", [b"", b"\x7fELF\x02\x01", b"\x7fELF\x01\x01" + b"\xff" * 60])
def test_no_program(tmp_path: Path, damage: bytes) -> None:
    (tmp_path / "x.elf").write_bytes(damage)
    with pytest.raises(DataError, match="is no program for an AVR"):
        sizes(tmp_path / "x.elf")
