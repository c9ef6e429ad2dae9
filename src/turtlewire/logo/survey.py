"""What a program mentions, without running it: names that get values, names that are read, what comes from elsewhere.

A list may be data or instructions, and nobody can tell before the program runs. So every list is looked at as if it
were run, and what may be a name counts as one: whoever asks here errs on the side of silence.
"""

from __future__ import annotations

from itertools import zip_longest
from typing import TYPE_CHECKING

from turtlewire.logo.errors import LogoError
from turtlewire.logo.reader import Definition, Line
from turtlewire.logo.tokens import DOTS, NAME, VALUE, Token, tokenize
from turtlewire.logo.values import plain

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

# Variables that Logo itself looks at, or gives their values.
SPECIAL = frozenset(
    (
        *(
            "allowgetset",
            "buttonact",
            "caseignoredp",
            "commandline",
            "editor",
            "erract",
            "fullprintp",
            "helploc",
        ),
        *(
            "keyact",
            "libloc",
            "loadnoisily",
            "logoplatform",
            "logoversion",
            "printdepthlimit",
            "printwidthlimit",
        ),
        *("redefp", "startup", "temploc", "unburyonedit", "usealternatenames"),
    )
)
# What gives the variable a value whose name is the first input; what only makes it local; what defines a procedure.
GIVERS = frozenset(("make", "localmake", "push", "queue", "global"))
LOCALS = frozenset(("local", "localmake"))
DEFINERS = frozenset(("define", ".defmacro", "copydef"))
# What brings in names that nobody has seen: other files, and text that becomes instructions.
OUTSIDE = frozenset(("load", "parse", "runparse", "readlist", "rl", "edit", "ed"))


class Words:
    """The names in some lines.

    Attributes:
        read: variables whose value is used, or may be.
        given: variables that get a value, or may.
        local: variables that are made local here, with the tokens that name them.
        defined: procedures that DEFINE and its like make.
        gives_unknown, reads_unknown, defines_unknown: whether names are computed, so that any may be meant.
    """

    def __init__(self) -> None:
        self.read: set[str] = set()
        self.given: set[str] = set()
        self.local: dict[str, Token] = {}
        self.defined: set[str] = set()
        self.gives_unknown = False
        self.reads_unknown = False
        self.defines_unknown = False

    def add(self, lines: Sequence[Line]) -> Words:
        """Look at more lines, and at the lists in them."""
        pending = list(lines)
        for line in pending:
            tokens = _tokens(line)
            pending += [token.value for token in tokens if isinstance(token.value, Line)]
            if line.items and isinstance(line.items[0], Line):  # of a lambda, it may be, the inputs
                self.given |= _words(line.items[0])
            before = ""
            for token, following in zip_longest(tokens, tokens[1:]):
                self._add(token, following, before)
                before = _key(token) if token.kind == NAME else ""
        return self

    def _add(self, token: Token, following: Token | None, before: str) -> None:
        key = _key(token)
        if token.kind == DOTS:
            self.read.add(key)
        elif token.kind == VALUE and isinstance(token.value, str):
            if before in GIVERS or before == "name":
                self.given.add(key)
            elif before not in LOCALS:
                self.read.add(key)
                self.given.add(key)  # whoever gets the name may give it a value
            if before in LOCALS:
                self.local.setdefault(key, token)
        elif token.kind == VALUE and isinstance(token.value, Line):
            if before == "for":
                self.given |= _words(Line(token.value.items[:1]))
            elif before in GIVERS or before in LOCALS:
                self.given |= _words(token.value)
        elif token.kind == NAME:
            self._add_call(key, following)

    def _add_call(self, key: str, following: Token | None) -> None:
        self.read.add(key)  # Logo's getters: a word may stand for the variable of its name
        is_known = (
            following is not None and following.kind == VALUE and isinstance(following.value, str | Line)
        )
        if key in DEFINERS:
            if is_known and following is not None and _key(following):
                self.defined.add(_key(following))
            else:
                self.defines_unknown = True
        elif key in GIVERS:
            self.gives_unknown = self.gives_unknown or not is_known
        elif key == "thing":
            self.reads_unknown = self.reads_unknown or not is_known
        elif key in OUTSIDE:
            self.gives_unknown = self.reads_unknown = self.defines_unknown = True


def _tokens(line: Line) -> list[Token]:
    """The tokens of a list; of one that cannot be instructions, its words."""
    try:
        return tokenize(line)
    except LogoError:
        return [Token(NAME if isinstance(item, str) else VALUE, item, None) for item in line.items]


def _words(line: Line) -> set[str]:
    return {plain(item).lstrip(":").lower() for item in line.items if isinstance(item, str)}


def _key(token: Token) -> str:
    return plain(token.value).lower() if isinstance(token.value, str) else ""


def lines_of(program: Sequence[Line | Definition]) -> Iterator[Line]:
    """Every line of a program, those of its procedures too; no titles."""
    for each in program:
        if isinstance(each, Definition):
            yield from each.body
        else:
            yield each
