"""Materials and laws of contact that are written once and referred to by name."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

from crackgrow.case import dump_case
from tests.unit.case.scenes import EVERYTHING, MATERIAL, fault, faults, held, load, rectangle, with_body

ROUGH = {"friction": 0.5, "cohesion": 1, "residual_friction": 0.4}


def named() -> dict[str, Any]:
    """The scene with every form, its materials and laws under names."""
    scene = copy.deepcopy(EVERYTHING)
    scene["materials"] = {"rock": MATERIAL, "heavy": {**MATERIAL, "density": "2500 kg/m^3"}}
    scene["laws"] = {"rough": ROUGH}
    for name, body in scene["bodies"].items():
        body["material"] = "heavy" if name == "block" else "rock"
    scene["cracks"]["flaw"]["contact"] = "rough"
    scene["interfaces"][0]["contact"] = "rough"
    scene["supports"][0]["contact"] = "rough"
    return scene


def test_names_mean_what_they_name(tmp_path: Path):
    written = copy.deepcopy(EVERYTHING)
    for part in (written["cracks"]["flaw"], written["interfaces"][0], written["supports"][0]):
        part["contact"] = ROUGH
    assert dump_case(load(tmp_path, named())) == dump_case(load(tmp_path, written))


def test_one_override_changes_all_that_refer_to_it(tmp_path: Path):
    case = load(tmp_path, named(), "materials.rock.poisson=0.1", "laws.rough.cohesion=2")
    assert [body.material.poisson for body in case.bodies] == [0.1, 0.25, 0.1]
    assert case.cracks[0].contact.cohesion == case.supports[0].contact.cohesion == 2e6


def test_a_faulty_definition_is_told_once(tmp_path: Path):
    where, message = fault(tmp_path, named(), "materials.rock.young=-1")
    assert where == "materials.rock.young"
    assert "out of range" in message


def test_what_checks_find_in_a_definition_stands_in_its_line(tmp_path: Path):
    scene = with_body(rectangle(0, 0, 4, 6), material="soft")
    scene = {"materials": {"soft": {"young": 1, "poisson": 0.5}}, **scene, "supports": held("rock")}
    (only,) = faults(tmp_path, scene)
    assert only.key == "bodies.rock.material.poisson"
    lines = (tmp_path / "scene.yaml").read_text(encoding="utf-8").splitlines()
    assert lines[only.line - 1].strip() == "poisson: 0.5"
