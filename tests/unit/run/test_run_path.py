"""The path between two loads: pieces on which every point stays on its branch of the law, and nothing is missed."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.contact.coulomb import OPEN, ContactMemory
from crackgrow.run import grow
from crackgrow.run.checkpoint import beginning
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.increments import LoadState, from_state, held_loads, increment
from crackgrow.run.load_level import LoadLevel
from crackgrow.run.scene import make_scene
from tests.scenes import shipped_case
from tests.stability.growing_scenes import growing_scene, text_of

COARSE = "numerics.spacing=5"
EXACT = 1e-10
"""Balance of energies, relative to the largest."""

LAWS = {
    "friction": (),
    "cohesion that is lost": ("cracks.flaw.contact.cohesion=5",),
    "cohesion that is kept": ("cracks.flaw.contact.cohesion=5", "cracks.flaw.contact.cohesion_after_slip=kept"),
    "residual friction": ("cracks.flaw.contact.residual_friction=0.1",),
    "dilation": ("cracks.flaw.contact.dilation_angle=5",),
    "elastic contact": ("numerics.contact.stiffness=2",),
}


def ready(*settings: str) -> Configuration:
    case = shipped_case("cyclic_friction", [COARSE, *settings])
    return assemble(make_scene(case), beginning(case).cracks)


def through(configuration: Configuration, *factors: float) -> list[LoadState]:
    """The states at load factors, in turn, with all those that they went through."""
    start, states = held_loads(configuration), []
    for factor in factors:
        state = increment(configuration, start, factor)
        states += [*state.via, state]
        start = from_state(state)
    return states


@pytest.mark.parametrize("law", LAWS)
def test_energies_balance_at_every_event(law: str) -> None:
    """Work is stored, dissipated or released to round-off, however the load turns."""
    for state in through(ready(*LAWS[law]), 0.3, 1.0, -0.2, -1.0, 1.0):
        energy = state.energy
        size = max(abs(energy.work), energy.strain, abs(energy.dissipated))
        missing = energy.work - energy.strain - energy.dissipated - energy.released
        assert abs(missing) < EXACT * size


def test_strain_energy_is_that_of_the_displacements() -> None:
    for state in through(ready(), 1.0, -1.0):
        u = state.outcome.u
        assert state.energy.strain == pytest.approx(
            0.5 * float(u @ (state.configuration.stiffness.matrix @ u)), rel=1e-10
        )


@pytest.mark.parametrize("law", ["friction", "cohesion that is kept", "elastic contact"])
def test_between_two_events_states_are_linear_in_the_load(law: str) -> None:
    """Half way between them an increment of its own finds the mean of their tractions and jumps."""
    configuration = ready(*LAWS[law])
    states = through(configuration, 1.0, -1.0)
    assert len(states) > 3
    compared = 0
    for one, other in pairwise(states):
        if abs(other.factor - one.factor) < 1e-3:
            continue
        middle = configuration.states(LoadLevel(0.5 * (one.factor + other.factor)), one.remembered.memory)
        size = np.abs(one.states.tractions).max()
        mean = 0.5 * (one.states.tractions + other.states.tractions)
        np.testing.assert_allclose(middle.tractions, mean, atol=1e-8 * size)
        compared += 1
    assert compared > 2


def test_how_often_a_load_pauses_changes_nothing() -> None:
    once, often = (
        through(ready(*LAWS["residual friction"]), *factors)[-1]
        for factors in ((1.0, -1.0), (0.2, 0.55, 1.0, 0.3, 0.1, -0.4, -1.0))
    )
    np.testing.assert_allclose(often.states.tractions, once.states.tractions, rtol=1e-7)
    assert often.energy.dissipated == pytest.approx(once.energy.dissipated, rel=1e-7)


def test_the_way_that_was_followed_leaves_what_was_remembered_alone() -> None:
    configuration = ready()
    (state,) = through(configuration, 1.0)[-1:]
    start = from_state(state)
    memory = start.remembered.memory
    kept = ContactMemory(memory.slip.copy(), memory.lost.copy(), memory.closed.copy(), memory.risen.copy())
    one = increment(configuration, start, -1.0)
    two = increment(configuration, start, -1.0)
    np.testing.assert_array_equal(one.outcome.u, two.outcome.u)
    np.testing.assert_array_equal(start.remembered.memory.slip, kept.slip)
    np.testing.assert_array_equal(start.remembered.memory.broken, kept.broken)


@pytest.mark.parametrize("seed", [25, 138])
def test_what_only_its_bond_has_held_lets_go_when_it_opens(tmp_path: Path, seed: int) -> None:
    """Cohesion that is kept holds faces only while they touch; what a point lets go of is released."""
    file = tmp_path / "scene.yaml"
    file.write_text(text_of(growing_scene(seed)), encoding="utf-8")
    n_open = 0
    for result in grow(load_case(file)):
        contact = result.contact
        is_open = contact.state == OPEN
        n_open += is_open.sum()
        assert not contact.tangential_traction[is_open].any()
        assert result.energy.error < 1e-6
        assert result.energy.released > -1e-9 * abs(result.energy.work)
    assert n_open > 0
