"""Rock in the ground: what balances moves nothing, a cut or water has its K, loads that cancel leave nothing.

In-situ stress and weight, uniform or by formulas of the place; water in joints.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import crackgrow
from crackgrow.case.model import Case
from crackgrow.errors import SolveError
from crackgrow.run.loop import grow
from crackgrow.run.result import StepResult
from tests.stability.changed import QUARTER, Change
from tests.verification.rows.test_tips import FAR, SQUARE, STRESS, ground, outcrop
from tests.verification.solutions import case_of, solve_case

PLACES = np.array([[10.0, 10.0], [30.0, 0.0], [0.0, 40.0], [-25.0, -20.0]])
IN_SITU, NO_SHEAR = {"stress": STRESS}, {"stress": [*STRESS[:2], 0]}


@pytest.mark.parametrize(
    ("supports", "loads", "shape", "moved"),
    [
        ("minimal", [FAR], outcrop(41), 2e-2),
        ("minimal", [IN_SITU, FAR], outcrop(41), 0.0),
        ([{"outline": "fixed"}], [IN_SITU], outcrop(41), 1e-10),
        ([{"outline": "rollers"}], [NO_SHEAR], SQUARE, 1e-10),
    ],
    ids=["loaded", "in balance", "fixed", "rollers"],
)
def test_without_a_crack_stress_is_uniform(
    supports: Any, loads: list[Any], shape: dict[str, Any], moved: float
) -> None:
    """The stress alone would displace the rim by 10 mm."""
    solution = crackgrow.solve(case_of(ground(shape, supports, loads)))
    wanted = 1e6 * np.array(loads[0].get("stress", STRESS))
    np.testing.assert_allclose(solution.stress_at(PLACES), np.tile(wanted, (4, 1)), atol=1.0)
    assert np.abs(solution.displacement_at(PLACES)).max() <= moved
    assert not solution.warnings


WEIGHT = 2650.0 * 9.81  # N/m^3

UNDER_WEIGHT = """
title: rock under its own weight, whose slope carries what the rock above it would
plane: strain
bodies:
  rock:
    shape: {polygon: [[0, 0], [30, 0], [30, 20], [18, 20], [14, 13], [0, 13]]}
    material: {young: 5 GPa, poisson: 0.2, density: 2650}
    edges: {bottom: 0, left: 5, right: 1, slope: 3, ground: 4}
cracks: {CRACKS}
supports:
  - {on: {body: rock, edge: bottom}, displacement: {y: 0}}
  - {on: {body: rock, edge: left}, displacement: {x: 0}}
  - {on: {body: rock, edge: right}, displacement: {x: 0}}
loads:
  - {body: rock, gravity: [0, -9.81]}
  - {body: rock, stress: ["0.25*2650*9.81*(y - 20)", "2650*9.81*(y - 20)", 0]}
  - {on: {body: rock, edge: slope}, traction: ["-7/65**0.5*0.25*2650*9.81*(y - 20)", "4/65**0.5*2650*9.81*(y - 20)"]}
  - {on: {body: rock, edge: ground}, traction: [0, "2650*9.81*(y - 20)"]}
