"""Tips: the angle jumps by two pi on the crack; where the tip functions fade out."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.cover.tips import crack_angle, seen_from_tip, tip_angle

KINKED = np.array([[4.0, 3.0], [3.2, 2.9], [2.6, 2.3], [1.6, 2.5]])
"""Seen from the tip; every circle round it meets the crack once."""

HAND = np.array([[0.3, -0.2], [0.1, 0.2], [-0.5, 0.4]])


def directions(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    along = np.diff(points, axis=0)
    along /= np.hypot(*along.T)[:, None]
    return along, np.stack([-along[:, 1], along[:, 0]], axis=1)


@pytest.mark.parametrize("turn", np.linspace(0, 2 * np.pi, 9)[:-1])
def test_angle_on_the_faces_of_a_straight_crack(turn: float) -> None:
    """Outward direction e: the face on the left of e has +pi, the other -pi; straight ahead is 0."""
    e = np.array([np.cos(turn), np.sin(turn)])
    left = np.array([-e[1], e[0]])
    point = np.array([0.7, -0.3])
    tip = seen_from_tip(np.array([point, point - 3 * e]), 10.0, ends_inside=False)
    points = point + np.stack([-e, -e, e, left, -left])
    reference = points + 1e-2 * np.stack([left, -left, left, left, -left])
    r, t = tip_angle(tip, points, reference)
    np.testing.assert_allclose(r, 1.0, rtol=1e-14)
    np.testing.assert_allclose(t, [np.pi, -np.pi, 0, np.pi / 2, -np.pi / 2], atol=1e-14)


@pytest.mark.parametrize("points", [KINKED, HAND])
def test_angle_jumps_by_two_pi_across_the_crack(points: np.ndarray) -> None:
    """It is pi on the left of the last segment; beyond, that at which the crack lies there."""
    tip = seen_from_tip(points, 1.0, ends_inside=False)
    along, left = directions(points)
    share = np.linspace(0.05, 0.95, 19)[:, None]
    for k in range(len(along)):
        on = points[k] + share * (points[k + 1] - points[k])
        # from the tip on, the left of the crack's direction is the side of t near -pi
        _, low = tip_angle(tip, on, on + 1e-7 * left[k])
        _, high = tip_angle(tip, on, on - 1e-7 * left[k])
        np.testing.assert_allclose(high - low, 2 * np.pi, rtol=1e-14)
        local = (on - points[0]) @ tip.rotation.T
        true = np.mod(np.arctan2(local[:, 1], local[:, 0]), 2 * np.pi) if k else np.pi
        np.testing.assert_allclose(high, true, atol=1e-12)
        np.testing.assert_allclose(crack_angle(tip, np.hypot(*local.T)), true, atol=1e-12)


BACK = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 0.5], [-3.0, 0.5]])
"""The second segment comes nearer to the tip again: the angle is not known beyond its start."""
CORNER = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]])
LENGTH = float(np.hypot(*(KINKED[-1] - KINKED[0])))


@pytest.mark.parametrize(
    ("points", "reach", "ends_inside", "fade"),
    [
        (KINKED, 5.0, True, LENGTH),
        (KINKED, 0.9 * LENGTH, True, np.inf),
        (KINKED, 5.0, False, np.inf),
        (BACK, 5.0, False, 2.0),
        (BACK, 1.9, False, np.inf),
        (CORNER, 5.0, False, np.inf),
        (CORNER, 5.0, True, np.sqrt(5.0)),
    ],
)
def test_tip_functions_fade_within_reach_at_the_other_tip_and_where_the_crack_turns_back(
    points: np.ndarray, reach: float, ends_inside: bool, fade: float
) -> None:
    tip = seen_from_tip(points, reach, ends_inside)
    assert tip.fade == pytest.approx(fade)
    assert points is not BACK or reach < 2.0 or tip.radii.tolist() == [0.0, 2.0]
