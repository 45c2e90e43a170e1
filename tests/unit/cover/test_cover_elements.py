"""Cells as small as is asked for; manifold elements that fill the bodies, know the sides of cracks, can be located."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from crackgrow.case.surface import crack_name
from crackgrow.cover.elements import cut_elements, locate
from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.cover.refinement import MOST_LEVELS, SizeField, balanced, refined
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.cover.squares import QUANTA, Squares, quarters_of, squares_of
from crackgrow.errors import GeometryError
from crackgrow.geometry.tolerance import GRID
from tests.unit.exact_fields import areas, on_their_sides, tile_boxes

SUPPORTS = (1.5, 1.75, 2.0, 2.5)
KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]
BOX = np.array([(0.5, 0.5), (7.5, 0.5), (7.5, 6.5), (0.5, 6.5)])
AREA = 1e-7
"""Relative: vertices move by 1e-9 spacings, along rims of about 40 spacings."""


@pytest.mark.parametrize("support", SUPPORTS)
def test_points_are_located_in_elements_that_hold_them_and_points_outside_in_none(build, support: float) -> None:
    sample = build.block((6, 5), [build.crack(KINKED)], support)
    elements, reach = sample.cover.elements, math.ceil(support)
    points = reach + np.random.default_rng(7).uniform((0.5, 0.5), (6.5, 5.5), (400, 2))
    found = locate(sample.lattice, elements, points)
    whole = found < elements.n_whole
    assert 0 < whole.sum() < len(points)
    low, high = tile_boxes(sample.lattice, elements.tile[found[whole]])
    assert np.all((low <= points[whole]) & (points[whole] <= high))
    polygons = elements.polygons[found[~whole] - elements.n_whole]
    assert shapely.distance(polygons, shapely.points(points[~whole])).max() <= 1e-8  # ON_LINE
    np.testing.assert_array_equal(locate(sample.lattice, elements, elements.reference), np.arange(elements.n))
    a, b = (elements.vertices[ends] for ends in (elements.edges.a, elements.edges.b))
    beside = 0.5 * (a + b) + 1e-6 * (b - a) @ [[0.0, 1.0], [-1.0, 0.0]]  # on the left
    np.testing.assert_array_equal(locate(sample.lattice, elements, beside), elements.edges.left)
    outside = np.array([[0.4, 3.0], [6.6, 3.0], [3.0, 0.49], [3.0, 5.51], [-50.0, 3.0], [3.0, 1e4]])
    np.testing.assert_array_equal(locate(sample.lattice, elements, outside + reach), [-1] * 6)
    on_the_rim = np.array([[0.5, 0.5], [6.5, 0.5], [6.5, 5.5], [0.5, 5.5], [3.0, 0.5], [6.5, 4.2]])
    assert locate(sample.lattice, elements, on_the_rim + reach).min() >= 0


OFFSETS = (0.0, 1e-12, 1e-9, 1e-8, 1e-6)

PLACES = {
    "along a lattice line": [(1.3, 3.0), (4.6, 3.0)],
    "along a lattice line from node to node": [(2.0, 3.0), (5.0, 3.0)],
    "through nodes, tips on nodes": [(2.0, 2.0), (5.0, 5.0)],
    "through a node, tips inside cells": [(1.4, 2.4), (4.6, 3.6)],
    "tip on a lattice line": [(1.3, 2.2), (4.0, 3.4)],
    "tip on a patch corner": [(1.3, 2.2), (4.5, 3.5)],
    "along the rim of patches": [(1.5, 2.5), (4.5, 2.5)],
    "kink on a node": [(1.3, 2.2), (3.0, 3.0), (4.6, 2.6)],
    "kink on a lattice line": [(1.3, 2.2), (3.0, 2.6), (4.6, 2.4)],
    "two segments on lattice lines": [(1.3, 3.0), (3.0, 3.0), (3.0, 4.6)],
    "along sides of cells of two sizes": [(3.25, 3.0), (0.9, 3.0)],
    "at 45 degrees through corners of many sizes": [(1.5, 1.5), (5.0, 5.0)],
    "at 45 degrees through middles": [(1.25, 1.0), (4.75, 4.5)],
    "upright from a corner of small cells": [(2.75, 1.125), (2.75, 4.7)],
    "kinks on corners of small cells": [(2.0, 2.0), (2.25, 2.125), (2.5, 2.0), (4.0, 3.0)],
    "far off": [(1.31, 2.22), (5.67, 4.41)],
    "far off and kinked": KINKED,
}


def fault(build, points: np.ndarray, support: float, levels: int = 0) -> str:
    """What is wrong with the elements along a crack, empty if nothing is; cells are small at its first end."""
    try:
        sample = build.block((6, 5), [build.crack(points)], support, levels, np.round(points[:1], 2))
    except GeometryError as error:
        return str(error)
    elements, edges = sample.cover.elements, sample.cover.elements.lines[0]
    corners = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    lengths = np.hypot(*(edges.points[:, 1] - edges.points[:, 0]).T)
    segment = np.searchsorted(corners[1:-1], edges.s.mean(axis=1))
    wrong = {
        "area": abs(areas(sample.lattice, elements).sum() - 30.0) > 30.0 * AREA,
        "empty": areas(sample.lattice, elements).min() <= 0.0,
        "length": abs(lengths.sum() - corners[-1]) > 1e-8,  # rounding moves each end by 1e-9
        "arc": abs(edges.s[-1, 1] - corners[-1]) > 1e-8 or np.abs(np.diff(edges.s)[:, 0] - lengths).max() > 1e-8,
        "segment": (edges.segment != segment).any(),
        "side": not on_their_sides(elements, 0).all() or np.intersect1d(edges.plus, edges.minus).size,
        "gap": (edges.points[1:, 0] != edges.points[:-1, 1]).any(),
        "count": elements.is_crack.sum() != len(edges.s),
    }
    return ", ".join(name for name, is_wrong in wrong.items() if is_wrong)


def shifted(place: str, offset: float) -> list[np.ndarray]:
    """The crack of a place moved off by `offset` along y, along both axes, and at its last end only."""
    points = np.array(PLACES[place])
    last = np.arange(len(points))[:, None] == len(points) - 1
    return [points + offset * np.array(way) for way in ((0.0, 1.0), (-1.0, 1.0), last * (1.0, -1.0))]


@pytest.mark.physics
@pytest.mark.parametrize(("levels", "support"), [(0, 1.5), (2, 2.0), (6, 2.0)])
@pytest.mark.parametrize("place", PLACES)
def test_awkward_places_cut_cleanly(build, place: str, support: float, levels: int) -> None:
    """Exactly on lattice lines, nodes and corners and just off them; a part of the crack lies in cells of 2^-levels."""
    for offset in OFFSETS:
        assert [fault(build, points, support, levels) for points in shifted(place, offset)] == [""] * 3, offset


def test_lines_that_meet_within_rounding_of_a_tile_line_cut_the_tile_beyond_it_as_well() -> None:
    """Lines that pass a grid step above and below (4, 3.5) cross left of it: tiles on the right need that one too."""
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


LEVELS = (0, 1, 3, 6)


def boxes(squares: Squares) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corners (n, 2) of squares, quanta."""
    return squares.low, squares.low + squares.size[:, None]


