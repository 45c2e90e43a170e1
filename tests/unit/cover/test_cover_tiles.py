"""Tiles of cells of several sizes, as a mesh: no patch ends inside of one, and rings know all corners on their rims."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from crackgrow.cover.lattice import Lattice
from crackgrow.cover.squares import QUANTA
from tests.unit.cover.graded import boxes, graded

LEVELS = (0, 1, 3, 6)
SUPPORTS = (1.5, 2.0, 2.5)


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


def test_tiles_are_whole_cells_away_from_changes_of_size_and_are_never_smaller_than_needed() -> None:
    """A tile that is a part of its cell has a sister that another set of patches is over."""
    for levels, support in ((3, 2.0), (3, 1.5), (5, 2.5)):
        tiles = graded(levels, levels, support).tiles
        part = tiles.squares.size < graded(levels, levels, support).cells.size[tiles.cell]
        assert part.any()
        of_cell: dict[int, set[bytes]] = {}
        for tile in np.flatnonzero(part).tolist():
            of_cell.setdefault(int(tiles.cell[tile]), set()).add(tiles.over.of(tile).tobytes())
        assert min(len(found) for found in of_cell.values()) > 1


@pytest.mark.parametrize("support", SUPPORTS)
@pytest.mark.parametrize("levels", LEVELS)
def test_rings_go_round_and_hold_every_corner_on_the_rim(levels: int, support: float) -> None:
    lattice = graded(levels + 10, levels, support)
    tiling, tiles = lattice.tiling, lattice.tiles.squares
    low, high = boxes(tiles)
    corners = np.rint(tiling.points * QUANTA).astype(np.int64)
    ring = tiling.ring
    start, end = corners[ring.values], corners[tiling.following]
    step = end - start
    assert np.all((step == 0).sum(axis=1) == 1)
    twice = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
    np.testing.assert_array_equal(np.bincount(ring.row, twice), 2.0 * tiles.size.astype(float) ** 2)
    np.testing.assert_array_equal(start[ring.start[:-1]], low)
    for tile in some_tiles(lattice, levels):
        mine = ring.of(tile)
        on = ((low[tile] <= corners) & (corners <= high[tile])).all(axis=1)
        on &= ((corners == low[tile]) | (corners == high[tile])).any(axis=1)
        np.testing.assert_array_equal(np.sort(mine), np.flatnonzero(on))
        following = tiling.following[ring.start[tile] : ring.start[tile + 1]]
        np.testing.assert_array_equal(following, np.roll(mine, -1))
