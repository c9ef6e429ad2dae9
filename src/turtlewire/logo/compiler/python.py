"""Pieces of Python's syntax, short to write.

Every piece that can fail carries, as its line number, the number of the Logo instruction that it comes from: so the
traceback of an exception says where in the Logo program it happened, at no cost while nothing happens.
"""

from __future__ import annotations

import ast
from typing import Any

Expr = ast.expr
Stmt = ast.stmt

LOAD, STORE = ast.Load(), ast.Store()
NONE = ast.Constant(None)


def at(number: int, piece: Any) -> Any:
    """A piece that belongs to this instruction."""
    piece.lineno = piece.end_lineno = number
    piece.col_offset = piece.end_col_offset = 0
    return piece


def name(text: str) -> Expr:
    """A variable's value."""
    return ast.Name(text, LOAD)


def const(value: str | float | None) -> Expr:
    """A constant; a number below zero is written as Python reads it."""
    return ast.Constant(value)


def assign(target: str, value: Expr) -> Stmt:
    """``target = value``."""
    return ast.Assign([ast.Name(target, STORE)], value)


def walrus(target: str, value: Expr) -> Expr:
    """``(target := value)``."""
    return ast.NamedExpr(ast.Name(target, STORE), value)


def call(function: str, *inputs: Expr) -> Expr:
    """``function(inputs)``."""
    return ast.Call(name(function), list(inputs), [])


def index(value: Expr, place: Expr) -> Expr:
    """``value[place]``."""
    return ast.Subscript(value, place, LOAD)


def minus(value: Expr) -> Expr:
    """``-value``; of a constant, the constant."""
    if isinstance(value, ast.Constant) and isinstance(value.value, int | float):
        return ast.Constant(-value.value)
    return ast.UnaryOp(ast.USub(), value)


def signed(value: Expr) -> Expr:
    """``+value``: a number itself; of anything else, Python refuses it. Of a constant, the constant."""
    if isinstance(value, ast.Constant) and isinstance(value.value, int | float):
        return value
    return ast.UnaryOp(ast.UAdd(), value)


def binary(left: Expr, operator: ast.operator, right: Expr) -> Expr:
    """``left operator right``."""
    return ast.BinOp(left, operator, right)


def compare(left: Expr, operator: ast.cmpop, right: Expr) -> Expr:
    """``left operator right``."""
    return ast.Compare(left, [operator], [right])


def either(condition: Expr, then: Expr, otherwise: Expr) -> Expr:
    """``then if condition else otherwise``."""
    return ast.IfExp(condition, then, otherwise)


def all_of(*conditions: Expr) -> Expr:
    """``a and b``."""
    return ast.BoolOp(ast.And(), list(conditions))


def any_of(*conditions: Expr) -> Expr:
    """``a or b``."""
    return ast.BoolOp(ast.Or(), list(conditions))


def negated(condition: Expr) -> Expr:
    """``not condition``."""
    if isinstance(condition, ast.UnaryOp) and isinstance(condition.op, ast.Not):
        return condition.operand
    return ast.UnaryOp(ast.Not(), condition)


def is_none(value: Expr) -> Expr:
    """``value is None``."""
    return compare(value, ast.Is(), NONE)


def is_some(value: Expr) -> Expr:
    """``value is not None``."""
    return compare(value, ast.IsNot(), NONE)


def has_type(value: Expr, kind: str) -> Expr:
    """``type(value) is kind``."""
    return compare(call("type", value), ast.Is(), name(kind))


def when(condition: Expr, then: list[Stmt], otherwise: list[Stmt] | None = None) -> Stmt:
    """``if condition: then``, and ``else``."""
    return ast.If(condition, then, otherwise if otherwise is not None else [])


def do(value: Expr) -> Stmt:
    """An expression as a statement."""
    return ast.Expr(value)


def give(value: Expr = NONE) -> Stmt:
    """``return value``."""
    return ast.Return(value)


def for_each(target: str, values: Expr, body: list[Stmt]) -> Stmt:
    """``for target in values: body``."""
    return ast.For(ast.Name(target, STORE), values, body, [])


def forever(body: list[Stmt]) -> Stmt:
    """``while True: body``."""
    return ast.While(ast.Constant(value=True), body, [])


def function(title: str, inputs: list[str], body: list[Stmt]) -> ast.FunctionDef:
    """``def title(inputs): body``."""
    arguments = ast.arguments([], [ast.arg(each) for each in inputs], None, [], [], None, [])
    made = ast.FunctionDef(title, arguments, body, [])
    made.type_params = []  # type: ignore[attr-defined,unused-ignore]  # wanted from Python 3.12 on
    return made


def module(tree: list[Stmt]) -> ast.Module:
    """Statements, as Python can compile them: every place has a line, and no block is empty."""
    pending: list[Any] = list(tree)
    for each in pending:
        if isinstance(each, ast.If | ast.For | ast.While | ast.Try | ast.FunctionDef):
            if not each.body:
                each.body.append(ast.Pass())
            pending += each.body
            if not isinstance(each, ast.FunctionDef):
                pending += each.orelse
            if isinstance(each, ast.Try):
                pending += each.finalbody
    return ast.fix_missing_locations(ast.Module(tree, []))
