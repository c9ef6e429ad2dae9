"""``turtlewire console``: robots from a browser, on this computer or in a class."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from turtlewire.cli import options, output
from turtlewire.cli.signals import Interrupted
from turtlewire.errors import UsageError

if TYPE_CHECKING:
    from turtlewire.cli.signals import Signals
    from turtlewire.console.stations import Berth

# Apart from one another on the ground, so that a map shows three.
SIMULATED = ("sim:walter", "sim:simple?start=400,0", "sim:frame?start=-400,0")
EXAMPLES = """\
examples:
  turtlewire console
      three simulated robots; open the address that it shows
  turtlewire console --port /dev/ttyUSB0
      the WALTER at this port
  turtlewire console --robot elsie --robot simple --port "/dev/ttyACM0?protocol=simple"
      several robots, of robots.toml, simulated or by their ports
  turtlewire console --host 0.0.0.0 --certificate class.pem
      for everybody in this network who has the token: it is shown as an address and as a QR code

Whoever may open the page may stop the robots; one at a time drives each of them. Ctrl-C ends it, and stops them.
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "console",
        summary="drive, see and program robots from a browser",
        description="Serve a page on which robots are driven, seen and programmed, from laptops and phones. Without a "
        "robot, three simulated ones.",
        examples=EXAMPLES,
    )
    parser.add_argument(
        "--robot",
        action="append",
        default=[],
        metavar="NAME",
        help="a robot in robots.toml, or a simulated one: walter, simple or frame; as often as wanted",
    )
    parser.add_argument(
        "--port",
        action="append",
        default=[],
        metavar="URL",
        help=options.PORTS + "; or sim:walter?arena=FILE, a simulated one; as often as wanted",
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="the address to listen at; 0.0.0.0: all of this computer's (127.0.0.1)",
    )
    parser.add_argument(
        "--listen-port", type=_port, default=8080, metavar="N", help="the port to listen at; 0: any (8080)"
    )
    parser.add_argument(
        "--certificate", type=Path, metavar="FILE", help="serve over TLS, with this PEM certificate"
    )
    parser.add_argument(
        "--key", type=Path, metavar="FILE", help="the certificate's key, if it is in another file"
    )
    parser.add_argument(
        "--programs",
        type=Path,
        metavar="FOLDER",
        help="where programs are kept (~/.local/share/turtlewire/programs)",
    )
    parser.set_defaults(execute=execute)


def _port(text: str) -> int:
    if not (text.isdecimal() and int(text) < 65536):
        raise argparse.ArgumentTypeError(f"{text!r} is not the number of a port, 0 to 65535")
    return int(text)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Serve until a signal comes. Whatever happens, the robots are stopped."""
    if arguments.key is not None and arguments.certificate is None:
        raise UsageError("--key is the key of a certificate: name that by --certificate")
    berths = _berths(arguments)
    _need_extra()
    import secrets

    from turtlewire.console.console import Console
    from turtlewire.console.gate import is_loopback
    from turtlewire.console.programs import Programs, default_folder
    from turtlewire.console.server import Service, check_certificate, door, listen

    if arguments.certificate is not None:
        check_certificate(arguments.certificate, arguments.key)
    _log()
    with listen(arguments.host, arguments.listen_port) as listener:
        token = "" if is_loopback(arguments.host) else secrets.token_urlsafe(16)
        entrance = door(arguments.host, listener, token, is_secure=arguments.certificate is not None)
        programs = Programs(arguments.programs or default_folder())
        service = Service(
            Console(berths, _announce, programs),
            entrance,
            listener,
            certificate=arguments.certificate,
            key=arguments.key,
        )
        signals.then(service.end)
        _welcome(entrance.address(arguments.host), token)
        try:
            service.run()
        finally:
            signals.hold()
    raise Interrupted(signals.received or "it ended")


def _berths(arguments: argparse.Namespace) -> list[Berth]:
    """The robots. Raises ``UsageError`` or ``DataError``."""
    from turtlewire import configuration
    from turtlewire.console.stations import Berth

    named = [argparse.Namespace(robot=robot, port=None, set=[]) for robot in arguments.robot]
    ports = arguments.port or ([] if named else SIMULATED)
    found = [*map(options.target, named), *map(configuration.target, ports)]
    return [Berth(*options.by_hand(target)) for target in found if target is not None]


def _need_extra() -> None:
    """Raises ``UsageError`` where the console's libraries are not installed."""
    from importlib.util import find_spec

    missing = [name for name in ("fastapi", "nicegui", "segno", "uvicorn") if find_spec(name) is None]
    if missing:
        raise UsageError(
            f"the console needs libraries that are not installed ({', '.join(missing)}): "
            "pip install 'turtlewire[console]'"
        )


def _log() -> None:
    """What happens, and what is refused, goes to standard error."""
    import logging

    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("%(asctime)s %(message)s", "%H:%M:%S"))
    log = logging.getLogger("turtlewire")
    log.addHandler(handler)
    log.setLevel(logging.INFO)


def _announce(path: str) -> None:
    output.tell(f"waiting for the robot at {path}")


def _welcome(address: str, token: str) -> None:
    """Say where the page is; to others than this computer, with the token, and as a picture for phones."""
    if not token:
        print(f"turtlewire console: {address}", flush=True)
        return
    import io

    import segno

    url = f"{address}?token={token}"
    picture = io.StringIO()
    segno.make(url, error="l").terminal(picture, compact=True)
    print(f"turtlewire console: {url}\n\n{picture.getvalue()}", flush=True)
    if not address.startswith("https:"):
        output.tell(
            "Whoever can listen in this network can read the token: with --certificate FILE nobody can."
        )
