"""Templates that stand in the program, and what goes through lists with them: as Python's loops."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from turtlewire.logo.compiler import python as py
from turtlewire.logo.compiler.emit import SlotNode
from turtlewire.logo.compiler.facts import TEMPLATES
from turtlewire.logo.compiler.roles import RefusedError
from turtlewire.logo.reader import Line
from turtlewire.logo.syntax import Call, Literal, Node
from turtlewire.logo.values import plain, to_text

if TYPE_CHECKING:
    from turtlewire.logo.compiler.emit import Emitter
    from turtlewire.logo.compiler.python import Expr, Stmt


def slot(emitter: Emitter, node: Call) -> Expr:
    """?."""
    which = 1
    if node.inputs:
        number = node.inputs[0]
        if not isinstance(number, Literal) or not isinstance(number.value, int):
            raise RefusedError("a slot that is computed")
        which = number.value
    if not 1 <= which <= len(emitter.slots):
        raise RefusedError("the template may be another procedure's")
    return py.name(emitter.slots[which - 1])


def _template(emitter: Emitter, node: Call, slots: list[str]) -> tuple[list[Stmt], Expr]:
    """What a template outputs for its slots: statements, and then an expression."""
    template = node.inputs[TEMPLATES[node.primitive.name]]
    found: list[Expr] = []
    if isinstance(template, Literal) and template.line is not None:
        line = template.line
        if not line.items or isinstance(line.items[0], Line | list):
            raise RefusedError("a template of another form")
        outer = emitter.slots, emitter.count
        emitter.slots, emitter.count = slots, ""
        emitter.loops += 1
        try:
            statements = emitter.within(lambda: found.append(emitter.result(line, node.name)))
        finally:
            emitter.slots, emitter.count = outer
            emitter.loops -= 1
        return statements, found[0]
    name = plain(to_text(template.value)).lower() if isinstance(template, Literal) else ""  # type: ignore[arg-type]
    procedure = emitter.survey.procedure(name)
    if procedure is None or not procedure.minimum_inputs <= len(slots) or not _takes(procedure, len(slots)):
        raise RefusedError("a template that is computed")
    inputs: list[Node] = [SlotNode(slot) for slot in slots]
    called = procedure.call_node(name, inputs, node.place)
    statements = emitter.within(lambda: found.append(emitter.value(called, node.name)))
    return statements, found[0]


def _takes(procedure: object, count: int) -> bool:
    maximum: int = procedure.maximum_inputs  # type: ignore[attr-defined]
    return maximum < 0 or count <= maximum


def _data(emitter: Emitter, node: Call, data: Node) -> tuple[Expr, Expr]:
    """The input, and its members."""
    whole = emitter.kept(emitter.value(data, node.name))
    return whole, py.at(emitter.site(node), py.call("each_of", whole))


def mapped(emitter: Emitter, node: Call) -> Expr:
    """MAP."""
    if len(node.inputs) != 2:
        raise RefusedError("several lists at once")
    whole, members = _data(emitter, node, node.inputs[1])
    slot, made = emitter.temp("q"), emitter.temp()
    statements, value = _template(emitter, node, [slot])
    emitter.body.append(py.assign(made, ast.List([], py.LOAD)))
    append = ast.Call(ast.Attribute(py.name(made), "append", py.LOAD), [value], [])
    emitter.body.append(py.for_each(slot, members, [*statements, py.do(append)]))
    return py.at(emitter.site(node), py.call("like", whole, py.name(made)))  # type: ignore[no-any-return]


def _truth_of_template(emitter: Emitter, node: Call, slot: str) -> tuple[list[Stmt], Expr]:
    template = node.inputs[0]
    if isinstance(template, Literal) and template.line is not None:
        nodes = emitter.survey.parse(template.line)
        if (
            len(nodes) == 1
            and isinstance(nodes[0], Call)
            and not isinstance(template.line.items[0], Line | list)
        ):
            found: list[Expr] = []
            outer = emitter.slots, emitter.count
            emitter.slots, emitter.count = [slot], ""
            try:
                statements = emitter.within(lambda: found.append(emitter.condition(nodes[0], node)))
            finally:
                emitter.slots, emitter.count = outer
            return statements, found[0]
    statements, value = _template(emitter, node, [slot])
    return statements, emitter.truth(*emitter.named(value), node, node)


def filtered(emitter: Emitter, node: Call) -> Expr:
    """FILTER."""
    whole, members = _data(emitter, node, node.inputs[1])
    slot, made = emitter.temp("q"), emitter.temp()
    statements, truth = _truth_of_template(emitter, node, slot)
    emitter.body.append(py.assign(made, ast.List([], py.LOAD)))
    append = ast.Call(ast.Attribute(py.name(made), "append", py.LOAD), [py.name(slot)], [])
    kept = py.when(truth, [py.do(append)])
    emitter.body.append(py.for_each(slot, members, [*statements, kept]))
    return py.at(emitter.site(node), py.call("like", whole, py.name(made)))  # type: ignore[no-any-return]


def found(emitter: Emitter, node: Call) -> Expr:
    """FIND."""
    _, members = _data(emitter, node, node.inputs[1])
    slot, made = emitter.temp("q"), emitter.temp()
    statements, truth = _truth_of_template(emitter, node, slot)
    emitter.body.append(py.assign(made, py.name("NIL")))
    found = py.when(truth, [py.assign(made, py.name(slot)), ast.Break()])
    emitter.body.append(py.for_each(slot, members, [*statements, found]))
    return py.name(made)


def reduced(emitter: Emitter, node: Call) -> Expr:
    """REDUCE."""
    whole = emitter.kept(emitter.value(node.inputs[1], node.name))
    slot, made, rest = emitter.temp("q"), emitter.temp(), emitter.temp()
    statements, value = _template(emitter, node, [slot, made])
    members = py.at(emitter.site(node), py.call("backwards", whole))
    emitter.body.append(py.assign(rest, members))
    pop = ast.Call(ast.Attribute(py.name(rest), "pop", py.LOAD), [], [])
    emitter.body.append(py.assign(made, pop))
    again = py.call("reversed", py.name(rest))
    emitter.body.append(py.for_each(slot, again, [*statements, py.assign(made, value)]))
    return py.name(made)


def foreach(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001 - as all commands
    """FOREACH."""
    template = node.inputs[-1]
    if len(node.inputs) != 2 or not isinstance(template, Literal) or template.line is None:
        raise RefusedError("a template that is computed")
    line = template.line
    if line.items and isinstance(line.items[0], Line | list):
        raise RefusedError("a template of another form")
    _, members = _data(emitter, node, node.inputs[0])
    slot = emitter.temp("q")
    outer = emitter.slots, emitter.count
    emitter.slots, emitter.count = [slot], ""
    try:
        body = emitter.block(line, loop=True)
    finally:
        emitter.slots, emitter.count = outer
    emitter.body.append(py.for_each(slot, members, body))
