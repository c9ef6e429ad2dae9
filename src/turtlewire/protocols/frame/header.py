"""The robot's C++11 header for a dialect: the same messages, the same bytes (F10).

Plain structs and inline functions in a namespace; no heap, no exceptions, no library but <stdint.h> and <string.h>, so
that it compiles for an 8-bit microcontroller as for a PC.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from turtlewire.protocols.frame.dialect import TO_ROBOT
from turtlewire.protocols.frame.message import HEADER, MAGIC, MAX_FRAME, MAX_PAYLOAD, OVERHEAD
from turtlewire.protocols.message import KINDS, Field

if TYPE_CHECKING:
    from turtlewire.protocols.checksums import Algorithm
    from turtlewire.protocols.frame.dialect import Dialect, Entry
    from turtlewire.protocols.message import AnyField

TYPES = {
    "u8": "uint8_t",
    "bool": "bool",
    "u16": "uint16_t",
    "i16": "int16_t",
    "u32": "uint32_t",
    "i32": "int32_t",
    "f32": "float",
}

FIXED = """\
inline uint8_t crc8_bit(uint8_t crc) {
  return static_cast<uint8_t>((crc & 0x@top@U) != 0 ? (crc @shift@ 1U) ^ CRC_POLY : crc @shift@ 1U);
}

inline uint8_t crc8_step(uint8_t crc, uint8_t byte) {
  crc = static_cast<uint8_t>(crc ^ byte);
  for (uint8_t bit = 0; bit < 8; ++bit) {
    crc = crc8_bit(crc);
  }
  return crc;
}

// The product of two polynomials, the remainder of it.
inline uint8_t crc8_times(uint8_t one, uint8_t other) {
  uint8_t product = 0;
  for (uint8_t bit = 0; bit < 8; ++bit) {
    product = crc8_bit(product);
    if ((other & 0x@top@U) != 0) {
      product = static_cast<uint8_t>(product ^ one);
    }
    other = static_cast<uint8_t>(other @shift@ 1U);
  }
  return product;
}

// What at most 127 zero bytes make of a CRC: so many times x^8, by the binary digits of the number.
inline uint8_t crc8_zeros(uint8_t crc, uint8_t count) {
  static const uint8_t POWERS[] = {@powers@};
  for (const uint8_t* power = POWERS; count != 0; ++power) {
    if ((count & 1U) != 0) {
      crc = crc8_times(crc, *power);
    }
    count = static_cast<uint8_t>(count >> 1U);
  }
  return crc;
}

// The CRC of a frame whose payload has `size` bytes.
inline uint8_t frame_crc(const uint8_t* frame, uint8_t size) {
  uint8_t crc = CRC_INIT;
  for (uint8_t at = CRC_FIRST; at < FRAME_HEADER + size; ++at) {
    crc = crc8_step(crc, frame[at]);
  }
  return static_cast<uint8_t>(crc ^ CRC_XOROUT);
}

// Whether a frame's CRC is right, by crc8_step() of all that came before each of its bytes, from any beginning on: what
// came before the frame follows it as zeros, and falls out.
inline bool is_right_frame(const uint8_t* frame, const uint8_t* crcs) {
  const auto end = static_cast<uint8_t>(FRAME_HEADER + frame[2]);
  const auto before = static_cast<uint8_t>(crcs[CRC_FIRST] ^ CRC_INIT);
  const auto zeros = static_cast<uint8_t>(end - CRC_FIRST);
  return (crcs[end] ^ crc8_zeros(before, zeros) ^ CRC_XOROUT) == frame[end];
}

// Makes a frame of a payload that stands at frame + FRAME_HEADER already. Returns the frame's size.
inline uint8_t finish_frame(uint8_t* frame, uint8_t seq, uint8_t size) {
  frame[0] = FRAME_MAGIC;
  frame[1] = seq;
  frame[2] = size;
  frame[FRAME_HEADER + size] = frame_crc(frame, size);
  return static_cast<uint8_t>(size + FRAME_OVERHEAD);
}
"""

# What reads and writes numbers of more than one byte: each uses those before it, and there are those that are used.
NUMBERS = (
    (
        {"u16", "i16", "u32", "i32", "f32"},
        """\
