"""K of the interaction integral against references: closed, open, mixed-mode and kinked cracks."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.judging import StepSolution, TipState
from crackgrow.run.scene import make_scene
from tests.scenes import shipped_case
from tests.solving import solve_step
from tests.verification.slit_body import plate as series

REFERENCES = Path(__file__).parent / "references"
CLOSED = np.genfromtxt(REFERENCES / "closed_crack_K.csv", delimiter=",", names=True)
PER_MM = 1e6 * np.sqrt(1e-3)  # Pa sqrt(m) of 1 MPa sqrt(mm)
MM = 1e-3


@cache
def solved(scene: str, *settings: str) -> StepSolution:
    case = shipped_case(scene, settings)
    cracks = tuple(map(GrowingCrack.given, case.cracks))
    return solve_step(make_scene(case), cracks, 1.0)


def closed_row(friction: float, stiffness: float) -> tuple[float, float]:
    """K_I and |K_II| (Pa sqrt(m)) of the reference, stiffness in N/m^3."""
    (row,) = CLOSED[(CLOSED["friction"] == friction) & (CLOSED["stiffness_N_per_m3"] == stiffness)]
    return 1e6 * float(row["K_I_MPa_sqrtm"]), 1e6 * float(row["K_II_abs_MPa_sqrtm"])


def closed_crack(friction: float, spacing: float, stiffness: float = np.inf, *more: str) -> tuple[TipState, ...]:
    kappa = "rigid" if np.isinf(stiffness) else stiffness * spacing * MM / 1e10
    return solved(
        "compression30",
        f"cracks.flaw.contact.friction={friction}",
        f"numerics.spacing={spacing}",
        f"numerics.contact.stiffness={kappa}",
        *more,
    ).tips


def plate(width: float, height: float, spacing: float) -> list[str]:
    """Settings of a plate (mm) that is held as the shipped ones are."""
    x, y = width / 2, height / 2
    held = [((-x, -y), "y"), ((x, -y), "y"), ((0, -y), "x")]
    supports = ", ".join(f"{{at: [{a}, {b}], displacement: {{{c}: 0}}}}" for (a, b), c in held)
    return [
        f"bodies.rock.shape.rectangle={{center: [0, 0], width: {width}, height: {height}}}",
        f"supports=[{supports}]",
        f"numerics.spacing={spacing}",
    ]


@pytest.mark.parametrize(
    ("discretization", "stiffness", "tolerance"),
    [("mortar", 1e11, 0.03), ("gauss", 1e11, 0.005), ("gauss", 1e13, 0.03)],
)
@pytest.mark.parametrize("friction", [0.0, 0.3, 0.6])
def test_K_I_of_the_overlap_of_elastic_contact(
    friction: float, discretization: str, stiffness: float, tolerance: float
) -> None:
    """Where the contact points resolve the length E' / (2 k) over which the pressure falls to the tip."""
    K_I, K_II = closed_row(friction, stiffness)
    setting = f"numerics.contact.discretization={discretization}"
    for tip in closed_crack(friction, 1.5, stiffness, setting):
        assert pytest.approx(K_I, rel=tolerance) == tip.K[0]
        assert pytest.approx(-K_II, abs=tolerance * np.hypot(K_I, K_II)) == tip.K[1]


def wings(*parts: tuple[float, float]) -> str:
    """The flaw with wings of given lengths (mm) and directions (degrees)."""
    points = [5.0 * np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])]
    for length, angle in parts:
        points.append(points[-1] + length * np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))]))
    path = [*[-p for p in points[::-1]], *points]
    return f"cracks.flaw.path={{points: {[p.tolist() for p in path]}}}"


WINGS = {
    "one increment": wings((2.0, 100.0)),
    "half a spacing": wings((0.75, 100.0)),
    "two increments": wings((2.0, 95.0), (2.0, 100.0)),
}


@pytest.mark.parametrize("spacing", [1.0, 0.95, 0.9])
@pytest.mark.parametrize("functions", ["patch", "gathered"])
def test_K_of_an_open_crack_wherever_in_its_cell_a_tip_lies(functions: str, spacing: float) -> None:
    exact = series(5.0, 45.0, 36.0, 36.0, 1.0)
    solution = solved("slant_tension", *plate(36, 36, spacing), f"numerics.tip_functions={functions}")
    assert all(tip.carriers.gathered == (functions == "gathered") for tip in solution.cover.tips)
    for tip in solution.tips:
        assert np.abs(tip.K) == pytest.approx(PER_MM * np.abs([exact.K_I, exact.K_II]), rel=3e-4)


@pytest.mark.parametrize("spacing", [1.0, 0.75])
def test_closed_crack_with_gathered_functions(spacing: float) -> None:
    K_II = closed_row(0.0, np.inf)[1]
    for tip in closed_crack(0.0, spacing, np.inf, "numerics.tip_functions=gathered"):
        assert abs(tip.K[1]) == pytest.approx(K_II, rel=2e-4)


@pytest.mark.parametrize("path", WINGS.values(), ids=WINGS.keys())
def test_kinked_crack_against_a_fine_solution(path: str) -> None:
    """The flaw opens over a hundredth of its length beside its kinks: cells of 0.3 mm everywhere do not resolve that.

    They tend to a K_II of the shortest wings that is 7 % off. Kinks of 12 micrometres do.
    """
    fine = solved("compression30", path, "numerics.spacing=3", "numerics.refine={tips: 6, kinks: 8}").tips[1]
    size = np.hypot(*fine.K)
    for tip in solved("compression30", path).tips:
        np.testing.assert_allclose(np.array(tip.K), fine.K, atol=0.0075 * size)


@pytest.mark.parametrize(("spacing", "tolerance"), [(1.5, 5e-3), (0.5, 1e-2)])
@pytest.mark.parametrize("path", WINGS.values(), ids=WINGS.keys())
def test_the_radius_does_not_matter(path: str, spacing: float, tolerance: float) -> None:
    """Spread over discs of 2.6 to 3.75 mm, which hold the kinks, and of 0.9 to 1.25 mm, into which one kink reaches."""
    tip = solved("compression30", path, f"numerics.spacing={spacing}").tips[1]
    assert max(tip.intensity.K_I_spread, tip.intensity.K_II_spread) < tolerance * np.hypot(*tip.K)
