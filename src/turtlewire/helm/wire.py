"""What passes over the wire, decoded: the last messages of both sides."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple, Protocol

from turtlewire.links.link import Link
from turtlewire.protocols import forms
from turtlewire.protocols.catalogue import Packet
from turtlewire.protocols.message import Decoded

if TYPE_CHECKING:
    from collections.abc import Mapping

    from turtlewire.protocols.catalogue import Codec, Sender
    from turtlewire.protocols.stream import Decoder, Item

MAX_LINES = 60
# The same again within this time is counted rather than shown again, seconds.
AGAIN_S = 1.0


class Line(NamedTuple):
    """A message, or the same one some times within a moment.

    Attributes:
        time_s, last_s: when it passed first, and last, since the link was opened.
        sender: who said it.
        text: what; of some that differ, the last.
        times: how often.
        about: what they have in common.
    """

    time_s: float
    sender: Sender
    text: str
    times: int
    last_s: float
    about: str


class Messages:
    """Decodes both directions, and keeps the last of what they said.

    Args:
        codec: of the protocol.
        phrases: what the host says in one breath, from whatever state, and what it means.
    """

    def __init__(self, codec: Codec, phrases: Mapping[bytes, str]) -> None:
        self._decoders: dict[Sender, Decoder] = {s: codec.decoder(s) for s in ("host", "robot")}
        # The longest first: one may begin with another.
        self._phrases = dict(sorted(phrases.items(), key=lambda phrase: -len(phrase[0])))
        self._lines: deque[Line] = deque(maxlen=MAX_LINES)

    def lines(self) -> tuple[Line, ...]:
        """The last messages, the oldest first."""
        return tuple(self._lines)

    def passed(self, data: bytes, sender: Sender, now: float) -> None:
        """Bytes passed; ``b""`` lets time pass."""
        decoder = self._decoders[sender]
        while sender == "host" and (phrase := next(filter(data.startswith, self._phrases), b"")):
            decoder.receive_data(phrase, now)
            meaning = self._phrases[phrase]
            self._add(meaning, meaning, sender, now)
            data = data[len(phrase) :]
        for item in decoder.receive_data(data, now):
            self._note(item, sender, now)

    def _note(self, item: Item, sender: Sender, now: float) -> None:
        text = _says(item)
        # What a robot tells again and again differs each time: the newest will do.
        about = text if sender == "host" else _about(item)
        self._add(text, about, sender, now)

    def _add(self, text: str, about: str, sender: Sender, now: float) -> None:
        for index in range(len(self._lines) - 1, -1, -1):
            line = self._lines[index]
            if now - line.last_s > AGAIN_S:
                break
            if (line.sender, line.about) == (sender, about):
                self._lines[index] = line._replace(text=text, last_s=now, times=line.times + 1)
                return
        self._lines.append(Line(now, sender, text, 1, now, about))


def _says(item: Item) -> str:
    """Without the number of a frame, so that the same is the same."""
    if isinstance(item, Decoded) and isinstance(item.message, Packet):
        packet = item.message
        return (
            "; ".join([*map(str, packet.messages), *(f"refused {message}" for message in packet.refused)])
            or "empty frame"
        )
    return forms.says(item)


def _about(item: Item) -> str:
    """What kind of thing an item says."""
    if not isinstance(item, Decoded):
        return forms.says(item)
    messages = item.message.messages if isinstance(item.message, Packet) else (item.message,)
    return " ".join(message.name() for message in messages)


class Listener(Protocol):
    """Somebody who listens to a wire."""

    def passed(self, data: bytes, sender: Sender, now: float) -> None:
        """Bytes passed, at so many seconds since the link was opened; ``b""`` lets time pass."""


class Tap(Link):
    """A link, with somebody who listens.

    Args:
        link: the link.
        messages: is told of everything that passes.
    """

    def __init__(self, link: Link, messages: Listener) -> None:
        self.url = link.url
        self.in_background = link.in_background
        self._link = link
        self._messages = messages
        self._started_s = link.now()

    def now(self) -> float:
        """The link's clock."""
        return self._link.now()

    def write(self, data: bytes) -> None:
        """Hand over bytes."""
        self._link.write(data)
        self._messages.passed(data, "host", self._elapsed_s)

    def write_urgent(self, data: bytes) -> None:
        """Send bytes ahead of everything."""
        self._link.write_urgent(data)
        self._messages.passed(data, "host", self._elapsed_s)

    async def read(self, until: float) -> bytes:
        """Wait for bytes."""
        data = await self._link.read(until)
        self._messages.passed(data, "robot", self._elapsed_s)
        return data

    def wake(self) -> None:
        """End a read that waits."""
        self._link.wake()

    async def close(self) -> None:
        """Let go of the port."""
        await self._link.close()

    async def reopen(self) -> None:
        """Open it again."""
        await self._link.reopen()

    async def sleep(self, until: float) -> None:
        """Let time pass while the link is closed."""
        await self._link.sleep(until)

    @property
    def _elapsed_s(self) -> float:
        return self._link.now() - self._started_s
