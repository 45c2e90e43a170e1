"""One solved configuration: history of cohesion, the stiffness of contact, and purity."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.contact.coulomb import SLIP, STICK
from crackgrow.fracture.advance import GrowingCrack, Way, advanced
from crackgrow.run.judging import StepSolution
from crackgrow.run.scene import make_scene
from tests.solving import solve_step

CASE = Path(__file__).parents[3] / "cases" / "compression30.yaml"
SHEAR = 100e6 * np.sin(np.deg2rad(30.0)) * np.cos(np.deg2rad(30.0))  # Pa, 43.3 MPa on the flaw's plane


def solve(*settings: str, wings: float | None = None) -> StepSolution:
    """The flaw of the scene, with a segment of 3 mm added to its end that is turned by `wings` degrees."""
    case = load_case(CASE, settings)
    scene = make_scene(case)
    (crack,) = case.cracks
    growing = GrowingCrack(crack, np.zeros(len(crack.points), dtype=np.int64))
    if wings is not None:
        growing, _ = advanced(growing, True, Way(np.deg2rad(wings), 3e-3), 1, scene.regions[0])
    return solve_step(scene, (growing,), 1.0)


@pytest.mark.parametrize(("share", "expected"), [(1.02, {STICK}), (0.5, {SLIP})])
def test_cohesion_holds_the_flaw_up_to_the_shear_on_its_plane(share: float, expected: set[int]) -> None:
    solution = solve(
        f"cracks.flaw.contact.cohesion={share * SHEAR / 1e6}", "cracks.flaw.contact.cohesion_after_slip=kept"
    )
    assert set(solution.outcome.points.state.tolist()) == expected
    limit = min(share, 1.0) * SHEAR
    np.testing.assert_allclose(np.abs(solution.outcome.points.tangential), limit, rtol=1e-3)  # patch test: 1e-4


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


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_contact_stiffness_is_kappa_E_over_h(plane: str) -> None:
    solution = solve("numerics.contact.stiffness=50", "numerics.spacing=2", f"plane={plane}")
    k = 50 * 1e10 / 2e-3
    np.testing.assert_allclose(solution.outcome.points.opening, solution.outcome.points.normal / k, rtol=1e-9)


def test_solving_the_same_configuration_twice_gives_the_same_bits() -> None:
    case = load_case(CASE, ["cracks.flaw.contact.friction=0.3"])
    scene = make_scene(case)
    (crack,) = case.cracks
    growing = GrowingCrack(crack, np.zeros(2, dtype=np.int64))
    longer, _ = advanced(growing, True, Way(1.0, 2e-3), 1, scene.regions[0])
    first = solve_step(scene, (growing,), 1.0)
    other = solve_step(scene, (longer,), 0.5)
    again = solve_step(scene, (growing,), 1.0)
    assert other.cover.n_dofs != first.cover.n_dofs
    np.testing.assert_array_equal(again.outcome.u, first.outcome.u)
    np.testing.assert_array_equal(again.outcome.points.normal, first.outcome.points.normal)
    assert again.tips[0].K == first.tips[0].K


def test_reversing_the_crack_changes_nothing_but_the_order_of_its_points() -> None:
    """plus and minus faces change places, and so do start and end."""
    there = solve("cracks.flaw.contact.friction=0.3")
    back = solve("cracks.flaw.contact.friction=0.3", "cracks.flaw.path.angle=210")
    scale = np.abs(there.outcome.points.slip).max()
    np.testing.assert_allclose(back.outcome.points.slip[::-1], there.outcome.points.slip, atol=1e-6 * scale)
    np.testing.assert_allclose(back.outcome.points.normal[::-1], there.outcome.points.normal, rtol=1e-6)
    K_II = [tip.K[1] for tip in there.tips]
    assert [tip.K[1] for tip in back.tips][::-1] == pytest.approx(K_II, rel=1e-6)


def test_seconds_are_given_phase_by_phase() -> None:
    seconds = solve("numerics.spacing=3").seconds
    assert set(seconds) == {"cover", "assembly", "factorize", "contact", "criterion"}
    assert min(seconds.values()) > 0.0
