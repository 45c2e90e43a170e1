"""Points on the rims of elements: area and normals by the divergence theorem, the same points on both sides."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crackgrow.quadrature.rims import points_on_edges, rim_points
from crackgrow.ragged import Ragged
from tests.unit.cover_tables import areas

KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]


@pytest.mark.parametrize("support", [1.5, 1.75, 2.0, 2.5])
def test_rims_close_and_give_the_area_of_their_elements(build, support: float) -> None:
    cover = build.block((6, 5), [build.crack(KINKED)], support).cover
    rim = rim_points(cover)
    assert np.all(np.diff(rim.element) >= 0)
    np.testing.assert_array_equal(np.unique(rim.element), np.arange(cover.elements.n))
    for axis in range(2):
        closed = np.bincount(rim.element, rim.normals[:, axis], cover.elements.n)
        area = np.bincount(rim.element, rim.points[:, axis] * rim.normals[:, axis], cover.elements.n)
        np.testing.assert_allclose(closed, 0.0, atol=1e-13)
        np.testing.assert_allclose(area, areas(cover.lattice, cover.elements), atol=1e-13)


def test_neighbours_use_the_same_points_and_opposite_normals(build) -> None:
    """Points that only one element has lie on the outline."""
    sample = build.block((9, 8), [build.crack(KINKED)], 1.5)
    rim = rim_points(sample.cover)
    places, which, n = np.unique(rim.points, axis=0, return_inverse=True, return_counts=True)
    total = np.stack([np.bincount(which, normal) for normal in rim.normals.T], axis=1)
    assert (n == 2).sum() > 200
    np.testing.assert_array_equal(total[n == 2], 0.0)
    assert shapely.distance(sample.region.boundary, shapely.points(places[n == 1])).max() < 1e-9
    assert n.max() == 2


@pytest.mark.parametrize("distance", [0.0, 1e-6, 1e-3, 0.2])
def test_square_root_of_the_distance_from_a_tip_is_integrated_along_edges(build, distance: float) -> None:
    cover = build.block((6, 5), [build.crack(KINKED)], 2.0).cover
    tip = cover.tips[0].point
    ends = tip + np.array([[(-0.3, distance), (0.6, distance)], [(0.0, distance), (0.0, 0.7 + distance)]])
    if distance == 0.0:
        ends[0, 0] = tip
    first_tip = Ragged(np.array([0, 1, 2]), np.array([0, 0]))  # on both edges
    edge, points, lengths = points_on_edges(cover, ends, first_tip)
    root = np.sqrt(np.hypot(*(points - tip).T))
    fine = (np.arange(400_000) + 0.5) / 400_000
    for number, (start, end) in enumerate(ends):
        at = start + fine[:, None] * (end - start)
        exact = np.sqrt(np.hypot(*(at - tip).T)).mean() * np.hypot(*(end - start))
        assert lengths[edge == number] @ root[edge == number] == pytest.approx(exact, rel=1e-6)
