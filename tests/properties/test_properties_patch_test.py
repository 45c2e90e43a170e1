"""Patch tests: a uniform stress state comes out, also along an open crack parallel to the only stress.

Errors are of the largest displacement. Gradients are corrected so that the divergence theorem holds in every element:
the patch test passes at round-off for any number of points.
"""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.case.model import Body, EdgeRegion, EdgeTraction, Material, PointSupport, Ring
from crackgrow.cover.cover import build_cover
from crackgrow.cover.elements import locate
from crackgrow.cover.lattice import place_lattice
from crackgrow.cover.shapes import BodyGeometry
from crackgrow.linear import ConstrainedSystem
from crackgrow.solid.elasticity import plane_elasticity
from crackgrow.solid.loads import load_vector
from crackgrow.solid.places import boxes_of_functions
from crackgrow.solid.recovery import displacement_at, stress_at
from crackgrow.solid.stiffness import stiffness
from crackgrow.solid.supports import constraints

LARGE, LONG = (14, 9), [(3.7, 4.2), (11.1, 4.2)]
SMALL, SHORT = (6, 5), [[(1.7, y), (4.9, y)] for y in (2.2, 3.0, 2.501)]
"""In spacings; at supports 2 and 2.5 both tips of the short cracks act in the same patches."""


def errors(sample, size: tuple[int, int], quadrature: int, stress: tuple[float, float, float]) -> tuple[float, float]:
    """Largest errors of displacement and of stress (mean square), relative, under a uniform stress state."""
    sxx, syy, sxy = stress
    tractions = {"left": (-sxx, -sxy), "right": (sxx, sxy), "bottom": (-sxy, -syy), "top": (sxy, syy)}
    low, right = np.array([0.5, 0.5]), np.array([size[0] + 0.5, 0.5])
    u = sample.solve(
        [PointSupport("rock", low, (0.0, 0.0)), PointSupport("rock", right, (None, 0.0))], tractions, quadrature
    )
    exx, eyy, gxy = np.linalg.solve(sample.material.matrix, stress)
    metres = np.random.default_rng(60).uniform(low, low + size, (600, 2))
    exact = (metres - low) @ np.array([[exx, gxy], [0.0, eyy]]).T  # no rotation of the lower side
    points = sample.lattice.to_lattice(metres)
    elements = locate(sample.lattice, sample.cover.elements, points)
    found = displacement_at(sample.cover, u, points, elements)
    found_stress = stress_at(sample.cover, [sample.material], u, points, elements)
    deviation = np.sqrt(np.mean((found_stress - stress) ** 2)) / np.abs(stress).max()
    return np.abs(found - exact).max() / np.abs(exact).max(), deviation


ANY = [(1e-3, 0.0, 0.0), (0.0, -2e-3, 0.0), (1e-3, 5e-4, 7e-4)]


@pytest.mark.parametrize(
    ("support", "levels"), [(1.5, 0), (1.75, 0), (2.0, 0), (2.5, 0), (1.25, 2), (1.5, 3), (2.0, 6)]
)
def test_uncut_body_under_any_uniform_stress(build, support: float, levels: int) -> None:
    """With levels, cells are small at a place inside, and on the outline."""
    sample = build.block(SMALL, [], support, levels, [(3.0, 2.2), (5.2, 5.5)])
    assert max(error for stress in ANY for error in errors(sample, SMALL, 4, stress)) < (1e-10 if levels else 1e-11)


@pytest.mark.parametrize(
    ("size", "points", "gathered", "cells", "quadrature"),
    [
        *((SMALL, points, False, ((1.5, 0), (1.75, 0), (2.0, 0), (2.5, 0)), 4) for points in SHORT),
        *((LARGE, LONG, False, ((1.5, 0), (2.0, 0), (2.5, 0)), quadrature) for quadrature in (2, 3, 6)),
        (LARGE, [(3.0, 4.2), (11.1, 4.2)], False, ((1.25, 2), (1.5, 3), (2.0, 1), (2.0, 6), (2.5, 2)), 4),
        ((22, 15), [(5.7, 7.2), (15.1, 7.2)], True, ((1.5, 0), (2.0, 0), (2.0, 3), (2.5, 2)), 4),
    ],
)
def test_crack_along_the_only_stress_leaves_it_alone(
    build, size: tuple[int, int], points: list, gathered: bool, cells: tuple[tuple[float, int], ...], quadrature: int
) -> None:
    """Tip functions fade out, and their gradients kink, inside of elements; cells are small at tips and on the rim."""
    for support, levels in cells:
        places = [*points, (size[0] - 0.8, size[1] + 0.5)]
        sample = build.block(size, [build.crack(points, gathered=gathered)], support, levels, places)
        assert any(tip.carriers.gathered for tip in sample.cover.tips) == gathered
        assert sample.cover.elements.size.min() == 0.5**levels
        assert errors(sample, size, quadrature, ANY[0])[0] < 1e-10, (support, levels)


