"""A dialect's TOML file, read and checked: every error names the file and the line (F10)."""

from __future__ import annotations

import keyword
import math
import re
import tomllib
from typing import Any, NamedTuple, NoReturn

from turtlewire.errors import DataError
from turtlewire.protocols.checksums import Coverage, algorithm
from turtlewire.protocols.frame.lines import Path, line_of, lines
from turtlewire.protocols.frame.message import MAX_PAYLOAD
from turtlewire.protocols.frame.words import CPP_WORDS, TAKEN
from turtlewire.protocols.message import KINDS, AnyField, Field, RealField, nearest_f32, text_name

DIRECTIONS = ("to robot", "from robot", "both")
FIELD_KINDS = tuple(kind for kind in KINDS if kind != "bit")
F32_MAX = (2.0 - 2.0**-23) * 2.0**127


class DialectError(DataError):
    """A dialect's file is wrong.

    Attributes:
        file: its name.
        line: counted from 1.
    """

    def __init__(self, file: str, line: int, what: str) -> None:
        super().__init__(f"{file}, line {line}: {what}")
        self.file = file
        self.line = line


class MessageDescription(NamedTuple):
    """One message as the file describes it.

    ``limited`` maps a field's name to the count that its values stay below; ``key`` is the field that has one.
    """

    name: str
    type: int
    direction: str
    doc: str
    channel: str
    stop: dict[str, float] | None
    fields: tuple[AnyField, ...]
    key: str
    below: str


class AmbiguousDescription(NamedTuple):
    """What a decoder reports for a type that several messages share (F1)."""

    name: str
    messages: tuple[str, ...]
    doc: str


class Description(NamedTuple):
    """A whole dialect as its file describes it."""

    name: str
    title: str
    baud: int
    algorithm: str
    coverage: str
    counts: dict[str, int]
    enumerations: dict[str, dict[str, int]]
    messages: tuple[MessageDescription, ...]
    ambiguous: tuple[AmbiguousDescription, ...]


