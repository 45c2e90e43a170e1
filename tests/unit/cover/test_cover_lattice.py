"""The lattice and its tiles."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.cover.pieces import cut_in_pieces
from crackgrow.cover.tiles import tiles_at, touched_tiles

SUPPORTS = (1.5, 1.75, 2.0, 2.5)
rng = np.random.default_rng(5)
BOXES = [(low, low + rng.uniform(1.0, 9.0, 2)) for low in rng.uniform(-20, 20, (40, 2))]


@pytest.mark.parametrize("support", SUPPORTS)
def test_lattice_is_symmetric_about_the_box(support: float) -> None:
    for low, high in BOXES:
        lattice = place_lattice(low, high, 0.37, support)
        middle = lattice.to_metres(0.5 * np.array(lattice.shape))
        np.testing.assert_allclose(middle, 0.5 * (low + high), atol=1e-13)  # coordinates up to 30


@pytest.mark.parametrize("support", SUPPORTS)
def test_box_sides_keep_a_quarter_cell_from_lattice_lines(support: float) -> None:
    for low, high in BOXES:
        lattice = place_lattice(low, high, 0.37, support)
        sides = lattice.to_lattice(np.stack([low, high])) % 1.0
        assert sides.min() >= 0.25 - 1e-12
        assert sides.max() <= 0.75 + 1e-12


@pytest.mark.parametrize("support", SUPPORTS)
def test_windows_of_all_points_of_the_box_lie_on_the_lattice(support: float) -> None:
    for low, high in BOXES:
        lattice = place_lattice(low, high, 0.37, support)
        cells = np.floor(lattice.to_lattice(np.stack([low, high]))).astype(int)
        nodes = cells[:, None] + lattice.offsets[None]
        assert nodes.min() >= 0
        assert np.all(nodes <= lattice.shape)


@pytest.mark.parametrize("support", [1.0, *SUPPORTS, 3.0])
def test_window_holds_every_node_that_covers_a_point(support: float) -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 4.0), 1.0, support)
    assert len(np.unique(lattice.offsets, axis=0)) == len(lattice.offsets)
    window = {tuple(offset) for offset in lattice.offsets}
    grid = np.arange(-6, 7)
    nodes = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    for local in np.random.default_rng(6).uniform(0, 1, (200, 2)):
        covering = nodes[np.all(np.abs(nodes - local) < support, axis=1)]
        assert {tuple(node) for node in covering} <= window


@pytest.mark.parametrize("support", SUPPORTS)
def test_no_tile_is_cut_by_the_edge_of_a_patch(support: float) -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 4.0), 1.0, support)
    lines, _ = lattice.tile_lines
    edges = np.concatenate([np.arange(20) - support, np.arange(20) + support])
    edges = edges[(edges >= 0) & (edges <= lattice.shape[0])]
    np.testing.assert_allclose(np.abs(edges[:, None] - lines).min(axis=1), 0.0, atol=1e-14)


def test_metres_and_lattice_coordinates_are_inverse() -> None:
    lattice = place_lattice(np.array([-1.0, 2.0]), np.array([3.0, 5.0]), 0.25, 2.0)
    points = rng.uniform(-1, 5, (30, 2))
    np.testing.assert_allclose(lattice.to_metres(lattice.to_lattice(points)), points, atol=1e-14)
    np.testing.assert_allclose(lattice.to_metres(np.zeros(2)), lattice.origin, rtol=1e-15)


@pytest.mark.parametrize("support", SUPPORTS)
def test_tile_of_a_point_holds_it(support: float) -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 3.0), 1.0, support)
    points = rng.uniform(0, lattice.shape[0], (500, 2))
    tiles = tiles_at(lattice, points)
    x, y = lattice.tile_lines
    assert np.all((x[tiles[:, 0]] <= points[:, 0]) & (points[:, 0] < x[tiles[:, 0] + 1]))
    assert np.all((y[tiles[:, 1]] <= points[:, 1]) & (points[:, 1] < y[tiles[:, 1] + 1]))


def touched_by(lattice: Lattice, segment: list[tuple[float, float]]) -> np.ndarray:
    pieces = cut_in_pieces(np.array([segment]), *lattice.tile_lines)
    return touched_tiles(lattice, np.concatenate([pieces.points, pieces.ends.mean(axis=1)]), np.empty((0, 2)))


def test_segment_touches_the_tiles_it_crosses_and_no_others() -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 4.0), 1.0, 2.0)
    touched = touched_by(lattice, [(1.5, 1.5), (3.5, 2.5)])
    # the line y = 1.5 + (x - 1.5) / 2 meets y = 2 at x = 2.5
    np.testing.assert_array_equal(np.argwhere(touched), [[1, 1], [2, 1], [2, 2], [3, 2]])


def test_segment_on_a_lattice_line_touches_both_sides_and_a_tip_all_its_neighbours() -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 4.0), 1.0, 2.0)
    along = touched_by(lattice, [(2.5, 3.0), (3.5, 3.0)])
    np.testing.assert_array_equal(np.argwhere(along), [[2, 2], [2, 3], [3, 2], [3, 3]])
    round_tip = touched_tiles(lattice, np.empty((0, 2)), np.array([[2.5, 3.5]]))
    assert np.argwhere(round_tip).min(axis=0).tolist() == [1, 2]
    assert np.argwhere(round_tip).max(axis=0).tolist() == [3, 4]
    assert round_tip.sum() == 9
