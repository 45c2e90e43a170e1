"""Bodies with gathered tip functions: uniform stress, the solver, the error at a tip, K of exact solutions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from crackgrow.case.model import PointSupport
from crackgrow.cover.cover import build_cover
from crackgrow.solid.places import places_of_unknowns
from crackgrow.solid.stiffness import stiffness_after
from tests.properties.test_properties_cells import TIP, mode_one
from tests.properties.test_properties_patch_test import errors
from tests.unit.exact_fields import solved_under, true_error

Floats = NDArray[np.float64]
LONG = [(5.7, 7.2), (15.1, 7.2)]


@pytest.mark.parametrize(("support", "levels"), [(1.5, 0), (2.0, 0), (2.0, 3), (2.5, 2)])
def test_a_crack_along_the_only_stress_leaves_it_alone(build, support: float, levels: int) -> None:
    crack = build.crack(LONG, gathered=True)
    sample = build.block((22, 15), [crack], support, levels, LONG)
    assert any(tip.carriers.gathered for tip in sample.cover.tips)
    displacement, _ = errors(sample, (22, 15), 4, (1e-3, 0.0, 0.0))
    assert displacement < 1e-10


END = np.array([9.3, 8.8])


def round_the_end(points: Floats) -> Floats:
    """Stress (n, 3) round `END` with a crack on its left."""
    return mode_one(points - END + TIP)


def error_of_mode_one(build, levels: int, gathered: bool) -> tuple[float, int]:
    """Percent of the energy norm on a square of 16 x 16, and the unknowns."""
    crack = build.crack([(0.5, END[1]), END], (False, True), gathered=gathered)
    sample = build.sample((0.5, 0.5), (16.5, 16.5), [crack], support=2.0, levels=levels, places=[END])
    assert sample.cover.tips[0].carriers.gathered == gathered
    u = solved_under(sample, round_the_end)
    return true_error(sample, u, round_the_end), sample.cover.n_dofs


@pytest.mark.parametrize("levels", range(7))
def test_the_error_at_a_tip_is_no_larger_than_with_functions_on_every_patch(build, levels: int) -> None:
    """With a hundred unknowns less."""
    (gathered, few), (on_patches, many) = (error_of_mode_one(build, levels, mode) for mode in (True, False))
    assert many - few > 70
    assert gathered < 1.01 * on_patches


def test_the_direct_solver_knows_what_gathered_functions_are_coupled_to(build) -> None:
    """It leaves out all pairs of unknowns whose boxes do not overlap."""
    sample = build.block((22, 15), [build.crack(LONG, gathered=True)], 2.0, 2, LONG[1:])
    places, matrix = places_of_unknowns(sample.cover), sample.stiffness().tocoo()
    low = np.maximum(places.low[matrix.row], places.low[matrix.col])
    high = np.minimum(places.high[matrix.row], places.high[matrix.col])
    assert (low < high).all()
    corners = np.array([(0.5, 0.5), (22.5, 0.5)])
    held = [PointSupport("rock", corners[0], (0.0, 0.0)), PointSupport("rock", corners[1], (None, 0.0))]
    system, given = sample.system(held)
    loads = np.random.default_rng(0).normal(size=sample.cover.n_dofs)
    u, multipliers = system.solve(loads, given)
    left = matrix @ u + system.constraints.T @ multipliers - loads
    assert np.abs(left).max() < 1e-9 * np.abs(loads).max()


def test_a_step_of_growth_takes_over_what_it_may(build) -> None:
    """The old tip's functions vanish, the new one's appear; the matrix is that of a fresh assembly."""
    far = build.crack([(5.7, 22.2), (15.1, 22.9)], name="far", gathered=True)
    sample = build.block((22, 28), [build.crack(LONG, gathered=True), far], 2.0)
    first = stiffness_after(sample.cover, [sample.material], 3)
    grown = np.vstack([sample.cover.cracks[0].points, sample.cover.cracks[0].points[-1] + (1.6, 1.5)])
    cracks = [replace(sample.cover.cracks[0], points=grown), sample.cover.cracks[1]]
    cover = build_cover(sample.lattice, sample.cover.bodies, cracks)
    assert [tip.carriers.gathered for tip in cover.tips] == [True] * 4
    later, fresh = (stiffness_after(cover, [sample.material], 3, before) for before in (first, None))
    assert later.n_integrated < 0.8 * fresh.n_integrated
    assert abs(later.matrix.tocsc() - fresh.matrix.tocsc()).max() == 0.0
