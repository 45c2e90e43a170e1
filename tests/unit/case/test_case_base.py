"""A case that is another one changed: `base` and `set`."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest

from crackgrow.case import Case, dump_case, load_case
from crackgrow.case.json_schema import case_schema
from crackgrow.errors import CaseError, Fault
from tests.unit.case.scenes import MATERIAL, held, rectangle, text_of, with_body

SCENE = {**with_body(rectangle(0, 0, 4, 6)), "supports": held("rock"), "loads": [{"stress": [-1, -2, 0]}]}


def write(folder: Path, **files: str) -> None:
    for name, text in files.items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")


def case_of(folder: Path, text: str, *overrides: str, name: str = "changed") -> Case:
    """The case of a text beside the plate in base.yaml."""
    write(folder, base=text_of(SCENE), **{name: text})
    return load_case(folder / f"{name}.yaml", overrides)


def faults(folder: Path, text: str, *overrides: str) -> tuple[Fault, ...]:
    with pytest.raises(CaseError) as caught:
        case_of(folder, text, *overrides)
    return caught.value.faults


def test_a_base_with_settings_is_the_case_with_these_overrides(tmp_path: Path):
    case = case_of(
        tmp_path, "base: base.yaml\ntitle: other\nset: {numerics.spacing: 50 cm, 'loads.0.stress': [0, 1, 2]}"
    )
    wanted = load_case(tmp_path / "base.yaml", ["title=other", "numerics.spacing=50 cm", "loads.0.stress=[0, 1, 2]"])
    assert dump_case(case) == dump_case(wanted)
    assert case.name == "changed"
    assert "base" not in dump_case(case)


def test_a_base_may_have_a_base_and_overrides_come_last(tmp_path: Path):
    write(tmp_path, middle="base: base.yaml\nset: {numerics.spacing: 0.4, numerics.support: 1.5}\ntitle: middle")
    case = case_of(tmp_path, "base: middle.yaml\nset: {numerics.spacing: 0.3}")
    assert (case.title, case.numerics.spacing, case.numerics.support) == ("middle", 0.3, 1.5)
    assert load_case(tmp_path / "changed.yaml", ["numerics.spacing=0.2"]).numerics.spacing == 0.2


def test_files_are_relative_to_the_file_that_names_them(tmp_path: Path):
    for folder in ("plates", "mine"):
        (tmp_path / folder).mkdir()
    square = {"type": "Polygon", "coordinates": [[[0, 0], [2, 0], [2, 2], [0, 2], [0, 0]]]}
    (tmp_path / "plates" / "square.geojson").write_text(json.dumps(square))
    scene = with_body({"file": "square.geojson"}, material=MATERIAL)
    scene["supports"] = [{"on": {"edge": "0"}, "displacement": [0, 0]}]
    write(tmp_path / "plates", base=text_of(scene))
    write(tmp_path / "mine", own="base: ../plates/base.yaml\nset: {plane: stress}")
    case = load_case(tmp_path / "mine" / "own.yaml")
    assert (case.plane, len(case.bodies[0].outline)) == ("stress", 4)


def test_faults_of_a_base_are_told_with_its_name(tmp_path: Path):
    write(tmp_path, middle="base: base.yaml\nset: {plane: strian}")
    (only,) = faults(tmp_path, "base: middle.yaml")
    assert (Path(only.source).name, only.line, only.key) == ("middle.yaml", 2, "plane")


def test_the_schema_takes_a_case_with_a_base_and_no_half_case():
    schema = jsonschema.Draft7Validator(json.loads(case_schema()))
    assert schema.is_valid({"base": "a.yaml", "title": "b", "set": {"growth.steps": 3, "loads.0.traction": [0, 1]}})
    assert not schema.is_valid({"base": "a.yaml", "plane": "strain"})
    assert not schema.is_valid({"title": "b", "plane": "strain"})


def test_a_circle_of_bases_is_told(tmp_path: Path):
    write(tmp_path, one="base: two.yaml", two="base: changed.yaml")
    (only,) = faults(tmp_path, "base: one.yaml")
    assert "changed.yaml -> one.yaml -> two.yaml -> changed.yaml" in only.message


def test_a_base_takes_no_override(tmp_path: Path):
    (only,) = faults(tmp_path, "base: base.yaml", "base=other.yaml")
    assert only.key == "base"
    assert "takes no override" in only.message
