"""Instruction lists to syntax trees, by the arities that procedures have when the list is run.

Precedence, lowest first: ``= <> < > <= >=``, then ``+ -``, then ``* /``, then unary minus; the inputs of a procedure
reach as far to the right as they can. A minus is unary after an infix operator or ``(``, whatever follows it; anywhere
else, when it begins a word of more than itself: ``3 - -2``, ``3 - - 2``, ``(- :a)`` and ``print -3`` negate, ``3 -2``
are two values, and the minus alone in ``print - 3`` is infix.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from turtlewire.logo.errors import LogoError, not_enough_inputs, too_many_inputs, unknown_procedure
from turtlewire.logo.values import LogoList, Value, parse_number, plain, to_text, without_backslashes, word

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from turtlewire.logo.procedures import Primitive, UserProcedure
    from turtlewire.logo.reader import Source

Place = tuple["Source", int] | None

PRECEDENCE = {"=": 1, "<>": 1, "<": 1, ">": 1, "<=": 1, ">=": 1, "+": 2, "-": 2, "*": 3, "/": 3}
_DELIMITERS = frozenset("()+-*/=<>")


class Literal:
    """A number, a quoted word or a list: it is its own value."""

    __slots__ = ("place", "value")

    def __init__(self, value: Value, place: Place) -> None:
        self.value = value
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


Node = Literal | Variable | Call | OutputCall | Invocation | Unknown | Failure | Pending


class Code:
    """A parsed instruction list: valid as long as no procedure is defined anew (``epoch``)."""

    __slots__ = ("epoch", "instructions", "last")

    def __init__(self, nodes: list[Node], epoch: int) -> None:
        self.instructions = nodes[:-1]
        self.last = nodes[-1] if nodes else None
        self.epoch = epoch


class Token(NamedTuple):
    """What the parser reads: ``kind`` is one of the constants below, or an infix operator or parenthesis itself."""

    kind: str
    value: Value
    place: Place


VALUE = "value"
DOTS = "dots"
NAME = "name"
NEGATE = "negate"


def tokenize(instructions: LogoList) -> list[Token]:
    """Split the words of a list into tokens.

    Raises:
        LogoError: a ``)`` without ``(``.
    """
    tokens: list[Token] = []
    source, offsets = instructions.source, instructions.offsets
    for index, item in enumerate(instructions.items):
        offset = offsets[index] if offsets else 0
        if isinstance(item, str):
            _split(item, tokens, source, offset)
        else:
            tokens.append(Token(VALUE, item, (source, offset) if source is not None else None))
    _check_parentheses(tokens)
    return tokens


def _check_parentheses(tokens: list[Token]) -> None:
    opened: list[Token] = []
    for token in tokens:
        if token.kind == "(":
            opened.append(token)
        elif token.kind == ")":
            if not opened:
                raise _placed(LogoError(12, "unexpected ')'"), token.place)
            opened.pop()
    if opened:
        raise _placed(LogoError(10, "too many ('s", hint="This ( has no )."), opened[-1].place)


def _placed(error: LogoError, place: Place) -> LogoError:
    if error.position is None and place is not None:
        error.position = place[0].position(place[1])
    return error


def _split(text: str, tokens: list[Token], source: Source | None, offset: int) -> None:
    """Split one word, whose first character stands at ``offset``, into tokens."""
    i, size = 0, len(text)
    if not text:
        tokens.append(Token(NAME, text, (source, offset) if source is not None else None))
    while i < size:
        place = (source, offset + i) if source is not None else None
        c = text[i]
        if c == '"':
            end = _end_of(text, i, "()")
            tokens.append(Token(VALUE, _quoted(text[i + 1 : end]), place))
            i = end
        elif c in _DELIMITERS:
            operator = text[i : i + 2] if text[i : i + 2] in PRECEDENCE else c
            end = i + len(operator)
            after_operator = bool(tokens) and (tokens[-1].kind in PRECEDENCE or tokens[-1].kind in ("(", NEGATE))
            if c == "-" and (after_operator or (i == 0 and end < size)):
                end = _negative(text, i, tokens, place)
            else:
                tokens.append(Token(operator, operator, place))
            i = end
        else:
            end = _end_of_name(text, i)
            piece = text[i:end]
            if c == ":":
                tokens.append(Token(DOTS, without_backslashes(piece[1:]), place))
            elif c == "?" and piece[1:].isdigit():
                tokens += [Token("(", "(", place), Token(NAME, "?", place)]
                tokens += [Token(VALUE, int(piece[1:]), place), Token(")", ")", place)]
            else:
                tokens.append(_name_or_number(piece, place))
            i = end


def _negative(text: str, start: int, tokens: list[Token], place: Place) -> int:
    """A unary minus: a negative number, or the operator; outputs where it ends."""
    end = _end_of_name(text, start + 1)
    if end > start + 1:
        token = _name_or_number(text[start:end], place)
        if token.kind == VALUE:
            tokens.append(token)
            return end
    tokens.append(Token(NEGATE, "-", place))
    return start + 1


def _end_of(text: str, start: int, delimiters: str) -> int:
    end = start
    while end < len(text) and text[end] not in delimiters:
        end += 1
    return end


def _end_of_name(text: str, start: int) -> int:
    """The end of a word that stops at operators; the sign of an exponent (``1e-7``) does not count as one."""
    i = start
    while i < len(text):
        if text[i] in _DELIMITERS:
            head = text[start:i]
            digits = head[:-1].replace(".", "", 1)
            is_exponent = (
                text[i] in "+-" and head[-1:] in "eE" and digits.isdigit() and text[i + 1 : i + 2].isdigit()
            )
            if not is_exponent:
                break
        i += 1
    return i


def _quoted(text: str) -> Value:
    return word(without_backslashes(text))


def _name_or_number(text: str, place: Place) -> Token:
    number = parse_number(text)
    return Token(NAME, text, place) if number is None else Token(VALUE, number, place)


class _UnknownNameError(Exception):
    """An unknown word on the first parse: what follows must wait until it is to run."""


class Parser:
    """Parses the tokens of one instruction list.

    Args:
        tokens: what ``tokenize`` made.
        procedures: every procedure, by its name in lower case.
        is_variable: whether a variable of this name has a value; given only when the first instruction is to run
            right now, so that unknown words in it can be decided on.
    """

    def __init__(
        self,
        tokens: list[Token],
        procedures: Mapping[str, Primitive | UserProcedure],
        is_variable: Callable[[str], bool] | None = None,
    ) -> None:
        self.tokens = tokens
        self.index = 0
        self.procedures = procedures
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
            if wanted_by:
                raise _placed(not_enough_inputs(wanted_by), place)
            if kind == ")":
                raise _placed(LogoError(12, "unexpected ')'"), place)
            raise _placed(not_enough_inputs(kind), place)
        token = self.tokens[self.index]
        self.index += 1
        if kind == VALUE:
            return Literal(token.value, token.place)
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
        for _ in range(procedure.default_inputs):
            if not self._kind() or self._kind() == ")":
                raise _placed(not_enough_inputs(name), token.place)
            inputs.append(self._expression(0, name))
        if procedure.takes_alternative and self._next_is_list():
            inputs.append(self._operand(name))
        return procedure.call_node(name, inputs, token.place)

    def _next_is_list(self) -> bool:
        return self._kind() == VALUE and isinstance(self.tokens[self.index].value, LogoList)

    def _procedure(self, name: str) -> Primitive | UserProcedure | None:
        return self.procedures.get(plain(name).lower())

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
                raise _placed(LogoError(8, "too much inside ()'s"), self.tokens[self.index].place)
            self.index += 1
            return node
        token = self.tokens[self.index]
        self.index += 1
        name = str(token.value)
        procedure = self._procedure(name)
        inputs: list[Node] = []
        if procedure is None:
            node = self._unknown(name, token)
            if self._kind() != ")":
                # Whatever inputs it was meant to have: the unknown name is the error to tell of.
                raise _placed(unknown_procedure(name, list(self.procedures)), token.place)
            self.index += 1
            return node
        while self._kind() != ")":
            inputs.append(self._expression(0, name))
        self.index += 1
        if len(inputs) < procedure.minimum_inputs:
            raise _placed(not_enough_inputs(name), token.place)
        if 0 <= procedure.maximum_inputs < len(inputs):
            raise _placed(too_many_inputs(name), token.place)
        return procedure.call_node(name, inputs, token.place)

    def _infix_follows(self) -> bool:
        """Whether a name just inside a parenthesis is an operand, as in ``(xcor + 1)``."""
        following = self.tokens[self.index + 1] if self.index + 1 < len(self.tokens) else None
        return following is not None and following.kind in PRECEDENCE
