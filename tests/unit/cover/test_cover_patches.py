"""Physical patches: as many as connected pieces, one per node of the window, singular where a tip ends."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from tests.unit.cover_tables import patch_table
from tests.unit.regular_functions import regular_window

SUPPORTS = (1.5, 1.75, 2.0, 2.5)
KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]
THROUGH = [(0.5, 2.3), (3.2, 2.9), (6.5, 3.6)]
LAYOUTS = {
    "uncut": [],
    "kinked": [(KINKED, (True, True))],
    "from the left side": [([(0.5, 2.2), (3.1, 2.7)], (False, True))],
    "through": [(THROUGH, (False, False))],
    "two": [(KINKED, (True, True)), ([(4.4, 1.3), (5.2, 4.8)], (True, True))],
    "meeting": [(THROUGH, (False, False)), ([(3.2, 2.9), (2.7, 5.5)], (False, False))],
    "steep bend": [([(2.0, 1.3), (4.2, 3.0), (2.1, 4.4)], (True, True))],
}
HAIR = 1e-6
"""Half width, in spacings, of the strips that stand for cracks."""


def layout(build, name: str, support: float):
    cracks = [build.crack(points, tips, str(k)) for k, (points, tips) in enumerate(LAYOUTS[name])]
    return build.block((6, 5), cracks, support)


def square(sample, node: np.ndarray) -> shapely.Polygon:
    return shapely.box(*(node - sample.lattice.support), *(node + sample.lattice.support))


def pieces(sample, node: np.ndarray) -> list[shapely.Polygon]:
    """Connected parts of the node's square in the body without the cracks; parts of a hair's width are left out."""
    part = sample.region.intersection(square(sample, node))
    for crack in sample.cover.cracks:
        part = part.difference(shapely.LineString(crack.points).buffer(HAIR, cap_style="square"))
    return [piece for piece in shapely.get_parts(part) if piece.area > 1e-4]


@pytest.mark.parametrize("support", SUPPORTS)
@pytest.mark.parametrize("name", LAYOUTS)
def test_a_node_has_one_patch_for_each_connected_piece(build, name: str, support: float) -> None:
    sample = layout(build, name, support)
    counts = {tuple(node): 0 for node in np.ndindex(sample.lattice.shape[0] + 1, sample.lattice.shape[1] + 1)}
    expected = {node: len(pieces(sample, np.array(node, dtype=float))) for node in counts}
    for node in sample.cover.patches.nodes:
        counts[tuple(node)] += 1
    assert counts == expected


@pytest.mark.parametrize("support", SUPPORTS)
@pytest.mark.parametrize("name", LAYOUTS)
def test_elements_share_a_patch_exactly_if_they_share_a_piece(build, name: str, support: float) -> None:
    """Checked node by node with the geometry itself, not with the graph that numbered the patches."""
    sample = layout(build, name, support)
    cover = sample.cover
    for node in np.array([[2, 2], [3, 3], [4, 2], [4, 4]]) + sample.lattice.reach:
        parts = pieces(sample, node)
        columns = patch_table(cover)
        owners = np.where((columns >= 0) & (cover.patches.nodes[columns] == node).all(axis=2), columns, -1).max(axis=1)
        inside = np.flatnonzero(owners >= 0)
        contains = np.array([shapely.contains_xy(part, cover.elements.reference[inside]) for part in parts])
        np.testing.assert_array_equal(contains.sum(axis=0), 1)
        pairs = np.unique(np.stack([contains.argmax(axis=0), owners[inside]], axis=1), axis=0)
        assert len(pairs) == len(parts) == len(np.unique(pairs[:, 1]))


@pytest.mark.parametrize("support", SUPPORTS)
@pytest.mark.parametrize("name", LAYOUTS)
def test_every_element_has_one_patch_of_each_node_that_covers_it(build, name: str, support: float) -> None:
    sample = layout(build, name, support)
    cover = sample.cover
    nodes = cover.elements.cell[:, None] + regular_window(support)[None]
    depth = support - np.abs(nodes - cover.elements.reference[:, None]).max(axis=2)
    table = patch_table(cover)
    used = table >= 0
    np.testing.assert_array_equal(used, depth > 0.0)
    np.testing.assert_array_equal(cover.patches.nodes[table[used]], nodes[used])
    np.testing.assert_array_equal(np.unique(table[used]), np.arange(len(cover.patches.nodes)))


def test_fully_cut_patch_falls_in_two_and_the_one_round_a_tip_stays_one(build) -> None:
    cover = build.block((6, 5), [build.crack([(0.5, 2.3), (4.2, 2.7)], (False, True))]).cover
    count = {tuple(node): 0 for node in cover.patches.nodes - 2}
    for node in cover.patches.nodes - 2:
        count[tuple(node)] += 1
    assert count[(2, 2)] == 2
    assert count[(2, 3)] == 2
    assert count[(4, 3)] == 1
    assert count[(5, 5)] == 1
    edges = cover.elements.lines[0]
    plus, minus = (cover.patches.of_element.of(side[0]) for side in (edges.plus, edges.minus))
    assert len(plus) == len(minus) > 0
    assert len(np.intersect1d(plus, minus)) == 0


@pytest.mark.parametrize("support", SUPPORTS)
@pytest.mark.parametrize("name", ["kinked", "from the left side", "two", "steep bend"])
def test_singular_patches_hold_the_tip_and_are_not_cut_through(build, name: str, support: float) -> None:
    """A tip is inside of one piece: the piece that touches both of the faces next to it."""
    sample = layout(build, name, support)
    cover = sample.cover
    assert len(cover.tips) == sum(sum(tips) for _, tips in LAYOUTS[name])
    for tip in cover.tips:
        points = tip.points
        away = (points[1] - points[0]) / np.hypot(*(points[1] - points[0]))
        left = np.array([-away[1], away[0]])
        faces = points[0] + 1e-3 * away + 1e-4 * np.stack([left, -left])
        expected = 0
        for node in np.unique(cover.patches.nodes, axis=0):
            holds = np.abs(points[0] - node).max() < support - 1e-3
            sides = [part for part in pieces(sample, node) if holds and shapely.contains_xy(part, faces).all()]
            expected += len(sides)
            singular = (cover.patches.nodes[tip.patches] == node).all(axis=1).sum()
            assert singular == len(sides), (name, node, points[0])
        assert expected > 0


def test_function_numbers_are_dense_and_four_by_four(build) -> None:
    cover = layout(build, "two", 2.0).cover
    starts = np.concatenate([tip.functions for tip in cover.tips])
    n_patches = len(cover.patches.nodes)
    np.testing.assert_array_equal(starts, n_patches + 4 * np.arange(len(starts)))
    assert cover.n_functions == n_patches + 4 * len(starts)
    assert cover.n_dofs == 2 * cover.n_functions


def test_patches_that_only_touch_the_body_are_left_out(build) -> None:
    """Support 2.5 on a body from 0.5: the squares of the nodes at -2 end on the body's side."""
    sample = build.block((6, 5), support=2.5)
    assert sample.cover.patches.nodes.min() - sample.lattice.reach == -1


def test_a_corner_cut_off_where_the_weight_is_below_round_off_gets_no_patch(build) -> None:
    """The crack passes the corner (3.5, 2.5) of the square of node (5, 1) at 0.01 spacings: weight 1e-16 there."""
    near = build.block((6, 5), [build.crack([(2.0, 1.4), (4.2, 3.0)])])
    node = np.array([5, 1]) + near.lattice.reach
    assert len(pieces(near, node)) == 1  # the corner's area, 6e-5, counts for nothing
    element = np.flatnonzero(shapely.contains_xy(near.cover.elements.polygons, 5.503, 4.497))[0]
    element += near.cover.elements.n_whole
    assert not (near.cover.patches.nodes[near.cover.patches.of_element.of(element)] == node).all(axis=1).any()
    assert (near.cover.patches.nodes == node).all(axis=1).sum() == 1
