"""The contact problem of many points, most of which stick, condensed once more: to the loose ones, which may not.

A W^-1 = L L' is factorized once for all active sets. With C = W A^-1, symmetric, and jumps du_l of the loose points

    W p = C (free + B a - du_l),    so that    du_l = S ((C (free + B a))_l - W p_l),    S = (C_ll)^-1,

and the places a follow from F p = pull as far as stuck points hold them: a contact problem of the loose points, of the
same form. Columns of L^-1, whose products C is made of, are found as points are asked for that do not stick, and kept.
Round-off of all that is made good by what the jumps of the unknowns miss.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.compiled import solve_upper
from crackgrow.contact.coulomb import ActiveSet, active_set, shear_bound
from crackgrow.contact.equations import solve_active
from crackgrow.contact.newton import ROUND_OFF, residual_floor, solve_by_newton
from crackgrow.contact.problem import CondensedPoints, ContactProblem, ContactSolution

HELD: Final = 1e-10  # of the stiffness that all points have against a motion: stuck ones with less do not hold it
MANY: Final = 500  # points, from which on this takes less time than Newton's steps with all of them
MOST_LOOSE: Final = 0.5  # of the points: with more it does not
AT_ONCE: Final = 128  # columns that are found together
GAIN: Final = 0.5  # corrections that leave more of what jumps miss end


class StuckPoints:
    """Contact points that all stick, factorized."""

    def __init__(self, points: CondensedPoints) -> None:
        self.points = points
        self._lower, info = dpotrf((points.compliance / points.weights).T, lower=1, overwrite_a=1)
        self.definite = info == 0
        self._last: LoosePoints | None = None
        self._place = np.full(len(points.scale), -1)  # of each row among the columns of L^-1 that are known
        self.columns, self.products = np.zeros((len(points.scale), 0)), np.zeros((0, 0))
        if self.definite:
            self._add(self.half(points.jump))

    @classmethod
    def of(cls, points: CondensedPoints) -> StuckPoints:
        """Those of some points, which are factorized once."""
        known: StuckPoints | None = points.__dict__.get("stuck")
        return known or points.__dict__.setdefault("stuck", cls(points))

    def among(self, loose: Bools) -> LoosePoints:
        """The points `loose` (n,) among the others; the last ones are kept."""
        if self._last is None or not np.array_equal(self._last.loose, loose):
            self._last = LoosePoints(self, loose)
        return self._last

    def half(self, right: Floats) -> Floats:
        """L^-1 times the columns `right` (2 n, k)."""
        found = np.array(right, order="C")
        solve_upper(self._lower.T, found, True)
        return found

    def tractions(self, jumps: Floats) -> Floats:
        """Tractions (2 n,) Pa that make jumps (2 n,) m."""
        return np.asarray(dpotrs(self._lower, jumps, lower=1)[0] / self.points.weights)

    def columns_of(self, rows: Ints) -> Ints:
        """Which columns are those of L^-1 at some ascending rows (k,)."""
        new = rows[self._place[rows] < 0]
        if len(new):
            self._place[new] = self.columns.shape[1] + np.arange(len(new))
            more = np.zeros((len(self._place), len(new)))
            more[new, np.arange(len(new))] = 1.0
            for start in range(0, len(new), AT_ONCE):
                from_here = slice(new[start], None)  # above there is nothing
                some = slice(start, start + AT_ONCE)
                solve_upper(self._lower.T[from_here, from_here], more[from_here, some], True)
            self._add(more)
        return self._place[rows]

    def _add(self, more: Floats) -> None:
        """Add columns (2 n, k) to those that are known, and their products with all."""
        across = self.columns.T @ more
        self.products = np.block([[self.products, across], [across.T, more.T @ more]])
        self.columns = np.hstack([self.columns, more])


class LoosePoints:
    """Some of the points among others that stick."""

    def __init__(self, stuck: StuckPoints, loose: Bools) -> None:
        self.loose, self.rows = loose, np.flatnonzero(np.tile(loose, 2))
        self._columns, n_motions = stuck.columns_of(self.rows), stuck.points.jump.shape[1]
        self._softness = _inverse(stuck.products[np.ix_(self._columns, self._columns)])
        self._moved = self._softness @ stuck.products[self._columns, :n_motions]
        stiff = stuck.products[:n_motions, :n_motions]
        scale = np.where(stiff.diagonal() > 0.0, stiff.diagonal(), 1.0) ** -0.5
        left = scale[:, None] * (stiff - stuck.products[:n_motions, self._columns] @ self._moved) * scale
        sizes, ways = np.linalg.eigh(left)
        held, ways = sizes > HELD, scale[:, None] * ways
        self._held, self._free = (ways[:, held] / sizes[held]) @ ways[:, held].T, ways[:, ~held]
        weights, jump = stuck.points.weights[self.rows], self._moved @ self._free
        compliance = (self._softness + self._moved @ self._held @ self._moved.T) * weights
        self.points = CondensedPoints(compliance, jump, (jump * weights[:, None]).T, weights)

    def improved(
        self, stuck: StuckPoints, problem: ContactProblem, x: Floats, jump: Floats, active: ActiveSet | None
    ) -> tuple[Floats, Floats, int]:
        """Unknowns x (2 n + l,) for which the loose points fulfil the law better, with the jumps (2 n,) that they are
        meant to have, before and after; on the branches of an `active` set, or on those that Newton's method finds.

        Also the iterations that it took; -1 if it has found none.
        """
        rows, k, n_motions, p = self.rows, len(self.rows), problem.n_motions, x[: len(jump)]
        miss, pull = problem.jump(x) - jump, problem.pull - problem.points.force @ p
        half = stuck.half(miss[:, None])[:, 0]
        known = stuck.columns.T @ half
        pull = pull - known[:n_motions] + self._moved.T @ known[self._columns]
        free = self._softness @ known[self._columns] + self._moved @ self._held @ pull
        law = {name: getattr(problem, name)[self.loose] for name in ("friction", "cohesion", "dilation", "slipped")}
        part = replace(
            problem,
            points=self.points,
            free=jump[rows] + self.points.compliance @ p[rows] + free,
            pull=self.points.force @ p[rows] + self._free.T @ pull,
            **law,
        )
        if active is not None:
            here = ActiveSet(active.closed[self.loose], active.slip[self.loose], active.sense[self.loose])
            there, iterations = solve_active(part, here), 0
        elif not k:
            there, iterations = np.zeros(part.n_motions), 0
        else:
            found = solve_by_newton(part, np.append(p[rows], np.zeros(part.n_motions)))
            there, iterations = found.unknowns, found.iterations if found.status == "solved" else -1
        change = self.points.weights * (there[:k] - p[rows])
        motion = self._held @ (pull - self._moved.T @ change) + self._free @ there[k:]
        meant = np.zeros(len(jump))
        meant[rows] = part.jump(there)
        p = p + stuck.tractions(miss + problem.points.jump @ motion - meant + jump)
        p[rows] = there[:k]
        return np.append(p, x[len(jump) :] + motion), meant, iterations


def solve_among_stuck(
    problem: ContactProblem, start: Floats | None = None, active: ActiveSet | None = None
) -> ContactSolution | None:
    """The solution of a problem of many points, or that on the branches of an `active` set; loose pieces are settled.

    Points are loose that do not stick at the `start` (2 n + l,), and those that leave the others from then on, each
    with the next ones. None where most points are loose, or this leads to nothing; also where faces that have slipped
    dilate, whose opening while they stick is known by the sense of that slip alone.
    """
    if (problem.dilation * problem.slipped).any():
        return None
    (lying, unknowns), n = problem.settled(), problem.n_points
    stuck, x, loose, iterations = StuckPoints.of(lying.points), np.zeros(2 * n + problem.n_motions), ~problem.resists, 0
    if start is not None:
        x = np.append(start[: 2 * n], 2.0 * start[2 * n :] - unknowns(start)[2 * n :])
        loose |= (x[:n] >= 0.0) | (np.abs(x[n : 2 * n]) >= shear_bound(problem, x[:n]))
    if active is not None:
        loose |= _not_stuck(active)
    meant = np.where(np.tile(loose, 2), lying.jump(x), 0.0)
    last = np.inf
    while stuck.definite and loose.mean() <= MOST_LOOSE:
        x, meant, more = stuck.among(loose).improved(stuck, lying, x, meant, active)
        iterations, jump = iterations + abs(more), lying.jump(x)
        now = active or active_set(lying, x[: 2 * n], jump)
        leaving = _not_stuck(now) & ~loose
        if leaving.any():
            loose = loose | leaving | np.append(leaving[1:], False) | np.append(False, leaving[:-1])
            last = np.inf
            continue
        left = float(np.abs((jump - meant) / lying.points.scale).max()) / float(np.abs(x[: 2 * n]).max() or 1.0)
        if more >= 0 and (left <= ROUND_OFF or GAIN * last < left <= residual_floor(lying)):
            return ContactSolution(x[: 2 * n], "solved", iterations, now.states(), unknowns(x)[2 * n :])
        if more < 0 or not left <= GAIN * last:  # nan is not
            break
        last = left
    return None


def _not_stuck(active: ActiveSet) -> Bools:
    """Which points (n,) are open or slip."""
    return np.asarray(~active.closed | (active.slip != 0))


def _inverse(matrix: Floats) -> Floats:
    """The inverse of a symmetric matrix (k, k) that is positive definite."""
    if not len(matrix):
        return matrix
    lower = np.tril(dpotri(dpotrf(matrix, lower=1)[0], lower=1)[0])
    return np.asarray(lower + np.tril(lower, -1).T)
