"""The compiler: Logo procedures as Python functions.

A procedure is compiled, with all that it reaches, when it is called first. What it cannot be compiled for (lists that
are computed and run, variables whose names are computed, inputs that can be left out ...) is left to the evaluator,
procedure by procedure: both call each other, and share all variables that the other may see.
"""

from turtlewire.logo.compiler.compiling import Compiler
from turtlewire.logo.compiler.store import Store

__all__ = ["Compiler", "Store"]
