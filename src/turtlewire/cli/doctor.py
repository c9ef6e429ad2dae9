"""``turtlewire doctor PORT``: what is at the other end, without moving it; and its entry in robots.toml."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from turtlewire.cli import options, output
from turtlewire.cli.signals import INTERRUPTED, Interrupted
from turtlewire.errors import LinkClosedError, NoReplyError, TurtlewireError, UsageError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Awaitable, Callable, Mapping

    from turtlewire.cli.signals import Signals
    from turtlewire.examination import Findings
    from turtlewire.examination.steps import Tell
    from turtlewire.links.link import Link
    from turtlewire.protocols.frame.dialect import Dialect

EXAMPLES = """\
examples:
  turtlewire doctor /dev/ttyUSB0
      shows what is there, and the entry that robots.toml could have
  turtlewire doctor /dev/ttyUSB0 --name elsie --write
      writes that entry, too; then: turtlewire run examples/rose.logo --robot elsie
  turtlewire doctor socket://robot.local:2000 --json
  turtlewire doctor /dev/ttyUSB0 --protocol frame --name herbie --write
      a robot that never says anything: listened to, and taken at your word
  turtlewire doctor elsie
      a robot that robots.toml has already

Nothing that is sent before the robot is known can move it, whatever it speaks, at any usual rate (docs/doctor.md).

exit codes:
  0 found, and written if that was wanted; 3 nothing was found, or something is wrong with the port
"""
PORTS = "a device (/dev/ttyUSB0, COM3), socket://host:port, a sim: URL, or the name of a robot in robots.toml"
EXAMPLE = "examples/rose.logo"
# Where nobody knows better (W16, F12).
WALTER_BAUD, FRAME_BAUD = 9600, 115200


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "doctor",
        summary="find out what is at a port, without moving it",
        description="Find out what is at a port: which protocol, rate, dialect and commands, how fast it answers. "
        "Nothing moves. Then show the robot's entry for robots.toml, and write it if wanted.",
        examples=EXAMPLES,
    )
    parser.add_argument("port", metavar="PORT", help=PORTS)
    parser.add_argument("--name", metavar="NAME", help="what the robot is to be called in robots.toml")
    parser.add_argument("--write", action="store_true", help="write the entry, and do not ask")
    parser.add_argument(
        "--replace", action="store_true", help="even if there is a robot of that name at another port"
    )
    parser.add_argument(
        "--protocol",
        choices=["walter", "simple", "frame"],
        help="look for this one only; frame and walter are believed if nothing answers",
    )
    parser.add_argument(
        "--baud",
        metavar="N,...",
        type=_bauds,
        help="try these rates only, in this order (all that are usual)",
    )
    parser.add_argument(
        "--dialect",
        metavar="FILE",
        action="append",
        default=[],
        help="of frame, beside those that come with turtlewire; as often as wanted",
    )
    parser.add_argument(
        "--boot-s",
        metavar="SECONDS",
        type=_seconds,
        default=2.5,
        help="it may take to boot when its port is opened (2.5)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object, whatever happens")
    parser.set_defaults(execute=execute)


def _seconds(text: str) -> float:
    import argparse

    with contextlib.suppress(ValueError):
        if 0.0 <= (seconds := float(text)) < float("inf"):
            return seconds
    raise argparse.ArgumentTypeError(f"{text!r} is not 0 or more seconds")


def _bauds(text: str) -> tuple[int, ...]:
    import argparse

    numbers = text.split(",")
    if all(n.isascii() and n.isdigit() and 50 <= int(n) <= 4_000_000 for n in numbers):
        return tuple(dict.fromkeys(map(int, numbers)))
    raise argparse.ArgumentTypeError(f"{text!r}: write one rate, or several with commas: 9600,19200")


class Patient(NamedTuple):
    """What is to be examined.

    Attributes:
        port: the port alone.
        lines: of its entry that say where it is: the port, and for a simulated robot its options.
        name: of the robot, or empty.
        bauds: to be tried.
    """

    port: str
    lines: dict[str, Any]
    name: str
    bauds: tuple[int | None, ...]


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Examine, tell, and write."""
    result: dict[str, Any] = {
        "outcome": "error",
        "exit_code": 0,
        "error": None,
        "findings": None,
        "entry": None,
        "written": [],
    }
    try:
        result["exit_code"] = _all(arguments, signals, result)
    except TurtlewireError as error:
        if not arguments.json:
            raise
        result["error"] = "\n".join([str(error), *getattr(error, "__notes__", [])])
        result["exit_code"] = error.exit_code
    except Interrupted:
        if not arguments.json:
            raise
        result["outcome"], result["exit_code"] = "interrupted", INTERRUPTED
    if arguments.json:
        output.write(json.dumps(result) + "\n")
    code: int = result["exit_code"]
    return code


