"""Which robot is meant: a URL with options, or a name in ``robots.toml``; what it speaks, and how to drive it.

The file is ``~/.config/turtlewire/robots.toml`` (or below ``XDG_CONFIG_HOME``), with a table for each robot::

    [elsie]
    port = "/dev/ttyUSB0"
    protocol = "walter"
    speed = 60

Whatever such a table says, a URL can say too: ``/dev/ttyUSB0?protocol=walter&speed=60``.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import unquote, unquote_plus

from turtlewire.errors import DataError, UsageError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import TypeAlias

    from turtlewire.links.faults import Faults
    from turtlewire.robots.car import Settings as CarSettings
    from turtlewire.robots.two_engine import Settings as TwoEngineSettings
    from turtlewire.robots.walter import Settings as WalterSettings

    AnySettings: TypeAlias = WalterSettings | CarSettings | TwoEngineSettings

PROTOCOLS = ("walter", "simple", "frame")
SIM = "sim:"
PTY = ("pty", "pty:")
# What Windows calls its ports is no name of a robot.
NAME = re.compile(r"(?!COM\d+$|pty$|walter$|simple$|frame$)[A-Za-z][A-Za-z0-9_-]*", re.IGNORECASE)
OWN = {"serial": "a serial port has baud", "socket": "a socket has none"}
YES_NO = {
    **dict.fromkeys(("1", "yes", "on", "true"), True),
    **dict.fromkeys(("0", "no", "off", "false"), False),
}


class Kind(NamedTuple):
    """How a setting is read: ``read`` raises ``ValueError`` or ``KeyError`` for a text that is not ``wanted``."""

    read: Callable[[str], Any]
    wanted: str


def _dialect(text: str) -> object:
    from turtlewire.protocols.frame.dialect import SHIPPED, load, shipped

    return shipped(text) if text in SHIPPED else load(text)


def _car_calibration(text: str) -> object:
    from turtlewire.robots.calibration import CarCalibration, read

    return read(CarCalibration, text)


def _two_engine_calibration(text: str) -> object:
    from turtlewire.robots.calibration import TwoEngineCalibration, read

    return read(TwoEngineCalibration, text)


def _calibrated(protocol: str, table: dict[str, Any], where: str) -> dict[str, Any]:
    """The settings that a calibration in ``robots.toml`` itself says. Raises ``DataError``."""
    from turtlewire.robots.calibration import KINDS, made

    found = made(KINDS[protocol], table, f"{where}: calibration")
    return {name: getattr(found, name) for name in table} if protocol == "walter" else {"calibration": found}


def _turn(text: str) -> str:
    return {"spot": "spot", "arc": "arc"}[text]


WHOLE = Kind(int, "a whole number")
NUMBER = Kind(float, "a number")
SECONDS = Kind(lambda text: None if text == "never" else float(text), "a number of seconds, or never")
SWITCH = Kind(lambda text: YES_NO[text.lower()], "yes or no")
# The settings that a file names, whose place may be beside robots.toml.
FILES = ("calibration", "dialect", "arena")
SETTINGS: dict[str, dict[str, Kind]] = {
    "walter": {
        "baud": WHOLE,
        "speed": WHOLE,
        "mm_per_s_per_unit": NUMBER,
        "deg_per_s_per_unit": NUMBER,
        "distance_scale": NUMBER,
        "turn_scale": NUMBER,
        "groups": Kind(lambda text: frozenset(text.upper()), "some of C, Q, H and E"),
        "gentle": SWITCH,
        "boot_s": NUMBER,
        "reply_timeout_s": NUMBER,
        "max_unfenced": WHOLE,
        "heartbeat_s": SECONDS,
        "require_replies": SWITCH,
        "reconnect_s": NUMBER,
    },
    "simple": {
        "baud": WHOLE,
        "speed": WHOLE,
        "calibration": Kind(_car_calibration, "a file"),
        "turn": Kind(_turn, "spot or arc"),
        "turn_space_mm": NUMBER,
        "tolerance_mm": NUMBER,
        "pen_light": SWITCH,
        "window": WHOLE,
        "reply_delay_s": NUMBER,
        "retries": WHOLE,
        "boot_s": NUMBER,
        "heartbeat_s": SECONDS,
        "reconnect_s": NUMBER,
    },
    "frame": {
        "dialect": Kind(_dialect, "0.1, 0.1-literal, telemetry, or a file"),
        "baud": WHOLE,
        "speed": WHOLE,
        "calibration": Kind(_two_engine_calibration, "a file"),
        "tolerance_mm": NUMBER,
        "halts": WHOLE,
        "boot_s": NUMBER,
        "repeat_s": SECONDS,
        "heartbeat_s": SECONDS,
        "odometry_s": NUMBER,
        "reconnect_s": NUMBER,
    },
}


class Target(NamedTuple):
    """A robot: where it is, what it speaks, and how to drive it.

    Attributes:
        name: what people call it: its URL as they wrote it, or its name in ``robots.toml``.
        port: its port, without options; ``sim:simple`` for a simulated robot.
        protocol: ``walter``, ``simple`` or ``frame``.
        overrides: settings of its driver that differ from the defaults, by name.
        simulation: options of a simulated robot, as they were written.
        faults: what goes wrong on the way to it, if that is wanted.
    """

    name: str
    port: str
    protocol: str
    overrides: Mapping[str, Any] = {}
    simulation: Mapping[str, str] = {}
    faults: Faults | None = None

    @property
    def is_simulated(self) -> bool:
        """Whether it is a simulated robot in this process, in virtual time."""
        return self.port.startswith(SIM)

    def settings(self, base: AnySettings | None = None) -> AnySettings:
        """How to drive it: ``base``, or the defaults, changed as this says. Raises ``UsageError``."""
        if base is None:
            base = defaults(self.protocol)
        elif protocol_of(base) != self.protocol:
            raise UsageError(
                f"{self.name} speaks {self.protocol}, but the settings are those of a robot that speaks "
                f"{protocol_of(base)}"
            )
        return base._replace(**self.overrides).checked()


def target(url: str, protocol: str = "walter") -> Target:
    """The robot that a URL or a name means; ``protocol`` is what it speaks if the URL does not say.

    Raises ``UsageError`` or, for what is wrong in a file, ``DataError``.
    """
    if NAME.fullmatch(url):
        return _named(url)
    port, question, query = url.partition("?")
    given = options(repr(url), query) if question else {}
    if url.startswith(SIM):
        return _simulated(repr(url), port, given)._replace(name=url)
    return _at_port(repr(url), port, _port_kind(port), given, protocol)._replace(name=url)


def read_setting(protocol: str, name: str, text: str, where: str) -> object:
    """The value of a setting. Raises ``UsageError``, whose text begins with ``where``."""
    kind = SETTINGS[protocol][name]
    try:
        return kind.read(text)
    except (ValueError, KeyError):
        raise UsageError(f"{where}: {name} is {text!r}, but must be {kind.wanted}") from None


def protocol_of(settings: AnySettings) -> str:
    """Which protocol a driver's settings are for. Raises ``UsageError`` if they are none."""
    from turtlewire.robots import walter

    if isinstance(settings, walter.Settings):
        return "walter"
    from turtlewire.robots import car, two_engine

    if isinstance(settings, car.Settings):
        return "simple"
    if isinstance(settings, two_engine.Settings):
        return "frame"
    raise UsageError(f"settings must be the Settings of a robot's driver, but are {settings!r}")


