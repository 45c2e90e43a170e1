"""Squares are found as by looking at each of them; cells are divided where that is needed and not else."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.cover.refinement import MOST_LEVELS, Focus, refined
from crackgrow.cover.squares import QUANTA, Squares
from tests.unit.cover.graded import boxes, graded

LEVELS = (0, 1, 3, 6)


@pytest.mark.parametrize("levels", LEVELS)
def test_squares_are_found_as_by_looking_at_each(levels: int) -> None:
    """Those that hold places (or have them as lower left corner), touch points, and lie within larger squares."""
    squares, rng = graded(levels, levels).cells, np.random.default_rng(levels)
    low, high = boxes(squares)
    corners = np.concatenate([low, high])
    places = np.concatenate([rng.integers(-QUANTA, 11 * QUANTA, (300, 2)), corners, corners - 1, corners - (0, 1)])
    inside = ((low <= places[:, None]) & (places[:, None] < high)).all(axis=2)
    assert inside.sum(axis=1).max() <= 1
    np.testing.assert_array_equal(squares.at(places), np.where(inside.any(axis=1), inside.argmax(axis=1), -1))

    on_rims = np.stack([low[:, 0], 0.5 * (low + high)[:, 1]], axis=1) / QUANTA
    some = [rng.permutation(points)[:100] for points in (low / QUANTA, on_rims)]
    points = np.concatenate([rng.uniform(0.0, 10.0, (200, 2)), *some])
    for point, around in zip(points, squares.around(points), strict=True):
        touching = np.flatnonzero(((low <= point * QUANTA) & (point * QUANTA <= high)).all(axis=1))
        assert set(around[around >= 0]) == set(touching)

    for part in range(-1, levels + 1):
        size = int(QUANTA / 2.0**part)
        asked = size * rng.integers(-1, 11 * QUANTA // size, (40, 2))
        found = squares.within(asked, np.full(len(asked), size))
        for k, corner in enumerate(asked):
            within = np.flatnonzero(((corner <= low) & (high <= corner + size)).all(axis=1))
            np.testing.assert_array_equal(np.sort(found.of(k)), within)


def area(squares: Squares) -> int:
    return int((squares.size**2).sum())


@pytest.mark.parametrize("levels", LEVELS)
@pytest.mark.parametrize("rings", [2.0, 3.0])
def test_no_cell_is_more_than_twice_as_large_as_one_that_it_touches(levels: int, rings: float) -> None:
    lattice = graded(levels, levels, rings=rings)
    cells = lattice.cells
    low, high = boxes(cells)
    assert area(cells) == QUANTA**2 * np.prod(lattice.shape)
    assert len(np.unique(cells.at(cells.low))) == cells.n
    touching = ((low[:, None] <= high) & (low <= high[:, None])).all(axis=2)
    assert not (touching & (cells.size[:, None] > 2 * cells.size)).any()


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


def smallest(place: tuple[float, float], asked: float) -> tuple[int, bool]:
    """The smallest cell, quanta, of a lattice of 6 x 6 with a place that asks for cells, and whether it is filled."""
    lattice = place_lattice(np.zeros(2), np.full(2, 6.0), 1.0, 2.0)
    cells = refined(lattice, Focus(shapely.points([place]), np.array([asked]), 2.0)).cells
    return int(cells.size.min()), area(cells) == area(lattice.cells)


def test_sizes_are_halved_until_they_are_no_larger_and_there_is_a_smallest() -> None:
    for asked, side in ((1.0, 1.0), (0.99, 0.5), (0.5, 0.5), (0.3, 0.25), (7.0, 1.0), (1e-9, 0.5**MOST_LEVELS)):
        assert smallest((3.1, 4.2), asked) == (side * QUANTA, True)
    for outside_or_on_the_rim, divided in (((-40.0, 3.0), 1), ((0.0, 0.0), 8), ((5.0, 0.0), 8), ((1e7, 1e7), 1)):
        assert smallest(outside_or_on_the_rim, 0.125) == (QUANTA // divided, True)
    lattice = place_lattice(np.zeros(2), np.full(2, 6.0), 1.0, 2.0)
    assert refined(lattice, Focus(np.empty(0, dtype=object), np.empty(0), 2.0)) is lattice
