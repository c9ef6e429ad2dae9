"""The page that a browser is given: one component, whose modules are in ``page/``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

# Imported for their names in the page's map of modules, nothing else.
import nicegui.elements.codemirror
import nicegui.elements.echart
import nicegui.elements.joystick  # noqa: F401
from nicegui import ui

if TYPE_CHECKING:
    from fastapi import FastAPI

MODULES = Path(__file__).parent / "page"


class ConsolePage(ui.element, component="component.js", esm={"turtlewire-console": "page"}):
    """The console, in a browser."""


def root() -> None:
    """The page, one for each browser that asks for it."""
    ConsolePage()


def mount(app: FastAPI) -> None:
    """Have the application serve the page."""
    ui.run_with(
        app,
        root=root,
        title="turtlewire",
        favicon=MODULES / "icon.svg",
        dark=None,
        tailwind=False,
        show_welcome_message=False,
        binding_refresh_interval=None,
    )
