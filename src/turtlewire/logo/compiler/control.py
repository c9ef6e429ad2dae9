"""Control structures whose lists stand in the program: as Python's own."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from turtlewire.logo.compiler import python as py
from turtlewire.logo.compiler import structures, templating
from turtlewire.logo.compiler.emit import key_of
from turtlewire.logo.compiler.facts import as_line, local_names
from turtlewire.logo.compiler.kinds import NUMBER
from turtlewire.logo.compiler.roles import RefusedError
from turtlewire.logo.syntax import Call, Invocation, Literal, Node
from turtlewire.logo.values import plain, to_text

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.logo.compiler.emit import Blamed, Emitter
    from turtlewire.logo.compiler.python import Expr, Stmt
    from turtlewire.logo.reader import Line


# ---------------------------------------------------------------- conditions


def _if(emitter: Emitter, node: Call, tail: bool) -> None:
    condition = emitter.condition(node.inputs[0], node)
    then = emitter.block(emitter.line(node.inputs[1]), tail=tail)
    otherwise = emitter.block(emitter.line(node.inputs[2]), tail=tail) if len(node.inputs) > 2 else []
    emitter.body.append(py.when(condition, then, otherwise))


def _choice(emitter: Emitter, node: Call, blamed: Blamed) -> Expr:
    """IF and IFELSE that output."""
    if len(node.inputs) != 3:
        raise RefusedError("an if that may output nothing")
    condition = emitter.condition(node.inputs[0], node)
    made = [_branch(emitter, _single(emitter, each), node.name, blamed) for each in node.inputs[1:]]
    (first, then), (second, otherwise) = made
    if not first and not second:
        return py.either(condition, then, otherwise)
    name = emitter.temp()
    first.append(py.assign(name, then))
    second.append(py.assign(name, otherwise))
    emitter.body.append(py.when(condition, first, second))
    return py.name(name)


def _single(emitter: Emitter, node: Node) -> Line:
    """A list that stands for a value, in which there is one expression."""
    line = emitter.line(node)
    if len(emitter.survey.parse(line)) != 1:
        raise RefusedError("a list of several instructions that stands for a value")
    return line


def _branch(emitter: Emitter, line: Line, wanted_by: str, blamed: Blamed) -> tuple[list[Stmt], Expr]:
    """The statements and the value of a list that may be run."""
    found: list[Expr] = []
    return emitter.within(lambda: found.append(emitter.result(line, wanted_by, blamed))), found[0]


def _test(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001 - as all commands
    emitter.body.append(py.assign("test", emitter.condition(node.inputs[0], node)))
    emitter.has_test = True


def _iftrue(emitter: Emitter, node: Call, tail: bool) -> None:
    if not emitter.has_test:
        raise RefusedError("the TEST may be another procedure's")
    emitter.body.append(py.when(py.name("test"), emitter.block(emitter.line(node.inputs[0]), tail=tail)))


def _iffalse(emitter: Emitter, node: Call, tail: bool) -> None:
    if not emitter.has_test:
        raise RefusedError("the TEST may be another procedure's")
    block = emitter.block(emitter.line(node.inputs[0]), tail=tail)
    emitter.body.append(py.when(py.negated(py.name("test")), block))


def _run(emitter: Emitter, node: Call, tail: bool) -> None:
    emitter.instructions(emitter.survey.parse(emitter.line(node.inputs[0])), tail=tail)


def _run_for_value(emitter: Emitter, node: Call, blamed: Blamed) -> Expr:
    return emitter.result(_single(emitter, node.inputs[0]), node.name, blamed)


def _ignore(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001
    emitter.body.append(py.do(emitter.value(node.inputs[0], node.name)))


# ---------------------------------------------------------------- variables


def _make(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001
    emitter.set_variable(key_of(node.inputs[0]), emitter.value(node.inputs[1], node.name))


def _name(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001
    emitter.set_variable(key_of(node.inputs[1]), emitter.value(node.inputs[0], node.name))


def _thing(emitter: Emitter, node: Call) -> Expr:
    from turtlewire.logo.syntax import Variable

    literal = node.inputs[0]
    key_of(literal)
    assert isinstance(literal, Literal)
    return emitter.variable(Variable(to_text(literal.value), node.place))  # type: ignore[arg-type]


def _local(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001
    for key in local_names(node):
        local = emitter.names.get(key) if key is not None else None
        if local is None:
            raise RefusedError("a local variable that other procedures see")
        # Without a value, even when the procedure begins anew in its own place.
        emitter.body.append(py.assign(local, py.NONE))
        emitter.body.append(ast.Delete([ast.Name(local, ast.Del())]))


def _localmake(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001
    key = key_of(node.inputs[0])
    if key not in emitter.names:
        raise RefusedError("a local variable that other procedures see")
    emitter.set_variable(key, emitter.value(node.inputs[1], node.name))


# ---------------------------------------------------------------- loops


def _loop_body(emitter: Emitter, node: Node, count: str) -> tuple[list[Stmt], bool]:
    """The statements of a loop's list, and whether they ask how often it has run."""
    outer = emitter.count, emitter.asked_count
    emitter.count, emitter.asked_count = count, False
    try:
        return emitter.block(emitter.line(node), loop=True), emitter.asked_count
    finally:
        asked = emitter.asked_count
        emitter.count, emitter.asked_count = outer[0], outer[1] or (asked and not count)


