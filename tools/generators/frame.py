"""What is generated from spec/protocols/frame*.toml: typed classes, the dialects in the package, the page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tools.generators.cpp import FIRMWARE
from tools.generators.python import ROOT, formatted
from turtlewire.protocols.frame.description import read
from turtlewire.protocols.frame.dialect import Dialect, load
from turtlewire.protocols.frame.header import header, namespace
from turtlewire.protocols.frame.page import page
from turtlewire.protocols.message import Field

if TYPE_CHECKING:
    from pathlib import Path

    from turtlewire.protocols.frame.description import AmbiguousDescription, MessageDescription
    from turtlewire.protocols.message import AnyField

# dialect -> its description
SOURCES = {
    "0.1": "frame.toml",
    "0.1-literal": "frame-0.1-literal.toml",
    "telemetry": "frame-telemetry.toml",
}
TYPED = ("0.1", "0.1-literal")

HEAD = '''"""The messages of Serial Protocol 0.1. Generated from spec/protocols/frame*.toml by `make generate`.

Do not edit.
"""

from __future__ import annotations

from typing import ClassVar

from turtlewire.protocols.frame.message import FrameMessage
from turtlewire.protocols.message import Field
'''

PAGE_HEAD = """# The messages of frame

Generated from `spec/protocols/frame*.toml` by `make generate`: the dialects that come with turtlewire. A message
stands in a frame as its type (1 byte), then its fields in order, big endian. How frames look, and how to write a
dialect of your own: [frame.md](frame.md).
"""


def class_source(described: MessageDescription | AmbiguousDescription, fields: tuple[AnyField, ...]) -> str:
    whole = [field for field in fields if isinstance(field, Field)]
    sources = ", ".join(f"Field({f.name!r}, {f.kind!r}, {f.low}, {f.high}, {f.unit!r})" for f in whole)
    lines = [
        "",
        "",
        f"class {described.name}(FrameMessage, frozen=True, gc=False):",
        f'    """{described.doc}"""',
        "",
        f"    FIELDS: ClassVar[tuple[Field, ...]] = ({sources},)",
        *(f"    {field.name}: int" for field in whole),
    ]
    return "\n".join(lines)


def python(texts: dict[str, str]) -> str:
    classes: dict[str, str] = {}
    for name in TYPED:
        description = read(texts[name], SOURCES[name])
        by_name = {message.name: message for message in description.messages}
        for message in description.messages:
            classes.setdefault(message.name, class_source(message, message.fields))
        for ambiguous in description.ambiguous:
            like = by_name[ambiguous.messages[0]]
            classes.setdefault(ambiguous.name, class_source(ambiguous, like.fields))
    messages = f"\n\nMESSAGES: tuple[type[FrameMessage], ...] = ({', '.join(classes)},)"
    return formatted("\n".join([HEAD, *classes.values(), messages]))


def pages(texts: dict[str, str]) -> str:
    dialects = [Dialect(read(text, SOURCES[name])) for name, text in texts.items()]
    return "\n".join([PAGE_HEAD, *(page(dialect, level=2) for dialect in dialects)])


def files() -> dict[Path, str]:
    """The generated files and what they must contain."""
    texts = {name: (ROOT / "spec/protocols" / file).read_text("utf-8") for name, file in SOURCES.items()}
    folder = ROOT / "src/turtlewire/protocols/frame"
    dialects = [Dialect(read(text, SOURCES[name])) for name, text in texts.items()]
    sketch = ROOT / "firmware/Turtlewire/examples/FrameRobot/dialect.toml"
    return {
        sketch.with_suffix(".h"): header(load(sketch)),
        **{FIRMWARE / f"{namespace(dialect)}.h": header(dialect) for dialect in dialects},
        folder / "messages.py": python(texts),
        **{folder / "dialects" / f"{name}.toml": text for name, text in texts.items()},
        ROOT / "docs/protocols/frame-messages.md": pages(texts),
    }
