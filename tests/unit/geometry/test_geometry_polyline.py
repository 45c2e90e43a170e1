"""Polylines: arc length, kinks, tip directions, the way out of a body."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crackgrow.geometry.polyline import arc_lengths, first_hit, kink_angles, segment_directions, tip_direction

BENT = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [0.0, 8.0]])


def test_arc_length_adds_up_from_the_start() -> None:
    np.testing.assert_allclose(arc_lengths(BENT), [0, 3, 7, 12], rtol=1e-15)


def test_arc_length_of_an_inscribed_polygon_converges_to_the_circle_with_order_two() -> None:
    errors = []
    for n in (20, 40):
        t = np.linspace(0, np.pi, n + 1)
        errors.append(np.pi - arc_lengths(np.stack([np.cos(t), np.sin(t)], axis=1))[-1])
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=1e-3)  # the next term is (pi / n)^2 / 80 smaller


def test_directions_are_unit_vectors_along_the_segments() -> None:
    np.testing.assert_allclose(segment_directions(BENT), [[1, 0], [0, 1], [-0.6, 0.8]], atol=1e-15)


def test_kink_to_the_left_is_positive() -> None:
    np.testing.assert_allclose(kink_angles(BENT), [np.pi / 2, np.arctan2(0.6, 0.8)], rtol=1e-14)


def test_kinks_change_sign_in_the_mirror_and_in_reverse() -> None:
    np.testing.assert_allclose(kink_angles(BENT * (1, -1)), -kink_angles(BENT), rtol=1e-14)
    np.testing.assert_allclose(kink_angles(BENT[::-1]), -kink_angles(BENT)[::-1], rtol=1e-14)


def test_kinks_do_not_change_under_rotation_shift_and_scale() -> None:
    rng = np.random.default_rng(4)
    points = np.cumsum(rng.uniform(-1, 1, (9, 2)), axis=0)
    c, s = np.cos(2.1), np.sin(2.1)
    moved = 1e-3 * points @ np.array([[c, s], [-s, c]]) + (5.0, -7.0)
    np.testing.assert_allclose(kink_angles(moved), kink_angles(points), atol=1e-10)  # shift 5e3 of the size: 1e-12


@pytest.mark.parametrize("angle", [-170.0, -70.0, 0.0, 1e-3, 45.0, 170.0])
def test_given_kink_comes_back(angle: float) -> None:
    a = np.radians(angle)
    points = np.array([[0, 0], [1, 0], [1 + np.cos(a), np.sin(a)]])
    np.testing.assert_allclose(np.degrees(kink_angles(points)), [angle], atol=1e-12)


def test_tips_point_away_from_the_polyline() -> None:
    np.testing.assert_allclose(tip_direction(BENT, at_end=True), [-0.6, 0.8], rtol=1e-15)
    np.testing.assert_allclose(tip_direction(BENT, at_end=False), [-1, 0], atol=1e-15)


def test_way_out_ends_on_the_first_boundary_it_meets() -> None:
    u_shape = shapely.Polygon([[0, 0], [6, 0], [6, 4], [4, 4], [4, 2], [2, 2], [2, 4], [0, 4]])
    out = first_hit(u_shape.boundary, np.array([1.0, 3.0]), np.array([7.0, 3.0]))
    np.testing.assert_allclose(out, [2.0, 3.0], rtol=1e-15)
    back = first_hit(u_shape.boundary, np.array([5.0, 3.0]), np.array([-1.0, 3.0]))
    np.testing.assert_allclose(back, [4.0, 3.0], rtol=1e-15)


def test_way_that_stays_inside_has_no_exit() -> None:
    assert first_hit(shapely.box(0, 0, 2, 2).boundary, np.array([0.5, 0.5]), np.array([1.5, 1.9])) is None


def test_way_that_ends_on_the_boundary_exits_there() -> None:
    out = first_hit(shapely.box(0, 0, 2, 2).boundary, np.array([0.5, 0.5]), np.array([1.0, 2.0]))
    np.testing.assert_allclose(out, [1.0, 2.0], rtol=1e-15)


def test_way_along_the_boundary_exits_where_it_first_meets_it() -> None:
    stepped = shapely.Polygon([[0, 0], [4, 0], [4, 2], [2, 2], [2, 1], [0, 1]])
    out = first_hit(stepped.boundary, np.array([1.0, 0.5]), np.array([3.0, 2.5]))
    np.testing.assert_allclose(out, [1.5, 1.0], rtol=1e-15)


def test_way_that_begins_on_the_line_meets_it_further_on_or_not_at_all() -> None:
    box = shapely.box(0, 0, 2, 2).boundary
    np.testing.assert_array_equal(first_hit(box, np.array([0.0, 1.0]), np.array([5.0, 1.0])), [2.0, 1.0])
    assert first_hit(box, np.array([0.0, 1.0]), np.array([1.0, 1.5])) is None
