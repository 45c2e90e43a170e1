"""One solved configuration: history of cohesion, the stiffness of contact, and purity."""

from __future__ import annotations

import numpy as np

from crackgrow.contact.coulomb import STICK
from crackgrow.fracture.advance import GrowingCrack, Way, advanced
from crackgrow.run.judging import StepSolution
from crackgrow.run.scene import make_scene
from tests.scenes import shipped_case
from tests.solving import solve_step

CASE = "compression30"
SHEAR = 100e6 * np.sin(np.deg2rad(30.0)) * np.cos(np.deg2rad(30.0))  # Pa, 43.3 MPa on the flaw's plane


def solve(*settings: str, wings: float | None = None) -> StepSolution:
    """The flaw of the scene, with a segment of 3 mm added to its end that is turned by `wings` degrees."""
    case = shipped_case(CASE, settings)
    scene = make_scene(case)
    (crack,) = case.cracks
    growing = GrowingCrack.given(crack)
    if wings is not None:
        growing, _ = advanced(growing, True, Way(np.deg2rad(wings), 3e-3), 1, scene.regions[0])
    return solve_step(scene, (growing,), 1.0)


def test_faces_that_growth_has_made_have_no_cohesion() -> None:
    """The new part goes straight on and is pressed as the old one: only the old one is bonded."""
    solution = solve(f"cracks.flaw.contact.cohesion={3.0 * SHEAR / 1e6}", wings=0.0)
    s = solution.faces.s * solution.cover.lattice.spacing
    new = s > 10e-3 + 1e-9
    assert new.any()
    assert not solution.outcome.points.tangential[new].any()
    assert set(solution.outcome.points.state[~new].tolist()) == {STICK}
    weights = solution.contact.weights[~new]
    assert np.abs(solution.outcome.points.tangential[~new] @ weights) > SHEAR * weights.sum()  # and more at its ends
