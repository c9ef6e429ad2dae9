"""``turtlewire ports``: the serial ports of this computer, and what is known of them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from turtlewire.cli import options, output
from turtlewire.errors import LinkError

if TYPE_CHECKING:
    import argparse

    from serialx import SerialPortInfo

    from turtlewire.cli.signals import Signals

EXAMPLES = """\
examples:
  turtlewire ports
  turtlewire ports --json
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "ports",
        summary="list the serial ports",
        description="List the serial ports of this computer, and what is known of them.",
        examples=EXAMPLES,
    )
    parser.add_argument("--json", action="store_true", help="print a JSON array instead of text")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """List them."""
    import serialx

    del signals
    try:
        found = sorted(serialx.list_serial_ports(), key=lambda port: port.device)
    except (OSError, serialx.SerialException) as error:
        raise LinkError(f"cannot list the serial ports: {error}") from error
    names = _names()
    ports = [_known(port, names) for port in found]
    if arguments.json:
        output.write(json.dumps(ports) + "\n")
    elif ports:
        output.write("".join(f"{_line(port)}\n" for port in ports))
    else:
        output.tell(
            "there is no serial port: is the robot plugged in, and is its cable one that carries data?"
        )
    return 0


def _names() -> dict[str, list[str]]:
    """Which robots ``robots.toml`` has at a port."""
    from turtlewire.configuration import entries

    names: dict[str, list[str]] = {}
    for name, entry in entries().items():
        port = entry.table.get("port") if isinstance(entry.table, dict) else None
        if isinstance(port, str):
            names.setdefault(port.removeprefix("serial://"), []).append(name)
    return names


def _known(port: SerialPortInfo, names: dict[str, list[str]]) -> dict[str, Any]:
    paths = dict.fromkeys((port.device, port.resolved_device))
    return {
        "port": port.device,
        "device": port.resolved_device,
        "manufacturer": port.manufacturer,
        "product": port.product,
        "serial_number": port.serial_number,
        "vendor_id": _hex(port.vid),
        "product_id": _hex(port.pid),
        "robots": [name for path in paths for name in names.get(path, [])],
    }


def _hex(number: int | None) -> str | None:
    return None if number is None else f"{number:04x}"


def _line(port: dict[str, Any]) -> str:
    what = " ".join(part for part in (port["manufacturer"], port["product"]) if part)
    details = [what or "nothing is known of it"]
    if port["vendor_id"]:
        details.append(f"USB {port['vendor_id']}:{port['product_id']}")
    if port["serial_number"]:
        details.append(f"serial number {port['serial_number']}")
    if port["device"] != port["port"]:
        details.append(f"is {port['device']}")
    if port["robots"]:
        details.append(f"robot: {', '.join(port['robots'])}")
    return f"{port['port']:<16} {'; '.join(details)}"
