"""The points of all elements: in them, on their rims, and singular functions round the tips."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from scipy.integrate import quad

from crackgrow.quadrature.elements import element_points, triangulate
from crackgrow.quadrature.rims import POINTS_PER_EDGE, points_on_edges, rim_points
from crackgrow.ragged import Ragged
from tests.unit.cover_tables import areas, tile_boxes

KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]
SUPPORTS = (1.5, 1.75, 2.0, 2.5)


@pytest.mark.parametrize("n", [2, 3, 4])
@pytest.mark.parametrize("support", SUPPORTS)
def test_points_lie_in_their_elements_and_weights_sum_to_the_areas(build, support: float, n: int) -> None:
    sample = build.block((6, 5), [build.crack(KINKED)], support)
    elements = sample.cover.elements
    points = element_points(sample.cover, n)
    assert elements.n - elements.n_whole > 20
    assert points.weights.min() > 0.0
    sums = np.bincount(points.element, points.weights, elements.n)
    np.testing.assert_allclose(sums, areas(sample.lattice, elements), rtol=1e-9)  # the arrangement's grid
    assert sums.sum() == pytest.approx(30.0, rel=1e-9)
    assert np.all(np.diff(points.element) >= 0)
    cut = points.element >= elements.n_whole
    polygons = elements.polygons[points.element[cut] - elements.n_whole]
    assert shapely.distance(polygons, shapely.points(points.points[cut])).max() < 1e-12


@pytest.mark.parametrize(("support", "levels"), [*((support, 0) for support in SUPPORTS), (2.0, 2), (1.5, 5)])
def test_rims_close_give_the_areas_and_are_shared_by_neighbours(build, support: float, levels: int) -> None:
    """By the divergence theorem; points that only one element has lie on the outline, among cells of any size."""
    sample = build.block((9, 8), [build.crack(KINKED)], support, levels, [KINKED[0], (6.2, 5.7)])
    cover, rim = sample.cover, rim_points(sample.cover)
    assert np.all(np.diff(rim.element) >= 0)
    for axis in range(2):
        closed = np.bincount(rim.element, rim.normals[:, axis], cover.elements.n)
        area = np.bincount(rim.element, rim.points[:, axis] * rim.normals[:, axis], cover.elements.n)
        np.testing.assert_allclose(closed, 0.0, atol=1e-13)
        np.testing.assert_allclose(area, areas(cover.lattice, cover.elements), atol=1e-13)
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
    edge, points, lengths = points_on_edges(cover, ends, first_tip, POINTS_PER_EDGE)
    root = np.sqrt(np.hypot(*(points - tip).T))
    fine = (np.arange(400_000) + 0.5) / 400_000
    for number, (start, end) in enumerate(ends):
        at = start + fine[:, None] * (end - start)
        exact = np.sqrt(np.hypot(*(at - tip).T)).mean() * np.hypot(*(end - start))
        assert lengths[edge == number] @ root[edge == number] == pytest.approx(exact, rel=1e-6)


def disc_free_integral(box: shapely.Polygon, tip: np.ndarray, power: float) -> float:
    """Integral of r^power over a convex region that holds the tip: integral of R(t)^(power + 2) / (power + 2)."""
    corners = np.array(box.exterior.coords)[:-1] - tip

    def radius(t: float) -> float:
        e = np.array([np.cos(t), np.sin(t)])
        sides = np.roll(corners, -1, axis=0) - corners
        normals = np.stack([sides[:, 1], -sides[:, 0]], axis=1)
        reach = np.sum(normals * corners, axis=1) / np.where(normals @ e > 1e-14, normals @ e, np.nan)
        return float(np.nanmin(reach))

    kinks = np.sort(np.arctan2(corners[:, 1], corners[:, 0]))
    pieces = zip(kinks, np.append(kinks[1:], kinks[0] + 2 * np.pi), strict=True)
    return sum(quad(lambda t: radius(t) ** (power + 2) / (power + 2), a, b, epsrel=1e-11)[0] for a, b in pieces)


TIPS = {
    "inside a cell": (4.3, 2.8),
    "near a lattice line": (4.3, 2.999),
    "very near a lattice line": (4.3, 3.0 - 1e-5),
    "in small triangles": (4.3, 3.0 - 1e-4),
    "on a lattice line": (4.3, 3.0),
    "on a node": (4.0, 3.0),
    "near a node": (4.001, 2.9995),
}


@pytest.mark.parametrize("levels", [0, 4, 8])
@pytest.mark.parametrize("place", TIPS)
def test_cells_round_a_tip_integrate_its_singularity(build, place: str, levels: int) -> None:
    """r^(-1/2) and r^(-1) over tiles round it by the rules for n = 3, whatever the place of the tip in its cell."""
    side, node = 0.5**levels, np.array(TIPS["on a node"])
    end = node + side * (np.array(TIPS[place]) - node)
    sample = build.block((6, 5), [build.crack([(0.5, 1.3), end], (False, True))], 1.5, levels, [end])
    tip = sample.cover.tips[0].point
    points = element_points(sample.cover, 3)
    close = np.abs(points.points - tip).max(axis=1) < 0.3 * side
    tiles = np.unique(sample.cover.elements.tile[points.element[close]])
    low, high = tile_boxes(sample.lattice, tiles)
    box = shapely.box(*low.min(axis=0), *high.max(axis=0))
    inside = shapely.contains_xy(box, points.points)
    weights, r = points.weights[inside], np.hypot(*(points.points[inside] - tip).T)
    assert weights.sum() == pytest.approx(box.area, rel=1e-4)
    assert weights @ r**-0.5 == pytest.approx(disc_free_integral(box, tip, -0.5), rel=1e-4)
    tolerance = 2e-6 if place == "in small triangles" else 1e-3
    assert weights @ r**-1.0 == pytest.approx(disc_free_integral(box, tip, -1.0), rel=tolerance)


def test_triangles_fill_polygons_with_holes_and_use_their_corners_only() -> None:
    frame = shapely.Polygon([[0, 0], [4, 0], [4, 4], [0, 4]], [[[1, 1], [1, 2], [2, 2], [2, 1]]])
    hook = shapely.Polygon([[5, 0], [8, 0], [8, 3], [7, 3], [7, 1], [5, 1]])
    corners, owner = triangulate(np.array([frame, hook]))
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    assert area.min() > 0.0
    np.testing.assert_allclose(np.bincount(owner, area), [15.0, 5.0], rtol=1e-14)
    known = {tuple(p) for p in shapely.get_coordinates([frame, hook])}
    assert {tuple(p) for p in corners.reshape(-1, 2)} == known


MIRRORED = {
    "across cells": [(1.7, 2.2), (4.6, 3.4)],
    "at 45 degrees, off the nodes": [(1.2, 1.7), (4.1, 4.6)],
    "a tip on a line of the lattice": [(1.7, 2.2), (4.0, 3.4)],
    "along a line of the lattice": [(1.7, 3.0), (4.6, 3.0)],
    "within a cell": [(3.2, 2.3), (3.8, 2.7)],
}


@pytest.mark.parametrize("path", MIRRORED)
@pytest.mark.parametrize("mirror", [(-1.0, 1.0), (1.0, -1.0)])
def test_points_of_the_mirrored_body_are_the_mirrored_points(build, path: str, mirror: tuple[float, float]) -> None:
    """Halves of right triangles have two longest sides, and rectangles four corners on a circle: rounding decides."""
    middle, found = np.array([3.5, 3.0]), []
    for way in (np.ones(2), np.array(mirror)):
        points = middle + (np.array(MIRRORED[path]) - middle) * way
        sample = build.block((6, 5), [build.crack(points)], 2.0)
        of = element_points(sample.cover, 3)
        places = middle + (sample.lattice.to_metres(of.points) - middle) * way
        found.append(np.column_stack([places, of.weights]))
    here, there = (shapely.points(points[:, :2]) for points in found)
    near, distance = shapely.STRtree(there).query_nearest(here, return_distance=True)
    assert len(here) == len(there)
    assert distance.max() < 1e-9
    assert np.abs(found[0][near[0], 2] - found[1][near[1], 2]).max() < 1e-9


@pytest.mark.parametrize("beside", [1e-9, -1e-9, 1e-7])
def test_a_crack_just_beside_a_lattice_line_takes_not_many_more_points_than_one_on_it(build, beside: float) -> None:
    """Its needles were cut into four as thin ones, each of them again: a million triangles."""
    counts = []
    for y in (2.0, 2.0 + beside):
        sample = build.block((6, 5), [build.crack([[1.3, y], [3.0 + beside, y]])], 2.0)
        counts.append(len(element_points(sample.cover, 3).points))
    assert counts[1] < 12 * counts[0]