numerics: {spacing: 1.3}
"""


@pytest.mark.parametrize(
    "change", [Change("as it is"), Change("turned", QUARTER), Change("scaled", size=1e-3, stress=1e-6, young=1e-2)]
)
def test_rock_in_equilibrium_with_its_weight_does_not_move(change: Change) -> None:
    solved = solve_case(Case.from_dict(change.apply(case_of(UNDER_WEIGHT, CRACKS="").to_dict())))
    size = change.displacement * 20.0 * WEIGHT * 20.0 / 5e9  # of the displacement if the weight came on
    places = np.array([(15.0, 5.0), (29.9, 0.1), (5.0, 12.9), (18.0, 19.9), (14.5, 12.9), (25.0, 19.99), (17.0, 17.0)])
    assert np.abs(solved.displacement(change.points(places))).max() < 1e-9 * size


def test_a_joint_in_rock_at_rest_carries_what_the_rock_beside_it_does() -> None:
    joint = "joint: {path: {points: [[8, 3], [22, 12]]}, contact: {friction: 0.8, cohesion: 0}}"
    solution = solve_case(case_of(UNDER_WEIGHT, CRACKS=joint)).solution
    nodes = solution.configuration.faces.nodes
    mine = nodes.surface == 0
    y = solution.scene.lattice.to_metres(nodes.points[mine])[:, 1]
    (n_x, n_y), stress = nodes.normal[mine].T, WEIGHT * (y - 20.0)
    normal, shear = stress * (0.25 * n_x**2 + n_y**2), stress * (0.25 - 1.0) * n_x * n_y
    size = np.abs(normal).max()
    np.testing.assert_allclose(solution.outcome.points.normal[mine], normal, rtol=0, atol=0.02 * size)
    np.testing.assert_allclose(solution.outcome.points.tangential[mine], shear, rtol=0, atol=0.02 * size)


CRACKED = """
title: a crack in rock that is held all round
plane: strain
bodies:
  rock:
    shape: {rectangle: {center: [0, 0], width: 20, height: 20}}
    material: {young: 5 GPa, poisson: 0.2, density: 2650}
cracks: {flaw: {path: {points: PATH}, contact: none}}
supports: [{outline: fixed}]
loads: [LOADS]
numerics: {spacing: 0.5}
"""


def K_of(path: str, *loads: str) -> np.ndarray:
    """K_I and K_II (n, 2) Pa sqrt(m) of the crack's tips."""
    step = next(grow(case_of(CRACKED, PATH=path, LOADS=", ".join(loads))))
    return np.array([(tip.K_I, tip.K_II) for tip in step.tips])


STEEP = "[[1, -2], [1, 2]]"


@pytest.mark.parametrize(("path", "across"), [("[[-2, 1], [2, 1]]", "1e6*(3 + x/4)"), (STEEP, "1e6*(2 + y)")])
def test_a_cut_in_stressed_rock_has_the_K_of_pressure_on_its_faces(path: str, across: str) -> None:
    """The stress that the cut takes away is the traction that it frees; K of the pressure is known to be right."""
    of_stress = K_of(path, '{body: rock, stress: ["1e6*(2 + y)", "1e6*(3 + x/4)", 0]}')
    of_pressure = K_of(path, f'{{crack: flaw, pressure: "{across}"}}')
    size = np.abs(of_pressure).max()
    np.testing.assert_allclose(of_stress, of_pressure, rtol=0, atol=2e-4 * size)
    assert abs(of_pressure[0, 0] - of_pressure[1, 0]) > 0.1 * size  # the load differs from tip to tip


def test_weight_and_the_stress_that_carries_it_leave_K_of_the_faces() -> None:
    """Its divergence cancels the weight w inside of the disc of the integral as well; shear is zero on the faces."""
    weight = 40.0 * WEIGHT  # heavy, so that what is forgotten shows
    w = repr(weight)
    stress = f'{{body: rock, stress: ["{w}*y/2 + 6e6", "{w}*y/2 + 3e6", "{w}*(x - 1)/2"]}}'
    found = K_of(STEEP, stress, "{body: rock, gravity: [0, -392.4]}")
    expected = K_of(STEEP, f'{{crack: flaw, pressure: "{weight!r}*y/2 + 6e6"}}')
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-4 * np.abs(expected).max())


WATER = """
title: water between two blocks
plane: stress
bodies:
  low: {shape: {rectangle: {center: [0, -0.5], width: 4, height: 1}}, material: {young: 1e9, poisson: 0}}
  top: {shape: {rectangle: {center: [0, 0.5], width: 4, height: 1}}, material: {young: 1e9, poisson: 0}}
interfaces: [{between: [top, low], contact: {friction: 0.5, cohesion: 0}}]
supports: [{on: {body: low, edge: bottom}, displacement: {x: 0, y: 0}}]
loads:
  - {on: {body: top, edge: top}, traction: [0, "-1e5 - 1e4*x"]}
  - {interface: PAIR, pressure: "HIGH + 1e4*x"}
numerics: {spacing: 0.25}
"""


