"""``turtlewire robots``: the robots that ``robots.toml`` names."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from turtlewire.cli import options, output
from turtlewire.errors import DataError, TurtlewireError

if TYPE_CHECKING:
    import argparse

    from turtlewire.cli.signals import Signals
    from turtlewire.configuration import Entry

EXAMPLES = """\
examples:
  turtlewire robots
  turtlewire robots --json
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "robots",
        summary="list the robots that have a name",
        description="List the robots in robots.toml, and say what is wrong with those that cannot be used.",
        examples=EXAMPLES,
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """List them; the exit code says whether all of them can be used."""
    from turtlewire.configuration import entries, path

    del signals
    robots = [_known(entry) for entry in entries().values()]
    if arguments.json:
        output.write(json.dumps({"file": str(path()), "robots": robots}) + "\n")
    elif not robots:
        output.tell(f"there are no robots in {path()}; `turtlewire ports` shows where some may be")
    for robot in robots if not arguments.json else ():
        if robot["error"] is None:
            texts = {k: "measured" if isinstance(v, dict) else v for k, v in robot["settings"].items()}
            settings = "".join(f", {key} {value}" for key, value in texts.items())
            output.write(f"{robot['name']:<12} {robot['protocol']:<8} {robot['port']}{settings}\n")
        else:
            output.tell(f"turtlewire: {robot['error']}")
    return DataError.exit_code if any(robot["error"] for robot in robots) else 0


def _known(entry: Entry) -> dict[str, Any]:
    from turtlewire.simulated import simulated

    known: dict[str, Any] = {
        "name": entry.name,
        "port": None,
        "protocol": None,
        "settings": {},
        "error": None,
    }
    try:
        target = entry.target()
        if target.is_simulated:
            simulated(target)
    except TurtlewireError as error:
        return {**known, "error": str(error)}
    assert isinstance(entry.table, dict)
    settings = {key: value for key, value in entry.table.items() if key not in ("port", "protocol")}
    return {**known, "port": target.port, "protocol": target.protocol, "settings": settings}
