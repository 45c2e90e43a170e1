"""Stages: rock that is taken out, loads that change each by itself; exact solutions, invariance, and friction's memory.

A tunnel in rock under stress: wall stresses of Kirsch (1898). The body that is taken out has done on the rest what the
stress there did, and when all of that is released the rest is what it would be had the hole always been there.
"""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.accuracy.companion import BOUND
from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.loop import grow, solved_steps
from crackgrow.run.result import STICK, StepResult
from tests.scenes import shipped_case
from tests.solving import seen, whole_run
from tests.verification.solutions import case_of

TUNNEL = """
title: a tunnel, radius 2 m
plane: strain
units: {stress: MPa}
bodies:
  rock:
    shape: {rectangle: {center: [0, 0], width: WIDTH, height: WIDTH}, holes: [{disk: {center: [0, 0], radius: 2}}]}
    material: {young: 20000, poisson: 0.25}
  core: {shape: {disk: {center: [0, 0], radius: 2}}, material: {young: YOUNG, poisson: 0.25}}
interfaces: [{between: [rock, core], contact: CONTACT}]
CRACKS
supports: [{outline: rollers}]
loads:
  - {body: rock, stress: [-10, -20, 0]}
  - {body: core, stress: [-10, -20, 0]}
loading: LOADING
numerics: {spacing: SPACING}
"""
ONE_STAGE = "{stages: [{name: rest}, {name: open, excavate: core}]}"
TWO_HALVES = "{stages: [{}, {excavate: core, release: 0.5}, {release: 1}]}"


def tunnel(loading: str, *settings: str, **words: str) -> Case:
    """The tunnel with words of its text replaced; `{}`: with the hole from the start."""
    text = TUNNEL if loading != "{}" else "\n".join(line for line in TUNNEL.splitlines() if "core" not in line)
    defaults = {"WIDTH": "24", "YOUNG": "20000", "CONTACT": "bonded", "CRACKS": "", "SPACING": "1"}
    for word, value in words.items():
        text = text.replace(word, value)
    return case_of(text, *settings, LOADING=loading, **defaults)


def steps_of(case: Case) -> list[tuple[StepResult, StepSolution]]:
    return list(solved_steps(case))


@pytest.mark.parametrize("core", [{}, {"YOUNG": "3000"}, {"CONTACT": "{friction: 3, cohesion: 0}"}], ids=str)
def test_rock_released_in_stages_is_rock_with_the_hole_from_the_start(core: dict[str, str]) -> None:
    """Where nothing slides, whatever the core was made of and however many stages it takes."""
    (_, expected), *_ = steps_of(tunnel("{}"))
    size = np.abs(expected.outcome.u).max()
    for loading in (ONE_STAGE, TWO_HALVES):
        *_, (_, last) = steps_of(tunnel(loading, **core))
        np.testing.assert_allclose(last.outcome.u, expected.outcome.u, rtol=0, atol=1e-9 * size)


def test_a_lining_presses_on_the_wall_from_its_stage_on() -> None:
    """A traction with a name of its own on an edge that is a boundary with the core until then."""
    rock = "  - {body: rock, stress"
    lining = f"  - {{on: {{body: rock, edge: hole0}}, traction: [x/2, y/2], name: lining}}\n{rock}"
    loading = "{stages: [{}, {excavate: core}, {loads: {lining: 3}}]}"
    *_, (_, found) = steps_of(tunnel(loading, **{rock: lining}))
    (_, expected), *_ = steps_of(tunnel("{}", **{rock: lining.replace("x/2, y/2", "3*x/2, 3*y/2")}))
    size = np.abs(expected.outcome.u).max()
    np.testing.assert_allclose(found.outcome.u, expected.outcome.u, rtol=0, atol=1e-9 * size)


