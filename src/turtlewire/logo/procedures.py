"""What a name can stand for: a primitive, or a procedure of the user's; and what running one can come to."""

from __future__ import annotations

from turtlewire.logo.syntax import Call, Invocation, MaybeOutputCall, Node, OutputCall
from turtlewire.logo.tokens import PRECEDENCE
from turtlewire.named_tuple import NamedTuple

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, TypeAlias, TypeVar

    from turtlewire.logo.reader import Line
    from turtlewire.logo.tokens import Place
    from turtlewire.logo.values import Array, List, Value

    Function = TypeVar("Function", bound="Callable[..., Result]")


# How the result of an evaluation is used.
COMMAND = 0  # it must not output
BODY = 1  # the same, directly within a procedure's body: OUTPUT ends the procedure
LAST = 2  # the same, and nothing of the procedure comes after it
OPERATION = 3  # it must output


class Stop:
    """STOP: the procedure that is running ends."""

    __slots__ = ()


class Output:
    """OUTPUT: the procedure that is running ends with this value."""

    __slots__ = ("value",)

    def __init__(self, value: Value) -> None:
        self.value = value


class TailCall:
    """The last deed of a procedure is to invoke another one, which takes its place."""

    __slots__ = ("inputs", "may_output", "node")

    def __init__(self, node: Invocation, inputs: list[Value], *, may_output: bool = False) -> None:
        self.node = node
        self.inputs = inputs
        self.may_output = may_output  # .MAYBEOUTPUT: a value or none, both are fine


class Goto:
    """GOTO: the procedure that is running goes on from its TAG."""

    __slots__ = ("tag",)

    def __init__(self, tag: str) -> None:
        self.tag = tag


class RunList:
    """What a primitive such as IF outputs to have a list run in its own place."""

    __slots__ = ("instructions",)

    def __init__(self, instructions: Value) -> None:
        self.instructions = instructions


# ``None``: a command that is done.
Result: TypeAlias = "str | int | float | List | Array | Stop | Output | Goto | TailCall | RunList | None"


def _inputs(count: int) -> str:
    if count == 0:
        return "no inputs"
    return "1 input" if count == 1 else f"{count} inputs"


class BadInputError(Exception):
    """A primitive does not like an input; becomes "... doesn't like ... as input", with what it wants instead."""

    def __init__(self, value: Value, number: int = 7, wanted: str = "") -> None:
        super().__init__(value)
        self.value = value
        self.number = number
        self.wanted = wanted


class ThrowError(Exception):
    """THROW on its way to its CATCH."""

    def __init__(self, tag: str, value: Value | None) -> None:
        super().__init__(tag)
        self.tag = tag
        self.value = value


class ExitError(Exception):
    """STOP or OUTPUT from within an input, on its way to the end of the procedure."""

    def __init__(self, signal: Result) -> None:
        super().__init__()
        self.signal = signal


class Primitive:
    """A primitive: its names, how many inputs it takes, and the function that does it.

    The function gets the interpreter and then the inputs, one by one; all in one list when it takes any number. It is
    set by whoever has it.
    """

    __slots__ = (
        "default_inputs",
        "function",
        "maximum_inputs",
        "may_lack_input",
        "minimum_inputs",
        "name",
        "takes_alternative",
    )

    function: Callable[..., Result]

    def __init__(self, name: str, inputs: int, minimum: int, maximum: int) -> None:
        self.name = name
        self.default_inputs = inputs
        self.minimum_inputs = minimum
        self.maximum_inputs = maximum  # -1: any number
        self.takes_alternative = name == "if"
        self.may_lack_input = name in ("continue", "help", "save")  # at the end of a line

    def usage(self, name: str) -> str:
        """What people are told of its inputs when they gave too few or too many."""
        if name in PRECEDENCE:
            return f"{name} needs a value on each side of it."
        return f"{name} takes {_inputs(self.default_inputs)}."

    def call_node(self, name: str, inputs: list[Node], place: Place) -> Node:
        """The node of the syntax tree that calls this with these inputs."""
        return _CALLS.get(self.name, Call)(self, name, inputs, place)


_CALLS: dict[str, type[Call]] = {"output": OutputCall, ".maybeoutput": MaybeOutputCall}


class OptionalInput(NamedTuple):
    """An optional input, and the list that computes its value when it is not given."""

    name: str
    default: Line


class UserProcedure:
    """A procedure that a program defined. Defining it anew changes it in place."""

    __slots__ = (
        "body", "code", "default_inputs", "full_text", "function", "inputs", "is_erased", "is_macro", "is_refused",
        "maximum_inputs",
        "may_lack_input", "minimum_inputs", "name", "optional", "rest", "takes_alternative", "title",
    )  # fmt: skip

    def __init__(self, name: str) -> None:
        self.name = name
        self.inputs: list[str] = []
        self.optional: list[OptionalInput] = []
        self.rest = ""
        self.body: tuple[Line, ...] = ()
        self.full_text: tuple[str, ...] = ()  # as it was written, line by line; by DEFINE, it was not
        self.title: Line | None = None
        self.code: Any = None
        self.default_inputs = self.minimum_inputs = self.maximum_inputs = 0
        self.takes_alternative = False
        self.function: Callable[..., Value | None] | None = None  # what the compiler made of it
        self.is_refused = False  # whether the compiler leaves it to the evaluator
        self.may_lack_input = False
        self.is_macro = False  # what it outputs is run in its caller's place
        self.is_erased = False  # code that was parsed before may still refer to it

    def usage(self, name: str) -> str:
        """What people are told of its inputs when they gave too few or too many."""
        names = [f":{key}" for key in self.inputs]
        names += [f"[:{each.name} ...]" for each in self.optional]
        if self.rest:
            names.append(f"[:{self.rest}]")
        title = " ".join(["to", self.name, *names])
        return f"{name} takes {_inputs(self.default_inputs)}; it is defined as: {title}"

    def call_node(self, name: str, inputs: list[Node], place: Place) -> Node:
        """The node of the syntax tree that invokes this with these inputs."""
        return Invocation(self, name, inputs, place)


class Chapter:
    """Collects the primitives of one chapter of the manual."""

    def __init__(self) -> None:
        self.primitives: dict[str, Primitive] = {}

    def primitive(
        self, names: str, inputs: int = 0, *, minimum: int | None = None, maximum: int | None = None
    ) -> Callable[[Function], Function]:
        """Make a function a primitive.

        Args:
            names: its names, divided by spaces; the first is the full one.
            inputs: how many inputs it takes without parentheses.
            minimum: the fewest inputs within parentheses; ``inputs`` when left out.
            maximum: the most; -1 for any number, and then the function gets them in one list.
        """

        def register(function: Function) -> Function:
            spelled = names.split()
            fewest = inputs if minimum is None else minimum
            most = inputs if maximum is None else maximum
            primitive = Primitive(spelled[0], inputs, fewest, most)
            primitive.function = function
            for name in spelled:
                self.primitives[name] = primitive
            return function

        return register
