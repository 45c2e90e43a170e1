"""The contact problem as a linear complementarity problem, solved by Lemke's method.

It is the LCP (17) of Li, Zheng, Guo 2017, after Zhu 1995, in a form free of the cancellation of the published one:
there the matrix is a difference of numbers of the size of the penalty stiffness; here the jump without traction,
free, and the compliance A (which may be rigid) are inverted instead.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.contact.coulomb import SOLVED_RESIDUAL, active_set, complementarity_residual
from crackgrow.contact.equations import solve_active
from crackgrow.contact.lemke import lemke
from crackgrow.contact.problem import UNSEEN, ContactProblem, ContactSolution
from crackgrow.errors import NotSolvedError

SINGULAR: Final = 1e14  # condition number of the scaled compliance from which its inverse has no digits left
DETERMINATE: Final = 1e-8  # of the largest diagonal entry: less stiffness has a traction that balance alone gives


def solve_by_lemke(problem: ContactProblem) -> ContactSolution:
    """Tractions of the contact problem by Lemke's method; for comparison and as a second opinion on Newton's.

    Status "solved", "limit", "ray", or "inaccurate" where the tractions violate the law by more than
    SOLVED_RESIDUAL. The active set that Lemke ends with is solved once more for the tractions themselves.
    Raises NotSolvedError where the compliance is singular (rigid contact at more points than the displacement follows).
    """
    M, q, d, root = _contact_lcp(problem)
    size = float(np.abs(q / root).max(initial=0.0)) or 1.0
    result = lemke(M / np.outer(root, root), q / (root * size), d / root)  # entries of order one
    p, du = _tractions(problem, size * result.z / root, size * root * result.w)
    left = du - problem.free + problem.points.compliance @ p
    motion = np.linalg.lstsq(problem.points.jump, left)[0] if problem.n_motions else np.zeros(0)
    active = active_set(problem, p, du)
    x, polished = np.append(p, motion), solve_active(problem, active)
    residual, polished_residual = (complementarity_residual(problem, each) for each in (x, polished))
    if polished_residual <= residual:
        x, residual = polished, polished_residual
    held = residual <= SOLVED_RESIDUAL  # of large problems round-off makes a ray where the law holds
    status = "solved" if held else "inaccurate" if result.status == "solved" else result.status
    m = problem.free.size
    return ContactSolution(x[:m], status, result.pivots, active.states(), x[m:])


def _contact_lcp(problem: ContactProblem) -> tuple[Floats, Floats, Floats, Floats]:
    """M, q of the LCP v = M lambda + q of (17), v = -f, its covering vector d, sqrt(|M_ii|) where nothing couples.

    In the form M = m_c' A^-1 m_g, q = -C - m_c' A^-1 free.

    Per point lambda = (slip +, slip -, opening) and, with c the cohesion,
    f = (p_t + friction p_n - c, -p_t + friction p_n - c, p_n); blocks of n rows in this order. Slip opens by dilation,
    back towards where the faces have come from it closes: as long as it does not pass that place. The covering vector
    has d_t >= friction d_n: with ones Lemke ends in a ray for most problems with friction above one. With rigid motions
    A^-1 is what stuck points need for their jumps where these motions are free, and they carry the pull of the loads.
    """
    n = problem.n_points
    inverse, carried = _inverse(problem)
    size = np.abs(inverse.diagonal())
    root = np.sqrt(np.maximum(size, DETERMINATE * size.max(initial=0.0)))
    opened, per_slip = _dilation(problem)
    # tractions with every point closed and sticking
    stuck = carried + inverse @ (problem.free - np.append(opened, np.zeros(n)))
    cross = problem.friction[:, None] * inverse[:n]
    rows = np.vstack([inverse[n:] + cross, cross - inverse[n:], inverse[:n]])  # m_c' A^-1
    M = np.hstack([rows[:, n:] + rows[:, :n] * per_slip[0], rows[:, :n] * per_slip[1] - rows[:, n:], rows[:, :n]])
    limit = problem.cohesion - problem.friction * stuck[:n]
    q = np.concatenate([limit - stuck[n:], limit + stuck[n:], -stuck[:n]])
    root_n, root_t = root[:n], root[n:]
    d_t = (1.0 + problem.friction) * np.maximum(root_n, root_t)
    return M, q, np.concatenate([d_t, d_t, root_n]), np.concatenate([root_t, root_t, root_n])


def _dilation(problem: ContactProblem) -> tuple[Floats, tuple[Floats, Floats]]:
    """What dilation has opened before (n,) m, and what it opens (n,) per slip + and per slip - from there on."""
    before = problem.slipped
    senses = (np.where(before < 0.0, -1.0, 1.0), np.where(before > 0.0, -1.0, 1.0))
    return problem.dilation * np.abs(before), (problem.dilation * senses[0], problem.dilation * senses[1])


def _inverse(problem: ContactProblem) -> tuple[Floats, Floats]:
    """A^-1 (m, m), and tractions (m,) that balance what pulls at rigid motions; without these A^-1 is the inverse.

    With motions they are parts of the inverse of [[A, -B], [F, 0]], of motions that points see at all.
    """
    A, points, m = problem.points.compliance, problem.points, problem.free.size
    root = np.sqrt(A.diagonal())
    scaled, last = A / np.outer(root, root), np.zeros(0)
    if problem.n_motions:
        _, sizes, seen = np.linalg.svd(points.jump / root[:, None], full_matrices=False)
        seen = seen[sizes > UNSEEN * sizes.max(initial=0.0)]
        jump, force = (points.jump @ seen.T) / root[:, None], (seen @ points.force) / root
        size = np.abs(force).max(axis=1)
        scaled = np.block(
            [[scaled, -jump / np.abs(jump).max(axis=0)], [force / size[:, None], np.zeros((len(seen),) * 2)]]
        )
        last = (seen @ problem.pull) / size
    try:
        inverse: Floats = np.asarray(np.linalg.inv(scaled), dtype=np.float64)
    except np.linalg.LinAlgError:
        inverse = np.full_like(scaled, np.inf)
    condition = float(np.abs(scaled).sum(axis=0).max(initial=0.0) * np.abs(inverse).sum(axis=0).max(initial=0.0))
    if condition > SINGULAR:
        raise NotSolvedError(
            f"contact compliance: condition number is {condition:.1e}, at most {SINGULAR:.0e} can be inverted for "
            f"Lemke's method: use fewer contact points, a finite contact stiffness or the Newton solver"
        )
    return inverse[:m, :m] / np.outer(root, root), inverse[:m, m:] @ last / root


def _tractions(problem: ContactProblem, slip_opening: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Tractions and jump (m,) of the variables of the LCP, both without subtracting large numbers."""
    n = problem.n_points
    p = np.concatenate([-v[2 * n :], (v[n : 2 * n] - v[:n]) / 2.0])
    opened, per_slip = _dilation(problem)
    forward, backward, gap = slip_opening.reshape(3, n)
    return p, np.concatenate([gap + opened + per_slip[0] * forward + per_slip[1] * backward, forward - backward])
