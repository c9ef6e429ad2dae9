"""What to do about a wrong name: loaded when an error is shown, and not before."""

from __future__ import annotations

import re
from difflib import get_close_matches

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence

_NO_VALUE = 11
_PEN = "A robot has the pen that was put into it: its colour and size cannot be changed from a program."
_NOT_THERE = {
    "then": 'IF needs no THEN: if :n > 3 [print "big]',
    "else": 'Both lists stand behind the condition: if :n > 3 [print "big] [print "small]',
    "end": "END stands alone in its line, at the end of a procedure that began with TO.",
    "elseif": "There is no ELSEIF: put another IF into the second list.",
    "def": "A procedure is defined by TO and ends with END.",
    "let": 'A variable gets its value by MAKE: make "n 5',
    "set": 'A variable gets its value by MAKE: make "n 5',
    "return": "A procedure outputs its value by OUTPUT.",
    "circle": "A circle is an arc of 360 degrees: arc 360 50",
    "move": "Did you mean forward?",
    "turn": "Did you mean right?",
} | dict.fromkeys(["setpencolor", "setpc", "setpensize", "setpensz", "setpen", "penerase", "pe"], _PEN)


def about_name(number: int, name: str, known_names: Sequence[str]) -> str:
    """The hint for a name that nothing has, given the names that there are."""
    lowered = name.lower()
    close = get_close_matches(lowered, known_names, n=1, cutoff=0.7)
    if number == _NO_VALUE:
        return f"Did you mean :{close[0]}?" if close else f'Give it one first: make "{name} 5'
    if lowered in _NOT_THERE:
        return _NOT_THERE[lowered]
    bare = lowered.strip(",.;!'\u201c\u201d\u201e")
    if bare != lowered:
        if bare in known_names:
            return f"Did you mean {bare}? Nothing but spaces stands between words."
        return f'A word is written with one straight quote before it and none behind: "{bare}'
    stuck = re.match(r"([^\W\d]+)(?=[\d:\"])", lowered)
    if stuck and stuck[1] in known_names:
        return f"A space is missing after {name[: stuck.end()]}."
    if close:
        return f"Did you mean {close[0]}?"
    return (
        f'No procedure and no variable is called {name}. A word is written "{name}, the value of a variable :{name}; '
        f"a new procedure begins with TO {name}."
    )
