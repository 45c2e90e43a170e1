"""The error of K that a run by a name measures: when it does, and what holds where it does not."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.run import aim as aim_file
from crackgrow.run import grow
from crackgrow.run.checkpoint import beginning
from crackgrow.run.growth_error import judged_when_off, kink_errors
from crackgrow.run.halvings import accuracy_of_record, record_of
from crackgrow.run.layout import cover_of
from crackgrow.run.loading import load
from crackgrow.run.loop import solved_steps
from crackgrow.run.nearby import room_at_tips
from crackgrow.run.other_cells import accuracy_of, compared, fitted_bounds
from crackgrow.run.scene import make_scene
from crackgrow.run.still_known import Since

CASES = Path(__file__).parents[3] / "cases"
QUIET = ("output.frames=none", "output.figures=false", "output.report=false")
KINKED = "cracks.flaw.path={points: [[-4 mm, 0], [2 mm, 0], [4 mm, 4 mm]]}"

pytestmark = pytest.mark.physics


def case(*overrides: str) -> Case:
    return load_case(CASES / "compression30.yaml", ["numerics.accuracy=draft", *QUIET, *overrides])


def test_K_is_that_of_a_run_whose_error_is_not_measured() -> None:
    """A spacing that is given is one; what it knows of the error is the fitted bound."""
    measured = case("growth.steps=2")
    given = replace(measured, numerics=replace(measured.numerics, auto_rule=None))
    for one, other in zip(grow(measured), grow(given), strict=True):
        assert [(tip.K_I, tip.K_II) for tip in one.tips] == [(tip.K_I, tip.K_II) for tip in other.tips]
        assert all(math.isfinite(tip.K_error_expected) for tip in one.tips)
        assert all(math.isnan(tip.K_error_expected) for tip in other.tips)
        assert all(new.K_I_error < old.K_I_error for new, old in zip(one.tips, other.tips, strict=True))


def test_it_is_measured_again_where_what_was_added_is_over_twice_as_long() -> None:
    steps = [step.factorizations for step in grow(case("growth.steps=8"))]
    assert steps == [2, 2, 1, 2, 1, 1, 1, 2, 1]


def test_cells_to_compare_are_half_as_large_and_an_eighth_at_kinks() -> None:
    kinked = case(KINKED)
    solution = load(make_scene(kinked), beginning(kinked).cracks)
    other = cover_of(compared(solution), beginning(kinked).cracks)
    assert [0.5 * tip.size for tip in solution.cover.tips] == [tip.size for tip in other.tips]
    at_kink = [float(cover.surfaces[0].in_cells.size(np.array([6e-3 / cover.lattice.spacing]))[0])
               for cover in (solution.cover, other)]  # fmt: skip
    assert at_kink[0] == 8.0 * at_kink[1]
    assert other.sizes.max() == solution.cover.sizes.max()


def test_they_are_half_as_large_at_tips_of_a_crack_that_the_largest_cells_resolve() -> None:
    """It asks for cells 2.1 times as large as they are."""
    long = case("cracks.flaw.path={center: [0 mm, 0 mm], length: 33 mm, angle: 90}", "growth.steps=0")
    result, solution = next(solved_steps(long))
    assert [tip.size for tip in solution.cover.tips] == [1.0, 1.0]
    assert [tip.size for tip in cover_of(compared(solution), beginning(long).cracks).tips] == [0.5, 0.5]
    assert all(math.isfinite(tip.K_error_expected) for tip in result.tips)


def test_a_crack_that_has_grown_more_than_the_others_has_the_fitted_bound() -> None:
    two = load_case(CASES / "two_flaws.yaml", ["numerics.accuracy=draft", *QUIET])
    _, solution = next(solved_steps(two))
    last = solution.accuracy
    assert last is not None
    known = Since(replace(last, grown=(1e-3, 1e-3)), solution, (1.5e-3, 3e-3)).carried_over
    fitted = fitted_bounds(solution)
    for tip, (crack, _) in enumerate(solution.cover.tip_ends):
        assert known.bounds[tip] == (fitted[tip] if crack == 1 else last.bounds[tip])
        assert math.isnan(known.expected[tip]) == (crack == 1)


def test_a_crack_that_has_started_since_has_the_fitted_bound_at_every_step() -> None:
    two = load_case(CASES / "two_flaws.yaml", ["numerics.accuracy=draft", *QUIET])
    _, solution = next(solved_steps(two))
    last = solution.accuracy
    assert last is not None
    first = {name: getattr(last, name)[:2] for name in ("ends", "bounds", "expected", "rooms")}
    known = replace(last, grown=(1e-3,), **first)
    for _ in range(2):
        known = Since(known, solution, (1.5e-3, 0.2e-3)).carried_over
        assert known.bounds == (*last.bounds[:2], *fitted_bounds(solution)[2:])
        assert [math.isnan(error) for error in known.expected] == [False, False, True, True]


def test_a_tip_with_a_third_less_room_has_the_fitted_bound() -> None:
    """K beside an outline rises, and its error with it, faster than what is added to the crack."""
    _, solution = next(solved_steps(case("growth.steps=0")))
    last = solution.accuracy
    assert last is not None
    assert last.rooms == room_at_tips(solution.scene, solution.cover)
    assert last.rooms == pytest.approx([10e-3, 10e-3])  # the crack's length: nothing is nearer
    fitted = fitted_bounds(solution)
    known = Since(replace(last, rooms=(14e-3, 16e-3)), solution, (0.0,)).carried_over
    assert known.bounds == (last.bounds[0], fitted[1])
    assert [math.isnan(error) for error in known.expected] == [False, True]
    _, targeted = next(solved_steps(case("growth.steps=0", "numerics.accuracy=3 %")))
    last = targeted.accuracy
    assert last is not None
    for rooms, wider in (((14e-3, math.nan), (1.0, 1.0)), ((14e-3, 16e-3), (1.0, (1.6 / 1.5) ** 2))):
        since = Since(replace(last, rooms=rooms), targeted, (0.0,))
        assert since.holds
        assert since.carried_over.bounds == pytest.approx(np.multiply(wider, last.bounds), rel=1e-6)
    assert not Since(replace(last, rooms=(14e-3, 160e-3)), targeted, (0.0,)).holds


def test_it_is_measured_again_where_a_tip_has_less_room_but_not_at_once() -> None:
    """After a step for each tip: a scene with many would be measured all the time."""
    _, solution = next(solved_steps(case("growth.steps=0")))
    last = solution.accuracy
    assert last is not None
    crowded = replace(last, rooms=tuple(2.0 * room for room in last.rooms))
    assert [Since(replace(crowded, age=age), solution, (0.0,)).holds for age in (0, 1, 2)] == [True, True, False]
    assert Since(replace(last, age=100), solution, (0.0,)).holds
    assert Since(crowded, solution, (0.0,)).carried_over.age == 1


def test_what_was_not_measured_is_not_carried_over() -> None:
    """The fitted bound is that of the step itself."""
    _, solution = next(solved_steps(case("growth.steps=0")))
    last = replace(accuracy_of(solution, None), grown=(0.0,), bounds=(1.0, 2.0))
    fitted = fitted_bounds(solution)
    assert Since(last, solution, (0.0,)).carried_over.bounds == tuple(fitted)


def test_what_the_criterion_says_on_the_other_cells_is_kept_and_carried_over() -> None:
    """K may be the same on both, where the stress at the distance of its average is not."""
    case_ = case("growth.steps=0", "loading=critical")
    result, solution = next(solved_steps(case_))
    last = solution.accuracy
    assert last is not None
    other = load(compared(solution), solution.cracks)
    here, there = (solution.tips[0].verdict, other.tips[0].verdict)
    assert here is not None
    assert there is not None
    share = other.state.factor / solution.state.factor  # both just meet the criterion, and stress is linear
    assert last.criticalities == pytest.approx([abs(1.0 / share - 1.0)] * 2, rel=1e-3)
    assert last.turns == pytest.approx([abs(there.kink - here.kink)] * 2, rel=1e-3)
    assert result.load_factor_error >= 299.99 * last.criticalities[0]
    assert all(tip.kink_error_deg >= math.degrees(2.9999 * last.turns[0]) for tip in result.tips)
    again = Since(last, solution, (0.0,)).carried_over
    assert (again.turns, again.criticalities) == (last.turns, last.criticalities)


def test_both_tips_of_a_crack_have_the_larger_of_their_differences() -> None:
    """That of one tip may pass through zero."""
    _, solution = next(solved_steps(case("growth.steps=0", "cracks.flaw.path.center=[7 mm, 3 mm]")))
    last = solution.accuracy
    assert last is not None
    other = load(compared(solution), solution.cracks)
    verdicts = [[tip.verdict for tip in each.tips] for each in (solution, other)]
    turns = [abs(here.kink - there.kink) for here, there in zip(*verdicts, strict=True) if here and there]
    criticalities = [abs(there.criticality / here.criticality - 1.0) for here, there in zip(*verdicts, strict=True)]
    assert min(turns) < 0.9 * max(turns)
    assert last.turns == pytest.approx([max(turns)] * 2, rel=1e-6)
    assert last.criticalities == pytest.approx([max(criticalities)] * 2, rel=1e-2)


def test_a_direction_is_off_by_half_a_turn_at_most() -> None:
    """Of two directions as good as each other the other cells may show the other one."""
    _, solution = next(solved_steps(case("growth.steps=0")))
    known = solution.accuracy
    assert known is not None
    turned = replace(solution, accuracy=replace(known, turns=(2.0, 1.0)))
    assert kink_errors(turned, judged_when_off(turned, [(0.0, 0.0)] * 2)) == [math.pi, 3.0]


def test_where_bonds_break_at_the_critical_load_the_other_cells_have_their_own() -> None:
    """At the same load they may not break: K would differ by more than half."""
    bonded = [f"cracks.flaw.contact.{name}" for name in ("cohesion=1 MPa", "friction=0.1")]
    uneven = [f"loads.{k}.traction=[0, '{pressure} * (1 + x / 20)']" for k, pressure in enumerate((-100, 100))]
    result, solution = next(solved_steps(case("growth.steps=0", "loading=critical", *bonded, *uneven)))
    assert any(solution.jumps)
    known = solution.accuracy
    assert known is not None
    other = load(compared(solution), solution.cracks)
    apart = abs(other.state.factor / solution.state.factor - 1.0)
    assert 1e-4 < apart < 0.1
    assert result.load_factor_error == pytest.approx(300.0 * apart, rel=1e-6)
    assert max(known.shares()) < 0.3
    for jumps in (True, False):  # the difference at one load tells nothing of that of two loads
        last = accuracy_of_record(record_of(replace(known, jumps=jumps)))
        assert Since(last, solution, (0.0,)).holds == jumps


def test_a_scene_with_very_many_unknowns_has_the_fitted_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(aim_file, "MOST_UNKNOWNS_OF_A_NAME", 100)
    large = case("growth.steps=0")
    result, solution = next(solved_steps(large))
    assert all(math.isnan(tip.K_error_expected) for tip in result.tips)
    assert result.factorizations == 1  # nothing else is solved
    assert [tip.K_I_error for tip in result.tips] == list(accuracy_of(solution, None).bounds)


def test_a_resumed_run_measures_as_one_that_was_not_stopped() -> None:
    whole = list(grow(case("growth.steps=4")))
    for begun in (1, 2):
        again = list(grow(case("growth.steps=4"), whole[begun].checkpoint))
        for one, other in zip(whole[begun:], again, strict=True):
            columns = [(tip.K_I, tip.K_I_error, tip.K_error_expected) for tip in one.tips]
            assert columns == [(tip.K_I, tip.K_I_error, tip.K_error_expected) for tip in other.tips]
