"""Lemke's method for linear complementarity problems, and the contact problem in that form.

The method and its lexicographic rule are those of Cottle, Pang, Stone, The Linear Complementarity Problem, chapter
4 (4.4, 4.9). The contact problem is the LCP (17) of Li, Zheng, Guo 2017, after Zhu 1995, in a form free of the
cancellation of the published one: there the matrix is a difference of numbers of the size of the penalty
stiffness; here the jump without traction, free, and the compliance A (which may be rigid) are inverted instead.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from crackgrow.contact.coulomb import (
    SOLVED_RESIDUAL,
    ContactProblem,
    ContactSolution,
    Floats,
    Ints,
    active_set,
    complementarity_residual,
    solve_active,
)
from crackgrow.errors import SolveError

FALSE_RAY: Final = 1e-9  # a ray that ends with z0 below this part of max |q| has reached a solution
PIVOT: Final = 1e-11  # entries below this part of the largest of their column are round-off, not pivots
TIE: Final = 1e-12  # ratios closer than this part of the largest basic value are ties
SINGULAR: Final = 1e14  # condition number of the scaled compliance from which its inverse has no digits left
BLOCK: Final = 48  # rank-1 updates collected before one matrix product applies them


@dataclass(frozen=True, slots=True, eq=False)
class _ContactLcp:
    """LCP (17) of a contact problem in scaled variables: lambda = size z / root, v = size root w."""

    M: Floats  # (k, k) with unit diagonal where friction does not couple: k = 3 n, or n without friction
    q: Floats  # (k,)
    d: Floats  # (k,) covering vector
    root: Floats  # (k,) sqrt(Pa/m)
    size: float  # sqrt(Pa m)


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

    `M` (n, n), `q` (n,) and the positive covering vector `d` (n,), ones by default, should be scaled to order one.
    Ties of the minimum ratio go to the artificial variable, else by the lexicographic rule, so that no degenerate
    problem cycles. The solution is computed anew from the final basis. Raises SolveError for wrong shapes, values
    that are not finite and entries of d that are not positive.
    """
    M, q, d = _checked(M, q, d)
    n = q.size
    limit = 1000 + 20 * n if max_pivots is None else max_pivots
    if n == 0 or q.min() >= 0.0:
        return LcpResult(np.zeros(n), q.copy(), "solved", 0)
    table = _Table(M, q, d)
    row, column, status = table.first_row(d), n, "limit"
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
        scale = max(float(np.abs(q).max()), float(np.abs(M).max() * z.max()))
        status = "solved" if _violation(M, q, z) <= SOLVED_RESIDUAL * scale else "inaccurate"
    return LcpResult(z, w, status, table.n_pivots)


def solve_by_lemke(problem: ContactProblem, max_pivots: int | None = None) -> ContactSolution:
    """Tractions of the contact problem by Lemke's method; for comparison and as a second opinion on Newton's.

    Status "solved", "limit", "ray", or "inaccurate" where the tractions violate the law by more than
    SOLVED_RESIDUAL. The active set that Lemke ends with is solved once more for the tractions themselves.
    Raises SolveError where the compliance is singular (rigid contact at more points than the displacement follows).
    """
    lcp = _contact_lcp(problem)
    result = lemke(lcp.M, lcp.q, lcp.d, max_pivots)
    p, du = _tractions(problem, lcp.size * result.z / lcp.root, lcp.size * lcp.root * result.w)
    active = active_set(problem, p, du)
    polished = solve_active(problem, active)
    residual, polished_residual = (complementarity_residual(problem, x) for x in (p, polished))
    if polished_residual <= residual:
        p, residual = polished, polished_residual
    status = result.status
    if status in ("solved", "inaccurate"):
        status = "solved" if residual <= SOLVED_RESIDUAL else "inaccurate"
    return ContactSolution(p, status, result.pivots, active.states())


def _contact_lcp(problem: ContactProblem) -> _ContactLcp:
    """The LCP v = M lambda + q of (17), v = -f, in the form M = m_c' A^-1 m_g, q = -C - m_c' A^-1 free.

    Per point lambda = (slip +, slip -, opening) and, with c the cohesion,
    f = (p_t + friction p_n - c, -p_t + friction p_n - c, p_n); blocks of n rows in this order. The covering vector
    has d_t >= friction d_n: with ones Lemke ends in a ray for most problems with friction above one.
    """
    n = problem.n_points
    inverse = _inverse(problem.compliance)
    stuck = inverse @ problem.free  # tractions with every point closed and sticking
    root = np.sqrt(np.abs(inverse.diagonal()))
    if problem.friction is None or problem.cohesion is None:
        return _scaled(inverse, -stuck, root, root)
    cross = problem.friction[:, None] * inverse[:n]
    rows = np.vstack([inverse[n:] + cross, cross - inverse[n:], inverse[:n]])  # m_c' A^-1
    M = np.hstack([rows[:, n:], -rows[:, n:], rows[:, :n]])
    limit = problem.cohesion - problem.friction * stuck[:n]
    q = np.concatenate([limit - stuck[n:], limit + stuck[n:], -stuck[:n]])
    root_n, root_t = root[:n], root[n:]
    d_t = (1.0 + problem.friction) * np.maximum(root_n, root_t)
    return _scaled(M, q, np.concatenate([d_t, d_t, root_n]), np.concatenate([root_t, root_t, root_n]))


