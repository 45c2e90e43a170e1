"""The JSON Schema, other names of keys, and what is read of numbers, units and formulas, in SI, to the last bit."""

from __future__ import annotations

import json
import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from jsonschema import Draft7Validator

from crackgrow.case.format import CASE, FORMAT
from crackgrow.case.formula import DEEPEST, LONGEST, CoordinateFormula, FormulaError, parse_formula
from crackgrow.case.json_schema import case_schema, schema_of
from crackgrow.case.keys import case_keys
from crackgrow.case.reader import parse
from crackgrow.case.report import Place, Report, words_elsewhere
from crackgrow.case.scalars import Context, Spec
from crackgrow.case.units import QuantityError, Units, parse_number, parse_quantity
from crackgrow.errors import CaseError
from tests.unit.case.scenes import CASES, fault, held, load, read_yaml12, rectangle, with_body

SCHEMA = json.loads(case_schema())
HERE = Path(__file__).parent
AGREED, VALUES = (yaml.safe_load((HERE / name).read_text(encoding="utf-8")) for name in ("schema.yaml", "values.yaml"))


def schema_accepts(spec: Spec, text: str) -> bool:
    return bool(Draft7Validator(schema_of(spec)).is_valid(read_yaml12(text)))


def reader_accepts(spec: Spec, text: str) -> bool:
    report = Report("scene.yaml")
    node = parse(text, report, Place("scene.yaml", 1))
    if node is None:  # no value at all
        return False
    spec.read(node, (), Context(report, Units("mm", "MPa")))
    return not report.faults


def test_the_schema_is_one_and_the_one_beside_the_cases_is_up_to_date():
    """If not: crackgrow schema --out cases/case.schema.json."""
    Draft7Validator.check_schema(SCHEMA)
    assert (CASES / "case.schema.json").read_text(encoding="utf-8") == case_schema()


@pytest.mark.parametrize("file", sorted(CASES.glob("*.yaml")), ids=lambda file: file.stem)
def test_shipped_cases_are_accepted_and_name_it(file: Path):
    text = file.read_text(encoding="utf-8")
    assert [error.message for error in Draft7Validator(SCHEMA).iter_errors(read_yaml12(text))] == []
    assert "# yaml-language-server: $schema=case.schema.json\n" in text


@pytest.mark.parametrize("group", AGREED, ids=lambda group: next(iter(group.values())))
def test_schema_and_reader_agree(group: dict[str, Any]):
    """On all texts of schema.yaml."""
    forms = {"spec": FORMAT.spec, "part": FORMAT.part, "key": lambda name: CASE.fields[name].spec}
    kind, name = next(iter(group.items()))
    spec = forms[kind](name)
    for judge in (reader_accepts, schema_accepts):
        assert [text for text in group["good"] if not judge(spec, text)] == []
        assert [text for text in group["bad"] if judge(spec, text)] == []


def inside(schema: Any) -> Iterator[dict[str, Any]]:
    """All mappings of a schema, outer ones first."""
    if isinstance(schema, dict):
        yield schema
    for value in schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ():
        yield from inside(value)


def test_editors_show_what_keys_mean_their_defaults_and_words():
    """Beside a reference there is nothing that draft 7 passes over but what editors show."""
    assert {key for schema in inside(SCHEMA) if "$ref" in schema for key in schema} == {
        "$ref",
        "description",
        "default",
    }
    named = {name: its for schema in inside(SCHEMA) for name, its in schema.get("properties", {}).items()}
    untold = [name for name, its in named.items() if "description" not in its]
    assert (len(named) > 60, untold) == (True, [])
    assert named["support"]["default"] == 2.0
    assert len(named["criterion"]["enum"]) == len(named["criterion"]["enumDescriptions"]) == 3


# --- other names of keys ---------------------------------------------------------------------------------------------


def test_every_meaning_is_a_key_or_word_of_the_format():
    keys = {part for key in case_keys() for part in key.name.split(".")}
    meant = words_elsewhere()["meant"]
    assert {word for several in meant.values() for word in several} - keys - {"none", "bonded"} == set()
    assert [name for name in meant if name != name.lower()] == []


FLAW = {"path": {"center": [2, 2], "length": 2, "angle": 30}, "contact": {"friction": 0.3, "cohesion": 0}}


@pytest.mark.parametrize(("wrong", "words"), [
    ({"in_situ": {"stress": [-12, -8, 0]}}, "stress from the start is a load"),
    ({"stress": [-12, -8, 0]}, "stress from the start is a load"),  # and not `units.stress`
    ({"gravity": [0, -9.81]}, "weight is a load"),
    ({"cracks": {"flaw": {**FLAW, "pressure": 1}}}, "fluid pressure in a crack is a load"),
])  # fmt: skip
def test_what_is_a_load_here_is_said_with_an_example_that_loads(tmp_path: Path, wrong: dict[str, Any], words: str):
    scene = {**with_body(rectangle(0, 0, 4, 4)), "cracks": {"flaw": FLAW}, "supports": held("rock")}
    _, message = fault(tmp_path, {**scene, **wrong})
    assert words in message
    example = yaml.safe_load(message.split("`")[-2].replace("NAME", "flaw"))
    scene["bodies"]["rock"]["material"]["density"] = "2600 kg/m^3"
    assert load(tmp_path, {**scene, **example}).loads


MM = Units("mm", "MPa")


@pytest.mark.parametrize(("text", "value"), VALUES["numbers"])
def test_numbers(text: str, value: float):
    assert parse_number(text) == value
    assert repr(parse_number("-0.0")) == "0.0"


@pytest.mark.parametrize("text", VALUES["no numbers"])
def test_not_a_number(text: str):
    with pytest.raises(QuantityError):
        parse_number(text)


@pytest.mark.parametrize(("text", "kind", "value"), VALUES["quantities"])
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
    *((text, "not allowed") for text in VALUES["no formulas"]),
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
