"""Physical patches: as many as connected pieces, one per node of the window, singular where a tip ends."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
import shapely

from tests.unit.cover_tables import cells_of, function_table, patch_table, regular_window

SUPPORTS = (1.5, 1.75, 2.0, 2.5)
KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]
THROUGH = [(0.5, 2.3), (3.2, 2.9), (6.5, 3.6)]
BOTH, NONE = (True, True), (False, False)
LAYOUTS = {
    "uncut": [],
    "kinked": [(KINKED, BOTH)],
    "from the left side": [([(0.5, 2.2), (3.1, 2.7)], (False, True))],
    "through": [(THROUGH, NONE)],
    "two": [(KINKED, BOTH), ([(4.4, 1.3), (5.2, 4.8)], BOTH)],
    "meeting": [(THROUGH, NONE), ([(3.2, 2.9), (2.7, 5.5)], NONE)],
    "steep bend": [([(2.0, 1.3), (4.2, 3.0), (2.1, 4.4)], BOTH)],
    "crossing": [([(1.1, 2.3), (5.4, 3.3)], BOTH), ([(2.8, 1.2), (3.2, 3.3)], BOTH)],
    "ring": [([(2.4, 2.4), (3.6, 2.5), (3.0, 3.7), (2.4, 2.4)], NONE)],
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
def test_a_node_has_one_patch_for_each_connected_piece_which_elements_there_share(
    build, name: str, support: float
) -> None:
    """Checked node by node with the geometry itself, not with the graph that numbered the patches."""
    sample = layout(build, name, support)
    patches, elements, table = sample.cover.patches, sample.cover.elements, patch_table(sample.cover)
    parts = {
        node: pieces(sample, np.array(node, dtype=float))
        for node in np.ndindex(sample.lattice.shape[0] + 1, sample.lattice.shape[1] + 1)
    }
    counts = Counter(map(tuple, patches.nodes))
    assert counts == {node: len(found) for node, found in parts.items() if found}
    for node in np.array([[2, 2], [3, 3], [4, 2], [4, 4]]) + math.ceil(support):
        owners = np.where((table >= 0) & (patches.nodes[table] == node).all(axis=2), table, -1).max(axis=1)
        inside = np.flatnonzero(owners >= 0)
        contains = np.array([shapely.contains_xy(part, elements.reference[inside]) for part in parts[tuple(node)]])
        np.testing.assert_array_equal(contains.sum(axis=0), 1)
        pairs = np.unique(np.stack([contains.argmax(axis=0), owners[inside]], axis=1), axis=0)
        assert len(pairs) == len(contains) == len(np.unique(pairs[:, 1]))
    nodes, used = cells_of(sample.cover)[:, None] + regular_window(support)[None], table >= 0
    np.testing.assert_array_equal(used, np.abs(nodes - elements.reference[:, None]).max(axis=2) < support)
    np.testing.assert_array_equal(patches.nodes[table[used]], nodes[used])
    np.testing.assert_array_equal(np.unique(table[used]), np.arange(len(patches.nodes)))
    assert len(sample.cover.tips) == sum(sum(tips) for _, tips in LAYOUTS[name])
    for tip in sample.cover.tips:  # inside of one piece: that which touches both of the faces next to it
        place, away = tip.point, (tip.points[1] - tip.points[0]) / np.hypot(*(tip.points[1] - tip.points[0]))
        faces = place + 1e-3 * away + 1e-4 * np.array([[-away[1], away[0]], [away[1], -away[0]]])
        singular = Counter(map(tuple, patches.nodes[tip.patches]))
        for node, found in parts.items():
            holds = np.abs(place - node).max() < support - 1e-3
            assert singular[node] == sum(holds and shapely.contains_xy(part, faces).all() for part in found)
        assert singular


def test_a_corner_cut_off_where_the_weight_is_below_round_off_gets_no_patch(build) -> None:
    """The crack passes the corner (3.5, 2.5) of the square of node (5, 1) at 0.01 spacings: weight 1e-16 there."""
    near = build.block((6, 5), [build.crack([(2.0, 1.4), (4.2, 3.0)])])
    node = np.array([5, 1]) + 2
    assert len(pieces(near, node)) == 1  # the corner's area, 6e-5, counts for nothing
    element = np.flatnonzero(shapely.contains_xy(near.cover.elements.polygons, 5.503, 4.497))[0]
    element += near.cover.elements.n_whole
    assert not (near.cover.patches.nodes[near.cover.patches.of_element.of(element)] == node).all(axis=1).any()
    assert (near.cover.patches.nodes == node).all(axis=1).sum() == 1


@pytest.mark.parametrize("name", ["many", "uncut"])
def test_an_element_lists_each_singular_patch_over_it_once_with_its_functions(build, name: str) -> None:
    cover = (build.field_of_cracks(2) if name == "many" else layout(build, name, 2.0)).cover
    enrichment = cover.enrichment
    carrier, of_element = enrichment.place.row, cover.patches.of_element
    pair, number = enrichment.first.row[carrier], enrichment.first.values[carrier]
    element, tip = enrichment.tips.row[pair], enrichment.tips.values[pair]
    patch = of_element.values[of_element.start[element] + enrichment.place.values]
    listed = list(zip(element.tolist(), tip.tolist(), patch.tolist(), strict=True))
    first = function_table(cover)
    expected = [
        (e, t, p)
        for e, p in zip(of_element.row.tolist(), of_element.values.tolist(), strict=True)
        for t in np.flatnonzero(first[:, p] >= 0).tolist()
    ]
    assert sorted(listed) == sorted(expected)
    np.testing.assert_array_equal(number, first[tip, patch])
    np.testing.assert_array_equal(enrichment.share, 1.0)
    assert enrichment.acted_on.any() == (name == "many")


OFF = (0.0, 1e-15, 1e-9, 1e-7, 1e-5)


@pytest.mark.physics
@pytest.mark.parametrize("levels", [1, 3, 6])
@pytest.mark.parametrize("support", [1.5, 2.0, 2.5, 3.0])
def test_a_tip_among_small_cells_has_the_functions_of_these(build, support: float, levels: int) -> None:
    """No more patches than in cells of one size hold it, also within rounding of a corner."""
    for off in (*OFF, 0.43 * 0.5**levels):
        tips = np.array([(3.0 + off, 3.0 - off), (5.3, 4.6)])
        cover = build.block((7, 6), [build.crack(tips)], support, levels, tips).cover
        assert [tip.size for tip in cover.tips] == [0.5**levels] * 2
        assert max(len(tip.patches) for tip in cover.tips) <= (2.0 * support) ** 2
