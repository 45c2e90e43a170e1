"""What slip makes of friction and cohesion: defaults, forms, and laws that no rock can have."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest

from crackgrow.case.model import CoulombContact
from tests.scenes import shipped_case
from tests.unit.case.scenes import EVERYTHING, load
from tests.unit.case.test_case_load import reread, same

FILE = "compression30"
LAW = {"friction": 0.6, "cohesion": 2}
FULL = {**LAW, "residual_friction": 0.4, "cohesion_after_slip": "kept", "dilation_angle": "5 deg"}
PLACES = ("cracks.flaw.contact", "interfaces.0.contact", "supports.0.contact")


def with_law(place: str, law: object) -> dict[str, Any]:
    """EVERYTHING with a law of contact at one place."""
    scene = copy.deepcopy(EVERYTHING)
    *parents, last = place.split(".")
    part: Any = scene
    for key in parents:
        part = part[int(key) if key.isdigit() else key]
    part[last] = law
    return scene


def law_of(scene: dict[str, Any], place: str, tmp_path: Path) -> CoulombContact:
    case = load(tmp_path, scene)
    kind = place.partition(".")[0]
    contact = {"cracks": case.cracks, "interfaces": case.interfaces, "supports": case.supports}[kind][0].contact
    assert isinstance(contact, CoulombContact)
    return contact


@pytest.mark.parametrize("place", PLACES)
def test_law_with_every_key(place: str, tmp_path: Path):
    contact = law_of(with_law(place, FULL), place, tmp_path)
    assert (contact.friction, contact.cohesion, contact.residual_friction) == (0.6, 2e6, 0.4)
    assert (contact.cohesion_kept, contact.dilation_angle) == (True, 5.0)


@pytest.mark.parametrize("place", PLACES)
def test_law_with_defaults(place: str, tmp_path: Path):
    contact = law_of(with_law(place, LAW), place, tmp_path)
    assert (contact.residual_friction, contact.cohesion_kept, contact.dilation_angle) == (0.6, False, 0.0)


def test_defaults_of_the_law_are_in_the_resolved_case(tmp_path: Path):
    case = shipped_case(FILE, ["cracks.flaw.contact.friction=0.3"])
    assert list(case.resolved["cracks"]["flaw"]["contact"].items()) == [  # type: ignore[index]
        ("friction", 0.3),
        ("cohesion", 0.0),
        ("tension", 0.0),
        ("residual_friction", 0.3),
        ("cohesion_after_slip", "lost"),
        ("dilation_angle", 0.0),
    ]
    assert same(case, reread(case, tmp_path))


@pytest.mark.parametrize(("friction", "angle"), [(1.0, 45), (0.0, 0), (0.58, 30)])
def test_steepest_dilation(friction: float, angle: float, tmp_path: Path):
    law = {"friction": friction, "cohesion": 0, "dilation_angle": angle}
    assert law_of(with_law(PLACES[0], law), PLACES[0], tmp_path).dilation_angle == angle