def area(squares: Squares) -> int:
    return int((squares.size**2).sum())


@pytest.mark.parametrize("levels", LEVELS)
def test_cells_are_divided_until_none_is_more_than_twice_as_large_as_one_that_it_touches(levels: int) -> None:
    rng = np.random.default_rng(levels)
    low, size = np.array([(0, 0), (QUANTA, 0), (0, QUANTA), (QUANTA, QUANTA)]), np.full(4, QUANTA)
    for _ in range(levels):
        one = np.arange(len(size)) == rng.choice(np.flatnonzero(size == size.min()))
        quarters = quarters_of(low[one], size[one])
        low, size = (np.concatenate([a[~one], b]) for a, b in zip((low, size), quarters, strict=True))
    cells = balanced(squares_of(low, size))
    low, high = boxes(cells)
    assert area(cells) == np.prod(high.max(axis=0))
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
        fine = refined(lattice, SizeField(shapely.points(place[None]), np.array([0.5**levels]), np.array([rings])))
        side, away = fine.cells.size / QUANTA, distances(fine, place)
        assert side[away == 0.0].max() == 0.5**levels == side.min()
        assert not ((side > 0.5**levels) & (away <= rings * side)).any()
        # a cell is the quarter of one that was near, or that touches one whose quarters are
        assert (away[side < 1.0] <= ((rings + 1.0) * 2.0 * side + 2.0 * side)[side < 1.0]).all()


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


@pytest.mark.parametrize("support", SUPPORTS)
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
