"""The rock condensed onto contact points by elimination alone: the same as by displacements per unit traction."""

from __future__ import annotations

from dataclasses import replace
from operator import attrgetter

import numpy as np
import pytest

from crackgrow.contact.coulomb import SLIP
from crackgrow.contact.solve import ContactOutcome
from crackgrow.contact.system import ContactSystem
from crackgrow.linear import ConstrainedSystem
from crackgrow.solid.places import boxes_of_functions
from tests.contact_problems import contact_law
from tests.solving import solve_contact
from tests.unit.contact.test_contact_solve import Block, compression, tilting, uniform


class ByElimination(ContactSystem):
    """Whatever its size, displacements per unit traction are too many."""

    _few = False


class BlockByFronts(Block):
    """A block whose contact is condensed by elimination."""


def by_fronts(block: Block) -> Block:
    """The block with a factorization that elimination goes by."""
    places = boxes_of_functions(block.sample.cover)
    found = replace(block, system=ConstrainedSystem(block.system.stiffness, block.system.constraints, places))
    return BlockByFronts(**vars(found))


def contact_of(block: Block, **law: float) -> ContactSystem:
    n = block.faces.n
    values = {"friction": 0.0, "cohesion": 0.0, "compliance": 0.0, **law}
    laws = contact_law(**{name: np.full(n, value) for name, value in values.items()})
    kind = ByElimination if isinstance(block, BlockByFronts) else ContactSystem
    return kind(block.system, *block.operators(), block.faces.weights, laws, "newton")


def solve(block: Block, **law: float) -> ContactOutcome:
    return solve_contact(contact_of(block, **law), block.loads, block.given)


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


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("loading", ["sliding", "tilting"])
def test_both_ways_lead_to_the_same_state(build, loading: str, law: str) -> None:
    """Without fronts the compliance comes from displacements per unit traction."""
    block = tilting(build) if loading == "tilting" else uniform(build, compression(2.0), 25.0)
    one, other = solve(by_fronts(block), **LAWS[law]), solve(block, **LAWS[law])
    assert len(one.points.rows)
    assert_alike(one, other)
    size = np.abs(one.u).max()
    gap_of, slip_of = block.operators()
    np.testing.assert_allclose(gap_of @ one.u, one.points.opening, atol=1e-12 * size)
    np.testing.assert_allclose(slip_of @ one.u, one.points.slip, atol=1e-12 * size)
    assert one.penetration < 1e-14 * size


def test_unloaded_faces_keep_what_slip_has_locked_in(build) -> None:
    """Nothing is loaded, so that the jumps without tractions are zero; cohesion holds a part of the slip."""
    block = uniform(build, np.array([[0.0, 0.5], [0.5, -2.0]]), 0.0, slip=0.004)
    found = []
    for one in (block, by_fronts(block)):
        contact = contact_of(one, cohesion=0.4, kept=True)
        slipped = solve_contact(contact, block.loads, block.given)
        assert (slipped.points.state == SLIP).all()
        found.append(solve_contact(contact, 0.0 * block.loads, 0.0 * block.given, slipped.memory))
    assert np.abs(found[0].points.slip).max() > 1e-4
    assert_alike(*found)


def test_condensations_are_the_same_operator(build) -> None:
    """Compliance between some points and all, displacements and multipliers under tractions."""
    block = uniform(build, compression(2.0), 25.0)
    t = np.random.default_rng(50).normal(size=2 * block.faces.n)
    found = []
    for one in (by_fronts(block), block):
        contact, without = contact_of(one, friction=0.3), one.system.solve(block.loads, block.given)
        moved = contact.displacements((block.loads, block.given), without, t, np.zeros(0))
        found.append((contact.compliance(np.array([1, 4, 5]), np.array([True, False, True])), contact.rock, *moved))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-11 * np.abs(other).max())


def test_what_was_asked_for_first_changes_no_bit(build) -> None:
    block = by_fronts(tilting(build))
    first, other = (contact_of(block, friction=0.4) for _ in range(2))
    solve_contact(other, -2.0 * block.loads, -0.5 * block.given)
    one, two = (solve_contact(contact, block.loads, block.given) for contact in (first, other))
    for name in ("u", "multipliers", *(f"points.{part}" for part in ("normal", "tangential", "opening", "slip"))):
        np.testing.assert_array_equal(*map(attrgetter(name), (one, two)), err_msg=name)


def test_all_points_cost_three_solves(build, monkeypatch: pytest.MonkeyPatch) -> None:
    """One without the tractions, one that the compliance is held against, and one with the tractions."""
    solved: list[int] = []
    exact = ConstrainedSystem.solve

    def counted(self, loads, *of, **more):
        solved.append(loads.size // len(loads))
        return exact(self, loads, *of, **more)

    monkeypatch.setattr(ConstrainedSystem, "solve", counted)
    outcome = solve(by_fronts(uniform(build, compression(2.0), 25.0)), friction=0.2)
    assert len(outcome.points.rows) > 5
    assert solved == [1, 1, 1]


@pytest.mark.parametrize("size", [1e-8, 1e-5, 5e-3, 0.1])
def test_a_rough_compliance_is_solved_for(build, monkeypatch: pytest.MonkeyPatch, size: float) -> None:
    """Elimination that is off leaves no trace."""
    block = by_fronts(tilting(build))
    plain = solve(block, friction=0.4)
    exact = ConstrainedSystem.compliance

    def rough(self, rows):
        found = exact(self, rows)
        off = np.random.default_rng(51).uniform(-1.0, 1.0, found.shape)
        return found * (1.0 + size * (off + off.T))

    monkeypatch.setattr(ConstrainedSystem, "compliance", rough)
    found = solve(block, friction=0.4)
    assert_alike(found, plain)
    assert found.complementarity < 1e-11
    assert found.notes == ()


def test_only_doubtful_points_are_solved_for(build, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where elimination is off at one point its own load alone is solved for, besides the one that tells."""
    block = by_fronts(tilting(build))
    expected = contact_of(block, friction=0.4).rock
    exact, solve_exactly = ConstrainedSystem.compliance, ConstrainedSystem.solve
    solved: list[int] = []

    def rough(self, rows):
        found = exact(self, rows)
        found[3, 3] *= 1.0 + 1e-4
        return found

    def counted(self, loads, *of, **more):
        solved.append(loads.size // len(loads))
        return solve_exactly(self, loads, *of, **more)

    monkeypatch.setattr(ConstrainedSystem, "compliance", rough)
    monkeypatch.setattr(ConstrainedSystem, "solve", counted)
    found = contact_of(block, friction=0.4).rock
    assert solved == [1, 1]
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


def test_jumps_that_corrections_cannot_mend_are_told(build, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each solve is off by another 1e-7 here: no correction gains on that."""
    block, rng, exact = by_fronts(tilting(build)), np.random.default_rng(52), ConstrainedSystem.solve

    def noisy(self, *of, **more):
        u, multipliers = exact(self, *of, **more)
        return u + 1e-7 * np.abs(u).max() * rng.uniform(-1.0, 1.0, u.shape), multipliers

    monkeypatch.setattr(ConstrainedSystem, "solve", noisy)
    found = solve(block, friction=0.4)
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
