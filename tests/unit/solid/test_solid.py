"""Elasticity, supports and loads: Hooke's law, resultants, what edges hold, free motions, loads that vary."""

from __future__ import annotations

import re

import numpy as np
import pytest

from crackgrow.case.formula import CoordinateFormula, parse_formula
from crackgrow.case.model import EdgePressure, EdgeSupport, EdgeTraction, ElasticBedding, PointSupport
from crackgrow.cover.elements import locate
from crackgrow.errors import FreePieceError, GeometryError
from crackgrow.solid.elasticity import energy_components, plane_elasticity
from crackgrow.solid.in_situ import InSitu
from crackgrow.solid.loads import load_vector
from crackgrow.solid.recovery import displacement_at
from crackgrow.solid.rigid_modes import free_motions
from crackgrow.solid.supports import constraints, points_along
from tests.conftest import Build, Sample
from tests.solving import steps_of

E, NU = 70e9, 0.3


def test_elasticity_inverts_the_flexibility_of_either_plane() -> None:
    strain, stress = (plane_elasticity(E, NU, plane) for plane in ("strain", "stress"))
    flexibility = np.array([[1, -NU, 0], [-NU, 1, 0], [0, 0, 2 * (1 + NU)]]) / E
    np.testing.assert_allclose(stress.matrix @ flexibility, np.eye(3), atol=1e-15)
    assert stress.young_prime == pytest.approx(E, rel=1e-15)
    assert not stress.zz.any()
    flexibility = (1 + NU) / E * np.array([[1 - NU, -NU, 0], [-NU, 1 - NU, 0], [0, 0, 2]])
    np.testing.assert_allclose(strain.matrix @ flexibility, np.eye(3), atol=1e-15)
    assert strain.young_prime == pytest.approx(E / 0.91, rel=1e-15)
    assert strain.zz == pytest.approx([NU, NU, 0.0])  # no strain along z


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("shear", [None, 0.2 * E])
def test_bedding_gives_every_direction_its_modulus_and_no_strain_out_of_the_plane(
    plane: str, shear: float | None
) -> None:
    """Of pull at an angle t to the planes, c^4 / E + s^4 / E' + c^2 s^2 (1 / G' - 2 nu' / E') (Amadei 1996)."""
    across, nu, angle = 0.4 * E, 0.2, 25.0
    rock = plane_elasticity(E, NU, plane, ElasticBedding(angle, across, nu, shear))
    per_shear = 1.0 / shear if shear else 1.0 / E + (1.0 + 2.0 * nu) / across
    for degrees in (-40.0, 25.0, 70.0, 115.0):
        t, to_planes = np.deg2rad(degrees), np.deg2rad(degrees - angle)
        pulled = np.array([np.cos(t) ** 2, np.sin(t) ** 2, np.cos(t) * np.sin(t)])
        c, s = np.cos(to_planes) ** 2, np.sin(to_planes) ** 2
        per_pull = c**2 / E + s**2 / across + c * s * (per_shear - 2.0 * nu / across)
        of_zz = -(NU / E * c + nu / across * s)  # strain
        zz = float(rock.zz @ pulled)
        assert zz == pytest.approx(-of_zz * E if plane == "strain" else 0.0, rel=1e-13)
        strain = np.linalg.solve(rock.matrix, pulled)
        assert pulled @ strain == pytest.approx(per_pull + of_zz * zz, rel=1e-13)


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_energy_components_square_to_the_strain_energy(plane: str) -> None:
    material = plane_elasticity(3.0, 0.3, plane, ElasticBedding(20.0, 1.0, 0.2))
    stress = np.array([[1.0, 2.0, -0.5], [0.0, 0.0, 1.0]])
    body = np.zeros(2, dtype=np.int64)
    expected = np.einsum("ni,ij,nj->n", stress, np.linalg.inv(material.matrix), stress)
    np.testing.assert_allclose(np.sum(energy_components([material], stress, body) ** 2, axis=1), expected)


def test_the_divergence_of_a_stress_that_varies_is_the_force_that_it_puts_on_the_rock() -> None:
    formulas = tuple(CoordinateFormula(parse_formula(text)) for text in ("x*x", "3*x*y", "x*y"))  # xx, yy, xy
    places = np.random.default_rng(3).uniform(-5.0, 5.0, (20, 2))
    x, y = places.T
    found = InSitu(varying=((2.0, formulas),)).divergence(places, 0.1)
    np.testing.assert_allclose(found, 2.0 * np.stack([3.0 * x, y + 3.0 * x], axis=1), atol=1e-7)


SIDES = {"bottom": 6.0, "right": 5.0, "top": 6.0, "left": 5.0}
KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]
MOUTH = [(0.5, 2.2), (3.1, 2.7)]


