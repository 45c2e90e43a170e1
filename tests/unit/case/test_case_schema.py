"""What tells people of the format: the JSON Schema, other names of keys, and what is meant."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from jsonschema import Draft7Validator

from crackgrow.case.format import CASE, FORMAT
from crackgrow.case.json_schema import case_schema, schema_of
from crackgrow.case.keys import case_keys
from crackgrow.case.reader import parse
from crackgrow.case.report import Place, Report, words_elsewhere
from crackgrow.case.scalars import Context, Spec
from crackgrow.case.units import Units
from tests.unit.case.scenes import CASES, fault, held, load, rectangle, with_body
from tests.yaml12 import read_yaml12

SCHEMA = json.loads(case_schema())
AGREED = yaml.safe_load(Path(__file__).with_name("schema.yaml").read_text(encoding="utf-8"))


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
    """Beside a reference there is nothing that draft 7 passes over."""
    assert [schema for schema in inside(SCHEMA) if "$ref" in schema and len(schema) > 1] == []
    named = {name: its for schema in inside(SCHEMA) for name, its in schema.get("properties", {}).items()}
    untold = [name for name, its in named.items() if not ({"$ref", "description"} & set(its))]
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
