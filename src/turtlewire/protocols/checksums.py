"""CRC-8: the catalogue's algorithms by name, and which of them a capture was made with (F2)."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

import fastcrc

from turtlewire.errors import DataError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable


class Algorithm(NamedTuple):
    """A CRC-8 as the catalogue of parametrised CRC algorithms describes it.

    ``reflected`` is both refin and refout, which agree in all of these. ``check`` is the CRC of the nine
    characters ``123456789``. ``crc`` computes it.
    """

    name: str
    poly: int
    init: int
    reflected: bool
    xorout: int
    check: int
    crc: Callable[[bytes], int]

    @property
    def residue(self) -> int:
        """What ``crc`` gives for any bytes followed by their own CRC."""
        return self.crc(bytes([self.crc(b"")]))

    def table(self) -> bytes:
        """What a register of 0 becomes by each byte: next register = table[register ^ byte]."""
        zero = self.crc(b"\0")
        return bytes(self.crc(bytes([byte])) ^ zero for byte in range(256))


_CRC8 = fastcrc.crc8
_PLAIN, _REFLECTED = False, True
CATALOGUE = {
    algorithm.name: algorithm
    for algorithm in (
        Algorithm("CRC-8/AUTOSAR", 0x2F, 0xFF, _PLAIN, 0xFF, 0xDF, _CRC8.autosar),
        Algorithm("CRC-8/BLUETOOTH", 0xA7, 0x00, _REFLECTED, 0x00, 0x26, _CRC8.bluetooth),
        Algorithm("CRC-8/CDMA2000", 0x9B, 0xFF, _PLAIN, 0x00, 0xDA, _CRC8.cdma2000),
        Algorithm("CRC-8/DARC", 0x39, 0x00, _REFLECTED, 0x00, 0x15, _CRC8.darc),
        Algorithm("CRC-8/DVB-S2", 0xD5, 0x00, _PLAIN, 0x00, 0xBC, _CRC8.dvb_s2),
        Algorithm("CRC-8/GSM-A", 0x1D, 0x00, _PLAIN, 0x00, 0x37, _CRC8.gsm_a),
        Algorithm("CRC-8/GSM-B", 0x49, 0x00, _PLAIN, 0xFF, 0x94, _CRC8.gsm_b),
        Algorithm("CRC-8/I-432-1", 0x07, 0x00, _PLAIN, 0x55, 0xA1, _CRC8.i_432_1),
        Algorithm("CRC-8/I-CODE", 0x1D, 0xFD, _PLAIN, 0x00, 0x7E, _CRC8.i_code),
        Algorithm("CRC-8/LTE", 0x9B, 0x00, _PLAIN, 0x00, 0xEA, _CRC8.lte),
        Algorithm("CRC-8/MAXIM-DOW", 0x31, 0x00, _REFLECTED, 0x00, 0xA1, _CRC8.maxim_dow),
        Algorithm("CRC-8/MIFARE-MAD", 0x1D, 0xC7, _PLAIN, 0x00, 0x99, _CRC8.mifare_mad),
        Algorithm("CRC-8/NRSC-5", 0x31, 0xFF, _PLAIN, 0x00, 0xF7, _CRC8.nrsc_5),
        Algorithm("CRC-8/OPENSAFETY", 0x2F, 0x00, _PLAIN, 0x00, 0x3E, _CRC8.opensafety),
        Algorithm("CRC-8/ROHC", 0x07, 0xFF, _REFLECTED, 0x00, 0xD0, _CRC8.rohc),
        Algorithm("CRC-8/SAE-J1850", 0x1D, 0xFF, _PLAIN, 0xFF, 0x4B, _CRC8.sae_j1850),
        Algorithm("CRC-8/SMBUS", 0x07, 0x00, _PLAIN, 0x00, 0xF4, _CRC8.smbus),
        Algorithm("CRC-8/TECH-3250", 0x1D, 0xFF, _REFLECTED, 0x00, 0x97, _CRC8.tech_3250),
        Algorithm("CRC-8/WCDMA", 0x9B, 0x00, _REFLECTED, 0x00, 0x25, _CRC8.wcdma),
    )
}


def algorithm(name: str) -> Algorithm:
    """An algorithm by its catalogue name: ``CRC-8/SMBUS``, or just ``smbus``. Plain ``CRC-8`` is SMBUS.

    Raises ``DataError`` naming those that there are.
    """
    full = name.upper()
    if full == "CRC-8":
        full = "CRC-8/SMBUS"
    elif not full.startswith("CRC-8/"):
        full = f"CRC-8/{full}"
    if full not in CATALOGUE:
        raise DataError(f"there is no CRC {name!r}; known are {', '.join(CATALOGUE)}")
    return CATALOGUE[full]


class Coverage(Enum):
    """Where the bytes of a frame begin that its CRC covers; they end before the CRC."""

    MAGIC = "magic"
    SEQ = "seq"
    SIZE = "size"
    PAYLOAD = "payload"

    @property
    def first(self) -> int:
        """The index in the frame of the first byte that is covered."""
        return list(Coverage).index(self)


class Checksum(NamedTuple):
    """An algorithm, and what of a frame it covers."""

    algorithm: Algorithm
    coverage: Coverage

    def __str__(self) -> str:
        return f"{self.algorithm.name} from {self.coverage.value}"

    def fits(self, frame: bytes) -> bool:
        """Whether the last byte of a whole frame is its CRC."""
        return self.algorithm.crc(frame[self.coverage.first :]) == self.algorithm.residue


CHECKSUMS = tuple(Checksum(algorithm, coverage) for coverage in Coverage for algorithm in CATALOGUE.values())


def fitting(frames: Iterable[bytes]) -> list[Checksum]:
    """Which algorithms and coverages fit all of these whole frames (magic to CRC).

    Every frame of other content and size rules out all but 1 in 256 of the wrong ones: a dozen frames of two sizes
    leave one. Of no frames, all are left.
    """
    left = list(CHECKSUMS)
    for frame in frames:
        left = [checksum for checksum in left if checksum.fits(frame)]
    return left
