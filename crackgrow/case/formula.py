"""Formulas in x and y, such as "0.09*x - 0.1": read by a whitelist, brought to SI, evaluated at points."""

from __future__ import annotations

import ast
import math
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Protocol

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.reader import Node, Scalar
from crackgrow.case.report import Path, clean, did_you_mean, quoted
from crackgrow.case.scalars import Context, Quantity, given
from crackgrow.case.units import UNITS, is_number, parse_number, place_text
from crackgrow.errors import CaseError

LONGEST = 1000  # characters of a formula
DEEPEST = 100  # levels of its tree

_QUANTITY = re.compile(r"[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?\s*[^\W\d_]+")  # a number and one word, perhaps a unit

_OPERATORS: Final[dict[type[ast.operator], Callable[..., Floats]]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
}
_SIGNS: Final[dict[type[ast.unaryop], Callable[..., Floats]]] = {ast.UAdd: np.positive, ast.USub: np.negative}
_FUNCTIONS: Final[dict[str, Callable[..., Floats]]] = {
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "abs": np.abs,
}
_EXTREMES: Final[dict[str, Callable[..., Floats]]] = {"min": np.minimum, "max": np.maximum}
_NAMES = ("x", "y", "pi")
ONE_VALUE = tuple(_FUNCTIONS)
"""Functions that take one value."""

ALPHABET = rf"[0-9.eE_+\-*/(),\s]|{'|'.join((*_NAMES, *_FUNCTIONS, *_EXTREMES))}"
"""Pattern of the letters, signs and words that a formula is made of."""

_ALLOWED = f"numbers, x, y, pi, + - * / **, parentheses, {', '.join((*_FUNCTIONS, *_EXTREMES))}"


class Formula(Protocol):
    """A component of a displacement or a load as a function of the place."""

    def __call__(self, points: Floats) -> Floats:
        """Values (n,) in SI at points (n, 2) m."""
        ...


Component = float | Formula


class FormulaError(ValueError):
    """A text that is no formula; the message says why."""


class MapFormula(str):
    """The text of a formula whose x and y are those of a map."""

    origin: tuple[float, float]  # m, of the case on the map


@dataclass(frozen=True, slots=True, eq=False)
class CoordinateFormula:
    """A value as a function of the place; made by `parse_formula` only, so that the text is known to be one."""

    text: str  # in SI
    origin: tuple[float, float] = (0.0, 0.0)  # m, x and y of the formula at the origin of the case

    @property
    def scaled(self) -> tuple[float, str]:
        """The number by which all of the formula is multiplied, such as the unit of its values, and the rest."""
        tree = _tree(self.text)
        if isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.Mult) and isinstance(tree.left, ast.Constant):
            return float(ast.literal_eval(tree.left)), ast.unparse(tree.right)
        return 1.0, self.text

    def __call__(self, points: Floats) -> Floats:
        """Values `(n,) float` in SI at points `(n, 2) float` m.

        Raises CaseError where the formula has no finite value.
        """
        values, nowhere = self.values(points)
        if nowhere is not None:
            message = f"has no finite value at {place_text(nowhere)}"
            raise CaseError.at(f"formula {quoted(self.text)}", message)
        return values

    def values(self, points: Floats) -> tuple[Floats, Floats | None]:
        """The same, finite or not, and the first place (2,) m, on the map, where the formula has no finite value."""
        places = np.asarray(points, dtype=float) + self.origin
        x, y = places.T
        with np.errstate(all="ignore"):
            values = np.array(np.broadcast_to(_evaluate(_tree(self.text), x, y), x.shape), dtype=float)
        finite = np.isfinite(values)
        return values, None if finite.all() else places[int(np.argmin(finite))]


def component_of(value: float | str) -> Component:
    """A component of a resolved case: a number, or the text of a formula."""
    return CoordinateFormula(str(value), getattr(value, "origin", (0.0, 0.0))) if isinstance(value, str) else value


def component_at(component: Component, places: Floats) -> Floats:
    """Values (n,) of a number or a formula at places (n, 2) m."""
    return component(places) if callable(component) else np.full(len(places), component)


def parse_formula(text: str, unit: float = 1.0, of_value: float | None = None) -> str:
    """Return the formula in SI: the same function, of x and y in m, with values in SI.

    unit: m, length of the unit in which x and y of `text` are
    of_value: the unit of its values in SI; that of x and y if None

    Raises FormulaError for what is none.
    """
    of_value = unit if of_value is None else of_value
    if len(text) > LONGEST:
        raise FormulaError(f"is longer than {LONGEST} characters")
    tree = _parse(text)
    if unit != 1.0:
        tree = _Rescaled(ast.Constant(unit)).visit(tree)
    if of_value != 1.0:
        tree = ast.BinOp(ast.Constant(of_value), ast.Mult(), tree)
    _check(tree)
    in_si = ast.unparse(tree)
    if len(in_si) > LONGEST:
        raise FormulaError(f"is longer than {LONGEST} characters in SI")
    return in_si


