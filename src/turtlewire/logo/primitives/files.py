"""Communication: files, opened and closed, read and written."""

from __future__ import annotations

import os

from turtlewire.logo.open_file import OpenFile
from turtlewire.logo.primitives.inputs import answer, key, natural, text
from turtlewire.logo.procedures import BadInputError, Chapter
from turtlewire.logo.streams import name_or_nil, not_open
from turtlewire.logo.values import NIL, List, Value, members_of, plain, show

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive

_NAME = "the name of a file, as one word; with spaces or signs in it between bars"


def file_name(value: Value) -> str:
    """The name of a file."""
    if not isinstance(value, str | int | float):
        raise BadInputError(value, 4, _NAME)
    return plain(text(value))


# --- opening and closing --------------------------------------------------------------------------------------


@primitive("openread", 1)
def _openread(logo: Interpreter, name: Value) -> None:
    logo.streams.open(file_name(name), "rb")


@primitive("openwrite", 1)
def _openwrite(logo: Interpreter, name: Value) -> None:
    if isinstance(name, list):
        logo.streams.open_buffer(name, _buffer_size(name))
    else:
        logo.streams.open(file_name(name), "wb")


@primitive("openappend", 1)
def _openappend(logo: Interpreter, name: Value) -> None:
    logo.streams.open(file_name(name), "ab")


@primitive("openupdate", 1)
def _openupdate(logo: Interpreter, name: Value) -> None:
    logo.streams.open(file_name(name), "r+b")


def _buffer_size(target: List) -> int:
    """The size of the buffer that a list ``[variable size]`` describes."""
    members = members_of(target)
    if (
        len(members) != 2
        or not isinstance(members[0], str)
        or not isinstance(members[1], int)
        or members[1] < 1
    ):
        raise BadInputError(
            target, 4, "a list of a variable's name and a number of characters, as in [text 1000]"
        )
    return members[1]


@primitive("close", 1)
def _close(logo: Interpreter, name: Value) -> None:
    if isinstance(name, list):
        if not logo.streams.has_buffer(name):
            raise not_open(
                show(name)[1:-1], "A buffer is closed by the same list that opened it, and no copy of it."
            )
        _close_buffer(logo, name)
    else:
        logo.streams.close(file_name(name))


def _close_buffer(logo: Interpreter, target: List) -> None:
    logo.variables[key(target[0])] = logo.streams.close_buffer(target)


@primitive("closeall", 0)
def _closeall(logo: Interpreter) -> None:
    for name in members_of(logo.streams.names):
        _close(logo, name)


@primitive("allopen", 0)
def _allopen(logo: Interpreter) -> Value:
    return logo.streams.names


@primitive("erasefile erf", 1)
def _erasefile(logo: Interpreter, name: Value) -> None:
    logo.streams.erase(file_name(name))


@primitive("filep file?", 1)
def _filep(logo: Interpreter, name: Value) -> Value:
    path = logo.streams.path(file_name(name))
    return answer(condition=path.is_file() and os.access(path, os.R_OK))


@primitive("setprefix", 1)
def _setprefix(logo: Interpreter, folder: Value) -> None:
    logo.streams.prefix = "" if folder == NIL else file_name(folder)


@primitive("prefix", 0)
def _prefix(logo: Interpreter) -> Value:
    return logo.streams.prefix or NIL


@primitive("dribble", 1)
def _dribble(logo: Interpreter, name: Value) -> None:
    logo.streams.dribble(file_name(name))


@primitive("nodribble", 0)
def _nodribble(logo: Interpreter) -> None:
    logo.streams.stop_dribbling()


# --- the file that is read, the file that is written ----------------------------------------------------------


@primitive("setread", 1)
def _setread(logo: Interpreter, name: Value) -> None:
    if isinstance(name, list) and name:
        raise not_open(show(name)[1:-1], "Only files are read, and their names are words.")
    logo.streams.read_from(None if isinstance(name, list) else file_name(name))


@primitive("setwrite", 1)
def _setwrite(logo: Interpreter, name: Value) -> None:
    streams = logo.streams
    implicit = streams.implicit_buffer()
    if not isinstance(name, list) or not name:
        streams.write_to(None if isinstance(name, list) else file_name(name))
    else:
        if not streams.has_buffer(name):
            streams.open_buffer(name, _buffer_size(name), is_implicit=True)
        streams.write_to(name)
    if implicit is not None and implicit is not name:
        target = streams.writer
        _close_buffer(logo, implicit)
        streams.write_to(target)


@primitive("reader", 0)
def _reader(logo: Interpreter) -> Value:
    return name_or_nil(logo.streams.reader)


@primitive("writer", 0)
def _writer(logo: Interpreter) -> Value:
    return name_or_nil(logo.streams.writer)


@primitive("setreadpos", 1)
def _setreadpos(logo: Interpreter, position: Value) -> None:
    wanted = natural(position)
    file = logo.streams.reading
    if file is not None:
        file.position = wanted


@primitive("readpos", 0)
def _readpos(logo: Interpreter) -> Value:
    file = logo.streams.reading
    return file.position if file is not None else 0


@primitive("setwritepos", 1)
def _setwritepos(logo: Interpreter, position: Value) -> None:
    wanted = natural(position)
    file = logo.streams.writing
    if isinstance(file, OpenFile):
        file.position = wanted


@primitive("writepos", 0)
def _writepos(logo: Interpreter) -> Value:
    file = logo.streams.writing
    return file.position if file is not None else 0
