"""Lines of the program with loops in them: functions that take global variables into Python locals, and give them back.

Where the text says that variables only ever hold whole numbers if they do at first, the line is written twice: for
that case, and for any other.
"""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from turtlewire.logo.compiler import python as py
from turtlewire.logo.compiler.emit import Emitter
from turtlewire.logo.compiler.kinds import (
    ARRAY,
    COUNT,
    NATURAL,
    NOTHING,
    NUMBER,
    SMALL,
    SMALL_AT_FIRST,
    WHOLE,
    Kinds,
)
from turtlewire.logo.compiler.sites import identifier
from turtlewire.logo.syntax import Call

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from turtlewire.logo.compiler.facts import Facts, Survey
    from turtlewire.logo.compiler.python import Expr, Stmt
    from turtlewire.logo.compiler.roles import Namer
    from turtlewire.logo.syntax import Node

_MOST_NODES = 400  # of a line that is written twice


class LineWriter:
    """Writes the function of a line.

    Args:
        survey: what is known of all procedures.
        nodes: the line's instructions.
        facts: what is known of them.
        namer: see ``Emitter``.
        may_be_local: see ``Emitter``.
    """

    def __init__(
        self,
        survey: Survey,
        nodes: Sequence[Node],
        facts: Facts,
        namer: Namer,
        may_be_local: Callable[[str], bool],
    ) -> None:
        self._survey = survey
        self._nodes = nodes
        self._facts = facts
        self._emitter = Emitter(survey, facts, namer, may_be_local)
        self._emitter.is_line = True
        self._emitter.site(nodes[0])  # where it is when it is nowhere in particular
        within = list(survey.walk(nodes))
        self._is_long = len(within) > _MOST_NODES
        calls = [each for each in within if isinstance(each, Call)]
        self._assigned = {key for key, _ in Kinds(survey, nodes, at_first={}).assignments}
        moves = facts.moves or any(survey.facts(each).moves for each in survey.reached_from(facts))
        declares = any(each.primitive.name in ("local", "localmake") for each in calls)
        # What a limit sensor starts may ask for any variable.
        keys = [] if moves or declares else sorted(key for key in facts.free if may_be_local(key))
        self._names = {key: f"{identifier(key)}_" for key in keys}

    def written(self) -> Emitter:
        """The emitter, when it has written the function's body.

        Raises:
            RefusedError: it is left to the evaluator.
        """
        emitter = self._emitter
        if self._names:
            emitter.names.update(self._names)
            body = self._with_locals()
            if not _asks_truth(body):  # a list that is run for it might set them
                emitter.body = body
                return emitter
            emitter.names.clear()
            emitter.uncertain.clear()
            del emitter.sites[1:]
        emitter.body = self._body(Kinds(self._survey, self._nodes, (), self._facts.free))
        return emitter

    def _body(self, kinds: Kinds) -> list[Stmt]:
        emitter = self._emitter
        emitter.kinds = kinds
        emitter.has_test = False
        return emitter.within(lambda: emitter.instructions(self._nodes))

    def _with_locals(self) -> list[Stmt]:
        emitter, names = self._emitter, self._names
        free = self._facts.free
        hopeful = Kinds(self._survey, self._nodes, (), free, dict.fromkeys(names, COUNT))
        known = {key: kind for key in names if (kind := hopeful.of_variable(key)) & NUMBER}
        quick: list[Stmt] = []
        if known and not self._is_long:
            emitter.uncertain = {name for key, name in names.items() if key not in known}
            quick = [*self._without(set(names) - set(known)), *self._body(hopeful)]
        emitter.uncertain = set(names.values())
        plain = Kinds(self._survey, self._nodes, (), free, dict.fromkeys(names, NOTHING))
        body = [*self._without(names), *self._body(plain)]
        if quick:
            conditions = [each for key, kind in known.items() for each in _is_of(kind, py.name(names[key]))]
            condition = py.all_of(*conditions) if len(conditions) > 1 else conditions[0]
            body = [py.when(condition, quick, body)]
        get = ast.Attribute(py.name("V"), "get", py.LOAD)
        taken = [py.assign(name, ast.Call(get, [py.const(key)], [])) for key, name in names.items()]
        given = [self._given_back(key) for key in names if key in self._assigned]
        return [*taken, ast.Try(body, [], [], given)] if given else [*taken, *body]

    def _without(self, keys: Sequence[str] | set[str] | dict[str, str]) -> list[Stmt]:
        """Variables that have no value have none in the Python local, either."""
        found: list[Stmt] = []
        for key in sorted(keys):
            delete = ast.Delete([ast.Name(self._names[key], ast.Del())])
            found.append(py.when(py.is_none(py.name(self._names[key])), [delete]))
        return found

    def _given_back(self, key: str) -> Stmt:
        place = ast.Subscript(py.name("V"), py.const(key), py.STORE)
        has_none = ast.ExceptHandler(py.name("NameError"), None, [ast.Pass()])
        return ast.Try([ast.Assign([place], py.name(self._names[key]))], [has_none], [], [])


def _is_of(kind: int, value: Expr) -> list[Expr]:
    """What is asked of a value before it is taken to be of a kind."""
    assert not kind & ARRAY
    if not kind & WHOLE:
        return [py.compare(py.call("type", value), ast.In(), py.name("NUMBERS"))]
    conditions = [py.has_type(value, "int")]
    least = py.const(0 if kind & NATURAL else -SMALL_AT_FIRST)
    if kind & SMALL:
        conditions.append(ast.Compare(least, [ast.LtE(), ast.LtE()], [value, py.const(SMALL_AT_FIRST)]))
    elif kind & NATURAL:
        conditions.append(py.compare(value, ast.GtE(), least))
    return conditions


def _asks_truth(body: list[Stmt]) -> bool:
    return any(
        isinstance(piece, ast.Name) and piece.id == "truth" for stmt in body for piece in ast.walk(stmt)
    )
