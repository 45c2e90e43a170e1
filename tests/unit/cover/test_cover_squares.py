"""Squares are found as by looking at each of them; cells are divided where that is needed and not else."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.cover.refinement import MOST_LEVELS, Focus, balanced, refined
from crackgrow.cover.squares import QUANTA, Squares, quarters_of, squares_of
from tests.unit.cover.graded import boxes, graded

LEVELS = (0, 1, 3, 6)


def holders(squares: Squares, places: np.ndarray) -> np.ndarray:
    """The square (m,) that holds each of `places` (m, 2) or lies above and right of it, -1 for none."""
    low, high = boxes(squares)
    inside = ((low <= places[:, None]) & (places[:, None] < high)).all(axis=2)
    assert inside.sum(axis=1).max() <= 1
    return np.where(inside.any(axis=1), inside.argmax(axis=1), -1)


@pytest.mark.parametrize("levels", LEVELS)
def test_places_are_found_as_by_looking_at_each_square(levels: int) -> None:
    lattice = graded(levels, levels)
    squares, rng = lattice.cells, np.random.default_rng(levels)
    corners = np.concatenate(boxes(squares))
    places = np.concatenate([rng.integers(-QUANTA, 11 * QUANTA, (300, 2)), corners, corners - 1, corners - (0, 1)])
    np.testing.assert_array_equal(squares.at(places), holders(squares, places))


@pytest.mark.parametrize("levels", LEVELS)
def test_squares_round_points_are_all_that_touch_them(levels: int) -> None:
    squares, rng = graded(levels, levels).cells, np.random.default_rng(levels)
    low, high = (corners / QUANTA for corners in boxes(squares))
    on_rims = rng.permutation(np.stack([low[:, 0], 0.5 * (low + high)[:, 1]], axis=1))[:100]
    points = np.concatenate([rng.uniform(0.0, 10.0, (200, 2)), rng.permutation(low)[:200], on_rims])
    for point, around in zip(points, squares.around(points), strict=True):
        touching = np.flatnonzero(((low <= point) & (point <= high)).all(axis=1))
        assert set(around[around >= 0]) == set(touching)


@pytest.mark.parametrize("levels", LEVELS)
def test_squares_within_larger_ones(levels: int) -> None:
    squares = graded(levels, levels).cells
    low, high = boxes(squares)
    for part in range(-1, levels + 1):
        size = int(QUANTA / 2.0**part)
        asked = size * np.random.default_rng(part + 1).integers(-1, 11 * QUANTA // size, (40, 2))
        found = squares.within(asked, np.full(len(asked), size))
        for k, corner in enumerate(asked):
            inside = np.flatnonzero(((corner <= low) & (high <= corner + size)).all(axis=1))
            np.testing.assert_array_equal(np.sort(found.of(k)), inside)


def touching(squares: Squares) -> np.ndarray:
    """Which squares touch each other, (n, n)."""
    low, high = boxes(squares)
    return np.asarray(((low[:, None] <= high) & (low <= high[:, None])).all(axis=2))


def area(squares: Squares) -> int:
    return int((squares.size**2).sum())


@pytest.mark.parametrize("levels", LEVELS)
@pytest.mark.parametrize("rings", [2.0, 3.0])
def test_no_cell_is_more_than_twice_as_large_as_one_that_it_touches(levels: int, rings: float) -> None:
    for seed in range(3):
        lattice = graded(seed, levels, rings=rings)
        cells = lattice.cells
        assert area(cells) == QUANTA**2 * np.prod(lattice.shape)
        assert len(np.unique(cells.at(cells.low))) == cells.n
        larger = cells.size[:, None] > 2 * cells.size
        assert not (touching(cells) & larger).any()


@pytest.mark.parametrize("levels", LEVELS)
def test_nothing_is_divided_without_need(levels: int) -> None:
    """Of the four quarters of a cell that only balance has divided one touches a cell of half its size or less."""
    rng = np.random.default_rng(levels)
    low, size = np.array([(0, 0), (QUANTA, 0), (0, QUANTA), (QUANTA, QUANTA)]), np.full(4, QUANTA)
    for _ in range(levels):
        one = np.arange(len(size)) == rng.choice(np.flatnonzero(size == size.min()))
        quarters = quarters_of(low[one], size[one])
        low, size = (np.concatenate([a[~one], b]) for a, b in zip((low, size), quarters, strict=True))
    given = squares_of(low, size)
    cells = balanced(given)
    was = given.size[given.at(cells.low)]
    parents = np.unique(
        np.column_stack([cells.low // (2 * cells.size[:, None]), 2 * cells.size])[cells.size < was], axis=0
    )
    for x, y, side in parents:
        corner = np.array([x, y]) * side
        near = ((cells.low <= corner + side) & (corner <= boxes(cells)[1])).all(axis=1)
        inside = ((corner <= cells.low) & (cells.low < corner + side)).all(axis=1)
        assert (cells.size[near & ~inside] < side // 2).any() or (cells.size[inside] < side // 2).any()


def distances(lattice: Lattice, place: np.ndarray) -> np.ndarray:
    """How far (cells,) a place (2,) is from each cell along the farther axis, spacings."""
    low, high = (corners / QUANTA for corners in boxes(lattice.cells))
    return np.maximum(np.maximum(low - place, place - high), 0.0).max(axis=1)


@pytest.mark.parametrize("rings", [2.0, 3.5])
@pytest.mark.parametrize("levels", LEVELS)
def test_cells_round_a_place_are_as_small_as_asked_in_rings_of_every_size(levels: int, rings: float) -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 12.0), 1.0, 2.0)
    for place in np.random.default_rng(levels).uniform(2.0, 12.0, (4, 2)):
        fine = refined(lattice, Focus(shapely.points(place[None]), np.array([0.5**levels]), rings))
        side, away = fine.cells.size / QUANTA, distances(fine, place)
        assert side[away == 0.0].max() == 0.5**levels == side.min()
        assert not ((side > 0.5**levels) & (away <= rings * side)).any()
        # a cell is the quarter of one that was near, or that touches one whose quarters are
        assert (away[side < 1.0] <= ((rings + 1.0) * 2.0 * side + 2.0 * side)[side < 1.0]).all()


@pytest.mark.parametrize("noise", [0.0, 1e-15, 1e-12, 1e-9])
def test_rounding_of_a_place_on_a_corner_is_no_matter(noise: float) -> None:
    """Cells of all sizes lie just at the distance at which they are divided."""
    lattice = place_lattice(np.zeros(2), np.full(2, 8.0), 1.0, 2.0)
    cells = []
    for direction in ((0, 0), (1, 1), (-1, 1), (1, -1), (-1, -1)):
        place = 0.5 * np.array(lattice.shape) + noise * np.array(direction)
        cells.append(refined(lattice, Focus(shapely.points([place]), np.array([0.5**6]), 2.0)).cells)
    for other in cells[1:]:
        np.testing.assert_array_equal(cells[0].low, other.low)
        np.testing.assert_array_equal(cells[0].size, other.size)
    mirrored = np.array(lattice.shape) * QUANTA - boxes(cells[0])[1]
    np.testing.assert_array_equal(np.unique(mirrored, axis=0), np.unique(cells[0].low, axis=0))


def test_sizes_between_powers_of_two_are_halved_until_they_are_no_larger() -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 6.0), 1.0, 2.0)
    for asked, side in ((1.0, 1.0), (0.99, 0.5), (0.5, 0.5), (0.3, 0.25), (7.0, 1.0)):
        fine = refined(lattice, Focus(shapely.points([[3.1, 4.2]]), np.array([asked]), 2.0))
        assert fine.cells.size.min() / QUANTA == side
    assert refined(lattice, Focus(np.empty(0, dtype=object), np.empty(0), 2.0)) is lattice


@pytest.mark.parametrize("place", [(-40.0, 3.0), (0.0, 0.0), (5.0, 0.0), (1e7, 1e7)])
def test_places_outside_of_the_lattice_or_on_its_rim_are_no_fault(place: tuple[float, float]) -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 6.0), 1.0, 2.0)
    fine = refined(lattice, Focus(shapely.points([place]), np.array([0.125]), 2.0))
    assert area(fine.cells) == area(lattice.cells)
    assert (fine.cells.size.min() < QUANTA) == (min(place) >= 0.0 and max(place) < 100.0)


def test_there_is_a_smallest_cell() -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 4.0), 1.0, 2.0)
    fine = refined(lattice, Focus(shapely.points([(3.2, 3.3)]), np.array([1e-9]), 2.0))
    assert fine.cells.size.min() == QUANTA // 2**MOST_LEVELS


def test_lines_and_many_places_close_together() -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 6.0), 1.0, 2.0)
    near = 4.0 + 1e-4 * np.random.default_rng(1).normal(size=(500, 2))
    line = shapely.LineString([(2.3, 2.2), (6.1, 3.1)])
    fine = refined(lattice, Focus(np.append(shapely.points(near), line), np.append(np.full(500, 0.03), 0.25), 2.0))
    alone = refined(lattice, Focus(np.append(shapely.points([(4.0, 4.0)]), line), np.array([0.03, 0.25]), 2.0))
    assert abs(fine.cells.n - alone.cells.n) < 0.2 * alone.cells.n
    low, high = (corners / QUANTA for corners in boxes(fine.cells))
    crossed = shapely.intersects(shapely.box(*low.T, *high.T), line)
    assert fine.cells.size[crossed].max() == QUANTA // 4
