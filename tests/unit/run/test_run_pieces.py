"""Pieces of rock that contact alone holds: they slide out where friction is too little."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.contact import hold
from crackgrow.contact.solve import ContactOutcome
from crackgrow.contact.system import ContactSystem
from crackgrow.errors import FreePieceError, SolveError
from crackgrow.run import grow
from crackgrow.solid.rigid_modes import Springs

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


def pressed(tmp_path: Path, cracks: list[Any], tips: list[str], friction: list[float], **more: Any) -> Case:
    """A plate of 40 x 60 mm with cracks (mm), pressed along y."""
    scene = {
        "title": "pieces",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "rock": {
                "shape": {"rectangle": {"center": [0, 0], "width": 40, "height": 60}},
                "material": {"young": 10000, "poisson": 0.25},
                "strength": {"tension": 0.05, "cohesion": 10, "friction_angle": 40},
            }
        },
        "cracks": {
            f"c{k}": {
                "path": {"points": [list(p) for p in path]},
                "tips": end,
                "contact": {"friction": mu, "cohesion": 0},
            }
            for k, (path, end, mu) in enumerate(zip(cracks, tips, friction, strict=True), 1)
        },
        "supports": [
            {"at": [-20, -30], "displacement": {"x": 0, "y": 0}},
            {"at": [20, -30], "displacement": {"y": 0}},
        ],
        "loads": [
            {"on": {"body": "rock", "edge": "top"}, "traction": [0, -4]},
            {"on": {"body": "rock", "edge": "bottom"}, "traction": [0, 4]},
        ],
        "numerics": {"spacing": 3},
        "output": {"frames": "none", "figures": False},
        **more,
    }
    file = tmp_path / "pieces.yaml"
    file.write_text(yaml.safe_dump(scene))
    return load_case(file)


@pytest.mark.parametrize("friction", [0.2, 0.35, 0.5, 0.8])
def test_a_piece_that_friction_does_not_hold_slides_out(tmp_path: Path, friction: float) -> None:
    case = pressed(tmp_path, HELD_BY_FRICTION, TIPS, [friction] * 5)
    with pytest.raises(FreePieceError, match="is free to move: contact does not hold it"):
        next(grow(case))


@pytest.mark.parametrize("friction", [1.0, 1.5])
def test_a_piece_that_friction_holds_is_solved(tmp_path: Path, friction: float) -> None:
    assert next(grow(pressed(tmp_path, HELD_BY_FRICTION, TIPS, [friction] * 5))).residual < 1e-10


def test_pieces_without_loads_stay_where_they_are(tmp_path: Path) -> None:
    case = pressed(tmp_path, HELD_BY_FRICTION, TIPS, [1.5] * 5, loading={"history": [0.0, 1.0]})
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


def hard(tmp_path: Path, friction: float) -> Case:
    growth = {
        "steps": 3,
        "increment": 5,
        "advance": "all",
        "criterion": "max_hoop_stress",
        "tip_stress": {"radius": 1.5},
    }
    growth["unload_between_steps"] = False
    frictions = [friction, friction, 0.0, friction, friction, friction, 0.0]
    return pressed(tmp_path, HARD, ["both"] * 7, frictions, growth=growth)


@pytest.mark.parametrize("friction", [0.26, 0.29, 0.30, 0.35])
def test_pieces_that_are_held_only_just_are_in_equilibrium(tmp_path: Path, friction: float) -> None:
    steps = list(grow(hard(tmp_path, friction)))
    assert len(steps) == 4
    assert max(step.residual for step in steps) < 1e-11
    assert max(step.complementarity for step in steps) < 1e-9


def test_stiffer_springs_solve_what_loose_ones_do_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The solution does not depend on them."""
    case = pressed(tmp_path, HELD_BY_FRICTION, TIPS, [1.5] * 5)
    expected = next(grow(case))
    exact, tried = hold.solve_contact_held_loosely, []

    def fails_at_first(contact: ContactSystem, springs: Springs, *rest: Any) -> ContactOutcome:
        tried.append(springs.stiffness[0])
        if len(tried) < 3:
            raise SolveError("not solved")
        return exact(contact, springs, *rest)

    monkeypatch.setattr(hold, "solve_contact_held_loosely", fails_at_first)
    found = next(grow(case))
    assert tried == [tried[0], 3.0 * tried[0], 10.0 * tried[0]]
    for name in ("normal_traction", "tangential_traction", "opening", "slip"):
        values = getattr(expected.contact, name)
        np.testing.assert_allclose(getattr(found.contact, name), values, atol=1e-7 * np.abs(values).max())


def test_pieces_that_stiffer_springs_do_not_solve_either_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*of: Any) -> ContactOutcome:
        raise SolveError("not solved")

    monkeypatch.setattr(hold, "solve_contact_held_loosely", fails)
    with pytest.raises(SolveError, match=r"contact alone holds the piece of rock.*perhaps only just: not solved"):
        next(grow(pressed(tmp_path, HELD_BY_FRICTION, TIPS, [1.5] * 5)))
