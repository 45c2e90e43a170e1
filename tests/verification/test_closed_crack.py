"""The paper's example 3 before growth against an independent finite-element code (0.01 %, rigid contact)."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.contact.coulomb import STICK
from crackgrow.contact.faces import points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.cover.elements import locate
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.judging import StepSolution
from crackgrow.run.scene import make_scene
from crackgrow.solid.recovery import displacement_at
from tests.one_size import one_size
from tests.solving import solve_step

ROOT = Path(__file__).parents[2]
REFERENCES = Path(__file__).parent / "references"
HALF_LENGTH = 5e-3  # m
YOUNG_PRIME = 1e10 / (1 - 0.25**2)  # Pa


@cache
def solved(*settings: str) -> StepSolution:
    case = load_case(ROOT / "cases" / "compression30.yaml", [*one_size("compression30"), *settings])
    cracks = tuple(map(GrowingCrack.given, case.cracks))
    return solve_step(make_scene(case), cracks, 1.0)


def closed_crack(friction: float, spacing: float) -> StepSolution:
    return solved(f"cracks.flaw.contact.friction={friction}", f"numerics.spacing={spacing}")


def slip_at_middle(solution: StepSolution) -> float:
    cover = solution.cover
    middle = points_at(cover, 0, np.array([HALF_LENGTH / cover.lattice.spacing]))
    return float(gap_and_slip(cover, middle, solution.outcome.u)[1][0])


def reference_K_II(friction: float) -> float:
    rows = np.genfromtxt(REFERENCES / "closed_crack_K.csv", delimiter=",", names=True)
    row = rows[(rows["friction"] == friction) & np.isinf(rows["stiffness_N_per_m3"])]
    return float(row["K_II_abs_MPa_sqrtm"][0]) * 1e6


@pytest.mark.parametrize(("spacing", "tolerance"), [(1.5, 2e-3), (3.0, 5e-3)])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_K_II_from_the_slip_at_the_middle(friction: float, spacing: float, tolerance: float) -> None:
    # K_II of a crack in an infinite plate with this slip at its middle; the finite plate changes the ratio by 0.09 %
    slip = slip_at_middle(closed_crack(friction, spacing))
    K_II = abs(slip) * YOUNG_PRIME / 4.0 * np.sqrt(np.pi / HALF_LENGTH)
    assert pytest.approx(reference_K_II(friction), rel=tolerance) == K_II


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_K_II_of_both_tips_from_the_faces_near_them(friction: float) -> None:
    # the limit of the slip at the tip is less accurate than the slip itself: 1 %
    tips = closed_crack(friction, 1.5).tips
    assert [tip.K_faces[1] for tip in tips] == pytest.approx([-reference_K_II(friction)] * 2, rel=1e-2)
    assert max(abs(tip.K_faces[0]) for tip in tips) < 5e-3 * reference_K_II(friction)


@pytest.mark.parametrize("spacing", [1.5, 0.75])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_contact_tractions_along_the_crack(friction: float, spacing: float) -> None:
    solution = closed_crack(friction, spacing)
    name = "0" if friction == 0.0 else f"{friction}"
    table = np.genfromtxt(
        REFERENCES / f"closed_crack_theta30_friction{name}.csv", delimiter=",", names=True, encoding="utf-8"
    )
    s = solution.faces.s * solution.cover.lattice.spacing - HALF_LENGTH
    away = np.abs(s) < HALF_LENGTH - solution.cover.lattice.spacing  # more than a spacing from the tips
    assert away.sum() >= 3
    pressure = np.interp(s[away], table["s_mm"] * 1e-3, table["normal_pressure_MPa"] * 1e6)
    np.testing.assert_allclose(-solution.outcome.points.normal[away], pressure, rtol=2e-3)
    shear = np.abs(solution.outcome.points.tangential[away])
    np.testing.assert_allclose(shear, friction * pressure, rtol=2e-3, atol=1.0)


def test_slip_along_the_crack_follows_the_reference() -> None:
    solution = closed_crack(0.0, 0.75)
    table = np.genfromtxt(
        REFERENCES / "closed_crack_theta30_friction0.csv", delimiter=",", names=True, encoding="utf-8"
    )
    s = np.linspace(-4.2e-3, 4.2e-3, 41)
    points = points_at(solution.cover, 0, (s + HALF_LENGTH) / solution.cover.lattice.spacing)
    slip = gap_and_slip(solution.cover, points, solution.outcome.u)[1]
    expected = np.interp(s, table["s_mm"] * 1e-3, table["slip_mm"] * 1e-3)
    np.testing.assert_allclose(slip, expected, rtol=5e-3)


@pytest.mark.parametrize("spacing", [3.0, 1.5])
def test_crack_with_more_friction_than_it_can_overcome_sticks(spacing: float) -> None:
    solution = closed_crack(0.6, spacing)  # above cot(60 degrees) = 0.577
    assert set(solution.outcome.points.state.tolist()) == {STICK}
    assert np.abs(solution.outcome.points.slip).max() < 1e-9
    np.testing.assert_allclose(solution.outcome.points.normal, -75e6, rtol=1e-4)  # exact: sin^2(60 degrees) 100 MPa


def test_stuck_crack_leaves_the_field_of_the_intact_plate() -> None:
    solution = closed_crack(0.6, 1.5)
    points = points_at(
        solution.cover, 0, np.linspace(0.05, 0.95, 31) * 2.0 * HALF_LENGTH / solution.cover.lattice.spacing
    )
    gap, slip = gap_and_slip(solution.cover, points, solution.outcome.u)
    largest = np.abs(solution.outcome.u[: 2 * len(solution.cover.patches.nodes)]).max()
    assert max(np.abs(gap).max(), np.abs(slip).max()) < 1e-9 * largest


@pytest.mark.parametrize(("spacing", "angle"), [(3.0, 30.0), (1.5, 30.0), (1.5, 10.0)])
def test_patch_test_through_a_stuck_crack(spacing: float, angle: float) -> None:
    """Uniform compression passes a stuck crack, to the accuracy of the rules on its faces: at most 3e-10."""
    solution = solved(
        "cracks.flaw.contact.friction=0.6", f"numerics.spacing={spacing}", f"cracks.flaw.path.angle={angle}"
    )
    metres = np.random.default_rng(1).uniform((-15.4e-3, -27.4e-3), (15.4e-3, 27.4e-3), (800, 2))
    points = solution.cover.lattice.to_lattice(metres)
    found = displacement_at(
        solution.cover, solution.outcome.u, points, locate(solution.cover.lattice, solution.cover.elements, points)
    )
    strain_yy, strain_xx = -100e6 / YOUNG_PRIME, 100e6 * 0.25 * 1.25 / 1e10  # plane strain
    exact = np.stack([strain_xx * metres[:, 0], strain_yy * (metres[:, 1] + 27.5e-3)], axis=1)
    assert np.abs(found - exact).max() < 1e-9 * np.abs(exact).max()


def test_elastic_contact_overlaps_by_pressure_over_stiffness() -> None:
    kappa = 100.0
    solution = solved(f"numerics.contact.stiffness={kappa}")
    k = kappa * 1e10 / 1.5e-3
    np.testing.assert_allclose(solution.outcome.points.opening, solution.outcome.points.normal / k, rtol=1e-9)
    assert abs(slip_at_middle(solution)) == pytest.approx(abs(slip_at_middle(solved())), rel=1e-2)


def test_equilibrium_and_contact_conditions_hold_at_round_off() -> None:
    solution = closed_crack(0.3, 1.5)
    assert solution.outcome.residual < 1e-11
    assert solution.outcome.complementarity < 1e-10
    assert solution.outcome.penetration < 1e-15  # m, rigid contact
    assert solution.outcome.points.n_unknowns == 2 * solution.faces.n
    assert closed_crack(0.0, 1.5).outcome.points.n_unknowns == solution.faces.n  # no friction, no friction rows
