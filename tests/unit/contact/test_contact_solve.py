"""Contact solves whose answer is known in closed form: blocks cut right through, under uniform stress."""

from __future__ import annotations

from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array

import crackgrow.contact.solve as module
from crackgrow.case.model import EdgeSupport, EdgeTraction, PointSupport
from crackgrow.contact.coulomb import OPEN, SLIP, STICK, ContactLaw
from crackgrow.contact.faces import ContactFaces
from crackgrow.contact.jump import contact_operators, gap_and_slip
from crackgrow.contact.mortar import mortar_faces
from crackgrow.contact.problem import ContactProblem, ContactSolution, Motions
from crackgrow.contact.solve import ContactOutcome
from crackgrow.contact.system import ContactSystem
from crackgrow.errors import SolveError
from crackgrow.linear import ConstrainedSystem
from crackgrow.solid.loads import load_vector
from tests.contact_problems import contact_law
from tests.solving import solve_contact

WIDTH, HEIGHT = 8.0, 10.0
SPACING = 1.0
YOUNG = 1000.0
YOUNG_PRIME = YOUNG / (1.0 - 0.25**2)  # plane strain

PATCH_TEST = 1e-6
"""Relative error of tractions under uniform stress that the rule of 8 x 8 points leaves (4 x 4 leave 1e-4)."""

Support = PointSupport | EdgeSupport


@dataclass(frozen=True)
class Block:
    """A block cut right through, supported on both sides of the cut."""

    sample: Any
    system: ConstrainedSystem
    given: np.ndarray
    loads: np.ndarray
    faces: ContactFaces

    def operators(self):
        return contact_operators(self.sample.cover, self.faces)

    def solve(
        self,
        friction: float = 0.0,
        cohesion: float = 0.0,
        stiffness: float = np.inf,
        *,
        factor: float = 1.0,
        solver: str = "newton",
    ) -> ContactOutcome:
        n = self.faces.n
        kept = np.ones(n, dtype=bool)
        law = contact_law(np.full(n, friction), np.full(n, cohesion), np.full(n, 1.0 / stiffness), kept=kept)
        contact = ContactSystem(self.system, *self.operators(), self.faces.weights, law, solver)
        return solve_contact(contact, factor * self.loads, factor * self.given)


def cut(angle_deg: float) -> np.ndarray:
    """The cut through the block's centre, from the left side to the right."""
    rise = 0.5 * WIDTH * np.tan(np.deg2rad(angle_deg))
    return np.array([(0.0, 0.5 * HEIGHT - rise), (WIDTH, 0.5 * HEIGHT + rise)])


def make(build, supports: list[Support], tractions: dict[str, tuple[float, float]], angle: float, touching=(0,)):
    crack = build.crack(cut(angle), tips=(False, False))
    sample = build.sample((0.0, 0.0), (WIDTH, HEIGHT), [crack], spacing=SPACING, support=2.0, young=YOUNG)
    system, given = sample.system(supports, quadrature=8)
    loads = tuple(EdgeTraction(build.edge(edge), t) for edge, t in tractions.items())
    f = load_vector(sample.cover, (sample.body,), loads, 8)
    return Block(sample, system, given, f, mortar_faces(sample.cover, list(touching), 1.0))


def strain(stress: np.ndarray) -> np.ndarray:
    """Plane strain (2, 2) of a stress (2, 2)."""
    shear_modulus = YOUNG / 2.5
    return (stress - 0.25 * np.trace(stress) * np.eye(2)) / (2.0 * shear_modulus)


def uniform(build, stress: np.ndarray, angle: float, slip: float = 0.0, touching=(0,)) -> Block:
    """Loaded on all sides by `stress` (2, 2), each half held at three components whose reactions are zero.

    The points above the cut are held where the uniform field puts them, moved by `slip` along the cut.
    """
    a = np.deg2rad(angle)
    moved = slip * np.array([np.cos(a), np.sin(a)])
    tractions = {
        "bottom": tuple(-stress[:, 1]),
        "top": tuple(stress[:, 1]),
        "left": tuple(-stress[:, 0]),
        "right": tuple(stress[:, 0]),
    }
    middle = np.array([0.5 * WIDTH, 0.5 * HEIGHT])
    supports: list[Support] = []
    for y, offset in ((0.0, np.zeros(2)), (HEIGHT, moved)):
        for x, free in ((0.0, ()), (WIDTH, (0,))):
            point = np.array([x, y])
            displacement = strain(stress) @ (point - middle) + offset
            components = [None if k in free else float(displacement[k]) for k in range(2)]
            supports.append(PointSupport("rock", point, (components[0], components[1])))
    return make(build, supports, tractions, angle, touching)


