"""The growth loop: what runs yield and return; one that goes on from a checkpoint is the whole run."""

from __future__ import annotations

import json
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest
import yaml

import crackgrow.run.loop as loop
from crackgrow.case.load import read_case
from crackgrow.case.model import Case
from crackgrow.errors import CrackgrowError, GeometryError, SolveError
from crackgrow.run.loop import grow
from crackgrow.run.result import Checkpoint
from tests.scenes import CYCLES, SHORTER, crack_at_bond, shipped_case, slow_cracks, specimen
from tests.solving import whole_run

MM = 1e-3


def straight(center: tuple[float, float], length: float, angle: float, **more: Any) -> dict[str, Any]:
    path = {"center": list(center), "length": length, "angle": angle}
    return {"path": path, "contact": {"friction": 0.2, "cohesion": 0.0}, **more}


def plate(cracks: dict[str, Any], *overrides: str, growth: dict[str, Any]) -> Case:
    """A plate of 31 x 55 mm pulled along y."""
    standard = {"steps": 2, "increment": 2, "advance": "most_critical", "criterion": "strength"}
    growth = standard | {"tip_stress": {"radius": 1}} | growth
    document = specimen(cracks, numerics={"spacing": 1.5}, growth=growth)
    return read_case(yaml.safe_dump(document), "plate", "plate", overrides)


CENTRE = {"flaw": straight((0.0, 0.0), 10.0, 0.0)}
NEAR = {"flaw": straight((9.0, 0.0), 10.0, 0.0)}
"""Its end is 1.5 mm from the right side."""


def test_a_run_yields_every_step_and_returns_why_it_ended() -> None:
    results, end = whole_run(plate(CENTRE, growth={"steps": 2}))
    assert [(result.step, len(result.cracks[0].points)) for result in results] == [(0, 2), (1, 3), (2, 4)]
    assert end.status == "completed"
    assert "2 growth steps" in end.reason
    np.testing.assert_array_equal(end.cracks[0].points, results[-1].cracks[0].points)  # none advances after the last
    alone, end = whole_run(plate({}, growth={}))
    assert len(alone) == 1
    assert end.status == "arrested"
    assert "no tip" in end.reason


@pytest.mark.parametrize("steps", [0, 2])
def test_a_run_whose_cracks_stay_says_how_near_to_growth_they_are(steps: int) -> None:
    settings = ["numerics.spacing=3", f"growth.steps={steps}", "loading.history=[1e-3]"]
    (result,), end = whole_run(shipped_case("compression30", settings))
    nearest = max(tip.criticality for tip in result.tips)
    assert 0.0 < nearest < 1.0
    assert end.reason.endswith(f"; the most critical is at {nearest:.3g} of the strength at load factor 0.001")
    assert end.reason.startswith("nothing grew: no tip meets the criterion" if steps else "the static solve is done")


def test_a_crack_that_reaches_the_outline_goes_on_at_its_other_tip() -> None:
    results, end = whole_run(plate(NEAR, growth={"steps": 3}))
    assert end.status == "completed"
    (event,) = results[1].events
    assert [len(result.events) for result in results] == [0, 1, 0, 0]
    assert (event.step, event.kind, event.crack, event.tip) == (1, "break_through", "flaw", "end")
    assert event.met == "the outline of body 'rock'"
    np.testing.assert_array_equal(event.point, results[1].cracks[0].points[-1])
    assert event.point[0] == pytest.approx(15.5 * MM)
    assert [[tip.tip for tip in result.tips] for result in results] == [["start", "end"]] + 3 * [["start"]]
    assert end.cracks[0].steps.tolist() == [3, 2, 0, 0, 1]
    lengths = [result.crack_length for result in results]
    np.testing.assert_allclose(np.diff(lengths), [1.5 * MM, 2 * MM, 2 * MM], rtol=1e-2)


def test_a_hole_and_an_interface_are_met_by_their_names() -> None:
    holes = "bodies.rock.shape.holes=[{rectangle: {center: [9, 0], width: 6, height: 6}}]"  # from x = 6
    results, end = whole_run(plate(CENTRE, holes, growth={"steps": 1, "advance": "all"}))
    assert end.status == "completed"
    (event,) = results[1].events
    assert (event.kind, event.tip, event.met) == ("hole", "end", "hole0 of body 'rock'")
    assert event.point[0] == pytest.approx(6 * MM)
    shape = "{rectangle: {center: [9, 0], width: 6, height: 6}}"
    inset = f"bodies.plug={{shape: {shape}, material: {{young: 10000, poisson: 0.25}}}}"
    between = "interfaces=[{between: [plug, rock], contact: bonded}]"
    results, _ = whole_run(plate(CENTRE, holes, inset, between, growth={"steps": 1, "advance": "all"}))
    (event,) = results[1].events
    assert (event.kind, event.tip) == ("interface", "end")
    names = [f"interface '{face.crack}'" for face in results[1].faces]
    assert event.met in names  # one of the lines of plug/rock
    stub = {"stub": {"path": {"points": [[6, 0], [8, 2]]}, "tips": "none", "contact": "none"}}  # of the plug
    results, _ = whole_run(plate(CENTRE | stub, holes, inset, between, growth={"steps": 1, "advance": "all"}))
    (event,) = results[1].events
    assert (event.kind, event.tip) == ("coalescence", "end")
    assert event.met in [f"crack 'stub' on {name}" for name in names]


