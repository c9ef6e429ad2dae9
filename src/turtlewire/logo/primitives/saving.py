"""Workspace control: saving it to files and loading it again, and what is asked about memory."""

from __future__ import annotations

import gc
import sys

from turtlewire import whole_file
from turtlewire.logo.definitions import define_from_title
from turtlewire.logo.errors import LogoError
from turtlewire.logo.open_file import cannot_open
from turtlewire.logo.primitives.files import file_name
from turtlewire.logo.primitives.inputs import integer
from turtlewire.logo.primitives.inspection import all_contents, contents_of, definitions
from turtlewire.logo.procedures import COMMAND, BadInputError, Chapter
from turtlewire.logo.reader import Definition, read
from turtlewire.logo.values import TRUE, make_list

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.marks import Contents
    from turtlewire.logo.values import Value

chapter = Chapter()
primitive = chapter.primitive


def _save(logo: Interpreter, contents: Contents, name: str) -> None:
    path = logo.streams.path(name)
    text = definitions(logo, contents)
    try:
        whole_file.replace(path, text.encode("utf-8"))
    except OSError as error:
        raise cannot_open(name, error, path) from None


@primitive("save", 1, minimum=0)
def _save_all(logo: Interpreter, name: Value | None = None) -> None:
    if name is None and not logo.streams.latest:
        raise LogoError(
            6,
            "not enough inputs to save",
            hint="(save) takes the file that was loaded or saved last; there is none.",
        )
    logo.streams.latest = logo.streams.latest if name is None else _loadable(name)
    _save(logo, all_contents(logo), logo.streams.latest)


@primitive("savel", 2)
def _savel(logo: Interpreter, what: Value, name: Value) -> None:
    _save(logo, contents_of(what), _loadable(name))


def _loadable(name: Value) -> str:
    if not isinstance(name, str | int | float):
        raise BadInputError(name, 4, "the name of a file")
    return file_name(name)


@primitive("load", 1)
def _load(logo: Interpreter, name: Value) -> None:
    """Run a file's instructions as if they stood at top level, and then the list that it gave to STARTUP."""
    file = _loadable(name)
    program = read(logo.streams.read_all(file), str(logo.streams.path(file)))
    logo.streams.latest = file
    startup = logo.variables.get("startup")
    procedure, logo.procedure = logo.procedure, None
    try:
        for line in program:
            if isinstance(line, Definition):
                _define(logo, line)
            else:
                logo.run_line(line, COMMAND)
        fresh = logo.variables.get("startup")
        if isinstance(fresh, list) and fresh and fresh is not startup:
            logo.run_list(fresh, COMMAND)
    finally:
        logo.procedure = procedure


def _define(logo: Interpreter, definition: Definition) -> None:
    define_from_title(logo, definition)
    noisily = logo.variables.get("loadnoisily")
    if isinstance(noisily, str) and noisily.lower() == TRUE:
        logo.write(f"{definition.title.items[1]} defined\n")


# --- memory ---------------------------------------------------------------------------------------------------


@primitive("gc", 0, maximum=1)
def _gc(_logo: Interpreter, _anything: Value = "") -> None:
    gc.collect()


@primitive("nodes", 0)
def _nodes(logo: Interpreter) -> Value:
    """Python's blocks of memory: those in use, and the most that were when this was asked."""
    used = sys.getallocatedblocks()
    logo.marks.most_nodes = max(logo.marks.most_nodes, used)
    return make_list((used, logo.marks.most_nodes))


@primitive(".setsegmentsize", 1)
def _setsegmentsize(_logo: Interpreter, size: Value) -> None:
    """Python allocates memory as it likes: only the input is looked at."""
    if integer(size) < 0:
        raise BadInputError(size, wanted="a whole number, more than 0")
