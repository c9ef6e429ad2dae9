"""The mistakes: what may become of a line of the core. They rely on its layout, which clang-format keeps."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterator

# An operator with a space on both sides, and what it is taken for.
SWAPS = {
    "<": ("<=", ">="),
    "<=": ("<", ">"),
    ">": (">=", "<="),
    ">=": (">", "<"),
    "==": ("!=",),
    "!=": ("==",),
    "&&": ("||",),
    "||": ("&&",),
    "+": ("-",),
    "-": ("+",),
    "*": ("+",),
    "%": ("*",),
    "&": ("|",),
    "|": ("&",),
    "^": ("|",),
    "<<": (">>",),
    ">>": ("<<",),
}
BINARY = re.compile(r"(?<= )(" + "|".join(map(re.escape, sorted(SWAPS, key=len, reverse=True))) + r")(?= )")
STEP = re.compile(r"\+\+|--")
NOT = re.compile(r"(?<=[( ])!(?=[\w:(])")
TRUTH = re.compile(r"\b(true|false)\b")
REAL = re.compile(r"(?<![\w.])(\d+\.\d+)F\b")
WHOLE = re.compile(r"(?<![\w.'])(0x[0-9A-Fa-f]+|\d+)(?=(?:UL|U|L)?\b)(?!\.)")
LETTER = re.compile(r"'(\\?.)'")
CHOICE = re.compile(r"(?<= )\? (.+?) : ([^:]+?)(?=[;)])")
# A statement on a line of its own, or behind a `case`: a call, an assignment, a step. No declaration, no jump.
STATEMENT = re.compile(r"^(?P<before>\s*(?:case [^:]+: |default: )?)(?P<statement>[^\s(){}=][^{}]*?;)")
NO_STATEMENT = re.compile(r"^(return|break|continue|const|constexpr|static)\b|^[\w:&<>]+ \w+( =|;|\()")
BREAK = re.compile(r" break;$")
IGNORED = re.compile(r"^\s*(#|//|static_assert|namespace|template|using|typedef)|^\s*\w+,?$|TURTLEWIRE_")


class Mutant(NamedTuple):
    """One mistake: in a file, on a line (from 1), which becomes another one."""

    file: str
    line: int
    original: str
    mutated: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.original.strip()}  ->  {self.mutated.strip() or '(deleted)'}"


def mutants(file: str, text: str) -> list[Mutant]:
    """All mistakes in a file, by line, none twice."""
    found: dict[Mutant, None] = {}
    for number, whole in enumerate(text.splitlines(), 1):
        code = whole.partition("  // ")[0].rstrip()
        if not code or IGNORED.search(code):
            continue
        for mutated in lines(code):
            if mutated != code:
                found[Mutant(file, number, code, mutated)] = None
    return list(found)


def lines(code: str) -> Iterator[str]:
    """What may become of one line."""
    for match in BINARY.finditer(code):
        yield from (_replaced(code, match, other) for other in SWAPS[match[1]])
    for match in STEP.finditer(code):
        yield _replaced(code, match, "--" if match[0] == "++" else "++")
    for match in NOT.finditer(code):
        yield _replaced(code, match, "")
    for match in TRUTH.finditer(code):
        yield _replaced(code, match, "false" if match[0] == "true" else "true")
    for match in REAL.finditer(code):
        yield _replaced(code, match, f"{float(match[1]) + 1}F")
    for match in WHOLE.finditer(code):
        number = int(match[1], 0)
        yield from (_replaced(code, match, str(other)) for other in (number + 1, number - 1) if other >= 0)
    for match in LETTER.finditer(code):
        yield _replaced(code, match, str(ord(match[1][-1]) + 1))
    for match in CHOICE.finditer(code):
        yield _replaced(code, match, f"? {match[2]} : {match[1]}")
    statement = STATEMENT.match(code)
    if statement and not NO_STATEMENT.match(statement["statement"]):
        yield code[: statement.start("statement")] + code[statement.end() :].lstrip()
    if BREAK.search(code) and "default:" not in code:
        yield BREAK.sub("", code)


def _replaced(code: str, match: re.Match[str], other: str) -> str:
    return code[: match.start()] + other + code[match.end() :]
