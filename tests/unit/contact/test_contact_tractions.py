"""Tractions between contact points that are the points where the elastic law holds."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.coulomb import SLIP, STICK
from crackgrow.contact.tractions import elastic_tractions
from crackgrow.run.evaluation import StepSolution, evaluated
from crackgrow.run.increments import from_state, increment, unloaded
from tests.unit.run.test_run_held import inside, on_plane, plate

pytestmark = pytest.mark.physics

KEPT = {"cohesion": 10, "cohesion_after_slip": "kept"}
LAWS = [
    ({"cohesion": 0}, (1.0,), SLIP),
    ({"cohesion": 0, "dilation_angle": 10}, (1.0,), SLIP),
    ({"cohesion": 0, "dilation_angle": 10}, (1.0, 0.9), STICK),
    (KEPT, (1.0,), SLIP),
    ({**KEPT, "dilation_angle": 5}, (1.0,), SLIP),
    ({**KEPT, "dilation_angle": 5}, (1.0, 0.9), STICK),
    ({"cohesion": 40}, (1.0,), STICK),
]


def solved(
    discretization: str, pressure: float, factors: tuple[float, ...], angle: float = 30.0, **law: object
) -> StepSolution:
    """A crack under shear of 30 MPa, with elastic contact, at the last of some load factors."""
    contact = f"numerics.contact={{stiffness: 100, discretization: {discretization}}}"
    scene = plate(inside(angle), on_plane(angle, pressure, 30.0), "numerics.spacing=2", contact, **law)
    start = unloaded(scene)
    for factor in factors:
        state = increment(scene, start, factor)
        start = from_state(state)
    return evaluated(state)


@pytest.mark.parametrize(("law", "factors", "state"), LAWS)
def test_at_the_contact_points_they_are_those_of_the_contact_points(law: dict, factors: tuple, state: int) -> None:
    """Dilation is no overlap, and the part of the shear that cohesion carries is none of friction's."""
    solution = solved("gauss", 20.0, factors, **law)
    outcome, faces = solution.outcome, solution.faces
    assert set(outcome.points.state.tolist()) == {state}
    normal, tangential = elastic_tractions(solution.cover, faces, 0, faces.s, solution.contact.law, outcome)
    np.testing.assert_allclose(normal, outcome.points.normal, rtol=1e-6)
    np.testing.assert_allclose(tangential, outcome.points.tangential, rtol=1e-6)


@pytest.mark.parametrize(("law", "factors", "state"), LAWS[1:5])
def test_gauss_points_have_the_K_of_mortar_nodes(law: dict, factors: tuple, state: int) -> None:
    """But for the spurious K_I of elastic contact, proportional to the pressure, which only Gauss points see."""
    found = []
    for some in (LAWS[0], (law, factors, state)):
        mortar, gauss = (solved(name, 20.0, some[1], **some[0]) for name in ("mortar", "gauss"))
        assert set(mortar.outcome.points.state.tolist()) == {some[2]}
        spurious, off = np.array(gauss.tips[1].K) - mortar.tips[1].K
        found.append((spurious / mortar.outcome.points.normal.mean(), off, mortar.tips[1].K[1]))
    (by_friction, _, K_II), (over_pressure, off, _) = found
    assert over_pressure == pytest.approx(by_friction, rel=0.1)
    assert abs(off) < 0.02 * K_II


def test_shear_on_a_bond_does_not_ask_for_the_pressure() -> None:
    """All sticks: K_II is that of the shear, also where the pressure is round-off."""
    K_II = [[tip.K[1] for tip in solved("gauss", p, (1.0,), angle=0.0, cohesion=40).tips] for p in (0.0, 1.0, 20.0)]
    np.testing.assert_allclose(K_II, np.tile(K_II[2], (3, 1)), rtol=1e-3)
    assert min(np.abs(K_II[2])) > 1e5
