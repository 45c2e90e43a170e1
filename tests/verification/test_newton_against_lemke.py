"""Lemke on the LCP (17) and Newton on the traction form agree: the paper's Gauss points, many of them, open wings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csr_array, vstack

from crackgrow.case.model import Case
from crackgrow.contact.contact_lcp import solve_by_lemke
from crackgrow.contact.jump import contact_operators
from crackgrow.contact.problem import ContactProblem
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.linear import ConstrainedSystem
from crackgrow.run import grow
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.scene import make_scene
from crackgrow.solid.loads import load_vector
from crackgrow.solid.places import boxes_of_functions
from crackgrow.solid.stiffness import stiffness
from crackgrow.solid.supports import constraints
from tests.one_size import one_size
from tests.scenes import shipped_case
from tests.solving import solve_step
from tests.verification.solutions import QUIET

SIZE = one_size("compression30")


def gauss_case(friction: float, solver: str) -> Case:
    """compression30 with the paper's contact."""
    contact = {"discretization": "gauss", "stiffness": "100", "solver": solver}
    overrides = [f"numerics.contact.{key}={value}" for key, value in contact.items()]
    return shipped_case("compression30", [*SIZE, *overrides, f"cracks.flaw.contact.friction={friction}"])


def solve(friction: float, solver: str, n_steps: int) -> StepSolution:
    """The flaw after a number of growth steps."""
    case = gauss_case(friction, solver)
    crack = GrowingCrack.given(case.cracks[0])
    if n_steps:
        *_, last = grow(shipped_case("compression30", [*SIZE, f"growth.steps={n_steps}", *QUIET]))
        crack = GrowingCrack(replace(case.cracks[0], points=last.cracks[0].points), last.cracks[0].steps)
    return solve_step(make_scene(case), (crack,), 1.0)


@pytest.mark.parametrize("n_steps", [0, 10])
@pytest.mark.parametrize("friction", [0.0, 0.3, 0.6])
def test_same_slip_and_tractions(friction: float, n_steps: int) -> None:
    newton, lemke = (solve(friction, solver, n_steps).outcome.points for solver in ("newton", "lemke"))
    assert newton.status == lemke.status == "solved"
    largest = np.abs(newton.normal).max()
    assert largest > 10e6  # Pa: the faces do press on each other
    np.testing.assert_allclose(lemke.normal, newton.normal, rtol=0.0, atol=1e-6 * largest)
    np.testing.assert_allclose(lemke.tangential, newton.tangential, rtol=0.0, atol=1e-6 * largest)
    np.testing.assert_allclose(lemke.slip, newton.slip, rtol=0.0, atol=1e-6 * np.abs(newton.slip).max())


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_lcp_of_all_points_with_the_open_wings(friction: float) -> None:
    """The LCP (17) of all 550 points of the tenth step: leaving open points out of the solve changes nothing."""
    solution, case = solve(friction, "newton", 10), gauss_case(friction, "lemke")
    scene = make_scene(case)
    stiff = stiffness(solution.cover, scene.materials, case.numerics.quadrature)
    held = constraints(solution.cover, case.supports)
    system = ConstrainedSystem(stiff, held.matrix, boxes_of_functions(solution.cover))
    free, _ = system.solve(load_vector(solution.cover, case.bodies, case.loads, 4), held.given)
    jumps = csr_array(vstack(contact_operators(solution.cover, solution.faces)))
    weights = np.tile(solution.faces.weights * scene.lattice.spacing, 2)
    response, _ = system.solve((jumps.T * weights).toarray())
    compliance = jumps @ response + np.eye(len(weights)) * case.numerics.spacing / (100 * 1e10)
    n, normal = solution.faces.n, solution.outcome.points.normal
    lemke = solve_by_lemke(ContactProblem(compliance, jumps @ free, np.full(n, friction)))
    assert lemke.status == "solved"
    assert lemke.iterations > 400  # one pivot per open point at least
    np.testing.assert_allclose(lemke.traction[:n], normal, rtol=0.0, atol=1e-6 * np.abs(normal).max())
