"""Cells that are halved for a target of the error of K, what is told where they can't be, and what is kept of it."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NoReturn

import numpy as np
import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.cover.refinement import MOST_LEVELS
from crackgrow.errors import SolveError
from crackgrow.fracture.stress_intensity import StressIntensity
from crackgrow.run import aimed_history as aimed_history_file
from crackgrow.run import grow
from crackgrow.run import scene as scene_file
from crackgrow.run import target as target_file
from crackgrow.run.caution import Cause
from crackgrow.run.checkpoint import beginning, restored
from crackgrow.run.halvings import Accuracy, Halvings, accuracy_of_record, record_of
from crackgrow.run.judging import StepSolution
from crackgrow.run.layout import cover_of
from crackgrow.run.loading import LoadsInTurn, NextStep, load
from crackgrow.run.loop import solved_steps
from crackgrow.run.other_cells import compared, still_tells
from crackgrow.run.result import Checkpoint, StepResult
from crackgrow.run.scene import Scene, make_scene
from crackgrow.run.still_known import Since
from crackgrow.run.target import aimed, cells_after
from tests.unit.run.test_run_starting import SQUARE, plate

CASES = Path(__file__).parents[3] / "cases"
QUIET = ("output.frames=none", "output.figures=false", "output.report=false")


SHEARED = (
    "growth.steps=2",
    "growth.increment=2",
    "growth.advance=all",
    "growth.initiation=ends",
    "cracks.flaw.contact.friction=0.3",
    "bodies.rock.strength.cohesion=0.6",
)
"""Shear cracks start at the ends of a flaw, beside its wings."""

ABOVE = ("cracks.flaw={path: {points: [[0, 31], [0, 49]]}, contact: none}",)
"""An open crack that ends a millimetre below an edge."""


def case(name: str, target: str, *settings: str) -> Case:
    return load_case(
        CASES / f"{name}.yaml", ["numerics.spacing=auto", f"numerics.accuracy={target}", *settings, *QUIET]
    )


def shares(step: StepResult) -> list[float]:
    """Bounds of K over the largest K, tip by tip."""
    largest = max(np.hypot(tip.K_I, tip.K_II) for tip in step.tips)
    return [max(tip.K_I_error, tip.K_II_error) / largest for tip in step.tips]


def told(step: StepResult) -> list[str]:
    return [caution.words for caution in step.cautions if caution.cause is Cause.TARGET]


@pytest.mark.parametrize("target", [0.05, 0.02, 0.005])
def test_bounds_of_K_are_within_the_target(target: float) -> None:
    step = next(grow(case("compression30", str(target))))
    assert max(shares(step)) <= target
    assert told(step) == []


def test_a_smaller_target_takes_smaller_cells() -> None:
    steps = [next(grow(case("compression30", target))) for target in ("5 %", "1 %")]
    assert np.all(np.diff([step.tips[0].cell_size for step in steps]) < 0.0)
    assert np.all(np.diff([step.n_dofs for step in steps]) > 0)


def test_cells_to_compare_are_twice_as_large_at_the_tips_and_away_from_them() -> None:
    scene = make_scene(case("compression30", "2 %", "numerics.refine.corners=1"))
    solution = load(scene, beginning(scene.case).cracks)
    covers = [cover_of(each, beginning(scene.case).cracks) for each in (scene, compared(solution))]
    small, large = (cover.lattice.cells.size for cover in covers)
    assert (large.min(), large.max()) == (2 * small.min(), 2 * small.max())
    assert [2.0 * tip.size for tip in covers[0].tips] == [tip.size for tip in covers[1].tips]
    assert covers[0].lattice.spacing == covers[1].lattice.spacing == 2.0 * scene.case.numerics.spacing


IN_A_WIDE_PLATE = (
    "bodies.rock.shape={rectangle: {center: [0, 0], width: 2000, height: 2000}}",
    "supports=[{at: [-1000, -1000], displacement: {x: 0, y: 0}}, {at: [1000, -1000], displacement: {y: 0}}]",
    "loading={history: [1]}",
)
KINKED = "cracks.flaw.path={points: [[-4, -3], [4, 3], [4, 9]]}"


def in_a_wide_plate(folder: Path, target: str, *settings: str, grows: bool = False) -> Case:
    """The flaw of compression30, with growth or without."""
    scene = yaml.safe_load((CASES / "compression30.yaml").read_text(encoding="utf-8"))
    if not grows:
        del scene["growth"]
    file = folder / "wide.yaml"
    file.write_text(yaml.safe_dump({**scene, "numerics": {"accuracy": target}}), encoding="utf-8")
    return load_case(file, [*IN_A_WIDE_PLATE, *settings, *QUIET])


@pytest.mark.parametrize(
    ("settings", "grows", "same"), [((), False, True), ((), True, False), ((KINKED,), False, False)]
)
def test_small_targets_begin_with_large_cells_where_cracks_are_straight_and_do_not_grow(
    settings: tuple[str, ...], grows: bool, same: bool, tmp_path: Path
) -> None:
    """Tip functions follow the field there, no stress is averaged over cells, and no later kink needs small ones."""
    cases = [in_a_wide_plate(tmp_path, target, *settings, grows=grows) for target in ("1 %", "0.3 %")]
    spacings = [each.numerics.spacing for each in cases]
    at_tips = [each.numerics.spacing * 0.5 ** make_scene(each).halvings.cracks[0] for each in cases]
    assert (spacings[0] == spacings[1], at_tips[0] == at_tips[1]) == (same, same)


def test_a_straight_crack_in_a_wide_plate_meets_a_small_target_with_few_cells(tmp_path: Path) -> None:
    step = next(grow(in_a_wide_plate(tmp_path, "0.1 %")))
    assert max(shares(step)) <= 0.001
    assert told(step) == []
    assert step.n_dofs < 10_000  # 50,000 on cells that are made for the target


BESIDE_A_TIP = {
    "support": {
        "supports=[{at: [0, 50], displacement: {x: 0, y: 0}}, {at: [-50, -50], displacement: {x: 0}}]",
        "loads=[{on: {body: rock, edge: bottom}, traction: [1, -1]}]",
    },
    "load": {
        "supports=[{on: {body: rock, edge: bottom}, displacement: {x: 0, y: 0}}]",
        "loads=[{on: {body: rock, edge: top, from: -0.5, to: 0.5}, traction: [0, -100]}]",
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("what", BESIDE_A_TIP)
def test_a_force_on_a_small_place_beside_a_tip_is_seen_by_the_bound(what: str) -> None:
    """Cells round the tip, which are as large there whatever those at the tip are, had told nothing of it.

    The truth is known as well as two kinds of smaller cells agree: K beside a force at a point is that of its cells.
    """
    aimed_at = case("slant_tension", "0.3 %", *ABOVE, *BESIDE_A_TIP[what])
    step, true = next(grow(aimed_at)), []
    for rings in (2, 4):
        refine = f"numerics.refine={{tips: 6, corners: 9, rings: {rings}}}"
        smaller = case("slant_tension", "draft", *ABOVE, *BESIDE_A_TIP[what], refine)
        true.append(np.array([tip.K for tip in load(make_scene(smaller), beginning(smaller).cracks).tips]))
    errors = np.hypot(*(np.array([(tip.K_I, tip.K_II) for tip in step.tips]) - true[0]).T)
    good_to = np.hypot(*(true[1] - true[0]).T).max()
    assert told(step) == []
    assert errors.max() <= max(max(tip.K_I_error, tip.K_II_error) for tip in step.tips) + good_to


def test_cells_beside_a_tip_are_larger_to_compare_where_a_force_acts() -> None:
    sizes = []
    aimed_at = case("slant_tension", "0.3 %", *ABOVE, *BESIDE_A_TIP["support"])
    scene = make_scene(aimed_at)
    solution = load(replace(scene, halvings=Halvings(1, (8,))), beginning(aimed_at).cracks)
    for each in (solution.scene, compared(solution)):
        lattice = cover_of(each, beginning(aimed_at).cracks).lattice
        (tile,) = lattice.tiles_at(lattice.to_lattice(np.array([[0.0, 0.04999]])))
        sizes.append(int(lattice.cells.size[lattice.tiles.cell[tile]]))
    assert sizes[1] == 2 * sizes[0]


def test_cells_to_compare_are_an_eighth_as_large_at_kinks() -> None:
    """Or a quarter, or twice as large there, too, where cells can't be halved so often."""
    kinked = case("compression30", "2 %", "cracks.flaw.path={points: [[-4 mm, 0], [2 mm, 0], [4 mm, 4 mm]]}")
    scene = make_scene(kinked)
    for more, times in ((0, 8.0), (MOST_LEVELS - 8, 4.0), (MOST_LEVELS - 7, 0.5)):
        given = replace(scene, halvings=replace(scene.halvings, kinks=more))
        solution = load(given, beginning(kinked).cracks)
        other = cover_of(compared(solution), beginning(kinked).cracks)
        assert solution.cover.sizes.min() == times * other.sizes.min()
        assert [2.0 * tip.size for tip in solution.cover.tips] == [tip.size for tip in other.tips]


