"""The primitives of Logo, one or two files per chapter of the manual; a chapter is loaded when a word of it is used."""

from __future__ import annotations

import sys

from turtlewire.logo.primitives.index import CHAPTERS
from turtlewire.logo.procedures import Primitive

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.logo.procedures import Chapter, Result


class _Listed(Primitive):
    """A primitive whose function is the one that its chapter has for it."""

    __slots__ = ("_chapter",)

    def __init__(self, name: str, inputs: int, minimum: int, maximum: int, chapter: str) -> None:
        super().__init__(name, inputs, minimum, maximum)
        self._chapter = chapter

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Callable[..., Result]:
            """The function, when it is first wanted; from then on it is an attribute like others."""
            if name != "function":
                raise AttributeError(f"primitives have no {name}")
            self.function = chapter(self._chapter).primitives[self.name].function
            return self.function


def chapter(name: str) -> Chapter:
    """A chapter, by the name of its file."""
    module = f"{__name__}.{name}"
    __import__(module)
    found: Chapter = sys.modules[module].chapter
    return found


PRIMITIVES: dict[str, Primitive] = {}
for _chapter, _words in CHAPTERS.items():
    for _names, _inputs, _minimum, _maximum in _words:
        _spelled = _names.split()
        _primitive = _Listed(_spelled[0], _inputs, _minimum, _maximum, _chapter)
        for _name in _spelled:
            PRIMITIVES[_name] = _primitive
