"""Errors from the difference of two meshes, and the cells that are refined for them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from crackgrow.accuracy.companion import (
    BOUND,
    Errors,
    Grading,
    Quantities,
    coarsened,
    errors_of,
    refined,
    unresolved_shear,
)
from crackgrow.arrays import Floats

ENDS = ((0, False), (0, True), (1, True))
HERE = Quantities(
    ENDS, np.array([[3.0, 0.0], [3.0, 4.0], [1.0, 0.0]]), np.zeros(3), np.array([5.0, -4.0, 1.0]),
    np.array([0.0, 0.4, 0.0]), np.zeros(3), np.array([0.1, 0.2, 0.3]), 2.0, np.array([[0.0, 2.0]]),
    np.array([[3.0, 4.0]]), {"K": 0.1, "slip": 1e-9, "reaction": 1e-9},
)  # fmt: skip
GRADING = Grading(nested=True)


def test_the_difference_of_a_crack_is_that_of_its_tip_where_it_is_largest() -> None:
    there = replace(
        HERE,
        K=HERE.K + np.array([[0.03, 0.04], [0.0, 0.0], [0.01, 0.0]]),
        T=HERE.T + np.array([0.1, -0.3, 0.2]),
        kinks=HERE.kinks + np.array([0.0, 0.05, 0.01]),
    )
    errors = errors_of(GRADING, HERE, there)
    assert pytest.approx((0.05, 0.05, 0.01)) == errors.K
    assert pytest.approx((0.5, 0.5, 0.2)) == errors.T  # its spread of 0.4 and the difference of 0.3, at the second tip
    assert errors.kinks == pytest.approx((0.05, 0.05, 0.01))
    assert (errors.largest, errors.estimate("K")) == (5.0, pytest.approx(0.05 / 5.0))
    assert errors.estimate_by_crack("K", 3) == pytest.approx([0.05 / 5.0, 0.01 / 5.0, 0.0])
    small = errors_of(GRADING, replace(HERE, small={**HERE.small, "K": 8.0}), there)
    assert small.estimate("K") == pytest.approx(0.05 / 8.0)


def test_the_spread_of_the_integral_and_shear_that_no_mesh_sees_are_added() -> None:
    noisy = replace(HERE, spread=np.array([0.0, 0.0, 0.3]), unresolved=np.array([0.0, 0.0, 1.2]))
    errors = errors_of(GRADING, noisy, replace(HERE, K=HERE.K + np.array([[0.0, 0.0], [0.0, 0.0], [0.4, 0.0]])))
    assert pytest.approx((0.0, 0.0, 0.5 + 1.2 / BOUND)) == errors.K


def test_directions_and_critical_loads_are_known_no_better_than_the_K_that_they_follow_from() -> None:
    there = replace(HERE, K=HERE.K + np.array([[0.0, 0.0], [0.0, 0.1], [0.02, 0.0]]), load_factor=2.0 + 1e-9)
    errors = errors_of(GRADING, HERE, there)
    assert errors.kinks == pytest.approx((0.1 / 3.0, 0.1 / 5.0, 0.02 / 1.0))
    assert errors.shares["load_factor"] == pytest.approx(0.1 / 5.0)
    assert errors_of(GRADING, HERE, replace(there, load_factor=2.0)).shares["load_factor"] == 0.0  # it was given


def test_tips_are_found_by_name_and_what_is_not_there_is_not_known() -> None:
    there = replace(HERE, ends=ENDS[1:], K=HERE.K[1:] + 0.1, kinks=HERE.kinks[1:])
    errors = errors_of(GRADING, HERE, there)
    assert math.isnan(errors.K[0])
    assert errors.K[1:] == pytest.approx((0.1 * math.sqrt(2.0),) * 2)


def test_goals_are_shares_of_their_largest_values_and_unknown_without_a_companion() -> None:
    there = replace(HERE, load_factor=2.1, jumps=np.array([[0.0, 1.9]]), forces=np.array([[3.0, 4.5]]))
    errors = errors_of(GRADING, HERE, there)
    assert [errors.estimate(goal) for goal in ("load_factor", "slip", "reaction")] == pytest.approx([0.05, 0.05, 0.1])
    small = replace(HERE, jumps=np.array([[0.0, 1e-3]]), small={**HERE.small, "slip": 0.5})
    assert errors_of(GRADING, small, replace(small, jumps=np.zeros((1, 2)))).estimate("slip") == pytest.approx(2e-3)
    nothing = replace(HERE, jumps=np.zeros((0, 2)))
    assert errors_of(GRADING, nothing, nothing).estimate("slip") == math.inf
    unknown = errors_of(GRADING, HERE, None)
    assert all(map(math.isnan, (*unknown.K, *unknown.kinks)))
    assert unknown.estimate("K") == unknown.estimate("slip") == math.inf


def test_a_tip_that_opens_before_the_first_contact_point_loses_its_shear() -> None:
    """All of it over the length a of K_I = p sqrt(8 a / pi), or up to the point."""
    y, p, c = 0.01, 4.0, 2.0
    a = 0.25 * y
    assert unresolved_shear(p * math.sqrt(8.0 * a / math.pi), y, p, c) == pytest.approx(
        c * math.sqrt(8.0 * a / math.pi)
    )
    assert unresolved_shear(1e9, y, p, c) == pytest.approx(c * math.sqrt(8.0 * y / math.pi))
    assert unresolved_shear(-1.0, y, p, c) == unresolved_shear(0.0, y, p, c) == 0.0


def off(*shares: float, grading: Grading = GRADING) -> Errors:
    """Errors whose estimates are such shares of the largest K, crack by crack."""
    ends = tuple((crack, True) for crack in range(len(shares)))
    return Errors(grading, ends, tuple(share for share in shares), 1.0)


def apart(n: int, distance: float = 1.0) -> list[Floats]:
    """Cracks of length 1, one above the other."""
    return [np.array([[0.0, distance * number], [1.0, distance * number]]) for number in range(n)]


def test_neighbours_are_refined_in_a_second_round_and_kept_with_a_crack_that_is_off() -> None:
    """In the first those alone that have no K to say so themselves."""
    now, lines = off(0.035, 0.009, 0.0), apart(3, 0.4)
    assert refined(now, None, 0.01, "K", lines, ()).cracks == (2, 0, 0)
    assert refined(now, off(0.07, 0.0, 0.0), 0.01, "K", lines, ()).cracks == (2, 2, 0)
    tipless = replace(now, ends=((0, True), (2, True)), K=(0.035, 0.0))
    assert refined(tipless, None, 0.01, "K", lines, ()).cracks == (2, 2, 0)
    begun = off(0.001, 0.02, 0.001, math.nan, grading=replace(GRADING, cracks=(2, 2, 2, 2)))
    assert coarsened(begun, 0.01, "K", [*apart(3, 0.2), *apart(5)[4:]], ()).cracks == (2, 2, 2, 2)
    assert coarsened(begun, 0.01, "K", apart(4), ()).cracks == (0, 2, 0, 2)
