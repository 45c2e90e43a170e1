"""Whether Coulomb friction leaves the contact problem with one solution.

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
from typing import Final

import numpy as np
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dpotrf, dpotrs

from crackgrow.arrays import Floats
from crackgrow.contact.contact_lcp import solve_by_lemke
from crackgrow.contact.coulomb import ActiveSet
from crackgrow.contact.newton import solve_active, solve_by_newton
from crackgrow.contact.problem import ContactProblem, ContactSolution
from crackgrow.errors import NotSolvedError

DIFFERENT: Final = 1e-6  # jumps that differ by more, relative to the largest free one, are two solutions
INVERSE_ITERATIONS: Final = 10  # for an estimate of an eigenvalue
NEARLY: Final = 0.8  # of that estimate: what the eigenvalue is proven to exceed
LEMKE_POINTS: Final = 300  # of more, Lemke's method would cost several times what everything else of a step does
ITERATIONS: Final = 40  # of Newton's method from a start that is but one of several


def friction_limit(compliance: Floats, weights: Floats) -> float:
    """Friction below which the contact problem has exactly one solution, by the bound above; infinity uncoupled.

    `compliance` (2 n, 2 n) m/Pa has normal and tangential rows of all points, and is symmetric once weighed with the
    points' lengths `weights` (n,). Zero where it is not positive definite.
    """
    n = len(weights)
    if n == 0:
        return float("inf")
    A = _normalised(compliance, weights)
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


def below_friction_limit(friction: float, compliance: Floats, weights: Floats) -> bool:
    """Whether `friction` is certainly below `friction_limit`: proven by three Cholesky factorizations, or not known.

    The least eigenvalue of A_nn exceeds a number if A_nn less that on its diagonal is positive definite, the largest of
    A_tt is at most its largest sum of a row, and gamma is less than g if A with diagonal blocks g A_nn and g A_tt is.
    """
    n = len(weights)
    if n == 0:
        return True
    A = _normalised(compliance, weights)
    least = NEARLY * _least_eigenvalue(A[:n, :n])
    if least <= 0.0 or dpotrf((A[:n, :n] - least * np.eye(n)).T, overwrite_a=True)[1]:
        return False
    largest = float(np.abs(A[n:, n:]).sum(axis=0).max())
    g = np.sqrt(least / (least + friction**2 * largest))
    A[:n, :n] *= g
    A[n:, n:] *= g
    return not dpotrf(A.T, overwrite_a=True)[1]


def _normalised(compliance: Floats, weights: Floats) -> Floats:
    """The symmetric A (2 n, 2 n) without a unit: forces for pressures, and any size a point, the same for its rows."""
    n = len(weights)
    root = np.tile(np.sqrt(weights), 2)
    size = np.tile(np.sqrt(compliance.diagonal()[:n]), 2)
    A: Floats = compliance * (root / size)[:, None]
    A /= root * size
    A += A.T.copy()
    A *= 0.5
    return A


def _least_eigenvalue(A: Floats) -> float:
    """An estimate from above by inverse iteration; zero where A (n, n) is not positive definite."""
    factor, failed = dpotrf(A, lower=True)
    if failed:
        return 0.0
    v = np.random.default_rng(0).normal(size=len(A))
    for _ in range(INVERSE_ITERATIONS):
        v /= np.linalg.norm(v)
        previous, v = v, dpotrs(factor, v, lower=True)[0]
    return 1.0 / float(previous @ v)


def other_solutions(problem: ContactProblem, known: Floats) -> Iterator[Floats]:
    """Solutions (m,) Pa that differ from the one `known` (m,), as far as starts from stick and slip lead to any.

    One that is found is a proof; none is no proof of there being none.
    """
    for solution in _attempts(problem):
        if solution.status == "solved" and _differ(problem, known, solution.traction):
            yield solution.traction


def _attempts(problem: ContactProblem) -> Iterator[ContactSolution]:
    """Newton's method from all points stuck and all slipping one way or the other, and Lemke's where they are few."""
    n = problem.n_points
    for slip in (0, 1, -1):
        closed = ActiveSet(np.ones(n, dtype=bool), np.full(n, slip, dtype=np.int64))
        yield solve_by_newton(problem, solve_active(problem, closed), ITERATIONS)
    yield solve_by_newton(problem)
    if n > LEMKE_POINTS:
        return
    try:
        yield solve_by_lemke(problem)
    except NotSolvedError:  # the compliance has no inverse: Newton's attempts are all there are
        return


def _differ(problem: ContactProblem, p: Floats, q: Floats) -> bool:
    """Whether faces lie elsewhere under tractions p than under q (m,): what redundant points share is not asked."""
    change = np.abs(problem.compliance @ (p - q)).max(initial=0.0)
    return bool(change > DIFFERENT * np.abs(problem.free).max(initial=0.0))
