"""How the rock is condensed onto its contact points: either way, roughly, and where round-off spoils it."""

from __future__ import annotations

from dataclasses import replace
from operator import attrgetter

import numpy as np
import pytest

from crackgrow.contact import system
from crackgrow.contact.coulomb import SLIP
from crackgrow.contact.solve import ContactOutcome
from crackgrow.errors import SolveError
from crackgrow.linear import ConstrainedSystem
from crackgrow.run.configuration import Configuration, LoadLevel
from tests.contact_problems import contact_law, rock_of
from tests.scenes import shipped_case
from tests.solving import ready, solve_contact, through

LAWS = {
    "smooth": ("cohesion=0",),
    "rough": ("friction=0.3",),
    "elastic": ("friction=0.3", "numerics.contact.stiffness=5"),
    "cohesive": ("friction=0.3", "cohesion=5"),
    "dilating": ("friction=0.3", "dilation_angle=5"),
}

LOAD = 100e6 * 31e-3  # N/m


def flaw(law: str) -> Configuration:
    """A closed flaw with a kink."""
    keys = [key if key.startswith("numerics") else f"cracks.flaw.contact.{key}" for key in LAWS[law]]
    path = "cracks.flaw.path={points: [[-5, -4], [0, 0], [5, 1]]}"
    return ready(shipped_case("compression30", ["numerics.spacing=3", path, *keys]))


def outcomes(law: str, *factors: float) -> list[ContactOutcome]:
    """At load factors; the load may turn and pull."""
    return [state.outcome for state in through(flaw(law), *factors)]


def alone() -> ContactOutcome:
    """Of a rough flaw, whose loads are solved for apart from what is asked of the rock besides."""
    configuration, level, none = flaw("rough"), LoadLevel(1.0), np.zeros((0, 0))
    contact = replace(configuration.contact, loads=none, given=none)
    return solve_contact(contact, configuration.loads(level), configuration.given(level))


def assert_alike(one: ContactOutcome, other: ContactOutcome, tolerance: float = 1e-10) -> None:
    np.testing.assert_array_equal(one.points.state, other.points.state)
    jumps, tractions = ("points.opening", "points.slip", "points.dilation"), ("points.normal", "points.tangential")
    for names in (("u", *jumps), tractions):
        size = max(np.abs(attrgetter(name)(other)).max() for name in names)
        for name in names:
            of_one, of_other = map(attrgetter(name), (one, other))
            np.testing.assert_allclose(of_one, of_other, atol=tolerance * size, err_msg=name)
    np.testing.assert_allclose(one.multipliers, other.multipliers, atol=tolerance * LOAD)


@pytest.mark.physics
@pytest.mark.parametrize("law", LAWS)
def test_condensed_either_way_the_state_is_the_same(law: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """By displacements per unit traction, and by elimination: loaded, unloaded with locked-in slip, pulled."""
    factors = (1.0, 0.0, -0.5)
    few = outcomes(law, *factors)
    assert (few[0].points.state == SLIP).any()
    monkeypatch.setattr(system, "FEW_NUMBERS", 0)
    for one, other in zip(few, outcomes(law, *factors), strict=True):
        assert_alike(one, other, 1e-9)


@pytest.fixture
def by_elimination(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    monkeypatch.setattr(system, "FEW_NUMBERS", 0)
    return monkeypatch


@pytest.mark.physics
@pytest.mark.parametrize("size", [1e-5, 0.1])
def test_rough_compliance_is_solved_for(by_elimination: pytest.MonkeyPatch, size: float) -> None:
    """Elimination that is off leaves no trace."""
    plain = alone()
    exact = ConstrainedSystem.compliance

    def rough(self, rows):
        found = exact(self, rows)
        off = np.random.default_rng(51).uniform(-1.0, 1.0, found.shape)
        return found * (1.0 + size * (off + off.T))

    by_elimination.setattr(ConstrainedSystem, "compliance", rough)
    found = alone()
    assert_alike(found, plain)
    assert found.complementarity < 1e-11
    assert found.notes == ()


@pytest.mark.physics
def test_jumps_that_corrections_cannot_mend_are_told(by_elimination: pytest.MonkeyPatch) -> None:
    """Each solve is off by another 1e-6 here: no correction gains on that."""
    rng, exact = np.random.default_rng(52), ConstrainedSystem.solve

    def noisy(self, *of, **more):
        u, multipliers = exact(self, *of, **more)
        return u * (1.0 + 1e-6 * rng.uniform(-1.0, 1.0, u.shape)), multipliers

    by_elimination.setattr(ConstrainedSystem, "solve", noisy)
    found = alone()
    (note,) = found.notes
    assert "jumps of the faces are off by" in note
    assert "ill conditioned" in note
    assert found.complementarity > 1e-8


@pytest.mark.physics
@pytest.mark.parametrize(("share", "noise", "words"), [(1.0, 0.001, "unsymmetric by"), (-1.0, 0.0, "not positive")])
def test_columns_spoilt_by_round_off_are_told_from_contact_that_does_not_solve(
    monkeypatch: pytest.MonkeyPatch, share: float, noise: float, words: str
) -> None:
    exact = ConstrainedSystem.solve

    def spoilt(self, loads, *more):
        u, multipliers = exact(self, loads, *more)
        if loads.ndim == 1:
            return u, multipliers
        return share * u + noise * np.abs(u).max() * np.random.default_rng(1).normal(size=u.shape), multipliers

    monkeypatch.setattr(ConstrainedSystem, "solve", spoilt)
    with pytest.raises(SolveError, match=f"ill conditioned.*{words}.*numerics.spacing"):
        alone()


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
