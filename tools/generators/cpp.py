"""Shared by the generators: headers of the robots' firmware."""

from __future__ import annotations

import re

from tools.generators.python import ROOT

FIRMWARE = ROOT / "firmware/Turtlewire/src/turtlewire"


def snake(name: str) -> str:
    """``SelectDirect`` as ``select_direct``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def cpp_header(protocol: str, lines: list[str]) -> str:
    """A header with these lines in the namespace of a protocol."""
    guard = f"TURTLEWIRE_{protocol.upper()}_MESSAGES_H"
    return "\n".join(
        [
            f"// The messages of {protocol}. Made from spec/protocols/{protocol}.toml by `make generate`: do not edit.",
            f"#ifndef {guard}",
            f"#define {guard}",
            "",
            "#include <stdint.h>",
            "",
            "namespace turtlewire {",
            f"namespace {protocol} {{",
            "",
            *lines,
            "",
            f"}}  // namespace {protocol}",
            "}  // namespace turtlewire",
            "",
            f"#endif  // {guard}",
            "",
        ]
    )
