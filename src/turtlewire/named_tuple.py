"""``NamedTuple`` as in ``typing``, for the modules that every Logo program loads.

``typing``, and ``re`` and ``collections`` which it needs, take longer to load than all of Logo; a short program would
wait for nothing else.
"""

from __future__ import annotations

from _collections import _tuplegetter as getter_of_field  # type: ignore[import-not-found]

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NamedTuple

__all__ = ["NamedTuple"]


class _Maker(type):
    """Makes a kind of tuple of the fields that a class names, with their defaults."""

    def __new__(cls, name: str, bases: tuple[type, ...], body: dict[str, Any]) -> type:
        if not bases:
            return super().__new__(cls, name, bases, body)
        fields = tuple(body.get("__annotations__", ()))
        defaults = {field: body.pop(field) for field in fields if field in body}
        getters = {field: getter_of_field(index, field) for index, field in enumerate(fields)}
        given = {
            "__new__": _constructor(name, fields, defaults),
            "_fields": fields,
            "_field_defaults": defaults,
        }
        return type(name, (tuple,), _METHODS | getters | given | body | {"__match_args__": fields})


def _constructor(name: str, fields: tuple[str, ...], defaults: dict[str, Any]) -> Any:
    inputs = ", ".join(fields)
    space: dict[str, Any] = {"tuple_of": tuple.__new__}
    exec(f"def __new__(cls, {inputs}): return tuple_of(cls, ({inputs},))", space)
    constructor = space["__new__"]
    constructor.__defaults__ = tuple(defaults.values())
    constructor.__qualname__ = f"{name}.__new__"
    return constructor


def _shown(self: Any) -> str:
    shown = ", ".join([f"{field}={value!r}" for field, value in zip(self._fields, self, strict=True)])
    return f"{type(self).__name__}({shown})"


def _replaced(self: Any, /, **values: object) -> Any:
    made = self._make([values.pop(field, value) for field, value in zip(self._fields, self, strict=True)])
    if values:
        raise ValueError(f"Got unexpected field names: {list(values)!r}")
    return made


def _as_dict(self: Any) -> dict[str, Any]:
    return dict(zip(self._fields, self, strict=True))


def _made(cls: Any, values: Any) -> Any:
    return cls(*values)


def _inputs(self: Any) -> tuple[Any, ...]:
    return tuple(self)


_METHODS: dict[str, Any] = {
    "__slots__": (),
    "__repr__": _shown,
    "__getnewargs__": _inputs,
    "_make": classmethod(_made),
    "_replace": _replaced,
    "_asdict": _as_dict,
}

if not TYPE_CHECKING:

    class NamedTuple(metaclass=_Maker):
        """See ``typing.NamedTuple``."""