def test_cells_to_compare_are_an_eighth_as_large_at_kinks_of_cracks_whose_cells_are_not_halved() -> None:
    """Wings of a crack that is long beside the cells begin so for a target that asks for little."""
    kinked = case("compression30", "2 %", "cracks.flaw.path={points: [[-4 mm, 0], [2 mm, 0], [4 mm, 4 mm]]}")
    scene = make_scene(kinked)
    given = replace(scene, halvings=replace(scene.halvings, cracks=(0,)))
    solution = load(given, beginning(kinked).cracks)
    assert solution.cover.sizes.min() == 8.0 * cover_of(compared(solution), beginning(kinked).cracks).sizes.min()


@pytest.mark.parametrize("wing", [1.0, 0.2])
def test_tips_of_short_wings_gather_their_functions(wing: float) -> None:
    """On the cells to compare, too: else hundreds of functions reach over all cells at the kink."""
    kinked = case(
        "compression30", "2 %", f"cracks.flaw.path={{points: [[-4 mm, 0], [4 mm, 0], [{4 + wing} mm, {wing} mm]]}}"
    )
    solution = load(make_scene(kinked), beginning(kinked).cracks)
    other = cover_of(compared(solution), beginning(kinked).cracks)
    assert solution.cover.tips[1].carriers.gathered
    assert other.tips[1].carriers.gathered


