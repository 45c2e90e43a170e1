"""Supports and loads: multipliers along edges, resultants of tractions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from crackgrow.approximation.basis import values_at
from crackgrow.case.model import EdgePressure, EdgeRegion, EdgeSupport, EdgeTraction, PointSupport
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.errors import GeometryError
from crackgrow.solid.loads import load_vector
from crackgrow.solid.recovery import displacement_at, stress_at
from crackgrow.solid.supports import EdgePoints, constraints, points_along

SIDES = {"bottom": 6.0, "right": 5.0, "top": 6.0, "left": 5.0}
KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]


def edge_points(cover: Cover, regions: Sequence[EdgeRegion]) -> list[EdgePoints]:
    return points_along(cover, [cover.edges_on(region) for region in regions])


def resultant(sample, f: np.ndarray) -> np.ndarray:
    """Force (2,) and moment about the origin of a load vector: its work on the rigid motions."""
    nodes = sample.lattice.to_metres(sample.cover.patches.nodes)
    forces = f.reshape(-1, 2)[: len(nodes)]
    moment = np.sum(nodes[:, 0] * forces[:, 1] - nodes[:, 1] * forces[:, 0])
    return np.append(forces.sum(axis=0), moment)


@pytest.mark.parametrize("support", [1.5, 2.0])
@pytest.mark.parametrize("edge", SIDES)
def test_traction_has_its_resultant_force_and_moment(build, edge: str, support: float) -> None:
    sample = build.block((6, 5), [build.crack([(0.5, 2.2), (3.1, 2.7)], (False, True))], support)
    traction = (2.0, -3.0)
    f = load_vector(sample.cover, (sample.body,), (EdgeTraction(build.edge(edge), traction),), 4)
    middle = {"bottom": (3.5, 0.5), "right": (6.5, 3.0), "top": (3.5, 5.5), "left": (0.5, 3.0)}[edge]
    force = SIDES[edge] * np.array(traction)
    moment = middle[0] * force[1] - middle[1] * force[0]
    np.testing.assert_allclose(resultant(sample, f), [*force, moment], rtol=1e-7)  # ends are rounded by 1e-9


def test_traction_on_a_part_of_an_edge_has_the_parts_resultant(build) -> None:
    sample = build.block((6, 5), support=2.0)
    region = build.edge("right", 0.24, 0.72)
    f = load_vector(sample.cover, (sample.body,), (EdgeTraction(region, (1.0, 0.0)),), 4)
    np.testing.assert_allclose(resultant(sample, f), [2.4, 0.0, -2.4 * 2.9], atol=1e-8)


def test_a_formula_that_varies_within_a_cell_has_its_resultant(build) -> None:
    """A peak of a fiftieth of a cell between the points of the edge; a water table within a cell."""
    sample = build.block((6, 5), [build.crack([(0.5, 2.2), (3.1, 2.7)], (False, True))], support=2.0)
    place, width = 3.03, 0.02

    def peak(at: np.ndarray) -> np.ndarray:
        return np.exp(-(((at[:, 0] - place) / width) ** 2))

    f = load_vector(sample.cover, (sample.body,), (EdgeTraction(build.edge("top"), (0.0, peak)),), 4)
    force = np.sqrt(np.pi) * width
    np.testing.assert_allclose(resultant(sample, f), [0.0, force, place * force], atol=1e-5 * force)

    def water(at: np.ndarray) -> np.ndarray:
        return np.maximum(3.3 - at[:, 1], 0.0)

    f = load_vector(sample.cover, (sample.body,), (EdgePressure(build.edge("left"), water),), 4)
    force, depth = 0.5 * 2.8**2, 2.8  # from the ground at 0.5 up; a third of the depth above it
    np.testing.assert_allclose(resultant(sample, f), [force, 0.0, -force * (0.5 + depth / 3.0)], atol=1e-5 * force)


@pytest.mark.parametrize("edge", SIDES)
def test_pressure_is_traction_into_the_rock(build, edge: str) -> None:
    sample = build.block((6, 5), support=2.0)
    inward = {"bottom": (0.0, 3.0), "right": (-3.0, 0.0), "top": (0.0, -3.0), "left": (3.0, 0.0)}[edge]
    region = build.edge(edge, 0.24, 0.72)
    f, same = (
        load_vector(sample.cover, (sample.body,), (load,), 4)
        for load in (EdgePressure(region, 3.0), EdgeTraction(region, inward))
    )
    np.testing.assert_allclose(f, same, atol=1e-14)


def test_loads_add_up(build) -> None:
    sample = build.block((6, 5))
    one, two = (
        EdgeTraction(build.edge("top"), (1.0, 2.0)),
        EdgeTraction(build.edge("left"), (0.0, -1.0)),
    )
    together = load_vector(sample.cover, (sample.body,), (one, two), 4)
    single = [load_vector(sample.cover, (sample.body,), (load,), 4) for load in (one, two)]
    np.testing.assert_allclose(together, sum(single), atol=1e-15)


@pytest.mark.parametrize("edge", SIDES)
def test_edge_points_lie_on_the_edge_and_their_lengths_add_up(build, edge: str) -> None:
    sample = build.block((6, 5), [build.crack([(0.5, 2.2), (3.1, 2.7)], (False, True))])
    (found,) = edge_points(sample.cover, [build.edge(edge)])
    length, s = found.lengths, found.s
    metres = sample.lattice.to_metres(found.points)
    axis, value = {"bottom": (1, 0.5), "right": (0, 6.5), "top": (1, 5.5), "left": (0, 0.5)}[edge]
    np.testing.assert_allclose(metres[:, axis], value, rtol=1e-14)
    assert length.sum() == pytest.approx(SIDES[edge], rel=1e-8)
    assert 0.0 < s.min() < s.max() < SIDES[edge]
    assert length @ s == pytest.approx(SIDES[edge] ** 2 / 2, rel=1e-8)
    assert found.elements.min() >= 0


def test_edge_points_of_several_regions_are_those_of_each(build) -> None:
    sample = build.block((6, 5), [build.crack([(0.5, 2.2), (3.1, 2.7)], (False, True))])  # one edge has its mouth
    regions = [build.edge(edge) for edge in ("top", "left", "bottom")]
    together = edge_points(sample.cover, regions)
    for region, found in zip(regions, together, strict=True):
        (alone,) = edge_points(sample.cover, [region])
        for name in ("points", "lengths", "elements", "s"):
            np.testing.assert_array_equal(getattr(found, name), getattr(alone, name))


def test_an_edge_is_held_cell_by_cell_where_cells_are_small(build) -> None:
    """Held on average over a spacing the edge moves between small cells, and larger cells elsewhere do not tell it."""
    sample = build.block((8, 8), support=2.0, levels=3, places=[(8.5, 4.5)])
    (found,) = edge_points(sample.cover, [build.edge("right")])
    held = constraints(sample.cover, [EdgeSupport(build.edge("right"), (0.0, None))])
    sides = sample.cover.sizes[found.elements]
    assert sides.min() == 0.125
    n_cells = (found.lengths / sides).sum()
    assert len(held.given) == int(n_cells) + 1 > 20
    steps = np.diff(found.stretched) / np.diff(found.s)
    assert np.all(steps > 1.0 - 1e-9)
    assert np.all(steps < 8.0 + 1e-9)
    assert found.stretched.max() < n_cells  # no jumps where cells of two sizes meet


@pytest.mark.parametrize("quadrature", [3, 8])
def test_stretch_between_edge_supports_is_uniform(build, quadrature: int) -> None:
    """u_x = 0 left, 0.01 right, u_y = 0 bottom: free sides contract by Poisson's ratio; the field is linear."""
    sample = build.block((6, 5), support=2.0)
    held = [
        EdgeSupport(build.edge("left"), (0.0, None)),
        EdgeSupport(build.edge("right"), (0.01, None)),
        EdgeSupport(build.edge("bottom"), (None, 0.0)),
    ]
    u = sample.solve(held, {}, quadrature)
    metres = np.random.default_rng(50).uniform((0.5, 0.5), (6.5, 5.5), (200, 2))
    points = sample.lattice.to_lattice(metres)
    elements = locate(sample.lattice, sample.cover.elements, points)
    strain = 0.01 / 6
    ratio = -sample.material.c12 / sample.material.c11
    exact = (metres - 0.5) * (strain, ratio * strain)
    error = np.abs(displacement_at(sample.cover, u, points, elements) - exact).max() / 0.01
    assert error < {3: 1e-4, 8: 3e-6}[quadrature]  # quadrature noise of 3 x 3 and of 8 x 8 points
    stress = stress_at(sample.cover, [sample.material], u, points, elements)
    sxx = sample.material.c11 * strain + sample.material.c12 * ratio * strain
    np.testing.assert_allclose(stress, np.broadcast_to([sxx, 0, 0], stress.shape), atol=1e-3 * sxx)


