"""Covers with cells of several sizes: rigid motions, the direct solver, the cover before, the error at a tip."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import block_array
from scipy.sparse.linalg import splu

from crackgrow.approximation.basis import values_at
from crackgrow.case.model import PointSupport
from crackgrow.cover.elements import locate
from crackgrow.solid.rigid_modes import rigid_motions
from tests.unit.exact_fields import solved_under, true_error

Floats = NDArray[np.float64]
SIZE = (8, 7)
KINKED = [(2.2, 2.3), (4.1, 2.9), (4.6, 4.4)]
SHORT = [(6.1, 5.2), (6.4, 5.35)]
PLACES = [*KINKED, *SHORT, (8.5, 0.5)]


def graded(build, support: float, levels: int):
    cracks = [build.crack(KINKED, name="kinked"), build.crack(SHORT, name="short")]
    return build.block(SIZE, cracks, support, levels, PLACES)


@pytest.mark.parametrize(("support", "levels"), [(2.0, 1), (2.0, 3), (2.0, 6), (1.5, 3), (2.5, 2)])
def test_rigid_motions_produce_no_forces_and_stiffness_is_symmetric(build, support: float, levels: int) -> None:
    sample = graded(build, support, levels)
    matrix = sample.stiffness()
    motions = rigid_motions(sample.cover, np.arange(len(sample.cover.patches.nodes))).toarray()
    size = matrix.diagonal().max()
    assert np.abs(matrix @ motions).max() < 1e-12 * size
    rng = np.random.default_rng(levels)
    one, other = rng.normal(size=(2, sample.cover.n_dofs))
    assert one @ (matrix @ other) == pytest.approx(other @ (matrix @ one), abs=1e-12 * size * len(one))
    assert matrix.diagonal().min() > 0.0
    assert one @ (matrix @ one) > 0.0


@pytest.mark.parametrize(
    ("support", "levels", "cracked"),
    [(2.0, 1, True), (1.5, 3, True), (1.5, 6, True), (2.0, 3, False), (2.0, 6, False), (2.5, 3, False)],
)
def test_the_direct_solver_agrees_with_sparse_lu(build, support: float, levels: int, cracked: bool) -> None:
    """In displacements: where functions nearly depend on each other, unknowns may differ."""
    sample = graded(build, support, levels) if cracked else build.block(SIZE, [], support, levels, PLACES)
    low, right = np.array([0.5, 0.5]), np.array([8.5, 0.5])
    system, _ = sample.system([PointSupport("rock", low, (0.0, 0.0)), PointSupport("rock", right, (None, 0.0))])
    n, m = sample.cover.n_dofs, system.constraints.shape[0]
    points = sample.lattice.to_lattice(np.random.default_rng(levels).uniform(low, low + SIZE, (300, 2)))
    rows = values_at(sample.cover, points, locate(sample.lattice, sample.cover.elements, points)).values()
    loads = (rows.T @ np.random.default_rng(7).normal(size=(len(points), 2))).ravel()
    scale = system.stiffness.diagonal().max()
    bordered = block_array(
        [[system.stiffness.tocsc(), scale * system.constraints.T], [scale * system.constraints, None]]
    )
    lu = splu(bordered.tocsc())
    known = np.append(loads, np.zeros(m))
    found = lu.solve(known)
    found += lu.solve(known - bordered @ found)
    u = system.solve(loads)[0]
    here, there = (rows @ some.reshape(-1, 2) for some in (u, found[:n]))
    np.testing.assert_allclose(here, there, atol=1e-9 * np.abs(there).max())


TIP = np.array([5.0, 4.0])
"""A corner of cells."""


def mode_one(points: Floats) -> Floats:
    """Stress (n, 3) round a tip with a crack on its left, for a K of 1."""
    x, y = (points - TIP).T
    r, t = np.hypot(x, y), 0.5 * np.arctan2(y, x)
    terms = (1.0 - np.sin(t) * np.sin(3.0 * t), 1.0 + np.sin(t) * np.sin(3.0 * t), np.sin(t) * np.cos(3.0 * t))
    return np.asarray((np.cos(t) / np.sqrt(2.0 * np.pi * r) * terms).T)


def error_of_mode_one(build, levels: int, *, is_tip: bool = False, everywhere: bool = False) -> float:
    """Percent of the energy norm on a square of 8 x 8; if it is none, the crack ends without tip functions."""
    crack = build.crack([(0.5, TIP[1]), TIP], (False, is_tip))
    places = [(x, y) for x in range(1, 9) for y in range(1, 9)] if everywhere else [TIP]
    sample = build.sample((0.5, 0.5), (8.5, 8.5), [crack], support=2.0, levels=levels, places=places, rings=3.0)
    return true_error(sample, solved_under(sample, mode_one), mode_one)


def test_the_error_at_a_tip_falls_by_the_square_root_of_two_a_level(build) -> None:
    """Without tip functions; it is that of a lattice whose cells are everywhere as small as the smallest."""
    errors = np.array([error_of_mode_one(build, levels) for levels in range(7)])
    np.testing.assert_allclose(errors[1:-1] / errors[2:], np.sqrt(2.0), rtol=0.1)
    assert errors[2] == pytest.approx(error_of_mode_one(build, 2, everywhere=True), rel=0.01)


def test_tip_functions_leave_the_error_of_the_rings_round_the_tip(build) -> None:
    """It falls with every level, to that of cells which grow with the distance from the tip."""
    errors = np.array([error_of_mode_one(build, levels, is_tip=True) for levels in range(6)])
    assert (np.diff(errors) < 0.0).all()
    assert errors[0] < 0.1 * error_of_mode_one(build, 0)
    assert errors[-1] < 0.4 * errors[0]
