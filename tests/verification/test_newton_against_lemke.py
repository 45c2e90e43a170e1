"""Lemke on the LCP (17) and Newton on the traction form agree: the paper's Gauss points, mortar nodes, many of them."""

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
from crackgrow.run.judging import StepSolution
from crackgrow.run.scene import make_scene
from crackgrow.solid.loads import load_vector
from crackgrow.solid.stiffness import stiffness
from crackgrow.solid.supports import constraints
from tests.one_size import one_size
from tests.scenes import shipped_case
from tests.solving import solve_step

CASE = "compression30"
SIZE = one_size("compression30")


def gauss_case(friction: float, solver: str, *more: str) -> Case:
    settings = {
        "contact.discretization": "gauss",
        "contact.stiffness": "100",
        "contact.solver": solver,
    }
    overrides = [f"numerics.{key}={value}" for key, value in settings.items()]
    return shipped_case(CASE, [*SIZE, *overrides, f"cracks.flaw.contact.friction={friction}", *more])


def grown(friction: float, n_steps: int) -> GrowingCrack:
    """The flaw after a number of growth steps."""
    case = shipped_case(CASE, [*SIZE, f"growth.steps={max(n_steps, 1)}", "output.frames=none", "output.figures=false"])
    if n_steps == 0:
        return GrowingCrack.given(case.cracks[0])
    *_, last = grow(case)
    crack = replace(gauss_case(friction, "newton").cracks[0], points=last.cracks[0].points)
    return GrowingCrack(crack, last.cracks[0].steps)


def solve(friction: float, solver: str, crack: GrowingCrack) -> StepSolution:
    case = gauss_case(friction, solver)
    law = case.cracks[0].contact
    return solve_step(make_scene(case), (GrowingCrack(replace(crack.crack, contact=law), crack.steps),), 1.0)


@pytest.mark.parametrize("n_steps", [0, 10])
@pytest.mark.parametrize("friction", [0.0, 0.3, 0.6])
def test_same_slip_and_tractions(friction: float, n_steps: int) -> None:
    crack = grown(friction, n_steps)
    newton, lemke = (solve(friction, solver, crack).outcome for solver in ("newton", "lemke"))
    assert newton.points.status == lemke.points.status == "solved"
    largest = np.abs(newton.points.normal).max()
    assert largest > 10e6  # Pa: the faces do press on each other
    np.testing.assert_allclose(lemke.points.normal, newton.points.normal, rtol=0.0, atol=1e-6 * largest)
    np.testing.assert_allclose(lemke.points.tangential, newton.points.tangential, rtol=0.0, atol=1e-6 * largest)
    np.testing.assert_allclose(
        lemke.points.slip, newton.points.slip, rtol=0.0, atol=1e-6 * np.abs(newton.points.slip).max()
    )


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_lcp_of_all_points_with_the_open_wings(friction: float) -> None:
    """The LCP (17) of all 550 points of the tenth step: leaving open points out of the solve changes nothing."""
    crack = grown(friction, 10)
    solution = solve(friction, "newton", crack)
    case = gauss_case(friction, "lemke")
    scene = make_scene(case)
    stiff = stiffness(solution.cover, scene.materials, case.numerics.quadrature).matrix.tocsc()
    held = constraints(solution.cover, case.supports)
    system = ConstrainedSystem(stiff, held.matrix)
    free, _ = system.solve(load_vector(solution.cover, case.bodies, case.loads, 4), held.given)
    jumps = csr_array(vstack(contact_operators(solution.cover, solution.faces)))
    weights = np.tile(solution.faces.weights * scene.lattice.spacing, 2)
    response, _ = system.solve((jumps.T * weights).toarray())
    compliance = jumps @ response + np.eye(len(weights)) * case.numerics.spacing / (100 * 1e10)
    lemke = solve_by_lemke(ContactProblem(compliance, jumps @ free, np.full(solution.faces.n, friction)))
    assert lemke.status == "solved"
    assert lemke.iterations > 400  # one pivot per open point at least
    largest = np.abs(solution.outcome.points.normal).max()
    np.testing.assert_allclose(
        lemke.traction[: solution.faces.n], solution.outcome.points.normal, rtol=0.0, atol=1e-6 * largest
    )
