"""Cells of several sizes, gathered tip functions, cracks that meet: rigid motions, errors at a tip, uniform stress."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.contact.coulomb import OPEN, SLIP, STICK
from crackgrow.contact.jump import gap_and_slip
from crackgrow.cover.elements import locate
from crackgrow.run.evaluation import StepSolution
from crackgrow.solid.recovery import displacement_at
from crackgrow.solid.rigid_modes import rigid_motions
from tests.scenes import specimen
from tests.solving import face_vertices, solve_case
from tests.unit.exact_fields import solved_under, true_error

SIZE = (8, 7)
KINKED = [(2.2, 2.3), (4.1, 2.9), (4.6, 4.4)]
SHORT = [(6.1, 5.2), (6.4, 5.35)]
PLACES = [*KINKED, *SHORT, (8.5, 0.5)]


def graded(build, support: float, levels: int, cracked: bool = True):
    cracks = [build.crack(KINKED, name="kinked"), build.crack(SHORT, name="short")]
    return build.block(SIZE, cracks if cracked else [], support, levels, PLACES)


@pytest.mark.parametrize(("support", "levels"), [(2.0, 1), (2.0, 3), (2.0, 6), (1.5, 3), (2.5, 2)])
def test_rigid_motions_produce_no_forces_and_stiffness_is_symmetric(build, support: float, levels: int) -> None:
    sample = graded(build, support, levels)
    matrix = sample.stiffness()
    motions = rigid_motions(sample.cover, np.arange(len(sample.cover.patches.nodes))).toarray()
    size = matrix.diagonal().max()
    assert np.abs(matrix @ motions).max() < 1e-12 * size
    rng = np.random.default_rng(levels)
    one, other = rng.normal(size=(2, sample.cover.n_dofs))
    assert one @ (matrix @ other) == pytest.approx(other @ (matrix @ one), abs=1e-12 * size * len(one))
    assert matrix.diagonal().min() > 0.0
    assert one @ (matrix @ one) > 0.0


TIP = np.array([5.0, 4.0])
"""A corner of cells."""
END = np.array([9.3, 8.8])
"""Inside of a cell, with room for gathered functions."""


def error_of_mode_one(
    build, levels: int, tip: Floats = TIP, *, functions: str = "none", everywhere: bool = False
) -> tuple[float, int]:
    """Percent of the energy norm on a square whose left half is cracked, and the unknowns; tip functions are on
    patches, gathered, or there are none."""

    def mode_one(points: Floats) -> Floats:
        """Stress (n, 3) round the tip, for a K of 1."""
        x, y = (points - tip).T
        r, t = np.hypot(x, y), 0.5 * np.arctan2(y, x)
        terms = (1.0 - np.sin(t) * np.sin(3.0 * t), 1.0 + np.sin(t) * np.sin(3.0 * t), np.sin(t) * np.cos(3.0 * t))
        return np.asarray((np.cos(t) / np.sqrt(2.0 * np.pi * r) * terms).T)

    side, gathered = (8 if tip is TIP else 16), functions == "gathered"
    crack = build.crack([(0.5, tip[1]), tip], (False, functions != "none"), gathered=gathered)
    places = [(x, y) for x in range(1, side + 1) for y in range(1, side + 1)] if everywhere else [tip]
    upper, rings = (side + 0.5, side + 0.5), 3.0 if tip is TIP else 2.0
    sample = build.sample((0.5, 0.5), upper, [crack], support=2.0, levels=levels, places=places, rings=rings)
    assert functions == "none" or sample.cover.tips[0].carriers.gathered == gathered
    return true_error(sample, solved_under(sample, mode_one), mode_one), sample.cover.n_dofs


def test_the_error_at_a_tip_falls_by_the_square_root_of_two_a_level(build) -> None:
    """Without tip functions; it is that of a lattice whose cells are everywhere as small as the smallest."""
    errors = np.array([error_of_mode_one(build, levels)[0] for levels in range(7)])
    np.testing.assert_allclose(errors[1:-1] / errors[2:], np.sqrt(2.0), rtol=0.1)
    assert errors[2] == pytest.approx(error_of_mode_one(build, 2, everywhere=True)[0], rel=0.01)


def test_tip_functions_leave_the_error_of_the_rings_round_the_tip(build) -> None:
    """It falls with every level, to that of cells which grow with the distance from the tip."""
    errors = np.array([error_of_mode_one(build, levels, functions="on patches")[0] for levels in range(6)])
    assert (np.diff(errors) < 0.0).all()
    assert errors[0] < 0.1 * error_of_mode_one(build, 0)[0]
    assert errors[-1] < 0.4 * errors[0]


@pytest.mark.parametrize("levels", range(7))
def test_gathered_functions_are_as_good_as_those_on_every_patch(build, levels: int) -> None:
    """With a hundred unknowns less."""
    gathered, few = error_of_mode_one(build, levels, END, functions="gathered")
    on_patches, many = error_of_mode_one(build, levels, END, functions="on patches")
    assert many - few > 70
    assert gathered < 1.01 * on_patches


PLATE = np.array([31.0, 55.0])  # mm, round the origin
YOUNG, POISSON, LOAD = 1e10, 0.25, 1e8  # Pa
LOWER_EDGE = np.array([0.0, -0.5 * PLATE[1]])
STICKY = 10.0

Cracks = tuple[tuple[str, tuple[tuple[float, float], ...]], ...]
"""Which ends are tips, and vertices (mm)."""

MAIN = ("both", ((-6.0, -2.0), (6.0, 2.0)))
ACROSS = ("none", ((-15.5, -3.0), (15.5, 4.0)))
STEM = ("start", ((-6.0, -2.0), (0.0, 0.0)))
LAYOUTS: dict[str, Cracks] = {
    "from the outline": (("end", ((-15.5, -2.0), (3.0, 3.0))),),
    "T": (MAIN, ("end", ((0.0, 0.0), (1.0, 8.0)))),
    "X": (MAIN, ("both", ((-1.0, -7.0), (2.0, 8.0)))),
    "three through a point": (MAIN, ("both", ((-1.0, -7.0), (1.0, 7.0))), ("both", ((-5.0, 4.0), (5.0, -4.0)))),
    "Y": (STEM, ("end", ((0.0, 0.0), (3.0, 7.0))), ("end", ((0.0, 0.0), (6.0, -4.0)))),
    "V": (STEM, ("end", ((0.0, 0.0), (1.0, 8.0)))),
    "branch near a tip": (MAIN, ("end", ((5.0, 5.0 / 3.0), (6.0, 5.0)))),
    "oblique branch": (MAIN, ("end", ((0.0, 0.0), (5.0, 3.0)))),
    "through": (ACROSS,),
    "through, and one across": (ACROSS, ("both", ((-1.0, -7.0), (1.0, 7.0)))),
    "lattice lines": (("both", ((-6.0, 0.0), (6.0, 0.0))), ("both", ((0.0, -6.0), (0.0, 6.0)))),
    "ring": (("none", ((-6.0, -2.0), (6.0, 2.0), (0.0, -7.0))), ("none", ((0.0, -7.0), (-6.0, -2.0)))),
    "triangle": (MAIN, ("both", ((-5.0, -6.0), (3.0, 7.0))), ("both", ((-3.0, 7.0), (5.0, -6.0)))),
}


@cache
def solved(cracks: Cracks, friction: float, support: float = 2.0, levels: int = 0) -> StepSolution:
    """A plate pressed along y, with cells that are halved `levels` times at tips and kinks."""
    law = {"friction": friction, "cohesion": 0}
    given = {
        str(k): {"path": {"points": [list(point) for point in points]}, "tips": tips, "contact": law}
        for k, (tips, points) in enumerate(cracks)
    }
    numerics = {"spacing": 1.5, "support": support, "refine": {"tips": levels, "kinks": levels}}
    scene = specimen(given, sigma=-1e-6 * LOAD, numerics=numerics)
    return solve_case(Case.from_dict(scene))


@pytest.mark.parametrize(
    ("support", "levels"),
    [(2.0, 2), *(pytest.param(*cells, marks=pytest.mark.slow) for cells in ((1.5, 0), (2.0, 0), (2.5, 0), (1.5, 3)))],
)
@pytest.mark.parametrize("name", LAYOUTS)
def test_uniform_compression_passes_through_stuck_cracks(name: str, support: float, levels: int) -> None:
    """Vertices are rounded by 1e-9 spacings, which tips on patches that only just hold them see enlarged."""
    solution = solved(LAYOUTS[name], STICKY, support, levels)
    cover = solution.cover
    metres = 1e-3 * np.random.default_rng(90).uniform(-0.5 * PLATE, 0.5 * PLATE, (800, 2))
    points = cover.lattice.to_lattice(metres)
    elements = locate(cover.lattice, cover.elements, points)
    metres, points, elements = (values[elements >= 0] for values in (metres, points, elements))
    found = displacement_at(cover, solution.outcome.u, points, elements)
    strain = LOAD / YOUNG * (1 + POISSON) * np.array([POISSON, POISSON - 1])
    exact = strain * (metres - 1e-3 * LOWER_EDGE)
    assert np.abs(found - exact).max() < 1e-6 * np.abs(exact).max()
    outcome, normal = solution.outcome, solution.configuration.faces.nodes.normal
    np.testing.assert_allclose(outcome.points.normal, -LOAD * normal[:, 1] ** 2, atol=1e-5 * LOAD)
    np.testing.assert_allclose(outcome.points.tangential, LOAD * normal[:, 0] * normal[:, 1], atol=1e-5 * LOAD)
    assert solution.outcome.residual < 1e-7


NODE = (-1.5, -1.5)
"""mm: a node of the plate's lattice at a spacing of 1.5 mm, where tile lines cross."""
PEEKING = [
    ((-1.693, -0.0416), (0.007, 0.1398), (-1.893, 1.3907)),
    ((-1.6917, 1.3946), (0.0083, 0.9371), (-1.8917, 1.6565)),
    ((-1.6843, 0.7169), (0.0157, 0.3363), (-1.8843, 0.9623)),
]
"""Spacings from there: cracks whose kink lies a few thousandths of a spacing over a tile line."""


