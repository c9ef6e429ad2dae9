"""The robot's header: it compiles without a warning, and reads and writes the bytes that Python does."""

from __future__ import annotations

import contextlib
import shutil
import struct
import subprocess
from typing import TYPE_CHECKING

import pytest

from turtlewire.protocols.frame.codec import FrameEncoder, frame_bytes
from turtlewire.protocols.frame.dialect import FROM_ROBOT, TO_ROBOT, Dialect, read_dialect, shipped
from turtlewire.protocols.frame.header import header, namespace
from turtlewire.protocols.message import Field

if TYPE_CHECKING:
    from pathlib import Path

    from turtlewire.protocols.frame.dialect import Entry

EVERY_KIND = """
protocol = "frame"
dialect = "every kind"
title = "Every kind\\\\\\nof field"
[counts]
none = 0
many = 256
[enumerations]
big = { small = -2147483648, middle = 70000, great = 2147483647 }
sign = { low = 0, high = 1, input = 4294967295 }
[[message]]
name = "Empty"
type = 255
direction = "both"
[[message]]
name = "Nobody"
type = 1
direction = "to robot"
fields = [{ name = "id", kind = "u8", below = "none" }]
[[message]]
name = "Everything"
type = 0
direction = "to robot"
doc = "One of each."
fields = [
  { name = "a", kind = "u8", min = 1, max = 254 }, { name = "b", kind = "bool" },
  { name = "c", kind = "u16", min = 1, max = 65534 }, { name = "d", kind = "i16", min = -32767, max = 32766 },
  { name = "e", kind = "u32", min = 1, max = 4294967294 }, { name = "f", kind = "i32", min = -2147483647 },
  { name = "g", kind = "f32", min = -0.1, max = 1e30 }, { name = "h", kind = "i32", enumeration = "big" },
  { name = "i", kind = "u32", enumeration = "sign" }, { name = "j", kind = "i32" }, { name = "k", kind = "f32" },
  { name = "l", kind = "u8", below = "many" },
]
"""
DIALECTS = {
    "0.1": shipped("0.1"),
    "0.1-literal": shipped("0.1-literal").configured(crc="MAXIM-DOW", coverage="seq"),
    "telemetry": shipped("telemetry").configured(crc="AUTOSAR", coverage="size"),
    "rohc": shipped("0.1").configured(crc="ROHC", coverage="payload", counts={"engines": 256}),
    "every kind": read_dialect(EVERY_KIND),
}


def payloads(dialect: Dialect, entry: Entry) -> list[bytes]:
    """All fields' bytes the same, for telling bytes; and each field at and beyond the ends of its range."""
    fields = entry.message_type.FIELDS
    size = entry.layout.size - 1
    found = [bytes([entry.type]) + bytes([byte]) * size for byte in (0, 1, 2, 0x40, 0x7F, 0x80, 0xA3, 0xFF)]
    start = [f.choices[0][1] if isinstance(f, Field) and f.choices else f.low for f in fields]
    for place, field in enumerate(fields):
        ends = [field.low, dialect.high(entry, field)]
        if isinstance(field, Field):
            ends += [number for _, number in field.choices]
        for value in (end + step for end in ends for step in (-1, 0, 1)):
            with contextlib.suppress(struct.error, OverflowError):  # there are no such bytes
                values = [*start[:place], value, *start[place + 1 :]]
                found.append(entry.layout.pack(entry.type, *values))
    return found


def expected(dialect: Dialect, entry: Entry, payload: bytes) -> str:
    """What the program shall say: whether the message is valid, its bytes again, the frame with it."""
    values = entry.layout.unpack(payload)[1:]
    fields = entry.message_type.FIELDS
    valid = all(f.fits(v) and v <= dialect.high(entry, f) for f, v in zip(fields, values, strict=True))
    again = entry.layout.pack(entry.type, *values)
    return f"{int(valid)} {again.hex()} {frame_bytes(dialect, 0xA3, again).hex()}"


def size_of(dialect: Dialect, direction: str, number: int) -> int:
    of_type = (entry for entry in dialect.entries if entry.type == number and entry.goes(direction))
    return max((entry.layout.size for entry in of_type), default=0)


