"""In-situ stress and water by formulas of the place: what balances moves nothing, what a cut frees has its K."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.errors import SolveError
from crackgrow.run.result import StepResult
from tests.stability.changed import QUARTER, Change
from tests.verification.solutions import solve_case
from tests.whole_run import whole_run

WEIGHT = 2650.0 * 9.81  # N/m^3

UNDER_WEIGHT = """
title: rock under its own weight, whose slope carries what the rock above it would
plane: strain
bodies:
  rock:
    shape: {polygon: [[0, 0], [30, 0], [30, 20], [18, 20], [14, 13], [0, 13]]}
    material: {young: 5 GPa, poisson: 0.2, density: 2650}
    edges: {bottom: 0, left: 5, right: 1, slope: 3, ground: 4}
CRACKS
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
output: {frames: none, figures: false}
"""


def case_of(folder: Path, text: str) -> Case:
    path = folder / "case.yaml"
    path.write_text(text, encoding="utf-8")
    return load_case(path)


@pytest.mark.parametrize(
    "change", [Change("as it is"), Change("turned", QUARTER), Change("scaled", size=1e-3, stress=1e-6, young=1e-2)]
)
def test_rock_in_equilibrium_with_its_weight_does_not_move(tmp_path: Path, change: Change) -> None:
    case = case_of(tmp_path, UNDER_WEIGHT.replace("CRACKS\n", ""))
    solved = solve_case(Case.from_dict(change.apply(case.to_dict())))
    size = change.displacement * 20.0 * WEIGHT * 20.0 / 5e9  # of the displacement if the weight came on
    places = np.array([(15.0, 5.0), (29.9, 0.1), (5.0, 12.9), (18.0, 19.9), (14.5, 12.9), (25.0, 19.99), (17.0, 17.0)])
    assert np.abs(solved.displacement(change.points(places))).max() < 1e-9 * size


def test_a_joint_in_rock_at_rest_carries_what_the_rock_beside_it_does(tmp_path: Path) -> None:
    joint = "cracks: {joint: {path: {points: [[8, 3], [22, 12]]}, contact: {friction: 0.8, cohesion: 0}}}"
    solution = solve_case(case_of(tmp_path, UNDER_WEIGHT.replace("CRACKS", joint))).solution
    nodes = solution.faces.nodes
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
supports:
  - {on: {edge: bottom}, displacement: {x: 0, y: 0}}
  - {on: {edge: top}, displacement: {x: 0, y: 0}}
  - {on: {edge: left}, displacement: {x: 0, y: 0}}
  - {on: {edge: right}, displacement: {x: 0, y: 0}}
loads:
LOADS
numerics: {spacing: 0.5}
output: {frames: none, figures: false}
"""


def K_of(folder: Path, path: str, *loads: str) -> np.ndarray:
    text = CRACKED.replace("PATH", path).replace("LOADS", "\n".join(f"  - {load}" for load in loads))
    step: StepResult = whole_run(case_of(folder, text))[0][0]
    return np.array([(tip.K_I, tip.K_II) for tip in step.tips])


@pytest.mark.parametrize("path", ["[[-2, 1], [2, 1]]", "[[1, -2], [1, 2]]"])
def test_a_cut_in_stressed_rock_has_the_K_of_pressure_on_its_faces(tmp_path: Path, path: str) -> None:
    """The stress that the cut takes away is the traction that it frees; K of the pressure is known to be right."""
    of_stress = K_of(tmp_path, path, '{body: rock, stress: ["1e6*(2 + y)", "1e6*(3 + x/4)", 0]}')
    across = "1e6*(3 + x/4)" if path.endswith("1]]") else "1e6*(2 + y)"
    of_pressure = K_of(tmp_path, path, f'{{crack: flaw, pressure: "{across}"}}')
    size = np.abs(of_pressure).max()
    np.testing.assert_allclose(of_stress, of_pressure, rtol=0, atol=2e-4 * size)
    assert abs(of_pressure[0, 0] - of_pressure[1, 0]) > 0.1 * size  # the load differs from tip to tip


def test_weight_and_the_stress_that_carries_it_leave_K_of_the_faces(tmp_path: Path) -> None:
    """sigma_yy = w y - 8e5: its divergence cancels the weight inside of the disc of the integral as well."""
    steep = "[[1, -2], [1, 2]]"
    weight = 40.0 * WEIGHT  # heavy, so that what is forgotten shows
    stress = f'{{body: rock, stress: ["{weight!r}*y/2 + 6e6", "{weight!r}*y + 3e6", 0]}}'
    found = K_of(tmp_path, steep, stress, "{body: rock, gravity: [0, -392.4]}")
    expected = K_of(tmp_path, steep, f'{{crack: flaw, pressure: "{weight!r}*y/2 + 6e6"}}')
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-4 * np.abs(expected).max())


WATER = """
title: water between two blocks
plane: stress
bodies:
  low: {shape: {rectangle: {center: [0, -0.5], width: 4, height: 1}}, material: {young: 1e9, poisson: 0}}
  top: {shape: {rectangle: {center: [0, 0.5], width: 4, height: 1}}, material: {young: 1e9, poisson: 0}}
interfaces: [{between: [top, low], contact: {friction: 0.5, cohesion: 0}}]
supports:
  - {on: {body: low, edge: bottom}, displacement: {x: 0, y: 0}}
loads:
  - {on: {body: top, edge: top}, traction: [0, "-1e5 - 1e4*x"]}
  - {interface: PAIR, pressure: "4e4 + 1e4*x"}
numerics: {spacing: 0.25}
output: {frames: none, figures: false}
"""


@pytest.mark.parametrize("pair", ["[top, low]", "[low, top]"])
def test_water_in_an_interface_takes_its_pressure_off_the_faces(tmp_path: Path, pair: str) -> None:
    """Effective stress: the faces carry 1e5 + 1e4 x less the pressure of the water."""
    solution = solve_case(case_of(tmp_path, WATER.replace("PAIR", pair))).solution
    weights = solution.contact.weights
    assert weights @ solution.outcome.points.normal == pytest.approx(-4 * 6e4, rel=1e-9)
    x = solution.faces.nodes.points[:, 0] * solution.scene.lattice.spacing
    x = x - (weights @ x) / weights.sum()
    assert weights @ (x * solution.outcome.points.normal) == pytest.approx(0.0, abs=1e-6 * 4 * 6e4)


def test_water_that_lifts_the_block_off_is_told(tmp_path: Path) -> None:
    text = WATER.replace("PAIR", "[top, low]").replace("4e4 + 1e4*x", "12e4 + 1e4*x")
    with pytest.raises(SolveError, match="is free to move: contact does not hold it, it moves off 'top/low'"):
        solve_case(case_of(tmp_path, text))