TWO_DRIFTS = """
title: two drifts on both sides of a joint
plane: strain
units: {stress: MPa}
bodies:
  rock:
    shape:
      rectangle: {center: [0, 0], width: 24, height: 20}
      holes: [{rectangle: {center: [-3, 0], width: 3, height: 3}}, {rectangle: {center: [3, 0], width: 3, height: 3}}]
    material: {young: 20000, poisson: 0.25}
  left: {shape: {rectangle: {center: [-3, 0], width: 3, height: 3}}, material: {young: 20000, poisson: 0.25}}
  right: {shape: {rectangle: {center: [3, 0], width: 3, height: 3}}, material: {young: 20000, poisson: 0.25}}
interfaces: [{between: [rock, left], contact: bonded}, {between: [right, rock], contact: bonded}]
cracks: {joint: {path: {points: [[-1.2, -6], [1, 6]]}, contact: {friction: FRICTION, cohesion: 0}}}
supports: [{outline: fixed}]
loads:
  - {body: rock, stress: [-8, -16, 0]}
  - {body: left, stress: [-8, -16, 0]}
  - {body: right, stress: [-8, -16, 0]}
loading: {stages: [{}, STAGES]}
numerics: {spacing: 1}
"""
ORDERS = (
    "{excavate: left}, {excavate: right}",
    "{excavate: right}, {excavate: left}",
    "{excavate: [left, right]}",
    "{excavate: [right, left], release: 0.3}, {release: 0.9}, {release: 1}",
    "{excavate: left, release: 0.5}, {excavate: right}",
)


@pytest.mark.parametrize(("friction", "slides"), [("5", False), ("0.25", True)])
def test_the_order_of_excavation_matters_where_a_joint_slides(friction: str, slides: bool) -> None:
    """And to rounding not where it holds: elasticity has no memory, friction has."""
    last = [steps_of(case_of(TWO_DRIFTS, STAGES=order, FRICTION=friction))[-1] for order in ORDERS]
    found = [solution.outcome.u for _, solution in last]
    size = np.abs(found[0]).max()
    np.testing.assert_allclose(found[3], found[2], rtol=0, atol=1e-8 * size)  # the same way, with stops
    for other in (1, 2, 4):
        apart = np.abs(found[other] - found[0]).max()
        assert apart > 1e-3 * size if slides else apart < 1e-9 * size
    assert max(result.energy.error for result, _ in last) < 1e-6


COLUMN = """
title: two blocks under their weight, the upper one is taken away
plane: strain
bodies:
  low: {shape: {rectangle: {center: [0, 1], width: 2, height: 2}}, material: {young: 1e9, poisson: 0, density: 2000}}
  top: {shape: {rectangle: {center: [0, 3.5], width: 2, height: 3}}, material: {young: 4e9, poisson: 0, density: 3000}}
interfaces: [{between: [low, top], contact: CONTACT}]
supports: SUPPORTS
loads:
  - {body: low, gravity: [0, -10]}
  - {body: top, gravity: [0, -10]}
  - {on: {body: top, edge: top}, traction: [0, -4e4], name: house}
loading: {stages: [{}, {loads: {house: 1}}, {excavate: top, release: 0.25}, {release: 1}]}
numerics: {spacing: 0.4}
output: {points: {head: {body: low, at: [0, 2]}, roof: {at: [0, 5]}}}
"""
ON_ROLLERS = (
    "[{at: [1, 5], displacement: {x: 0}}, {on: {body: low, edge: bottom}, displacement: {y: 0}},"
    " {at: [0, 0], displacement: {x: 0}}]"
)
ON_ROCK = "[{on: {body: low, edge: bottom}, contact: {friction: 0.5, cohesion: 0}}]"