def test_a_jog_beside_a_tip_asks_for_no_smaller_cells_than_its_kink() -> None:
    kinked = case("compression30", "2 %", "cracks.flaw.path={points: [[-4 mm, 0], [4 mm, 0], [4.02 mm, 0.02 mm]]}")
    scene = make_scene(kinked)
    cover = cover_of(scene, beginning(kinked).cracks)
    assert cover.sizes.min() == 0.5 * 0.5 ** scene.halvings.at_kinks(0)


def test_kinks_are_halved_from_the_beginning() -> None:
    """Though the tips of a crack that is long beside the cells ask for nothing."""
    paths = ("[-9 mm, 0], [9 mm, 0]", "[-9 mm, 0], [9 mm, 0], [12 mm, 4 mm]")
    scenes = [make_scene(case("compression30", "8 %", f"cracks.flaw.path={{points: [{path}]}}")) for path in paths]
    assert [scene.halvings.cracks for scene in scenes] == [(0,), (1,)]


@pytest.mark.parametrize(
    ("path", "tells"),
    [("[-4 mm, 0], [2 mm, 0], [4 mm, 4 mm]", [True, True, False]), ("[-4 mm, 0], [4 mm, 0]", [True, False])],
)
def test_cells_to_compare_serve_smaller_cells_while_those_at_kinks_are_a_quarter(path: str, tells: list[bool]) -> None:
    """Without kinks they are twice as large, or nothing is told by them; nor is it under another load."""
    aim = case(
        "compression30", "3 %", f"cracks.flaw.path={{points: [{path}]}}", "loading={history: [1]}", "growth.steps=0"
    )
    scene, cracks = make_scene(aim), beginning(aim).cracks
    solutions = [
        load(replace(scene, halvings=replace(scene.halvings, cracks=(scene.halvings.cracks[0] + n,))), cracks)
        for n in range(len(tells))
    ]
    other, _ = NextStep(cracks, None).state(compared(solutions[0]), 1.0, None)
    assert [still_tells(solution, other) for solution in solutions] == tells
    assert not still_tells(solutions[0], replace(other, level=other.level._replace(factor=2.0)))


