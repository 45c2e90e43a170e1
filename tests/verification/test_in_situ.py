"""In-situ stress in rock whose outline is held, or loaded by the same stress: nothing moves but what a flaw lets go."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

import crackgrow
from crackgrow.case import Case

STRESS = (-2.0, -10.0, 1.5)
"""MPa: xx, yy, xy."""

PLACES = np.array([[10.0, 10.0], [30.0, 0.0], [0.0, 40.0], [-25.0, -20.0]])


def outcrop(n: int = 163) -> list[list[float]]:
    """Corners of a ragged outline of about 100 m across."""
    rng = np.random.default_rng(1)
    angle = 2.0 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    radius = 50.0 * (1.0 + 0.15 * np.cos(2.0 * angle + 1.0) + 0.08 * np.cos(5.0 * angle) + 0.02 * rng.uniform(-1, 1, n))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]).tolist()


def rock(supports: Any, loads: Sequence[dict[str, Any]], flaw: float | None = None, square: bool = False) -> Case:
    """An outcrop, or a square of 100 m, perhaps with a closed flaw of 5 m at an angle (degrees)."""
    shape = {"rectangle": {"center": [0, 0], "width": 100, "height": 100}} if square else {"polygon": outcrop()}
    path = {"center": [0, 0], "length": 5, "angle": flaw}
    cracks = {} if flaw is None else {"flaw": {"path": path, "contact": {"friction": 0.3, "cohesion": 0}}}
    return Case.from_dict(
        {
            "title": "rock with an in-situ stress",
            "units": {"length": "m", "stress": "MPa"},
            "plane": "strain",
            "bodies": {"rock": {"shape": shape, "material": {"young": "30 GPa", "poisson": 0.2}}},
            "cracks": cracks,
            "supports": supports,
            "loads": list(loads),
        }
    )


IN_SITU, FAR = {"stress": list(STRESS)}, {"far_field": list(STRESS)}
NO_SHEAR = {"stress": [*STRESS[:2], 0]}


@pytest.mark.parametrize(
    ("supports", "loads", "square", "moved"),
    [
        ("minimal", [FAR], False, 2e-2),
        ("minimal", [IN_SITU, FAR], False, 0.0),
        ([{"outline": "fixed"}], [IN_SITU], False, 1e-10),
        ([{"outline": "rollers"}], [NO_SHEAR], True, 1e-10),
    ],
    ids=["loaded", "in balance", "fixed", "rollers"],
)
def test_without_a_crack_stress_is_uniform(
    supports: Any, loads: list[dict[str, Any]], square: bool, moved: float
) -> None:
    """The stress alone would displace the rim by 10 mm."""
    solution = crackgrow.solve(rock(supports, loads, square=square))
    wanted = 1e6 * np.array(loads[0].get("stress", STRESS))
    np.testing.assert_allclose(solution.stress_at(PLACES), np.tile(wanted, (4, 1)), atol=1.0)
    assert np.abs(solution.displacement_at(PLACES)).max() <= moved
    assert not solution.warnings


@pytest.mark.parametrize("flaw", [45.0, 65.0, 120.0])
@pytest.mark.parametrize("loads", [[FAR], [IN_SITU, FAR]], ids=["loaded", "in balance"])
def test_K_of_a_closed_flaw_is_that_in_an_infinite_plane(loads: list[dict[str, Any]], flaw: float) -> None:
    xx, yy, xy = 1e6 * np.array(STRESS)
    along = np.array([np.cos(np.deg2rad(flaw)), np.sin(np.deg2rad(flaw))])
    traction = np.array([[xx, xy], [xy, yy]]) @ (-along[1], along[0])
    normal, shear = float(traction @ (-along[1], along[0])), float(traction @ along)
    slipping = max(abs(shear) + 0.3 * normal, 0.0)
    tips = crackgrow.solve(rock("minimal", loads, flaw)).tips
    K = slipping * np.sqrt(np.pi * 2.5)
    assert K > 1e6
    np.testing.assert_allclose(tips["K_II"].abs(), K, rtol=0.01)
    np.testing.assert_allclose(tips["K_I"], 0.0, atol=0.01 * K)


def test_K_of_a_flaw_in_held_rock_is_a_little_less() -> None:
    """What the flaw lets go is held back by an outline twenty times as wide."""
    exact = (4.0 + 0.3 * (-6.0)) * 1e6 * np.sqrt(np.pi * 2.5)
    for supports, square in (([{"outline": "rollers"}], True), ([{"outline": "fixed"}], False)):
        tips = crackgrow.solve(rock(supports, [NO_SHEAR], 45.0, square)).tips
        np.testing.assert_allclose(tips["K_II"].abs(), exact, rtol=0.01)


def test_a_far_field_on_bodies_side_by_side_is_that_on_one() -> None:
    """Their common boundary, bonded, is no part of the outline."""
    elastic = {"young": "30 GPa", "poisson": 0.2}
    left = {"rectangle": {"center": [-25, 0], "width": 50, "height": 100}}
    right = {"polygon": [[0, -40], [30, -50], [50, 0], [40, 45], [0, 60]]}
    bodies = {name: {"shape": shape, "material": elastic} for name, shape in (("left", left), ("right", right))}
    case = Case.from_dict(
        {
            "title": "two bodies",
            "units": {"length": "m", "stress": "MPa"},
            "plane": "strain",
            "bodies": bodies,
            "interfaces": [{"between": ["left", "right"], "contact": "bonded"}],
            "supports": "minimal",
            "loads": [FAR],
        }
    )
    stress = crackgrow.solve(case).stress_at(PLACES)
    np.testing.assert_allclose(stress, 1e6 * np.tile(STRESS, (4, 1)), atol=10.0)