def test_multipliers_are_the_reactions(build) -> None:
    """Pulled with a uniform traction at the top, held at the bottom: reactions sum to the pull."""
    sample = build.block((6, 5), [build.crack(KINKED)], 2.0)
    held = (EdgeSupport(build.edge("bottom"), (0.0, 0.0)),)
    system, given = sample.system(held)
    f = load_vector(sample.cover, (sample.body,), (EdgeTraction(build.edge("top"), (0.5, 2.0)),), 4)
    u, multipliers = system.solve(f, given)
    reactions = system.constraints.T @ multipliers
    np.testing.assert_allclose(resultant(sample, f - reactions), 0.0, atol=1e-8)
    assert np.abs(u).max() > 1.0


def test_constraint_rows_average_the_displacement_of_the_edge(build) -> None:
    """Each row gives a constant as it is, and their values of a linear field lie within the edge, in order."""
    sample = build.block((6, 5), support=2.0)
    held = constraints(sample.cover, (EdgeSupport(build.edge("right"), (0.3, None)),))
    nodes = sample.lattice.to_metres(sample.cover.patches.nodes)
    np.testing.assert_allclose(held.matrix @ np.tile([1.0, 7.0], len(nodes)), 1.0, rtol=1e-13)
    heights = held.matrix @ np.stack([nodes[:, 1], 0 * nodes[:, 0]], axis=1).ravel()
    np.testing.assert_allclose(heights[1:-1], [1.5, 2.5, 3.5, 4.5], atol=3e-2)  # 4 Gauss points on a kinked hat
    assert 0.5 < heights[0] < heights[1]
    assert heights[-2] < heights[-1] < 5.5
    np.testing.assert_array_equal(held.given, [0.3] * 6)