inline void put16(uint8_t* out, uint16_t value) {
  out[0] = static_cast<uint8_t>(value >> 8U);
  out[1] = static_cast<uint8_t>(value & 0xFFU);
}

inline uint16_t get16(const uint8_t* in) {
  return static_cast<uint16_t>((static_cast<uint16_t>(in[0]) << 8U) | in[1]);
}
""",
    ),
    (
        {"u32", "i32", "f32"},
        """\
inline void put32(uint8_t* out, uint32_t value) {
  put16(out, static_cast<uint16_t>(value >> 16U));
  put16(out + 2, static_cast<uint16_t>(value & 0xFFFFU));
}

inline uint32_t get32(const uint8_t* in) {
  return (static_cast<uint32_t>(get16(in)) << 16U) | get16(in + 2);
}
""",
    ),
    (
        {"f32"},
        """\
inline void put_float(uint8_t* out, float value) {
  static_assert(sizeof(float) == sizeof(uint32_t), "an f32 is an IEEE 754 single");
  uint32_t bits = 0;
  memcpy(&bits, &value, sizeof bits);
  put32(out, bits);
}

inline float get_float(const uint8_t* in) {
  const uint32_t bits = get32(in);
  float value = 0;
  memcpy(&value, &bits, sizeof value);
  return value;
}
""",
    ),
)
PUT = {
    "u8": "out[{at}] = message.{name};",
    "bool": "out[{at}] = message.{name} ? 1 : 0;",
    "u16": "put16(out + {at}, message.{name});",
    "i16": "put16(out + {at}, static_cast<uint16_t>(message.{name}));",
    "u32": "put32(out + {at}, message.{name});",
    "i32": "put32(out + {at}, static_cast<uint32_t>(message.{name}));",
    "f32": "put_float(out + {at}, message.{name});",
}
GET = {
    "u8": "message.{name} = in[{at}];",
    "bool": "message.{name} = in[{at}] != 0;",
    "u16": "message.{name} = get16(in + {at});",
    "i16": "message.{name} = static_cast<int16_t>(get16(in + {at}));",
    "u32": "message.{name} = get32(in + {at});",
    "i32": "message.{name} = static_cast<int32_t>(get32(in + {at}));",
    "f32": "message.{name} = get_float(in + {at});",
}


def namespace(dialect: Dialect) -> str:
    """The header's namespace: ``frame_0_1`` for the dialect ``0.1``."""
    return "frame_" + re.sub(r"\W", "_", dialect.name, flags=re.ASCII)


