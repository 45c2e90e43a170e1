"""The lattice: cells divided where that is needed and not else, its tiles and nodes; squares are found."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import shapely

from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.cover.refinement import MOST_LEVELS, SizeField, balanced, refined
from crackgrow.cover.squares import QUANTA, Squares, quarters_of, squares_of
from crackgrow.errors import GeometryError
from tests.unit.cover_tables import tile_boxes

LEVELS = (0, 1, 3, 6)
SUPPORTS = (1.5, 2.0, 2.5)
SIDES = 6.0
"""Of the box that the lattices here are placed round, spacings."""


def graded(seed: int, levels: int, support: float = 2.0, rings: float = 2.0) -> Lattice:
    """A lattice with two random places that ask for cells of 2^-levels, and one that asks for half as many levels."""
    lattice = place_lattice(np.zeros(2), np.full(2, SIDES), 1.0, support)
    places = lattice.to_lattice(np.random.default_rng(seed).uniform(0.0, SIDES, (3, 2)))
    sizes = 0.5 ** np.array([levels, levels, levels // 2])
    return refined(lattice, SizeField(shapely.points(places), sizes, np.full(3, rings)))


def boxes(squares: Squares) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corners (n, 2) of squares, quanta."""
    return squares.low, squares.low + squares.size[:, None]


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
def test_cells_are_divided_until_none_is_more_than_twice_as_large_as_one_that_it_touches(levels: int) -> None:
    """Of the four quarters of a cell that only balance has divided one touches a cell of half its size or less."""
    rng = np.random.default_rng(levels)
    low, size = np.array([(0, 0), (QUANTA, 0), (0, QUANTA), (QUANTA, QUANTA)]), np.full(4, QUANTA)
    for _ in range(levels):
        one = np.arange(len(size)) == rng.choice(np.flatnonzero(size == size.min()))
        quarters = quarters_of(low[one], size[one])
        low, size = (np.concatenate([a[~one], b]) for a, b in zip((low, size), quarters, strict=True))
    given = squares_of(low, size)
    for cells in (balanced(given), *(graded(levels, levels, rings=rings).cells for rings in (2.0, 3.0))):
        low, high = boxes(cells)
        assert area(cells) == np.prod(high.max(axis=0))
        assert len(np.unique(cells.at(cells.low))) == cells.n
        touching = ((low[:, None] <= high) & (low <= high[:, None])).all(axis=2)
        assert not (touching & (cells.size[:, None] > 2 * cells.size)).any()
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
        fine = refined(lattice, SizeField(shapely.points(place[None]), np.array([0.5**levels]), np.array([rings])))
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
        cells.append(refined(lattice, SizeField(shapely.points([place]), np.array([0.5**6]), np.array([2.0]))).cells)
    for other in cells[1:]:
        np.testing.assert_array_equal(cells[0].low, other.low)
        np.testing.assert_array_equal(cells[0].size, other.size)
    mirrored = np.array(lattice.shape) * QUANTA - boxes(cells[0])[1]
    np.testing.assert_array_equal(np.unique(mirrored, axis=0), np.unique(cells[0].low, axis=0))


def smallest(place: tuple[float, float], asked: float) -> tuple[int, bool]:
    """The smallest cell, quanta, of a lattice of 6 x 6 with a place that asks for cells, and whether it is filled."""
    lattice = place_lattice(np.zeros(2), np.full(2, 6.0), 1.0, 2.0)
    cells = refined(lattice, SizeField(shapely.points([place]), np.array([asked]), np.array([2.0]))).cells
    return int(cells.size.min()), area(cells) == area(lattice.cells)