def pressed(build, shortening: float, touching=(0,)) -> Block:
    """A bar with a level cut, its ends pushed together without friction."""
    supports = [
        EdgeSupport(build.edge("bottom"), (None, 0.0)),
        EdgeSupport(build.edge("top"), (None, -shortening)),
        PointSupport("rock", np.array([0.5 * WIDTH, 0.0]), (0.0, None)),
        PointSupport("rock", np.array([0.5 * WIDTH, HEIGHT]), (0.0, None)),
    ]
    return make(build, supports, {}, 0.0, touching)


def on_cut(stress: np.ndarray, angle: float) -> tuple[float, float]:
    """Normal and tangential traction of a stress (2, 2) on the cut."""
    a = np.deg2rad(angle)
    tangent, normal = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
    return float(normal @ stress @ normal), float(tangent @ stress @ normal)


def compression(sigma: float) -> np.ndarray:
    return np.array([[0.0, 0.0], [0.0, -sigma]])


@pytest.mark.parametrize("angle", [-30.0, 10.0, 25.0])
@pytest.mark.parametrize("excess", [1.02, 1.5])
def test_a_cut_sticks_where_friction_exceeds_its_slope(build, angle: float, excess: float) -> None:
    sigma, a = 2.0, np.deg2rad(angle)
    outcome = uniform(build, compression(sigma), angle).solve(friction=excess * np.tan(abs(a)))
    assert outcome.points.status == "solved"
    assert set(outcome.points.state.tolist()) == {STICK}
    np.testing.assert_allclose(outcome.points.normal, -sigma * np.cos(a) ** 2, rtol=PATCH_TEST)
    np.testing.assert_allclose(outcome.points.tangential, -sigma * np.sin(a) * np.cos(a), rtol=PATCH_TEST)
    assert np.abs(outcome.points.slip).max() < 1e-12  # displacements are about 0.02
    assert outcome.complementarity < 1e-12


@pytest.mark.parametrize("angle", [-30.0, 25.0])
@pytest.mark.parametrize("shortage", [0.3, 0.9])
def test_a_cut_slides_down_where_friction_is_less_than_its_slope(build, angle: float, shortage: float) -> None:
    friction = shortage * np.tan(np.deg2rad(abs(angle)))
    outcome = uniform(build, compression(2.0), angle).solve(friction=friction)
    sliding = outcome.points.state == SLIP
    assert sliding.sum() > outcome.points.state.size // 2
    assert np.sign(outcome.points.slip[sliding]).tolist() == [-np.sign(angle)] * int(sliding.sum())  # downhill
    expected = friction * outcome.points.normal[sliding] * np.sign(angle)
    np.testing.assert_allclose(outcome.points.tangential[sliding], expected, rtol=1e-10)
    assert outcome.points.normal.max() <= 0.0
    assert outcome.complementarity < 1e-12


@pytest.mark.parametrize("sense", [-1.0, 1.0])
@pytest.mark.parametrize("angle", [0.0, 20.0])
@pytest.mark.parametrize(("friction", "cohesion"), [(0.0, 0.0), (0.4, 0.0), (0.0, 0.7), (0.3, 0.5)])
def test_a_sliding_cut_carries_its_limit_and_slips_as_imposed(
    build, friction: float, cohesion: float, angle: float, sense: float
) -> None:
    """Uniform stress whose shear on the cut is at Coulomb's limit, the upper half moved along: the exact solution."""
    a, p = np.deg2rad(angle), 2.0
    limit = cohesion + friction * p
    turn = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    stress = turn @ np.array([[-0.5, sense * limit], [sense * limit, -p]]) @ turn.T
    outcome = uniform(build, stress, angle, slip=sense * 0.01).solve(friction, cohesion)
    assert set(outcome.points.state.tolist()) == {SLIP}
    np.testing.assert_allclose(outcome.points.normal, -p, rtol=PATCH_TEST)
    np.testing.assert_allclose(outcome.points.tangential, sense * limit, rtol=PATCH_TEST, atol=1e-12)
    np.testing.assert_allclose(outcome.points.slip, sense * 0.01, rtol=1e-5)
    assert np.abs(outcome.points.opening).max() < 1e-12


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_cohesion_holds_the_cut_up_to_its_limit(build, friction: float) -> None:
    p, cohesion = 2.0, 0.5
    limit = cohesion + friction * p
    states = []
    for share in (-0.99, 0.0, 0.5, 0.99, 1.05):
        stress = np.array([[0.0, share * limit], [share * limit, -p]])
        outcome = uniform(build, stress, 0.0).solve(friction, cohesion)
        states.append(set(outcome.points.state.tolist()))
        assert np.abs(outcome.points.tangential).max() <= (cohesion - friction * outcome.points.normal.min())
    assert states[:4] == [{STICK}] * 4
    assert SLIP in states[4]


