"""The contact problem as a linear complementarity problem, solved by Lemke's method.

It is the LCP (17) of Li, Zheng, Guo 2017, after Zhu 1995, in a form free of the cancellation of the published one:
there the matrix is a difference of numbers of the size of the penalty stiffness; here the jump without traction,
free, and the compliance A (which may be rigid) are inverted instead. The method and its lexicographic rule are those of
Cottle, Pang, Stone, The Linear Complementarity Problem, chapter 4 (4.4, 4.9). Rows and columns are scaled beforehand,
which changes neither the problem nor its solutions (Ruiz 2001).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.linalg.blas import dger

from crackgrow.arrays import Floats, Ints
from crackgrow.contact.coulomb import SOLVED_RESIDUAL, active_set, complementarity_residual
from crackgrow.contact.equations import solve_active
from crackgrow.contact.points import UNSEEN
from crackgrow.contact.problem import ContactProblem, ContactSolution
from crackgrow.errors import NotSolvedError

SINGULAR: Final = 1e14  # condition number of the scaled compliance from which its inverse has no digits left
DETERMINATE: Final = 1e-8  # of the largest diagonal entry: less stiffness has a traction that balance alone gives
FALSE_RAY: Final = 1e-9  # a ray that ends with z0 below this part of max |q| has reached a solution
SCALINGS: Final = 20  # of rows and columns in turn; each halves the logarithms of what is left
PIVOT: Final = 1e-11  # entries below this part of the largest of their column are round-off, not pivots
TIE: Final = 1e-12  # ratios closer than this part of the largest basic value are ties


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


@dataclass(frozen=True, slots=True, eq=False)
class LcpResult:
    """End of Lemke's method for w = M z + q, w >= 0, z >= 0, w'z = 0."""

    z: Floats  # (n,) the solution, or the last basic point where the status is not "solved"
    w: Floats  # (n,) M z + q; zero where z is basic
    # "solved"; "limit": too many pivots; "ray": none found, and none exists for copositive-plus M; "inaccurate":
    # ended, but round-off left more than SOLVED_RESIDUAL
    status: str
    pivots: int


def lemke(M: Floats, q: Floats, d: Floats | None = None, max_pivots: int | None = None) -> LcpResult:
    """Solve the linear complementarity problem w = M z + q, w >= 0, z >= 0, w'z = 0 by Lemke's method.

    `M` (n, n), `q` (n,) and the positive covering vector `d` (n,), ones in the scaled rows by default; at most
    `max_pivots` pivots, 1000 + 20 n by default. Ties of the minimum ratio go to the artificial variable, else by the
    lexicographic rule, so that no degenerate problem cycles. The solution is computed anew from the final basis, and
    is "solved" only where every row holds to SOLVED_RESIDUAL of that row's own terms.
    """
    n = q.size
    limit = 1000 + 20 * n if max_pivots is None else max_pivots
    if n == 0 or q.min() >= 0.0:
        return LcpResult(np.zeros(n), q.copy(), "solved", 0)
    by_row, by_column = _scales(M, q)
    M, q, covering = by_row[:, None] * M * by_column, by_row * q, np.ones(n) if d is None else d * by_row
    table = _Tableau(M, q, covering)
    row, column, status = table.first_row(covering), n, "limit"
    for _ in range(limit):
        leaving = table.pivot(row, column)
        if leaving == 2 * n:
            status = "solved"
            break
        column = int(table.place[(leaving + n) % (2 * n)])
        row = table.leaving_row(column)
        if row < 0:
            status = "solved" if table.artificial() <= FALSE_RAY * np.abs(q).max() else "ray"
            break
    z, w = table.point()
    if status == "solved":
        z, w = _refactored(M, q, z, w, table.basic)
        status = "solved" if _violation(M, q, z) <= SOLVED_RESIDUAL else "inaccurate"
    return LcpResult(by_column * z, w / by_row, status, table.n_pivots)


def _scales(M: Floats, q: Floats) -> tuple[Floats, Floats]:
    """Powers of two (n,) for rows and columns with which the largest entries of these and of q are of order one.

    They are the square roots of the largest entries, taken in turn; q gives a row of zeros its scale.
    """
    with np.errstate(divide="ignore"):
        size, q_size = np.log2(np.abs(M)), np.log2(np.abs(q))
    row, column = np.zeros(q.size), np.zeros(q.size)
    for _ in range(SCALINGS):
        left = size + row[:, None] + column
        largest_of_row, largest_of_column = left.max(axis=1), left.max(axis=0)
        row -= 0.5 * np.where(np.isfinite(largest_of_row), largest_of_row, 0.0)
        column -= 0.5 * np.where(np.isfinite(largest_of_column), largest_of_column, 0.0)
    empty = ~np.isfinite(size).any(axis=1)
    row = np.where(empty & np.isfinite(q_size), -q_size, row)
    row -= (q_size + row).max()  # the largest of q
    column -= np.max(size + row[:, None] + column, initial=-np.inf, where=np.isfinite(size)) if not empty.all() else 0.0
    return np.exp2(np.rint(row)), np.exp2(np.rint(column))


def _refactored(M: Floats, q: Floats, z: Floats, w: Floats, basic: Ints) -> tuple[Floats, Floats]:
    """z and w of the final basis by a direct solve, where that is closer to a solution than the tableau's."""
    n = q.size
    J = np.sort(basic[(basic >= n) & (basic < 2 * n)]) - n
    exact = np.zeros(n)
    try:
        exact[J] = np.linalg.solve(M[np.ix_(J, J)], -q[J])
    except np.linalg.LinAlgError:
        return z, w
    exact_w = M @ exact + q
    exact_w[J] = 0.0
    return (exact, exact_w) if _violation(M, q, exact) <= _violation(M, q, z) else (z, w)