def header(dialect: Dialect) -> str:
    """The text of the header."""
    name = namespace(dialect)
    guard = f"TURTLEWIRE_{name.upper()}_H"
    checksum = dialect.checksum
    made = checksum.algorithm
    out = [
        f"// {_comment(dialect.title)}: dialect {_comment(dialect.name)}.",
        "// Made by turtlewire from the dialect's file: do not edit.",
        "//",
        "// valid() tells whether a message keeps its restrictions: one that does not is not to be carried out.",
        "// unpack() takes type and fields; it returns false where the type is another or bytes are missing.",
        "// pack() returns how many bytes it wrote.",
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        "#include <stdint.h>",
        "#include <string.h>",
        "",
        f"namespace {name} {{",
        "",
        f"constexpr uint32_t BAUD = {dialect.baud}UL;",
        f"constexpr uint8_t FRAME_MAGIC = 0x{MAGIC:02X};",
        f"constexpr uint8_t FRAME_HEADER = {HEADER};",
        f"constexpr uint8_t FRAME_OVERHEAD = {OVERHEAD};",
        f"constexpr uint8_t MAX_PAYLOAD = {MAX_PAYLOAD};",
        f"constexpr uint8_t MAX_FRAME = {MAX_FRAME};",
        "",
        f"// {checksum}",
        f"constexpr uint8_t CRC_POLY = 0x{_reversed(made.poly) if made.reflected else made.poly:02X};",
        f"constexpr uint8_t CRC_INIT = 0x{_reversed(made.init) if made.reflected else made.init:02X};",
        f"constexpr uint8_t CRC_XOROUT = 0x{made.xorout:02X};",
        f"constexpr uint8_t CRC_FIRST = {checksum.coverage.first};",
        "",
        FIXED.replace("@top@", "01" if made.reflected else "80")
        .replace("@shift@", ">>" if made.reflected else "<<")
        .replace("@powers@", ", ".join(f"0x{power:02X}" for power in _powers(made))),
    ]
    kinds = {field.kind for entry in dialect.entries for field in entry.message_type.FIELDS}
    out += [functions for users, functions in NUMBERS if kinds & users]
    for count, number in dialect.counts.items():
        out.append(f"constexpr uint16_t COUNT_{count.upper()} = {number};")
    for enumeration, members in dialect.enumerations.items():
        values = ", ".join(f"{member.name} = {_whole(member.value)}" for member in members)
        base = "int32_t" if min(members) < 0 else "uint32_t"
        out += ["", f"namespace {enumeration} {{ enum : {base} {{ {values} }}; }}"]
    for entry in dialect.entries:
        out += _message(dialect, entry)
    for direction, function in ((TO_ROBOT, "command_size"), ("from robot", "telemetry_size")):
        out += _sizes(dialect, direction, function)
    out += _traits(dialect)
    out += ["", f"}}  // namespace {name}", "", f"#endif  // {guard}"]
    return "\n".join(out) + "\n"


def _comment(text: str) -> str:
    """Text that stays within a line's comment."""
    return " ".join(text.replace("\\", "/").split())


def _reversed(byte: int) -> int:
    return int(f"{byte:08b}"[::-1], 2)


def _powers(made: Algorithm) -> list[int]:
    """Powers of x, as the register has them: 8, 16, 32 .. 512."""
    found, power = [], 1
    for exponent in range(1, 513):
        power <<= 1
        if power > 0xFF:
            power ^= 0x100 | made.poly
        if exponent >= 8 and exponent.bit_count() == 1:
            found.append(_reversed(power) if made.reflected else power)
    return found


def _whole(value: int) -> str:
    """A whole number that C++ takes for what it is, with int of 16 bits too."""
    if value == -(1 << 31):
        return "(-2147483647L - 1L)"
    if -(1 << 15) < value < 1 << 15:
        return str(value)
    return f"{value}L" if value < 1 << 31 else f"{value}UL"


def _message(dialect: Dialect, entry: Entry) -> list[str]:
    message_type = entry.message_type
    name, fields = message_type.__name__, message_type.FIELDS
    size = 1 + sum(KINDS[field.kind][0] for field in fields)
    out = ["", f"// {_comment(message_type.__doc__ or name)} ({entry.direction})", f"struct {name} {{"]
    out.append(f"  static constexpr uint8_t TYPE = 0x{entry.type:02X};")
    out.append(f"  static constexpr uint8_t SIZE = {size};")
    out += [f"  {TYPES[field.kind]} {field.name};  // {_comment(field.unit)}" for field in fields]
    out.append("};")
    put, get, at = [], [], 1
    for field in fields:
        put.append("  " + PUT[field.kind].format(at=at, name=field.name))
        get.append("  " + GET[field.kind].format(at=at, name=field.name))
        at += KINDS[field.kind][0]
    tests = [test for field in fields for test in _tests(dialect, entry, field)]
    used = "message" if fields else "/* message */"
    checked = "message" if any("message" in test for test in tests) else "/* message */"
    out += [
        "",
        f"inline bool valid(const {name}& {checked}) {{",
        f"  return {' && '.join(tests) or 'true'};",
        "}",
        "",
        f"inline uint8_t pack(const {name}& {used}, uint8_t* out) {{",
        f"  out[0] = 0x{entry.type:02X};",
        *put,
        f"  return {size};",
        "}",
        "",
        f"inline bool unpack(const uint8_t* in, uint8_t size, {name}& {used}) {{",
        f"  if (size < {size} || in[0] != 0x{entry.type:02X}) {{",
        "    return false;",
        "  }",
        *get,
        "  return true;",
        "}",
    ]
    return out


