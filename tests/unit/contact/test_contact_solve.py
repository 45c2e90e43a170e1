"""Contact solves of blocks cut right through, and how the rock is condensed onto their contact points."""

from __future__ import annotations

from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np
import pytest

import crackgrow.contact.solve as module
from crackgrow.case.model import EdgeSupport, EdgeTraction, PointSupport
from crackgrow.contact.coulomb import OPEN, SLIP, STICK
from crackgrow.contact.faces import ContactFaces
from crackgrow.contact.jump import contact_operators
from crackgrow.contact.mortar import mortar_faces
from crackgrow.contact.problem import CondensedPoints, ContactProblem, ContactSolution
from crackgrow.contact.solve import ContactOutcome
from crackgrow.contact.system import ContactSystem
from crackgrow.errors import SolveError
from crackgrow.linear import ConstrainedSystem
from crackgrow.solid.loads import load_vector
from crackgrow.solid.places import boxes_of_functions
from tests.contact_problems import contact_law, rock_of
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

    def solve(self, friction: float = 0.0, solver: str = "newton") -> ContactOutcome:
        n = self.faces.n
        law = contact_law(np.full(n, friction), np.zeros(n), np.zeros(n))
        contact = ContactSystem(self.system, *self.operators(), self.faces.weights, law, solver)
        return solve_contact(contact, self.loads, self.given)


def cut(angle_deg: float) -> np.ndarray:
    """The cut through the block's centre, from the left side to the right."""
    rise = 0.5 * WIDTH * np.tan(np.deg2rad(angle_deg))
    return np.array([(0.0, 0.5 * HEIGHT - rise), (WIDTH, 0.5 * HEIGHT + rise)])


def make(build, supports: list[Support], tractions: dict[str, tuple[float, float]], angle: float):
    crack = build.crack(cut(angle), tips=(False, False))
    sample = build.sample((0.0, 0.0), (WIDTH, HEIGHT), [crack], spacing=SPACING, support=2.0, young=YOUNG)
    system, given = sample.system(supports, quadrature=8)
    loads = tuple(EdgeTraction(build.edge(edge), t) for edge, t in tractions.items())
    f = load_vector(sample.cover, (sample.body,), loads, 8)
    return Block(sample, system, given, f, mortar_faces(sample.cover, [0], 1.0))


def strain(stress: np.ndarray) -> np.ndarray:
    """Plane strain (2, 2) of a stress (2, 2)."""
    shear_modulus = YOUNG / 2.5
    return (stress - 0.25 * np.trace(stress) * np.eye(2)) / (2.0 * shear_modulus)


def uniform(build, stress: np.ndarray, angle: float, slip: float = 0.0) -> Block:
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
    return make(build, supports, tractions, angle)


def pressed(build, shortening: float) -> Block:
    """A bar with a level cut, its ends pushed together without friction."""
    supports = [
        EdgeSupport(build.edge("bottom"), (None, 0.0)),
        EdgeSupport(build.edge("top"), (None, -shortening)),
        PointSupport("rock", np.array([0.5 * WIDTH, 0.0]), (0.0, None)),
        PointSupport("rock", np.array([0.5 * WIDTH, HEIGHT]), (0.0, None)),
    ]
    return make(build, supports, {}, 0.0)


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
    apart = pressed(build, -0.02).solve(friction, solver)
    assert apart.points.status == "none"
    assert set(np.flatnonzero(outcome.points.state != OPEN)) <= set(outcome.points.rows)


@pytest.mark.parametrize("solver", ["newton", "lemke"])
def test_a_point_that_the_contact_of_another_closes_is_taken_in(solver: str) -> None:
    """A lever by hand: pushing the first gap open closes the second, by compliance [[2, -1], [-1, 2]]."""
    K = np.eye(4)
    K[:2, :2] = np.linalg.inv([[2.0, -1.0], [-1.0, 2.0]])
    loads = K @ [-1.0, 0.3, 0.0, 0.0]
    outcome = solve_contact(rock_of(K, contact_law(*np.zeros((3, 2))), solver), loads, np.zeros(0))
    assert outcome.points.n_unknowns == 2
    np.testing.assert_allclose(outcome.points.normal, loads[:2], rtol=1e-14)  # both gaps closed
    np.testing.assert_allclose(outcome.points.opening, 0.0, atol=1e-15)


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


def test_gaps_that_are_none_do_not_depend_on_how_pieces_are_held() -> None:
    """Other supports that hold a piece just once add rigid motions, and what they give way to loads out of balance."""
    rng = np.random.default_rng(3)
    n, n_motions = 6, 3
    half = rng.normal(size=(2 * n, 2 * n))
    A, free, friction = half @ half.T + np.eye(2 * n), rng.normal(size=2 * n), np.full(n, 0.5)
    B = rng.normal(size=(2 * n, n_motions))
    F = (B * rng.uniform(0.5, 2.0, (2 * n, 1))).T
    p = rng.normal(size=2 * n)
    along, push = rng.normal(size=(n_motions, 2 * n)), 50.0 * rng.normal(size=(2 * n, n_motions))
    found = ContactSolution(p, "solved", 0, np.full(n, STICK), np.zeros(n_motions))
    other = A + B @ along + push @ F
    other_free = free + B @ rng.normal(size=n_motions) + push @ (F @ p)
    size = np.abs(other).max() + 1.0
    shift = size * np.outer(B[:, 0], B[:, 0]) + size * F.T @ F  # so that the diagonal is positive
    other, other_free = other + shift, other_free + size * F.T @ (F @ p)
    problems = [
        ContactProblem(CondensedPoints(each, B, F), jumps, friction, pull=F @ p)
        for each, jumps in ((A, free), (other, other_free))
    ]
    gaps = [module._nothing(problem, found) for problem in problems]
    np.testing.assert_allclose(gaps[1], gaps[0], rtol=1e-8)


