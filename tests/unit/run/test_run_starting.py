"""Cracks that start in a run, with which law; a crack at a bond stops, turns or crosses by what it takes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from crackgrow.case.model import Case
from crackgrow.fracture.criteria import TipLoading
from crackgrow.fracture.sites import LARGEST_KINK, Site
from crackgrow.fracture.tip_stress import TipField
from crackgrow.run.checkpoint import restored
from crackgrow.run.evaluation import verdicts
from crackgrow.run.scene import make_scene
from tests.scenes import ROCK_TOUGHNESS, STARTS, crack_at_bond, shipped_case, specimen
from tests.solving import whole_run

SECOND = (*STARTS, "growth.steps=3", "numerics.spacing=3", "growth.initiation.at=cracks")


def plate(at: str, criterion: str, spacing: float, apart: float, **shape: Any) -> Case:
    """A square plate without cracks, pulled by 1 MPa, of a tensile strength of 5 MPa."""
    initiation = {"at": at, "spacing": apart}
    growth = {"steps": 1, "increment": 2, "criterion": criterion, "tip_stress": {"radius": 1}, "initiation": initiation}
    scene = specimen({}, (40.0, 40.0), growth=growth, loading="critical", numerics={"spacing": spacing})
    scene["bodies"]["rock"]["strength"] = {"tension": 5, "cohesion": 20, "friction_angle": 30}
    scene["bodies"]["rock"]["shape"] |= shape
    return Case.from_dict(scene)


@pytest.mark.parametrize(("criterion", "exact"), [("strength", 1e-9), ("directional_strength", 2e-5)])
def test_rock_under_uniform_tension_cracks_across_it_at_its_strength(criterion: str, exact: float) -> None:
    """Between rays 5 degrees apart the hoop stress is that of a parabola."""
    results, end = whole_run(plate("anywhere", criterion, 2, 5))
    assert results[0].load_factor == pytest.approx(5.0, rel=exact)
    assert [event.kind for event in results[1].events] == ["initiation"]
    (crack,) = end.cracks
    first, last = crack.points[[0, -1]]
    assert abs((last - first)[1]) < 1e-9 * np.hypot(*(last - first))
    assert np.hypot(*(last - first)) == pytest.approx(2e-3, rel=1e-12)


def test_a_hole_in_tension_cracks_where_its_rim_is_stretched_most() -> None:
    """Kirsch: the hoop stress ahead of the wall is S/2 (2 + a^2/r^2 + 3 a^4/r^4); its mean over R decides."""
    hole = {"disk": {"center": [0, 0], "radius": 1.5}}
    results, _ = whole_run(plate("outlines", "directional_strength", 1, 0.5, holes=[hole]))
    (event,) = results[1].events
    assert event.kind == "initiation"
    assert event.met == "hole0 of body 'rock' (tension)"
    assert abs(event.point[0]) == pytest.approx(1.5e-3, rel=2e-2)
    assert abs(event.point[1]) < 0.2e-3
    a, R = 1.5, 1.0
    b = a + R
    mean = (2.0 * R + a * a * (1 / a - 1 / b) + a**4 * (1 / a**3 - 1 / b**3)) / (2.0 * R)
    assert results[0].load_factor == pytest.approx(5.0 / mean, rel=2e-2)


def test_a_flaw_with_wings_starts_a_second_crack_in_shear() -> None:
    """It is broken from the start, with the friction of its parent; without the key tips alone grow."""
    case = shipped_case("compression30", [*SECOND, "cracks.flaw.contact.cohesion=0.01"])
    results, end = whole_run(case)
    started = [event for result in results for event in result.events if event.kind == "initiation"]
    assert started[0].met == "crack 'flaw' (shear)"
    assert np.hypot(*(results[0].cracks[0].points[[0, -1]] - started[0].point).T).min() < 1e-12
    assert {tip.criterion for tip in results[0].tips if tip.advanced} == {"tension"}  # wings come first
    assert {path.name for path in end.cracks} >= {"flaw", "new1"}
    assert results[-1].checkpoint is not None
    new = restored(case, results[-1].checkpoint).cracks[1]
    assert new.parent == 0
    assert new.crack.contact is not None
    assert (new.crack.contact.cohesion, new.crack.contact.friction) == (0.0, 0.3)
    _, end = whole_run(shipped_case("compression30", [key for key in SECOND if "initiation" not in key]))
    assert len(end.cracks) == 1


def test_ends_of_a_flaw_start_one_crack_each_and_equal_ones_together() -> None:
    """The flaw and its load are their own image turned by 180 degrees, and so is what starts."""
    case = shipped_case("compression30", [*SECOND, "growth.initiation=ends"])
    results, end = whole_run(case)
    started = [event for result in results for event in result.events if event.kind == "initiation"]
    assert len({event.step for event in started}) == 1
    ends = results[0].cracks[0].points
    assert sorted(tuple(event.point) for event in started) == sorted(map(tuple, ends.tolist()))
    one, other = (path.points for path in end.cracks if path.name.startswith("new"))
    centre = ends.mean(axis=0)
    np.testing.assert_allclose(one - centre, centre - other, atol=1e-3 * np.hypot(*(ends[1] - ends[0])))


def test_a_toughness_in_shear_is_for_tips_not_for_starts() -> None:
    """What starts goes by the strength; whether a crack that has started in shear goes on so, by the toughness."""
    settings = [*SECOND, "growth.criterion=directional_strength", "bodies.rock.strength.tension=0.7"]
    started, in_shear = [], []
    for key in ((), ("bodies.rock.strength.shear_toughness=0.1 MPa sqrt(m)",)):
        every = [*settings, "growth.steps=4", "loading={history: [0.03]}", *key]
        results, _ = whole_run(shipped_case("compression30", every))
        events = [event for result in results for event in result.events if event.kind == "initiation"]
        started.append([(event.step, event.met, *event.point) for event in events])
        grown = [tip for result in results for tip in result.tips if tip.advanced]
        in_shear.append({tip.crack for tip in grown if tip.criterion == "shear"})
    assert started[0] == started[1]
    assert {met for _, met, *_ in started[0]} == {"crack 'flaw' (shear)"}
    assert in_shear == [{"new1", "new2"}, set()]


@pytest.mark.parametrize(
    ("in_shear", "K_I", "shear", "mode"),
    [
        (False, 0.0, 1.2, "tension"),
        (True, 0.0, 0.8, "shear"),
        (True, 5e6, 0.8, "tension"),  # of the two the more critical one, as long as shear is not met
        (True, 5e6, 1.2, "shear"),
    ],
)
def test_a_crack_that_has_started_in_shear_goes_on_so(in_shear: bool, K_I: float, shear: float, mode: str) -> None:
    """On rays under the hydrostatic pressure p and a shear of the rays' own, over cohesion + p tan(phi)."""
    scene = make_scene(shipped_case("compression30", ["growth.criterion=max_hoop_stress"]))
    strength, angles = scene.case.bodies[0].strength, np.deg2rad(np.linspace(-177.5, 177.5, 72))
    assert strength is not None
    pressure = 1e6
    bound = strength.cohesion + pressure * np.tan(np.deg2rad(strength.friction_angle))
    tau = shear * bound * np.cos(0.5 * angles)  # largest straight ahead
    rays = np.stack([-pressure - tau * np.sin(2 * angles), -pressure + tau * np.sin(2 * angles)], axis=1)
    rays = np.column_stack([rays, tau * np.cos(2 * angles)])
    field = TipField(0.0, angles, rays, rays.mean(axis=0))
    site = Site("tip", np.zeros(2), 0.0, LARGEST_KINK, 0, 0, in_shear)
    (found,) = verdicts(scene, [site], [TipLoading(field, K_I, 0.0, 1e-3)])
    by_K = K_I / (strength.tension * np.sqrt(2.0 * np.pi * 1e-3))
    assert found.mode == mode
    if in_shear:
        assert found.criticality == pytest.approx(max(shear, by_K), rel=1e-3)


