"""Pieces of rock that contact alone holds: they slide out where friction is too little."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case.load import read_case
from crackgrow.case.model import Case
from crackgrow.errors import FreePieceError
from crackgrow.run import grow
from tests.scenes import specimen

HELD_BY_FRICTION = [
    [(-2.47, 6.123), (-2.616, 9.325), (-2.863, 14.319), (-14.167, 23.901), (-14.378, 28.896), (-13.608, 30.0)],
    [(3.057, 5.426), (7.708, 7.262), (9.85, 11.78), (9.446, 16.763), (-0.943, 24.96), (-1.141, 30.0)],
    [
        (-11.323, -15.005), (-6.689, -12.67), (-7.447, -7.728), (-8.177, -2.782), (-6.742, -0.542), (-2.47, 6.123),
        (-0.034, 9.925), (-0.415, 14.91), (-3.455, 18.88), (-7.842, 21.279),
    ],
    [(-3.539, -30.0), (-2.954, -28.649), (-3.425, -23.671), (-12.66, -19.495), (-13.114, -17.332)],
    [
        (-16.934, -30.0), (-17.593, -28.181), (-17.615, -23.181), (-13.114, -17.332), (-11.323, -15.005),
        (-8.455, -11.278), (-9.14, -6.326), (-10.307, -1.464), (-6.742, -0.542),
    ],
]  # fmt: skip
"""mm: cracks that cut three pieces out of a plate; the lowest would slide down and out."""
TIPS = ["none", "start", "end", "none", "none"]
"""Of these."""


def pressed(cracks: list[Any], tips: list[str], friction: list[float], **more: Any) -> Case:
    """A plate of 40 x 60 mm with cracks (mm), pressed along y."""
    given = {
        f"c{k}": {"path": {"points": [list(p) for p in path]}, "tips": end, "contact": {"friction": mu, "cohesion": 0}}
        for k, (path, end, mu) in enumerate(zip(cracks, tips, friction, strict=True), 1)
    }
    scene = specimen(given, (40.0, 60.0), -4.0, numerics={"spacing": 3}, **more)
    scene["bodies"]["rock"]["strength"]["tension"] = 0.05
    return read_case(yaml.safe_dump(scene), "pieces", "pieces")


@pytest.mark.parametrize("friction", [0.2, 0.35, 0.5, 0.6, 1.0, 1.5])
def test_a_piece_slides_out_where_friction_does_not_hold_it(friction: float) -> None:
    case = pressed(HELD_BY_FRICTION, TIPS, [friction] * 5)
    if friction < 1.0:
        with pytest.raises(FreePieceError, match="is free to move: contact does not hold it"):
            next(grow(case))
    else:
        assert next(grow(case)).residual < 1e-10


def test_pieces_without_loads_stay_where_they_are() -> None:
    case = pressed(HELD_BY_FRICTION, TIPS, [1.5] * 5, loading={"history": [0.0, 1.0]})
    unloaded, loaded = grow(case)
    assert np.abs(unloaded.contact.opening).max() == np.abs(unloaded.contact.slip).max() == 0.0
    assert loaded.residual < 1e-10


HARD = [
    [(-5.209, -23.467), (-9.525, -20.599)],
    [(13.743, -2.085), (8.774, 0.228), (0.945, 6.273)],
    [(10.624, -2.037), (10.119, 2.673), (12.619, 6.017)],
    [(11.663, -6.064), (-4.278, -5.103)],
    [(-3.04, -23.963), (-4.069, -11.068)],
    [(13.459, 16.479), (11.468, 25.19)],
    [(-2.053, 15.261), (-2.138, 19.882), (-4.883, 22.205)],
]
"""mm: cracks that grow together in two steps; pieces that friction then holds only just."""


GROWTH = {
    "steps": 3,
    "increment": 5,
    "advance": "all",
    "criterion": "max_hoop_stress",
    "tip_stress": {"radius": 1.5},
    "unload_between_steps": False,
}


@pytest.mark.parametrize("friction", [0.26, 0.29, 0.30, 0.35])
def test_pieces_that_are_held_only_just_are_in_equilibrium(friction: float) -> None:
    frictions = [friction, friction, 0.0, friction, friction, friction, 0.0]
    steps = list(grow(pressed(HARD, ["both"] * 7, frictions, growth=GROWTH)))
    assert len(steps) == 4
    assert max(step.residual for step in steps) < 1e-11
    assert max(step.complementarity for step in steps) < 1e-9


CAPPED = """
title: A cap on a block that rests on a base
units: {length: mm, stress: MPa}
plane: strain
bodies:
  base: {shape: {rectangle: {center: [0, -10], width: 60, height: 20}}, material: {young: 10000, poisson: 0.2}}
  block: {shape: {rectangle: {center: [0, 10], width: 40, height: 20}}, material: {young: 10000, poisson: 0.2}}
  cap: {shape: {rectangle: {center: [0, 25], width: 40, height: 10}}, material: {young: 10000, poisson: 0.2}}
interfaces:
  - {between: [base, block], contact: {friction: 0.5, cohesion: 0}}
  - {between: [block, cap], contact: bonded}
supports:
  - {on: {body: base, edge: bottom}, displacement: {x: 0, y: 0}}
loads:
  - {on: {body: cap, edge: top}, traction: [SHEAR, -3]}
numerics: {spacing: 5}
output: {figures: false, frames: none}
"""


def test_a_body_bonded_to_one_that_contact_holds_is_held_as_long_as_friction_holds_that() -> None:
    """The joint carries the load on the cap, and all of it stays where it is."""
    held, sliding = (read_case(CAPPED.replace("SHEAR", shear), "capped", "capped") for shear in ("0.5", "2"))
    result = next(grow(held))
    joint = next(face for face in result.faces if face.crack == "base/block")
    normal, shear = (np.trapezoid(p, joint.s) for p in (joint.normal_traction, joint.tangential_traction))
    assert result.residual < 1e-10
    assert normal == pytest.approx(-3e6 * 0.04, rel=1e-9)
    assert abs(shear) == pytest.approx(0.5e6 * 0.04, rel=1e-9)
    with pytest.raises(FreePieceError, match="free to move: contact does not hold it, it slides along"):
        next(grow(sliding))
