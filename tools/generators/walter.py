"""What is generated from spec/protocols/walter.toml."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

from tools.generators.cpp import FIRMWARE, cpp_header, snake
from tools.generators.python import RANGES, ROOT, field_source, formatted

if TYPE_CHECKING:
    from pathlib import Path

SIZES = {"u8": 1, "u16": 2, "i16": 2}
BASES = {"logo": "LogoCommand", "direct": "DirectKey", "robot": "RobotMessage"}
SECTIONS = {
    "logo": ("Logo control, host to robot", "letters, fields, RET"),
    "direct": ("Direct control, host to robot", "one key, fields, no RET"),
    "robot": ("Logo control, robot to host", "letters, fields, RET"),
}

HEAD = '''"""The messages of WALTER. Generated from spec/protocols/walter.toml by `make generate`: do not edit.

Everything is big endian; RET is CR or CR LF (W1).
"""

from __future__ import annotations

from typing import ClassVar

from turtlewire.protocols.message import Field, Message
'''

BASES_SOURCE = '''

class WalterMessage(Message, frozen=True):
    """Any message of WALTER."""

    LETTERS: ClassVar[bytes]


class LogoCommand(WalterMessage, frozen=True):
    """Host to robot in Logo control: letters, binary arguments, RET.

    ``GROUP`` is the capability group (C, Q, H, E) that a robot may lack, or empty (W10).
    ``QUEUED`` tells whether the robot carries it out in order (W9) or when it arrives.
    """

    GROUP: ClassVar[str] = ""
    QUEUED: ClassVar[bool] = True


class DirectKey(WalterMessage, frozen=True):
    """Host to robot in direct control: one key, at most one binary byte, no RET."""


class RobotMessage(WalterMessage, frozen=True):
    """Robot to host in Logo control: letters, binary values, RET."""
'''


def message_source(message: dict[str, Any]) -> str:
    doc = message["doc"]
    if message.get("logo"):
        doc += f" Logo: {', '.join(message['logo'])}."
    lines = [
        "",
        "",
        f"class {message['name']}({BASES[message['mode']]}, frozen=True):",
        f'    """{doc}"""',
        "",
    ]
    lines.append(f"    LETTERS: ClassVar[bytes] = {message['letters'].encode()!r}")
    if message.get("group"):
        lines.append(f"    GROUP: ClassVar[str] = {message['group']!r}")
    if message.get("acts") == "at once":
        lines.append("    QUEUED: ClassVar[bool] = False")
    fields = message.get("fields", [])
    if fields:
        sources = ", ".join(field_source(field) for field in fields)
        lines.append(f"    FIELDS: ClassVar[tuple[Field, ...]] = ({sources},)")
        lines += [f"    {field['name']}: int" for field in fields]
    return "\n".join(lines)


def python(spec: dict[str, Any]) -> str:
    names = {mode: [m["name"] for m in spec["message"] if m["mode"] == mode] for mode in BASES}
    replies = {m["name"]: m["reply"] for m in spec["message"] if "reply" in m}
    calibration, limits = spec["calibration"], spec["limits"]
    out = [HEAD]
    out.append(f"BAUD = {spec['baud']}  # W16")
    out.append(f"MAX_UNFENCED_BYTES = {limits['unfenced_bytes']}  # W9")
    out.append(f"QUEUE_COMMANDS = {limits['queue_commands']}  # what a robot must be able to queue")
    out.append(f"MM_PER_S_PER_UNIT = {calibration['mm_per_s_per_unit']}  # W14, the nominal robot")
    out.append(f"DEG_PER_S_PER_UNIT = {calibration['deg_per_s_per_unit']}  # W14, the nominal robot")
    out.append(f"DEFAULT_SPEED = {calibration['default_speed']}")
    for name, data in spec["sequences"].items():
        out.append(f"{name.upper()} = bytes.fromhex({data!r})")
    out.append(BASES_SOURCE)
    out += [message_source(message) for message in spec["message"]]
    for constant, mode in (("LOGO_COMMANDS", "logo"), ("DIRECT_KEYS", "direct"), ("ROBOT_MESSAGES", "robot")):
        out.append(f"\n\n{constant}: tuple[type[{BASES[mode]}], ...] = ({', '.join(names[mode])},)")
    out.append("MESSAGES: tuple[type[WalterMessage], ...] = (*LOGO_COMMANDS, *DIRECT_KEYS, *ROBOT_MESSAGES)")
    pairs = ", ".join(f"{query}: {reply}" for query, reply in replies.items())
    out.append(f"REPLIES: dict[type[LogoCommand], type[RobotMessage]] = {{{pairs}}}")
    return formatted("\n".join(out))


def page(spec: dict[str, Any]) -> str:
    out = [
        "# The messages of WALTER",
        "",
        "Generated from `spec/protocols/walter.toml` by `make generate`. Binary fields are big endian.",
        "A group in the last column marks what a robot may lack (W10).",
    ]
    for mode, (title, form) in SECTIONS.items():
        out += ["", f"## {title}", "", f"Form: {form}.", ""]
        out += ["| message | bytes | Logo | meaning | group |", "| --- | --- | --- | --- | --- |"]
        for message in (m for m in spec["message"] if m["mode"] == mode):
            wire = [f"`{letter}`" if letter != " " else "space" for letter in message["letters"]]
            for field in message.get("fields", []):
                low, high = RANGES[field["kind"]]
                wire.append(f"{field['name']} ({field['kind']}, {low}..{field.get('max', high)})")
            if mode != "direct":
                wire.append("RET")
            logo = ", ".join(message.get("logo", []))
            row = [f"`{message['name']}`", " ".join(wire), logo, message["doc"], message.get("group", "")]
            out.append(f"| {' | '.join(row)} |")
    return "\n".join(out) + "\n"


def cpp(spec: dict[str, Any]) -> str:
    """The robot's header: every command and key a number, and how it is written."""
    lines = [m for m in spec["message"] if m["mode"] == "logo" and m["letters"]]
    keys = [m for m in spec["message"] if m["mode"] == "direct"]
    clashing = {m["name"] for m in lines} & {m["name"] for m in keys}
    for message in lines + keys:
        # What the parser on the robot relies on.
        assert all("max" not in field for field in message.get("fields", [])), message["name"]
        assert message.get("group", "") in ("", message["letters"][0]), message["name"]
    names = {id(m): cpp_name(m, clashing) for m in lines + keys}
    sizes = {id(m): sum(SIZES[field["kind"]] for field in m.get("fields", [])) for m in lines + keys}
    prefixes = sorted({m["letters"][0] for m in lines if len(m["letters"]) > 1})
    any_of = " || ".join(f"letter == '{prefix}'" for prefix in prefixes)
    limits, calibration = spec["limits"], spec["calibration"]
    return cpp_header(
        "walter",
        [
            f"const uint32_t BAUD = {spec['baud']}UL;  // W16",
            f"const uint8_t QUEUE_COMMANDS = {limits['queue_commands']};  // what a host may have sent ahead (W9)",
            f"const uint8_t DEFAULT_SPEED = {calibration['default_speed']};",
            f"const uint8_t MAX_ARGUMENTS = {max(sizes.values())};",
            "",
            "enum Id : uint8_t {",
            "  // Logo control.",
            "  EMPTY_LINE,",
            *(f"  {names[id(m)]},  // {m['doc']}" for m in lines),
            "  // Direct control.",
            *(f"  {names[id(m)]},  // {m['doc']}" for m in keys),
            "};",
            "",
            f"inline bool is_key(Id id) {{ return id >= {names[id(keys[0])]}; }}",
            "",
            "// A message, and how many bytes of arguments follow its letters.",
            "struct Form {",
            "  Id id;",
            "  uint8_t size;",
            "};",
            "",
            "// The command that begins with these letters, the second 0 if there is none; false: none does.",
            "inline bool find_line(uint8_t first, uint8_t second, Form& form) {",
            "  switch ((static_cast<uint16_t>(first) << 8U) | second) {",
            *(
                f"    case {letters(m)}: form = {{{names[id(m)]}, {sizes[id(m)]}}}; return true;"
                for m in lines
            ),
            "    default: return false;",
            "  }",
            "}",
            "",
            "// Whether a second letter has to follow.",
            "inline bool is_prefix(uint8_t letter) {",
            f"  return {any_of};",
            "}",
            "",
            "inline bool find_key(uint8_t key, Form& form) {",
            "  switch (key) {",
            *(
                f"    case '{m['letters']}': form = {{{names[id(m)]}, {sizes[id(m)]}}}; return true;"
                for m in keys
            ),
            "    default: return false;",
            "  }",
            "}",
        ],
    )


def cpp_name(message: dict[str, Any], clashing: set[str]) -> str:
    """Its name in C++; keys that are called as a command is are told apart."""
    name = snake(message["name"]).upper()
    return f"KEY_{name}" if message["mode"] == "direct" and message["name"] in clashing else name


def letters(message: dict[str, Any]) -> str:
    """Both letters in 16 bits, as hexadecimal."""
    first, second = (message["letters"] + "\0")[:2]
    return f"0x{ord(first):02X}{ord(second):02X}"


def files() -> dict[Path, str]:
    """The generated files and what they must contain."""
    spec = tomllib.loads((ROOT / "spec/protocols/walter.toml").read_text("utf-8"))
    return {
        ROOT / "src/turtlewire/protocols/walter/messages.py": python(spec),
        ROOT / "docs/protocols/walter-messages.md": page(spec),
        FIRMWARE / "walter_messages.h": cpp(spec),
    }
