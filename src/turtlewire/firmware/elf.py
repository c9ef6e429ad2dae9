"""What a program takes on a chip, from its ELF file (System V ABI: the section headers; avr-libc: the addresses)."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from turtlewire.errors import DataError

if TYPE_CHECKING:
    from pathlib import Path

MAGIC = b"\x7fELF\x01\x01"  # 32 bits, lowest byte first
OCCUPIES_MEMORY = 2  # SHF_ALLOC
NO_CONTENT = 8  # SHT_NOBITS: .bss, .noinit
# Where avr-gcc puts RAM; above it are EEPROM, fuses and lock bits.
RAM, BEYOND_RAM = 0x800000, 0x810000


def sizes(elf: Path) -> tuple[int, int]:
    """How many bytes of flash and of RAM a program takes; what is initialised takes both. The stack is not counted.

    Raises ``DataError`` for what is no such file.
    """
    data = elf.read_bytes()
    try:
        if not data.startswith(MAGIC):
            raise ValueError
        (table,) = struct.unpack_from("<I", data, 32)
        size, count = struct.unpack_from("<HH", data, 46)
        flash_bytes = ram_bytes = 0
        for number in range(count):
            _, kind, flags, address, _, length = struct.unpack_from("<6I", data, table + number * size)
            if not flags & OCCUPIES_MEMORY or address >= BEYOND_RAM:
                continue
            flash_bytes += length if kind != NO_CONTENT else 0
            ram_bytes += length if address >= RAM else 0
    except (ValueError, struct.error):
        raise DataError(f"{elf} is no program for an AVR (ELF, 32 bits)") from None
    return flash_bytes, ram_bytes