def test_what_is_known_of_a_step_serves_the_next_ones() -> None:
    """Each step is within the target, and K of some of them is not measured anew on other cells."""
    steps = list(grow(case("compression30", "3 %", "growth.steps=5")))
    assert max(max(shares(step)) for step in steps) <= 0.03 + 1e-12
    assert sum(step.factorizations == 1 for step in steps) >= 1


@pytest.fixture(scope="module")
def aimed_at() -> tuple[StepSolution, Accuracy]:
    """A step for 3 %, with what is known of it 3 mm of growth after it was measured."""
    _, solution = next(solved_steps(case("compression30", "3 %", "growth.steps=0")))
    assert solution.accuracy is not None
    return solution, replace(solution.accuracy, grown=(3.0e-3,))


def test_what_is_known_holds_as_it_was_at_twice_the_length_whatever_round_off_makes_of_it(
    aimed_at: tuple[StepSolution, Accuracy],
) -> None:
    """Increments are alike, so that cracks have grown by twice as much just so, but for the sum of lengths."""
    solution, last = aimed_at
    for times in (1.0, 2.0 - 1e-14, 2.0, 2.0 + 1e-14):
        since = Since(last, solution, (times * 3.0e-3,))
        assert since.holds
        assert since.carried_over.bounds == last.bounds


def test_bounds_are_widened_from_there_on_up_to_the_target(aimed_at: tuple[StepSolution, Accuracy]) -> None:
    """As what was added is longer; the steps between make nothing of it, nor does what is most likely change."""
    solution, last = aimed_at
    known = last
    for times in (3.0, 4.0, 5.0):
        since = Since(known, solution, (times * 3.0e-3,))
        assert since.holds
        known = since.carried_over
        assert known.bounds == pytest.approx([0.5 * times * bound for bound in last.bounds], rel=1e-12)
        assert known.expected == last.expected
    most = 2.0 * 0.03 / max(last.shares())
    assert [Since(last, solution, (times * most * 3.0e-3,)).holds for times in (0.999, 1.001)] == [True, False]


def test_what_the_criterion_says_otherwise_is_kept_while_bounds_are_widened(
    aimed_at: tuple[StepSolution, Accuracy],
) -> None:
    solution, last = aimed_at
    last = replace(last, turns=(0.01, 0.02), criticalities=(0.001, 0.002))
    known = Since(last, solution, (9.0e-3,)).carried_over
    assert known.widened == pytest.approx((1.5, 1.5))
    assert (known.turns, known.criticalities) == (last.turns, last.criticalities)


def test_bounds_are_widened_by_what_the_fitted_one_says_more(aimed_at: tuple[StepSolution, Accuracy]) -> None:
    solution, last = aimed_at
    known = Since(replace(last, fitted=last.fitted / 3.0), solution, (3.0e-3,)).carried_over
    assert known.bounds == pytest.approx([1.5 * bound for bound in last.bounds], rel=1e-9)


def test_joined_cells_widen_bounds_by_eight_and_smaller_ones_are_not_known(
    aimed_at: tuple[StepSolution, Accuracy],
) -> None:
    """Those of the crack are as large as those that K was held against, but at kinks."""
    solution, last = aimed_at
    last = replace(last, bounds=tuple(0.1 * bound for bound in last.bounds))
    (times,) = last.halvings.cracks
    finer, coarser = (replace(last, halvings=replace(last.halvings, cracks=(n,))) for n in (times + 1, times - 1))
    since = Since(finer, solution, (3.0e-3,))
    assert since.holds
    known = since.carried_over
    assert (known.halvings, known.coarser) == (solution.scene.halvings, (1,))
    assert known.bounds == pytest.approx([8.0 * bound for bound in last.bounds], rel=1e-12)
    assert known.expected == pytest.approx([4.0 * error for error in last.expected], rel=1e-12)
    again = Since(known, solution, (3.0e-3,)).carried_over
    assert (again.coarser, again.bounds, again.expected) == ((1,), known.bounds, known.expected)
    assert not Since(coarser, solution, (3.0e-3,)).holds
    elsewhere = replace(last.halvings, everywhere=last.halvings.everywhere + 1)
    assert not Since(replace(last, halvings=elsewhere), solution, (3.0e-3,)).holds


