"""Other names of keys and words lead to those of the format."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from crackgrow.case.declared import keys_of
from crackgrow.case.keys import case_keys
from crackgrow.case.model import CoulombContact, Material, Strength
from crackgrow.case.report import nearest
from crackgrow.case.synonyms import SYNONYMS
from tests.unit.case.scenes import fault, held, load, rectangle, with_body

FLAW = {"path": {"center": [5, 5], "length": 2, "angle": 30}, "contact": {"friction": 0.3, "cohesion": 0}}


@pytest.mark.parametrize(
    ("text", "allowed", "meant"),
    [
        ("E", keys_of(Material), "young"),
        ("nu", keys_of(Material), "poisson"),
        ("rho", keys_of(Material), "density"),
        ("phi", keys_of(Strength), "friction_angle"),
        ("sigma_t", keys_of(Strength), "tension"),
        ("K_Ic", keys_of(Strength), "toughness"),
        ("mu", keys_of(CoulombContact), "friction"),
        ("phi", keys_of(CoulombContact), "friction"),
        ("circle", ("rectangle", "polygon", "disk"), "disk"),
        ("h", ("center", "width", "height"), "height"),
        ("h", ("support", "spacing"), "spacing"),
        ("E", ("strength", "directional_strength", "max_hoop_stress"), None),
    ],
)
def test_other_names_mean_the_key_that_is_allowed(text: str, allowed: object, meant: str | None):
    assert nearest(text, allowed) == meant


def test_every_meaning_is_a_key_or_word_of_the_format():
    keys = {part for key in case_keys() for part in key.name.split(".")}
    words = {"none", "bonded"}
    assert {meant for several in SYNONYMS.values() for meant in several} - keys - words == set()
    assert [name for name in SYNONYMS if name != name.lower()] == []


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"in_situ": {"stress": [-12, -8, 0]}}, "stress from the start is a load"),
        ({"stress": [-12, -8, 0]}, "stress from the start is a load"),  # and not `units.stress`
        ({"gravity": [0, -9.81]}, "weight is a load"),
        ({"cracks": {"flaw": {**FLAW, "pressure": 1}}}, "fluid pressure in a crack is a load"),
    ],
)
def test_what_is_a_load_here_is_said_with_an_example_that_loads(tmp_path: Path, wrong: dict[str, Any], words: str):
    scene = {**with_body(rectangle(0, 0, 10, 10)), "cracks": {"flaw": FLAW}, "supports": held("rock")}
    _, message = fault(tmp_path, {**scene, **wrong})
    assert words in message
    example = yaml.safe_load(message.split("`")[-2].replace("NAME", "flaw"))
    body = {"rock": {**scene["bodies"]["rock"], "material": {"young": 1000, "poisson": 0.2, "density": "2600 kg/m^3"}}}
    assert load(tmp_path, {**scene, **example, "bodies": body}).loads


def test_names_of_edges_within_a_shape_are_said_to_belong_to_the_body(tmp_path: Path) -> None:
    corners = [[0, 0], [10, 0], [10, 10]]
    scene = {**with_body(rectangle(0, 0, 10, 10)), "supports": held("rock")}
    scene["bodies"]["rock"]["shape"] = {"polygon": corners, "edges": {"inlet": 1}}
    key, message = fault(tmp_path, scene)
    assert key == "bodies.rock.shape.edges"
    assert "belong to the body, beside `shape`" in message
