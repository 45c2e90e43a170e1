"""Rules that are exact to their degree, pieces of lines, and the points of all elements, on rims and round tips."""

from __future__ import annotations

from math import factorial

import numpy as np
import pytest
import shapely
from scipy.integrate import quad

from crackgrow.quadrature.elements import element_points, triangulate
from crackgrow.quadrature.rims import rim_points
from crackgrow.quadrature.rules import gauss, on_edges, on_tip_triangles, on_triangles, square, triangle
from crackgrow.quadrature.subdivision import MOST_LEVELS, subdivided
from tests.unit.exact_fields import areas, tile_boxes

POINTS = (1, 2, 3, 4, 6)


@pytest.mark.parametrize("n", POINTS)
def test_gauss_rules_of_lines_and_squares_are_exact_to_their_degree_and_no_further(n: int) -> None:
    (x, w), (points, weights), (position, lengths) = gauss(n), square(n), on_edges(*np.zeros((2, 3), dtype=bool), n)
    for i in range(2 * n):
        assert w @ x**i == pytest.approx(1 / (i + 1), rel=1e-13)
        np.testing.assert_allclose(np.sum(lengths * position**i, axis=1), np.full(3, 1 / (i + 1)), rtol=1e-13)
        for j in range(2 * n):
            value = weights @ (points[:, 0] ** i * points[:, 1] ** j)
            assert value == pytest.approx(1 / ((i + 1) * (j + 1)), rel=1e-13)
    # error of the degree 2 n: (n!)^4 / ((2 n + 1) (2 n)!^2)
    error = factorial(n) ** 4 / ((2 * n + 1) * factorial(2 * n) ** 2)
    for values, weight in ((x, w), (points[:, 0], weights), (points[:, 1], weights)):
        assert 1 / (2 * n + 1) - weight @ values ** (2 * n) == pytest.approx(error, rel=1e-5)


@pytest.mark.parametrize("n", POINTS)
def test_triangle_is_exact_to_its_degree_and_no_further(n: int) -> None:
    points, w = triangle(n)

    def error(i: int, j: int) -> float:
        exact = factorial(i) * factorial(j) / factorial(i + j + 2)
        return abs(w @ (points[:, 0] ** i * points[:, 1] ** j) / exact - 1)

    assert max(error(i, d - i) for d in range(2 * n) for i in range(d + 1)) < 1e-12
    assert max(error(i, 2 * n - i) for i in range(2 * n + 1)) > 1e-6
    assert points.min() > 0.0
    assert points.sum(axis=1).max() < 1.0


def test_mapped_triangles_keep_area_and_degree_in_both_orientations() -> None:
    corners = np.array([[[0.2, 0.1], [1.3, 0.4], [0.6, 1.7]]])
    for given in (corners, corners[:, ::-1]):
        points, w = on_triangles(given, 2)
        assert w.sum() == pytest.approx(0.5 * (1.1 * 1.6 - 0.3 * 0.4), rel=1e-14)
        # second moment of a triangle: area / 12 * (9 mean^2 + sum of squares)
        x = corners[0, :, 0]
        exact = w.sum() / 12 * (9 * x.mean() ** 2 + np.sum(x**2))
        assert w[0] @ points[0, :, 0] ** 2 == pytest.approx(exact, rel=1e-14)


def tip_integral(corners: np.ndarray, power: float, angular) -> float:
    """Integral of r^power angular(t), by polar coordinates and adaptive quadrature along the far side's angle."""
    tip, a, b = corners
    unit = (b - a) / np.hypot(*(b - a))
    normal = np.array([unit[1], -unit[0]])
    height = (a - tip) @ normal
    foot = np.arctan2(*(np.sign(height) * normal)[::-1])
    low, high = (np.arctan2((p - tip) @ unit, abs(height)) for p in (a, b))
    sense = np.sign(height)  # whether the angle grows along the side
    exact, _ = quad(
        lambda t: (abs(height) / np.cos(t)) ** (power + 2) / (power + 2) * angular(foot + sense * t),
        low, high, epsabs=0, epsrel=1e-12, limit=400,
    )  # fmt: skip
    return exact


TRIANGLES = {
    "regular": [[0.3, 0.2], [1.3, 0.1], [0.9, 1.1]],
    "clockwise": [[0.3, 0.2], [0.9, 1.1], [1.3, 0.1]],
    "slender": [[0.0, 0.0], [1.0, 0.0], [1.0, 0.02]],
    "far side at 1e-2": [[0.0, 0.0], [-0.4, -0.01], [0.6, -0.01]],
    "far side at 1e-4": [[0.0, 0.0], [-0.4, -1e-4], [0.6, -1e-4]],
    "foot outside": [[0.0, 0.0], [0.1, 0.05], [1.0, 0.05]],
}