@pytest.mark.parametrize(
    ("contact", "supports"),
    [("bonded", ON_ROLLERS), ("{friction: 0.5, cohesion: 0}", ON_ROLLERS), ("{friction: 0.5, cohesion: 0}", ON_ROCK)],
)
def test_a_column_rebounds_when_its_upper_part_is_taken_away(contact: str, supports: str) -> None:
    """Uniform strain: head = -(q h + w h^2 / 2) / E with q the pressure on it; energies of the column exactly."""
    results, _ = whole_run(case_of(COLUMN, CONTACT=contact, SUPPORTS=supports))
    own, E, h = 2e4, 1e9, 2.0
    pressures = [9e4, 13e4, 0.75 * 13e4, 0.0]
    heads, roofs = ([seen([result], f"{point}.u_y")[-1] for result in results] for point in ("head", "roof"))
    np.testing.assert_allclose(heads, [-(q * h + 0.5 * own * h**2) / E for q in pressures], rtol=1e-6)
    assert np.isfinite(roofs[:2]).all()
    assert np.isnan(roofs[2:]).all()
    stored = [2.0 * (q**2 * h + q * own * h**2 + own**2 * h**3 / 3.0) / (2.0 * E) for q in pressures]
    np.testing.assert_allclose([result.energy.strain for result in results[2:]], stored[2:], rtol=1e-6)
    of_top = results[1].energy.strain - stored[1]
    released = [result.energy.released for result in results]
    np.testing.assert_allclose(released, [0, 0, of_top, of_top], rtol=1e-6, atol=1e-3)
    assert max(result.energy.error for result in results) < 1e-6
    forces = [{reaction.where: reaction.force for reaction in result.reactions} for result in results]
    assert all(list(found) == list(forces[0]) for found in forces)  # those that are gone stay in the tables
    foot = "supports.1" if supports == ON_ROLLERS else "low.bottom"
    np.testing.assert_allclose([found[foot][1] for found in forces], [2 * (q + own * h) for q in pressures], rtol=1e-6)
    for name in ("supports.0", "low/top") if supports == ON_ROLLERS else ("low/top",):
        assert not np.any(forces[3][name])


def test_stages_of_factors_are_a_history() -> None:
    """The same loads in the same turn; the configuration is made anew in each stage."""
    factors = [0.4, 1, -0.3, 0.6]
    loadings = (f"loading.history={factors}", f"loading={{stages: {[{'factor': f} for f in factors]}}}")
    in_turn, staged = (
        whole_run(shipped_case("cyclic_friction", ["numerics.spacing=10", "output.frames=none", loading]))[0]
        for loading in loadings
    )
    for expected, found in zip(in_turn, staged, strict=True):
        size = np.abs(expected.contact.slip).max()
        np.testing.assert_allclose(found.contact.slip, expected.contact.slip, rtol=0, atol=1e-9 * size)
        assert found.energy.dissipated == pytest.approx(expected.energy.dissipated, rel=1e-9)
        assert found.energy.error < 1e-9
    assert [result.load_factor for result in staged] == [1.0, 2.0, 3.0, 4.0]


SLIPPERY = "cracks: {a: {path: {points: [[3, 1], [5.5, 2.2]]}, contact: {friction: 0, cohesion: 0}}}"
JUDGED = (
    "growth={criterion: max_hoop_stress, advance: all, steps: 0, increment: 0.5}",
    "bodies.rock.strength={tension: 5, cohesion: 20, friction_angle: 40, toughness: 1 MPa sqrt(m)}",
)


def aimed(accuracy: float | str, loading: str = ONE_STAGE, *settings: str) -> Case:
    return tunnel(loading, *settings, SPACING=f"auto, accuracy: {accuracy}", CRACKS=SLIPPERY)


def K_of(step: StepResult) -> Floats:
    """K_I and K_II (n, 2) of all tips, Pa sqrt(m)."""
    return np.array([(tip.K_I, tip.K_II) for tip in step.tips])


