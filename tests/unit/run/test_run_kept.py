"""What a step takes over from the one before is what it would find alone, to the last bit; all else is found anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.contact import system
from crackgrow.fracture.advance import GrowingCrack, Way, advanced
from crackgrow.fracture.stress_intensity import IntegralReading
from crackgrow.run import grow
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.loop import solved_steps
from crackgrow.run.scene import make_scene
from tests.benchmarks.flaw_field import field_case


@pytest.fixture(scope="module")
def steps() -> tuple[Configuration, Configuration, Configuration]:
    """Six flaws; the same after one tip has grown, with what was known before and without it."""
    case = field_case(6, 1, spacing=4, refine={"tips": 2, "kinks": 3})
    scene = make_scene(case)
    cracks = tuple(map(GrowingCrack.given, case.cracks))
    first = assemble(scene, cracks)
    assert integrals(first)
    assert first.fields
    grown, _ = advanced(cracks[0], True, Way(0.6, 4e-3), 1, scene.regions[0], cracks[1:])
    after = (grown, *cracks[1:])
    return first, assemble(scene, after, first), assemble(scene, after)


def integrals(configuration: Configuration) -> list[IntegralReading]:
    """What the integrals of all tips read off."""
    tips = [(tip, False) for tip in range(len(configuration.cover.tips))]
    return configuration.integrals.of(configuration.scene.materials, tips)


def test_readings_taken_over_are_those_found_alone(steps: tuple[Configuration, ...]) -> None:
    _, later, alone = steps
    for ours, fresh in zip(integrals(later), integrals(alone), strict=True):
        np.testing.assert_array_equal(ours.functions, fresh.functions)
        assert (ours.reading is None) == (fresh.reading is None)
        if ours.reading is not None and fresh.reading is not None:
            np.testing.assert_array_equal(ours.reading.rows, fresh.reading.rows)
            for mine, other in zip(ours.reading.more, fresh.reading.more, strict=True):
                np.testing.assert_array_equal(mine, other)
    for number, field in later.fields.items():
        np.testing.assert_array_equal(field.functions, alone.fields[number].functions)
        np.testing.assert_array_equal(field.reading.rows, alone.fields[number].reading.rows)
        for mine, other in zip(field.reading.more, alone.fields[number].reading.more, strict=True):
            np.testing.assert_array_equal(mine, other)


def test_only_tips_near_what_has_changed_are_read_anew(steps: tuple[Configuration, ...]) -> None:
    first, later, alone = steps
    every = len(integrals(alone)) + len(alone.fields)
    assert len(integrals(later)) == len(later.cover.tips)
    assert first.readings.n_made == alone.readings.n_made == every
    assert 2 <= later.readings.n_made < every
    moved = [number for number, tip in enumerate(later.cover.tips) if tip.crack == 0]
    rows = [
        first.fields[number].reading.rows is later.fields[number].reading.rows for number in range(len(first.fields))
    ]
    assert not rows[moved[-1]]
    assert any(rows)


def test_products_of_a_later_step_are_those_of_it_alone(steps: tuple[Configuration, ...]) -> None:
    first, later, alone = steps
    u = np.random.default_rng(3).normal(size=later.cover.n_dofs)
    np.testing.assert_array_equal(later.stiffness.matrix @ u, alone.stiffness.matrix @ u)
    np.testing.assert_array_equal(later.stiffness.matrix.sizes(u), alone.stiffness.matrix.sizes(u))
    known = {part.key for part in first.stiffness.summed.blocks.parts}
    assert any(part.key in known for part in later.stiffness.summed.blocks.parts)
    assert any(part.key not in known for part in later.stiffness.summed.blocks.parts)


def test_compliance_of_contact_taken_over_is_that_found_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Subtrees far from what has grown are taken over."""
    monkeypatch.setattr(system, "FEW_NUMBERS", 0)
    case = field_case(6, 1, spacing=4, refine={"tips": 2, "kinks": 3})
    scene = make_scene(case)
    cracks = tuple(map(GrowingCrack.given, case.cracks))
    first = assemble(scene, cracks)
    assert first.faces.n == len(first.contact.rock) // 2
    grown, _ = advanced(cracks[3], True, Way(0.6, 4e-3), 1, scene.regions[0], (*cracks[:3], *cracks[4:]))
    after = (*cracks[:3], grown, *cracks[4:])
    later, alone = assemble(scene, after, first), assemble(scene, after)
    np.testing.assert_array_equal(later.contact.rock, alone.contact.rock)
    ours, before = later.contact.system.factorization.reduced, first.contact.system.factorization.reduced
    assert ours.keys() == alone.contact.system.factorization.reduced.keys()
    assert 0 < len(ours.keys() - before.keys()) < 0.7 * len(ours)


def test_compliance_asked_for_in_turn_is_that_of_the_points_asked_for(steps: tuple[Configuration, ...]) -> None:
    """Few of them are kept, whatever is asked for; what is kept is not that of other points."""
    contact = replace(steps[0].contact)
    n = len(contact.weights)
    for _ in range(2):
        for first in range(5):
            points = np.arange(first, n, 3)
            found = contact.compliance(points, np.ones(len(points), dtype=bool))
            at = np.concatenate([points, n + points])
            expected = contact.rock[np.ix_(at, at)] + np.diag(contact.law.compliances[at])
            np.testing.assert_array_equal(found, expected)
            assert len(vars(contact)["_compliances"]) <= system.AT_HAND


def test_a_run_gone_on_with_has_the_bits_of_one_that_was_not_broken_off() -> None:
    """It knows nothing of the steps before; what is kept follows from its key alone."""
    case = field_case(3, 2)
    whole = list(grow(case))
    assert whole[1].checkpoint is not None
    again = list(grow(case, whole[1].checkpoint))
    assert [result.step for result in again] == [1, 2]
    for ours, before in zip(again, whole[1:], strict=True):
        assert ours.load_factor == before.load_factor
        for tip, other in zip(ours.tips, before.tips, strict=True):
            assert (tip.K_I, tip.K_II, tip.criticality) == (other.K_I, other.K_II, other.criticality)


def test_a_run_holds_the_factors_of_its_last_step_alone() -> None:
    first, last = (solution.contact.system for _, solution in list(solved_steps(field_case(6, 1))))
    assert len(first.factorization.factors) < 0.1 * len(last.factorization.factors)  # that the next one had in common
    last.solve(np.zeros(last.stiffness.shape[0]))
    with pytest.raises(RuntimeError, match="handed over"):
        first.solve(np.zeros(first.stiffness.shape[0]))
