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

from dataclasses import dataclass, field, replace

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.errors import NotSolvedError

ROWS_AT_ONCE = 256
"""Rows of a large compliance that are worked on together."""


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """The l rigid motions of pieces of rock that contact alone holds."""

    jump: Floats  # (2 n, l) B: gap and slip in each motion
    force: Floats  # (l, 2 n) F, N/m per Pa: what tractions do on each motion
    pull: Floats  # (l,) N/m: what the loads do


@dataclass(frozen=True, slots=True, eq=False)
class ContactProblem:
    """Compliance, free jump and friction law of n contact points; arrays are seen read-only, not copied.

    Raises NotSolvedError for a value that is not finite and a diagonal entry of the compliance that is not positive,
    ValueError for a wrong shape and for negative friction, cohesion or dilation.
    """

    compliance: Floats  # (2 n, 2 n) m/Pa: A; need not be symmetric
    free: Floats  # (2 n,) m: gap and slip without contact traction
    friction: Floats  # (n,) coefficient
    cohesion: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) Pa; left out: zero, as the next ones
    dilation: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) tangent of the dilation angle
    slipped: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) m: slip s0 of earlier increments
    motions: Motions | None = None  # None: supports hold all of the rock
    scale: Floats = field(init=False, repr=False)  # (2 n,) m/Pa: the diagonal, which weighs jumps against tractions
    reach: Floats = field(init=False, repr=False)  # (2 n,) m/Pa: sum of every row's absolute values

    def __post_init__(self) -> None:
        n = self.friction.size
        for name in ("cohesion", "dilation", "slipped"):
            if getattr(self, name).size == 0:
                object.__setattr__(self, name, np.zeros(n))
        shapes = {"compliance": (2 * n, 2 * n), "free": (2 * n,)}
        for name in ("compliance", "free", "friction", "cohesion", "dilation", "slipped"):
            value = read_only(name, getattr(self, name))
            check_shape(name, value, shapes.get(name, (n,)))
            object.__setattr__(self, name, value)
        for name in ("friction", "cohesion", "dilation"):
            _check_sign(name, getattr(self, name))
        diagonal = self.compliance.diagonal()
        if not np.all(diagonal > 0.0):
            point = int(np.flatnonzero(~(diagonal > 0.0))[0])
            raise NotSolvedError(
                f"contact compliance diagonal: entry {point} is {diagonal[point]:.6g}, must be positive: the system is "
                "too ill conditioned, for cracks, tips or outlines too close to each other"
            )
        object.__setattr__(self, "scale", read_only("scale", diagonal))
        object.__setattr__(self, "reach", read_only("reach", absolute_product(self.compliance, np.ones(2 * n))))

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
        return 0 if self.motions is None else len(self.motions.pull)

    @property
    def least_traction(self) -> float:
        """Pa: the least traction that could make up the free jump; what is nothing beside it is no traction."""
        return float(np.abs(self.free).max(initial=0.0)) / max(float(self.reach.max(initial=0.0)), np.finfo(float).tiny)

    def jump(self, x: Floats) -> Floats:
        """(2 n,) m: du = free - A p + B a, the gap and slip with unknowns x (2 n + l,)."""
        m = self.free.size
        du: Floats = self.free - self.compliance @ x[:m]
        return du if self.motions is None else du + self.motions.jump @ x[m:]

    def scaled(self, share: float) -> ContactProblem:
        """The problem under `share` times the loads, of faces that nothing but their friction holds."""
        motions = self.motions and replace(self.motions, pull=share * self.motions.pull)
        return replace(self, free=share * self.free, slipped=share * self.slipped, motions=motions)

    def imbalance(self, x: Floats) -> float:
        """The largest force along a motion that nothing balances, relative to the forces that there are."""
        if self.motions is None:
            return 0.0
        motions, p = self.motions, x[: self.free.size]
        size = float(np.max(np.abs(motions.force) @ np.maximum(np.abs(p), self.least_traction), initial=0.0))
        size = max(size, float(np.abs(motions.pull).max(initial=0.0)))
        left = float(np.abs(motions.pull - motions.force @ p).max(initial=0.0))
        return left / size if size > 0.0 else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class ContactSolution:
    """Tractions of one contact problem and how their computation ended."""

    traction: Floats  # (2 n,) Pa, ordered as the rows of the problem
    status: str  # "solved", "limit" (too many iterations), "ray" (Lemke found none), "inaccurate"
    iterations: int  # linear solves of Newton, pivots of Lemke
    state: Ints  # (n,) OPEN, STICK or SLIP
    motion: Floats = field(default_factory=lambda: np.zeros(0))  # (l,) amplitudes of the rigid motions

    @property
    def unknowns(self) -> Floats:
        """x (2 n + l,)."""
        return np.concatenate([self.traction, self.motion])


def absolute_product(A: Floats, x: Floats, left: Floats | None = None, right: Floats | None = None) -> Floats:
    """(n,) |A - left right| x of A (n, m), in blocks of rows: large ones are never held twice."""
    found = np.empty(len(A))
    for start in range(0, len(A), ROWS_AT_ONCE):
        some = slice(start, start + ROWS_AT_ONCE)
        block = A[some] if left is None or right is None else A[some] - left[some] @ right
        found[some] = np.abs(block) @ x
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


def check_shape(name: str, value: Floats, shape: tuple[int, ...]) -> None:
    """Raise ValueError where an array has another shape."""
    if value.shape != shape:
        raise ValueError(f"contact {name}: shape is {value.shape}, must be {shape}")


def _check_sign(name: str, value: Floats) -> None:
    if not np.all(value >= 0.0):
        point = int(np.flatnonzero(~(value >= 0.0))[0])
        raise ValueError(f"contact {name}: entry {point} is {value[point]:.6g}, must be zero or positive")
