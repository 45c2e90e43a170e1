"""Single cracks of random angle, length and place: the solve is accurate, and the contact conditions hold."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.case.model import CoulombContact
from crackgrow.contact.coulomb import OPEN, SLIP, STICK
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.frame import make_frame
from crackgrow.run.judging import StepSolution
from crackgrow.run.result import Frame
from crackgrow.run.scene import make_scene
from tests.solving import solve_step

CASE = Path(__file__).parents[2] / "cases" / "compression30.yaml"
SIZE = np.array([31e-3, 55e-3])  # m
SPACING = 3.0  # mm
CLEAR = 2e-3  # m: nearest that a tip comes to the outline
SEEDS = range(20)

RESIDUAL = 1e-9
COMPLEMENTARITY = 1e-8


def random_crack(seed: int) -> tuple[np.ndarray, float, float]:
    """Path (2, 2) m inside of the plate, friction, and load (MPa, negative in compression)."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(-90.0, 90.0)
    half = 0.5 * rng.uniform(4e-3, 20e-3) * np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])
    room = 0.5 * SIZE - CLEAR - np.abs(half)
    centre = rng.uniform(-1.0, 1.0, 2) * room
    return np.array([centre - half, centre + half]), float(rng.choice([0.0, 0.3, 0.8])), (-100.0, 1.0)[seed % 2]


@cache
def solved(seed: int) -> tuple[StepSolution, Frame, float]:
    path, friction, load = random_crack(seed)
    traction = [f"loads.0.traction=[0, {load}]", f"loads.1.traction=[0, {-load}]"]
    case = load_case(CASE, [f"numerics.spacing={SPACING}", "growth.steps=1", *traction])
    crack = replace(case.cracks[0], points=path, contact=CoulombContact(friction, 0.0, friction, False))
    scene = make_scene(replace(case, cracks=(crack,)))
    solution = solve_step(scene, (GrowingCrack(crack, np.zeros(2, dtype=np.int64)),), 1.0)
    return solution, make_frame(solution.cover, scene.materials, solution.outcome.u), friction


@pytest.mark.parametrize("seed", SEEDS)
def test_equilibrium_and_complementarity_hold(seed: int) -> None:
    solution, _, _ = solved(seed)
    assert solution.outcome.residual < RESIDUAL
    assert solution.outcome.complementarity < COMPLEMENTARITY
    assert solution.outcome.penetration < 1e-9 * np.ptp(solution.outcome.u)


@pytest.mark.parametrize("seed", SEEDS)
def test_every_contact_point_obeys_coulomb(seed: int) -> None:
    solution, _, friction = solved(seed)
    outcome = solution.outcome
    p_n, p_t = outcome.points.normal, outcome.points.tangential
    size, length = max(np.abs(p_n).max(), 1.0), np.ptp(outcome.u)
    assert p_n.max() <= 0.0
    is_open, stick, slip = (outcome.points.state == state for state in (OPEN, STICK, SLIP))
    assert np.abs(p_n[is_open]).max(initial=0.0) == 0.0
    assert np.abs(p_t[is_open]).max(initial=0.0) == 0.0
    assert np.abs(outcome.points.opening[~is_open]).max(initial=0.0) < 1e-9 * length
    assert np.abs(outcome.points.slip[stick]).max(initial=0.0) < 1e-9 * length
    assert np.max(np.abs(p_t) + friction * p_n) < 1e-9 * size
    np.testing.assert_allclose(np.abs(p_t[slip]), -friction * p_n[slip], atol=1e-9 * size)
    assert np.min(p_t[slip] * outcome.points.slip[slip], initial=0.0) >= -1e-9 * size * length  # friction takes energy


@pytest.mark.parametrize("seed", SEEDS)
def test_the_mesh_fills_the_plate(seed: int) -> None:
    _, frame, _ = solved(seed)
    total = 0.0
    for cells in (frame.triangles, frame.quads):
        x, y = frame.points[cells].transpose(2, 0, 1)
        area = 0.5 * np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y, axis=1)
        assert area.min() > -1e-15  # m^2
        total += area.sum()
    assert total == pytest.approx(np.prod(SIZE), rel=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_contact_weights_sum_to_the_length_of_the_crack(seed: int) -> None:
    solution, _, _ = solved(seed)
    path, _, _ = random_crack(seed)
    length = np.hypot(*np.diff(path, axis=0)[0])
    assert solution.faces.weights.sum() * solution.cover.lattice.spacing == pytest.approx(length, rel=1e-7)


def test_the_sample_has_open_sticking_and_slipping_cracks() -> None:
    seen = set(np.concatenate([solved(seed)[0].outcome.points.state for seed in SEEDS]).tolist())
    assert seen == {OPEN, STICK, SLIP}