def contact_of(block: Block, by_fronts: bool = False, **law: float) -> ContactSystem:
    """By fronts the rock is condensed by elimination, as where displacements per unit traction are too many."""
    n = block.faces.n
    values = {"friction": 0.0, "cohesion": 0.0, "compliance": 0.0, **law}
    laws = contact_law(**{name: np.full(n, value) for name, value in values.items()})
    if not by_fronts:
        return ContactSystem(block.system, *block.operators(), block.faces.weights, laws, "newton")
    places = boxes_of_functions(block.sample.cover)
    system = ConstrainedSystem(block.system.stiffness, block.system.constraints, places)
    return ByElimination(system, *block.operators(), block.faces.weights, laws, "newton")


class ByElimination(ContactSystem):
    _few = False


def condensed(block: Block, by_fronts: bool = True, **law: float) -> ContactOutcome:
    return solve_contact(contact_of(block, by_fronts, **law), block.loads, block.given)


def assert_alike(one: ContactOutcome, other: ContactOutcome, tolerance: float = 1e-10) -> None:
    np.testing.assert_array_equal(one.points.state, other.points.state)
    size = np.abs(other.u).max()
    for name in ("u", "points.opening", "points.slip", "points.dilation"):
        np.testing.assert_allclose(*map(attrgetter(name), (one, other)), atol=tolerance * size, err_msg=name)
    names = ("points.normal", "points.tangential")
    largest = max(np.abs(attrgetter(name)(other)).max() for name in names)
    for name in names:
        np.testing.assert_allclose(*map(attrgetter(name), (one, other)), atol=tolerance * largest, err_msg=name)
    np.testing.assert_allclose(one.multipliers, other.multipliers, atol=tolerance * np.abs(other.multipliers).max())


LAWS = {
    "smooth": {},
    "rough": {"friction": 0.4},
    "elastic": {"friction": 0.2, "compliance": 1e-3},
    "cohesive": {"friction": 0.2, "cohesion": 0.4},
    "dilating": {"friction": 0.2, "dilation": 0.1},
}


@pytest.mark.physics
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("loading", ["sliding", "tilting"])
def test_condensed_either_way_the_state_is_the_same(build, loading: str, law: str) -> None:
    """Without fronts the compliance comes from displacements per unit traction."""
    block = tilting(build) if loading == "tilting" else uniform(build, compression(2.0), 25.0)
    one, other = condensed(block, **LAWS[law]), condensed(block, by_fronts=False, **LAWS[law])
    assert len(one.points.rows)
    assert_alike(one, other)
    size = np.abs(one.u).max()
    gap_of, slip_of = block.operators()
    np.testing.assert_allclose(gap_of @ one.u, one.points.opening, atol=1e-12 * size)
    np.testing.assert_allclose(slip_of @ one.u, one.points.slip, atol=1e-12 * size)
    assert one.penetration < 1e-14 * size


@pytest.mark.physics
def test_condensed_unloaded_faces_keep_what_slip_has_locked_in(build) -> None:
    """Nothing is loaded, so that the jumps without tractions are zero; cohesion holds a part of the slip."""
    block = uniform(build, np.array([[0.0, 0.5], [0.5, -2.0]]), 0.0, slip=0.004)
    found = []
    for by_fronts in (False, True):
        contact = contact_of(block, by_fronts, cohesion=0.4, kept=True)
        slipped = solve_contact(contact, block.loads, block.given)
        assert (slipped.points.state == SLIP).all()
        found.append(solve_contact(contact, 0.0 * block.loads, 0.0 * block.given, slipped.memory))
    assert np.abs(found[0].points.slip).max() > 1e-4
    assert_alike(*found)


@pytest.mark.physics
@pytest.mark.parametrize("size", [1e-8, 1e-5, 5e-3, 0.1])
def test_condensed_rough_compliance_is_solved_for(build, monkeypatch: pytest.MonkeyPatch, size: float) -> None:
    """Elimination that is off leaves no trace."""
    block = tilting(build)
    plain = condensed(block, friction=0.4)
    exact = ConstrainedSystem.compliance

    def rough(self, rows):
        found = exact(self, rows)
        off = np.random.default_rng(51).uniform(-1.0, 1.0, found.shape)
        return found * (1.0 + size * (off + off.T))

    monkeypatch.setattr(ConstrainedSystem, "compliance", rough)
    found = condensed(block, friction=0.4)
    assert_alike(found, plain)
    assert found.complementarity < 1e-11
    assert found.notes == ()


@pytest.mark.physics
def test_condensed_jumps_that_corrections_cannot_mend_are_told(build, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each solve is off by another 1e-7 here: no correction gains on that."""
    block, rng, exact = tilting(build), np.random.default_rng(52), ConstrainedSystem.solve

    def noisy(self, *of, **more):
        u, multipliers = exact(self, *of, **more)
        return u + 1e-7 * np.abs(u).max() * rng.uniform(-1.0, 1.0, u.shape), multipliers

    monkeypatch.setattr(ConstrainedSystem, "solve", noisy)
    found = condensed(block, friction=0.4)
    (note,) = found.notes
    assert "jumps of the faces are off by" in note
    assert "ill conditioned" in note
    gap_of, slip_of = block.operators()
    off = max(
        np.abs(gap_of @ found.u - found.points.opening).max(), np.abs(slip_of @ found.u - found.points.slip).max()
    )
    size = max(np.abs(found.points.opening).max(), np.abs(found.points.slip).max())
    assert off / size > 1e-8
    assert found.complementarity == pytest.approx(off / size, rel=0.5)