MAIN = """
#include "dialect.h"
#include <stdio.h>
using namespace NAMESPACE;

static void show(const uint8_t* bytes, unsigned size) {
  printf(" ");
  for (unsigned at = 0; at < size; ++at) { printf("%02x", static_cast<unsigned>(bytes[at])); }
}

template <typename M> static int exercise(const uint8_t* in, uint8_t size) {
  M message;
  uint8_t frame[MAX_FRAME];
  uint8_t other[M::SIZE];
  memcpy(other, in, M::SIZE);
  other[0] = static_cast<uint8_t>(other[0] + 1U);
  if (size != M::SIZE || unpack(in, static_cast<uint8_t>(size - 1U), message)) { return 1; }
  if (unpack(other, size, message)) { return 6; }
  if (!unpack(in, size, message)) { return 2; }
  const uint8_t packed = pack(message, frame + FRAME_HEADER);
  printf("%d", valid(message) ? 1 : 0);
  show(frame + FRAME_HEADER, packed);
  show(frame, finish_frame(frame, 0xA3, packed));
  printf("\\n");
  return 0;
}

// Frames of every size, right and with each bit of their last byte wrong, behind anything.
static bool is_told_right() {
  uint8_t frame[MAX_FRAME], crcs[MAX_FRAME];
  for (uint8_t at = 0; at < MAX_FRAME; ++at) { frame[at] = static_cast<uint8_t>(at * at + 7 * at); }
  for (unsigned before = 0; before < 256; before += 51) {
    for (uint8_t size = 0; size <= MAX_PAYLOAD; ++size) {
      const uint8_t whole = finish_frame(frame, static_cast<uint8_t>(size * 5), size);
      uint8_t crc = static_cast<uint8_t>(before);
      for (uint8_t at = 0; at < whole; ++at) {
        crcs[at] = crc;
        crc = Dialect::step(crc, frame[at]);
      }
      if (!Dialect::is_right(frame, crcs)) { return false; }
      for (unsigned bit = 1; bit < 256; bit <<= 1U) {
        frame[whole - 1] = static_cast<uint8_t>(frame[whole - 1] ^ bit);
        if (Dialect::is_right(frame, crcs)) { return false; }
        frame[whole - 1] = static_cast<uint8_t>(frame[whole - 1] ^ bit);
      }
    }
  }
  return true;
}

int main() {
  if (!is_told_right()) { return 7; }
  int which = 0;
  unsigned size = 0;
  while (scanf("%d %u", &which, &size) == 2) {
    uint8_t in[MAX_PAYLOAD];
    for (unsigned at = 0; at < size; ++at) {
      unsigned byte = 0;
      if (scanf("%x", &byte) != 1) { return 3; }
      in[at] = static_cast<uint8_t>(byte);
    }
    int failed = 4;
    switch (which) { CASES default: break; }
    if (failed != 0) { return failed; }
  }
  return SIZES ? 0 : 5;
}
"""


@pytest.mark.parametrize("dialect", DIALECTS.values(), ids=list(DIALECTS))
def test_it_compiles_and_agrees_with_python(dialect: Dialect, tmp_path: Path) -> None:
    compiler = shutil.which("g++")
    assert compiler, "these tests need g++ (on Debian: sudo apt install g++)"
    cases = [
        f"case {n}: failed = exercise<{entry.message_type.__name__}>(in, static_cast<uint8_t>(size)); break;"
        for n, entry in enumerate(dialect.entries)
    ]
    sizes = [
        f"{function}({number}) == {size_of(dialect, direction, number)}"
        for direction, function in ((TO_ROBOT, "command_size"), (FROM_ROBOT, "telemetry_size"))
        if any(entry.goes(direction) for entry in dialect.entries)
        for number in range(256)
    ]
    main = MAIN.replace("NAMESPACE", namespace(dialect)).replace("CASES", "\n".join(cases))
    (tmp_path / "dialect.h").write_text(header(dialect))
    (tmp_path / "main.cpp").write_text(main.replace("SIZES", " && ".join(sizes)))
    flags = ["-std=c++11", "-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-pedantic", "-Werror"]
    program = tmp_path / "program"
    built = subprocess.run(
        [compiler, *flags, str(tmp_path / "main.cpp"), "-o", str(program)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    given, wanted = [], []
    for n, entry in enumerate(dialect.entries):
        for payload in payloads(dialect, entry):
            given.append(f"{n} {len(payload)} {payload.hex(' ')}")
            wanted.append(expected(dialect, entry, payload))
    ran = subprocess.run([program], input="\n".join(given), capture_output=True, text=True, check=False)
    assert ran.returncode == 0
    assert ran.stdout.splitlines() == wanted
    assert {line[0] for line in wanted} == {"0", "1"}


def test_a_frame_of_the_header_is_a_frame_of_the_encoder() -> None:
    """What ``frame_bytes`` makes above is what the encoder sends."""
    dialect = DIALECTS["0.1"]
    message = dialect.parse("engine_forward engine_id=1 speed=7")
    (frame,) = FrameEncoder(dialect, seq=0xA3).encode([message])
    assert frame == frame_bytes(dialect, 0xA3, b"\x01\x01\x07")


def test_what_the_header_says() -> None:
    text = header(shipped("telemetry"))
    assert text.startswith("// A robot with telemetry: dialect telemetry.\n")
    assert "namespace frame_telemetry {" in text
    assert "constexpr uint8_t CRC_POLY = 0x07;" in text
    assert "constexpr uint16_t COUNT_SERVOS = 1;" in text
    assert "namespace state { enum : uint32_t { idle = 0, driving = 1, stopped = 2, fault = 9 }; }" in text
    assert "  int16_t left_mm_per_s;  // mm/s" in text
    assert "malloc" not in text
    assert "new " not in text
