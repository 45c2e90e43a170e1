"""Contact solves whose answer is known in closed form: blocks cut right through, under uniform stress."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array

import crackgrow.contact.solve as module
from crackgrow.case.model import EdgeSupport, EdgeTraction, PointSupport
from crackgrow.contact.coulomb import OPEN, STICK, ContactLaw
from crackgrow.contact.faces import ContactFaces
from crackgrow.contact.jump import contact_operators
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


def compression(sigma: float) -> np.ndarray:
    return np.array([[0.0, 0.0], [0.0, -sigma]])


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
