"""Writing ``robots.toml``: some lines of one robot change, everything else stays as people wrote it, comments too."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from turtlewire import configuration, whole_file
from turtlewire.errors import DataError, OutputError, UsageError
from turtlewire.robots.calibration import KINDS, parse

if TYPE_CHECKING:
    from collections.abc import Mapping, MutableMapping

    from tomlkit import TOMLDocument


def write(name: str, values: Mapping[str, Any]) -> list[Path]:
    """Change lines of the table of one robot, which is added if it is new; return the files that have changed.

    Args:
        name: the robot's.
        values: what its lines are to say, by key; a mapping is a table of its own, of which lines change in the same
            way; None: there is to be no such line. A calibration that is in a file of its own stays there.

    Nothing is written unless the robot can be used then. Raises ``UsageError`` for a name or a line that means
    nothing, ``DataError`` for a file that is no TOML, ``OutputError`` for one that cannot be written.
    """
    check_name(name)
    file = configuration.path()
    document = _read(file)
    if name not in document:
        _add_table(document, name)
    table: Any = document[name]
    if not isinstance(table, dict):
        raise DataError(f"{file}: {name} is no table")
    values = dict(values)
    own, measured = table.get("calibration"), values.get("calibration")
    texts: dict[Path, str] = {}
    if isinstance(own, str) and isinstance(measured, dict):
        del values["calibration"]
        beside = file.parent / own
        own_file = beside if beside.is_file() else Path(own)
        calibration = _read(own_file)
        _change(calibration, measured)
        texts[own_file] = calibration.as_string()
        protocol = configuration.Entry(file, name, dict(table), 1).target().protocol
        parse(KINDS[protocol], texts[own_file], str(own_file))
    if values:
        rest = _cut_off(table)
        _change(table, values)
        _last(table).extend(rest)
        texts[file] = document.as_string()
        _check(file, name, texts[file])
    for path, text in texts.items():
        _save(path, text)
    return list(texts)


def check_name(name: str) -> None:
    """Raises ``UsageError`` for what cannot be the name of a robot."""
    if not configuration.NAME.fullmatch(name):
        raise UsageError(
            f"{name!r} cannot be the name of a robot: that is a letter, then letters, digits, - and _; "
            f"{', '.join(configuration.PROTOCOLS)}, pty, COM1 and the like mean something else"
        )


def _save(file: Path, text: str) -> None:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        whole_file.replace(file, text.encode())
    except OSError as error:
        raise OutputError(f"cannot write {file}: {error.strerror or error}") from error


def options(url: str) -> dict[str, Any]:
    """The lines that mean the same robot as a URL. Raises ``UsageError`` for an option that stands there twice."""
    port, _, query = url.partition("?")
    lines: dict[str, Any] = {"port": port}
    for key, text in configuration.options(repr(url), query).items():
        lines[key] = _value(text)
    return lines


def _value(text: str) -> object:
    """A number where it says the same."""
    for kind in (int, float):
        try:
            if str(kind(text)) == text:
                return kind(text)
        except ValueError:
            pass
    return text


def _read(file: Path) -> TOMLDocument:
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        return tomlkit.parse(file.read_bytes().decode())
    except FileNotFoundError:
        return tomlkit.document()
    except OSError as error:
        raise DataError(f"cannot read {file}: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise DataError(f"{file}, line {line}: this is not UTF-8") from None
    except TOMLKitError as error:
        raise DataError(f"{file}: {error}") from None


def _add_table(document: TOMLDocument, name: str) -> None:
    import tomlkit

    if document.as_string().strip():
        if not document.as_string().endswith("\n"):
            document.add(tomlkit.nl())
        document.add(tomlkit.nl())
    document.add(name, tomlkit.table())


def _last(table: Any) -> list[Any]:
    """What stands in the last of a robot's tables: keys with their values, blank lines, comments."""
    from tomlkit.items import Table

    body: list[Any] = table.value.body if isinstance(table, Table) else []
    for key, item in reversed(body):
        if key is not None:
            return _last(item) if isinstance(item, Table) else body
    return body


def _cut_off(table: Any) -> list[Any]:
    """Take away the blank line below a robot, and what follows: it is about the next one. Returns that."""
    from tomlkit.items import Whitespace

    body = _last(table)
    start = len(body)
    while start and body[start - 1][0] is None:
        start -= 1
    while start < len(body) and not (isinstance(body[start][1], Whitespace) and "\n" in body[start][1].s):
        start += 1
    rest = body[start:]
    del body[start:]
    return rest


def _change(table: MutableMapping[str, Any], values: Mapping[str, Any]) -> None:
    import tomlkit
    from tomlkit.items import Table

    added: list[str] = []
    body = table.value.body if isinstance(table, Table) else []
    indents = [(item.trivia, item.trivia.indent) for key, item in body if key is not None]
    for key, value in values.items():
        if value is None:
            table.pop(key, None)
        elif isinstance(value, dict):
            if not isinstance(table.get(key), dict):
                table.pop(key, None)
                table[key] = tomlkit.table()
            _change(table[key], value)
        else:
            if key not in table:
                added.append(key)
            table[key] = value
    # A blank line before a table within it, which was not there, is not wanted either.
    for trivia, indent in indents:
        trivia.indent = indent
    _move_up(table, added)


def _move_up(table: Any, added: list[str]) -> None:
    """New lines belong below those that a table has, and above comments about a table within it."""
    from tomlkit.items import Table

    if not isinstance(table, Table):
        return
    body = table.value.body
    new = [pair for pair in body if pair[0] is not None and pair[0].key in added]
    old = [pair for pair in body if pair not in new]
    at = max((i + 1 for i, (key, item) in enumerate(old) if key and not isinstance(item, Table)), default=0)
    # A comment below a line, without a blank one between, is about it.
    while at < len(old) and old[at][0] is None and "\n" not in old[at][1].as_string()[:1]:
        at += 1
    # Nothing is looked up in here any more: only the order counts.
    body[:] = [*old[:at], *new, *old[at:]]


def _check(file: Path, name: str, text: str) -> None:
    """Whether the robot can be used then. Raises ``DataError``."""
    try:
        table = tomllib.loads(text)[name]
    except tomllib.TOMLDecodeError as error:
        raise DataError(f"{file} cannot be changed by a program: {error}") from None
    configuration.Entry(file, name, table, 1).target()
