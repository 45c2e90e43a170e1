"""Physical patches: one a connected piece; tips: their angle, where their functions fade, which are gathered."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
import shapely

from crackgrow.cover.gathered import RADIUS, STRAIGHT
from crackgrow.cover.tips import crack_angle, seen_from_tip, tip_angle
from tests.unit.exact_fields import cells_of, patch_table

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


def pieces(sample, node: np.ndarray) -> list[shapely.Polygon]:
    """Connected parts of the node's square in the body without the cracks; parts of a hair's width are left out."""
    square = shapely.box(*(node - sample.lattice.support), *(node + sample.lattice.support))
    part = sample.region.intersection(square)
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
    steps, used = np.arange(1.0 - math.ceil(support), math.ceil(support) + 1.0), table >= 0
    window = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    nodes = cells_of(sample.cover)[:, None] + window
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


FROM_TIP = np.array([[4.0, 3.0], [3.2, 2.9], [2.6, 2.3], [1.6, 2.5]])
"""Seen from the tip; every circle round it meets the crack once."""

HAND = np.array([[0.3, -0.2], [0.1, 0.2], [-0.5, 0.4]])


def directions(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    along = np.diff(points, axis=0)
    along /= np.hypot(*along.T)[:, None]
    return along, np.stack([-along[:, 1], along[:, 0]], axis=1)


@pytest.mark.parametrize("points", [FROM_TIP, HAND])
def test_angle_jumps_by_two_pi_across_the_crack(points: np.ndarray) -> None:
    """It is pi on the left of the last segment; beyond, that at which the crack lies there."""
    tip = seen_from_tip(points, 1.0, ends_inside=False)
    along, left = directions(points)
    share = np.linspace(0.05, 0.95, 19)[:, None]
    for k in range(len(along)):
        on = points[k] + share * (points[k + 1] - points[k])
        # from the tip on, the left of the crack's direction is the side of t near -pi
        _, low = tip_angle(tip, on, on + 1e-7 * left[k])
        _, high = tip_angle(tip, on, on - 1e-7 * left[k])
        np.testing.assert_allclose(high - low, 2 * np.pi, rtol=1e-14)
        local = (on - points[0]) @ tip.rotation.T
        true = np.mod(np.arctan2(local[:, 1], local[:, 0]), 2 * np.pi) if k else np.pi
        np.testing.assert_allclose(high, true, atol=1e-12)
        np.testing.assert_allclose(crack_angle(tip, np.hypot(*local.T)), true, atol=1e-12)


BACK = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 0.5], [-3.0, 0.5]])
"""The second segment comes nearer to the tip again: the angle is not known beyond its start."""
CORNER = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]])
LENGTH = float(np.hypot(*(FROM_TIP[-1] - FROM_TIP[0])))


@pytest.mark.parametrize(
    ("points", "reach", "ends_inside", "fade"),
    [
        (FROM_TIP, 5.0, True, LENGTH),
        (FROM_TIP, 0.9 * LENGTH, True, np.inf),
        (FROM_TIP, 5.0, False, np.inf),
        (BACK, 5.0, False, 2.0),
        (BACK, 1.9, False, np.inf),
        (CORNER, 5.0, False, np.inf),
        (CORNER, 5.0, True, np.sqrt(5.0)),
    ],
)
def test_tip_functions_fade_within_reach_at_the_other_tip_and_where_the_crack_turns_back(
    points: np.ndarray, reach: float, ends_inside: bool, fade: float
) -> None:
    tip = seen_from_tip(points, reach, ends_inside)
    assert tip.fade == pytest.approx(fade)
    assert points is not BACK or reach < 2.0 or tip.radii.tolist() == [0.0, 2.0]


SIZE = (24, 20)
CRACK = [(7.3, 10.2), (16.4, 11.4)]
"""Its tips have room for each other, and to the outline of a body of `SIZE`."""


def test_a_gathered_tip_has_three_carriers_whatever_patches_there_are(build) -> None:
    """One, x and y from the tip, faded out; over all patches within R, on both sides of the crack."""
    cover = build.block(SIZE, [build.crack(CRACK, gathered=True)], 2.0).cover
    assert cover.n_functions == len(cover.patches.nodes) + 2 * 4 * 3
    for tip in cover.tips:
        assert tip.carriers.n == 3
        off = cover.patches.nodes - tip.point
        near = np.flatnonzero(np.hypot(*off.T) < RADIUS)
        chi = (1.0 - (np.hypot(*off[near].T) / RADIUS) ** 4) ** 2
        np.testing.assert_array_equal(tip.patches.reshape(3, -1), [near] * 3)
        np.testing.assert_allclose(tip.carriers.shares.reshape(3, -1), chi * [np.ones(len(near)), *off[near].T])
        nodes = cover.patches.nodes[near]
        assert len(np.unique(nodes, axis=0)) < len(nodes)  # the crack cuts some of them in two


def gathered_at(build, *cracks: list, levels: int = 0, places=(), size=SIZE) -> list[bool]:
    """Whether the functions of each tip are gathered."""
    lines = [build.crack(points, name=f"crack {k}", gathered=True) for k, points in enumerate(cracks)]
    sample = build.block(size, lines, 2.0, levels, places)
    return [tip.carriers.gathered for tip in sample.cover.tips]


@pytest.mark.parametrize(("share", "room"), [(0.95, False), (1.05, True)])
def test_functions_are_gathered_where_nothing_else_is_within_the_radius(build, share: float, room: bool) -> None:
    """Nor a kink within the length that must be straight, nor the crack's other end where functions are still seen."""
    away = share * RADIUS
    ahead, beside = [(16.4 + away, 8.0), (16.4 + away, 15.0)], [(12.0, 11.4 + away), (20.0, 11.4 + away)]
    assert gathered_at(build, CRACK, ahead, size=(40, 20))[:2] == [True, room]
    assert gathered_at(build, CRACK, beside, size=(24, 30))[:2] == [True, room]
    assert gathered_at(build, [(14.5 - away, 10.2), (24.5 - away, 10.4)]) == [True, room]  # the outline is at 24.5
    assert gathered_at(build, [*CRACK, (16.4, 11.4 + share * STRAIGHT)]) == [True, room]
    length = 8.5 if room else 7.5  # the radius and half the diagonal of a patch
    assert gathered_at(build, [(7.3, 10.2), (7.3 + length, 10.2)]) == [room, room]
    from_side = build.crack([(0.5, 10.2), (0.5 + length, 10.2)], (False, True), gathered=True)
    assert build.block(SIZE, [from_side], 2.0).cover.tips[0].carriers.gathered is room


def test_the_radius_goes_by_the_cells_at_the_tip_and_a_crack_that_turns_back_has_none(build) -> None:
    beside = [(14.0, 13.4), (20.0, 13.4)]
    assert gathered_at(build, CRACK, beside)[1] is False
    assert gathered_at(build, CRACK, beside, levels=2, places=[CRACK[1]])[1] is True
    assert gathered_at(build, [(16.0, 14.2), (13.0, 12.2), (8.0, 11.4), (15.0, 10.2)])[1] is False
