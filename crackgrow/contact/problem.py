"""The condensed contact problem: the data of n contact points, and what a solver says of them.

Unknown are the tractions p of the points, all normals first, then all tangentials. With free the jump without contact
traction, the jump of the displacement is

    du = free - A p,    A = G K^-1 G' W + diag(1/k),

and every point satisfies Coulomb's law (`coulomb`). Pieces of rock that nothing but contact holds move as rigid bodies
besides, by amplitudes a that are unknown too. With B their jumps and W the lengths of the points, and as many equations
more,

    du = free - A p + B a,    F p = pull,    F = B' W,

where `pull` is what the loads do on each motion. Unknowns are handed on as x = (p, a).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.contact.points import CondensedPoints, RockPoints, read_only

if TYPE_CHECKING:
    from crackgrow.contact.equations import ActiveEquations


@dataclass(frozen=True, slots=True, eq=False)
class ContactProblem:
    """Free jump, friction law and pull of n contact points. Raises NotSolvedError for a value that is not finite."""

    points: RockPoints
    free: Floats  # (2 n,) m: gap and slip without contact traction
    friction: Floats  # (n,) coefficient
    cohesion: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) Pa; left out: zero, as the next ones
    dilation: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) tangent of the dilation angle
    slipped: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) m: slip s0 of earlier increments
    pull: Floats = field(default_factory=lambda: np.zeros(0))  # (l,) N/m: what the loads do on each motion
    # (2 n,) Pa, on sparse rock: tractions by amplitudes (l,) of motions and jumps (2 n,) m
    by_jumps: Callable[[Floats, Floats], Floats] | None = None

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

    def jump_of(self, solution: ContactSolution) -> Floats:
        """The same (2 n,) m of a solution."""
        return self.jump(solution.unknowns) if solution.jump is None else solution.jump

    def settled(self) -> tuple[ContactProblem, Callable[[Floats], Floats]]:
        """The same problem with loose pieces settled (`CondensedPoints.settled`), and all unknowns of its own."""
        if not self.n_motions or not isinstance(self.points, CondensedPoints):
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
    jump: Floats | None = None  # (2 n,) m; None: that of its unknowns

    @property
    def unknowns(self) -> Floats:
        """x (2 n + l,)."""
        return np.concatenate([self.traction, self.motion])