ACROSS = {"flaw": straight((0.0, 0.0), 27.0, 0.0)}
"""2 mm short of either side."""


def test_a_piece_that_comes_loose_ends_the_run() -> None:
    results, end = whole_run(plate(ACROSS, growth={"steps": 5, "increment": 3, "advance": "all"}))
    assert [result.step for result in results] == [0]
    assert end.status == "broke_through"
    assert end.reason.startswith("step 1: the piece of body 'rock' round (")
    assert " mm) is free to move: contact does not hold it, it moves off 'flaw'" in end.reason
    assert [(event.step, event.tip) for event in end.events] == [(1, "start"), (1, "end")]
    np.testing.assert_allclose(np.abs(end.cracks[0].points[[0, -1], 0]), 15.5 * MM, rtol=1e-12)


def test_rock_in_pieces_that_supports_hold_has_broken_through_when_no_tip_is_left() -> None:
    held = (
        "supports=[{on: {body: rock, edge: bottom}, displacement: {x: 0, y: 0}}, "
        "{on: {body: rock, edge: top}, displacement: {x: 0, y: 0.01}}]"
    )
    results, end = whole_run(plate(ACROSS, held, growth={"steps": 5, "increment": 3, "advance": "all"}))
    assert [len(result.events) for result in results] == [0, 2]
    assert results[-1].tips == ()
    assert (end.status, end.events) == ("broke_through", ())
    _, sooner = whole_run(plate(ACROSS, held, growth={"steps": 1, "increment": 3, "advance": "all"}))
    assert (sooner.status, sooner.reason) == (end.status, end.reason)  # the last step is judged alike
    assert "no tip is left" in end.reason
    assert "2 pieces, 1 at the start" in end.reason


@pytest.mark.parametrize("error", [SolveError("ill conditioned"), GeometryError("two tips in one place")])
def test_a_later_step_that_fails_ends_the_run_with_its_geometry_and_the_first_is_an_error(
    monkeypatch: pytest.MonkeyPatch, error: CrackgrowError
) -> None:
    case, true, outcomes = plate(NEAR, growth={"steps": 5}), loop.load, [None, error, error]

    def solve(*arguments: Any, **named: Any) -> Any:
        if failure := outcomes.pop(0):
            raise failure
        return true(*arguments, **named)

    monkeypatch.setattr(loop, "load", solve)
    (result,), end = whole_run(case)
    assert result.step == 0
    assert (end.status, end.reason) == ("failed", f"step 1: {error}")
    assert [(event.step, event.kind) for event in end.events] == [(1, "break_through")]
    assert end.cracks[0].points[-1, 0] == pytest.approx(15.5 * MM)
    with pytest.raises(type(error), match=str(error)):
        next(grow(case))


@pytest.mark.parametrize("tips", ["end", "both"])
def test_a_tip_that_has_met_a_crack_stays_and_the_other_goes_on(tips: str) -> None:
    """Where every tip has met something the run is arrested: the rock is still in one piece."""
    cracks = {"a": straight((-4.0, 0.0), 8.0, 0.0, tips=tips), "b": straight((1.5, 0.0), 8.0, 90.0, tips="none")}
    results, end = whole_run(plate(cracks, growth={"steps": 2, "advance": "all"}))
    (event,) = results[1].events
    assert (event.kind, event.crack, event.tip, event.met) == ("coalescence", "a", "end", "crack 'b'")
    assert event.point[0] == pytest.approx(1.5 * MM)
    if tips == "end":
        assert (end.status, end.reason) == ("arrested", "step 1: no tip is left that could grow")
    else:
        assert (end.status, [len(result.events) for result in results]) == ("completed", [0, 1, 0])
        assert [(tip.crack, tip.tip) for tip in results[1].tips if tip.advanced] == [("a", "start")]


def test_a_history_is_gone_through_on_one_factorization() -> None:
    """Without growth; it slips back only below a factor of 1/3."""
    case = shipped_case("cyclic_friction", ["numerics.spacing=4", "loading.history=[0.5, 1.0, 0.2]"])
    results, end = whole_run(case)
    assert [result.load_factor for result in results] == [0.5, 1.0, 0.2]
    assert [result.factorizations for result in results] == [1, 0, 0]
    assert [result.seconds["assembly"] > 0.0 for result in results] == [True, False, False]
    assert (end.status, end.reason) == ("completed", "all 3 load factors are done")
    slip = [result.contact.slip for result in results]
    np.testing.assert_allclose(slip[2], 0.8 * slip[1], rtol=1e-3)


