"""Increments of load: where the energy goes, the path between two loads, and what faces remember when cracks grow."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import pytest

import crackgrow.run.increments as increments
from crackgrow.arrays import Bools, Floats
from crackgrow.case.model import LoadHistory
from crackgrow.contact.coulomb import STICK
from crackgrow.contact.faces import points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.fracture.advance import GrowingCrack, Segment, advanced
from crackgrow.run.configuration import Configuration, LoadLevel, assemble
from crackgrow.run.increments import LoadState, increment, mapped, unloaded
from crackgrow.run.loop import grow, solved_steps
from crackgrow.run.scene import Scene
from tests.scenes import shipped_case
from tests.solving import ready, solve_step, through

COARSE = ("numerics.spacing=3",)
FRICTION = ("cracks.flaw.contact.friction=0.3", *COARSE)
SMALL_SHEAR = (  # the sheared crack in a plate of five times its size
    "bodies.rock.shape.rectangle.width=100",
    "bodies.rock.shape.rectangle.height=100",
    "supports.0.at=[-50, -50]",
    "supports.1.at=[50, -50]",
    "numerics.spacing=4",
)
PULL = (  # pressed and sheared, then pulled apart as well
    "loads=[{on: {body: rock, edge: top}, traction: [0, -6], held: true}, "
    "{on: {body: rock, edge: bottom}, traction: [0, 6], held: true}, "
    "{on: {body: rock, edge: top}, traction: [20, 12]}, {on: {body: rock, edge: bottom}, traction: [-20, -12]}, "
    "{on: {body: rock, edge: right}, traction: [0, 20]}, {on: {body: rock, edge: left}, traction: [0, -20]}]"
)
PULLED = "{on: {body: rock, edge: top}, displacement: {y: -0.05, x: 0}}"
PUSHED = f"supports=[{{on: {{body: rock, edge: bottom}}, displacement: {{x: 0, y: 0}}}}, {PULLED}]"


def laid_out(name: str, *settings: str) -> Configuration:
    return ready(shipped_case(name, settings))


def events(states: list[LoadState]) -> list[LoadState]:
    """All states that were gone through."""
    return [state for last in states for state in (*last.via, last)]


LAW = "cracks.flaw.contact"
CYCLE = ("cyclic_friction", ("numerics.spacing=5",), (0.3, 1.0, -0.2, -1.0, 1.0))
PRESSED = ("compression30", FRICTION, (0.5, -0.5, 1.0, -1.0))
LAWS = {
    "no contact": ("tension0", COARSE, (0.3, 1.0, 0.5)),
    "friction": CYCLE,
    "friction under pressure": PRESSED,
    "in parts": ("compression30", FRICTION, tuple(np.linspace(0.1, 1.0, 10))),
    "displacement": ("compression30", (*FRICTION, "loads=[]", PUSHED), (0.5, 1.0, 0.2)),
    "cohesion that is lost": (*CYCLE, f"{LAW}.cohesion=5"),
    "cohesion that is kept": (*CYCLE, f"{LAW}.cohesion=5", f"{LAW}.cohesion_after_slip=kept"),
    "residual friction": (*CYCLE, f"{LAW}.residual_friction=0.1"),
    "dilation": (*CYCLE, f"{LAW}.dilation_angle=5"),
    "dilation under pressure": (*PRESSED[:2], (0.5, 1.0, 0.2), f"{LAW}.dilation_angle=8"),
    "dilated faces that open": (
        "cyclic_friction",
        (*SMALL_SHEAR, PULL),
        (0.0, 0.2, 0.4, 0.6, 0.8, 1.0),
        *(f"{LAW}.{key}" for key in ("friction=0.6", "residual_friction=0.4", "dilation_angle=15")),
    ),
    "elastic contact": (*CYCLE, "numerics.contact.stiffness=2"),
    "elastic contact under pressure": (*PRESSED, "numerics.contact.stiffness=5"),
}
"""Scene, settings, load factors, more settings."""


def of_law(law: str) -> list[LoadState]:
    name, settings, factors, *more = LAWS[law]
    return through(laid_out(name, *settings, *more), *factors)


@pytest.mark.parametrize("law", LAWS)
def test_work_is_stored_dissipated_or_released_at_every_event(law: str) -> None:
    """However the load turns; friction never gives energy back, and only bonds and strength that is lost release it."""
    states = events(of_law(law))
    lost = [0.0]
    for state in states:
        energy = state.energy
        size = max(abs(energy.work), energy.strain, abs(energy.dissipated))
        assert abs(energy.work - energy.strain - energy.dissipated - energy.released) < 1e-10 * size
        assert energy.released > -1e-9 * size
        if law not in ("cohesion that is lost", "residual friction", "dilated faces that open"):
            assert energy.released < 1e-9 * size
        u, contact = state.outcome.u, state.configuration.contact
        faces = np.tile(contact.weights, 2) @ (contact.law.compliances * state.states.tractions**2)
        rock = float(u @ (state.configuration.stiffness @ u))
        assert energy.strain == pytest.approx(0.5 * (rock + faces), rel=1e-9)
        lost.append(energy.dissipated)
    assert np.diff(lost).min() >= -1e-9 * max(*lost, states[0].energy.strain)
    assert (lost[-1] > 1e-4 * states[-1].energy.strain) == (law != "no contact")


def test_a_bond_that_breaks_releases_half_of_its_strength_times_the_slip() -> None:
    """Cohesion alone: slip rises while the shear falls from c to zero, and rock and loads give c/2 per unit of it."""
    law = ("cracks.flaw.contact.friction=0", "cracks.flaw.contact.cohesion=10")
    configuration = laid_out("compression30", *COARSE, *law)
    (state,) = through(configuration, 1.0)
    behind = next(part for part in state.via if part.outcome.memory.broken.any())
    weights, slip = configuration.contact.weights, behind.outcome.memory.slip
    assert behind.outcome.memory.broken.all()
    assert behind.factor == pytest.approx(10e6 / (100e6 * np.sqrt(3.0) / 4.0), rel=2e-3)
    assert state.energy.released == pytest.approx(0.5 * 10e6 * weights @ np.abs(slip), rel=2e-3)
    assert state.energy.dissipated == 0.0


def test_increments_of_plain_friction_slip_as_events_do() -> None:
    """Their dissipation is of the first order in the increments, and the balance of energies of the second."""
    case = shipped_case("confined30", COARSE)

    def loaded(follow: int | Literal["events"]) -> LoadState:
        return through(ready(replace(case, loading=LoadHistory((1.0,), follow))), 1.0)[0]

    events, some = loaded("events"), [loaded(number) for number in (4, 8, 16)]
    assert len(events.via) > 1
    for state in some:
        slip, known = state.outcome.points.slip, events.outcome.points.slip
        np.testing.assert_allclose(slip, known, atol=1e-9 * np.abs(known).max())
        assert state.energy.error < 1e-5
    off = [abs(state.energy.dissipated / events.energy.dissipated - 1.0) for state in some]
    assert off[2] < 0.6 * off[1] < 0.36 * off[0] < 0.01


@cache
def sheared(*settings: str) -> tuple[Scene, GrowingCrack, LoadState]:
    """The sheared crack, partly unloaded after it has slipped: it sticks with residual slip."""
    configuration = laid_out("cyclic_friction", *SMALL_SHEAR, *settings)
    return configuration.scene, configuration.cracks[0], through(configuration, 0.0, 1.0, 0.6)[-1]


def longer(scene: Scene, growing: GrowingCrack, increment_m: float, kink: float = 0.0) -> GrowingCrack:
    """The crack with another segment at its end."""
    return advanced(growing, True, Segment(kink, increment_m), 1, scene.regions[0])[0]


@pytest.mark.parametrize(
    ("kink", "settings", "off"), [(0.0, (), 1e-3), (1.2, (), 1e-3), (0.0, ("numerics.contact.stiffness=2",), 3e-3)]
)
def test_old_faces_remember_and_new_ones_know_nothing(kink: float, settings: tuple[str, ...], off: float) -> None:
    """What they remember of elastic contact is the inelastic slip alone."""
    scene, growing, state = sheared(*settings)
    grown = assemble(scene, (longer(scene, growing, 5e-3, kink),))
    start, faces, length = mapped(state, grown), grown.faces, 0.02 / scene.lattice.spacing
    total = state.configuration.faces.weights @ state.outcome.memory.slip
    assert faces.weights @ start.memory.slip == pytest.approx(total, rel=off)  # no more, however the points lie now
    apart = np.abs(faces.s - length) > 1e-6  # a node on the old tip may lie to either side
    np.testing.assert_array_equal(start.memory.broken[apart], (faces.s < length)[apart])
    for values in (start.memory.slip, start.memory.normal, start.memory.tangential):
        assert not values[faces.s > length + 2.0].any()


@pytest.mark.parametrize("name", ["tension0", "compression30"])
def test_growth_releases_the_energy_that_K_says(name: str) -> None:
    """G da = (K_I^2 + K_II^2) / E' da straight ahead, by Simpson's rule over the increment; no friction."""
    configuration = laid_out(name, "numerics.spacing=1.5")
    scene, (growing,), G = configuration.scene, configuration.cracks, []
    for cracks in ((growing,), *((longer(scene, growing, da),) for da in (1e-3, 2e-3))):
        K = solve_step(scene, cracks, 1.0).tips[1].K
        G.append(np.dot(K, K) / scene.materials[0].young_prime)
    grown = assemble(scene, (longer(scene, growing, 2e-3),))
    after = increment(grown, mapped(through(configuration, 1.0)[0], grown), 1.0)
    assert after.energy.released == pytest.approx(2e-3 * np.dot([1, 4, 1], G) / 6.0, rel=0.03)
    assert after.energy.error < 1e-9


def test_faces_that_growth_has_made_have_no_cohesion() -> None:
    """The new part goes straight on and is pressed as the old one: only the old one is bonded."""
    configuration = laid_out("compression30", f"{LAW}.cohesion=130")  # three times the shear on the flaw's plane
    scene, (growing,) = configuration.scene, configuration.cracks
    solution = solve_step(scene, (longer(scene, growing, 3e-3),), 1.0)
    points, new = solution.outcome.points, solution.configuration.faces.s * scene.lattice.spacing > 10e-3 + 1e-9
    assert new.any()
    assert not points.tangential[new].any()
    assert set(points.state[~new].tolist()) == {STICK}


def test_stuck_faces_do_not_jump_back_when_the_crack_grows() -> None:
    """Friction holds the old faces, the new ones hardly slip: without memory all of the slip would be lost."""
    scene, growing, state = sheared()
    grown = assemble(scene, (longer(scene, growing, 4e-3),))
    after = increment(grown, mapped(state, grown), state.factor)
    s = np.linspace(1e-3, 19e-3, 50) / scene.lattice.spacing
    was, now = (
        gap_and_slip(x.configuration.cover, points_at(x.configuration.cover, 0, s), x.outcome.u)[1]
        for x in (state, after)
    )
    forgotten = increment(grown, unloaded(grown), state.factor)
    lost = gap_and_slip(grown.cover, points_at(grown.cover, 0, s), forgotten.outcome.u)[1]
    assert np.abs(now - was).max() < 0.3 * np.abs(was).max()  # at the old tip new faces have opened a way
    assert np.abs(np.mean(now - was)) < 0.1 * np.mean(np.abs(was))
    assert np.abs(np.mean(lost - was)) > 0.3 * np.mean(np.abs(was))


def test_loads_move_by_their_work_over_their_force_even_if_a_tip_is_close_to_them() -> None:
    """Half of force times displacement is the energy. The tip at 26 mm enriches patches on the upper edge."""
    flaw = "cracks.flaw={path: {points: [[1, -5], [-2, 26]]}, contact: none}"
    result = next(grow(shipped_case("compression30", [*COARSE, flaw, "growth.steps=0"])))
    force = 2.0 * 100e6 * 31e-3  # N/m, on both edges
    assert 0.5 * force * result.load_displacement == pytest.approx(result.energy.strain, rel=1e-9)


def test_a_load_that_is_not_followed_to_its_end_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bonds that break one after the other take more pieces than are allowed here."""
    case = shipped_case("compression30", [*FRICTION, "cracks.flaw.contact.cohesion=10", "growth.steps=0"])
    assert not any("was not followed" in warning for warning in next(grow(case)).warnings)
    monkeypatch.setattr(increments, "MOST_PIECES", 1)
    warnings = [warning for warning in next(grow(case)).warnings if "was not followed" in warning]
    assert len(warnings) == 1


