"""``turtlewire identify FILE|PORT``: which protocol is spoken there, by whom, and how sure that is."""

from __future__ import annotations

import json
import os
import re
import stat
from pathlib import Path
from typing import TYPE_CHECKING, Any

from turtlewire.cli import options, output, wire
from turtlewire.cli.signals import INTERRUPTED
from turtlewire.errors import LinkClosedError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable

    from turtlewire.cli.signals import Signals
    from turtlewire.links.link import Link
    from turtlewire.protocols.catalogue import Sender
    from turtlewire.protocols.identify import Identification

CANNOT_TELL = 1
BAUD = 9600
# While a port is listened to, a verdict is tried after so many bytes, and whenever twice as many have come.
FIRST_TRY_BYTES = 32
EXAMPLES = """\
examples:
  turtlewire identify traffic.bin
      the bytes of one direction, as they were on the wire
  turtlewire identify recording.jsonl
      each direction of a recording of turtlewire monitor
  turtlewire identify /dev/ttyUSB0 --seconds 30
      listens, and sends nothing
  turtlewire identify /dev/ttyUSB0 --baud auto
      listens at one rate after the other; turtlewire doctor finds robots that only answer, too

exit codes:
  0 it is one of the three, 1 none of them or too little to tell
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "identify",
        summary="say which protocol bytes are of",
        description="Say which of the three protocols bytes are of, which direction, which mode, which CRC; "
        "how sure that is, and why. A port is listened to; nothing is sent.",
        examples=EXAMPLES,
    )
    parser.add_argument("source", metavar="FILE|PORT", help=f"- is the standard input; {options.PORTS}")
    parser.add_argument(
        "--seconds", metavar="N", type=options.positive, default=10.0, help="to listen at a port at most (10)"
    )
    parser.add_argument(
        "--baud", metavar="BAUD", type=_baud, default=BAUD, help="of a port; auto: all that are usual (9600)"
    )
    parser.add_argument("--hex", action="store_true", help="the file is hexadecimal text")
    parser.add_argument("--json", action="store_true", help="print a JSON object for each direction")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Identify each direction."""
    from turtlewire.protocols.identify import identify

    baud = None
    heard: dict[Sender | None, bytes]
    if _is_port(arguments.source):
        baud, data = _listened(arguments, signals)
        heard = {None: data}
    else:
        heard = _read(arguments)
    is_sure = True
    for sender, data in heard.items():
        identification = identify(data)
        is_sure = is_sure and identification.is_sure
        _tell(identification, sender, baud, as_json=arguments.json)
    if signals.received:
        output.tell(f"turtlewire: interrupted ({signals.received})")
        return INTERRUPTED
    return 0 if is_sure else CANNOT_TELL


def _baud(text: str) -> int | None:
    """A rate, or None for all of them."""
    import argparse

    if text == "auto":
        return None
    if text.isascii() and text.isdigit() and 50 <= int(text) <= 4_000_000:
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r}: write a number from 50 to 4000000, or auto")