def test_cells_that_are_joined_at_several_cracks_count_where_they_are_most_often() -> None:
    widened = []
    _, solution = next(solved_steps(case("two_flaws", "3 %", "growth.steps=0")))
    last = solution.accuracy
    assert last is not None
    for more in ((1, 0), (1, 1), (2, 0)):
        cracks = tuple(n + times for n, times in zip(solution.scene.halvings.cracks, more, strict=True))
        finer = replace(last, halvings=replace(solution.scene.halvings, cracks=cracks))
        widened.append(Since(finer, solution, last.grown).carried_over.widened)
    assert widened == [pytest.approx((times,) * 4) for times in (8.0, 8.0, 64.0)]


def test_nothing_is_known_on_once_a_crack_has_started_without_a_tip(aimed_at: tuple[StepSolution, Accuracy]) -> None:
    """It has run into a hole at once: tips are the same, but not what is near them."""
    solution, last = aimed_at
    assert Since(last, solution, (3.0e-3,)).holds
    assert not Since(replace(last, halvings=replace(last.halvings, cracks=())), solution, (3.0e-3,)).holds


def test_what_is_nearest_is_remembered_where_K_is_not_known(aimed_at: tuple[StepSolution, Accuracy]) -> None:
    """Of another goal nothing is expected of K: still a tip that comes near something has it measured anew."""
    solution, last = aimed_at
    unknown = replace(last, expected=(math.nan, math.nan))
    again = Since(unknown, solution, (3.0e-3,)).carried_over
    assert again.rooms == last.rooms
    assert not all(Since(replace(again, rooms=(1.6 * last.rooms[0], math.nan)), solution, (3.0e-3,)).still_known)


def test_what_was_known_of_a_crack_without_growth_does_not_hold_once_it_has_grown(
    aimed_at: tuple[StepSolution, Accuracy],
) -> None:
    """However small the fitted bound is: that is not measured."""
    solution, last = aimed_at
    assert not Since(replace(last, grown=(0.0,)), solution, (1.0e-6,)).holds
    assert Since(replace(last, grown=(0.0,)), solution, (0.0,)).holds


def test_a_run_goes_on_from_widened_bounds_to_the_same_bits() -> None:
    """K is measured at the first step of growth: at the third one it has grown by three times as much."""
    wings = case("compression30", "1 %", "growth.steps=4")
    steps = list(solved_steps(wings))
    result, solution = steps[3]
    assert solution.accuracy is not None
    assert solution.accuracy.widened == pytest.approx((1.5, 1.5))
    again = list(grow(wings, result.checkpoint))
    assert [tip_numbers(step) for step in again] == [tip_numbers(step) for step, _ in steps[3:]]


def test_a_run_goes_on_from_joined_cells_to_the_same_bits() -> None:
    """Wings of all flaws are long enough for larger cells at the second step."""
    wings = case("en_echelon", "1 %", "growth.steps=3")
    steps = list(solved_steps(wings))
    known = [solution.accuracy for _, solution in steps]
    assert known[2] is not None
    assert known[2].coarser == (1, 1, 1)
    assert min(known[2].widened) >= 8.0
    for number in (1, 2):
        again = list(grow(wings, steps[number][0].checkpoint))
        assert [tip_numbers(step) for step in again] == [tip_numbers(step) for step, _ in steps[number:]]


def tip_numbers(step: StepResult) -> list[tuple[float, ...]]:
    """K of the tips, and what is stated of it."""
    return [(tip.K_I, tip.K_II, tip.K_I_error, tip.K_error_expected, tip.kink_error_deg) for tip in step.tips]


def test_the_bound_of_another_goal_is_not_widened(aimed_at: tuple[StepSolution, Accuracy]) -> None:
    """Neither where there was no solution on the other cells: what the fit says of K tells nothing of it."""
    solution, last = aimed_at
    numerics = replace(solution.scene.case.numerics, goal="slip")
    scene = replace(solution.scene, case=replace(solution.scene.case, numerics=numerics))
    configuration = replace(solution.state.configuration, scene=scene)
    of_slip = replace(solution, state=replace(solution.state, configuration=configuration))
    assert of_slip.scene.case.numerics.measured_of == "slip"
    for goal in (1e-3, math.nan):
        known = replace(last, goal=goal)
        assert [Since(known, of_slip, (times * 3.0e-3,)).holds for times in (2.0, 2.01)] == [True, False]