def resultant(sample, f: np.ndarray) -> np.ndarray:
    """Force (2,) and moment about the origin of a load vector: its work on the rigid motions."""
    nodes = sample.lattice.to_metres(sample.cover.patches.nodes)
    forces = f.reshape(-1, 2)[: len(nodes)]
    moment = np.sum(nodes[:, 0] * forces[:, 1] - nodes[:, 1] * forces[:, 0])
    return np.append(forces.sum(axis=0), moment)


def water(at: np.ndarray) -> np.ndarray:
    """A water table within a cell."""
    return np.maximum(3.3 - at[:, 1], 0.0)


def peak(at: np.ndarray) -> np.ndarray:
    """A fiftieth of a cell wide, between the points of the edge."""
    return np.exp(-(((at[:, 0] - 3.03) / 0.02) ** 2))


PEAK = 0.02 * np.sqrt(np.pi)
PARTS = {
    **{edge: (EdgeTraction(Build.edge(edge), (2.0, -3.0)), middle, SIDES[edge] * np.array([2.0, -3.0]))
       for edge, middle in (("bottom", (3.5, 0.5)), ("right", (6.5, 3.0)), ("top", (3.5, 5.5)), ("left", (0.5, 3.0)))},
    **{f"pressure on {edge}": (EdgePressure(Build.edge(edge, 0.24, 0.72), 3.0), middle, 3.0 * 0.48 * np.array(inward))
       for edge, middle, inward in (("bottom", (3.38, 0.5), (0.0, 6.0)), ("right", (6.5, 2.9), (-5.0, 0.0)),
                                    ("top", (3.62, 5.5), (0.0, -6.0)), ("left", (0.5, 3.1), (5.0, 0.0)))},
    "a part": (EdgeTraction(Build.edge("right", 0.24, 0.72), (1.0, 0.0)), (6.5, 2.9), (2.4, 0.0)),
    "a peak": (EdgeTraction(Build.edge("top"), (0.0, peak)), (3.03, 5.5), (0.0, PEAK)),
    "water": (EdgePressure(Build.edge("left"), water), (0.5, 0.5 + 2.8 / 3.0), (0.5 * 2.8**2, 0.0)),
}  # fmt: skip
"""Loads on edges, where their resultant acts, and the resultant."""


@pytest.mark.parametrize("support", [1.5, 2.0])
@pytest.mark.parametrize("name", PARTS)
def test_loads_on_edges_have_their_resultant_force_and_moment(build, name: str, support: float) -> None:
    sample = build.block((6, 5), [build.crack(MOUTH, (False, True))], support)
    load, (x, y), (force_x, force_y) = PARTS[name]
    found = resultant(sample, load_vector(sample.cover, (sample.body,), (load,), 4))
    size = np.hypot(force_x, force_y)
    tolerance = {"a peak": 1e-5, "water": 1e-5, "a part": 4e-9}.get(name, 5e-8)
    np.testing.assert_allclose(found, [force_x, force_y, x * force_y - y * force_x], atol=tolerance * size)


def test_an_edge_is_held_cell_by_cell_where_cells_are_small(build) -> None:
    """Held on average over a spacing the edge moves between small cells, and larger cells elsewhere do not tell it."""
    sample = build.block((8, 8), support=2.0, levels=3, places=[(8.5, 4.5)])
    (found,) = points_along(sample.cover, [sample.cover.edges_on(build.edge("right"))])
    held = constraints(sample.cover, [EdgeSupport(build.edge("right"), (0.0, None))])
    sides = sample.cover.elements.size[found.elements]
    assert sides.min() == 0.125
    n_cells = (found.lengths / sides).sum()
    assert len(held.given) == int(n_cells) + 1 > 20
    steps = np.diff(found.cells) / np.hypot(*np.diff(found.points, axis=0).T)
    assert np.all(steps > 1.0 - 1e-9)
    assert np.all(steps < 8.0 + 1e-9)
    assert found.cells.max() < n_cells  # no jumps where cells of two sizes meet


def test_a_stretch_between_edge_supports_is_uniform(build) -> None:
    """Of 0.01 m from left to right, on rollers: free sides contract by Poisson's ratio."""
    sample, held = build.block((6, 5), support=2.0), {"left": (0.0, None), "right": (0.01, None), "bottom": (None, 0.0)}
    u = sample.solve([EdgeSupport(build.edge(edge), given) for edge, given in held.items()], {}, 8)
    metres = np.random.default_rng(50).uniform((0.5, 0.5), (6.5, 5.5), (200, 2))
    points = sample.lattice.to_lattice(metres)
    found = displacement_at(sample.cover, u, points, locate(sample.lattice, sample.cover.elements, points))
    exact = (metres - 0.5) * (1.0, -sample.material.matrix[0, 1] / sample.material.matrix[0, 0]) * 0.01 / 6.0
    assert np.abs(found - exact).max() < 3e-6 * 0.01


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


