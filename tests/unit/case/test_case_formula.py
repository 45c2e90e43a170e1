"""Formulas: what they may hold, their values, and the same function in SI."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from crackgrow.case.formula import DEEPEST, LONGEST, CoordinateFormula, FormulaError, parse_formula
from crackgrow.errors import CaseError
from tests.scenes import shipped_case

CASE = "compression30"
POINTS = np.array([[0.5, -2.0], [3.0, 0.25], [-1.0, 4.0]])
X, Y = POINTS.T

FORMULAS = [
    ("0.09*x - 0.1", 0.09 * X - 0.1),
    ("x*y/2 + x**2", X * Y / 2 + X**2),
    ("-x - -y", -X + Y),
    ("2**-1*x", X / 2),
    ("(x + y)*(x - y)", (X + Y) * (X - Y)),
    ("sin(pi*x) + cos(y) + tan(x)", np.sin(np.pi * X) + np.cos(Y) + np.tan(X)),
    ("sqrt(abs(x)) + exp(-y) + log(y**2)", np.sqrt(np.abs(X)) + np.exp(-Y) + np.log(Y**2)),
    ("min(x, y) + max(x, y, 1)", np.minimum(X, Y) + np.maximum(np.maximum(X, Y), 1)),
    (" pi ", np.full(3, np.pi)),
    ("10**10**2", np.full(3, 1e100)),
]


@pytest.mark.parametrize(("text", "values"), FORMULAS)
def test_values(text: str, values: np.ndarray):
    formula = CoordinateFormula(parse_formula(text))
    np.testing.assert_allclose(formula(POINTS), values, rtol=1e-15)  # the same operations
    assert formula(POINTS).shape == (3,)
    assert formula(POINTS[:0]).shape == (0,)


@pytest.mark.parametrize(("text", "values"), FORMULAS)
@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_the_same_function_in_si(text: str, values: np.ndarray, unit: float):
    formula = CoordinateFormula(parse_formula(text, unit))
    np.testing.assert_allclose(formula(POINTS * unit), values * unit, rtol=1e-13)  # (x / L) rounds before tan and exp
    assert parse_formula(formula.text) == formula.text


def test_text_in_si():
    assert parse_formula("0.09*x-0.1") == "0.09 * x - 0.1"
    assert parse_formula("0.09*x - 0.1", 0.001) == "0.001 * (0.09 * (x / 0.001) - 0.1)"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x^2", "has ^, which is no power here: write **"),
        ("2x", "is not a formula"),
        ("x +", "is not a formula"),
        ("", "is not a formula"),
        ("x\0", "is not a formula"),
        ("z + 1", "unknown name 'z'"),
        ("sine(x)", "unknown function 'sine'"),
        ("sine(x)", "did you mean 'sin'?"),
        ("sin(x, y)", "gives sin 2 values; it takes one"),
        ("sin()", "gives sin 0 values"),
        ("max(x)", "gives max 1 values; it takes two or more"),
        ("sin(x=1)", "'sin(x=1)', which is not allowed; allowed: numbers, x, y, pi"),
        ("min(*x, 1)", "'*x', which is not allowed"),
        ("sin + x", "unknown name 'sin'"),
        ("x if x > 0 else y", "not allowed"),
        ("x > y", "not allowed"),
        ("x // y", "not allowed"),
        ("x % y", "not allowed"),
        ("not x", "not allowed"),
        ("~x", "not allowed"),
        ("x and y", "not allowed"),
        ("x, y", "not allowed"),
        ("[x]", "not allowed"),
        ("1if x else 2", "not allowed"),
        ("x[0]", "not allowed"),
        ("x.real", "not allowed"),
        ("lambda: x", "not allowed"),
        ("(x := 1)", "not allowed"),
        ("__import__('os').system('exit 3')", "not allowed"),
        ("open('a')", "unknown function 'open'"),
        ("'x'", "not allowed"),
        ("True", "not allowed"),
        ("1j*x", "not allowed"),
        ("1e999*x", "too large"),
        ("1" + "0" * 400 + "*x", "too large"),
        ("x" + " + x" * DEEPEST, "nested deeper than"),
        ("(" * 400 + "x" + ")" * 400, "is not a formula"),
        ("-" * (LONGEST - 1) + "x", "nested deeper than"),
        ("x + " + " " * LONGEST + "y", "longer than"),
        ("x" + "+x*x*x*x*x*x*x*x*x*x" * 45, "longer than 1000 characters in SI"),
    ],
)
def test_what_is_no_formula(text: str, words: str):
    with pytest.raises(FormulaError) as caught:
        parse_formula(text, 1e-3)
    assert words in str(caught.value)


@pytest.mark.parametrize("text", ["1/x", "log(x)", "x**0.5/x", "exp(1000 + x)", "10**10**10*x", "0*(1/x)"])
def test_no_finite_value(text: str):
    with pytest.raises(CaseError, match="has no finite value at"):
        CoordinateFormula(parse_formula(text))(np.array([[1.0, 1.0], [0.0, 0.0], [-1.0, 0.0], [1e308, 0.0]]))


def test_a_formula_survives_pickling():
    formula = CoordinateFormula("x + 1")
    assert pickle.loads(pickle.dumps(formula))(POINTS).tolist() == (X + 1).tolist()


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ("0.1*y", "0.001 * (0.1 * (y / 0.001))"),
        ("'0.1 * y'", "0.001 * (0.1 * (y / 0.001))"),
        ("y", "0.001 * (y / 0.001)"),
        ("1e-3*x", "0.001 * (0.001 * (x / 0.001))"),
    ],
)
def test_formula_in_a_case(given: str, text: str):
    case = shipped_case(CASE, [f"supports.2.displacement.x={given}"])
    x, y = case.supports[2].displacement
    assert (x.text, y) == (text, None)
    assert case.resolved["supports"][2]["displacement"] == {"x": text}  # type: ignore[index]


@pytest.mark.parametrize(("given", "value"), [("0.5", 5e-4), ("-0.5 um", -5e-7), ("1e-1mm", 1e-4), ('"1 mm"', 1e-3)])
def test_plain_components_stay_numbers(given: str, value: float):
    assert shipped_case(CASE, [f"supports.2.displacement.x={given}"]).supports[2].displacement == (value, None)


@pytest.mark.parametrize(("given", "value"), [("(5)", 5.0), ("-(5)", -5.0)])
def test_a_number_in_parentheses_is_a_number(given: str, value: float):
    overrides = ["units.length=m", "numerics.spacing=1.5", f"supports.2.displacement.x={given}"]
    assert shipped_case(CASE, overrides).supports[2].displacement == (value, None)
