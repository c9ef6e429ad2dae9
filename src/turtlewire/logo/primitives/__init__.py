"""The primitives of Logo, one file per chapter of the manual."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.logo.primitives import (
    arithmetic,
    communication,
    control,
    data,
    graphics,
    logic,
    robot,
    templates,
    workspace,
)

if TYPE_CHECKING:
    from turtlewire.logo.procedures import Primitive

PRIMITIVES: dict[str, Primitive] = {}
for _chapter in (arithmetic, communication, control, data, graphics, logic, robot, templates, workspace):
    PRIMITIVES |= _chapter.chapter.primitives
