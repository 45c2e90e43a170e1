"""Distances of polylines: by hand, and against sampled ones."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from crackgrow.geometry.polyline import arc_lengths
from crackgrow.study.distance import RESOLUTION, between, extent, farthest, frechet, nearest, overhang

Floats = NDArray[np.float64]
SAMPLE = 0.05  # between the samples of the discrete Frechet distance, which is at most this much larger


def line(*points: tuple[float, float]) -> Floats:
    return np.array(points, dtype=float)


def discrete_frechet(p: Floats, q: Floats) -> float:
    """Frechet distance of point sequences by its recursion (that of GEOS 3.14 gives values that are too large)."""
    apart = np.hypot(*(p[:, None] - q[None]).transpose(2, 0, 1))
    row = np.maximum.accumulate(apart[0])
    for distances in apart[1:]:
        above, row = row, np.empty_like(row)
        row[0] = max(above[0], distances[0])
        for j in range(1, len(row)):
            row[j] = max(min(above[j], above[j - 1], row[j - 1]), distances[j])
    return float(row[-1])


def random_lines(seed: int) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(seed)
    a = np.cumsum(rng.normal(size=(rng.integers(2, 10), 2)), axis=0)
    if seed % 2:
        return a, a + 0.1 * rng.normal(size=a.shape)
    return a, np.cumsum(rng.normal(size=(rng.integers(2, 10), 2)), axis=0)


POSTS = line((0, 0), (0, -5), (6, -5), (6, 0))
SHORT, LONG = line((0, 0), (1, 0)), line((0, 0), (5, 0))
POINT, ABOVE = line((0, 0)), line((0, 1), (0, 4))


@pytest.mark.parametrize(("a", "b", "distance", "s"), [
    (line((0, 0), (4, 0)), line((0, 3), (1, 3), (4, 3)), 3.0, None),
    (line((0, 4), (6, 4)), POSTS, 5.0, 3.0),  # between two posts, at no vertex of either: on the bisector
    (SHORT, LONG, 0.0, None),  # one-sided
    (LONG, SHORT, 4.0, 5.0),
    (POINT, ABOVE, 1.0, 0.0),
    (ABOVE, POINT, 4.0, 3.0),
])  # fmt: skip
def test_the_farthest_point_of_one_line_from_another(a: Floats, b: Floats, distance: float, s: float | None) -> None:
    found = farthest(a, b)
    assert found.distance == pytest.approx(distance, abs=6 * RESOLUTION)
    assert s is None or found.s == pytest.approx(s, abs=1e-5)
    (again,), (near_s,) = nearest(np.column_stack([np.interp(found.s, arc_lengths(a), x) for x in a.T]), b)
    assert (again, near_s) == (found.distance, found.near_s)


@pytest.mark.parametrize("offset", [0.0, 1e5])
def test_sampling_of_the_same_line_changes_nothing(offset: float) -> None:
    a = line((0, 0), (1, 2), (4, 2)) + offset
    b = shapely.get_coordinates(shapely.segmentize(shapely.LineString(a), 0.17))
    size = 4 * RESOLUTION
    assert max(farthest(a, b).distance, farthest(b, a).distance, frechet(a, b)) < size + 1e-15 * offset
    assert (farthest(a, a).distance, frechet(a, a)) == (0.0, 0.0)


def test_frechet_sees_the_order() -> None:
    """A line that runs back on itself is near everywhere, but not in the order of a walk: half of the way back."""
    there = line((0, 0), (10, 0))
    back = line((0, 0), (7, 0), (3, 0), (10, 0))
    assert max(farthest(there, back).distance, farthest(back, there).distance) == 0.0
    assert frechet(there, back) == pytest.approx(2.0, abs=10 * RESOLUTION)
    assert frechet(there, there[::-1]) == pytest.approx(10.0)
    assert frechet(POINT, ABOVE) == 4.0


@pytest.mark.parametrize("seed", range(30))
def test_distances_against_sampled_ones(seed: int) -> None:
    a, b = random_lines(seed)
    fine = RESOLUTION * extent(a, b) * 2
    samples_a, samples_b = (
        shapely.get_coordinates(shapely.segmentize(shapely.LineString(points), SAMPLE)) for points in (a, b)
    )
    hausdorff = max(farthest(a, b).distance, farthest(b, a).distance)
    sampled = max(nearest(samples_a, b)[0].max(), nearest(samples_b, a)[0].max())
    assert sampled - fine <= hausdorff <= sampled + SAMPLE / 2
    leash = frechet(a, b)
    assert leash - fine <= discrete_frechet(samples_a, samples_b) <= leash + SAMPLE
    assert leash >= hausdorff
    assert frechet(b, a) == pytest.approx(leash, abs=2 * fine)


def test_between_keeps_the_vertices_inside() -> None:
    bent = line((0, 0), (2, 0), (2, 2))
    np.testing.assert_allclose(between(bent, 1, 3), [[1, 0], [2, 0], [2, 1]])
    np.testing.assert_allclose(between(bent, 3, 1), [[2, 1], [2, 0], [1, 0]])
    np.testing.assert_array_equal(between(bent, 0, 4), bent)


def test_overhang_begins_beside_the_tip() -> None:
    short = line((0, 0), (2, 0))
    assert overhang(line((0, 1), (5, 1)), short, at_both=False) == pytest.approx(2.0, abs=1e-6)
    assert overhang(short, line((0, 1), (5, 1)), at_both=False) == 2.0
    assert overhang(line((3, 1), (5, 1)), short, at_both=False) == 0.0
    assert overhang(line((-3, 1), (-1, 1)), short, at_both=True) == 0.0
