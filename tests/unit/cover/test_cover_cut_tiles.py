"""Pieces of lines, tiles that are cut on their own, and numbers of vertices and edges."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crackgrow.cover.cut_tiles import NOTHING, content_of, cut_tiles
from crackgrow.cover.elements import cut_elements
from crackgrow.cover.lattice import place_lattice
from crackgrow.cover.pieces import cut_in_pieces
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.cover.tiles import touched_tiles
from crackgrow.geometry.tolerance import GRID
from tests.unit.cover_tables import tiles_of

X, Y = np.arange(6.0), np.array([0.0, 0.5, 1.0, 2.0, 3.0, 4.0])
BOX = np.array([(0.5, 0.5), (7.5, 0.5), (7.5, 6.5), (0.5, 6.5)])


def random_segments(n: int) -> np.ndarray:
    return np.random.default_rng(7).uniform(0.1, 3.9, (n, 2, 2))


def test_pieces_end_on_the_tile_lines_that_they_cross_and_stay_in_one_tile() -> None:
    segments = random_segments(50)
    pieces = cut_in_pieces(segments, X, Y)
    for k, segment in enumerate(segments):
        crossed = sum(
            ((lines > ends.min()) & (lines < ends.max())).sum() for lines, ends in zip((X, Y), segment.T, strict=True)
        )
        mine = pieces.ends[pieces.segment == k]
        assert len(mine) == crossed + 1
        np.testing.assert_allclose(mine[[0, -1], [0, 1]], segment, atol=GRID)
        np.testing.assert_array_equal(mine[1:, 0], mine[:-1, 1])
    for axis, lines in enumerate((X, Y)):
        low, high = np.sort(pieces.ends[..., axis], axis=1).T
        assert np.all(np.searchsorted(lines, low, side="right") >= np.searchsorted(lines, high, side="left"))


def test_equal_segments_are_cut_alike_whichever_way_they_run() -> None:
    segments = random_segments(50)
    there, back = cut_in_pieces(segments, X, Y), cut_in_pieces(segments[::-1, ::-1], X, Y)
    np.testing.assert_array_equal(there.ends, back.ends[::-1, ::-1])


@pytest.mark.parametrize("segment", [[(1.0, 0.2), (1.0, 3.3)], [(0.5, 1.0), (3.5, 1.0)], [(1.0, 1.0), (3.0, 3.0)]])
def test_pieces_along_tile_lines_and_through_corners_have_no_specks(segment: list[tuple[float, float]]) -> None:
    pieces = cut_in_pieces(np.array([segment]), X, Y)
    lengths = np.hypot(*(pieces.ends[:, 1] - pieces.ends[:, 0]).T)
    assert lengths.min() > 0.1
    assert lengths.sum() == pytest.approx(np.hypot(*np.diff(segment, axis=0)[0]), abs=GRID)


def test_a_tile_is_cut_the_same_alone_and_with_all_others() -> None:
    lattice = place_lattice(np.zeros(2), np.full(2, 6.0), 1.0, 1.5)
    x, y = lattice.tile_lines
    pieces = cut_in_pieces(np.random.default_rng(8).uniform(1.0, 6.0, (12, 2, 2)), x, y)
    region = shapely.box(0.0, 0.0, x[-1], y[-1])
    middles = pieces.ends.mean(axis=1)
    touched = touched_tiles(lattice, np.concatenate([pieces.points, middles]), np.empty((0, 2)))
    together, extra = cut_tiles(content_of(touched, x, y, pieces.ends, pieces.points), x, y, [region], NOTHING)
    assert len(extra) == 0
    assert shapely.area(together.polygons).sum() == pytest.approx((touched * np.outer(np.diff(x), np.diff(y))).sum())
    for tile in np.argwhere(touched):
        only = np.zeros_like(touched)
        only[tuple(tile)] = True
        alone, _ = cut_tiles(content_of(only, x, y, pieces.ends, pieces.points), x, y, [region], NOTHING)
        mine = together.polygons[together.tile == tile[0] * (len(y) - 1) + tile[1]]
        np.testing.assert_array_equal(shapely.to_wkb(alone.polygons), shapely.to_wkb(mine))


def test_lines_that_meet_within_rounding_of_a_tile_line_cut_the_tile_beyond_it_as_well() -> None:
    """At x = 4 two lines without a common vertex are a grid step above and below (4, 3.5), and cross left of it, nearer
    to x = 4 than to the next point of the grid: the tiles on the right must have the vertex (4, 3.5) too."""
    lattice = place_lattice(BOX[0], BOX[2], 1.0, 2.0)
    lines = []
    for name, sign in (("up", 1.0), ("down", -1.0)):
        middle = np.array([(3.9, -0.4), (4.1, 0.4 + 2.0 * GRID)])
        path = np.concatenate([[(0.5, -1.4)], middle, [(7.5, 1.3)]]) * (1.0, sign) + (0.0, 3.5)
        lines.append(CrackGeometry(name, lattice.to_lattice(path), False, False))
    at = lattice.to_lattice(np.array([4.0, 3.5]))
    assert np.all(at % 1.0 == (0.0, 0.5))
    elements = cut_elements(lattice, [BodyGeometry((lattice.to_lattice(BOX),))], lines)
    vertex = int(np.flatnonzero(np.all(elements.vertices == at, axis=1))[0])
    beside = elements.ring_element[elements.ring_start == vertex]
    assert set(tiles_of(lattice, elements)[beside, 0]) == {int(at[0]) - 1, int(at[0])}
    rim = elements.outlines.points
    assert np.hypot(*(rim[:, 1] - rim[:, 0]).T).sum() == pytest.approx(26.0, rel=1e-8)
    ends = np.bincount(elements.ring_end, minlength=len(elements.vertices))
    np.testing.assert_array_equal(np.bincount(elements.ring_start, minlength=len(elements.vertices)), ends)


@pytest.mark.parametrize("support", [1.5, 1.75, 2.0, 2.5])
def test_every_edge_lies_between_the_elements_that_its_ends_go_round(build, support: float) -> None:
    """Each directed edge of a ring is one edge, with the ring's element on the side that it leads round."""
    elements = build.block((6, 5), [build.crack([(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)])], support).cover.elements
    edges = elements.edges
    two = edges.right >= 0
    found = np.concatenate(
        [np.stack([edges.a, edges.b, edges.left]), np.stack([edges.b, edges.a, edges.right])[:, two]], 1
    )
    rings = np.stack([elements.ring_start, elements.ring_end, elements.ring_element])
    np.testing.assert_array_equal(found[:, np.lexsort(found)], rings[:, np.lexsort(rings)])
    a, b = elements.vertices[edges.a], elements.vertices[edges.b]
    step, towards = b - a, elements.reference[edges.left] - a
    assert (step[:, 0] * towards[:, 1] - step[:, 1] * towards[:, 0]).min() > 0.0
