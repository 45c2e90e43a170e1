"""Junctions: lines that meet share a vertex to the last bit, and the cover knows the sides of every branch."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crackgrow.approximation.basis import values_at
from crackgrow.case.surface import SurfaceName, crack_name
from crackgrow.cover.cover import build_cover
from crackgrow.cover.junctions import with_junctions
from crackgrow.cover.lattice import place_lattice
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.geometry.tolerance import GRID, TOUCH
from tests.unit.exact_fields import areas, function_table, on_their_sides

SUPPORTS = (1.5, 2.0, 2.5)
P = (3.5, 2.875)  # on the grid of the arrangement
MAIN = [(1.7, 2.2), (5.3, 3.55)]  # P is its middle
TO_P = [(1.7, 2.2), P]
STEEP = [P, (3.1, 5.1)]
DOWN = [P, (5.1, 2.1)]
NEAR_P = (P[0] + 3e-7, P[1])
ACROSS = [(2.9, 1.2), (3.6, 5.1)]
MET = tuple(np.array(shapely.LineString(MAIN).intersection(shapely.LineString(ACROSS)).coords[0]))


def lines_of(*paths, tips=(True, True)) -> list[CrackGeometry]:
    return [CrackGeometry(crack_name(str(k)), np.array(path, dtype=float), *tips) for k, path in enumerate(paths)]


def joined_points(line: CrackGeometry) -> list[tuple[float, ...]]:
    return [tuple(point) for point in line.points[line.junctions].tolist()]


def joined(line: CrackGeometry) -> str:
    """A line in one character a vertex: > or < a tip, + a junction, . any other."""
    marks = ["+" if junction else "." for junction in line.junctions]
    ends = (0, line.tip_at_start, "<"), (-1, line.tip_at_end, ">")
    for end, is_tip, mark in ends:
        assert not (is_tip and line.junctions[end])
        marks[end] = mark if is_tip else marks[end]
    return "".join(marks)


def stopped(off: float) -> list[tuple[float, float]]:
    """The line STEEP with its foot `off` away from P along it: a negative one pokes through MAIN."""
    along = np.subtract(*STEEP[::-1]) / np.hypot(*np.subtract(*STEEP))
    return [tuple(P + off * along), STEEP[1]]


MEETINGS = {
    "apart": ([MAIN, [(1.0, 4.0), (3.0, 4.5)], [(5.3 + 3 * TOUCH, 3.6), (6.0, 3.6)]], ["<>", "<>", "<>"], None),
    "crossing": ([MAIN, ACROSS], ["<+>", "<+>"], MET),
    **{f"stopped {off}": ([MAIN, stopped(off)], ["<+>", "+>"], P) for off in (0.0, 1e-7, -1e-7, 9e-7, -9e-7, -2e-6)},
    "stopped short by more than rounding": ([MAIN, stopped(1e-3)], ["<>", "<>"], None),
    "ends that meet": ([TO_P, STEEP, DOWN], ["<+", "+>", "+>"], P),
    "a ring": ([[(1.7, 2.2), (5.3, 3.6), (5.0, 1.3), (1.7 + 1e-7, 2.2)]], ["+..+"], (1.7, 2.2)),
    "back onto its path": ([[*MAIN, (5.0, 1.3), (3.0, 1.2), P]], ["<+...+"], P),
    "across itself": ([[(1.7, 2.2), (5.3, 3.6), (5.3, 2.2), (1.7, 3.6)]], ["<+..+>"], (3.5, 2.9)),
    "vertices of both": ([[MAIN[0], P, (5.3, 2.2)], [(1.5, 3.7), NEAR_P, (5.0, 4.1)]], ["<+>", "<+>"], P),
}
"""Lines, what becomes of them, and where they meet."""


@pytest.mark.parametrize("name", MEETINGS)
def test_lines_that_meet_share_a_vertex_and_ends_on_lines_are_no_tips(name: str) -> None:
    paths, marks, place = MEETINGS[name]
    given = lines_of(*paths)
    lines = with_junctions(given)
    assert [joined(line) for line in lines] == marks
    if place is None:
        assert all(one is other for one, other in zip(lines, given, strict=True))
    else:
        (point,) = {point for line in lines for point in joined_points(line)}
        tolerance = 3 * TOUCH if name.startswith("stopped") else 1e-7 if name == "a ring" else 2 * GRID
        np.testing.assert_allclose(point, place, rtol=0.0, atol=tolerance)


@pytest.mark.parametrize("seed", range(20))
def test_lines_through_one_place_share_one_vertex(seed: int) -> None:
    """Their crossings, pair by pair, differ by round-off."""
    rng = np.random.default_rng(seed)
    angles = np.linspace(0.0, np.pi, 5)[:-1] + rng.uniform(-0.2, 0.2, 4)
    away = np.stack([np.cos(angles), np.sin(angles)], axis=1) * rng.uniform(1.0, 2.0, (4, 1))
    place = rng.uniform(2.0, 4.0, 2)
    ends = np.rint(np.stack([place - away, place + away * rng.uniform(0.5, 2.0)], axis=1) / GRID) * GRID
    lines = with_junctions(lines_of(*ends))
    places = {point for line in lines for point in joined_points(line)}
    assert len(places) == 1
    assert [line.junctions.tolist() for line in lines] == [[False, True, False]] * 4
    np.testing.assert_allclose(places.pop(), place, atol=1e-8)


@pytest.mark.parametrize("off", [0.0, 1e-9, 1e-7, 5e-7, -5e-7])
def test_crack_on_an_interface_does_not_bend_it_off_its_bodies(off: float) -> None:
    """Two bodies, one on top of the other, the crack in the lower one."""
    lattice = place_lattice(np.array([0.5, 0.5]), np.array([6.5, 5.5]), 1.0, 2.0)
    across = np.array([(0.5, 2.7), (6.5, 3.4)])
    lower = np.array([(0.5, 0.5), (6.5, 0.5), *across[::-1]])
    upper = np.array([*across, (6.5, 5.5), (0.5, 5.5)])
    bodies = [BodyGeometry((lattice.to_lattice(outline),)) for outline in (lower, upper)]
    foot = across[0] + 0.45 * (across[1] - across[0])
    crack = CrackGeometry(
        crack_name("crack"), lattice.to_lattice(np.array([(2.0, 1.4), (foot[0], foot[1] + off)])), True, False
    )
    interface = CrackGeometry(SurfaceName("interface", ("left", "right")), lattice.to_lattice(across), False, False)
    cover = build_cover(lattice, bodies, [crack], [interface])
    assert cover.cracks[0].junctions.tolist() == [False, True]
    edges = cover.elements.lines[1]
    assert edges.s[-1, 1] == pytest.approx(np.hypot(*(across[1] - across[0])), abs=1e-8)
    assert set(cover.elements.body[edges.plus]) == {1}
    assert set(cover.elements.body[edges.minus]) == {0}


LAYOUTS = {
    "X": [MAIN, [(2.9, 1.2), (3.6, 5.1)]],
    "T": [MAIN, STEEP],
    "V": [TO_P, STEEP],
    "Y": [TO_P, STEEP, DOWN],
    "three": [MAIN, [(2.9, 1.2), (4.1, 4.55)], [(2.8, 4.0), (4.2, 1.75)]],
    "oblique": [MAIN, [P, (5.2, 4.1)]],
    "near a tip": [[(1.7, 2.2), (4.1, 2.5)], [(3.9, 2.475), (4.2, 3.4)]],
    "own path": [[*MAIN, (5.0, 1.3), (3.0, 1.2), P]],
    "ring": [[(1.7, 2.2), (5.3, 3.6), (5.0, 1.3), (1.7, 2.2)]],
    "eight": [[(1.7, 2.2), (5.3, 3.6), (5.3, 2.2), (1.7, 3.6)]],
    "lattice lines": [[(1.3, 3.0), (5.0, 3.0)], [(3.0, 1.2), (3.0, 5.0)]],
    "nodes": [[(1.0, 1.0), (5.0, 5.0)], [(1.0, 5.0), (5.0, 1.0)]],
    "short hooks": [TO_P, [P, (3.6, 3.3)], [P, (3.8, 2.7)]],
}


def sample_of(build, name: str, support: float):
    return build.block((6, 5), [build.crack(path, name=str(k)) for k, path in enumerate(LAYOUTS[name])], support)


@pytest.mark.parametrize("support", SUPPORTS)
@pytest.mark.parametrize("name", LAYOUTS)
def test_edges_lead_along_every_line_with_plus_on_its_left(build, name: str, support: float) -> None:
    sample = sample_of(build, name, support)
    elements = sample.cover.elements
    assert areas(sample.lattice, elements).sum() == pytest.approx(30.0, rel=1e-7)
    for number, (line, path) in enumerate(zip(sample.cover.cracks, LAYOUTS[name], strict=True)):
        edges = elements.lines[number]
        np.testing.assert_array_equal(edges.points[1:, 0], edges.points[:-1, 1])
        np.testing.assert_array_equal(edges.points[[0, -1], [0, 1]], line.points[[0, -1]])
        assert edges.s[-1, 1] == pytest.approx(np.hypot(*np.diff(path, axis=0).T).sum(), abs=1e-8)
        assert on_their_sides(elements, number).all()
        assert not np.any(edges.plus == edges.minus)


@pytest.mark.parametrize("support", SUPPORTS)
@pytest.mark.parametrize("name", LAYOUTS)
def test_tip_functions_jump_on_their_own_crack_alone(build, name: str, support: float) -> None:
    """Function by function, where a singular patch lies on both sides of a crack: only the tip's own one may cut it."""
    cover = sample_of(build, name, support).cover
    for number, edges in enumerate(cover.elements.lines):
        middle = edges.points.mean(axis=1)
        values = np.zeros((2, len(middle), cover.n_functions))
        seen = np.zeros((2, len(middle), len(cover.patches.nodes)), dtype=bool)
        for k, side in enumerate((edges.plus, edges.minus)):
            values[k] = values_at(cover, middle, side).toarray()
            patches = cover.patches.of_element.taken(side)
            seen[k, patches.row, patches.values] = True
        for tip, first in zip(cover.tips, function_table(cover), strict=True):
            edge, patch = np.nonzero(seen.all(axis=0) & (first >= 0))
            jumps = values[0, edge, first[patch] + 1] - values[1, edge, first[patch] + 1]  # sqrt(r) sin(t/2)
            r = np.hypot(*(middle[edge] - tip.point).T)
            fade = np.maximum(1.0 - (r / tip.fade) ** 2, 0.0) ** 2
            from_tip = edges.segment.max() - edges.segment if tip.at_end else edges.segment
            own = (tip.crack == number) & (from_tip[edge] < len(tip.path) - 1)  # up to where the crack turns back
            expected = own * 2.0 * np.sqrt(r) * fade * values[0, edge, patch]
            np.testing.assert_allclose(np.abs(jumps), expected, atol=1e-8)
