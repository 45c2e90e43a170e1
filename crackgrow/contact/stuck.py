"""The contact problem of many points, most of which stick, condensed once more: to the loose ones, which may not.

C = W A^-1, symmetric, serves all active sets: by a Cholesky factor of A W^-1 = L L' or, where there are very many
points, by that of rock whose faces are tied. With jumps du_l of the loose points

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
from scipy.sparse import csr_array, vstack

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.compiled import solve_upper
from crackgrow.contact.coulomb import ActiveSet, active_set, shear_bound
from crackgrow.contact.equations import solve_active
from crackgrow.contact.newton import ROUND_OFF, residual_floor, solve_by_newton
from crackgrow.contact.points import CondensedPoints, RockPoints
from crackgrow.contact.problem import ContactProblem, ContactSolution
from crackgrow.contact.sparse_points import SparsePoints
from crackgrow.errors import NotSolvedError, SolveError
from crackgrow.linear import mirror

HELD: Final = 1e-10  # of the squares of jumps that all points see of a motion: stuck ones with less do not hold it
MANY: Final = 500  # points, from which on this takes less time than Newton's steps with all of them
MOST_LOOSE: Final = 0.5  # of the points: with more it does not
MOST_LOOSE_POINTS: Final = 10_000  # where faces are tied: their compliance takes 3.2 GB, and Newton's method as much
AT_ONCE: Final = 128  # columns that are found together
ILL_DEFINED: Final = 1e-6  # of the largest traction: what those of points with next to no length may be uncertain by
GAIN: Final = 0.5  # corrections that leave more of what jumps miss end


class StuckPoints:
    """Contact points that all stick: C = W A^-1, by which jumps make forces."""

    def __init__(self, points: RockPoints) -> None:
        self.points = points
        self._last: LoosePoints | None = None

    @staticmethod
    def of(points: RockPoints) -> StuckPoints:
        """Those of some points, which are factorized once. Raises SolveError where they have no factors."""
        known: StuckPoints | None = points.__dict__.get("stuck")
        if known is None:
            known = TiedPoints(points) if isinstance(points, SparsePoints) else FactorizedPoints(points)
            points.__dict__["stuck"] = known
        return known

    def among(self, loose: Bools) -> LoosePoints:
        """The points `loose` (n,) among the others; the last ones are kept."""
        if self._last is None or not np.array_equal(self._last.loose, loose):
            self._last = None  # it is large
            self._last = LoosePoints(self, loose)
        return self._last

    def forces(self, jumps: Floats) -> Floats:
        """C du (2 n,) N/m, the forces that make jumps (2 n,) m."""
        raise NotImplementedError

    def floor(self, problem: ContactProblem) -> float:
        """What tractions may miss in the end, of the largest."""
        return residual_floor(problem)

    def exact(self, problem: ContactProblem, x: Floats, meant: Floats) -> Floats:
        """The unknowns (2 n + l,) with all digits of the tractions that make what is `meant`."""
        return x

    def products(self, rows: Ints) -> Floats:
        """X' C X (l + k, l + k) N/m^2 of the l motions and of units of some ascending rows (k,)."""
        raise NotImplementedError

    def begun(self, problem: ContactProblem, start: Floats | None, loose: Bools) -> tuple[Floats, Floats]:
        """Unknowns (2 n + l,) near a `start` or from nothing on, and the jumps (2 n,) m that they are meant to have."""
        raise NotImplementedError

    def jump(self, problem: ContactProblem, x: Floats, meant: Floats) -> Floats:
        """The jumps (2 n,) m of unknowns (2 n + l,) that are found by C for those that are `meant`."""
        raise NotImplementedError