@pytest.mark.parametrize("pair", ["[top, low]", "[low, top]"])
def test_water_in_an_interface_takes_its_pressure_off_the_faces(pair: str) -> None:
    """Effective stress: the faces carry 1e5 + 1e4 x less the pressure of the water."""
    solution = solve_case(case_of(WATER, PAIR=pair, HIGH="4e4")).solution
    weights = solution.configuration.contact.weights
    assert weights @ solution.outcome.points.normal == pytest.approx(-4 * 6e4, rel=1e-9)
    x = solution.configuration.faces.nodes.points[:, 0] * solution.scene.lattice.spacing
    x = x - (weights @ x) / weights.sum()
    assert weights @ (x * solution.outcome.points.normal) == pytest.approx(0.0, abs=1e-6 * 4 * 6e4)


def test_water_that_lifts_the_block_off_is_told() -> None:
    with pytest.raises(SolveError, match="is free to move: contact does not hold it, it moves off 'top/low'"):
        solve_case(case_of(WATER, PAIR="[top, low]", HIGH="12e4"))


BLOCK = """
title: a block on rock with a flaw
plane: strain
bodies:
  rock: {shape: {rectangle: {center: [0, 0], width: 2, height: 2}}, material: {young: 1e10, poisson: 0.25}}
  block: {shape: {rectangle: {center: [0, 1.25], width: 0.6, height: 0.5}}, material: {young: 1e10, poisson: 0.25}}
cracks: {flaw: {path: {center: [0, 0], length: 0.7, angle: 35}, contact: {friction: FRICTION, cohesion: 0}}}
interfaces: [{between: [rock, block], contact: {friction: FRICTION, cohesion: 0}}]
supports: [{on: {body: rock, edge: bottom}, displacement: {x: 0, y: 0}}]
loads:
  - {on: {body: block, edge: top}, traction: [3.1e5, -3.1e6], name: down}
  - {on: {body: block, edge: top}, traction: [-1.55e5, 1.55e6], name: up}
  - {on: {body: rock, edge: left}, traction: [PUSH, 0], name: push}
  - {on: {body: rock, edge: left}, traction: [PULL, 0], name: pull}
numerics: {spacing: 0.25}
"""


def staged(*factors: tuple[float, ...], friction: float = 0.5, push: float = 2.3e6) -> list[StepResult]:
    """The steps of stages with factors of the four loads, of which each pair cancels at factors of 1, 2 and 1, -3."""
    names = ("down", "up", "push", "pull")
    stages = [{"loads": dict(zip(names, map(float, each), strict=True))} for each in factors]
    return list(grow(case_of(BLOCK, f"loading={{stages: {stages}}}", FRICTION=friction, PUSH=push, PULL=push / 3.0)))


@pytest.mark.parametrize("seed", range(3))
def test_loads_that_cancel_all_through_stages_leave_nothing(seed: int) -> None:
    """Tractions of 1e-10 Pa, and the states of points that go with them, are what round-off of the sums makes."""
    random = np.random.default_rng(seed)
    sizes, push = random.uniform(0.3, 1.5, (2, 2)).tolist(), float(random.uniform(1e6, 5e6))
    for step in staged(*((down, 2.0 * down, side, -3.0 * side) for down, side in sizes), push=push):
        assert np.abs(step.contact.normal_traction).max() == np.abs(step.contact.tangential_traction).max() == 0.0
        assert (step.contact.state == 0).all()
        assert np.abs(step.contact.slip).max() == 0.0


@pytest.mark.parametrize("friction", [0.12, 0.3])
@pytest.mark.parametrize("last", [(0, 0, 0, 0), (0.7, 1.4, 0, 0)], ids=["off", "taken back"])
def test_a_block_that_slid_lies_free_when_its_loads_go(friction: float, last: tuple[float, ...]) -> None:
    loaded, unloaded = staged((1, 0, 0, 0), last, friction=friction)
    assert np.abs(unloaded.contact.normal_traction).max() < 1e-12 * np.abs(loaded.contact.normal_traction).max()
    assert np.isfinite(unloaded.contact.slip).all()
