"""The condensed contact problem: the data of n contact points, and what a solver says of them.

Unknown are the tractions p of the points, all normals first, then all tangentials. With free the jump without contact
traction, the jump of the displacement is

    du = free - A p,    A = G K^-1 G' W + diag(1/k),

and every point satisfies Coulomb's law (`coulomb`). Pieces of rock that nothing but contact holds move as rigid bodies
besides, by amplitudes a that are unknown too. With B their jumps and W the lengths of the points, and as many equations
more,

    du = free - A p + B a,    F p = pull,    F = B' W,

where `pull` is what the loads do on each motion. Unknowns are handed on as x = (p, a).

Where supports hold such pieces to be solved for single tractions, and loads, turn them far: of A and of the free jumps
all is taken off that is a motion, or works on one, and springs as soft as the rock are put in its place. Digits would
be lost in what they turn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.errors import NotSolvedError

if TYPE_CHECKING:
    from crackgrow.contact.equations import ActiveEquations

ROWS_AT_ONCE = 256
"""Rows of a large compliance that are worked on together."""


UNSEEN: Final = 1e-12  # motions that contact points see by less, relative to what they see best, are not seen


@dataclass(frozen=True, eq=False)
class CondensedPoints:
    """The rock as n contact points see it, whatever the loads and the law: the compliance and l rigid motions.

    Arrays are seen read-only, not copied. Raises NotSolvedError for a value that is not finite and a diagonal entry of
    the compliance that is not positive.
    """

    compliance: Floats  # (2 n, 2 n) m/Pa: A; need not be symmetric
    jump: Floats = field(default_factory=lambda: np.zeros((0, 0)))  # (2 n, l) B: gap and slip; left out: no motions
    force: Floats = field(default_factory=lambda: np.zeros((0, 0)))  # (l, 2 n) F, N/m per Pa: what tractions do
    weights: Floats = field(default_factory=lambda: np.zeros(0))  # (2 n,) m: W; left out: one

    def __post_init__(self) -> None:
        m = len(self.compliance)
        object.__setattr__(self, "compliance", read_only("compliance", self.compliance))
        if self.jump.shape == (0, 0):
            object.__setattr__(self, "jump", np.zeros((m, 0)))
            object.__setattr__(self, "force", np.zeros((0, m)))
        if not self.weights.size:
            object.__setattr__(self, "weights", np.ones(m))
        diagonal = self.compliance.diagonal()
        if not np.all(diagonal > 0.0):
            point = int(np.flatnonzero(~(diagonal > 0.0))[0])
            raise NotSolvedError(
                f"contact compliance diagonal: entry {point} is {diagonal[point]:.6g}, must be positive: the system is "
                "too ill conditioned, for cracks, tips or outlines too close to each other"
            )

    def release(self) -> None:
        """Let go of what is large, and can be made again."""
        for name in ("settled", "stuck"):
            self.__dict__.pop(name, None)

    @cached_property
    def scale(self) -> Floats:
        """(2 n,) m/Pa: the diagonal, which weighs jumps against tractions."""
        return self.compliance.diagonal()

    @cached_property
    def reach(self) -> Floats:
        """(2 n,) m/Pa: sum of every row's absolute values."""
        return absolute_product(self.compliance, np.ones(len(self.compliance)))

    @cached_property
    def balance(self) -> Floats:
        """Amplitudes (l, l) of motions whose jumps, as tractions, are a unit of force on each; pseudoinverse."""
        return np.asarray(np.linalg.pinv(self.force @ self.jump, rcond=UNSEEN, hermitian=True))

    @cached_property
    def settled(self) -> tuple[CondensedPoints, Floats, Floats]:
        """The points without what supports do that hold loose pieces to be solved for.

        And what tractions move more without them (l, 2 n), and what pulls move less (2 n, l).
        """
        B, F, A, balance = self.jump, self.force, self.compliance, self.balance
        moving, pushed = balance @ (F @ A), (A @ B) @ balance
        pushed -= B @ (moving @ B @ balance)
        softness = float(np.median(A.diagonal() - (B * moving.T).sum(axis=1) - (pushed * F.T).sum(axis=1)))
        moving -= softness * balance @ F  # with F = B' W the projection is one of symmetric A W^-1
        moves = np.hstack([B, pushed]) @ np.vstack([moving, F])
        np.subtract(A, moves, out=moves)  # it is large
        return CondensedPoints(moves, B, F, self.weights), moving, pushed