def defaults(protocol: str) -> AnySettings:
    """How robots that speak a protocol are driven, unless something else is said."""
    if protocol == "walter":
        from turtlewire.robots import walter

        return walter.Settings()
    if protocol == "simple":
        from turtlewire.robots import car

        return car.Settings()
    from turtlewire.robots import two_engine

    return two_engine.Settings()


# ---------------------------------------------------------------- URLs


def options(where: str, query: str) -> dict[str, str]:
    """What stands behind the ? of a URL, by name. Raises ``UsageError``, whose text begins with ``where``."""
    options: dict[str, str] = {}
    for part in filter(None, query.split("&")):
        name, _, text = part.partition("=")
        name = unquote_plus(name)
        if name in options:
            raise UsageError(f"{where}: {name} stands there twice")
        # A + is a part of faults: stall:5+2.
        options[name] = unquote(text) if name == "faults" else unquote_plus(text)
    return options


def _faults(where: str, options: dict[str, str]) -> Faults | None:
    text = options.pop("faults", None)
    if text is None:
        return None
    from turtlewire.links.faults import Faults

    try:
        return Faults.parse(text)
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from None


def _simulated(where: str, port: str, options: dict[str, str]) -> Target:
    protocol = port.removeprefix(SIM)
    if protocol not in PROTOCOLS or options.pop("protocol", protocol) != protocol:
        raise UsageError(
            f"{where}: there is no simulated robot {protocol!r}; there is sim:walter, sim:simple and sim:frame"
        )
    faults = _faults(where, options)
    return Target(port, port, protocol, simulation=options, faults=faults)


def _port_kind(port: str) -> str:
    from turtlewire.links.port import Port

    return Port.parse(port).kind