@pytest.mark.parametrize(
    "settings",
    [
        ("growth.steps=2",),
        ("growth.steps=2", "growth.unload_between_steps=false", "cracks.flaw.contact.friction=0.3"),
        SHEARED,
    ],
)
def test_a_run_that_was_broken_off_goes_on_to_the_same_bits(settings: tuple[str, ...]) -> None:
    aim = case("compression30", "3 %", *settings)
    whole = list(grow(aim))
    kept = whole[1].checkpoint
    assert kept is not None
    again = Checkpoint(kept.step, json.loads(json.dumps(kept.values)), kept.arrays)
    rest = list(grow(aim, again))
    columns = ("K_I", "K_II", "K_I_error", "K_II_error", "cell_size")
    assert [[getattr(tip, name) for tip in step.tips for name in columns] for step in rest] == [
        [getattr(tip, name) for tip in step.tips for name in columns] for step in whole[1:]
    ]
    assert [step.factorizations for step in rest] == [step.factorizations for step in whole[1:]]


def true_error(aim: Case, step: StepResult, solution: StepSolution) -> float:
    """Of K, over the largest: against cells of a quarter of the size at all tips."""
    assert step.checkpoint is not None
    scene, cracks = solution.scene, restored(aim, step.checkpoint).cracks
    halvings = replace(scene.halvings, cracks=tuple(n + 2 for n in scene.halvings.cracks))
    finer = np.array([tip.K for tip in load(scene.with_halvings(halvings), cracks).tips])
    off = finer - [(tip.K_I, tip.K_II) for tip in step.tips]
    return float(np.hypot(*off.T).max() / np.hypot(*finer.T).max())


def test_cracks_that_start_meet_the_target() -> None:
    """Their cells are small by their own length, and K of all tips is held against other cells when they start."""
    aim = case("compression30", "3 %", *SHEARED)
    steps = list(solved_steps(aim))
    step, solution = steps[-1]
    assert [event.kind for event in step.events] == ["initiation", "initiation"]
    assert len(step.tips) == 4
    assert step.factorizations > 1
    assert told(step) == []
    assert max(max(shares(each)) for each, _ in steps) <= 0.03
    assert true_error(aim, step, solution) <= 0.03


def test_where_nothing_has_started_yet_K_is_told_to_be_missing(tmp_path: Path) -> None:
    """The first crack then meets the target."""
    settings = ("numerics.accuracy=3 %", "numerics.spacing=auto", "growth.steps=1")
    aim = plate(tmp_path, SQUARE, "anywhere", *settings)
    first, (step, solution) = solved_steps(aim)
    (words,) = told(first[0])
    assert words.endswith("no crack has a tip yet")
    assert told(step) == []
    assert max(shares(step)) <= 0.03
    assert true_error(aim, step, solution) <= 0.03


def test_every_load_of_a_history_meets_the_target() -> None:
    steps = list(grow(case("cyclic_friction", "3 %", "loading.history=[0.5, 1.0, 0.8]")))
    assert len(steps) == 3
    for step in steps:
        assert max(shares(step)) <= 0.03 or told(step)


def test_cells_that_a_later_load_makes_smaller_are_paid_for_there() -> None:
    """The loads before are gone through again on them; the next load finds all of it made."""
    aim = case("cyclic_friction", "3 %", "loading.history=[0.5, 1.0, 1.1]")
    scene = make_scene(aim)
    given = beginning(aim).cracks
    loads = LoadsInTurn(scene, given)
    state, _, (seconds, factorizations) = loads.state(1)
    assert seconds["contact"] > state.seconds
    assert (seconds["assembly"] > 0.0, factorizations) == (True, 1)
    again = LoadsInTurn(scene, given)
    second, third = again.solution(1), again.solution(2)
    assert [second.factorizations, third.factorizations] == [1, 0]
    assert [solution.seconds["assembly"] > 0.0 for solution in (second, third)] == [True, False]
    assert second.seconds["contact"] > second.state.seconds


def test_faces_that_stick_leave_no_K_to_aim_at() -> None:
    step = next(grow(case("compression30", "1 %", "cracks.flaw.contact.friction=2")))
    (words,) = told(step)
    assert "stick" in words
    assert step.n_dofs < 10_000


