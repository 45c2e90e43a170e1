"""Newton on the points that move: those that stick are condensed once, however often others change.

With S the points that slip, open or may do so, and the jump du given there and nothing elsewhere, tractions follow from
one factorization of A,

    p = p0 - P du_S,    P = A^-1 E - A^-1 B (F A^-1 B)^-1 F A^-1 E,

E the columns of the identity at S. So P_SS^-1 is the compliance of a problem of these points alone, a Schur complement,
in which motions remain of pieces that only they hold. Points outside that leave the stuck state are taken in: S only
grows, so that nothing cycles outside of the small problem.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.contact.coulomb import STICK, active_set
from crackgrow.contact.equations import SINGULAR
from crackgrow.contact.loose import split
from crackgrow.contact.newton import as_far, missed, solve_by_newton
from crackgrow.contact.problem import ContactProblem, ContactSolution, Motions

MOST_MOVING = 0.4
"""Share of the points: where more of them move their columns cost more than Newton's steps on all points.

Measured with 400 points on a crack: 0.08 s for either where 41 % of them move, 0.06 and 0.08 s with 29, 0.13 and 0.07 s
with 54.
"""


def solve_where_points_move(
    problem: ContactProblem, start: Floats | None = None, most_moving: float = MOST_MOVING
) -> ContactSolution | None:
    """The solution, from unknowns `start` (2 n + l,) on; None where a larger share of points than
    `most_moving` moves, or the small problem has none.

    Iterations are those of Newton on the small problems.
    """
    n, m, moves, x = problem.n_points, problem.free.size, ~problem.resists, start
    if start is not None:
        moves |= _moving(problem, start)
    motions = problem.motions or _none(problem)
    lu, pivots, info = dgetrf(problem.compliance.T)
    if info or dgecon(lu, np.abs(problem.compliance).sum(axis=1).max(), norm="1")[0] <= SINGULAR:
        return None
    rest = np.concatenate([problem.dilation * np.abs(problem.slipped), np.zeros(n)])  # jumps of points that stick
    by_rock = dgetrs(lu, pivots, np.column_stack([problem.free - rest, motions.jump]), trans=1)[0]
    small, iterations = None, 0
    at, per = np.zeros(0, dtype=np.int64), np.zeros((m, 0))
    while moves.mean() <= most_moving:
        new = np.setdiff1d(np.flatnonzero(np.tile(moves, 2)), at)
        if small is None or len(new):
            units = np.zeros((m, len(new)), order="F")
            units[new, np.arange(len(new))] = 1.0
            at, per = np.append(at, new), np.column_stack([per, dgetrs(lu, pivots, units, trans=1, overwrite_b=1)[0]])
            order = np.argsort(at)
            at, per = at[order], per[:, order]
            small = _Small.of(motions, by_rock[:, 1:], per, at)
            if small is None:
                return None
        found = small.solved(problem, by_rock[:, 0], rest, x)
        if found is None:
            return None
        x, du, iterations = found[0], problem.jump(found[0]), iterations + found[1]
        leaving = _moving(problem, x) & ~moves
        if leaving.any():
            moves |= leaving
            continue
        if missed(problem, x, du) > as_far(problem):
            return None
        x[:n] = np.minimum(x[:n], 0.0)
        return ContactSolution(x[:m], "solved", iterations, active_set(problem, x[:m], du).states(), x[m:])
    return None


@dataclass(frozen=True, slots=True, eq=False)
class _Small:
    """The rock as the points that move see it, where nothing else moves, and what follows from their tractions."""

    at: Ints  # (k,) their rows among those of all points
    compliance: Floats  # (k, k) m/Pa
    per: Floats  # (2 n, k) Pa/m tractions that each jump takes away
    motions: Motions
    seen: Floats  # (r, l) motions that points which stick see
    kept: Floats  # (j, l) motions that only those see which move
    moved: Floats  # (2 n, r) Pa/m tractions by the motions that are seen
    balance: Floats  # (r, r) m^2/N: what is seen of the motions by a pull along them
    turned: Floats  # (r, k) the same by each jump

    @classmethod
    def of(cls, motions: Motions, by_motions: Floats, by_units: Floats, at: Ints) -> _Small | None:
        """By tractions A^-1 B (2 n, l) and A^-1 E (2 n, k); None where the small compliance is singular."""
        seen, kept = split(np.delete(motions.jump, at, axis=0))
        moved, force = by_motions @ seen.T, seen @ motions.force
        try:
            balance = np.asarray(np.linalg.inv(force @ moved), dtype=np.float64)
            turned = balance @ (force @ by_units)
            per = by_units - moved @ turned
            compliance = np.asarray(np.linalg.inv(per[at]), dtype=np.float64)
        except np.linalg.LinAlgError:
            return None
        if not np.all(compliance.diagonal() > 0.0) or (len(kept) and not len(at)):
            return None
        return cls(at, compliance, per, motions, seen, kept, moved, balance, turned)

    def solved(
        self, problem: ContactProblem, base: Floats, rest: Floats, start: Floats | None
    ) -> tuple[Floats, int] | None:
        """All unknowns (2 n + l,) by the law, and iterations; None where Newton finds none.

        `base` (2 n,) are tractions without motions and jumps, `rest` (2 n,) the jumps of points that stick.
        """
        at, F, pull = self.at, self.motions.force, self.motions.pull
        motion = self.balance @ (self.seen @ (pull - F @ base))
        without = base + self.moved @ motion
        some = at[: len(at) // 2]
        laws = problem.friction[some], problem.cohesion[some], problem.dilation[some], problem.slipped[some]
        left = Motions(self.motions.jump[at] @ self.kept.T, self.kept @ F[:, at], self.kept @ pull)
        free = rest[at] + self.compliance @ without[at]
        small = ContactProblem(self.compliance, free, *laws, left if len(self.kept) else None)
        found = solve_by_newton(small, None if start is None else np.append(start[at], np.zeros(small.n_motions)))
        if found.status != "solved":
            return None
        jump = self.compliance @ (without[at] - found.traction)
        p = without - self.per @ jump
        p[at] = found.traction
        motion += self.turned @ jump
        return np.concatenate([p, self.seen.T @ motion + self.kept.T @ found.motion]), found.iterations


def _moving(problem: ContactProblem, x: Floats) -> Bools:
    """Points (n,) that unknowns say do not stick."""
    m = problem.free.size
    return np.asarray(active_set(problem, x[:m], problem.jump(x)).states() != STICK)


def _none(problem: ContactProblem) -> Motions:
    """No motions."""
    return Motions(np.zeros((problem.free.size, 0)), np.zeros((0, problem.free.size)), np.zeros(0))