class TiedPoints(StuckPoints):
    """Points whose faces are tied."""

    def __init__(self, points: SparsePoints) -> None:
        super().__init__(points)
        self._sparse, self._apart = points, points.weights / points.scale  # of slip that the rock does not feel
        self._apart[points.acts] = 0.0
        self._system = points.tied
        self._system.factorize()

    def forces(self, jumps: Floats) -> Floats:
        """C du (2 n,) N/m, the forces that make jumps (2 n,) m, as the factors give them."""
        tractions = self._sparse.with_jumps(None, None, -jumps, refined=False)[2]
        return np.asarray(tractions * self.points.weights + self._apart * jumps)

    def floor(self, problem: ContactProblem) -> float:
        """What tractions may miss in the end, of the largest."""
        return ILL_DEFINED

    def exact(self, problem: ContactProblem, x: Floats, meant: Floats) -> Floats:
        """The unknowns (2 n + l,) with all digits of the tractions that make what is `meant`."""
        motion = x[len(meant) :]
        assert problem.by_jumps is not None
        return np.append(problem.by_jumps(motion, meant), motion)

    def products(self, rows: Ints) -> Floats:
        """X' C X (l + k, l + k) N/m^2 of the l motions and of units of some ascending rows (k,)."""
        (m, n), acts = self._system.constraints.shape, self._sparse.acts
        units = csr_array((np.ones(len(rows)), rows, np.arange(len(rows) + 1)), shape=(len(rows), len(self._apart)))
        of_points = csr_array(vstack([csr_array(self.points.jump.T), units], format="csr"))
        of_ties = csr_array(of_points[:, acts])
        at = (of_ties.data, of_ties.indices + n + m - len(acts), of_ties.indptr)
        found = self._system.compliance(csr_array(at, shape=(of_ties.shape[0], n + m)))
        return np.asarray(((of_points * self._apart) @ of_points.T).toarray() - found)

    def begun(self, problem: ContactProblem, start: Floats | None, loose: Bools) -> tuple[Floats, Floats]:
        """Unknowns (2 n + l,) and jumps (2 n,) m where all points stick."""
        nothing = np.zeros(2 * problem.n_points), np.zeros(problem.n_motions)
        return self.exact(problem, np.concatenate(nothing), nothing[0]), nothing[0]

    def jump(self, problem: ContactProblem, x: Floats, meant: Floats) -> Floats:
        """Those that are meant: forces have all digits, where jumps by forces on thin pieces have few."""
        return meant


class FactorizedPoints(StuckPoints):
    """Points whose compliance is factorized."""

    def __init__(self, points: RockPoints) -> None:
        super().__init__(points)
        self._lower, info = dpotrf((points.compliance / points.weights).T, lower=1, overwrite_a=1)
        if info:
            raise SolveError("the compliance of the rock between contact points is not positive definite")
        self._place = np.full(len(points.scale), -1)  # of each row among the columns of L^-1 that are known
        self._columns, self._products = np.zeros((len(points.scale), 0)), np.zeros((0, 0))
        self._add(self._half(points.jump))

    def forces(self, jumps: Floats) -> Floats:
        """C du (2 n,) N/m, the forces that make jumps (2 n,) m."""
        return np.asarray(dpotrs(self._lower, jumps, lower=1)[0])

    def begun(self, problem: ContactProblem, start: Floats | None, loose: Bools) -> tuple[Floats, Floats]:
        """Unknowns (2 n + l,) near a `start` or from nothing on, and the jumps (2 n,) m that they are meant to have."""
        x = np.zeros(problem.free.size + problem.n_motions) if start is None else start
        return x, np.where(np.tile(loose, 2), problem.jump(x), 0.0)

    def jump(self, problem: ContactProblem, x: Floats, meant: Floats) -> Floats:
        """Those that the compliance says: C has the round-off of its factor."""
        return problem.jump(x)

    def products(self, rows: Ints) -> Floats:
        """X' C X (l + k, l + k) N/m^2 of the l motions and of units of some ascending rows (k,)."""
        new = rows[self._place[rows] < 0]
        if len(new):
            self._place[new] = self._columns.shape[1] + np.arange(len(new))
            more = np.zeros((len(self._place), len(new)))
            more[new, np.arange(len(new))] = 1.0
            for start in range(0, len(new), AT_ONCE):
                from_here = slice(new[start], None)  # above there is nothing
                some = slice(start, start + AT_ONCE)
                solve_upper(self._lower.T[from_here, from_here], more[from_here, some], True)
            self._add(more)
        wanted = np.append(np.arange(self.points.jump.shape[1]), self._place[rows])
        return np.asarray(self._products[np.ix_(wanted, wanted)])

    def _half(self, right: Floats) -> Floats:
        """L^-1 times the columns `right` (2 n, k)."""
        found = np.array(right, order="C")
        solve_upper(self._lower.T, found, True)
        return found

    def _add(self, more: Floats) -> None:
        """Add columns (2 n, k) to those that are known, and their products with all."""
        across = self._columns.T @ more
        self._products = np.block([[self._products, across], [across.T, more.T @ more]])
        self._columns = np.hstack([self._columns, more])


