"""Covers with cells of several sizes, and gathered tip functions: rigid motions, error at a tip."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from crackgrow.solid.rigid_modes import rigid_motions
from tests.unit.exact_fields import solved_under, true_error

Floats = NDArray[np.float64]
SIZE = (8, 7)
KINKED = [(2.2, 2.3), (4.1, 2.9), (4.6, 4.4)]
SHORT = [(6.1, 5.2), (6.4, 5.35)]
PLACES = [*KINKED, *SHORT, (8.5, 0.5)]


def graded(build, support: float, levels: int, cracked: bool = True):
    cracks = [build.crack(KINKED, name="kinked"), build.crack(SHORT, name="short")]
    return build.block(SIZE, cracks if cracked else [], support, levels, PLACES)


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


TIP = np.array([5.0, 4.0])
"""A corner of cells."""
END = np.array([9.3, 8.8])
"""Inside of a cell, with room for gathered functions."""


def error_of_mode_one(
    build, levels: int, tip: Floats = TIP, *, functions: str = "none", everywhere: bool = False
) -> tuple[float, int]:
    """Percent of the energy norm on a square whose left half is cracked, and the unknowns; tip functions are on
    patches, gathered, or there are none."""

    def mode_one(points: Floats) -> Floats:
        """Stress (n, 3) round the tip, for a K of 1."""
        x, y = (points - tip).T
        r, t = np.hypot(x, y), 0.5 * np.arctan2(y, x)
        terms = (1.0 - np.sin(t) * np.sin(3.0 * t), 1.0 + np.sin(t) * np.sin(3.0 * t), np.sin(t) * np.cos(3.0 * t))
        return np.asarray((np.cos(t) / np.sqrt(2.0 * np.pi * r) * terms).T)

    side, gathered = (8 if tip is TIP else 16), functions == "gathered"
    crack = build.crack([(0.5, tip[1]), tip], (False, functions != "none"), gathered=gathered)
    places = [(x, y) for x in range(1, side + 1) for y in range(1, side + 1)] if everywhere else [tip]
    upper, rings = (side + 0.5, side + 0.5), 3.0 if tip is TIP else 2.0
    sample = build.sample((0.5, 0.5), upper, [crack], support=2.0, levels=levels, places=places, rings=rings)
    assert functions == "none" or sample.cover.tips[0].carriers.gathered == gathered
    return true_error(sample, solved_under(sample, mode_one), mode_one), sample.cover.n_dofs


def test_the_error_at_a_tip_falls_by_the_square_root_of_two_a_level(build) -> None:
    """Without tip functions; it is that of a lattice whose cells are everywhere as small as the smallest."""
    errors = np.array([error_of_mode_one(build, levels)[0] for levels in range(7)])
    np.testing.assert_allclose(errors[1:-1] / errors[2:], np.sqrt(2.0), rtol=0.1)
    assert errors[2] == pytest.approx(error_of_mode_one(build, 2, everywhere=True)[0], rel=0.01)


def test_tip_functions_leave_the_error_of_the_rings_round_the_tip(build) -> None:
    """It falls with every level, to that of cells which grow with the distance from the tip."""
    errors = np.array([error_of_mode_one(build, levels, functions="on patches")[0] for levels in range(6)])
    assert (np.diff(errors) < 0.0).all()
    assert errors[0] < 0.1 * error_of_mode_one(build, 0)[0]
    assert errors[-1] < 0.4 * errors[0]


@pytest.mark.parametrize("levels", range(7))
def test_gathered_functions_are_as_good_as_those_on_every_patch(build, levels: int) -> None:
    """With a hundred unknowns less."""
    gathered, few = error_of_mode_one(build, levels, END, functions="gathered")
    on_patches, many = error_of_mode_one(build, levels, END, functions="on patches")
    assert many - few > 70
    assert gathered < 1.01 * on_patches