@pytest.mark.parametrize(("share", "cohesion"), [(0.5, 0.5), (-0.99, 0.5)])
def test_the_shear_of_a_stuck_cut_is_that_of_the_whole_block(build, share: float, cohesion: float) -> None:
    stress = np.array([[0.3, share * cohesion], [share * cohesion, -2.0]])
    outcome = uniform(build, stress, 0.0).solve(0.0, cohesion)
    p_n, p_t = on_cut(stress, 0.0)
    np.testing.assert_allclose(outcome.points.normal, p_n, rtol=PATCH_TEST)
    np.testing.assert_allclose(outcome.points.tangential, p_t, rtol=PATCH_TEST)


def test_a_cut_pulled_open_has_nothing_to_solve(build) -> None:
    outcome = pressed(build, -0.02).solve(friction=0.5)
    assert outcome.points.status == "none"
    assert outcome.points.n_unknowns == outcome.points.iterations == 0
    assert set(outcome.points.state.tolist()) == {OPEN}
    assert not outcome.points.normal.any()
    assert not outcome.points.tangential.any()
    np.testing.assert_allclose(outcome.points.opening, 0.02, rtol=1e-9)
    assert outcome.penetration == 0.0


def test_faces_without_contact_pass_through_each_other(build) -> None:
    block = pressed(build, 0.02, touching=())
    outcome = block.solve()
    assert outcome.points.status == "none"
    assert outcome.points.n_unknowns == 0
    assert outcome.points.opening.shape == outcome.points.state.shape == (0,)
    points = mortar_faces(block.sample.cover, [0], 1.0).points
    np.testing.assert_allclose(gap_and_slip(block.sample.cover, points, outcome.u)[0], -0.02, rtol=1e-9)


@pytest.mark.parametrize("stiffness", [np.inf, 2000.0, 150.0, 1.0])
def test_a_bar_and_its_contact_shorten_in_series(build, stiffness: float) -> None:
    """shortening = sigma (H / E' + 1 / k)."""
    shortening = 0.03
    outcome = pressed(build, shortening).solve(stiffness=stiffness)
    sigma = shortening / (HEIGHT / YOUNG_PRIME + 1.0 / stiffness)
    np.testing.assert_allclose(outcome.points.normal, -sigma, rtol=PATCH_TEST)
    np.testing.assert_allclose(outcome.points.opening, -sigma / stiffness, rtol=PATCH_TEST, atol=1e-12)
    assert outcome.penetration < 1e-12  # what the stiffness explains is no penetration
    assert outcome.points.n_unknowns == outcome.points.state.size  # without friction one unknown a point


def test_equilibrium_with_supports_and_contact_tractions(build) -> None:
    block = uniform(build, compression(2.0), 25.0)
    outcome = block.solve(friction=0.2)
    gap_of, slip_of = contact_operators(block.sample.cover, block.faces)
    w = block.faces.weights
    contact = gap_of.T @ (w * outcome.points.normal) + slip_of.T @ (w * outcome.points.tangential)
    support = block.system.constraints.T @ outcome.multipliers
    left = block.system.stiffness @ outcome.u + support + contact - block.loads
    assert np.abs(left).max() < 1e-11 * np.abs(block.loads).max()
    np.testing.assert_allclose(block.system.constraints @ outcome.u, block.given, atol=1e-14)