DIAGONAL = (
    [(0.25, 1.25), (1.25, 0.25), (4.0, 0.25), (4.5, 0.75), (4.5, 3.25), (3.0, 4.75), (0.25, 2.0)],
    [(5.0, 1.5), (6.5, 0.0), (8.0, 1.5)],
)
"""Two bodies whose corners and crossings with the lattice are exact."""
SLANTED = [(0.3, 0.4), (5.2, 0.1), (4.6, 3.3), (2.4, 4.7), (0.1, 3.1)], [(5.9, 0.2), (8.8, 1.3), (6.3, 4.1)]
"""Two bodies whose outlines are bent where they cross the lattice, by rounding to the grid: 1e-9 spacings."""


@pytest.mark.parametrize(("outlines", "tolerance"), [(DIAGONAL, 1e-11), (SLANTED, 1e-8)])
@pytest.mark.parametrize(("support", "levels"), [(1.5, 0), (2.0, 0), (2.5, 0), (2.0, 5), (1.5, 3)])
def test_two_bodies_with_slanted_outlines_under_any_uniform_stress(
    build, support: float, levels: int, outlines, tolerance: float
) -> None:
    """With levels, cells are small at a corner of each body."""
    lattice = place_lattice(np.array([0.0, 0.0]), np.array([9.0, 5.0]), 1.0, support)
    lattice = build.graded(lattice, lattice.to_lattice(np.array([corners[2] for corners in outlines])), levels)
    stress, modulus = np.array([[1e-3, 7e-4], [7e-4, 5e-4]]), plane_elasticity(1.0, 0.25, "strain")
    exx, eyy, gxy = np.linalg.solve(modulus.matrix, stress[[0, 1, 0], [0, 1, 1]])
    gradient = np.array([[exx, 0.5 * gxy], [0.5 * gxy, eyy]])
    bodies, loads, supports = [], [], []
    for name, outline in zip("ab", outlines, strict=True):
        corners = np.array(outline, dtype=float)
        edges = tuple(f"edge {i}" for i in range(len(corners)))
        bodies.append(Body(name, (Ring(corners, edges),), Material(1.0, 0.25), None))
        for side, step in enumerate(np.roll(corners, -1, axis=0) - corners):
            normal = np.array([step[1], -step[0]]) / np.hypot(*step)
            region = EdgeRegion(name, edges[side], np.array([side]), np.array([[0.0, 1.0]]))
            loads.append(EdgeTraction(region, tuple(stress @ normal)))
        first, second = corners[:2]
        supports.append(PointSupport(name, first, tuple(gradient @ first)))
        supports.append(PointSupport(name, second, (None, float((gradient @ second)[1]))))
    cover = build_cover(lattice, [BodyGeometry((lattice.to_lattice(body.outline),), body.name) for body in bodies], [])
    held = constraints(cover, tuple(supports))
    system = ConstrainedSystem(stiffness(cover, [modulus, modulus], 4), held.matrix, boxes_of_functions(cover))
    u = system.solve(load_vector(cover, tuple(bodies), tuple(loads), 4), held.given)[0]
    metres = np.random.default_rng(61).uniform((0.0, 0.0), (9.0, 5.0), (600, 2))
    elements = locate(lattice, cover.elements, lattice.to_lattice(metres))
    metres, elements = metres[elements >= 0], elements[elements >= 0]
    found = displacement_at(cover, u, lattice.to_lattice(metres), elements)
    exact = metres @ gradient.T
    assert set(cover.elements.body[elements]) == {0, 1}
    assert np.abs(found - exact).max() < tolerance * np.abs(exact).max()