class _Reader:
    """Reads one file."""

    def __init__(self, text: str, file: str) -> None:
        self.file = file
        try:
            self.data: dict[str, Any] = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            place = re.search(r" \(at (?:line (\d+), .*|end of document)\)$", str(error))
            at = int(place[1]) if place and place[1] else text.count("\n") + 1
            what = str(error)[: place.start()] if place else str(error)
            raise DialectError(file, at, f"not TOML: {what}") from None
        self.lines = lines(text.replace("\r\n", "\n"))

    def fail(self, path: Path, what: str) -> NoReturn:
        raise DialectError(self.file, line_of(self.lines, path), what)

    def take(self, table: dict[str, Any], path: Path, key: str, kind: type, default: Any = None) -> Any:
        """The value of a key, of the right kind; the default if there is one."""
        if key not in table:
            if default is None:
                self.fail(path, f"{key!r} is missing")
            return default
        value = table[key]
        if type(value) is not kind:
            words = {str: "text", int: "a whole number", dict: "a table", list: "a list"}
            self.fail((*path, key), f"{key} must be {words[kind]}, not {value!r}")
        return value

    def only(self, table: dict[str, Any], path: Path, known: str) -> None:
        """No key but these."""
        for key in table:
            if key not in known.split():
                self.fail((*path, key), f"there is no {key!r} here; known are {', '.join(known.split())}")

    def name(self, value: str, path: Path, pattern: str, example: str) -> str:
        if not re.fullmatch(pattern, value):
            self.fail(path, f"{value!r} is no name for this; one looks like {example}")
        if value in CPP_WORDS or keyword.iskeyword(value) or value in TAKEN:
            self.fail(path, f"{value!r} is a word that Python, C++ or turtlewire keeps for itself")
        return value

    def number(self, value: Any, path: Path, what: str, low: int, high: int) -> int:
        if type(value) is not int or not low <= value <= high:
            self.fail(path, f"{what} must be a whole number from {low} to {high}, not {value!r}")
        return value

    # ------------------------------------------------------------------ the parts of a file

    def whole(self) -> Description:
        data = self.data
        known = "protocol dialect title baud crc counts enumerations message ambiguous"
        self.only(data, (), known)
        if self.take(data, (), "protocol", str) != "frame":
            self.fail(("protocol",), f"this describes a dialect of frame, not of {data['protocol']!r}")
        name = self.take(data, (), "dialect", str)
        crc = self.take(data, (), "crc", dict, {})
        self.only(crc, ("crc",), "algorithm coverage")
        algorithm_name = self.take(crc, ("crc",), "algorithm", str, "CRC-8/SMBUS")
        try:
            algorithm_name = algorithm(algorithm_name).name
        except DataError as error:
            self.fail(("crc", "algorithm"), str(error))
        coverage = self.take(crc, ("crc",), "coverage", str, Coverage.MAGIC.value)
        coverages = [c.value for c in Coverage]
        if coverage not in coverages:
            self.fail(
                ("crc", "coverage"), f"coverage must be one of {', '.join(coverages)}, not {coverage!r}"
            )
        counts = self.take(data, (), "counts", dict, {})
        for key, value in counts.items():
            self.name(key, ("counts", key), r"[a-z][a-z0-9_]*", "engines")
            self.number(value, ("counts", key), "a count", 0, 256)
        enumerations = self.take(data, (), "enumerations", dict, {})
        for key, members in enumerations.items():
            self.enumeration(key, members)
        described = self.take(data, (), "message", list, [])
        if not described:
            self.fail((), "a dialect needs at least one [[message]]")
        messages = tuple(
            self.message(m, ("message", n), counts, enumerations) for n, m in enumerate(described)
        )
        self.check_names(messages, ())
        rest = self.take(data, (), "ambiguous", list, [])
        ambiguous = tuple(self.ambiguous(a, ("ambiguous", n), messages) for n, a in enumerate(rest))
        self.check_names(messages, ambiguous)
        self.check_types(messages, ambiguous)
        title = self.take(data, (), "title", str, name)
        baud = self.number(data.get("baud", 115200), ("baud",), "baud", 1, 100_000_000)
        return Description(
            name, title, baud, algorithm_name, coverage, counts, enumerations, messages, ambiguous
        )

    def enumeration(self, name: str, members: Any) -> None:
        path: Path = ("enumerations", name)
        self.name(name, path, r"[a-z][a-z0-9_]*", "state")
        if not isinstance(members, dict) or not members:
            self.fail(path, f"an enumeration looks like {name} = {{ idle = 0, driving = 1 }}")
        numbers: dict[int, str] = {}
        for key, value in members.items():
            self.name(key, (*path, key), r"[a-z][a-z0-9_]*", "idle")
            self.number(value, (*path, key), key, -(1 << 31), (1 << 32) - 1)
            if value in numbers:
                self.fail((*path, key), f"{key} has the number of {numbers[value]}: {value}")
            numbers[value] = key

    def message(
        self, table: Any, path: Path, counts: dict[str, int], enumerations: dict[str, dict[str, int]]
    ) -> MessageDescription:
        if not isinstance(table, dict):
            self.fail(path, "a message is a table: begin it with [[message]]")
        self.only(table, path, "name type direction doc channel stop fields")
        name = self.take(table, path, "name", str)
        self.name(name, (*path, "name"), r"[A-Z][A-Za-z0-9]*", "SetLamp")
        number = self.number(self.take(table, path, "type", int), (*path, "type"), "type", 0, 255)
        direction = self.take(table, path, "direction", str)
        if direction not in DIRECTIONS:
            self.fail(
                (*path, "direction"), f"direction must be one of {', '.join(DIRECTIONS)}, not {direction!r}"
            )
        fields: list[AnyField] = []
        key = below = ""
        size = 1
        for n, described in enumerate(self.take(table, path, "fields", list, [])):
            place = (*path, "fields", n)
            field, count = self.field(described, place, counts, enumerations)
            if field.name in [f.name for f in fields]:
                self.fail((*place, "name"), f"{name} has two fields {field.name!r}")
            if count and below:
                self.fail(
                    (*place, "below"), f"{name} has two fields with 'below': only one can be its number"
                )
            if count:
                key, below = field.name, count
            fields.append(field)
            size += KINDS[field.kind][0]
            if size > MAX_PAYLOAD:
                self.fail(place, f"with this field {name} has {size} bytes; a frame carries {MAX_PAYLOAD}")
        channel = self.take(table, path, "channel", str, "")
        if channel:
            self.name(channel, (*path, "channel"), r"[a-z][a-z0-9_]*", "wheels")
            if direction == "from robot":
                self.fail((*path, "channel"), "only messages to the robot are set-points of a channel")
        stop = table.get("stop")
        if stop is not None:
            self.check_stop(stop, (*path, "stop"), direction, key, fields)
        doc = self.take(table, path, "doc", str, "")
        return MessageDescription(name, number, direction, doc, channel, stop, tuple(fields), key, below)

    def check_stop(self, stop: Any, path: Path, direction: str, key: str, fields: list[AnyField]) -> None:
        if direction == "from robot":
            self.fail(path, "only messages to the robot can stop it")
        if not isinstance(stop, dict):
            self.fail(path, "stop looks like { speed = 0 }: a value for every field but the one with 'below'")
        wanted = {field.name: field for field in fields if field.name != key}
        for name, value in stop.items():
            if name not in wanted:
                self.fail((*path, name), f"{name!r} is no field that stop can set")
            if (isinstance(value, bool) and wanted[name].kind != "bool") or not wanted[name].fits(value):
                self.fail((*path, name), f"{name} must be {wanted[name].expectation()}, not {value!r}")
        if missing := [name for name in wanted if name not in stop]:
            self.fail(path, f"stop lacks {' and '.join(missing)}")

    def field(
        self, table: Any, path: Path, counts: dict[str, int], enumerations: dict[str, dict[str, int]]
    ) -> tuple[AnyField, str]:
        """A field, and the count that its values stay below, if there is one."""
        if not isinstance(table, dict):
            self.fail(path, 'a field looks like { name = "speed", kind = "u8", unit = "mm/s" }')
        self.only(table, path, "name kind unit min max below enumeration")
        name = self.take(table, path, "name", str)
        self.name(name, (*path, "name"), r"[a-z][a-z0-9_]*", "speed_mm_per_s")
        kind = self.take(table, path, "kind", str)
        if kind not in FIELD_KINDS:
            self.fail((*path, "kind"), f"kind must be one of {', '.join(FIELD_KINDS)}, not {kind!r}")
        unit = self.take(table, path, "unit", str, "number")
        given = [key for key in ("min", "max", "below", "enumeration") if key in table]
        if kind == "f32":
            return self.real(table, path, name, unit, given), ""
        if kind == "bool" and given:
            self.fail((*path, given[0]), "a bool is 0 or 1: it has no other range")
        if ("below" in given or "enumeration" in given) and len(given) > 1:
            self.fail((*path, given[-1]), f"{' and '.join(given)} exclude one another")
        size, signed = KINDS[kind]
        top = 1 if kind == "bool" else (1 << (8 * size - signed)) - 1
        bottom = -top - 1 if signed else 0
        low = self.number(table.get("min", bottom), (*path, "min"), "min", bottom, top)
        high = self.number(table.get("max", top), (*path, "max"), "max", bottom, top)
        if low > high:
            self.fail((*path, given[0]), f"min {low} is above max {high}")
        if "below" in given:
            below = self.take(table, path, "below", str)
            if below not in counts:
                self.fail((*path, "below"), f"there is no {below!r} in [counts]")
            return Field(name, kind, low, high, unit), below
        choices: tuple[tuple[str, int], ...] = ()
        if "enumeration" in given:
            enumeration = self.take(table, path, "enumeration", str)
            if enumeration not in enumerations:
                self.fail((*path, "enumeration"), f"there is no {enumeration!r} in [enumerations]")
            choices = tuple(enumerations[enumeration].items())
            for choice, number in choices:
                if not bottom <= number <= top:
                    self.fail((*path, "kind"), f"{choice} of {enumeration} is {number}: too much for {kind}")
        return Field(name, kind, low, high, unit, choices), ""

    def real(self, table: dict[str, Any], path: Path, name: str, unit: str, given: list[str]) -> RealField:
        ends = []
        for key, default in (("min", -F32_MAX), ("max", F32_MAX)):
            value = table.get(key, default)
            if type(value) not in (int, float) or not math.isfinite(value) or abs(value) > F32_MAX:
                self.fail((*path, key), f"{key} must be a number that an f32 can be, not {value!r}")
            # A value at the end of the range is rounded like any other: the end is rounded with it.
            ends.append(nearest_f32(value))
        for key in ("below", "enumeration"):
            if key in given:
                self.fail((*path, key), f"an f32 has no {key!r}, only min and max")
        low, high = ends
        if low > high:
            self.fail((*path, given[0]), f"min {low:g} is above max {high:g}")
        return RealField(name, "f32", low, high, unit)

    def ambiguous(
        self, table: Any, path: Path, messages: tuple[MessageDescription, ...]
    ) -> AmbiguousDescription:
        if not isinstance(table, dict):
            self.fail(path, "what is ambiguous is a table: begin it with [[ambiguous]]")
        self.only(table, path, "name messages doc")
        name = self.take(table, path, "name", str)
        self.name(name, (*path, "name"), r"[A-Z][A-Za-z0-9]*", "EngineDirectionUnknown")
        names = self.take(table, path, "messages", list)
        by_name = {message.name: message for message in messages}
        for n, one in enumerate(names):
            if one not in by_name:
                self.fail((*path, "messages", n), f"there is no message {one!r}")
        if len(set(names)) < 2 or len({(by_name[n].type, by_name[n].direction) for n in names}) > 1:
            self.fail((*path, "messages"), "these are not several messages of one type and direction")
        if len({(by_name[n].fields, by_name[n].below) for n in names}) > 1:
            self.fail((*path, "messages"), "messages of one type must have the same fields")
        return AmbiguousDescription(name, tuple(names), self.take(table, path, "doc", str, ""))

    def check_names(
        self, messages: tuple[MessageDescription, ...], ambiguous: tuple[AmbiguousDescription, ...]
    ) -> None:
        names: dict[str, str] = {}
        places: list[Path] = [("message", n, "name") for n in range(len(messages))]
        places += [("ambiguous", n, "name") for n in range(len(ambiguous))]
        for name, path in zip([d.name for d in messages] + [d.name for d in ambiguous], places, strict=True):
            text = text_name(name)
            if text in names:
                self.fail(path, f"{name} and {names[text]} have the same name in text: {text}")
            names[text] = name

    def check_types(
        self, messages: tuple[MessageDescription, ...], ambiguous: tuple[AmbiguousDescription, ...]
    ) -> None:
        shared = [frozenset(a.messages) for a in ambiguous]
        taken: dict[tuple[int, str], str] = {}
        for n, message in enumerate(messages):
            sides = DIRECTIONS[:2] if message.direction == "both" else (message.direction,)
            for side in sides:
                other = taken.setdefault((message.type, side), message.name)
                if other != message.name and not any({other, message.name} <= names for names in shared):
                    self.fail(
                        ("message", n, "type"),
                        f"{message.name} has the type of {other}, {message.type:02X}, {side}: nobody could tell "
                        "them apart. Change one, or say in [[ambiguous]] what a decoder shall report",
                    )


def read(text: str, file: str) -> Description:
    """Read a dialect's description. Raises ``DialectError`` naming the file and the line."""
    return _Reader(text, file).whole()
