"""Pieces of lines, tiles that are cut on their own, and numbers of vertices and edges."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crackgrow.case.surface import crack_name
from crackgrow.cover.cut_tiles import cut_tiles
from crackgrow.cover.elements import cut_elements
from crackgrow.cover.lattice import place_lattice
from crackgrow.cover.pieces import cut_in_pieces
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.cover.squares import QUANTA, Squares, quarters_of, squares_of
from crackgrow.geometry.tolerance import GRID

TILES = {"of one size": [], "of four sizes": [(0, 0), (2, 1), (2.5, 1.5), (2.75, 1.5), (3, 3)]}
"""Squares of a lattice of 4 x 4 that are divided, by their corners."""


BOX = np.array([(0.5, 0.5), (7.5, 0.5), (7.5, 6.5), (0.5, 6.5)])


def tiles(places: list[tuple[float, float]]) -> Squares:
    low, size = QUANTA * np.array([(x, y) for x in range(4) for y in range(4)]), np.full(16, QUANTA)
    for place in places:
        divided = np.all(low == QUANTA * np.array(place), axis=1)
        quarters = quarters_of(low[divided], size[divided])
        low, size = (np.concatenate([a[~divided], b]) for a, b in zip((low, size), quarters, strict=True))
    return squares_of(low, size)


@pytest.mark.parametrize("places", TILES.values(), ids=TILES)
def test_pieces_end_on_the_sides_of_tiles_that_they_cross_and_stay_in_one_tile(places: list) -> None:
    """Whichever way a segment runs."""
    segments, squares = np.random.default_rng(7).uniform(0.1, 3.9, (50, 2, 2)), tiles(places)
    pieces = cut_in_pieces(segments, squares)
    low, high = squares.low / QUANTA, (squares.low + squares.size[:, None]) / QUANTA
    boxes = shapely.box(*low.T, *high.T)
    for k, segment in enumerate(segments):
        mine = pieces.ends[pieces.segment == k]
        inside = shapely.length(shapely.intersection(boxes, shapely.LineString(segment)))
        assert len(mine) == np.count_nonzero(inside > GRID)
        np.testing.assert_allclose(mine[[0, -1], [0, 1]], segment, atol=GRID)
        np.testing.assert_array_equal(mine[1:, 0], mine[:-1, 1])
    tile = squares.around(pieces.ends.mean(axis=1))[:, 0]
    assert np.all((pieces.ends >= low[tile, None]) & (pieces.ends <= high[tile, None]))
    back = cut_in_pieces(segments[::-1, ::-1], squares)
    np.testing.assert_array_equal(pieces.ends, back.ends[::-1, ::-1])


@pytest.mark.parametrize("levels", [0, 3])
def test_a_tile_is_cut_the_same_alone_and_with_all_others(build, levels: int) -> None:
    lattice = build.graded(place_lattice(np.zeros(2), np.full(2, 6.0), 1.0, 1.5), [(3.7, 4.1)], levels)
    squares = lattice.tiles.squares
    pieces = cut_in_pieces(np.random.default_rng(8).uniform(1.0, 6.0, (12, 2, 2)), squares)
    region = shapely.box(0.0, 0.0, *lattice.shape)
    touched = np.zeros(squares.n, dtype=bool)
    touched[squares.around(np.concatenate([pieces.points, pieces.ends.mean(axis=1)]))] = True
    together, extra = cut_tiles(lattice, touched, pieces.ends, pieces.points, [region])
    assert len(extra) == 0
    assert shapely.area(together.polygons).sum() == pytest.approx((lattice.tile_size[touched] ** 2).sum())
    for tile in np.flatnonzero(touched):
        only = np.arange(squares.n) == tile
        alone, _ = cut_tiles(lattice, only, pieces.ends, pieces.points, [region])
        mine = together.polygons[together.tile == tile]
        np.testing.assert_array_equal(shapely.to_wkb(alone.polygons), shapely.to_wkb(mine))
        box = shapely.box(*lattice.tile_low[tile], *(lattice.tile_low[tile] + lattice.tile_size[tile]))
        inside = pieces.ends[(squares.around(pieces.ends.mean(axis=1)) == tile).all(axis=1)]
        noded = shapely.union_all([box.exterior, *shapely.linestrings(inside)], grid_size=GRID)
        wanted = shapely.get_parts(shapely.polygonize([noded]))
        assert shapely.equals(wanted[:, None], mine).sum(axis=0).tolist() == [1] * len(wanted)


def test_lines_that_meet_within_rounding_of_a_tile_line_cut_the_tile_beyond_it_as_well() -> None:
    """At x = 4 two lines without a common vertex are a grid step above and below (4, 3.5), and cross left of it, nearer
    to x = 4 than to the next point of the grid: the tiles on the right must have the vertex (4, 3.5) too."""
    lattice = place_lattice(BOX[0], BOX[2], 1.0, 2.0)
    lines = []
    for name, sign in (("up", 1.0), ("down", -1.0)):
        middle = np.array([(3.9, -0.4), (4.1, 0.4 + 2.0 * GRID)])
        path = np.concatenate([[(0.5, -1.4)], middle, [(7.5, 1.3)]]) * (1.0, sign) + (0.0, 3.5)
        lines.append(CrackGeometry(crack_name(name), lattice.to_lattice(path), False, False))
    at = lattice.to_lattice(np.array([4.0, 3.5]))
    assert np.all(at % 1.0 == (0.0, 0.5))
    elements = cut_elements(lattice, [BodyGeometry((lattice.to_lattice(BOX),))], lines)
    vertex = int(np.flatnonzero(np.all(elements.vertices == at, axis=1))[0])
    beside = elements.rings.face[elements.rings.start == vertex]
    assert set(lattice.tile_low[elements.tile[beside], 0]) == {at[0] - 1.0, at[0]}
    rim = elements.outlines.points
    assert np.hypot(*(rim[:, 1] - rim[:, 0]).T).sum() == pytest.approx(26.0, rel=1e-8)
    ends = np.bincount(elements.rings.end, minlength=len(elements.vertices))
    np.testing.assert_array_equal(np.bincount(elements.rings.start, minlength=len(elements.vertices)), ends)


def test_a_line_and_a_rim_that_the_extension_of_a_tip_crosses_are_whole(build) -> None:
    """Inside of one tile, where neither has the end of a piece."""
    cracks = [[(3.1, 3.2), (5.2, 4.9)], [(3.2, 2.2), (4.24, 3.9)], [(2.2, 2.2), (1.7, 0.6)]]
    elements = build.block(
        (6, 5), [build.crack(points, name=str(k)) for k, points in enumerate(cracks)], 1.5
    ).cover.elements
    crossed, rim = elements.lines[0], elements.outlines
    np.testing.assert_array_equal(crossed.points[1:, 0], crossed.points[:-1, 1])
    np.testing.assert_allclose(crossed.s[[0, -1], [0, 1]], [0.0, np.hypot(2.1, 1.7)], atol=1e-8)
    lengths = np.bincount(rim.side, np.hypot(*(rim.points[:, 1] - rim.points[:, 0]).T))
    np.testing.assert_allclose(lengths, [6.0, 5.0, 6.0, 5.0], rtol=1e-8)


@pytest.mark.parametrize("support", [1.5, 1.75, 2.0, 2.5])
def test_every_edge_lies_between_the_elements_that_its_ends_go_round(build, support: float) -> None:
    """Each directed edge of a ring is one edge, with the ring's element on the side that it leads round."""
    elements = build.block((6, 5), [build.crack([(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)])], support).cover.elements
    edges = elements.edges
    two = edges.right >= 0
    found = np.concatenate(
        [np.stack([edges.a, edges.b, edges.left]), np.stack([edges.b, edges.a, edges.right])[:, two]], 1
    )
    rings = np.stack([elements.rings.start, elements.rings.end, elements.rings.face])
    np.testing.assert_array_equal(found[:, np.lexsort(found)], rings[:, np.lexsort(rings)])
    a, b = elements.vertices[edges.a], elements.vertices[edges.b]
    step, towards = b - a, elements.reference[edges.left] - a
    assert (step[:, 0] * towards[:, 1] - step[:, 1] * towards[:, 0]).min() > 0.0