def _at_port(where: str, port: str, kind: str, options: dict[str, str], protocol: str) -> Target:
    protocol = options.pop("protocol", protocol)
    if protocol not in PROTOCOLS:
        raise UsageError(f"{where}: protocol is {protocol!r}, but must be walter, simple or frame")
    faults = _faults(where, options)
    overrides: dict[str, Any] = {}
    for name, text in options.items():
        if name not in SETTINGS[protocol]:
            own = f"; {OWN[kind]}" if kind in OWN else ""
            raise UsageError(
                f"{where}: unknown option {name!r}{own}. Any robot may have protocol and faults, and one that speaks "
                f"{protocol}: {', '.join(SETTINGS[protocol])}"
            )
        overrides[name] = read_setting(protocol, name, text, where)
    return Target(port, port, protocol, overrides, faults=faults)


# ---------------------------------------------------------------- robots.toml


class Entry(NamedTuple):
    """One robot as ``robots.toml`` has it: its name, what its table says, and in which line that begins."""

    file: Path
    name: str
    table: object
    line: int

    def target(self) -> Target:
        """The robot. Raises ``DataError`` that says where the file is wrong, and what is allowed."""
        where = f"{self.file}, line {self.line}, [{self.name}]"
        try:
            return self._target(where)
        except UsageError as error:
            text = str(error)
            raise DataError(text if text.startswith(where) else f"{where}: {text}") from None

    def _target(self, where: str) -> Target:
        if not NAME.fullmatch(self.name):
            raise UsageError(
                "a robot's name is a letter, then letters, digits, - and _; "
                f"{', '.join(PROTOCOLS)}, pty, COM1 and the like mean something else"
            )
        if not isinstance(self.table, dict):
            raise UsageError("a robot is a table, with a port, a protocol and settings")
        measured = self.table.get("calibration")
        here = isinstance(measured, dict)
        options = {
            key: self._text(key, value)
            for key, value in self.table.items()
            if not here or key != "calibration"
        }
        port = options.pop("port", "")
        if not port or "?" in port or NAME.fullmatch(port):
            raise UsageError(
                f'port is {port!r}, but must be where the robot is, such as "/dev/ttyUSB0" or '
                '"socket://robot.local:2000"; what is behind the ? of a URL has lines of its own'
            )
        if port.startswith(SIM):
            found = _simulated(where, port, options)
        else:
            found = _at_port(where, port, _port_kind(port), options, "walter")
        if isinstance(measured, dict):
            calibrated = _calibrated(found.protocol, measured, where)
            found = found._replace(overrides={**found.overrides, **calibrated})
        found.settings()  # whether they can drive a robot
        return found._replace(name=self.name)

    def _text(self, key: str, value: object) -> str:
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, int | float):
            return str(value)
        if not isinstance(value, str):
            raise UsageError(f"{key} is {value!r}, but must be a text, a number, true or false")
        beside = self.file.parent / value
        return str(beside) if key in FILES and beside.is_file() else value


def path() -> Path:
    """Where ``robots.toml`` is, or would be."""
    home = os.environ.get("XDG_CONFIG_HOME", "")
    # The standard says that a relative one is to be ignored.
    folder = Path(home) if Path(home).is_absolute() else Path.home() / ".config"
    return folder / "turtlewire" / "robots.toml"


def entries() -> dict[str, Entry]:
    """The robots in ``robots.toml``, none of them checked yet. Raises ``DataError`` for a file that is no TOML."""
    import tomllib

    file = path()
    try:
        text = file.read_text("utf-8")
        tables = tomllib.loads(text)
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise DataError(f"cannot read {file}: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise DataError(f"{file}, line {line}: this is not UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise DataError(f"{file}: {error}") from None
    return {name: Entry(file, name, table, _line(text, name)) for name, table in tables.items()}


def _line(text: str, name: str) -> int:
    """Where a table, or a line with a value, begins."""
    found = re.search(rf"^[ \t]*(\[[ \t]*)?[\"']?{re.escape(name)}\b", text, re.MULTILINE)
    return text.count("\n", 0, found.start()) + 1 if found else 1


def _named(name: str) -> Target:
    robots = entries()
    if name in robots:
        return robots[name].target()
    from turtlewire.links.port import FORMS

    raise UsageError(f"{name!r} is no port: write {FORMS}; or the name of a robot: {known()}")


def known() -> str:
    """Which names there are."""
    file = path()
    if not file.exists():
        return f"{file} would have them, but does not exist"
    return f"{file} has {', '.join(entries()) or 'none'}"