def _tests(dialect: Dialect, entry: Entry, field: AnyField) -> list[str]:
    """What must hold of a field; nothing where its type cannot hold anything else."""
    value = f"message.{field.name}"
    if not isinstance(field, Field):
        return [f"{value} >= {field.low!r}F", f"{value} <= {field.high!r}F"]
    if field.kind == "bool":
        return []
    if field.choices:
        return ["(" + " || ".join(f"{value} == {_whole(number)}" for _, number in field.choices) + ")"]
    size, signed = KINDS[field.kind]
    top = (1 << (8 * size - signed)) - 1
    bottom = -top - 1 if signed else 0
    high = int(dialect.high(entry, field))
    if high < field.low:
        return ["false"]
    if high == field.low:
        return [f"{value} == {_whole(high)}"]
    return [f"{value} >= {_whole(field.low)}"] * (field.low > bottom) + [f"{value} <= {_whole(high)}"] * (
        high < top
    )


def _sizes(dialect: Dialect, direction: str, function: str) -> list[str]:
    """The size of a message by its type; one ``case`` for each type, 0 for what is unknown."""
    sizes = {e.type: e.message_type.__name__ for e in dialect.entries if e.goes(direction)}
    if not sizes:
        return []
    return [
        "",
        f"// Type and fields of a message {direction}; 0 for an unknown type.",
        f"inline uint8_t {function}(uint8_t type) {{",
        "  switch (type) {",
        *(f"    case 0x{number:02X}: return {name}::SIZE;" for number, name in sizes.items()),
        "    default: return 0;",
        "  }",
        "}",
    ]


def _traits(dialect: Dialect) -> list[str]:
    """What the robot's end of frame, a template, asks about its dialect."""
    commands = {e.type: e.message_type.__name__ for e in dialect.entries if e.goes(TO_ROBOT) and e.is_decoded}
    size = (
        "(uint8_t type) { return command_size(type); }" if commands else "(uint8_t /* type */) { return 0; }"
    )
    out = [
        "",
        "// The dialect as turtlewire's parser wants it: frame::Robot<Dialect, Handler>, frame::Sender<Dialect>.",
        "struct Dialect {",
        f"  static uint8_t size{size}",
        "  static uint8_t step(uint8_t crc, uint8_t byte) { return crc8_step(crc, byte); }",
        "  static bool is_right(const uint8_t* frame, const uint8_t* crcs) { return is_right_frame(frame, crcs); }",
        "  static uint8_t finish(uint8_t* frame, uint8_t seq, uint8_t size) { return finish_frame(frame, seq, size); }",
    ]
    if not commands:
        return [
            *out,
            "",
            "  template <class Handler>",
            "  static bool dispatch(const uint8_t* /* in */, Handler& /* handler */) {",
            "    return false;",
            "  }",
            "};",
        ]
    return [
        *out,
        "",
        "  // Hands one message, all of whose bytes are there, to handler.message(); false: it breaks its restriction.",
        "  template <class Handler>",
        "  static bool dispatch(const uint8_t* in, Handler& handler) {",
        "    switch (in[0]) {",
        *(
            f"      case 0x{number:02X}: return hand_over<{name}>(in, handler);"
            for number, name in commands.items()
        ),
        "      default: return false;",
        "    }",
        "  }",
        "",
        " private:",
        "  template <class Message, class Handler>",
        "  static bool hand_over(const uint8_t* in, Handler& handler) {",
        "    Message message = Message();",
        "    static_cast<void>(unpack(in, Message::SIZE, message));  // type and size are right already",
        "    if (!valid(message)) {",
        "      return false;",
        "    }",
        "    handler.message(message);",
        "    return true;",
        "  }",
        "};",
    ]
