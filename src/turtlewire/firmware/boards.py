"""The boards that firmware is built for."""

from __future__ import annotations

from typing import NamedTuple


class Board(NamedTuple):
    """A board with an AVR.

    Attributes:
        name: what people call it here.
        fqbn: what Arduino's tools call it.
        chip: for the compiler and avrdude.
        macro: what sketches can test for, as ``ARDUINO_AVR_UNO``.
        variant: the folder of its pins in Arduino's core.
        flash_bytes, ram_bytes: what a program may use; the bootloader's part of the flash is not counted.
        bootloader: what avrdude calls it.
        baud: of the bootloader.
    """

    name: str
    fqbn: str
    chip: str
    macro: str
    variant: str
    flash_bytes: int
    ram_bytes: int
    bootloader: str
    baud: int


FREQUENCY_HZ = 16_000_000
BOARDS = {
    board.name: board
    for board in (
        Board("uno", "arduino:avr:uno", "atmega328p", "AVR_UNO", "standard", 32256, 2048, "arduino", 115200),
        Board(
            "nano",
            "arduino:avr:nano",
            "atmega328p",
            "AVR_NANO",
            "eightanaloginputs",
            30720,
            2048,
            "arduino",
            115200,
        ),
        # What Arduino's menus call the old bootloader: before 2018, and on many copies to this day.
        Board(
            "nano-old",
            "arduino:avr:nano:cpu=atmega328old",
            "atmega328p",
            "AVR_NANO",
            "eightanaloginputs",
            30720,
            2048,
            "arduino",
            57600,
        ),
        Board(
            "mega", "arduino:avr:mega", "atmega2560", "AVR_MEGA2560", "mega", 253952, 8192, "wiring", 115200
        ),
    )
}
