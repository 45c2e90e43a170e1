"""The lattice, and its tiles which fill the cells: no patch ends inside of one."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.errors import GeometryError
from tests.unit.cover.graded import boxes, graded
from tests.unit.cover_tables import tile_boxes

LEVELS = (0, 1, 3, 6)
SUPPORTS = (1.5, 2.0, 2.5)


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
