"""Tips: the angle jumps by two pi on the crack; where their functions fade out, and which are gathered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.cover.cover import build_cover
from crackgrow.cover.gathered import RADIUS, STRAIGHT
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


SIZE = (24, 20)
CRACK = [(7.3, 10.2), (16.4, 11.4)]
"""Its tips have room for each other, and to the outline of a body of `SIZE`."""


def test_a_gathered_tip_has_three_carriers_whatever_patches_there_are(build) -> None:
    """One, x and y from the tip, faded out; over all patches within R, on both sides of the crack."""
    cover = build.block(SIZE, [build.crack(CRACK, gathered=True)], 2.0).cover
    assert cover.n_functions == len(cover.patches.nodes) + 2 * 4 * 3
    for tip in cover.tips:
        assert tip.carriers.n == 3
        off = cover.patches.nodes - tip.point
        near = np.flatnonzero(np.hypot(*off.T) < RADIUS)
        chi = (1.0 - (np.hypot(*off[near].T) / RADIUS) ** 4) ** 2
        np.testing.assert_array_equal(tip.patches.reshape(3, -1), [near] * 3)
        np.testing.assert_allclose(tip.carriers.shares.reshape(3, -1), chi * [np.ones(len(near)), *off[near].T])
        nodes = cover.patches.nodes[near]
        assert len(np.unique(nodes, axis=0)) < len(nodes)  # the crack cuts some of them in two


def test_functions_are_numbered_without_gaps_also_where_only_some_are_gathered(build) -> None:
    one, other = build.crack(CRACK, gathered=True), build.crack([(4.2, 3.1), (14.8, 3.9)], name="other")
    cover = build.block(SIZE, [one, other], 2.0).cover
    assert [tip.carriers.gathered for tip in cover.tips] == [True, True, False, False]
    firsts = np.unique(np.concatenate([tip.functions for tip in cover.tips]))
    np.testing.assert_array_equal(firsts, np.arange(len(cover.patches.nodes), cover.n_functions, 4))
    seen = cover.functions_on(np.arange(cover.elements.n)).values
    np.testing.assert_array_equal(np.unique(seen), np.arange(cover.n_functions))


def gathered_at(build, *cracks: list, levels: int = 0, places=(), size=SIZE) -> list[bool]:
    """Whether the functions of each tip are gathered."""
    lines = [build.crack(points, name=f"crack {k}", gathered=True) for k, points in enumerate(cracks)]
    sample = build.block(size, lines, 2.0, levels, places)
    return [tip.carriers.gathered for tip in sample.cover.tips]


@pytest.mark.parametrize(("share", "room"), [(0.95, False), (1.05, True)])
def test_functions_are_gathered_where_nothing_else_is_within_the_radius(build, share: float, room: bool) -> None:
    """Nor a kink within the length that must be straight, nor the crack's other end where functions are still seen."""
    away = share * RADIUS
    ahead, beside = [(16.4 + away, 8.0), (16.4 + away, 15.0)], [(12.0, 11.4 + away), (20.0, 11.4 + away)]
    assert gathered_at(build, CRACK, ahead, size=(40, 20))[:2] == [True, room]
    assert gathered_at(build, CRACK, beside, size=(24, 30))[:2] == [True, room]
    assert gathered_at(build, [(14.5 - away, 10.2), (24.5 - away, 10.4)]) == [True, room]  # the outline is at 24.5
    assert gathered_at(build, [*CRACK, (16.4, 11.4 + share * STRAIGHT)]) == [True, room]
    length = 8.5 if room else 7.5  # the radius and half the diagonal of a patch
    assert gathered_at(build, [(7.3, 10.2), (7.3 + length, 10.2)]) == [room, room]
    from_side = build.crack([(0.5, 10.2), (0.5 + length, 10.2)], (False, True), gathered=True)
    assert build.block(SIZE, [from_side], 2.0).cover.tips[0].carriers.gathered is room


def test_the_radius_goes_by_the_cells_at_the_tip_and_a_crack_that_turns_back_has_none(build) -> None:
    beside = [(14.0, 13.4), (20.0, 13.4)]
    assert gathered_at(build, CRACK, beside)[1] is False
    assert gathered_at(build, CRACK, beside, levels=2, places=[CRACK[1]])[1] is True
    assert gathered_at(build, [(16.0, 14.2), (13.0, 12.2), (8.0, 11.4), (15.0, 10.2)])[1] is False


def test_without_the_wish_nothing_is_gathered_and_with_it_patches_stay_as_they_are(build) -> None:
    sample = build.block(SIZE, [build.crack(CRACK)], 2.0)
    one = sample.cover
    other = build_cover(sample.lattice, one.bodies, [replace(one.cracks[0], gathered=True)])
    assert not any(tip.carriers.gathered for tip in one.tips)
    np.testing.assert_array_equal(one.patches.nodes, other.patches.nodes)
    np.testing.assert_array_equal(one.patches.of_element.values, other.patches.of_element.values)
