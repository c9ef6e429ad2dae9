"""What is buried, traced and stepped: names of procedures, variables and property lists, defined or not."""

from __future__ import annotations

from turtlewire.named_tuple import NamedTuple


class Names:
    """Names of each kind, in the spelling of tables."""

    __slots__ = ("procedures", "property_lists", "variables")

    def __init__(self) -> None:
        self.procedures: set[str] = set()
        self.variables: set[str] = set()
        self.property_lists: set[str] = set()

    def add(self, contents: Contents) -> None:
        """Mark these."""
        self.procedures.update(contents.procedures)
        self.variables.update(contents.variables)
        self.property_lists.update(contents.property_lists)

    def remove(self, contents: Contents) -> None:
        """Mark these no longer."""
        self.procedures.difference_update(contents.procedures)
        self.variables.difference_update(contents.variables)
        self.property_lists.difference_update(contents.property_lists)

    def has_first_of(self, contents: Contents) -> bool:
        """Whether the first name of a contents list that is not empty is marked."""
        for names, marked in (
            (contents.procedures, self.procedures),
            (contents.variables, self.variables),
            (contents.property_lists, self.property_lists),
        ):
            if names:
                return names[0] in marked
        return False

    def contents(self) -> Contents:
        """What is marked, in the order of the alphabet."""
        return Contents(sorted(self.procedures), sorted(self.variables), sorted(self.property_lists))


class Contents(NamedTuple):
    """A contents list: names of procedures, variables and property lists."""

    procedures: list[str]
    variables: list[str]
    property_lists: list[str]


class Marks:
    """What is marked in a workspace, and how deep traced procedures have called one another."""

    def __init__(self) -> None:
        self.buried = Names()
        self.traced = Names()
        self.stepped = Names()
        self.declared: set[str] = set()  # variables that GLOBAL named: their setters are known
        self.trace_depth = 0
        self.most_nodes = 0  # that NODES has told of
