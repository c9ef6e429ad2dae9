"""The primitives of Logo, one file per chapter of the manual."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.logo.primitives import (
    arithmetic,
    arrays,
    communication,
    control,
    data,
    graphics,
    logic,
    macros,
    predicates,
    robot,
    templates,
    workspace,
)

if TYPE_CHECKING:
    from turtlewire.logo.procedures import Primitive

PRIMITIVES: dict[str, Primitive] = {}
_CHAPTERS = (
    arithmetic,
    arrays,
    communication,
    control,
    data,
    graphics,
    logic,
    macros,
    predicates,
    robot,
    templates,
    workspace,
)
for _chapter in _CHAPTERS:
    PRIMITIVES |= _chapter.chapter.primitives