LOADED = "loading={history: [3.8]}"  # G straight on is 0.957 of the toughness of the rock
NO_STRENGTH = "bodies.right={shape: {polygon: [[0, -200], [200, -200], [200, 200], [0, 200]]}, material: " + (
    "{young: 20 GPa, poisson: 0.25}}"
)


def toughness(share: float) -> str:
    """That of the bond, as a share of the rock's."""
    return f"interfaces.0.toughness={share * ROCK_TOUGHNESS}"


def test_it_stops_below_both_toughnesses() -> None:
    results, end = whole_run(crack_at_bond(LOADED, toughness(0.28)))
    assert (len(results), end.status, [event.kind for event in end.events]) == (1, "arrested", ["stop"])
    assert "stops at interface 'left/right' (G/G_c of 0.9" in end.events[0].words


def test_it_turns_to_both_sides_where_they_are_equal_and_goes_on_along_the_bond() -> None:
    results, end = whole_run(crack_at_bond(LOADED, toughness(0.24)))
    assert end.status == "completed"
    (event,) = results[1].events
    assert "crack 'flaw' (end) turns along interface 'left/right'" in event.words
    assert [tip.advanced for tip in results[1].interface_tips] == [True, True]
    for step, result in enumerate(results[1:], 1):
        found = sorted(float(tip.point[1]) for tip in result.interface_tips)
        np.testing.assert_allclose(found, [-1e-3 * step, 1e-3 * step], atol=1e-9)
        first, second = (tip.G for tip in result.interface_tips)
        assert first == pytest.approx(second, rel=1e-4)