def _repeat(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001
    times = emitter.value(node.inputs[0], node.name)
    if not (isinstance(times, ast.Constant) and type(times.value) is int and times.value >= 0):
        times = py.at(emitter.site(node), py.call("natural", times))
    counter = emitter.temp("i")
    body, asked = _loop_body(emitter, node.inputs[1], f"{counter}c")
    if asked:
        body.insert(0, py.assign(f"{counter}c", py.binary(py.name(counter), ast.Add(), py.const(1))))
    times = emitter.kept(times)
    loop = py.for_each(counter, py.call("range", times), body)
    emitter.body += _watched(emitter, times, loop, done=py.name(counter))


def _watched(emitter: Emitter, times: Expr, loop: Stmt, done: Expr | None = None) -> list[Stmt]:
    """A loop that tells how far it is: at top level, or where something moves in it, for that can take long.

    ``done`` is how often it has been run, if somebody counts that.
    """
    assert isinstance(loop, ast.For)
    if not (emitter.is_line and not emitter.loops) and not _moves(loop.body):
        return [loop]
    level = emitter.temp("level")
    first = ast.Subscript(py.name(level), py.const(0), py.STORE)
    if done is None:
        one_more = ast.AugAssign(first, ast.Add(), py.const(1))
        loop.body.append(py.when(py.is_some(py.name(level)), [one_more]))
    else:
        loop.body.insert(0, py.when(py.is_some(py.name(level)), [ast.Assign([first], done)]))
    leave = py.when(py.is_some(py.name(level)), [py.do(py.call("leave"))])
    return [py.assign(level, py.call("enter_loop", times)), ast.Try([loop], [], [], [leave])]


def _moves(body: list[Stmt]) -> bool:
    return any(
        isinstance(piece, ast.Call) and isinstance(piece.func, ast.Name) and piece.func.id.startswith("m_")
        for stmt in body
        for piece in ast.walk(stmt)
    )


def _forever(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001
    counter = emitter.temp("i")
    body, asked = _loop_body(emitter, node.inputs[0], counter)
    if asked:
        emitter.body.append(py.assign(counter, py.const(0)))
        body.insert(0, ast.AugAssign(ast.Name(counter, py.STORE), ast.Add(), py.const(1)))
    emitter.body.append(py.forever(body))


def _while(*, wanted: bool, test_first: bool) -> Callable[[Emitter, Call, bool], None]:
    def emit(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001
        condition, instructions = node.inputs if test_first else reversed(node.inputs)
        line = emitter.line(condition)

        def check() -> None:
            nodes = emitter.survey.parse(line)
            if len(nodes) != 1:
                raise RefusedError("a condition of several instructions")
            truth = emitter.condition(nodes[0], node)
            emitter.body.append(py.when(py.negated(truth) if wanted else truth, [ast.Break()]))

        checked = emitter.within(check)
        body = emitter.block(emitter.line(instructions), loop=True)
        emitter.body.append(py.forever([*checked, *body] if test_first else [*body, *checked]))

    return emit


def _for(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001
    control = emitter.line(node.inputs[0])
    if not 3 <= len(control.items) <= 4 or not isinstance(control.items[0], str):
        raise RefusedError("a FOR that cannot be right")
    key = plain(control.items[0]).lower()
    if not emitter.may_be_local(key):
        raise RefusedError("a loop's variable that other procedures see")
    limits: list[Expr] = []
    for index in range(1, len(control.items)):
        nodes = emitter.survey.parse(as_line(control, index))
        if len(nodes) != 1:
            raise RefusedError("a limit of several instructions")
        limits.append(emitter.kept(_limit(emitter, node, nodes[0])))
    start, end = limits[:2]
    step = limits[2] if len(limits) > 2 else py.call("direction", start, end)
    variable = emitter.bind(key)
    outer = emitter.names.get(key)
    emitter.names[key] = variable
    try:
        body = emitter.block(emitter.line(node.inputs[1]), loop=True)
    finally:
        if outer is None:
            del emitter.names[key]
        else:
            emitter.names[key] = outer
    numbers = emitter.kept(py.call("numbers", start, end, step))
    emitter.body += _watched(emitter, numbers, py.for_each(variable, numbers, body))


def _limit(emitter: Emitter, node: Call, limit: Node) -> Expr:
    value = emitter.value(limit, node.name)
    if emitter.kinds.of(limit) & NUMBER:
        return value
    return py.at(emitter.site(node), py.call("number", value))  # type: ignore[no-any-return]


def _repcount(emitter: Emitter, node: Call) -> Expr:
    if node.primitive.name == "#":
        raise RefusedError("it may ask for the number of a template")
    if not emitter.count:
        raise RefusedError("the REPEAT may be another procedure's")
    emitter.asked_count = True
    return py.name(emitter.count)


# ---------------------------------------------------------------- ends of procedures, and tail calls


def _stop(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001
    emitter.ending.nothing(emitter, node)


def _output(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001
    emitter.ending.output(emitter, node)


def invoke(emitter: Emitter, node: Invocation, *, tail: bool) -> None:
    """A procedure as a command."""
    if tail and emitter.ending.takes_over(emitter, node):
        return
    made = emitter.invocation(node, "", as_command=True)
    if emitter.namer.never_outputs(node.procedure):
        emitter.body.append(py.do(made))
        return
    number = emitter.site(node)
    name = emitter.temp()
    unused = py.do(py.at(number, py.call("unused", py.name(name))))
    emitter.body.append(py.when(py.is_some(py.walrus(name, made)), [unused]))


COMMANDS: dict[str, Callable[[Emitter, Call, bool], None]] = {
    "if": _if, "ifelse": _if, "test": _test, "iftrue": _iftrue, "iffalse": _iffalse, "run": _run, "ignore": _ignore,
    "make": _make, "name": _name, "local": _local, "localmake": _localmake, "repeat": _repeat, "forever": _forever,
    "while": _while(wanted=True, test_first=True), "until": _while(wanted=False, test_first=True),
    "do.while": _while(wanted=True, test_first=False), "do.until": _while(wanted=False, test_first=False),
    "for": _for, "setitem": structures.set_item, "foreach": templating.foreach, "stop": _stop, "output": _output,
}  # fmt: skip
# Operations whose value is that of a list that they run.
CHOICES: dict[str, Callable[[Emitter, Call, Blamed], Expr]] = {
    "if": _choice, "ifelse": _choice, "run": _run_for_value,
}  # fmt: skip
OPERATIONS: dict[str, Callable[[Emitter, Call], Expr]] = {
    "thing": _thing, "repcount": _repcount, "#": _repcount,
    "?": templating.slot, "map": templating.mapped, "filter": templating.filtered, "find": templating.found,
    "reduce": templating.reduced,
}  # fmt: skip