def tilting(build) -> Block:
    """The upper half turned round its middle: the cut opens on the left and closes on the right."""
    supports: list[Support] = [
        PointSupport("rock", np.array([0.0, 0.0]), (0.0, 0.0)),
        PointSupport("rock", np.array([WIDTH, 0.0]), (None, 0.0)),
        PointSupport("rock", np.array([0.0, HEIGHT]), (0.0, 0.02)),
        PointSupport("rock", np.array([WIDTH, HEIGHT]), (None, -0.02)),
    ]
    return make(build, supports, {}, 0.0)


def test_open_faces_cost_no_solve(build, monkeypatch: pytest.MonkeyPatch) -> None:
    """Others cost those of the displacements per unit traction, once a system."""
    solved: list[int] = []
    solve = ConstrainedSystem.solve

    def counted(self, loads, *of, **more):
        solved.append(1 if loads.ndim == 1 else loads.shape[1])
        return solve(self, loads, *of, **more)

    monkeypatch.setattr(ConstrainedSystem, "solve", counted)
    for block, friction in ((pressed(build, -0.02), 0.4), (pressed(build, 0.02), 0.0), (tilting(build), 0.4)):
        solved.clear()
        outcome = block.solve(friction)
        n_tractions = (2 if friction > 0.0 else 1) * outcome.points.state.size
        assert solved == ([1] if outcome.points.status == "none" else [1, n_tractions])
        assert set(np.flatnonzero(outcome.points.state != OPEN)) <= set(outcome.points.rows)


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("solver", ["newton", "lemke"])
def test_points_that_stay_open_carry_nothing(build, solver: str, friction: float) -> None:
    outcome = tilting(build).solve(friction, solver=solver)
    is_open = outcome.points.state == OPEN
    assert is_open[0]
    assert not is_open[-1]
    assert outcome.points.opening[is_open].min() > 0.0
    assert not outcome.points.normal[is_open].any()
    assert not outcome.points.tangential[is_open].any()
    assert outcome.points.normal[~is_open].max() < 0.0
    assert np.abs(outcome.points.opening[~is_open]).max() < 1e-12
    assert outcome.penetration < 1e-12
    assert outcome.complementarity < 1e-10


def test_newton_and_lemke_agree(build) -> None:
    block = tilting(build)
    newton, lemke = (block.solve(0.4, 0.1, solver=solver) for solver in ("newton", "lemke"))
    np.testing.assert_allclose(lemke.u, newton.u, atol=1e-9 * np.abs(newton.u).max())
    np.testing.assert_array_equal(lemke.points.state, newton.points.state)


@pytest.mark.parametrize("solver", ["newton", "lemke"])
def test_a_point_that_the_contact_of_another_closes_is_taken_in(solver: str) -> None:
    """A lever by hand: pushing the first gap open closes the second, by compliance [[2, -1], [-1, 2]]."""
    compliance = np.array([[2.0, -1.0], [-1.0, 2.0]])
    K = np.eye(4)
    K[:2, :2] = np.linalg.inv(compliance)
    system = ConstrainedSystem(csc_array(K), csr_array(np.eye(4)[2:]))
    free = np.array([-1.0, 0.3])
    loads = np.append(K[:2, :2] @ free, np.zeros(2))
    gap_of, slip_of = csr_array(np.eye(4)[:2]), csr_array((2, 4))
    law = contact_law(np.zeros(2), np.zeros(2), np.zeros(2))
    outcome = solve_contact(ContactSystem(system, gap_of, slip_of, np.ones(2), law, solver), loads, np.zeros(2))
    assert outcome.points.n_unknowns == 2
    np.testing.assert_allclose(outcome.points.normal, K[:2, :2] @ free, rtol=1e-14)  # both gaps closed
    np.testing.assert_allclose(outcome.points.opening, 0.0, atol=1e-15)
    alone = ContactSystem(system, gap_of[:1], slip_of[:1], np.ones(1), _one(), solver)
    apart = solve_contact(alone, 1e-3 * loads, np.zeros(2))
    assert apart.points.normal == pytest.approx([-5e-4])  # the first one alone: half of its overlap


def _one() -> ContactLaw:
    return contact_law(np.zeros(1), np.zeros(1), np.zeros(1))


