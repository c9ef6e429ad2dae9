from __future__ import annotations

import pytest

from turtlewire.errors import DataError
from turtlewire.protocols.checksums import (
    CATALOGUE,
    CHECKSUMS,
    Algorithm,
    Checksum,
    Coverage,
    algorithm,
    fitting,
)

# From the catalogue of parametrised CRC algorithms: the CRC of "123456789".
CHECKS = {
    "CRC-8/SMBUS": 0xF4,
    "CRC-8/MAXIM-DOW": 0xA1,
    "CRC-8/AUTOSAR": 0xDF,
    "CRC-8/SAE-J1850": 0x4B,
    "CRC-8/ROHC": 0xD0,
    "CRC-8/CDMA2000": 0xDA,
}

each_algorithm = pytest.mark.parametrize("one", CATALOGUE.values(), ids=list(CATALOGUE))


def bit_by_bit(one: Algorithm, data: bytes) -> int:
    register = one.init
    for byte in data:
        for n in range(8):
            bit = byte >> (n if one.reflected else 7 - n) & 1
            out = register >> 7 ^ bit
            register = register << 1 & 0xFF ^ (one.poly if out else 0)
    if one.reflected:
        register = int(f"{register:08b}"[::-1], 2)
    return register ^ one.xorout


@each_algorithm
def test_the_parameters_are_those_of_what_is_computed(one: Algorithm) -> None:
    for data in (b"", b"\0", b"123456789", bytes(range(256)), b"\xa3\x00\x03\x01\x00\xc8"):
        assert one.crc(data) == bit_by_bit(one, data)
    assert one.crc(b"123456789") == one.check
    assert CHECKS.get(one.name, one.check) == one.check


def test_those_that_the_protocol_page_names_are_there() -> None:
    assert set(CHECKS) <= set(CATALOGUE)
    assert len(CATALOGUE) == len({(a.poly, a.init, a.reflected, a.xorout) for a in CATALOGUE.values()}) == 19


@each_algorithm
def test_residue_and_table(one: Algorithm) -> None:
    for data in (b"", b"x", b"123456789"):
        assert one.crc(data + bytes([one.crc(data)])) == one.residue
    table = one.table()
    assert sorted(table) == list(range(256))
    # The register that the table runs is the CRC but for what initial value and final XOR add.
    register = 0
    for byte in b"123456789":
        register = table[register ^ byte]
    assert register == one.crc(b"123456789") ^ one.crc(bytes(9))


def test_names() -> None:
    for name in ("CRC-8/SMBUS", "crc-8/smbus", "smbus", "SMBUS", "CRC-8", "crc-8"):
        assert algorithm(name).name == "CRC-8/SMBUS"
    with pytest.raises(DataError, match="there is no CRC 'CRC-16'; known are CRC-8/AUTOSAR, "):
        algorithm("CRC-16")


def test_coverages_begin_one_byte_after_the_other() -> None:
    assert [coverage.first for coverage in Coverage] == [0, 1, 2, 3]
    assert str(Checksum(algorithm("rohc"), Coverage.SIZE)) == "CRC-8/ROHC from size"


def frames(checksum: Checksum) -> list[bytes]:
    """A dozen frames of different sizes and contents."""
    out = []
    for n in range(12):
        body = bytes([0xA3, 17 * n + 5, n]) + bytes((n * k * 37 + 11) % 256 for k in range(n))
        out.append(body + bytes([checksum.algorithm.crc(body[checksum.coverage.first :])]))
    return out


@pytest.mark.parametrize("checksum", CHECKSUMS, ids=str)
def test_a_dozen_frames_tell_algorithm_and_coverage(checksum: Checksum) -> None:
    assert fitting(frames(checksum)) == [checksum]


def test_few_frames_leave_more_and_damaged_ones_none() -> None:
    checksum = Checksum(algorithm("smbus"), Coverage.MAGIC)
    good = frames(checksum)
    assert fitting([]) == list(CHECKSUMS)
    assert checksum in fitting(good[4:5])
    damaged = [*good, good[5][:-1] + bytes([good[5][-1] ^ 1])]
    assert fitting(damaged) == []
