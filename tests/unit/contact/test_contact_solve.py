"""How rock is condensed onto its contact points, and where round-off spoils it; tractions between them, short waves."""

from __future__ import annotations

from dataclasses import replace
from operator import attrgetter

import numpy as np
import pytest

from crackgrow.contact import system
from crackgrow.contact.coulomb import SLIP, STICK
from crackgrow.contact.jump import elastic_tractions
from crackgrow.contact.ripple import ripple, worst_ripple
from crackgrow.contact.solve import ContactOutcome
from crackgrow.errors import SolveError
from crackgrow.linear import ConstrainedSystem
from crackgrow.run.configuration import Configuration, LoadLevel
from crackgrow.run.evaluation import StepSolution, evaluated
from crackgrow.run.increments import increment, unloaded
from tests.contact_problems import contact_law, rock_of
from tests.scenes import shipped_case
from tests.solving import ready, solve_case, solve_contact, through
from tests.unit.run.test_run_held import inside, on_plane, plate

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


KEPT = {"cohesion": 10, "cohesion_after_slip": "kept"}
ELASTIC = [
    ({"cohesion": 0}, (1.0,), SLIP),
    ({"cohesion": 0, "dilation_angle": 10}, (1.0,), SLIP),
    ({"cohesion": 0, "dilation_angle": 10}, (1.0, 0.9), STICK),
    (KEPT, (1.0,), SLIP),
    ({**KEPT, "dilation_angle": 5}, (1.0,), SLIP),
    ({**KEPT, "dilation_angle": 5}, (1.0, 0.9), STICK),
    ({"cohesion": 40}, (1.0,), STICK),
]


def solved(
    discretization: str, pressure: float, factors: tuple[float, ...], angle: float = 30.0, **law: object
) -> StepSolution:
    """A crack under shear of 30 MPa, with elastic contact, at the last of some load factors."""
    contact = f"numerics.contact={{stiffness: 100, discretization: {discretization}}}"
    scene = plate(inside(angle), on_plane(angle, pressure, 30.0), "numerics.spacing=2", contact, **law)
    start = unloaded(scene)
    for factor in factors:
        state = increment(scene, start, factor)
        start = state
    return evaluated(state)


@pytest.mark.physics
@pytest.mark.parametrize(("law", "factors", "state"), ELASTIC)
def test_at_the_contact_points_they_are_those_of_the_contact_points(law: dict, factors: tuple, state: int) -> None:
    """Dilation is no overlap, and the part of the shear that cohesion carries is none of friction's."""
    solution = solved("gauss", 20.0, factors, **law)
    outcome, faces, by_point = solution.outcome, solution.configuration.faces, solution.configuration.contact.law
    assert set(outcome.points.state.tolist()) == {state}
    normal, tangential = elastic_tractions(solution.cover, faces, 0, faces.s, by_point, outcome)
    np.testing.assert_allclose(normal, outcome.points.normal, rtol=1e-6)
    np.testing.assert_allclose(tangential, outcome.points.tangential, rtol=1e-6)


@pytest.mark.physics
def test_shear_on_a_bond_does_not_ask_for_the_pressure() -> None:
    """All sticks: K_II is that of the shear, also where the pressure is round-off."""
    K_II = [[tip.K[1] for tip in solved("gauss", p, (1.0,), angle=0.0, cohesion=40).tips] for p in (0.0, 1.0, 20.0)]
    np.testing.assert_allclose(K_II, np.tile(K_II[2], (3, 1)), rtol=1e-3)
    assert min(np.abs(K_II[2])) > 1e5


S = np.linspace(0.0, 6.0, 61)
"""Ten points a cell."""


@pytest.mark.parametrize("length", [0.3, 0.5, 1.0, 1.6])
@pytest.mark.parametrize("amplitude", [0.1, 2.0])
def test_a_short_wave_is_measured_whatever_it_rides_on(length: float, amplitude: float) -> None:
    s = np.linspace(0.0, 6.0, 601)
    for smooth in (np.zeros(601), np.full(601, -75.0), -75.0 + 0.002 * s**2):
        swing = ripple(s, smooth + amplitude * np.sin(2.0 * np.pi * s / length))
        assert swing == pytest.approx(2.0 * amplitude, rel=0.1)


def test_what_rock_does_and_waves_that_the_lattice_carries_are_none() -> None:
    for length in (2.5, 4.0, 12.0):
        assert ripple(S, np.sin(2.0 * np.pi * S / length)) == 0.0
    root = np.sqrt(S * (6.0 - S))
    step = np.where(S < 3.0, -75.0, -20.0)
    peak = -75.0 - 500.0 * np.eye(61)[30]
    for smooth in (-75.0 * np.ones(61), -75.0 + S, root, -1.0 / (S + 0.01), step, peak, -np.abs(S - 2.0)):
        assert ripple(S, smooth) == 0.0


def test_of_two_waves_the_larger_counts_and_few_points_have_none() -> None:
    p = np.zeros(61)
    p[40:44] = [1.0, -1.0, 1.0, -1.0]
    p[10:14] = [0.2, -0.2, 0.2, -0.2]
    assert ripple(S, p) == 2.0
    assert [ripple(S[:n], p[40 : 40 + n]) for n in range(5)] == [0.0, 0.0, 0.0, 0.0, 2.0]


def test_the_ripple_of_a_surface_is_held_against_its_own_pressure() -> None:
    settings = ("numerics.contact={discretization: gauss, stiffness: 1}", "numerics.spacing=3", "growth.steps=0")
    solution = solve_case(shipped_case("compression30", settings))
    cover, faces, none = solution.cover, solution.configuration.faces, np.zeros(solution.configuration.faces.n)
    calm = none - 75e6
    wave = calm + 15e6 * (-1.0) ** np.arange(faces.n)
    for normal, tangential in ((wave, none), (1e-9 * wave, none), (calm, wave)):
        assert worst_ripple(cover, faces, normal, tangential)[1] == pytest.approx(30.0 / 75.0, rel=0.01)
    assert worst_ripple(cover, faces, none, none) is None
