"""The primitives of Logo, one file per chapter of the manual."""

from __future__ import annotations

from turtlewire.logo.primitives import (
    arithmetic,
    arrays,
    communication,
    control,
    data,
    files,
    graphics,
    inspection,
    logic,
    loops,
    macros,
    marking,
    predicates,
    receivers,
    robot,
    saving,
    templates,
    workspace,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.procedures import Primitive

_CHAPTERS = (
    arithmetic,
    arrays,
    communication,
    control,
    data,
    files,
    graphics,
    inspection,
    logic,
    loops,
    macros,
    marking,
    predicates,
    receivers,
    robot,
    saving,
    templates,
    workspace,
)
PRIMITIVES: dict[str, Primitive] = {}
for _chapter in _CHAPTERS:
    PRIMITIVES |= _chapter.chapter.primitives
