"""The line editor: Enter ends an instruction, or goes on in the next line while something is open in it."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import TYPE_CHECKING

from prompt_toolkit import PromptSession
from prompt_toolkit.history import FileHistory, History, InMemoryHistory
from prompt_toolkit.key_binding import KeyBindings
from prompt_toolkit.patch_stdout import patch_stdout

from turtlewire.logo.unfinished import is_unfinished
from turtlewire.prompt.completion import LogoCompleter

if TYPE_CHECKING:
    from collections.abc import Mapping

    from prompt_toolkit.key_binding import KeyPressEvent

MORE = "> "


class Editor:
    """Asks for instructions, with a history that lasts and with names completed by the Tab key.

    Args:
        procedures: every procedure, by its name in lower case.
        variables: every variable.
    """

    def __init__(self, procedures: Mapping[str, object], variables: Mapping[str, object]) -> None:
        self._session: PromptSession[str] = PromptSession(
            history=_history(),
            completer=LogoCompleter(procedures, variables),
            complete_while_typing=False,
            multiline=True,
            prompt_continuation=MORE,
            key_bindings=_keys(),
        )

    def ask(self, prompt: str) -> str:
        """What somebody has written, one or more lines.

        Raises ``KeyboardInterrupt`` for Ctrl-C, ``EOFError`` for Ctrl-D.
        """
        # Whatever is written meanwhile, from another thread, stands above the prompt.
        with patch_stdout(raw=True):
            return self._session.prompt(prompt, handle_sigint=False)


def _keys() -> KeyBindings:
    keys = KeyBindings()

    @keys.add("enter")
    def _enter(event: KeyPressEvent) -> None:
        buffer = event.current_buffer
        state = buffer.complete_state
        if state is not None and state.current_completion is not None:
            buffer.apply_completion(state.current_completion)
        elif is_unfinished(buffer.text):
            buffer.insert_text("\n")
        else:
            buffer.validate_and_handle()

    return keys


class _LastingHistory(FileHistory):
    """A history in a file; a full disk is no reason to end."""

    def store_string(self, string: str) -> None:
        with contextlib.suppress(OSError):
            super().store_string(string)


def history_path() -> Path:
    """Where the history is: in the folder for what programs remember (XDG)."""
    home = os.environ.get("XDG_STATE_HOME", "")
    folder = Path(home) if Path(home).is_absolute() else Path.home() / ".local" / "state"
    return folder / "turtlewire" / "logo_history"


def _history() -> History:
    """The history; one that is forgotten, where none can be kept."""
    try:
        path = history_path()
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        path.touch(mode=0o600)
        with path.open("rb"):
            return _LastingHistory(path)
    except (OSError, RuntimeError):  # RuntimeError: nobody knows where home is
        return InMemoryHistory()