def _violation(M: Floats, q: Floats, z: Floats) -> float:
    """Worst violation by z (n,): z against its largest entry, every row of w = M z + q against its own terms."""
    terms = np.abs(M) @ np.abs(z) + np.abs(q)
    w = np.divide(M @ z + q, terms, out=np.zeros_like(q), where=terms > 0.0)
    largest = float(np.abs(z).max())
    return float(np.abs(np.minimum(z / largest if largest > 0.0 else z, w)).max())


class _Tableau:
    """Condensed tableau x_B + T x_N = value, where variables 0..n-1 are w, n..2n-1 are z, and 2n is z0.

    Columns of the inverse basis, which the lexicographic rule compares, are those of w in T (n, n+1) where w is
    nonbasic, else unit vectors.
    """

    def __init__(self, M: Floats, q: Floats, d: Floats) -> None:
        n = q.size
        self.T = np.asfortranarray(np.column_stack([-M, -d]))  # of which `dger` works in place
        self.value, self.n_pivots = q.copy(), 0
        self.basic = np.arange(n)  # variable of each row
        self.nonbasic = np.arange(n, 2 * n + 1)  # variable of each column
        self.place = np.concatenate([np.arange(n), np.arange(n + 1)])  # row or column of each variable

    def first_row(self, d: Floats) -> int:
        """Row that leaves when z0 enters: the most negative q/d, the last one of ties (lexicographic)."""
        ratio = self.value / d
        return int(np.flatnonzero(ratio <= ratio.min() + TIE * np.abs(ratio).max())[-1])

    def leaving_row(self, column: int) -> int:
        """Row of the lexicographic minimum ratio for an entering column; -1 where it may grow without end (a ray)."""
        entries = self.T[:, column]
        rows = np.flatnonzero(entries > PIVOT * max(1.0, float(np.abs(entries).max())))
        if rows.size == 0:
            return -1
        ratio = np.maximum(self.value[rows], 0.0) / entries[rows]
        rows = rows[ratio <= ratio.min() + TIE * max(1.0, float(self.value.max()))]
        artificial = rows[self.basic[rows] == 2 * self.value.size]
        if artificial.size:
            return int(artificial[0])
        return int(rows[0]) if rows.size == 1 else self._lexicographic(rows, entries)

    def pivot(self, row: int, column: int) -> int:
        """Exchange the variables of a row and a column; return the variable that left the basis."""
        u, v = self.T[:, column].copy(), self.T[row].copy()
        pivot = float(u[row])
        step = self.value[row] / pivot
        self.value -= step * u
        self.value[row] = step
        left, right = u.copy(), v / pivot
        left[row], right[column] = 0.0, 0.0
        self.T = dger(-1.0, left, right, a=self.T, overwrite_a=1)
        self.T[row], self.T[:, column] = v / pivot, -u / pivot
        self.T[row, column] = 1.0 / pivot
        entering, leaving = int(self.nonbasic[column]), int(self.basic[row])
        self.basic[row], self.nonbasic[column] = entering, leaving
        self.place[entering], self.place[leaving] = row, column
        self.n_pivots += 1
        return leaving

    def artificial(self) -> float:
        """Value of z0."""
        n = self.value.size
        return float(self.value[self.basic == 2 * n].sum())

    def point(self) -> tuple[Floats, Floats]:
        """z (n,) and w (n,) of the basis."""
        n = self.value.size
        x = np.zeros(2 * n + 1)
        x[self.basic] = np.maximum(self.value, 0.0)
        return x[n : 2 * n], x[:n]

    def _lexicographic(self, rows: Ints, entries: Floats) -> int:
        n = self.value.size
        for w in range(n):
            place = int(self.place[w])
            is_basic = place < n and self.basic[place] == w
            inverse = (rows == place).astype(np.float64) if is_basic else self.T[rows, place]
            ratio = inverse / entries[rows]
            rows = rows[ratio <= ratio.min() + TIE * max(1.0, float(np.abs(ratio).max()))]
            if rows.size == 1:
                break
        return int(rows[0])
