"""A robot that was examined gets its entry in ``robots.toml``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlencode

from turtlewire import configuration
from turtlewire.cli import output
from turtlewire.errors import DataError, UsageError
from turtlewire.examination.entry import lines
from turtlewire.examination.findings import FrameFacts

if TYPE_CHECKING:
    from turtlewire.examination import Findings

PLACEHOLDER = "NAME"


class Enrolment:
    """The entry of one robot, from where it is to the file.

    Args:
        name: what it is to be called, or empty.
        where: the lines that say where it is.
        is_replacing: whether a robot of that name at another port may lose its entry.

    Attributes:
        name: what it is called, once that is known.
        lines: of its entry.

    Raises ``UsageError`` for a name that cannot be used, ``DataError`` for a ``robots.toml`` that cannot be read.
    """

    def __init__(self, name: str, where: dict[str, Any], *, is_replacing: bool) -> None:
        self._where = where
        self._is_replacing = is_replacing
        self.name = ""
        self.lines: dict[str, Any] = {}
        self._lacking = ""
        # What stands there already of that robot.
        self._before: dict[str, Any] = {}
        if name:
            self._call(name)

    def _call(self, name: str) -> None:
        from turtlewire import robots_file

        robots_file.check_name(name)
        entry = configuration.entries().get(name)
        before = entry.table if entry is not None and isinstance(entry.table, dict) else {}
        port = before.get("port", self._where["port"])
        if port != self._where["port"] and not self._is_replacing:
            raise UsageError(
                f"{configuration.path()} has a robot {name} already, at {port}: choose another name, or --replace"
            )
        self.name, self._before = name, before

    def found(self, findings: Findings) -> None:
        """What the robot is."""
        self.lines = {**self._where, **lines(findings)}
        if self.lines["port"].startswith(configuration.SIM):
            del self.lines["protocol"]  # its port says it
        facts = findings.facts
        if isinstance(facts, FrameFacts) and findings.likelihood:
            if not facts.dialect:
                self._lacking = "no driver knows its messages"
            elif not facts.is_dialects_crc:
                self._lacking = (
                    f"its CRC is {facts.crc} from {facts.coverage}, and the dialect {facts.dialect} has another: make "
                    "a dialect of your own with that CRC (docs/protocols/frame.md), and give it with --dialect"
                )

    @property
    def toml(self) -> str:
        """The entry, as it would stand in the file."""
        import tomlkit

        text = tomlkit.dumps({self.name or PLACEHOLDER: self.lines})
        return "".join(f"  {line}\n" for line in text.splitlines())

    def is_wanted(self) -> bool:
        """Ask whether to write it, and under which name; where nobody can be asked, it is not wanted."""
        if self._lacking or not (sys.stdin.isatty() and sys.stderr.isatty()):
            return False
        if self.name:
            return _asked(f"write it to {configuration.path()}? [y/N] ").lower() in ("y", "yes")
        name = _asked(f"a name, to write it to {configuration.path()} (nothing: do not write it): ")
        if name:
            self._call(name)
        return bool(name)

    def write(self) -> list[Path]:
        """Write it; return the files that have changed.

        Raises ``DataError`` for a robot that cannot be driven, and what ``robots_file.write`` raises.
        """
        from turtlewire import robots_file

        if self._lacking:
            raise DataError(f"no entry was written: {self._lacking}")
        values = {**self._left_out(), **self.lines}
        files = robots_file.write(self.name, values)
        for file in files:
            output.tell(f"written to {file}")
        return files

    def _left_out(self) -> dict[str, None]:
        """What stands there and means nothing to a robot of another protocol."""
        target = configuration.Entry(Path(), self.name, {**self.lines}, 1).target()
        if self._before.get("protocol", "walter") == target.protocol:
            return {}
        known = configuration.SETTINGS[target.protocol]
        left_out = [key for key in self._before if key not in {*self.lines, *known, "faults"}]
        if left_out:
            output.tell(f"{self.name} speaks another protocol now; left out: {', '.join(left_out)}")
        return dict.fromkeys(left_out)

    def next_step(self, program: str, *, is_written: bool) -> str:
        """The command that may come next."""
        if self._lacking:
            return f"it cannot be driven yet: {self._lacking}\n"
        if is_written:
            return f"next:\n  turtlewire run {program} --robot {self.name}\n"
        rest = urlencode({key: value for key, value in self.lines.items() if key != "port"}, safe="/")
        port = f"{self.lines['port']}?{rest}" if rest else self.lines["port"]
        return f"next:\n  turtlewire run {program} --port '{port}'\n"


def _asked(question: str) -> str:
    """What somebody at the terminal answers."""
    sys.stderr.write(question)
    sys.stderr.flush()
    return sys.stdin.readline().strip()