@pytest.mark.parametrize("kink", PEEKING)
def test_a_kink_just_over_a_tile_line_leaves_contact_reciprocal(kink: tuple[tuple[float, float], ...]) -> None:
    """The gap at one contact point by a force at another is the gap there by the same force here (Betti)."""
    path = tuple((NODE[0] + 1.5 * x, NODE[1] + 1.5 * y) for x, y in kink)
    contact = solved((("both", path),), STICKY).configuration.contact
    S = contact.rock / np.tile(contact.weights, 2)
    assert np.linalg.eigvalsh(0.5 * (S + S.T)).min() > 0.0
    np.testing.assert_allclose(S, S.T, atol=3e-6 * np.abs(S).max())


@pytest.mark.parametrize("name", ["T", "X", "three through a point", "Y", "V", "oblique branch"])
def test_slipping_branches_do_not_overlap(name: str) -> None:
    solution = solved(LAYOUTS[name], 0.0)
    cover, outcome = solution.cover, solution.outcome
    size = np.abs(outcome.points.slip).max()
    assert (outcome.points.state == SLIP).any()
    assert STICK not in outcome.points.state
    assert outcome.points.normal.max() <= 0.0
    assert outcome.points.opening[outcome.points.state != OPEN] == pytest.approx(0.0, abs=1e-9 * size)
    assert outcome.points.opening.min() > -1e-9 * size
    slips = [gap_and_slip(cover, face_vertices(cover, k), outcome.u)[1] for k in range(len(cover.cracks))]
    assert min(np.abs(slip).max() for slip in slips) > 1e-3 * size