def test_point_support_holds_the_point_exactly(build) -> None:
    sample = build.block((6, 5), [build.crack(KINKED)])
    place = np.array([5.2, 1.3])
    held = [PointSupport("rock", place, (0.02, -0.01)), PointSupport("rock", np.array([0.5, 0.5]), (None, 0.0))]
    u = sample.solve(held, {"top": (0.0, 0.01), "bottom": (0.0, -0.01)})
    at = sample.lattice.to_lattice(place[None])
    element = locate(sample.lattice, sample.cover.elements, at)
    np.testing.assert_allclose(displacement_at(sample.cover, u, at, element), [[0.02, -0.01]], atol=1e-12)
    matrix = values_at(sample.cover, at, element).rows
    np.testing.assert_allclose(matrix @ u.reshape(-1, 2), [[0.02, -0.01]], atol=1e-12)


def test_point_support_outside_is_refused_with_its_place(build) -> None:
    sample = build.block((6, 5))
    with pytest.raises(GeometryError, match=r"\(7 m, 2 m\) lies outside"):
        constraints(sample.cover, (PointSupport("rock", np.array([7.0, 2.0]), (0.0, None)),))


def test_no_supports_give_an_empty_matrix(build) -> None:
    sample = build.block((6, 5))
    held = constraints(sample.cover, ())
    assert held.matrix.shape == (0, sample.cover.n_dofs)
    assert held.given.shape == (0,)
