"""Whether Coulomb friction leaves the contact problem with one solution: `crackgrow check --unique`.

The given cracks are loaded as in a run. At every load factor the bound below is compared; beyond it, other starts of
the solvers may lead to a second solution.

With a positive definite compliance the problem always has a solution: friction only dissipates, which bounds the
tractions whatever the coefficient. Where normal and tangential jumps are coupled it may have several (Klarbring 1990):
pressed and sheared, a point can stay open as well as wedge itself.

Let b be the shear bounds (n,), and p_n(b) the pressures of the problem with b fixed (Tresca friction; one solution).
Points C are closed and S slip; all others of the tangential rows stick. With the symmetric compliance A and
tau = (shear where it sticks, +-db where it slips),

    dp_n = -A_CC^-1 A_Ct tau,     tau' (A_tt - A_tC A_CC^-1 A_Ct) tau <= db' A_tt db,

the latter since the sticking shear makes that energy least. With gamma < 1 the largest of x' A_nt y over
sqrt(x' A_nn x . y' A_tt y), whatever C and S,

    |dp_n| <= gamma / sqrt(1 - gamma^2) sqrt(largest eigenvalue of A_tt / least of A_nn) |db|,     |db| <= mu |dp_n|,

so that b -> c - mu p_n(b) is a contraction, and the solution the only one, while mu is below the inverse of the
factor. For one point that is |A_nn / A_nt| sqrt(1 - gamma^2), just below the |A_nn / A_nt| from which there can be two.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.linalg import solve_triangular

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Case, LoadHistory, Stages, StrengthReduction
from crackgrow.case.units import Metres, place_text
from crackgrow.contact.coulomb import OPEN, SLIP, STICK, ActiveSet, active_set
from crackgrow.contact.equations import solve_active
from crackgrow.contact.lemke import solve_by_lemke
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.problem import ContactProblem, ContactSolution
from crackgrow.contact.solve import OVERLAP, ContactOutcome, PointStates
from crackgrow.contact.system import MOST_CONDENSED, ContactSystem
from crackgrow.errors import NotSolvedError
from crackgrow.run.checkpoint import beginning
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.loading import LoadsInTurn, load
from crackgrow.run.scene import make_scene

DIFFERENT: Final = 1e-6  # jumps that differ by more, relative to the largest free one, are two solutions
LEMKE_POINTS: Final = 300  # of more, Lemke's method would cost several times what everything else of a step does

WORDS: Final = {OPEN: "is open", STICK: "sticks", SLIP: "slips"}


def friction_limit(compliance: Floats, weights: Floats) -> float:
    """Friction below which the contact problem has exactly one solution, by the bound above; infinity uncoupled.

    `compliance` (2 n, 2 n) m/Pa has normal and tangential rows of all points, and is symmetric once weighed with the
    points' lengths `weights` (n,). Zero where it is not positive definite.
    """
    n = len(weights)
    if n == 0:
        return float("inf")
    root, size = np.tile(np.sqrt(weights), 2), np.tile(np.sqrt(compliance.diagonal()[:n]), 2)
    A = compliance * (root / size)[:, None] / (root * size)  # no unit: forces for pressures, any size a point
    A = 0.5 * (A + A.T)
    try:
        normal, tangential = np.linalg.cholesky(A[:n, :n]), np.linalg.cholesky(A[n:, n:])
    except np.linalg.LinAlgError:
        return 0.0
    half = solve_triangular(normal, A[:n, n:], lower=True)
    coupling = solve_triangular(tangential, half.T, lower=True)
    gamma_sq = float(np.linalg.eigvalsh(coupling @ coupling.T)[-1])
    if gamma_sq <= 0.0:
        return float("inf")
    uncoupled = np.linalg.eigvalsh(A[:n, :n])[0] / np.linalg.eigvalsh(A[n:, n:])[-1]
    return float(np.sqrt(max(1.0 - gamma_sq, 0.0) / gamma_sq * uncoupled))


def other_solutions(problem: ContactProblem, known: Floats) -> Iterator[Floats]:
    """Solutions (m,) Pa that differ from the one `known` (m,), as far as starts from stick and slip lead to any.

    One that is found is a proof; none is no proof of there being none. Faces lie elsewhere in another one: what
    redundant points share is not asked.
    """
    least = DIFFERENT * np.abs(problem.free).max(initial=0.0)
    for solution in _attempts(problem):
        moved = problem.points.compliance @ (known - solution.traction)
        if solution.status == "solved" and np.abs(moved).max(initial=0.0) > least:
            yield solution.traction


def _attempts(problem: ContactProblem) -> Iterator[ContactSolution]:
    """Newton's method from all points stuck and all slipping one way or the other, and Lemke's where they are few."""
    n = problem.n_points
    for slip in (0, 1, -1):
        slips = np.full(n, slip, dtype=np.int64)
        closed = ActiveSet(np.ones(n, dtype=bool), slips, slips)
        yield solve_by_newton(problem, solve_active(problem, closed))
    if n > LEMKE_POINTS:
        return
    try:
        yield solve_by_lemke(problem)
    except NotSolvedError:  # the compliance has no inverse: Newton's attempts are all there are
        return


@dataclass(frozen=True, slots=True, eq=False)
class SecondSolution:
    """Another state that meets the contact law under the same loads and the same memory."""

    points: Ints  # (k,) contact points, those whose jump changes most first
    change: Floats  # (k,) m, how much farther or nearer the faces lie there, or how far along
    states: Ints  # (k,) OPEN, STICK or SLIP


def unique_text(case: Case) -> Iterator[str]:
    """What is known of the solutions of contact at every load factor of a case, in lines. Raises as a run does."""
    history = isinstance(case.loading, LoadHistory | Stages)
    if isinstance(case.loading, StrengthReduction):  # with the strength that it has
        case = replace(case, loading=LoadHistory(case.loading.factors))
    scene, cracks = make_scene(case), beginning(case).cracks
    in_turn = map(LoadsInTurn(scene, cracks).solution, range(case.n_loads)) if history else [load(scene, cracks)]
    for solution in in_turn:
        yield f"  at load factor {solution.factor:.6g}: {_found(solution)}"


def _found(solution: StepSolution) -> str:
    """What is known of the solutions of a loaded configuration."""
    contact, points = solution.configuration.contact, solution.outcome.points
    if why := why_not_examined(contact, points):
        return why
    assert points.problem is not None  # it is examined
    limit = friction_limit(points.problem.points.compliance, contact.weights[points.rows])
    if points.problem.friction.max() < limit:
        touching = "no faces touch: " if (points.state == OPEN).all() else ""
        return f"{touching}there is exactly one solution"
    second = second_solution(contact, solution.outcome)
    beyond = f"it is certain only where friction is below {limit:.2g}"
    if second is None:
        return f"no second solution was found, which is no proof that there is none: {beyond}"
    point = int(second.points[0])
    there = solution.cover.lattice.to_map(solution.configuration.faces.nodes.points[[point]])[0]
    place = solution.cover.surfaces[solution.configuration.faces.surface[point]].name
    return (
        f"friction leaves more than one solution ({beyond}): in another one the point {place_text(there, 4)} of "
        f"'{place}', which {WORDS[int(points.state[point])]}, {WORDS[int(second.states[0])]}, its faces moved by "
        f"{Metres(second.change[0]):.2g}; apply the loads in steps (loading.history), or lower the friction there"
    )


def why_not_examined(contact: ContactSystem, points: PointStates) -> str:
    """Why nothing is examined; empty otherwise. The bound takes supports of all rock, and a symmetric compliance."""
    if points.problem is None:
        return "no faces touch: there is exactly one solution"
    if contact.sparse:
        return f"not known: more than {MOST_CONDENSED:,} contact points are not examined"
    if points.problem.n_motions:
        return "not known: contact alone holds a piece of rock, which is not examined"
    if contact.law.dilation.any():
        return "not known: faces that dilate are not examined"
    if contact.law.bends.any():
        return "not known: faces whose friction or closure depends on the pressure are not examined"
    return "" if points.problem.friction.any() else "there is no friction: there is exactly one solution"


def second_solution(contact: ContactSystem, outcome: ContactOutcome) -> SecondSolution | None:
    """A second solution, if there is one and some start leads to it."""
    points = outcome.points
    problem, rows, n = points.problem, points.rows, len(contact.weights)
    if problem is None or points.solution is None:
        return None
    known = points.solution.traction
    for p in other_solutions(problem, known):
        states = active_set(problem, p, problem.jump(p)).states()
        whole = contact.law.breakable[rows] & ~outcome.memory.broken[rows]
        breaks = bool((whole & (states != STICK)).any())  # then it is one of another law, with lost cohesion
        gap = points.gap - contact.rock[:n, np.concatenate([rows, n + rows])] @ (p - known)
        gap[rows] = 0.0
        overlaps = gap.min() < -OVERLAP * np.abs(gap).max()  # at points that the solver did not have to deal with
        if not breaks and not overlaps:
            moved = problem.points.compliance @ (p - known)
            change = np.hypot(*moved.reshape(2, -1))
            order = np.argsort(-change, kind="stable")
            return SecondSolution(rows[order], change[order], states[order])
    return None