def angular(t: np.ndarray) -> np.ndarray:
    return 1.2 + np.cos(t) + 0.3 * np.sin(2 * t)


def tip_rule(name: str, power: float, n: int) -> tuple[float, float]:
    """Value by the rule, and error, for r^power times the smooth function of the angle."""
    corners = np.array(TRIANGLES[name], dtype=float)
    points, w = on_tip_triangles(corners[None], n)
    local = points[0] - corners[0]
    value = w[0] @ (np.hypot(*local.T) ** power * angular(np.arctan2(local[:, 1], local[:, 0])))
    return value, value - tip_integral(corners, power, angular)


@pytest.mark.parametrize("power", [-1.0, -0.5, 0.0, 0.5])
@pytest.mark.parametrize("name", TRIANGLES)
def test_tip_rule_integrates_powers_of_the_distance_with_smooth_angles(name: str, power: float) -> None:
    """It converges the slower the closer the far side; six points suffice relative to the disc of the same size."""
    value, error = tip_rule(name, power, 32)
    assert abs(error) < {"far side at 1e-2": 1e-8, "far side at 1e-4": 1e-4}.get(name, 1e-12) * value
    assert power > 0.0 or abs(tip_rule(name, power, 6)[1]) < 2e-4 * 2 * np.pi / (power + 2)


@pytest.mark.parametrize("n", [2, 3, 5])
def test_edges_with_a_tip_are_exact_for_half_powers_to_their_degree_and_no_further(n: int) -> None:
    at_start, at_end = np.array([True, False, False]), np.array([False, True, False])
    position, w = on_edges(at_start, at_end, n)
    distance = np.stack([position[0], 1 - position[1]])
    for k in range(-1, 2 * n - 1):
        np.testing.assert_allclose(np.sum(w[:2] * distance ** (k / 2), axis=1), 1 / (k / 2 + 1), rtol=1e-13)
    k = 2 * n - 1
    assert np.abs(np.sum(w[:2] * distance ** (k / 2), axis=1) * (k / 2 + 1) - 1).min() > 1e-8
    np.testing.assert_allclose(w[2], gauss(n)[1], rtol=1e-15)


def test_edge_between_two_tips_integrates_the_opening_of_a_crack() -> None:
    """sqrt(x (1 - x)) -> pi / 8, and its inverse, the gradient -> pi; the inverse is exact with one point."""
    both = np.array([True])
    for n, tolerance in ((6, 1e-6), (12, 1e-13)):
        position, w = on_edges(both, both, n)
        root = np.sqrt(position * (1 - position))
        assert np.sum(w * root) == pytest.approx(np.pi / 8, rel=tolerance)
        assert np.sum(w / root) == pytest.approx(np.pi, rel=1e-13)


ENDS = np.array([[[0.0, 0.0], [3.0, 4.0]], [[3.0, 4.0], [3.0, 6.0]]])  # 5 and 2 long


def test_what_the_points_integrate_is_not_cut() -> None:
    line, limits = subdivided(ENDS, lambda at, line: np.stack([at[:, 0] ** 7, 1.0 + line], axis=1))
    assert line.tolist() == [0, 1]
    assert limits.tolist() == [[0.0, 1.0], [0.0, 1.0]]


def test_no_singularity_is_followed_for_ever_and_pieces_follow_each_other() -> None:
    line, limits = subdivided(ENDS, lambda at, _: (1.0 / np.abs(at[:, 1] - 5.0 + 1e-9))[:, None])
    assert np.diff(limits, axis=1).min() >= 0.5**MOST_LEVELS
    assert len(line) < 200
    assert np.all(np.diff(line) >= 0)
    np.testing.assert_array_equal(limits[1:, 0], np.where(np.diff(line) == 0, limits[:-1, 1], 0.0))


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


@pytest.mark.parametrize("beside", [1e-9, -1e-9, 1e-7])
def test_a_crack_just_beside_a_lattice_line_takes_not_many_more_points_than_one_on_it(build, beside: float) -> None:
    """Its needles were cut into four as thin ones, each of them again: a million triangles."""
    counts = []
    for y in (2.0, 2.0 + beside):
        sample = build.block((6, 5), [build.crack([[1.3, y], [3.0 + beside, y]])], 2.0)
        counts.append(len(element_points(sample.cover, 3).points))
    assert counts[1] < 12 * counts[0]