@dataclass(frozen=True, slots=True, eq=False)
class ContactProblem:
    """Free jump, friction law and pull of n contact points. Raises NotSolvedError for a value that is not finite."""

    points: CondensedPoints
    free: Floats  # (2 n,) m: gap and slip without contact traction
    friction: Floats  # (n,) coefficient
    cohesion: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) Pa; left out: zero, as the next ones
    dilation: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) tangent of the dilation angle
    slipped: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) m: slip s0 of earlier increments
    pull: Floats = field(default_factory=lambda: np.zeros(0))  # (l,) N/m: what the loads do on each motion

    def __post_init__(self) -> None:
        for name in ("free", "friction", "cohesion", "dilation", "slipped"):
            value = getattr(self, name)
            given = value if value.size else np.zeros(self.friction.size)
            object.__setattr__(self, name, read_only(name, given))

    @property
    def n_points(self) -> int:
        """Number of contact points."""
        return int(self.friction.size)

    @property
    def n_unknowns(self) -> int:
        """Number of tractions that the law leaves open: no shear where nothing resists it."""
        return self.n_points * (2 if bool(self.resists.any()) else 1)

    @property
    def resists(self) -> Bools:
        """Points (n,) where slip matters."""
        return np.asarray((self.friction > 0.0) | (self.cohesion > 0.0) | (self.dilation > 0.0))

    @property
    def n_motions(self) -> int:
        """Number of rigid motions."""
        return int(self.points.jump.shape[1])

    @property
    def least_traction(self) -> float:
        """Pa: the least traction that could make up the free jump; what is nothing beside it is no traction."""
        reach = float(self.points.reach.max(initial=0.0))
        return float(np.abs(self.free).max(initial=0.0)) / max(reach, np.finfo(float).tiny)

    def jump(self, x: Floats) -> Floats:
        """(2 n,) m: du = free - A p + B a, the gap and slip with unknowns x (2 n + l,)."""
        m = self.free.size
        return np.asarray(self.free - self.points.compliance @ x[:m] + self.points.jump @ x[m:])

    def settled(self) -> tuple[ContactProblem, Callable[[Floats], Floats]]:
        """The same problem with loose pieces settled (`CondensedPoints.settled`), and all unknowns of its own."""
        if not self.n_motions:
            return self, np.array
        m, (points, moving, pushed) = self.free.size, self.points.settled
        free = self.free - pushed @ self.pull
        moved = points.balance @ (points.force @ free)
        other = replace(self, points=points, free=free - points.jump @ moved)
        return other, lambda x: np.append(x[:m], x[m:] + moving @ x[:m] - moved)

    def imbalance(self, x: Floats) -> float:
        """The largest force along a motion that nothing balances, relative to the forces that there are."""
        if not self.n_motions:
            return 0.0
        force, p = self.points.force, x[: self.free.size]
        size = float(np.max(np.abs(force) @ np.maximum(np.abs(p), self.least_traction), initial=0.0))
        size = max(size, float(np.abs(self.pull).max(initial=0.0)))
        left = float(np.abs(self.pull - force @ p).max(initial=0.0))
        return left / size if size > 0.0 else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class ContactSolution:
    """Tractions of one contact problem and how their computation ended."""

    traction: Floats  # (2 n,) Pa, ordered as the rows of the problem
    status: str  # "solved", "limit" (too many iterations), "ray" (Lemke found none), "inaccurate"
    iterations: int  # linear solves of Newton, pivots of Lemke
    state: Ints  # (n,) OPEN, STICK or SLIP
    motion: Floats = field(default_factory=lambda: np.zeros(0))  # (l,) amplitudes of the rigid motions
    equations: ActiveEquations | None = None  # that Newton factorized last; a problem that is close needs few more

    @property
    def unknowns(self) -> Floats:
        """x (2 n + l,)."""
        return np.concatenate([self.traction, self.motion])


def absolute_product(A: Floats, x: Floats) -> Floats:
    """(n,) |A| x of A (n, m), in blocks of rows: large ones are never held twice."""
    found = np.empty(len(A))
    for start in range(0, len(A), ROWS_AT_ONCE):
        some = slice(start, start + ROWS_AT_ONCE)
        found[some] = np.abs(A[some]) @ x
    return found


def read_only(name: str, value: Floats) -> Floats:
    """The array, that can't be changed. Raises NotSolvedError where it is not finite."""
    view = np.ascontiguousarray(value, dtype=np.float64).view()
    if not np.isfinite(view).all():
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(view))[0])
        raise NotSolvedError(
            f"contact {name}: entry {place} is {view[place]}, must be finite: check supports and loads"
        )
    view.flags.writeable = False
    return view