class LoosePoints:
    """Some of the points among others that stick."""

    def __init__(self, stuck: StuckPoints, loose: Bools) -> None:
        self.loose, self.rows = loose, np.flatnonzero(np.tile(loose, 2))
        products, n_motions = stuck.products(self.rows), stuck.points.jump.shape[1]
        of_motions, across = products[:n_motions, :n_motions].copy(), products[n_motions:, :n_motions].copy()
        compliance = np.ascontiguousarray(products[n_motions:, n_motions:])
        del products
        _invert(compliance)
        self._moved = compliance @ across
        left = of_motions - across.T @ self._moved
        seen = stuck.points.jump * np.sqrt(stuck.points.weights)[:, None]
        size = np.linalg.norm(seen, axis=0)
        scale = 1.0 / np.where(size > 0.0, size, 1.0)
        by_stuck = scale * np.delete(seen, self.rows, axis=0)
        sizes, ways = np.linalg.eigh(by_stuck.T @ by_stuck)
        ways, free = scale[:, None] * ways[:, sizes > HELD], scale[:, None] * ways[:, sizes <= HELD]
        self._held, self._free = ways @ np.linalg.inv(ways.T @ left @ ways) @ ways.T, free
        weights, jump = stuck.points.weights[self.rows], self._moved @ self._free
        if self._held.any():
            compliance += self._moved @ self._held @ self._moved.T
        compliance *= weights
        self.points = CondensedPoints(compliance, jump, (jump * weights[:, None]).T, weights)

    def improved(
        self, stuck: StuckPoints, problem: ContactProblem, x: Floats, jump: Floats, active: ActiveSet | None
    ) -> tuple[Floats, Floats, float, int]:
        """Unknowns x (2 n + l,) for which the loose points fulfil the law better, with the jumps (2 n,) that they are
        meant to have, before and after; on the branches of an `active` set, or on those that Newton's method finds.

        Also by how much tractions miss what they were meant to be, and the iterations that it took; -1 if it has found
        none.
        """
        rows, k, p = self.rows, len(self.rows), x[: len(jump)]
        miss, pull = stuck.jump(problem, x, jump) - jump, problem.pull - problem.points.force @ p
        known = stuck.forces(miss) if miss.any() else miss
        of_loose = self._moved.T @ known[rows]
        pull = pull - problem.points.jump.T @ known + of_loose
        free = self.points.compliance @ (known[rows] / self.points.weights) + self._moved @ self._held @ (
            pull - of_loose
        )
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
        p = p + (known + stuck.forces(problem.points.jump @ motion - meant + jump)) / problem.points.weights
        off = float(np.abs(p[rows] - there[:k]).max(initial=0.0))
        p[rows] = there[:k]
        return np.append(p, x[len(jump) :] + motion), meant, off, iterations


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
    try:
        stuck = StuckPoints.of(lying.points)
    except SolveError:
        return None
    loose, iterations = ~problem.resists, 0
    if start is not None:
        start = np.append(start[: 2 * n], 2.0 * start[2 * n :] - unknowns(start)[2 * n :])
        loose |= (start[:n] >= 0.0) | (np.abs(start[n : 2 * n]) >= shear_bound(problem, start[:n]))
    if active is not None:
        loose |= _not_stuck(active)
    x, meant = stuck.begun(lying, start, loose)
    last = np.inf
    while loose.mean() <= MOST_LOOSE or (isinstance(stuck, TiedPoints) and loose.sum() <= MOST_LOOSE_POINTS):
        x, meant, off, more = stuck.among(loose).improved(stuck, lying, x, meant, active)
        iterations, jump = iterations + abs(more), stuck.jump(lying, x, meant)
        now = active or active_set(lying, x[: 2 * n], jump)
        leaving = _not_stuck(now) & ~loose
        if leaving.any():
            loose = loose | leaving | np.append(leaving[1:], False) | np.append(False, leaving[:-1])
            last = np.inf
            continue
        found = stuck.exact(lying, x, meant)
        off = max(off, float(np.abs((jump - meant) / lying.points.scale).max()), float(np.abs(found - x).max()))
        left = off / float(np.abs(x[: 2 * n]).max() or 1.0)
        if more >= 0 and (left <= ROUND_OFF or GAIN * last < left <= stuck.floor(lying)):
            motion = unknowns(x)[2 * n :]
            return ContactSolution(x[: 2 * n], "solved", iterations, now.states(), motion, jump=jump)
        if more < 0 or not left <= GAIN * last:  # nan is not
            break
        last, x = left, found
    return None


def _not_stuck(active: ActiveSet) -> Bools:
    """Which points (n,) are open or slip."""
    return np.asarray(~active.closed | (active.slip != 0))


def _invert(matrix: Floats) -> None:
    """Replace a large symmetric matrix (k, k) by its inverse. Raises NotSolvedError where it is not definite."""
    if len(matrix):
        lower, info = dpotrf(matrix.T, lower=1, overwrite_a=1)
        if info:
            raise NotSolvedError("the stiffness between contact points that may slip is not positive definite")
        dpotri(lower, lower=1, overwrite_c=1)
        mirror(matrix)