def test_with_growth_every_step_goes_through_the_history_to_its_last_factor() -> None:
    """Loaded to 2 and back to 1 the stuck crack holds more slip than one that is loaded to 1."""
    settings = ("numerics.spacing=3", "growth.tip_stress.radius=2", "cracks.flaw.contact.friction=0.3")
    results, _ = whole_run(shipped_case("compression30", [*settings, "growth.steps=1", "loading.history=[2, 1]"]))
    assert [result.load_factor for result in results] == [1.0, 1.0]
    direct = next(grow(shipped_case("compression30", [*settings, "loading.history=[1]"])))
    for result in results:
        assert np.abs(result.contact.slip).max() > 1.2 * np.abs(direct.contact.slip).max()


COARSE = ("numerics.spacing=3", "output.frames=none", "output.figures=false")
FRICTION = "cracks.flaw.contact.friction=0.3"
IMPLICIT = "growth.direction=implicit"
LOADED = "growth.unload_between_steps=false"
AIM = ("numerics.accuracy=3 %", "numerics.spacing=auto", "growth.steps=2", FRICTION)
FACING = "cracks={a: {path: [[-11, 0], [-3, 0]], contact: none}, b: {path: [[0, 0], [8, 0]], contact: none}}"
POINTS = "output.points={mouth: {crack: flaw, at: [0, 0]}}"
STARTS = ("growth.initiation.at=cracks", "bodies.rock.strength.cohesion=0.6", "growth.advance=all", LOADED)
CYCLE = "loading.history=[0.4, 1, 0.7, -0.3, -1, -0.8, 0.6]"
BLOCK = "loading.history=[0.3, 1.0, 0.1, 0.5]"
ALONG = "growth={steps: 3, increment: 5, criterion: max_hoop_stress, unload_between_steps: false}"
SCENES = {
    "unloaded between steps": ("compression30", "growth.steps=3", FRICTION),
    "history in every step": ("compression30", "growth.steps=2", FRICTION, "loading.history=[0.5, -0.2, 1.0]"),
    "implicit direction": ("compression30", "growth.steps=2", "growth.criterion=max_hoop_stress", IMPLICIT),
    "cracks that start": ("compression30", "growth.steps=3", FRICTION, *STARTS),
    "a target, loaded throughout": ("compression30", *AIM, LOADED, POINTS),
    "critical load": ("flaw_and_hole", "growth.steps=3"),
    "all tips, meeting": ("tension0", FACING, "growth.steps=3", "growth.advance=all"),
    "cyclic friction": ("cyclic_friction", "numerics.spacing=10", CYCLE),
    "subcritical, a tip that waits": ("slow_cracks", SHORTER),
    "cycles": ("slow_cracks", SHORTER, *CYCLES),
    "block on a foundation": ("block_rigid", "numerics.spacing=0.5", BLOCK),
    "stages": ("tunnel_excavated", "numerics.spacing=2", "output.points={}"),
    "interface that parts": ("17_interface", "loading={history: [1]}", "interfaces.0.toughness=1", ALONG),
    "cracks that cross a bond": ("crack_at_bond", "interfaces.0.toughness=14"),
    "cracks that turn along a bond": ("crack_at_bond", "loading={history: [4]}", LOADED),
    "interface": ("interface_friction04", "numerics.spacing=0.2", BLOCK),
}


def scene(name: str) -> Case:
    file, *settings = SCENES[name]
    if file in ("slow_cracks", "crack_at_bond"):
        return {"slow_cracks": slow_cracks, "crack_at_bond": crack_at_bond}[file](*settings)
    coarse = COARSE[1:] if any("spacing" in setting for setting in settings) else COARSE
    return shipped_case(file, [*coarse, *settings])


def stored(checkpoint: Checkpoint | None) -> Checkpoint:
    """The checkpoint as it comes back from files."""
    assert checkpoint is not None
    arrays = {name: array.copy() for name, array in checkpoint.arrays.items()}
    return Checkpoint(checkpoint.step, json.loads(json.dumps(checkpoint.values)), arrays)


def assert_same(one: Any, other: Any, where: str) -> None:
    """Everything but times is equal, floats bit by bit."""
    if where.endswith(".seconds"):
        return
    if is_dataclass(one):
        for part in fields(one):
            assert_same(getattr(one, part.name), getattr(other, part.name), f"{where}.{part.name}")
    elif isinstance(one, tuple | list):
        assert len(one) == len(other), where
        for number, (a, b) in enumerate(zip(one, other, strict=True)):
            assert_same(a, b, f"{where}[{number}]")
    elif isinstance(one, dict):
        assert list(one) == list(other), where
        for key, value in one.items():
            assert_same(value, other[key], f"{where}[{key}]")
    else:
        np.testing.assert_array_equal(one, other, err_msg=where)


@pytest.mark.parametrize("name", SCENES)
def test_steps_can_be_gone_on_from(name: str) -> None:
    case = scene(name)
    results, end = whole_run(case)
    assert len(results) > 2
    again, same_end = whole_run(case, stored(results[-2].checkpoint))
    assert_same(results[-2:], again, name)
    assert_same(end, same_end, f"{name}, end")