def _all(arguments: argparse.Namespace, signals: Signals, result: dict[str, Any]) -> int:
    """Everything, in order; ``result`` gathers what is known."""
    from turtlewire.cli import doctor_report
    from turtlewire.cli.enrolment import Enrolment

    patient = _patient(arguments)
    enrolment = Enrolment(patient.name, patient.lines, is_replacing=arguments.replace)
    dialects = _dialects(arguments.dialect, patient.name)
    findings = _examined(arguments, signals, patient, dialects)
    result["findings"] = findings.to_json()
    if not findings.protocol:
        findings = _believed(arguments, patient, dialects, findings)
    if not findings.protocol:
        result["outcome"] = "nothing"
        if not arguments.json:
            command = f"turtlewire doctor {arguments.port} --name {patient.name or 'NAME'} --write"
            output.tell("\n".join(doctor_report.nothing(findings, patient.port, command)))
        return NoReplyError.exit_code
    result["outcome"] = "found" if findings.likelihood else "believed"
    if not arguments.json:
        report = doctor_report.found if findings.likelihood else doctor_report.believed
        output.write("".join(f"{line}\n" for line in report(findings)))
    enrolment.found(findings)
    result["entry"] = {"name": enrolment.name or None, "lines": enrolment.lines}
    if not arguments.json:
        output.write(f"its entry in robots.toml:\n{enrolment.toml}")
    if arguments.write or (not arguments.json and enrolment.is_wanted()):
        result["written"] = [str(path) for path in enrolment.write()]
    if not arguments.json:
        output.write(enrolment.next_step(EXAMPLE, is_written=bool(result["written"])))
    return 0


# ---------------------------------------------------------------- what, and where


def _patient(arguments: argparse.Namespace) -> Patient:
    """What the options mean. Raises ``UsageError`` or, for what is wrong in robots.toml, ``DataError``."""
    from turtlewire import configuration, robots_file

    lines: dict[str, Any] = {}
    text, name = arguments.port, arguments.name or ""
    if configuration.NAME.fullmatch(text):
        lines = _known(text)
        text, name = lines["port"], name or text
    elif "?" in text:
        lines = robots_file.options(text)
        text = lines["port"]
    if arguments.write and not name:
        raise UsageError("--write: what is it to be called? --name NAME")
    if text in configuration.PTY:
        raise UsageError("pty is a new port, with no robot at it yet: name the port of the robot")
    if text.startswith(configuration.SIM):
        if arguments.baud:
            raise UsageError(f"--baud: {text} is no serial port")
        return Patient(text, {**lines, "port": text}, name, (None,))
    bauds = _bauds_of(arguments, text, lines.get("baud"))
    unknown = [key for key in lines if key not in ("port", "baud")]
    if unknown and "?" in arguments.port:
        raise UsageError(
            f"{arguments.port!r}: leave out {', '.join(unknown)}: what the robot is, the doctor finds out"
        )
    return Patient(text, {"port": text}, name, bauds)


def _known(name: str) -> dict[str, Any]:
    """The lines of a robot that robots.toml has."""
    from turtlewire import configuration

    entry = configuration.entries().get(name)
    if entry is None:
        from turtlewire.links.port import FORMS

        raise UsageError(
            f"{name!r} is no port: write {FORMS}; or the name of a robot: {configuration.known()}"
        )
    table = entry.table if isinstance(entry.table, dict) else {}
    if not isinstance(table.get("port"), str):
        entry.target()  # says what is wrong with it
    return dict(table)


def _bauds_of(arguments: argparse.Namespace, port: str, known: object) -> tuple[int | None, ...]:
    """Which rates to try, in which order."""
    from turtlewire.examination import BAUDS
    from turtlewire.links.port import Port

    parsed = Port.parse(port)
    if parsed.kind == "socket":
        if arguments.baud:
            raise UsageError(f"--baud: {port} has no rate")
        return (None,)
    if arguments.baud:
        given: tuple[int, ...] = arguments.baud
        return given
    if parsed.baud is not None:
        return (parsed.baud,)
    first = [int(str(known))] if str(known).isdigit() else []
    if "?" in arguments.port and first:
        return tuple(first)
    if arguments.protocol == "frame":
        first.append(FRAME_BAUD)
    return tuple(dict.fromkeys((*first, *BAUDS)))


