"""The planar arrangement: faces, edges, and vertices that are shared exactly."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crackgrow.geometry.arrangement import Rings, edges_between, faces_of, on_grid, ring_vertices, vertex_ids
from crackgrow.geometry.tolerance import GRID

FRAME = [[0, 0], [4, 0], [4, 3], [0, 3], [0, 0]]


def arrangement(*parts: list[list[float]]):
    polygons = faces_of([shapely.MultiLineString(list(parts))])[0]
    points, end, face = ring_vertices(polygons)
    ids = vertex_ids(points)
    return polygons, points, ids, edges_between(Rings(ids, ids[end], face), len(points))


def test_random_lines_leave_no_gap_and_no_overlap_and_share_their_vertices_exactly() -> None:
    """Euler: faces = edges - vertices + 1; the areas sum to the frame's; vertices lie on the grid."""
    rng = np.random.default_rng(1)
    frame = shapely.Polygon(FRAME)
    clipped = [shapely.intersection(shapely.LineString(rng.uniform(-1, 5, (2, 2))), frame) for _ in range(12)]
    parts = [shapely.get_coordinates(line).tolist() for line in clipped if line.length > 0.0]
    polygons, points, ids, edges = arrangement(FRAME, *parts)
    assert shapely.area(polygons).sum() == pytest.approx(12.0, rel=1e-8)  # snapping moves the rim by 1e-9
    assert len(polygons) == len(edges.a) - len(np.unique(ids)) + 1
    np.testing.assert_array_equal(points / GRID, np.rint(points / GRID))
    assert len(np.unique(points, axis=0)) == len(np.unique(ids)) == len(np.unique(np.c_[points, ids], axis=0))


def test_edges_pair_the_face_on_the_left_with_the_face_on_the_right() -> None:
    polygons, points, ids, edges = arrangement(FRAME, [[0, 0], [4, 3]], [[1, 0], [1, 3]])
    place = np.empty((ids.max() + 1, 2))
    place[ids] = points
    a, b = place[edges.a], place[edges.b]
    normal = np.stack([a[:, 1] - b[:, 1], b[:, 0] - a[:, 0]], axis=1)
    normal /= np.hypot(*normal.T)[:, None]
    middle = 0.5 * (a + b)
    assert shapely.contains_xy(polygons[edges.left], middle + 1e-3 * normal).all()
    inner = edges.right >= 0
    assert shapely.contains_xy(polygons[edges.right[inner]], (middle - 1e-3 * normal)[inner]).all()
    outside = (middle - 1e-3 * normal)[~inner]
    assert not shapely.contains_xy(shapely.Polygon(FRAME), outside).any()
    assert np.hypot(*(b - a)[~inner].T).sum() == pytest.approx(14.0, rel=1e-9)
    for start, end in ((edges.a, edges.b), (edges.b, edges.a)):
        np.testing.assert_array_equal(edges.between(start, end), np.arange(len(edges.a)))
    corners = np.array([np.flatnonzero((place == corner).all(axis=1))[0] for corner in ((0, 0), (4, 3), (0, 3))])
    assert edges.between(np.append(corners[:2], -1), corners[[1, 2, 2]]).tolist() == [-1, -1, -1]


@pytest.mark.parametrize("offset", [1e-12, -1e-12, 1e-10])
def test_lines_closer_than_the_grid_become_one(offset: float) -> None:
    polygons, _, ids, _ = arrangement(FRAME, [[0, 1], [4, 1]], [[0, 1 + offset], [4, 1 + offset]])
    np.testing.assert_array_equal(np.sort(shapely.area(polygons)), [4.0, 8.0])
    assert len(np.unique(ids)) == 6


def test_rounding_to_the_grid_moves_by_half_a_step_at_most_and_keeps_integers() -> None:
    points = np.random.default_rng(2).uniform(-50, 50, (1000, 2))
    assert np.abs(on_grid(points) - points).max() <= 0.5 * GRID
    np.testing.assert_array_equal(on_grid(np.rint(points)), np.rint(points))
    np.testing.assert_array_equal(on_grid(on_grid(points)), on_grid(points))