def _is_port(source: str) -> bool:
    if source == "pty" or "://" in source or re.fullmatch(r"COM\d+|/dev/(tty|cu).+", source, re.IGNORECASE):
        return True
    try:
        if not stat.S_ISCHR(Path(source).stat().st_mode):
            return False
        descriptor = os.open(source, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
    except (OSError, ValueError):
        return False  # reading it says why
    try:
        return os.isatty(descriptor)
    finally:
        os.close(descriptor)


def _read(arguments: argparse.Namespace) -> dict[Sender | None, bytes]:
    """The beginning of what each end said. Without a recording nobody knows which end that was."""
    from turtlewire.capture import Chunk
    from turtlewire.protocols.catalogue import SENDERS
    from turtlewire.protocols.identify import SAMPLE_BYTES

    name = "standard input" if arguments.source == "-" else arguments.source
    heard: dict[Sender, bytes] = {}
    with wire.reading(arguments.source) as (descriptor, _):
        pieces = wire.pieces(descriptor, name)
        stream = wire.Stream(wire.from_hexadecimal(pieces, name) if arguments.hex else pieces, name, "host")
        for record in stream:
            if isinstance(record, Chunk) and len(heard.get(record.sender, b"")) < SAMPLE_BYTES:
                heard[record.sender] = heard.get(record.sender, b"") + record.raw
            # In a recording, the other end may speak later.
            ends = 1 if stream.header is None else 2
            if sum(len(data) >= SAMPLE_BYTES for data in heard.values()) == ends:
                break
    if stream.torn:
        output.tell(f"turtlewire: {stream.torn}")
    if stream.header is None:
        return {None: heard.get("host", b"")}
    return {sender: heard[sender] for sender in SENDERS if sender in heard} or {None: b""}


def _listened(arguments: argparse.Namespace, signals: Signals) -> tuple[int | None, bytes]:
    """What comes in at a port, until that is enough; and the rate, if that was to be found."""
    import asyncio

    from turtlewire.links.port import Port

    if arguments.baud is None and Port.parse(arguments.source).kind == "serial":
        return _listened_around(arguments, signals)
    return None, asyncio.run(_listen(arguments, signals))


def _listened_around(arguments: argparse.Namespace, signals: Signals) -> tuple[int | None, bytes]:
    """Listen at one rate after the other."""
    import asyncio
    import contextlib

    from turtlewire.cli.doctor_report import rate
    from turtlewire.examination import BAUDS, Listening, carry_out
    from turtlewire.links.stream import open_port

    listening = Listening(BAUDS, arguments.seconds)

    async def listen() -> None:
        task, loop = asyncio.current_task(), asyncio.get_running_loop()
        assert task is not None
        signals.then(lambda: loop.call_soon_threadsafe(task.cancel))
        link = await open_port(arguments.source, baud=BAUDS[0])
        output.tell(
            f"listening at {link.url}, at one rate after the other, for about {arguments.seconds:g} seconds at most; "
            "nothing is sent"
        )
        await carry_out(
            listening.plan(), link, link.set_baud, lambda step: output.tell(f"{rate(step.baud)}  {step.what}")
        )

    try:
        with contextlib.suppress(asyncio.CancelledError):
            asyncio.run(listen())
    except LinkClosedError:
        if not listening.data:
            raise
    return listening.baud, listening.data


async def _listen(arguments: argparse.Namespace, signals: Signals) -> bytes:
    from turtlewire.links.stream import open_port

    link = await open_port(
        arguments.source,
        baud=arguments.baud or BAUD,
        announce=lambda path: output.tell(f"the port is {path}"),
    )
    try:
        return await _gather(link, arguments.seconds, signals)
    finally:
        await link.close()


async def _gather(link: Link, seconds: float, signals: Signals) -> bytes:
    """Listen until it is sure, the time is up, the other side is gone, or a signal comes."""
    import asyncio

    from turtlewire.protocols.identify import SAMPLE_BYTES, identify

    loop = asyncio.get_running_loop()
    wake: Callable[[], object] = lambda: loop.call_soon_threadsafe(link.wake)  # noqa: E731
    signals.then(wake)
    output.tell(f"listening at {link.url} for {seconds:g} seconds at most; nothing is sent")
    until = link.now() + seconds
    data = b""
    next_try = FIRST_TRY_BYTES
    while link.now() < until and not signals.received and len(data) < SAMPLE_BYTES:
        try:
            data += await link.read(until)
        except LinkClosedError:
            if not data:
                raise
            break
        if len(data) >= next_try:
            next_try = 2 * len(data)
            if identify(data).is_sure:
                break
    return data


def _tell(identification: Identification, sender: Sender | None, baud: int | None, *, as_json: bool) -> None:
    """Say what it is: to programs everything, to people the best of it and what else it might be."""
    if as_json:
        verdicts = [
            {**verdict._asdict(), "settings": dict(verdict.settings)} for verdict in identification.verdicts
        ]
        form: dict[str, Any] = {"recorded_from": sender, "bytes": identification.size}
        if baud is not None:
            form["baud"] = baud
        output.write(json.dumps(form | {"is_sure": identification.is_sure, "verdicts": verdicts}) + "\n")
        return
    best, *others = identification.verdicts
    lines = [f"recorded from the {sender}:"] if sender is not None else []
    if baud is not None and identification.size:
        lines.append(f"at {baud} baud:")
    if identification.is_sure:
        who = f", from the {best.sender}" if best.sender else ", from either end"
        settings = "".join(f", {name} {value}" for name, value in best.settings.items())
        lines.append(f"{best.protocol}{who}{settings} ({_percent(best.score)} sure)")
    elif best.protocol == "none":
        lines.append(f"none of the three protocols, as far as these bytes tell ({_percent(best.score)} sure)")
    else:
        lines.append(f"cannot tell; perhaps {best.protocol} ({_percent(best.score)} sure)")
    lines += [f"  {reason}" for reason in best.reasons]
    lines += [
        f"  or {other.protocol}{f', from the {other.sender}' if other.sender else ''} ({_percent(other.score)})"
        for other in others
        if other.score >= 0.001
    ]
    output.write("".join(f"{line}\n" for line in lines))


def _percent(score: float) -> str:
    return "more than 99.9%" if score > 0.999 else f"{score:.1%}"
