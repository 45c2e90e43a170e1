"""Numbers, units and formulas: what is read, in SI, to the last bit, and what is refused."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case.formula import DEEPEST, LONGEST, CoordinateFormula, FormulaError, parse_formula
from crackgrow.case.units import QuantityError, Units, parse_number, parse_quantity
from crackgrow.errors import CaseError
from tests.unit.case.scenes import fault, load, rectangle, with_body

MM = Units("mm", "MPa")


@pytest.mark.parametrize(
    ("text", "value"),
    [("10", 10.0), ("1e10", 1e10), ("1.e10", 1e10), (".5", 0.5), ("-3.25E-2", -0.0325), ("+7", 7.0), ("010", 10.0)],
)
def test_numbers(text: str, value: float):
    assert parse_number(text) == value
    assert repr(parse_number("-0.0")) == "0.0"


@pytest.mark.parametrize(
    "text", ["", "x", "1_000", "0x10", "1:30", "1e", "--1", "1,5", "٣", "1 2", "nan", "-.inf", "1e61"]
)
def test_not_a_number(text: str):
    with pytest.raises(QuantityError):
        parse_number(text)


@pytest.mark.parametrize(("text", "kind", "value"), [
    ("31", "length", 0.031),
    ("31 mm", "length", 0.031),
    ("31mm", "length", 0.031),
    (" 3.1 cm ", "length", 0.031),
    ("0.1 um", "length", 1e-7),
    ("0", "force", 0.0),  # in every unit
    ("-2 kN/mm", "force", -2e6),
    ("10 GPa", "stress", 1e10),
    ("1e1GPa", "stress", 1e10),
    ("0.7", "stress", 700000.0),
    ("2500", "density", 2500.0),
    ("2.7 g/cm^3", "density", 2700.0),
    ("30 deg", "angle", 30.0),
    ("1 mm/year", "velocity", 1e-3 / (365.25 * 86400.0)),
    ("40 kPa sqrt(m)", "toughness", 4e4),
    ("1 MPa sqrt(mm)", "toughness", 1e9**0.5),
])  # fmt: skip
def test_quantities_are_the_nearest_floats(text: str, kind: str, value: float):
    assert parse_quantity(text, kind, MM) == value


# --- formulas --------------------------------------------------------------------------------------------------------

POINTS = np.array([[0.5, -2.0], [3.0, 0.25], [-1.0, 4.0]])
X, Y = POINTS.T


@pytest.mark.parametrize(("text", "values"), [
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
])  # fmt: skip
def test_values_and_the_same_function_in_si(text: str, values: np.ndarray):
    formula = CoordinateFormula(parse_formula(text))
    np.testing.assert_allclose(formula(POINTS), values, rtol=1e-15)  # the same operations
    assert formula(POINTS[:0]).shape == (0,)
    assert pickle.loads(pickle.dumps(formula))(POINTS).tolist() == formula(POINTS).tolist()
    for unit in (1e-3, 1e3):
        formula = CoordinateFormula(parse_formula(text, unit))
        np.testing.assert_allclose(formula(POINTS * unit), values * unit, rtol=1e-13)  # (x / L) rounds before tan, exp
        assert parse_formula(formula.text) == formula.text


@pytest.mark.parametrize(("text", "words"), [
    ("x\0", "is not a formula"),
    ("1" + "0" * 400 + "*x", "too large"),
    ("x" + " + x" * DEEPEST, "nested deeper than"),
    ("(" * 400 + "x" + ")" * 400, "is not a formula"),
    ("-" * (LONGEST - 1) + "x", "nested deeper than"),
    ("x + " + " " * LONGEST + "y", "longer than"),
    ("x" + "+x*x*x*x*x*x*x*x*x*x" * 45, "longer than 1000 characters in SI"),
    *((text, "not allowed") for text in (
        "x if x > 0 else y", "x > y", "x // y", "x % y", "not x", "~x", "x and y", "x, y", "[x]", "1if x else 2",
        "x[0]", "x.real", "lambda: x", "(x := 1)", "'x'", "True", "1j*x", "sin(x=1)", "min(*x, 1)",
        "__import__('os').system('exit 3')",
    )),
])  # fmt: skip
def test_what_is_no_formula(text: str, words: str):
    with pytest.raises(FormulaError) as caught:
        parse_formula(text, 1e-3)
    assert words in str(caught.value)


@pytest.mark.parametrize("text", ["1/x", "log(x)", "x**0.5/x", "exp(1000 + x)", "10**10**10*x", "0*(1/x)"])
def test_no_finite_value(text: str):
    with pytest.raises(CaseError, match="has no finite value at"):
        CoordinateFormula(parse_formula(text))(np.array([[1.0, 1.0], [0.0, 0.0], [-1.0, 0.0], [1e308, 0.0]]))


def test_formulas_of_a_map_need_values_in_the_rock_alone(tmp_path: Path):
    """x and y are those of the map: log(x - 399.99) has values right of x = 399.99 m."""
    scene = {**with_body(rectangle(400, 800, 10, 10)), "units": {"length": "m", "origin": [400, 800]}}
    for x, told in ((399.99, ""), (405, "has no finite value at (400 m, 800 m)")):
        held = {"x": 0, "y": f"1e-6*log(x - {x})"}
        scene["supports"] = [{"on": {"body": "rock", "edge": "bottom"}, "displacement": held}]
        if told:
            assert fault(tmp_path, scene)[1] == told
        else:
            assert load(tmp_path, scene).supports[0].displacement[1](np.zeros((1, 2))) == [1e-6 * np.log(400 - x)]


def test_a_bare_toughness_by_pounds_needs_a_unit():
    with pytest.raises(QuantityError, match=r"needs a unit, such as ksi sqrt\(in\)"):
        parse_quantity("1", "toughness", Units("m", "ksi"))
