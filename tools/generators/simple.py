"""What is generated from spec/protocols/simple.toml."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

from tools.generators.cpp import FIRMWARE, cpp_header, snake
from tools.generators.python import RANGES, ROOT, field_source, formatted

if TYPE_CHECKING:
    from pathlib import Path

BASES = {"to robot": "SimpleCommand", "from robot": "Reply"}
SECTIONS = {
    "to robot": ("Host to robot", "one letter and six positions; `-` is don't care and sent as `0` (S2)"),
    "from robot": ("Robot to host", "one byte, after every seven bytes received (S4)"),
}
DIGITS = {"u8": 3, "bit": 1}

HEAD = '''"""The messages of simple. Generated from spec/protocols/simple.toml by `make generate`: do not edit."""

from __future__ import annotations

from typing import ClassVar

from turtlewire.protocols.message import Field, Message
'''

BASES_SOURCE = '''

class SimpleMessage(Message, frozen=True):
    """Any message of simple: ``LETTER`` is its first byte."""

    LETTER: ClassVar[bytes]


class SimpleCommand(SimpleMessage, frozen=True):
    """Host to robot: one letter and six positions.

    ``CHANNEL`` is what a set-point sets (S9), empty for the stop. ``SIGN`` is what its value counts as there.
    ``STOPPED`` tells whether a stop ends it (S5).

    A command of one's own (S10) is a subclass with a letter and a channel of its own, and with fields for up to six
    positions: a ``u16`` of at most 999 or a ``u8`` takes three of them, a ``bit`` one. Both ends are told of it.
    """

    CHANNEL: ClassVar[str] = ""
    SIGN: ClassVar[int] = 1
    STOPPED: ClassVar[bool] = False


class Reply(SimpleMessage, frozen=True):
    """Robot to host: one byte, after every seven bytes received (S4)."""
'''


def message_source(message: dict[str, Any]) -> str:
    lines = [
        "",
        "",
        f"class {message['name']}({BASES[message['direction']]}, frozen=True):",
        f'    """{message["doc"]}"""',
        "",
        f"    LETTER: ClassVar[bytes] = {message['letter'].encode()!r}",
    ]
    if "channel" in message:
        lines.append(f"    CHANNEL: ClassVar[str] = {message['channel']!r}")
    if message.get("sign", 1) != 1:
        lines.append(f"    SIGN: ClassVar[int] = {message['sign']}")
    if message.get("stopped"):
        lines.append("    STOPPED: ClassVar[bool] = True")
    fields = message.get("fields", [])
    if fields:
        sources = ", ".join(field_source(field) for field in fields)
        lines.append(f"    FIELDS: ClassVar[tuple[Field, ...]] = ({sources},)")
        lines += [f"    {field['name']}: int" for field in fields]
    return "\n".join(lines)


def python(spec: dict[str, Any]) -> str:
    out = [HEAD]
    out.append(f"BAUD = {spec['baud']}  # S6")
    out.append(f"LENGTH = {spec['length']}  # bytes of every command")
    out.append(f"DONT_CARE = {spec['dont_care'].encode()!r}  # S2")
    out.append(f"MAX_WINDOW = {spec['max_window']}  # S9")
    for name, data in spec["sequences"].items():
        out.append(f"{name.upper()} = bytes.fromhex({data!r})")
    out.append(BASES_SOURCE)
    out += [message_source(message) for message in spec["message"]]
    for constant, direction in (("COMMANDS", "to robot"), ("REPLIES", "from robot")):
        names = ", ".join(m["name"] for m in spec["message"] if m["direction"] == direction)
        out.append(f"\n\n{constant}: tuple[type[{BASES[direction]}], ...] = ({names},)")
    out.append("MESSAGES: tuple[type[SimpleMessage], ...] = (*COMMANDS, *REPLIES)")
    return formatted("\n".join(out))


def wire(message: dict[str, Any], length: int) -> str:
    """The seven positions of a command: the letter, `v` or a letter of its own for a digit, `-`."""
    fields = message.get("fields", [])
    digits = "".join("v" * DIGITS[field["kind"]] for field in fields)
    if len(fields) > 1:
        digits = "abcdef"[: len(digits)]
    return f"{message['letter']}{digits}".ljust(length, "-")


def page(spec: dict[str, Any]) -> str:
    out = [
        "# The messages of simple",
        "",
        "Generated from `spec/protocols/simple.toml` by `make generate`.",
    ]
    for direction, (title, form) in SECTIONS.items():
        out += ["", f"## {title}", "", f"Form: {form}.", ""]
        out += ["| message | bytes | fields | channel | meaning |", "| --- | --- | --- | --- | --- |"]
        for message in (m for m in spec["message"] if m["direction"] == direction):
            fields = []
            for field in message.get("fields", []):
                low, high = RANGES[field["kind"]]
                fields.append(f"{field['name']} {low}..{high} ({field['unit']})")
            length = spec["length"] if direction == "to robot" else 1
            row = [
                f"`{message['name']}`",
                f"`{wire(message, length)}`",
                "; ".join(fields),
                message.get("channel", ""),
                message["doc"],
            ]
            out.append(f"| {' | '.join(row)} |")
    return "\n".join(out) + "\n"


def cpp(spec: dict[str, Any]) -> str:
    """The robot's header."""
    commands = [m for m in spec["message"] if m["direction"] == "to robot"]
    replies = [m for m in spec["message"] if m["direction"] == "from robot"]
    constants = [
        f"const uint32_t BAUD = {spec['baud']}UL;  // S6",
        f"const uint8_t LENGTH = {spec['length']};",
        f"const uint8_t MAX_WINDOW = {spec['max_window']};  // S9",
        "",
        *(f"const uint8_t {snake(m['name']).upper()} = '{m['letter']}';  // {m['doc']}" for m in commands),
        "",
        *(f"const uint8_t {snake(m['name']).upper()} = '{m['letter']}';  // {m['doc']}" for m in replies),
    ]
    cases = [f"    case {snake(m['name']).upper()}: return {cpp_form(m)};" for m in commands]
    return cpp_header(
        "simple",
        [
            *constants,
            "",
            "// How the six positions of a command are filled.",
            "enum Form : uint8_t {",
            "  FORM_UNKNOWN,",
            "  FORM_EMPTY,   // nothing but don't-care positions",
            "  FORM_NUMBER,  // three digits, 000..255",
            "  FORM_BITS,    // four digits: 0 off, any other on",
            "};",
            "",
            "inline Form form_of(uint8_t letter) {",
            "  switch (letter) {",
            *cases,
            "    default: return FORM_UNKNOWN;",
            "  }",
            "}",
        ],
    )


def cpp_form(message: dict[str, Any]) -> str:
    """The form of a command; the parser on the robot knows these three."""
    forms = {(): "FORM_EMPTY", ("u8",): "FORM_NUMBER", ("bit",) * 4: "FORM_BITS"}
    return forms[tuple(field["kind"] for field in message.get("fields", []))]


def files() -> dict[Path, str]:
    """The generated files and what they must contain."""
    spec = tomllib.loads((ROOT / "spec/protocols/simple.toml").read_text("utf-8"))
    return {
        ROOT / "src/turtlewire/protocols/simple/messages.py": python(spec),
        ROOT / "docs/protocols/simple-messages.md": page(spec),
        FIRMWARE / "simple_messages.h": cpp(spec),
    }