@pytest.mark.parametrize(
    ("share", "words"),
    [(1.5, "miss each other by"), (-1.0, "J/m in a part of the load"), (-1.0, "J/m as cracks grow")],
)
def test_energies_that_do_not_add_up_are_a_warning(monkeypatch: pytest.MonkeyPatch, share: float, words: str) -> None:
    case = shipped_case("compression30", [*FRICTION, "growth.steps=1", "growth.unload_between_steps=false"])
    assert not any(words in warning for step in grow(case) for warning in step.warnings)
    true = increments.dissipated_on

    def wrong(*of: Any) -> tuple[Bools, Floats]:
        slides, by_point = true(*of)
        return slides, share * by_point

    monkeypatch.setattr(increments, "dissipated_on", wrong)
    assert any(words in warning for step in grow(case) for warning in step.warnings)


@pytest.mark.parametrize("law", ["friction", "cohesion that is kept", "elastic contact"])
def test_between_two_events_states_are_linear_in_the_load(law: str) -> None:
    """Half way between them an increment of its own finds the mean of their tractions."""
    states, compared = events(of_law(law)), 0
    for one, other in pairwise(states):
        if abs(other.factor - one.factor) > 1e-3:
            middle = one.configuration.states(LoadLevel(0.5 * (one.factor + other.factor)), one.memory)
            mean = 0.5 * (one.states.tractions + other.states.tractions)
            np.testing.assert_allclose(middle.tractions, mean, atol=1e-8 * np.abs(one.states.tractions).max())
            compared += 1
    assert compared > 2


def test_a_load_that_goes_to_nothing_ends_in_few_pieces() -> None:
    """Faces that have lost their bonds stick, part and slide in turn, at a hundredth of the load each time."""
    law = "cracks.flaw.contact={friction: 0.3, cohesion: 5, cohesion_after_slip: kept}"
    settings = ("growth.steps=0", "numerics={spacing: 1.5}", "loading={history: [1, 0]}", "output.frames=none", law)
    *_, (result, solution) = solved_steps(shipped_case("compression30", settings))
    assert 20 < len(solution.via) < 100
    assert np.abs(result.contact.normal_traction).max() < 1e-8 * 100e6
    assert result.energy.error < 1e-9
    assert result.energy.released > 0.0  # of bonds that pressure and shear have locked