def test_scaling_loads_and_displacements_scales_the_answer(build) -> None:
    """Coulomb's law without cohesion has no stress of its own."""
    block = tilting(build)
    one, three = block.solve(0.4), block.solve(0.4, factor=3.0)
    np.testing.assert_allclose(three.u, 3.0 * one.u, atol=1e-11)
    np.testing.assert_allclose(three.points.normal, 3.0 * one.points.normal, atol=1e-9)
    np.testing.assert_array_equal(three.points.state, one.points.state)


def test_solving_leaves_no_trace(build) -> None:
    """r(A), r(B), r(A): bit for bit, and the system stays as it was."""
    block = uniform(build, compression(2.0), 25.0)
    before = block.system.stiffness.tocsc().copy()
    first = block.solve(friction=0.2)
    other = block.solve(friction=0.6, cohesion=0.1, factor=-0.5)
    again = block.solve(friction=0.2)
    assert not np.array_equal(other.u, first.u)
    for name in (
        "u",
        "multipliers",
        *(f"points.{part}" for part in ("normal", "tangential", "opening", "slip", "state")),
    ):
        np.testing.assert_array_equal(*map(attrgetter(name), (again, first)))
    np.testing.assert_array_equal(block.system.stiffness.tocsc().data, before.data)
    np.testing.assert_array_equal(block.system.stiffness.tocsc().indices, before.indices)


@pytest.mark.parametrize(("share", "noise", "words"), [(1.0, 0.001, "unsymmetric by 0."), (-1.0, 0.0, "not positive")])
def test_columns_spoilt_by_round_off_are_told_from_contact_that_does_not_solve(
    build, monkeypatch, share: float, noise: float, words: str
) -> None:
    exact = ConstrainedSystem.solve

    def spoilt(self, *of, **more):
        u, multipliers = exact(self, *of, **more)
        return (share * u + noise * np.abs(u).max() * np.random.default_rng(1).normal(size=u.shape), multipliers)

    block = pressed(build, 0.01)
    block.solve()
    monkeypatch.setattr(ConstrainedSystem, "solve", lambda *a, **k: (spoilt if a[1].ndim == 2 else exact)(*a, **k))
    with pytest.raises(SolveError, match=f"ill conditioned.*{words}.*numerics.spacing"):
        block.solve()


@pytest.mark.parametrize(("solver", "status"), [("newton", "limit"), ("lemke", "ray")])
def test_no_solution_is_an_error_and_not_a_result(build, monkeypatch, solver: str, status: str) -> None:
    def gives_up(problem, start=None):
        zeros = np.zeros(problem.free.size)
        return ContactSolution(zeros, status, 17, np.zeros(problem.n_points, dtype=np.int64))

    for name in ("newton", "lemke"):
        monkeypatch.setattr(module, f"solve_by_{name}", gives_up)
    with pytest.raises(SolveError, match=rf"{solver}: status '{status}' after 17 iterations"):
        pressed(build, 0.02).solve(solver=solver)


def test_gaps_that_are_none_do_not_depend_on_how_pieces_are_held() -> None:
    """Other supports that hold a piece just once add rigid motions, and what they give way to loads out of balance."""
    rng = np.random.default_rng(3)
    n, n_motions = 6, 3
    half = rng.normal(size=(2 * n, 2 * n))
    A, free, friction = half @ half.T + np.eye(2 * n), rng.normal(size=2 * n), np.full(n, 0.5)
    B, F = rng.normal(size=(2 * n, n_motions)), rng.normal(size=(n_motions, 2 * n))
    p = rng.normal(size=2 * n)
    along, push = rng.normal(size=(n_motions, 2 * n)), 50.0 * rng.normal(size=(2 * n, n_motions))
    motions, found = Motions(B, F, F @ p), ContactSolution(p, "solved", 0, np.full(n, STICK), np.zeros(n_motions))
    other = A + B @ along + push @ F
    other_free = free + B @ rng.normal(size=n_motions) + push @ (F @ p)
    size = np.abs(other).max() + 1.0
    shift = size * np.outer(B[:, 0], B[:, 0]) + size * F.T @ F  # so that the diagonal is positive
    other, other_free = other + shift, other_free + size * F.T @ (F @ p)
    problems = [ContactProblem(*each, friction, motions=motions) for each in ((A, free), (other, other_free))]
    gaps = [module._nothing(problem, found) for problem in problems]
    np.testing.assert_allclose(gaps[1], gaps[0], rtol=1e-8)
