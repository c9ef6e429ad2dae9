"""Which protocol bytes are of, which direction, which settings, how sure that is, and why.

Every explanation of the bytes is asked how many bits it takes to write them down if it is true; a bit less is twice as
likely. The rivals are text, and bytes without any structure that learn which bytes are frequent.
What a protocol does not determine (arguments, payloads, and bytes that belong to no message) costs there what it costs
without structure, so that nothing but the protocol's own order tells. Noise and a beginning in the middle of a message
cost a little; they hide nothing.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.protocols import likelihood
from turtlewire.protocols.catalogue import Settings, codec
from turtlewire.protocols.checksums import CHECKSUMS, Checksum
from turtlewire.protocols.message import Decoded

if TYPE_CHECKING:
    from collections.abc import Mapping

    from turtlewire.protocols.catalogue import Sender

# More bytes than these do not make it surer.
SAMPLE_BYTES = 1 << 16
# Nothing is claimed that is less likely than this.
SURE = 0.95
# How much likelier than each protocol it is at first that bytes are something else: what chance must not make up for.
DOUBT_BITS = 20.0
# Fewer than these are few, whatever they seem to be.
FEW_BYTES = 64
NONE = "none"


class Verdict(NamedTuple):
    """One explanation.

    Attributes:
        protocol: simple, frame, walter, or none of them.
        sender: who says this; None: both could.
        settings: what tells this robot's protocol from others of its kind: mode; crc, coverage and dialect.
        score: how likely it is among all explanations, 0 to 1.
        reasons: why, in words.
    """

    protocol: str
    sender: Sender | None
    settings: Mapping[str, str]
    score: float
    reasons: tuple[str, ...]


class Identification(NamedTuple):
    """All explanations, the likeliest first; of how many bytes.

    ``gained_bits``: how much shorter the bytes are written by the likeliest protocol than without any: 1.0 is twice as
    likely. It tells which of several identifications understood most: the same line, heard at different rates.
    """

    verdicts: tuple[Verdict, ...]
    size: int
    gained_bits: float

    @property
    def best(self) -> Verdict:
        """The likeliest explanation."""
        return self.verdicts[0]

    @property
    def is_sure(self) -> bool:
        """Whether the likeliest explanation is a protocol, and nothing else comes near."""
        return self.best.protocol != NONE and self.best.score >= SURE


class _Explanation(NamedTuple):
    """A verdict before it is compared: ``bits`` is what the bytes cost."""

    protocol: str
    sender: Sender | None
    settings: dict[str, str]
    bits: float
    reasons: tuple[str, ...]


def identify(data: bytes) -> Identification:
    """Say what bytes are that one end of a wire sent, as they came; a beginning of them will do."""
    data = data[:SAMPLE_BYTES]
    counts = Counter(data)
    rival_bits = min(likelihood.text_bits(counts), likelihood.opaque_bits(counts, doubts_few=True))
    explanations = [
        explanation._replace(bits=explanation.bits + DOUBT_BITS)
        for explanation in (*_walter(data), *_simple(data), *_frame(data))
    ]
    rival = likelihood.resemblance(counts)
    explanations.append(_Explanation(NONE, None, {}, rival_bits, _no_reasons(data, rival)))
    explanations.sort(key=lambda explanation: explanation.bits)
    least = explanations[0].bits
    weights = [2.0 ** max(-1000.0, least - explanation.bits) for explanation in explanations]
    verdicts = [
        Verdict(e.protocol, e.sender, e.settings, weight / sum(weights), _compared(e, rival_bits, rival))
        for e, weight in zip(explanations, weights, strict=True)
    ]
    gained_bits = max(rival_bits - e.bits for e in explanations if e.protocol != NONE)
    return Identification(tuple(verdicts), len(data), gained_bits)


def _no_reasons(data: bytes, rival: str) -> tuple[str, ...]:
    if not data:
        return ("there are no bytes",)
    few = f", and there are only {_number(len(data), 'byte')}" if len(data) < FEW_BYTES else ""
    return (f"they are likeliest {rival}{few}",)


def _compared(explanation: _Explanation, rival_bits: float, rival: str) -> tuple[str, ...]:
    if explanation.protocol == NONE:
        return explanation.reasons
    gained = rival_bits - explanation.bits
    likelier = f"2^{gained:.0f} times likelier than" if gained > 0 else "not likelier than"
    return (*explanation.reasons, f"{likelier} {rival}")


class _Reading:
    """What one explanation makes of bytes, counted."""

    def __init__(self) -> None:
        self.types: Counter[str] = Counter()
        self.arguments: Counter[int] = Counter()
        self.noise: Counter[int] = Counter()
        # Choices that a sender makes and sticks to: upper or lower case, CR or CR LF.
        self.habits: dict[str, Counter[int]] = {}

    def habit(self, name: str, choice: int) -> None:
        self.habits.setdefault(name, Counter())[choice] += 1

    def bits(self, kinds: int, choices: Mapping[str, int] = {}) -> float:
        """What all of it costs, with so many kinds of messages, and so many choices (2) of each habit."""
        messages, noise = self.types.total(), self.noise.total()
        bits = likelihood.learned_bits((messages, noise), 2) + likelihood.learned_bits(
            self.types.values(), kinds
        )
        bits += likelihood.opaque_bits(self.arguments) + likelihood.opaque_bits(self.noise)
        return bits + sum(
            likelihood.settled_bits(counts.values(), choices.get(name, 2))
            for name, counts in self.habits.items()
        )

    def reasons(self, size: int) -> tuple[str, ...]:
        """How much of the bytes is explained, and by what."""
        most = ", ".join(f"{name} {n}" for name, n in self.types.most_common(4))
        share = (size - self.noise.total()) / size if size else 0.0
        return (
            f"{share:.1%} of {_number(size, 'byte')} are in {_number(self.types.total(), 'message')} ({most})",
        )


def _number(count: int, what: str) -> str:
    return f"{count:,} {what}{'s' * (count != 1)}"


# ------------------------------------------------------------------------------------------------------ walter


def _walter(data: bytes) -> list[_Explanation]:
    # Noise that happens to be the key for Logo control must not hide the keys behind it.
    hosts = [_walter_host(data, "logo", 0)]
    hosts += [
        _walter_host(data, "direct", start) for start in sorted({0, min(64, len(data)), len(data) // 2})
    ]
    reading = _walter_reading(data, "robot", "logo")
    robot = _Explanation("walter", "robot", {}, reading.bits(11), reading.reasons(len(data)))
    return [min(hosts, key=lambda explanation: explanation.bits), robot]


def _walter_host(data: bytes, mode: str, start: int) -> _Explanation:
    """What a host says, if that begins after so many bytes of noise, in this mode."""
    from turtlewire.protocols.walter.messages import DIRECT_KEYS

    reading = _walter_reading(data[start:], "host", mode)
    reading.noise.update(data[:start])
    keys = {key.name() for key in DIRECT_KEYS}
    in_direct = sum(n for name, n in reading.types.items() if name in keys)
    in_logo = reading.types.total() - in_direct
    reasons = (*reading.reasons(len(data)), f"{in_logo} in Logo control, {in_direct} in direct control")
    return _Explanation("walter", "host", {"mode": mode}, reading.bits(40) + 2.0, reasons)


def _walter_reading(data: bytes, sender: Sender, mode: str) -> _Reading:
    from turtlewire.protocols.stream import Skipped
    from turtlewire.protocols.walter.messages import DirectKey, EmptyLine, WalterMessage

    decoder = codec("walter", Settings(mode=mode)).decoder(sender)
    reading = _Reading()
    is_behind_message = False
    for item in (*decoder.receive_data(data), *decoder.finish()):
        if isinstance(item, Skipped) and is_behind_message:
            reading.habit("line end", 1)
            continue
        is_behind_message = isinstance(item, Decoded) and not isinstance(item.message, EmptyLine)
        # Empty lines and line feeds are what text is full of, too: they tell nothing.
        if not is_behind_message or not isinstance(item, Decoded):
            reading.noise.update(item.raw)
            continue
        message = item.message
        assert isinstance(message, WalterMessage)
        letters = item.raw[: len(message.LETTERS)]
        has_ret = not isinstance(message, DirectKey)
        reading.types[message.name()] += 1
        reading.arguments.update(item.raw[len(letters) : len(item.raw) - has_ret])
        if has_ret:
            reading.habit("line end", 0)
        for letter in letters:
            if chr(letter).isalpha():
                reading.habit("case", chr(letter).islower())
    return reading


# ------------------------------------------------------------------------------------------------------ simple

# A host sends the same byte wherever anything will do: the source says 0, others - or x.
_COMMAND = re.compile(
    rb"(?P<letter>[FBLR])(?P<value>[01]\d\d|2[0-4]\d|25[0-5])(?P<any>.)(?P=any){2}"
    rb"|(?P<stop>S)(?P<anything>.)(?P=anything){5}|(?P<lights>H)(?P<digits>\d{4})(?P<rest>.)(?P=rest)",
    re.DOTALL,
)
_LETTERS = {
    b"F": "drive_forward", b"B": "drive_backward", b"L": "steer_left", b"R": "steer_right", b"S": "stop",
    b"H": "headlights",
}  # fmt: skip


def _simple(data: bytes) -> list[_Explanation]:
    host, robot = _Reading(), _Reading()
    at = 0
    for match in _COMMAND.finditer(data):
        host.noise.update(data[at : match.start()])
        at = match.end()
        host.types[_LETTERS[match[0][:1]]] += 1
        host.arguments.update([int(match["value"])] if match["value"] else match["digits"] or b"")
        host.habit("filler", match[0][-1])
    host.noise.update(data[at:])
    robot.types.update(
        {name: n for name, n in (("accepted", data.count(b"K")), ("rejected", data.count(b"F"))) if n}
    )
    robot.noise.update(data.translate(None, b"KF"))
    return [
        _Explanation("simple", "host", {}, host.bits(6, {"filler": 256}), host.reasons(len(data))),
        _Explanation("simple", "robot", {}, robot.bits(2), robot.reasons(len(data))),
    ]


# ------------------------------------------------------------------------------------------------------- frame

_MAGIC = 0xA3
_OVERHEAD, _MAX_PAYLOAD = 4, 124


def _frame(data: bytes) -> list[_Explanation]:
    candidates = [
        (at, data[at : at + data[at + 2] + _OVERHEAD])
        for at in (match.start() for match in re.finditer(rb"\xa3", data))
        if at + 2 < len(data) and data[at + 2] <= _MAX_PAYLOAD and at + data[at + 2] + _OVERHEAD <= len(data)
    ]
    fits = {
        checksum: [(at, frame) for at, frame in candidates if checksum.fits(frame)] for checksum in CHECKSUMS
    }
    most = max(map(len, fits.values()))
    chain = _chain(data, candidates)
    if 2 * most < len(chain) or not most:
        return [_chained(data, chain)]
    # Those that come first are the likelier ones where several fit: the default, then by coverage.
    best = [checksum for checksum in sorted(CHECKSUMS, key=_unlikely) if len(fits[checksum]) == most]
    return [_framed(data, fits[best[0]], best)]


def _unlikely(checksum: Checksum) -> tuple[bool, int]:
    return checksum.algorithm.name != "CRC-8/SMBUS", checksum.coverage.first


def _framed(data: bytes, found: list[tuple[int, bytes]], fitting: list[Checksum]) -> _Explanation:
    """Frames whose CRC is right, by one or by several checksums alike."""
    frames = []
    end = 0
    for at, frame in found:
        if at >= end:
            frames.append((at, frame))
            end = at + len(frame)
    reading = _frames_reading(data, frames, crc_is_known=True)
    checksum = fitting[0]
    sender, dialect, what = _messages(b"".join(frame for _, frame in frames), checksum)
    if len(fitting) == 1:
        crc = f"{checksum} fits {_number(len(frames), 'frame')}, and no other CRC does"
    else:
        others = ", ".join(map(str, fitting[1:4])) + (" and more" if len(fitting) > 4 else "")
        crc = f"{checksum} fits {_number(len(frames), 'frame')}, but so does {others}: more frames will tell"
    settings = {"crc": checksum.algorithm.name, "coverage": checksum.coverage.value}
    if dialect:
        settings["dialect"] = dialect
    bits = _frames_bits(reading) + math.log2(len(CHECKSUMS) / len(fitting))
    return _Explanation("frame", sender, settings, bits, (*reading.reasons(len(data)), crc, what))


def _chain(data: bytes, candidates: list[tuple[int, bytes]]) -> list[tuple[int, bytes]]:
    """Frames that stand one behind the other, whatever their CRC."""
    frames = []
    end = 0
    for at, frame in candidates:
        behind = at + len(frame)
        if at >= end and (behind == len(data) or data[behind] == _MAGIC):
            frames.append((at, frame))
            end = behind
    return frames


def _chained(data: bytes, frames: list[tuple[int, bytes]]) -> _Explanation:
    """Frames that are known by nothing else: their CRC is none of the catalogue's."""
    reading = _frames_reading(data, frames, crc_is_known=False)
    reasons = (*reading.reasons(len(data)), "frame stands behind frame, but no known CRC-8 fits them")
    return _Explanation("frame", None, {}, _frames_bits(reading), reasons)