def _inverse(A: Floats) -> Floats:
    root = np.sqrt(A.diagonal())
    scaled = A / np.outer(root, root)
    try:
        inverse: Floats = np.asarray(np.linalg.inv(scaled), dtype=np.float64)
    except np.linalg.LinAlgError:
        inverse = np.full_like(A, np.inf)
    condition = float(np.abs(scaled).sum(axis=0).max(initial=0.0) * np.abs(inverse).sum(axis=0).max(initial=0.0))
    if condition > SINGULAR:
        raise SolveError(
            f"contact compliance: condition number is {condition:.1e}, at most {SINGULAR:.0e} can be inverted for "
            f"Lemke's method: use fewer contact points, a finite contact stiffness or the Newton solver"
        )
    inverse /= np.outer(root, root)
    return inverse


def _scaled(M: Floats, q: Floats, d: Floats, root: Floats) -> _ContactLcp:
    """Scale rows and columns so that the diagonal of M and the largest |q| are of order one."""
    size = float(np.abs(q / root).max(initial=0.0)) or 1.0
    return _ContactLcp(M / np.outer(root, root), q / (root * size), d / root, root, size)


def _tractions(problem: ContactProblem, slip_opening: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Tractions and jump (m,) of the variables of the LCP, both without subtracting large numbers."""
    n = problem.n_points
    if problem.friction is None:
        return -v, slip_opening
    p = np.concatenate([-v[2 * n :], (v[n : 2 * n] - v[:n]) / 2.0])
    return p, np.concatenate([slip_opening[2 * n :], slip_opening[:n] - slip_opening[n : 2 * n]])


class _Table:
    """Condensed tableau x_B + T x_N = value, where variables 0..n-1 are w, n..2n-1 are z, and 2n is z0.

    T (n, n+1) is kept as base - U V, the product collecting the latest pivots. Columns of the inverse basis, which
    the lexicographic rule compares, are those of w where w is nonbasic, else unit vectors.
    """

    def __init__(self, M: Floats, q: Floats, d: Floats) -> None:
        n = q.size
        self.base = np.column_stack([-M, -d])
        self.value = q.copy()
        self.U, self.V = np.zeros((n, BLOCK)), np.zeros((BLOCK, n + 1))
        self.n_pending, self.n_pivots = 0, 0
        self.basic = np.arange(n)  # variable of each row
        self.nonbasic = np.arange(n, 2 * n + 1)  # variable of each column
        self.place = np.concatenate([np.arange(n), np.arange(n + 1)])  # row or column of each variable

    def first_row(self, d: Floats) -> int:
        """Row that leaves when z0 enters: the most negative q/d, the last one of ties (lexicographic)."""
        ratio = self.value / d
        return int(np.flatnonzero(ratio <= ratio.min() + TIE * np.abs(ratio).max())[-1])

    def leaving_row(self, column: int) -> int:
        """Row of the lexicographic minimum ratio for an entering column; -1 where it may grow without end (a ray)."""
        entries = self._column(column)
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
        u, v = self._column(column), self._row(row)
        pivot = float(u[row])
        step = self.value[row] / pivot
        self.value -= step * u
        self.value[row] = step
        self.U[row], self.V[:, column] = 0.0, 0.0
        self.base[row], self.base[:, column] = v / pivot, -u / pivot
        self.base[row, column] = 1.0 / pivot
        u[row], v[column] = 0.0, 0.0
        self.U[:, self.n_pending], self.V[self.n_pending] = u, v / pivot
        self.n_pending += 1
        if self.n_pending == BLOCK:
            self._apply()
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
            inverse = (rows == place).astype(np.float64) if is_basic else self._column(place, rows)
            ratio = inverse / entries[rows]
            rows = rows[ratio <= ratio.min() + TIE * max(1.0, float(np.abs(ratio).max()))]
            if rows.size == 1:
                break
        return int(rows[0])

    def _column(self, column: int, rows: Ints | slice = slice(None)) -> Floats:
        k = self.n_pending
        entries: Floats = self.base[rows, column] - self.U[rows, :k] @ self.V[:k, column]
        return entries

    def _row(self, row: int) -> Floats:
        k = self.n_pending
        entries: Floats = self.base[row] - self.U[row, :k] @ self.V[:k]
        return entries

    def _apply(self) -> None:
        self.base -= self.U @ self.V
        self.U[:], self.V[:], self.n_pending = 0.0, 0.0, 0


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
    return float(np.abs(np.minimum(z, M @ z + q)).max())


def _checked(M: Floats, q: Floats, d: Floats | None) -> tuple[Floats, Floats, Floats]:
    M, q = np.asarray(M, dtype=np.float64), np.asarray(q, dtype=np.float64)
    d = np.ones(q.size) if d is None else np.asarray(d, dtype=np.float64)
    for name, value, shape in (("M", M, (q.size, q.size)), ("q", q, (q.size,)), ("d", d, (q.size,))):
        if value.shape != shape or not np.isfinite(value).all():
            raise SolveError(f"lemke {name}: shape {value.shape}, must be {shape} with finite values only")
    if d.size and d.min() <= 0.0:
        raise SolveError(f"lemke d: least entry is {d.min():.6g}, must be positive")
    return M, q, d