def test_a_target_holds_at_the_end_of_stages() -> None:
    """Without friction K is what it would be had the hole always been there. With growth the last stage is judged."""
    exact = K_of(next(grow(aimed(0.005, "{}"))))
    case, target = aimed(0.03), 0.03
    steps = list(grow(case))
    judged = next(grow(aimed(0.03, ONE_STAGE, *JUDGED)))
    for step in (*steps, judged):
        estimates = [max(tip.K_I_error, tip.K_II_error) / BOUND for tip in step.tips]
        assert max(estimates) <= target * np.hypot(*K_of(step).T).max()
    for step in (steps[1], judged):
        assert np.hypot(*(K_of(step) - exact).T).max() <= target * np.hypot(*exact.T).max()
    assert np.hypot(*(K_of(steps[0]) - exact).T).max() > 2.0 * target * np.hypot(*exact.T).max()
    again = next(grow(case, steps[1].checkpoint))
    assert np.array_equal(K_of(again), K_of(steps[1]))
    assert again.factorizations == steps[1].factorizations


def test_a_crack_grows_at_the_end_of_all_stages() -> None:
    """As beside a hole that has always been there."""
    grows = (JUDGED[0].replace("steps: 0", "steps: 1"), JUDGED[1].replace("1 MPa", "0.1 MPa"), "numerics.spacing=1")
    (found, end), (expected, like) = (
        whole_run(tunnel(loading, *grows, CRACKS=SLIPPERY)) for loading in (TWO_HALVES, "{}")
    )
    assert len(found) == len(expected) == 2
    np.testing.assert_allclose(end.cracks[0].points, like.cracks[0].points, rtol=0, atol=1e-9)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(K_of(one), K_of(other), rtol=0, atol=1e-6 * np.abs(K_of(other)).max())
        assert one.history is None or one.history.load_factor[[0, -1]].tolist() == [1.0, 3.0]


BONDED_BY_COHESION = """
title: a block that coheres with its base is pressed, let go, and pressed again
plane: strain
units: {length: mm, stress: MPa}
bodies:
  up:
    shape: {polygon: [[-50, -10], [50, 10], [50, 50], [-50, 50]]}
    edges: {top: 2}
    material: {young: 10000, poisson: 0.2}
  low:
    shape: {polygon: [[-50, -50], [50, -50], [50, 10], [-50, -10]]}
    edges: {bottom: 0}
    material: {young: 10000, poisson: 0.2}
cracks:
  high: {path: {points: [[-20, 25], [15, 27]]}, contact: LAW}
  deep: {path: {points: [[-25, -30], [0, -25], [20, -31]]}, contact: LAW}
interfaces: [{between: [up, low], contact: LAW}]
supports: [{on: {body: low, edge: bottom}, displacement: {x: 0, y: 0}}]
loads: [{on: {body: up, edge: top}, traction: [0, -7], name: press}]
loading: {stages: STAGES}
numerics: {spacing: 6}
"""


@pytest.mark.parametrize("dilation", [0, 4])
@pytest.mark.parametrize("way", [(0.7, 0.0, 1.0), (0.9, 0.7, 0.3, 0.0, 0.6, 0.0, 1.0)])
def test_bonds_hold_through_stages_without_load(way: tuple[float, ...], dilation: int) -> None:
    """Nothing slips at full load. Without load tractions are round-off: bonds broke by it, and faces slipped after."""
    law = f"{{friction: 0.6, cohesion: 0.35, residual_friction: 0.2, dilation_angle: {dilation}}}"

    def at_last(factors: tuple[float, ...]) -> StepResult:
        stages = [{"loads": {"press": factor}} for factor in factors]
        *_, last = grow(case_of(BONDED_BY_COHESION, LAW=law, STAGES=stages))
        return last

    last, straight = at_last(way), at_last((1.0,))
    assert (last.contact.state == STICK).all()
    assert not last.warnings
    tractions = [(at.contact.normal_traction, at.contact.tangential_traction) for at in (last, straight)]
    np.testing.assert_allclose(*tractions, atol=1e-9 * 7e6)
