"""Instruction lists to syntax trees, by the arities that procedures have when the list is run.

Precedence, lowest first: ``= <> < > <= >=``, then ``+ -``, then ``* /``, then unary minus; the inputs of a procedure
reach as far to the right as they can. Which minus is unary: see ``tokens``.
"""

from __future__ import annotations

from turtlewire.logo.errors import (
    LogoError,
    not_enough_inputs,
    too_many_inputs,
    unexpected_parenthesis,
    unknown_procedure,
)
from turtlewire.logo.reader import Line
from turtlewire.logo.tokens import DOTS, NAME, NEGATE, PRECEDENCE, VALUE, Place, Token, placed
from turtlewire.logo.values import Array, parse_number, plain, to_text

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from turtlewire.logo.procedures import Primitive, UserProcedure
    from turtlewire.logo.reader import Item
    from turtlewire.logo.values import Value


class Literal:
    """A number, a quoted word or a list: it is its own value; ``line`` is how a list was read, if it was."""

    __slots__ = ("line", "place", "value")

    def __init__(self, item: Item, place: Place) -> None:
        self.line = item if isinstance(item, Line) else None
        self.value: Value = item.value if isinstance(item, Line) else item
        self.place = place


class Variable:
    """``:name``."""

    __slots__ = ("key", "name", "place")

    def __init__(self, name: str, place: Place) -> None:
        self.name = name
        self.key = plain(name).lower()
        self.place = place


class Call:
    """A primitive with its inputs; ``name`` is the name it was called by."""

    __slots__ = ("inputs", "name", "place", "primitive")

    def __init__(self, primitive: Primitive, name: str, inputs: list[Node], place: Place) -> None:
        self.primitive = primitive
        self.name = name
        self.inputs = inputs
        self.place = place


class OutputCall(Call):
    """OUTPUT with its input: apart, because what it invokes can take the place of the procedure that is running."""

    __slots__ = ()


class MaybeOutputCall(Call):
    """.MAYBEOUTPUT with its input, which may have no value: the one exception to how inputs are evaluated."""

    __slots__ = ()


class Invocation:
    """A user's procedure with its inputs."""

    __slots__ = ("inputs", "name", "place", "procedure")

    def __init__(self, procedure: UserProcedure, name: str, inputs: list[Node], place: Place) -> None:
        self.procedure = procedure
        self.name = name
        self.inputs = inputs
        self.place = place


class Unknown:
    """A word that named no procedure when it was to run: a variable (getter syntax), or an error."""

    __slots__ = ("name", "place")

    def __init__(self, name: str, place: Place) -> None:
        self.name = name
        self.place = place


class Failure:
    """What cannot be parsed; the error is raised when the evaluator gets there."""

    __slots__ = ("error", "place")

    def __init__(self, error: LogoError, place: Place) -> None:
        self.error = error
        self.place = place


class Pending:
    """The rest of a line from the first instruction with an unknown word: parsed again when it is to run."""

    __slots__ = ("place", "tokens")

    def __init__(self, tokens: list[Token], place: Place) -> None:
        self.tokens = tokens
        self.place = place


Node = Literal | Variable | Call | OutputCall | MaybeOutputCall | Invocation | Unknown | Failure | Pending


class Code:
    """A parsed instruction list: valid as long as no procedure is defined anew (``epoch``).

    ``lines`` are the lines that its instructions stood in, one for each of them, when it is a procedure's body.
    """

    __slots__ = ("epoch", "instructions", "last", "lines")

    def __init__(self, nodes: list[Node], epoch: int, lines: Sequence[Line] = ()) -> None:
        self.lines = lines
        self.instructions = nodes[:-1]
        self.last = nodes[-1] if nodes else None
        self.epoch = epoch


class _UnknownNameError(Exception):
    """An unknown word on the first parse: what follows must wait until it is to run."""


