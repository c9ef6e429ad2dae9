"""Communication: what a program reads, from the keyboard or from a file."""

from __future__ import annotations

from turtlewire.logo.primitives.inputs import answer, natural
from turtlewire.logo.procedures import Chapter
from turtlewire.logo.receiving import list_of_line, word_of_line
from turtlewire.logo.values import NIL, Value, word

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive


@primitive("readlist rl", 0)
def _readlist(logo: Interpreter) -> Value:
    found = list_of_line(logo.streams.read_line)
    return "" if found is None else found


@primitive("readword rw", 0)
def _readword(logo: Interpreter) -> Value:
    found = word_of_line(logo.streams.read_line)
    return NIL if found is None else found


@primitive("readrawline", 0)
def _readrawline(logo: Interpreter) -> Value:
    line = logo.streams.read_line()
    return NIL if line is None else word(line)


@primitive("readchar rc", 0)
def _readchar(logo: Interpreter) -> Value:
    character = logo.streams.read_character()
    return word(character) if character else NIL


@primitive("readchars rcs", 1)
def _readchars(logo: Interpreter, count: Value) -> Value:
    wanted = natural(count)
    found: list[str] = []
    while len(found) < wanted:
        character = logo.streams.read_character()
        if not character:
            break
        found.append(character)
    return word("".join(found)) if found else NIL


@primitive("eofp eof?", 0)
def _eofp(logo: Interpreter) -> Value:
    file = logo.streams.reading
    return answer(condition=file is not None and file.is_at_end())


@primitive("keyp key? linep line?", 0)
def _keyp(logo: Interpreter) -> Value:
    file = logo.streams.reading
    if file is not None:
        return answer(condition=not file.is_at_end())
    return answer(condition=logo.streams.keyboard.has_key())
