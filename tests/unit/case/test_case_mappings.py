"""Cases made of mappings, given as mappings, and changed in Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import Case, dump_case, load_case
from crackgrow.errors import CaseError
from tests.unit.case.scenes import EVERYTHING, held, load, rectangle, with_body

PLATE = {**with_body(rectangle(0, 0, 4, 6)), "supports": held("rock"), "numerics": {"spacing": "auto"}}


def test_a_mapping_is_the_case_that_its_file_is(tmp_path: Path):
    assert dump_case(Case.from_dict(EVERYTHING)) == dump_case(load(tmp_path, EVERYTHING))


def test_a_mapping_that_a_reader_of_yaml_1_1_has_made_is_the_case_that_its_file_is(tmp_path: Path):
    """It takes the key `on` for true."""
    scene = {**PLATE, "loads": [{"on": {"edge": "top"}, "traction": [0, 1]}]}
    read = {**scene, "loads": [{True: {"edge": "top"}, "traction": [0, 1]}]}
    assert dump_case(Case.from_dict(read)) == dump_case(load(tmp_path, scene))


def test_a_case_comes_back_from_its_mapping():
    case = Case.from_dict(EVERYTHING, "everything")
    again = Case.from_dict(case.to_dict(), case.name)
    assert again.to_dict() == case.to_dict()
    assert again.name == "everything"


def test_the_mapping_is_the_callers_own():
    case = Case.from_dict(PLATE)
    case.to_dict()["bodies"]["rock"]["material"]["young"] = 1.0
    assert case.to_dict()["bodies"]["rock"]["material"]["young"] == PLATE["bodies"]["rock"]["material"]["young"]


def test_arrays_and_tuples_are_taken():
    points = np.array([[1.0, 1.0], [2.0, 2.5]])
    cracks = {"flaw": {"path": {"points": points}, "contact": {"friction": np.float64(0.25), "cohesion": 0}}}
    case = Case.from_dict({**PLATE, "cracks": cracks})
    np.testing.assert_array_equal(case.cracks[0].points, points)
    assert case.cracks[0].contact.friction == 0.25


def test_settings_are_those_of_the_command_line(tmp_path: Path):
    settings = ["bodies.rock.shape.rectangle.width=200 cm", "plane=stress"]
    case = load(tmp_path, PLATE)
    assert dump_case(case.with_(*settings)) == dump_case(load_case(tmp_path / "scene.yaml", settings))
    assert case.plane == "strain"
    assert case.with_("numerics.spacing=50 mm").numerics.spacing == 0.05


def test_faults_name_keys_and_no_lines():
    with pytest.raises(CaseError) as caught:
        Case.from_dict({**PLATE, "plane": "strian", "growht": {}})
    assert [(fault.key, fault.line) for fault in caught.value.faults] == [("plane", None), ("growht", None)]
    with pytest.raises(CaseError, match=r"numerics\.spacng: unknown key"):
        Case.from_dict(PLATE).with_("numerics.spacng=1")


def test_what_is_no_mapping_is_refused():
    with pytest.raises(TypeError, match="a mapping in the case format is wanted, not str"):
        Case.from_dict("title: x")
    with pytest.raises(TypeError, match=r"loads\.0: set given"):
        Case.from_dict({**PLATE, "loads": [{1, 2}]})
