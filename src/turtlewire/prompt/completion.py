"""What a half-written word can become: primitives, procedures, and the names of variables."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from prompt_toolkit.completion import Completer, Completion

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from prompt_toolkit.completion import CompleteEvent
    from prompt_toolkit.document import Document

# Where a word begins: behind a space, bracket, parenthesis or operator.
WORD = re.compile(r"[^\s\[\](){}+\-*/=<>;]*\Z")


class LogoCompleter(Completer):
    """Completes the word before the cursor.

    Args:
        procedures: by name, in lower case: primitives and the user's own. Looked at whenever something is completed.
        variables: the same.
    """

    def __init__(self, procedures: Mapping[str, object], variables: Mapping[str, object]) -> None:
        self._procedures = procedures
        self._variables = variables

    def get_completions(self, document: Document, complete_event: CompleteEvent) -> Iterator[Completion]:
        """What the word before the cursor can become, in the order of the alphabet."""
        del complete_event
        match = WORD.search(document.text_before_cursor)
        assert match is not None  # it may be empty
        begun = match[0]
        sign = begun[:1] if begun[:1] in (":", '"') else ""
        stem = begun[len(sign) :]
        if not stem and not sign:
            return  # everything there is would be no help
        for name in sorted(self._names(sign)):
            if name.startswith(stem.lower()) and name != stem.lower():
                completed = name.upper() if stem.isupper() else stem + name[len(stem) :]
                yield Completion(sign + completed, -len(begun))

    def _names(self, sign: str) -> Iterable[str]:
        if sign == ":":
            return self._variables
        names = {name for name in self._procedures if name[0].isalpha() or name[0] in "._"}
        return names | set(self._variables) if sign else names
