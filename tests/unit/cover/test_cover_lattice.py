"""The lattice and its tiles."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.case.surface import crack_name
from crackgrow.cover.elements import cut_elements
from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.errors import GeometryError
from tests.unit.cover_tables import tile_boxes
from tests.unit.regular_functions import regular_window

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
        nodes = cells[:, None] + regular_window(support)[None]
        assert nodes.min() >= 0
        assert np.all(nodes <= lattice.shape)


@pytest.mark.parametrize("support", [1.0, *SUPPORTS, 3.0])
def test_window_holds_every_node_that_covers_a_point(support: float) -> None:
    nodes = regular_window(support)
    assert len(np.unique(nodes, axis=0)) == len(nodes)
    window = {tuple(node) for node in nodes}
    grid = np.arange(-6, 7)
    nodes = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    for local in np.random.default_rng(6).uniform(0, 1, (200, 2)):
        covering = nodes[np.all(np.abs(nodes - local) < support, axis=1)]
        assert {tuple(node) for node in covering} <= window


@pytest.mark.parametrize("levels", [0, 4])
@pytest.mark.parametrize("support", SUPPORTS)
def test_tile_of_a_point_holds_it(build, support: float, levels: int) -> None:
    lattice = build.graded(place_lattice(np.zeros(2), np.full(2, 3.0), 1.0, support), [(1.6, 2.1)], levels)
    points = rng.uniform(0, lattice.shape[0], (500, 2))
    low, high = tile_boxes(lattice, lattice.tiles_at(points))
    assert np.all((low <= points) & (points < high))
    assert np.all(lattice.tiles_at(np.array([[-0.1, 1.0], [1.0, lattice.shape[1] + 0.1], [1e9, 1.0]])) == -1)


def touched_by(lattice: Lattice, segment: list[tuple[float, float]], tips: tuple[bool, bool]) -> np.ndarray:
    """Lower left corners of the tiles, inside of a body, that are cut because of a segment."""
    box = BodyGeometry((np.array([(0.5, 0.5), (7.5, 0.5), (7.5, 7.5), (0.5, 7.5)]),))
    without, cut = (
        cut_elements(lattice, [box], lines).whole_of_tile
        for lines in ([], [CrackGeometry(crack_name("crack"), np.array(segment), *tips)])
    )
    return lattice.tile_low[(without >= 0) & (cut < 0)]


def test_segment_touches_the_tiles_it_crosses_and_no_others() -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 4.0), 1.0, 2.0)
    # the line y = 1.25 + (x - 1) / 2 meets y = 2 at x = 2.5; at its ends it touches the tiles before and behind
    touched = touched_by(lattice, [(1.0, 1.25), (3.0, 2.25)], (False, False))
    np.testing.assert_array_equal(touched, [[1, 1], [2, 1], [2, 2], [3, 2]])


def test_segment_on_a_lattice_line_touches_both_sides_and_a_tip_all_its_neighbours() -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 4.0), 1.0, 2.0)
    along = touched_by(lattice, [(2.5, 3.0), (3.5, 3.0)], (False, False))
    np.testing.assert_array_equal(along, [[2, 2], [2, 3], [3, 2], [3, 3]])
    round_tips = touched_by(lattice, [(2.5, 3.5), (5.5, 3.5)], (True, True))
    np.testing.assert_array_equal(round_tips, [[x, y] for x in (1, 2, 3, 4, 5, 6) for y in (2, 3, 4)])


def test_more_cells_across_than_have_places_are_refused() -> None:
    with pytest.raises(GeometryError, match=r"9,00\d cells .* at most 8,192 .* use a larger numerics.spacing"):
        place_lattice(np.zeros(2), np.array([9.0, 0.002]), 1e-3, 2.0)