@dataclass(frozen=True, slots=True)
class OrFormula:
    """A quantity, or a formula in x and y; x, y and the value are in the units of the case."""

    kind: str = "length"

    def describe(self) -> str:
        return f'a {self.kind} or a formula in x and y such as "0.09*x - 0.1"'

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the float in SI, or the text of the formula in SI."""
        if not isinstance(node, Scalar) or node.is_null:
            return Quantity(self.kind, note=" or a formula in x and y").read(node, path, context)
        text = node.text.strip()
        if is_number(text) or _QUANTITY.fullmatch(text):
            return Quantity(self.kind, note=" or a formula in x and y").read(node, path, context)
        try:
            units = (float(UNITS[kind][context.units.of(kind)]) for kind in ("length", self.kind))
            formula = parse_formula(text, *units)
        except FormulaError as error:
            return context.refused(path, f"{given(node)} {error}; wanted: {self.describe()}")
        if is_number(formula):
            return parse_number(formula)
        if context.units.origin is not None:
            formula = MapFormula(formula)
            formula.origin = context.units.origin
        return formula


@lru_cache(maxsize=64)
def _tree(text: str) -> ast.expr:
    return _parse(text)


def _parse(text: str) -> ast.expr:
    """Return the checked tree of a formula."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the reader, about what is refused below anyway
            tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else "unreadable"
        raise FormulaError(f"is not a formula: {clean(reason)}") from None
    _check(tree)
    return tree


def _check(tree: ast.expr) -> None:
    """Hold every node to the whitelist, and the tree to its depth."""
    level: list[ast.expr] = [tree]
    for _ in range(DEEPEST):
        level = [child for node in level for child in _parts(node)]
        if not level:
            return
    raise FormulaError(f"is nested deeper than {DEEPEST} levels")


def _parts(node: ast.expr) -> list[ast.expr]:
    """Return what an allowed node is made of."""
    match node:
        case ast.BinOp(left, operator, right) if type(operator) in _OPERATORS:
            return [left, right]
        case ast.BinOp(_, ast.BitXor(), _):
            raise FormulaError("has ^, which is no power here: write **")
        case ast.UnaryOp(sign, operand) if type(sign) in _SIGNS:
            return [operand]
        case ast.Constant(int() | float() as value) if not isinstance(value, bool):
            try:
                finite = math.isfinite(float(value))
            except OverflowError:
                finite = False
            if not finite:
                raise FormulaError("has a number that is too large")
            return []
        case ast.Name(name) if name in _NAMES:
            return []
        case ast.Name(name):
            known = (*_NAMES, *_FUNCTIONS, *_EXTREMES)
            message = f"has the unknown name {quoted(name)}; allowed: {_ALLOWED}{did_you_mean(name, known)}"
            raise FormulaError(message)
        case ast.Call(ast.Name(name), arguments, []):
            return _arguments(name, arguments)
    raise FormulaError(f"has {quoted(ast.unparse(node))}, which is not allowed; allowed: {_ALLOWED}")


def _arguments(name: str, arguments: list[ast.expr]) -> list[ast.expr]:
    if name not in _FUNCTIONS and name not in _EXTREMES:
        hint = did_you_mean(name, (*_FUNCTIONS, *_EXTREMES))
        raise FormulaError(f"has the unknown function {quoted(name)}; allowed: {_ALLOWED}{hint}")
    if name in _FUNCTIONS and len(arguments) != 1:
        raise FormulaError(f"gives {name} {len(arguments)} values; it takes one")
    if name in _EXTREMES and len(arguments) < 2:
        raise FormulaError(f"gives {name} {len(arguments)} values; it takes two or more")
    return arguments


class _Rescaled(ast.NodeTransformer):
    """Writes x and y in m into a tree in another unit."""

    def __init__(self, unit: ast.Constant) -> None:
        self.unit = unit

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return ast.BinOp(node, ast.Div(), self.unit) if node.id in ("x", "y") else node


def _evaluate(node: ast.expr, x: Floats, y: Floats) -> Floats:
    match node:
        case ast.BinOp(left, operator, right):
            return _OPERATORS[type(operator)](_evaluate(left, x, y), _evaluate(right, x, y))
        case ast.UnaryOp(sign, operand):
            return _SIGNS[type(sign)](_evaluate(operand, x, y))
        case ast.Call(ast.Name(name), arguments):
            values = [_evaluate(argument, x, y) for argument in arguments]
            if name in _FUNCTIONS:
                return _FUNCTIONS[name](*values)
            extreme = values[0]
            for value in values[1:]:
                extreme = _EXTREMES[name](extreme, value)
            return extreme
        case ast.Name(name):
            return {"x": x, "y": y}.get(name, np.array(np.pi))
        case ast.Constant(int() | float() as value):
            return np.array(float(value))
    raise TypeError("the tree was not checked")