def test_it_does_not_cross_into_rock_whose_strength_is_not_known() -> None:
    """At the load at which it turns, however large that is."""
    results, _ = whole_run(crack_at_bond(NO_STRENGTH, toughness(1.0), "growth.steps=1"))
    (event,) = results[1].events
    assert event.kind == "deflection"
    assert "unknown straight on" in event.met
    assert max(tip.criticality for tip in results[1].interface_tips) == pytest.approx(1.0)


def test_under_a_pressure_that_is_held_the_load_at_which_it_goes_on_rises_by_that() -> None:
    """By superposition: pressure and loads are the same but for their sign. The crack is closed at first."""
    factors, closed = list[float](), "cracks.flaw.contact={friction: 0, cohesion: 0}"
    for held in (0.0, 2.0, 5.0):
        loads = f"loads=[{{far_field: [1, 1, 0]}}, {{far_field: [{-held}, {-held}, 0], held: true}}]"
        case = crack_at_bond(NO_STRENGTH, toughness(0.3), "growth.steps=1", "numerics.accuracy=draft", closed, loads)
        factors.append(whole_run(case)[0][0].load_factor)
    np.testing.assert_allclose(np.subtract(factors, factors[0]), [0.0, 2.0, 5.0], atol=5e-3 * factors[0])


def test_it_goes_on_in_the_other_body_as_its_crack() -> None:
    results, _ = whole_run(crack_at_bond(toughness(0.4)))
    assert [event.kind for event in results[1].events] == ["crossing"]
    new = results[-1].cracks[-1]
    assert new.name == "new1"
    np.testing.assert_allclose(new.points, [[0, 0], [1e-3, 0], [2e-3, 0]], atol=1e-5)


def test_equal_cracks_go_on_together_and_the_step_is_that_of_their_load() -> None:
    """Every step has the load factor at which something just grows: G of what grows is that of the toughness."""
    two = {name: f"{{path: [[-30, {y}], [0, {y}]], contact: none, tips: none}}" for name, y in (("b", 7), ("a", -7))}
    both = f"cracks={{{', '.join(f'{name}: {crack}' for name, crack in two.items())}}}"
    case = crack_at_bond(both, toughness(0.1), "numerics.accuracy=draft", "growth.increment=2", "growth.steps=1")
    results, _ = whole_run(case)
    assert [(event.kind, event.crack) for event in results[1].events] == [("deflection", "a"), ("deflection", "b")]
    one, other, *debonds = results[1].cracks
    assert len(results[1].interface_tips) == 4
    for y, along in zip(sorted([-7e-3, 7e-3]), debonds, strict=True):
        np.testing.assert_allclose(np.abs(along.points - [0.0, y]).sum(axis=1).max(), 2e-3, rtol=1e-6)
        assert 1 in along.steps.tolist(), along
    G = np.sort([tip.G for tip in results[1].interface_tips if np.isfinite(tip.G)])
    np.testing.assert_allclose(G, 0.1 * ROCK_TOUGHNESS, rtol=1e-6)
    assert len(one.points) == len(other.points) == 2
    assert results[0].load_factor == pytest.approx(results[1].load_factor, rel=0.05)
