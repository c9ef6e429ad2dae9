"""Who uses the console: every page is a session, and so is every program that asked for one."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field

from turtlewire.console.refusals import Refused

MAX_SESSIONS = 1000
# A session without a page that nobody uses for so long is over.
UNUSED_S = 3600.0
MAX_NAME = 40


@dataclass(eq=False)
class Session:
    """Somebody who uses the console.

    Attributes:
        id: for everybody to know.
        name: what others are shown.
        secret: what shows that a request is this session's.
        address: where it comes from.
        has_page: it lasts as long as its stream; otherwise as long as it is used.
        used_s: when it was used last.
    """

    id: int
    name: str
    address: str
    has_page: bool
    used_s: float
    secret: str = field(default_factory=lambda: secrets.token_urlsafe(18), repr=False)


class Sessions:
    """All of them. No clock: time is an argument."""

    def __init__(self) -> None:
        self._sessions: dict[str, Session] = {}
        self._last = 0

    def open(self, name: str, address: str, now: float, *, has_page: bool) -> Session:
        """A new one. Raises ``Refused`` when there are too many."""
        if len(self._sessions) >= MAX_SESSIONS:
            raise Refused(429, "many_sessions", f"there are {MAX_SESSIONS} sessions already")
        self._last += 1
        session = Session(self._last, "", address, has_page, now)
        self.rename(session, name)
        self._sessions[session.secret] = session
        return session

    @staticmethod
    def rename(session: Session, name: str) -> None:
        """Give it the name, without what cannot be read; an empty one: a name of ours."""
        name = " ".join("".join(letter if letter.isprintable() else " " for letter in name).split())
        session.name = name[:MAX_NAME] or f"guest {session.id}"

    def find(self, secret: str, now: float) -> Session:
        """The session of a secret. Raises ``Refused``."""
        session = self._sessions.get(secret)
        if session is None:
            raise Refused(
                401,
                "no_session",
                "no such session: send the header X-Session, with what POST /api/sessions or the stream's welcome said",
            )
        session.used_s = now
        return session

    def name(self, number: int | None) -> str | None:
        """What a session is called; None: there is none."""
        return next((each.name for each in self._sessions.values() if each.id == number), None)

    def close(self, session: Session) -> None:
        """It is over."""
        self._sessions.pop(session.secret, None)

    def unused(self, now: float) -> list[Session]:
        """Those that nobody has used for long."""
        return [
            session
            for session in self._sessions.values()
            if not session.has_page and now - session.used_s >= UNUSED_S
        ]