class Parser:
    """Parses the tokens of one instruction list.

    Args:
        tokens: what ``tokenize`` made.
        procedures: every procedure, by its name in lower case.
        remember: told of each list that stands in the program, so that it is known again when it is run as a value.
        is_variable: whether a variable of this name has a value; given only when the first instruction is to run
            right now, so that unknown words in it can be decided on.
    """

    def __init__(
        self,
        tokens: list[Token],
        procedures: Mapping[str, Primitive | UserProcedure],
        remember: Callable[[Line], None],
        is_variable: Callable[[str], bool] | None = None,
    ) -> None:
        self.tokens = tokens
        self.index = 0
        self.procedures = procedures
        self._remember = remember
        self.is_variable = is_variable
        self._negation = procedures["minus"]

    def parse(self) -> list[Node]:
        """The instructions; an error among them stands where it will be raised."""
        nodes: list[Node] = []
        while self.index < len(self.tokens):
            start = self.index
            place = self.tokens[start].place
            try:
                nodes.append(self._expression(0, ""))
            except _UnknownNameError:
                nodes.append(Pending(self.tokens[start:], place))
                break
            except LogoError as error:
                nodes.append(Failure(error, place))
                break
            self.is_variable = None  # only the first instruction is to run right now
        return nodes

    def _kind(self) -> str:
        return self.tokens[self.index].kind if self.index < len(self.tokens) else ""

    def _expression(self, minimum: int, wanted_by: str) -> Node:
        left = self._operand(wanted_by)
        while (precedence := PRECEDENCE.get(self._kind(), 0)) > minimum:
            token = self.tokens[self.index]
            self.index += 1
            right = self._expression(precedence, token.kind)
            primitive = self.procedures[token.kind]
            left = Call(primitive, token.kind, [left, right], token.place)  # type: ignore[arg-type]
        return left

    def _operand(self, wanted_by: str) -> Node:
        kind = self._kind()
        if not kind or kind == ")" or kind in PRECEDENCE:
            place = self.tokens[min(self.index, len(self.tokens) - 1)].place
            if wanted_by in PRECEDENCE and kind in PRECEDENCE:
                raise placed(not_enough_inputs(kind), self.tokens[self.index].place)
            if wanted_by:
                raise placed(self._not_enough_inputs(wanted_by), place)
            if kind == ")":
                raise placed(unexpected_parenthesis(), place)
            raise placed(not_enough_inputs(kind), place)
        token = self._named_token()
        self.index += 1
        if kind == VALUE:
            if isinstance(token.value, Line):
                self._remember(token.value)
            literal = Literal(token.value, token.place)
            if isinstance(token.value, Array):  # a new one whenever it is evaluated
                return Call(self.procedures["{}"], "{}", [literal], token.place)  # type: ignore[arg-type]
            return literal
        if kind == DOTS:
            return Variable(to_text(token.value), token.place)  # type: ignore[arg-type]
        if kind == NEGATE:
            return Call(self._negation, "-", [self._operand("-")], token.place)  # type: ignore[arg-type]
        if kind == "(":
            return self._parenthesised()
        return self._call(token)

    def _call(self, token: Token) -> Node:
        name = str(token.value)
        procedure = self._procedure(name)
        if procedure is None:
            return self._unknown(name, token)
        inputs: list[Node] = []
        if procedure.may_lack_input and not self._kind():
            return procedure.call_node(name, inputs, token.place)
        for _ in range(procedure.default_inputs):
            if not self._kind() or self._kind() == ")":
                raise placed(self._not_enough_inputs(name), token.place)
            inputs.append(self._expression(0, name))
        if procedure.takes_alternative and self._next_is_list():
            inputs.append(self._operand(name))
        return procedure.call_node(name, inputs, token.place)

    def _next_is_list(self) -> bool:
        return self._kind() == VALUE and isinstance(self.tokens[self.index].value, Line | list)

    def _procedure(self, name: str) -> Primitive | UserProcedure | None:
        return self.procedures.get(plain(name).lower())

    def _named_token(self) -> Token:
        """The next token; a name that only spells a procedure's with a number behind it (``fd100``) is made two."""
        token = self.tokens[self.index]
        if token.kind != NAME or self._procedure(str(token.value)) is not None:
            return token
        name = str(token.value)
        stem = name.rstrip("0123456789")
        if len(stem) == len(name) or self._procedure(stem) is None:
            return token
        place = (token.place[0], token.place[1] + len(stem)) if token.place is not None else None
        number = Token(VALUE, parse_number(name[len(stem) :]), place)  # type: ignore[arg-type]
        token = Token(NAME, stem, token.place)
        self.tokens = [*self.tokens[: self.index], token, number, *self.tokens[self.index + 1 :]]
        return token

    def _not_enough_inputs(self, name: str) -> LogoError:
        procedure = self._procedure(name)
        return not_enough_inputs(name, procedure.usage(name) if procedure is not None else "")

    def _unknown(self, name: str, token: Token) -> Node:
        if self.is_variable is None:
            raise _UnknownNameError
        key = plain(name).lower()
        if (
            len(key) > 3
            and key.startswith("set")
            and self.is_variable(key[3:])
            and self._kind() not in ("", ")")
        ):
            make = self.procedures["make"]
            value = self._expression(0, name)
            return make.call_node("make", [Literal(key[3:], token.place), value], token.place)
        return Unknown(name, token.place)

    def _parenthesised(self) -> Node:
        if self._kind() != NAME or self._infix_follows():
            node = self._expression(0, "")
            if self._kind() != ")":
                raise placed(
                    LogoError(
                        8,
                        "too much inside ()'s",
                        hint="Parentheses hold one value, or one procedure with all of its inputs.",
                    ),
                    self.tokens[self.index].place,
                )
            self.index += 1
            return node
        token = self._named_token()
        self.index += 1
        name = str(token.value)
        procedure = self._procedure(name)
        inputs: list[Node] = []
        if procedure is None:
            node = self._unknown(name, token)
            if self._kind() != ")":
                # Whatever inputs it was meant to have: the unknown name is the error to tell of.
                raise placed(unknown_procedure(name, list(self.procedures)), token.place)
            self.index += 1
            return node
        while self._kind() != ")":
            inputs.append(self._expression(0, name))
        self.index += 1
        if len(inputs) < procedure.minimum_inputs:
            raise placed(self._not_enough_inputs(name), token.place)
        if 0 <= procedure.maximum_inputs < len(inputs):
            raise placed(too_many_inputs(name, procedure.usage(name)), token.place)
        return procedure.call_node(name, inputs, token.place)

    def _infix_follows(self) -> bool:
        """Whether a name just inside a parenthesis is an operand, as in ``(xcor + 1)``."""
        following = self.tokens[self.index + 1] if self.index + 1 < len(self.tokens) else None
        return following is not None and following.kind in PRECEDENCE