def test_sizes_are_halved_until_they_are_no_larger_and_there_is_a_smallest() -> None:
    for asked, side in ((1.0, 1.0), (0.99, 0.5), (0.5, 0.5), (0.3, 0.25), (7.0, 1.0), (1e-9, 0.5**MOST_LEVELS)):
        assert smallest((3.1, 4.2), asked) == (side * QUANTA, True)
    for outside_or_on_the_rim, divided in (((-40.0, 3.0), 1), ((0.0, 0.0), 8), ((5.0, 0.0), 8), ((1e7, 1e7), 1)):
        assert smallest(outside_or_on_the_rim, 0.125) == (QUANTA // divided, True)
    lattice = place_lattice(np.zeros(2), np.full(2, 6.0), 1.0, 2.0)
    assert refined(lattice, SizeField(np.empty(0, dtype=object), np.empty(0), np.empty(0))) is lattice


@pytest.mark.parametrize("support", [1.75, *SUPPORTS])
def test_the_lattice_is_symmetric_about_the_box_whose_sides_lie_well_within_cells(support: float) -> None:
    """And all nodes that cover a point of the box are nodes of the lattice."""
    rng = np.random.default_rng(5)
    for low in rng.uniform(-20, 20, (40, 2)):
        high = low + rng.uniform(1.0, 9.0, 2)
        lattice = place_lattice(low, high, 0.37, support)
        middle = lattice.to_metres(0.5 * np.array(lattice.shape))
        np.testing.assert_allclose(middle, 0.5 * (low + high), atol=1e-13)  # coordinates up to 30
        box = lattice.to_lattice(np.stack([low, high]))
        assert np.all((box % 1.0 >= 0.25 - 1e-12) & (box % 1.0 <= 0.75 + 1e-12))
        assert np.all((np.floor(box[0] - support) + 1.0 >= 0.0) & (np.ceil(box[1] + support) - 1.0 <= lattice.shape))


def test_more_cells_across_than_have_places_are_refused() -> None:
    with pytest.raises(GeometryError, match=r"9,00\d cells .* at most 8,192 .* use a larger numerics.spacing"):
        place_lattice(np.zeros(2), np.array([9.0, 0.002]), 1e-3, 2.0)


@pytest.mark.parametrize("levels", [0, 4])
def test_the_tile_of_a_point_holds_it(levels: int) -> None:
    lattice = graded(levels, levels)
    points = np.random.default_rng(5).uniform(0, lattice.shape[0], (500, 2))
    low, high = tile_boxes(lattice, lattice.tiles_at(points))
    assert np.all((low <= points) & (points < high))
    assert np.all(lattice.tiles_at(np.array([[-0.1, 1.0], [1.0, lattice.shape[1] + 0.1], [1e9, 1.0]])) == -1)


def some_tiles(lattice: Lattice, seed: int) -> np.ndarray:
    """At most 1,000 tiles, half of them of the smallest."""
    rng, n = np.random.default_rng(seed), lattice.tiles.squares.n
    small = np.flatnonzero(lattice.tiles.squares.size == lattice.tiles.squares.size.min())
    return np.unique(np.concatenate([rng.integers(n, size=500), rng.choice(small, 500)]))


@pytest.mark.parametrize("levels", LEVELS)
def test_nodes_are_corners_of_all_cells_there_and_their_patches_as_wide_as_the_largest(levels: int) -> None:
    for support in SUPPORTS:
        lattice = graded(levels, levels, support)
        low, high = boxes(lattice.cells)
        corners = np.concatenate(
            [low, high, np.stack([low[:, 0], high[:, 1]], 1), np.stack([high[:, 0], low[:, 1]], 1)]
        )
        corners, shared = np.unique(corners, axis=0, return_counts=True)
        touching = ((low[:, None] <= corners) & (corners <= high[:, None])).all(axis=2).sum(axis=0)
        np.testing.assert_array_equal(lattice.nodes.places, corners[shared == touching])
        for k in np.random.default_rng(levels).integers(len(lattice.nodes.places), size=300):
            node = lattice.nodes.places[k]
            largest = lattice.cells.size[((low <= node) & (node <= high)).all(axis=1)].max()
            assert lattice.nodes.largest[k] == largest
            assert lattice.nodes.half[k] == support * largest


@pytest.mark.parametrize(("levels", "support"), [*product(LEVELS, SUPPORTS), *product((1, 3), (1.25, 1.75))])
def test_tiles_fill_their_cells_and_no_patch_ends_inside_of_one(levels: int, support: float) -> None:
    lattice = graded(levels, levels, support)
    tiles, cells, nodes = lattice.tiles, lattice.cells, lattice.nodes
    filled = np.bincount(tiles.cell, tiles.squares.size.astype(float) ** 2, cells.n)
    np.testing.assert_array_equal(filled, cells.size.astype(float) ** 2)
    some = some_tiles(lattice, levels)
    (low, high), (first, last) = ([a[some] for a in boxes(tiles.squares)], [a[tiles.cell[some]] for a in boxes(cells)])
    assert np.all((first <= low) & (high <= last))
    patch_low, patch_high = nodes.places - nodes.half[:, None], nodes.places + nodes.half[:, None]
    overlap = ((patch_low < high[:, None]) & (low[:, None] < patch_high)).all(axis=2)
    inside = ((patch_low <= low[:, None]) & (high[:, None] <= patch_high)).all(axis=2)
    np.testing.assert_array_equal(overlap, inside)
    over = tiles.over.taken(some)
    np.testing.assert_array_equal(np.stack([over.row, over.values]), np.stack(np.nonzero(inside)))
