"""What the console refuses, and how it says so."""

from __future__ import annotations

from typing import Any

from turtlewire.errors import TurtlewireError


class Refused(TurtlewireError):  # noqa: N818 (it is no error of the console's)
    """Something is not done for whoever asked for it.

    Args:
        status: of an HTTP answer: 400..429.
        code: for the page, which translates it.
        text: in English, for machines and logs: what was wrong, and what to do.
        details: more of it, for machines.
    """

    exit_code = 2

    def __init__(self, status: int, code: str, text: str, details: dict[str, Any] | None = None) -> None:
        super().__init__(text)
        self.status = status
        self.code = code
        self.text = text
        self.details = details

    def as_json(self) -> dict[str, Any]:
        """The answer: ``models.Refusal``."""
        return {"code": self.code, "text": self.text} | ({"details": self.details} if self.details else {})