def _dialects(files: list[str], name: str) -> dict[str, Dialect]:
    """The dialects of frame to look for; those that somebody has named come first."""
    from turtlewire import configuration
    from turtlewire.protocols.frame.dialect import SHIPPED, load, shipped

    dialects = {str(Path(file).resolve()): load(file) for file in files}
    entry = configuration.entries().get(name) if name else None
    own = entry.table.get("dialect") if entry is not None and isinstance(entry.table, dict) else None
    if isinstance(own, str) and own not in SHIPPED:
        beside = configuration.path().parent / own
        dialects[own] = load(beside if beside.is_file() else own)
    return dialects | {known: shipped(known) for known in SHIPPED}


# ---------------------------------------------------------------- the examination


def _examined(
    arguments: argparse.Namespace, signals: Signals, patient: Patient, dialects: Mapping[str, Dialect]
) -> Findings:
    """Examine it. Raises ``LinkError``, or ``Interrupted`` when all has been put in order after a signal."""
    import asyncio

    from turtlewire import configuration
    from turtlewire.cli.doctor_report import rate
    from turtlewire.examination import Wanted, carry_out, examination

    protocols = frozenset({arguments.protocol} if arguments.protocol else configuration.PROTOCOLS)
    plan = examination(Wanted(patient.bauds, protocols, dialects, arguments.boot_s))

    def tell(step: Tell) -> None:
        if not arguments.json:
            output.tell(f"{rate(step.baud)}  {step.what}")

    async def examine() -> Findings:
        task, loop = asyncio.current_task(), asyncio.get_running_loop()
        assert task is not None
        signals.then(lambda: loop.call_soon_threadsafe(task.cancel))
        link, tune = await _opened(patient)
        if not arguments.json:
            output.tell(f"examining {patient.port}: nothing that is sent can move a robot")
        return await carry_out(plan, link, tune, tell)

    findings = None
    try:
        with contextlib.suppress(asyncio.CancelledError):
            findings = asyncio.run(examine())
    except LinkClosedError as error:
        options.explain_refusal(error, patient.port)
        raise
    if findings is None or signals.received:
        raise Interrupted(signals.received)
    signals.then(lambda: _interrupt(signals))
    return findings


def _interrupt(signals: Signals) -> None:
    raise Interrupted(signals.received)


async def _opened(patient: Patient) -> tuple[Link, Callable[[int], Awaitable[None]] | None]:
    """The link, and what changes its rate."""
    from turtlewire import configuration

    if patient.port.startswith(configuration.SIM):
        from urllib.parse import urlencode

        from turtlewire.links.memory import MemoryLink
        from turtlewire.simulated import simulated

        query = urlencode({key: value for key, value in patient.lines.items() if key != "port"})
        found = simulated(configuration.target(f"{patient.port}?{query}"))
        return MemoryLink(found.robot, patient.port, found.pace), None
    from turtlewire.links.stream import open_port

    first = patient.bauds[0]
    link = await open_port(patient.port, baud=first or 0)
    return link, None if first is None else link.set_baud


def _believed(
    arguments: argparse.Namespace, patient: Patient, dialects: Mapping[str, Dialect], findings: Findings
) -> Findings:
    """A robot that is said to be one that never answers, and does not."""
    from turtlewire.examination.findings import FrameFacts

    if arguments.protocol not in ("frame", "walter") or (findings.strange and findings.baud is None):
        return findings
    if not findings.strange and any(at.heard_bytes or at.answer_bytes for at in findings.rates):
        return findings
    named = str(Path(arguments.dialect[0]).resolve()) if len(arguments.dialect) == 1 else ""
    baud = findings.baud
    if baud is None and patient.bauds[0] is not None:
        usual = WALTER_BAUD
        if arguments.protocol == "frame":
            usual = dialects[named].baud if named else FRAME_BAUD
        baud = patient.bauds[0] if arguments.baud else usual
    facts = FrameFacts("", "", named, {}, 0, is_dialects_crc=True) if arguments.protocol == "frame" else None
    return findings._replace(protocol=arguments.protocol, baud=baud, likelihood=0.0, facts=facts)