def _frames_reading(data: bytes, frames: list[tuple[int, bytes]], *, crc_is_known: bool) -> _Reading:
    reading = _Reading()
    at = 0
    before = -1
    for start, frame in frames:
        reading.noise.update(data[at:start])
        at = start + len(frame)
        reading.types["frame"] += 1
        follows = frame[1] == (before + 1) % 256
        reading.habit("order", 0 if follows else 1 if frame[1] == before else 2)
        if not follows:
            reading.arguments[frame[1]] += 1
        before = frame[1]
        reading.habit("size", frame[2])
        reading.arguments.update(frame[3:-1] if crc_is_known else frame[3:])
    reading.noise.update(data[at:])
    return reading


def _frames_bits(reading: _Reading) -> float:
    return reading.bits(1, {"order": 3, "size": _MAX_PAYLOAD + 1})


def _messages(frames: bytes, checksum: Checksum) -> tuple[Sender | None, str, str]:
    """Who sends the messages in whole frames, in which dialect; and that in words."""
    from turtlewire.protocols.frame.dialect import SHIPPED

    understood: dict[tuple[str, Sender], int] = {}
    for dialect in SHIPPED:
        settings = Settings(dialect=dialect, crc=checksum.algorithm.name, coverage=checksum.coverage.value)
        senders: tuple[Sender, ...] = ("host", "robot")
        for sender in senders:
            items = codec("frame", settings).decoder(sender).receive_data(frames)
            understood[dialect, sender] = sum(
                isinstance(item, Decoded) and len(item.raw) > _OVERHEAD for item in items
            )
    best = max(understood, key=lambda key: understood[key])
    if not understood[best]:
        return None, "", "their messages are of no dialect that comes with turtlewire"
    dialect, sender = best
    other: Sender = "host" if sender == "robot" else "robot"
    if understood[dialect, other] == understood[best]:
        return None, dialect, f"their messages are of the dialect {dialect}, and go either way"
    return sender, dialect, f"their messages are those of a {sender} in the dialect {dialect}"