def test_point_support_holds_the_point_exactly_and_lies_in_the_body(build) -> None:
    sample = build.block((6, 5), [build.crack(KINKED)])
    place = np.array([5.2, 1.3])
    held = [PointSupport("rock", place, (0.02, -0.01)), PointSupport("rock", np.array([0.5, 0.5]), (None, 0.0))]
    u = sample.solve(held, {"top": (0.0, 0.01), "bottom": (0.0, -0.01)})
    at = sample.lattice.to_lattice(place[None])
    element = locate(sample.lattice, sample.cover.elements, at)
    np.testing.assert_allclose(displacement_at(sample.cover, u, at, element), [[0.02, -0.01]], atol=1e-12)
    with pytest.raises(GeometryError, match=r"\(7 m, 2 m\) lies outside"):
        constraints(sample.cover, (PointSupport("rock", np.array([7.0, 2.0]), (0.0, None)),))
    assert constraints(sample.cover, ()).matrix.shape == (0, sample.cover.n_dofs)


LOWER, UPPER = (2.0, 1.0), (8.0, 6.0)
FREE, HELD = None, 0.0


def body(build: type[Build], size: float = 1.0) -> Sample:
    return build.sample(np.multiply(LOWER, size), np.multiply(UPPER, size), spacing=size)


def at(x: float, y: float, displacement: tuple[float | None, float | None]) -> PointSupport:
    return PointSupport("rock", np.array([x, y]), displacement)


MOTIONS = [
    ([], "translation in x and translation in y and rotation"),
    ([at(3.0, 2.0, (HELD, FREE)), at(3.0, 5.0, (HELD, FREE))], "translation in y"),
    ([at(3.0, 2.0, (FREE, HELD)), at(7.0, 2.0, (FREE, HELD))], "translation in x"),
    ([at(3.0, 2.0, (HELD, HELD))], "rotation about (3 m, 2 m)"),
    ([at(3.0, 2.0, (HELD, FREE)), at(7.0, 5.5, (FREE, HELD))], "rotation about (7 m, 2 m)"),
    ([at(3.0, 2.0, (HELD, FREE))], "translation in y and rotation"),
]
IN_UNITS = [(1e-6, "(3 um, 2 um)"), (1.0, "(3 m, 2 m)"), (1e4, "(3e+04 m, 2e+04 m)")]


def test_free_motions_are_named_in_any_unit_of_length(build: type[Build]) -> None:
    for supports, motion in MOTIONS:
        words = re.escape(f"is free to move: {motion}; it needs supports of its own")
        with pytest.raises(FreePieceError, match=words):
            body(build).system(supports)
    for size, place in IN_UNITS:
        with pytest.raises(FreePieceError, match=re.escape(f"rotation about {place}")):
            body(build, size).system([at(3.0 * size, 2.0 * size, (HELD, HELD))])


def test_loads_that_balance_by_themselves_pull_at_no_motion(build: type[Build]) -> None:
    """Tractions of a uniform stress sum to nothing but for round-off, whose sign would press a piece on its contact."""
    sample = body(build)
    free = free_motions(sample.cover, constraints(sample.cover, ()).matrix)
    tractions = {"bottom": (-0.3, 1.0), "top": (0.3, -1.0), "left": (2.0, -0.3), "right": (-2.0, 0.3)}

    def pull(some: dict[str, tuple[float, float]]) -> np.ndarray:
        loads = tuple(EdgeTraction(build.edge(edge), traction) for edge, traction in some.items())
        return free.along(load_vector(sample.cover, (sample.body,), loads, 3))

    assert not pull(tractions).any()
    tractions["top"] = (0.3, -1.0 - 1e-9)
    assert pull(tractions).any()


CRACKED = """
title: a crack under a pressure that varies along it
plane: strain
bodies: {rock: {shape: {rectangle: {center: [0, 0], width: 0.4, height: 0.4}}, material: {young: 1e10, poisson: 0.2}}}
cracks: {flaw: {path: {center: [0, 0], length: 0.04, angle: 0}, contact: none}}
supports:
  - {at: [-0.2, -0.2], displacement: {x: 0, y: 0}}
  - {at: [0.2, -0.2], displacement: {y: 0}}
loads: [{crack: flaw, pressure: "1e6*(1 + x/0.02)"}]
numerics: {spacing: 0.005, refine: {tips: 1}}
output: {frames: none, figures: false}
"""


@pytest.mark.physics
def test_pressure_that_varies_along_a_crack_has_the_K_of_the_closed_form() -> None:
    """p (1 + x/a): K_I = p sqrt(pi a) (F +- 1/2) at the two tips; F = 1.014 in a square plate ten times as wide."""
    (result,) = steps_of(CRACKED)
    K = 1e6 * np.sqrt(np.pi * 0.02)
    by_tip = {tip.tip: tip.K_I for tip in result.tips}
    assert by_tip["end"] == pytest.approx(1.514 * K, rel=0.003)
    assert by_tip["start"] == pytest.approx(0.514 * K, rel=0.003)
