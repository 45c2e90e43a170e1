"""What contact can hold, by hand: a block on a slope, and one that tips over."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.limit import least_unbalanced

WEIGHT, LENGTH = 3.0, 2.0


def block_on_slope(angle: float, height: float, friction: float, cohesion: float = 0.0) -> tuple[float, np.ndarray]:
    """A block with its base of length 2 at two points; motions: up and along the slope, and rotation about the middle.

    Its weight acts at `height` over the base; `angle` (degrees) is that of the slope, down along the motion.
    """
    a = np.deg2rad(angle)
    gap = np.array([[1.0, 0.0, -1.0], [1.0, 0.0, 1.0]])
    slip = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    pull = WEIGHT * np.array([-np.cos(a), np.sin(a), -height * np.sin(a)])
    weights = np.full(2, 0.5 * LENGTH)
    return least_unbalanced(gap, slip, weights, pull, WEIGHT, np.full(2, friction), np.full(2, cohesion))


@pytest.mark.parametrize("angle", [5.0, 20.0, 40.0])
def test_a_block_slides_where_the_slope_is_steeper_than_friction(angle: float) -> None:
    limit, a = np.tan(np.deg2rad(angle)), np.deg2rad(angle)
    assert block_on_slope(angle, 0.1, 1.001 * limit)[0] == pytest.approx(0.0, abs=1e-9)
    left, way = block_on_slope(angle, 0.1, 0.9 * limit)
    assert left == pytest.approx(0.1 * np.sin(a), rel=1e-6)  # of the weight: what friction lacks
    assert np.argmax(np.abs(way)) == 1  # it goes along the slope


def test_cohesion_holds_what_friction_does_not() -> None:
    lacking = WEIGHT * np.sin(np.deg2rad(20.0)) / LENGTH
    assert block_on_slope(20.0, 0.1, 0.0, 1.001 * lacking)[0] == pytest.approx(0.0, abs=1e-9)
    assert block_on_slope(20.0, 0.1, 0.0, 0.9 * lacking)[0] > 0.01


def test_a_tall_block_tips_over_however_much_friction() -> None:
    assert block_on_slope(30.0, 1.7, 5.0)[0] == pytest.approx(0.0, abs=1e-9)  # up to 1 / tan(30 degrees) = 1.73
    assert block_on_slope(30.0, 1.8, 5.0)[0] > 0.01


def test_faces_do_not_pull() -> None:
    assert block_on_slope(180.0, 0.0, 1.0)[0] == pytest.approx(1.0)  # upside down it falls