def test_tips_without_room_for_an_integral_leave_no_K_to_aim_at() -> None:
    """Though the faces tell of some K: no bound is known of it."""
    scene = make_scene(case("compression30", "1 %"))
    cracks = beginning(scene.case).cracks
    solution = load(scene, cracks)
    nan = float("nan")
    nothing = StressIntensity(nan, nan, nan, nan, nan, True, "no room")
    crowded = replace(solution, tips=tuple(replace(tip, intensity=nothing) for tip in solution.tips))

    def unsolved(*_: object) -> NoReturn:
        raise SolveError("none")

    found = aimed(crowded, SimpleNamespace(solve=unsolved, state=unsolved), None)
    assert found.accuracy is not None
    assert found.accuracy.missed == "K is not known at any tip"


def test_a_target_that_takes_too_many_unknowns_ends_with_what_was_reached(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(target_file, "MOST_UNKNOWNS", 100)
    step = next(grow(case("compression30", "0.1 %")))
    (words,) = told(step)
    assert "within 0.1 %" in words
    assert "at most 100 " in words
    assert f"is within {100.0 * max(shares(step)):.2g} %" in words


def test_loads_go_on_with_their_cells_where_smaller_ones_have_no_solution(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the first load; contact of the others is that of the history on those cells."""
    first = Halvings(1, (0,))
    monkeypatch.setattr(scene_file, "first_halvings", lambda *_: first)

    def only_on_the_first(scene: Scene, *rest: Any, **more: Any) -> LoadsInTurn:
        if scene.halvings.cracks != first.cracks:
            raise SolveError("not solved")
        return LoadsInTurn(scene, *rest, **more)

    monkeypatch.setattr(aimed_history_file, "LoadsInTurn", only_on_the_first)
    steps = list(grow(case("cyclic_friction", "0.1 %", "loading.history=[0.5, 1.0]")))
    assert [step.load_factor for step in steps] == [0.5, 1.0]
    for step in steps:
        (words,) = told(step)
        assert "smaller cells are not to be had: not solved" in words


def test_a_target_that_cells_halved_to_the_least_miss_ends_and_says_so() -> None:
    points = "[[-0.1 mm, 0], [0.1 mm, 0], [0.12 mm, 0.08 mm]]"
    step = next(grow(case("compression30", "0.1 %", "numerics.spacing=15", f"cracks.flaw.path={{points: {points}}}")))
    (words,) = told(step)
    assert f"{MOST_LEVELS} times" in words


def test_what_is_known_comes_back_from_plain_data() -> None:
    known = Accuracy(
        Halvings(1, (3, 0), 2, 1), ((0, False), (1, True)), (2.5, math.nan), 7.0, (0.1, 0.0), 0.2, "why",
        expected=(1.5, math.nan), rooms=(0.25, math.nan), age=3, widened=(1.7, 1.0), coarser=(2, 0),
    )  # fmt: skip
    again = accuracy_of_record(json.loads(json.dumps(record_of(known))))
    assert (again.halvings, again.ends, again.largest) == (known.halvings, known.ends, known.largest)
    assert (again.grown, again.fitted, again.missed, again.bounds[0]) == (known.grown, 0.2, "why", 2.5)
    assert (again.expected[0], again.rooms[0], again.age) == (1.5, 0.25, 3)
    assert (again.widened, again.coarser) == ((1.7, 1.0), (2, 0))
    assert math.isnan(again.bounds[1])
    assert math.isnan(again.expected[1])
    assert (again.shares(), again.shares(1)) == ([2.5 / 7.0], [])


def test_cells_are_joined_where_K_is_far_better_than_asked_for() -> None:
    scene = make_scene(case("compression30", "1 %"))
    known = Accuracy(scene.halvings, ((0, False), (0, True)), (1e-4, 2e-4), 1.0)
    (step, solution) = next(solved_steps(scene.case))
    assert step.n_dofs > 0
    assert cells_after(replace(solution, accuracy=known)).cracks == (scene.halvings.cracks[0] - 1,)
    near = replace(known, bounds=(8e-3, 1e-4))
    assert cells_after(replace(solution, accuracy=near)) == scene.halvings
