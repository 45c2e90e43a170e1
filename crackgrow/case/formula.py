"""Formulas in x and y, such as "0.09*x - 0.1": read by a whitelist, brought to SI, evaluated at points."""

from __future__ import annotations

import ast
import re
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, reduce
from typing import Final

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.report import clean, did_you_mean, quoted
from crackgrow.case.scalars import Context, Measured, Numeric
from crackgrow.case.units import UNITS, QuantityError, is_number, parse_number, place_text
from crackgrow.errors import CaseError

LONGEST = 1000  # characters of a formula
DEEPEST = 100  # levels of its tree

_QUANTITY = re.compile(r"[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?\s*[^\W\d_]+")  # a number and one word, perhaps a unit

_OPERATORS: Final[dict[type[ast.operator | ast.unaryop], Callable[..., Floats]]] = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide, ast.Pow: np.power,
    ast.UAdd: np.positive, ast.USub: np.negative,
}  # fmt: skip
ONE_VALUE: Final = ("sin", "cos", "tan", "sqrt", "exp", "log", "abs")  # functions of one value
_EXTREMES: Final[dict[str, Callable[..., Floats]]] = {"min": np.minimum, "max": np.maximum}
_FUNCTIONS: Final = (*ONE_VALUE, *_EXTREMES)
_NAMES: Final = ("x", "y", "pi")

ALPHABET = rf"[0-9.eE_+\-*/(),\s]|{'|'.join((*_NAMES, *_FUNCTIONS))}"
"""Pattern of the letters, signs and words that a formula is made of."""

_ALLOWED = f"numbers, x, y, pi, + - * / **, parentheses, {', '.join(_FUNCTIONS)}"

_Function = Callable[[Floats, Floats], Floats]  # of x and y


Formula = Callable[[Floats], Floats]  # values (n,) in SI at points (n, 2) m
Component = float | Formula


class FormulaError(QuantityError):
    """A text that is no formula; the message says why."""


@dataclass(frozen=True, slots=True, eq=False)
class CoordinateFormula:
    """A value as a function of the place; made by `parse_formula` only, so that the text is known to be one."""

    text: str  # in SI
    origin: tuple[float, float] = (0.0, 0.0)  # m, x and y of the formula at the origin of the case

    @property
    def scaled(self) -> tuple[float, str]:
        """The number by which all of the formula is multiplied, such as the unit of its values, and the rest."""
        tree = ast.parse(self.text, mode="eval").body
        if isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.Mult) and isinstance(tree.left, ast.Constant):
            return float(ast.literal_eval(tree.left)), ast.unparse(tree.right)
        return 1.0, self.text

    def __call__(self, points: Floats) -> Floats:
        """Values `(n,) float` in SI at points `(n, 2) float` m.

        Raises CaseError where the formula has no finite value.
        """
        values, nowhere = self.values(points)
        if nowhere is not None:
            message = f"has no finite value at {place_text(nowhere + self.origin)}"
            raise CaseError.at(f"formula {quoted(self.text)}", message)
        return values

    def values(self, points: Floats) -> tuple[Floats, Floats | None]:
        """The same, finite or not, and the first of the points, (2,) m, at which the formula has no finite value."""
        x, y = (np.asarray(points, dtype=float) + self.origin).T
        with np.errstate(all="ignore"):
            values = np.array(np.broadcast_to(_function_of(self.text)(x, y), x.shape), dtype=float)
        finite = np.isfinite(values)
        return values, None if finite.all() else points[int(np.argmin(finite))]


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
    in_si = _checked(text)
    if unit != 1.0:
        in_si = re.sub(r"\b[xy]\b", rf"(\g<0> / {unit!r})", in_si)
    if of_value != 1.0:
        in_si = f"{of_value!r} * ({in_si})"
    in_si = _checked(in_si)
    if len(in_si) > LONGEST:
        raise FormulaError(f"is longer than {LONGEST} characters in SI")
    return in_si


@dataclass(frozen=True, slots=True)
class OrFormula(Numeric):
    """A quantity, or a formula in x and y; x, y and the value are in the units of the case."""

    kind: str

    def describe(self) -> str:
        return f'a {self.kind} or a formula in x and y such as "0.09*x - 0.1"'

    def hint(self, context: Context) -> str:
        return Measured(self.kind).hint(context)

    def parse(self, text: str, context: Context) -> Component:
        """The float or the formula, in SI; raises QuantityError, of which FormulaError is one."""
        if is_number(text) or _QUANTITY.fullmatch(text):
            return Measured(self.kind).parse(text, context)
        formula = parse_formula(text, *(float(UNITS[kind][context.units.of(kind)]) for kind in ("length", self.kind)))
        if is_number(formula):
            return parse_number(formula)
        return CoordinateFormula(formula, context.units.origin or (0.0, 0.0))


def _checked(text: str) -> str:
    """The text of a formula with no more parentheses and spaces than it needs; raises FormulaError."""
    tree = _tree(text)
    _function(tree)
    return ast.unparse(tree)


@lru_cache(maxsize=64)
def _function_of(text: str) -> _Function:
    return _function(_tree(text))


def _tree(text: str) -> ast.expr:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the reader, about what is refused below anyway
            return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else "unreadable"
        raise FormulaError(f"is not a formula: {clean(reason)}") from None


def _function(node: ast.expr, level: int = 1) -> _Function:
    """The function that a node on a level of the tree stands for; raises FormulaError where it is not allowed."""
    if level > DEEPEST:
        raise FormulaError(f"is nested deeper than {DEEPEST} levels")
    match node:
        case ast.Constant(int() | float() as value) if not isinstance(value, bool):
            if abs(value) > sys.float_info.max:
                raise FormulaError("has a number that is too large")
            number = np.array(float(value))
            return lambda x, y: number
        case ast.Name("x" | "y" | "pi" as name):
            return lambda x, y: {"x": x, "y": y, "pi": np.array(np.pi)}[name]
        case ast.Name(name):
            hint = did_you_mean(name, (*_NAMES, *_FUNCTIONS))
            raise FormulaError(f"has the unknown name {quoted(name)}; allowed: {_ALLOWED}{hint}")
        case ast.BinOp(_, ast.BitXor(), _):
            raise FormulaError("has ^, which is no power here: write **")
        case ast.BinOp(left, operator, right) if type(operator) in _OPERATORS:
            combine, arguments = _OPERATORS[type(operator)], [left, right]
        case ast.UnaryOp(sign, operand) if type(sign) in _OPERATORS:
            combine, arguments = _OPERATORS[type(sign)], [operand]
        case ast.Call(ast.Name(name), arguments, []):
            combine = _named(name, len(arguments))
        case _:
            raise FormulaError(f"has {quoted(ast.unparse(node))}, which is not allowed; allowed: {_ALLOWED}")
    parts = [_function(argument, level + 1) for argument in arguments]
    return lambda x, y: combine(*(part(x, y) for part in parts))


def _named(name: str, n_values: int) -> Callable[..., Floats]:
    """The function of a name, of so many values."""
    if name in ONE_VALUE and n_values == 1:
        function: Callable[..., Floats] = getattr(np, name)
        return function
    if name in _EXTREMES and n_values > 1:
        return lambda *values: reduce(_EXTREMES[name], values)
    if name in _FUNCTIONS:
        wanted = "one" if name in ONE_VALUE else "two or more"
        raise FormulaError(f"gives {name} {n_values} values; it takes {wanted}")
    hint = did_you_mean(name, _FUNCTIONS)
    raise FormulaError(f"has the unknown function {quoted(name)}; allowed: {_ALLOWED}{hint}")
