"""The condensed contact problem with Coulomb friction: data, law and residual.

Unknown are the tractions p of n contact points, all normals first, then all tangentials (no tangential rows
without friction). With free the jump without contact traction, the jump of the displacement is

    du = free - A p,    A = G K^-1 G' W + diag(1/k),

and every point satisfies (Li, Zheng, Guo 2017, equations (4) to (6), in total slip from the unloaded state)

    gap = du_n >= 0,   p_n <= 0,   gap p_n = 0,
    |p_t| <= b = cohesion - friction p_n,   du_t = 0 where |p_t| < b, else du_t has the sign of p_t.

Faces that dilate are pushed apart by slip (Li, Zheng, Guo 2017, m_g with tan psi): with s0 the slip that `free` does
not count, from earlier increments, and d = tan(psi)

    gap = du_n - d |s0 + du_t|.

Pieces of rock that nothing but contact holds move as rigid bodies besides, by amplitudes a that are unknown too. With B
their jumps and W the lengths of the points, and as many equations more,

    du = free - A p + B a,    F p = pull,    F = B' W,

where `pull` is what the loads do on each motion. Unknowns are handed on as x = (p, a).

The law is taken as written: b is the cohesion at an open point too. Whoever knows the history of a point passes
a cohesion of zero where the bond is lost; an open point then carries no shear. The semismooth Newton and Lemke
solvers (`newton`, `lemke`) both solve exactly this problem.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.errors import NotSolvedError

OPEN: Final = 0
STICK: Final = 1
SLIP: Final = 2

SOLVED_RESIDUAL: Final = 1e-8  # a solver that ends above this complementarity residual does not say "solved"


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """The l rigid motions of pieces of rock that contact alone holds."""

    jump: Floats  # (m, l) B: gap and slip in each motion
    force: Floats  # (l, m) F, N/m per Pa: what tractions do on each motion
    pull: Floats  # (l,) N/m: what the loads do


@dataclass(frozen=True, slots=True, eq=False)
class ContactProblem:
    """Compliance, free jump and friction law of n contact points; arrays are seen read-only, not copied.

    Raises NotSolvedError for a value that is not finite and a diagonal entry of the compliance that is not positive,
    ValueError for a wrong shape and for negative friction, cohesion or dilation.
    """

    compliance: Floats  # (m, m) m/Pa: A; m = n without friction, else 2 n; need not be symmetric
    free: Floats  # (m,) m: gap and slip without contact traction
    friction: Floats | None = None  # (n,) coefficient, or None where there are no tangential rows
    cohesion: Floats | None = None  # (n,) Pa, None for zero; without meaning where friction is None
    dilation: Floats | None = None  # (n,) tangent of the dilation angle, None for zero; only with friction
    slipped: Floats | None = None  # (n,) m: slip s0 of earlier increments, None for zero
    motions: Motions | None = None  # None: supports hold all of the rock
    scale: Floats = field(init=False, repr=False)  # (m,) m/Pa: the diagonal, which weighs jumps against tractions
    reach: Floats = field(init=False, repr=False)  # (m,) m/Pa: sum of every row's absolute values

    def __post_init__(self) -> None:
        for name in ("compliance", "free", "friction", "cohesion", "dilation", "slipped"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, _read_only(name, value))
        n_rows = self.free.size
        n_points = n_rows if self.friction is None else self.friction.size
        _check_shape("free", self.free, (n_points if self.friction is None else 2 * n_points,))
        _check_shape("compliance", self.compliance, (n_rows, n_rows))
        if self.friction is not None:
            for name in ("cohesion", "dilation", "slipped"):
                if getattr(self, name) is None:
                    object.__setattr__(self, name, _read_only(name, np.zeros(n_points)))
                _check_shape(name, getattr(self, name), (n_points,))
            for name in ("friction", "cohesion", "dilation"):
                _check_sign(name, getattr(self, name))
        diagonal = self.compliance.diagonal()
        if not np.all(diagonal > 0.0):
            point = int(np.flatnonzero(~(diagonal > 0.0))[0])
            raise NotSolvedError(
                f"contact compliance diagonal: entry {point} is {diagonal[point]:.6g}, must be positive: the system is "
                "too ill conditioned, for cracks, tips or outlines too close to each other"
            )
        object.__setattr__(self, "scale", _read_only("scale", diagonal))
        object.__setattr__(self, "reach", _read_only("reach", np.abs(self.compliance).sum(axis=1)))

    @property
    def n_points(self) -> int:
        """Number of contact points."""
        return int(self.free.size if self.friction is None else self.friction.size)

    @property
    def least_traction(self) -> float:
        """Pa: the least traction that could make up the free jump; what is nothing beside it is no traction."""
        return float(np.abs(self.free).max(initial=0.0)) / max(float(self.reach.max(initial=0.0)), np.finfo(float).tiny)

    @property
    def n_motions(self) -> int:
        """Number of rigid motions."""
        return 0 if self.motions is None else len(self.motions.pull)


@dataclass(frozen=True, slots=True, eq=False)
class ContactSolution:
    """Tractions of one contact problem and how their computation ended."""

    traction: Floats  # (m,) Pa, ordered as the rows of the problem
    status: str  # "solved", "limit" (too many iterations), "ray" (Lemke found none), "inaccurate"
    iterations: int  # linear solves of Newton, pivots of Lemke
    state: Ints  # (n,) OPEN, STICK or SLIP
    motion: Floats = field(default_factory=lambda: np.zeros(0))  # (l,) amplitudes of the rigid motions

    @property
    def unknowns(self) -> Floats:
        """x (m + l,)."""
        return np.concatenate([self.traction, self.motion])


@dataclass(frozen=True, slots=True, eq=False)
class ActiveSet:
    """Which branch of the contact law every point is on."""

    closed: Bools  # (n,): gap = 0 is imposed, else p_n = 0
    slip: Ints  # (n,): 0 sticks (du_t = 0), +1 or -1 slips (p_t = slip * b); +1 throughout without friction
    sense: Ints | None = None  # (n,): the sign of all slip, s0 + du_t, by which faces dilate; None: that of `slip`

    def key(self) -> bytes:
        """Bytes that are equal for equal sets."""
        parts = (self.closed, self.slip) if self.sense is None else (self.closed, self.slip, self.sense)
        return b"".join(part.astype(np.int8).tobytes() for part in parts)

    def states(self) -> Ints:
        """(n,) OPEN, STICK or SLIP; an open point is OPEN whatever shear its cohesion carries."""
        return np.where(self.closed, np.where(self.slip == 0, STICK, SLIP), OPEN).astype(np.int64)


def jump(problem: ContactProblem, x: Floats) -> Floats:
    """(m,) m: du = free - A p + B a, the gap and slip with unknowns x (m + l,)."""
    m = problem.free.size
    du: Floats = problem.free - problem.compliance @ x[:m]
    return du if problem.motions is None else du + problem.motions.jump @ x[m:]


def imbalance(problem: ContactProblem, x: Floats) -> float:
    """The largest force along a motion that nothing balances, relative to the forces that there are."""
    if problem.motions is None:
        return 0.0
    motions, p = problem.motions, x[: problem.free.size]
    size = float(np.max(np.abs(motions.force) @ np.maximum(np.abs(p), problem.least_traction), initial=0.0))
    size = max(size, float(np.abs(motions.pull).max(initial=0.0)))
    left = float(np.abs(motions.pull - motions.force @ p).max(initial=0.0))
    return left / size if size > 0.0 else 0.0


def opening(problem: ContactProblem, du: Floats) -> Floats:
    """(n,) m: the gap, which is du_n less what slip has opened by dilation."""
    n = problem.n_points
    if problem.dilation is None or problem.slipped is None:
        return du[:n]
    return np.asarray(du[:n] - problem.dilation * np.abs(problem.slipped + du[n:]))


def project(problem: ContactProblem, p: Floats, du: Floats) -> Floats:
    """(m,) Pa: tractions of the contact law for p pushed by the jump, r = 1/scale; a solution is a fixed point.

    p_n = min(0, p_n + r gap), p_t = clip(p_t + r du_t, -b, b) with b from the projected p_n.
    """
    n, trial = problem.n_points, _trial(problem, p, du)
    trial[:n] = np.minimum(trial[:n], 0.0)
    if problem.friction is not None:
        b = shear_bound(problem, trial[:n])
        trial[n:] = np.clip(trial[n:], -b, b)
    return trial


def active_set(problem: ContactProblem, p: Floats, du: Floats) -> ActiveSet:
    """Return the branch of `project` that each point is on, for tractions p (m,) and jump du (m,)."""
    n, trial = problem.n_points, _trial(problem, p, du)
    closed = trial[:n] < 0.0
    slip = np.ones(n, dtype=np.int64)
    if problem.friction is None or problem.slipped is None:
        return ActiveSet(closed, slip)
    b = shear_bound(problem, np.minimum(trial[:n], 0.0))
    slip[trial[n:] < b] = 0
    slip[trial[n:] <= -b] = -1
    forward = slip * np.maximum(slip * du[n:], 0.0)  # slip against the traction is about to end
    sense = np.sign(problem.slipped + forward).astype(np.int64)
    return ActiveSet(closed, slip, np.where(sense == 0, slip, sense))


def _trial(problem: ContactProblem, p: Floats, du: Floats) -> Floats:
    """(m,) Pa: tractions p pushed by the gap and the slip."""
    n = problem.n_points
    return p + np.concatenate([opening(problem, du), du[n:]]) / problem.scale


def shear_bound(problem: ContactProblem, p_n: Floats) -> Floats:
    """(n,) Pa: b = cohesion - friction p_n, not below zero, for normal tractions p_n (n,); equation (6)."""
    assert problem.friction is not None
    assert problem.cohesion is not None
    bound: Floats = np.maximum(0.0, problem.cohesion - problem.friction * p_n)
    return bound


def complementarity_residual(problem: ContactProblem, x: Floats) -> float:
    """Worst relative violation of the contact law by unknowns x (m + l,): zero for a solution, one for a wrong one.

    Jumps are measured by the largest one without tractions, or the largest diag(A) |p| where that is more; tractions by
    the largest |p|, or the least traction that could make up that jump. Needs nothing but the problem and x.
    Raises NotSolvedError where x is not finite, ValueError where it has the wrong shape.
    """
    x = _read_only("traction", x)
    _check_shape("traction", x, (problem.free.size + problem.n_motions,))
    if problem.free.size == 0:
        return 0.0
    n, A, p = problem.n_points, problem.compliance, x[: problem.free.size]
    du = jump(problem, x)
    largest_free = float(np.abs(du + A @ p).max()) if problem.n_motions else float(np.abs(problem.free).max())
    length = max(largest_free, float((A.diagonal() * np.abs(p)).max()))
    traction = max(float(np.abs(p).max()), problem.least_traction)
    if length == 0.0:
        return imbalance(problem, x)
    gap, du = opening(problem, du) / length, du / length
    violation = np.abs(np.minimum(gap, -p[:n] / traction))
    worst = max(float(violation.max()), imbalance(problem, x))
    if problem.friction is not None:
        b = shear_bound(problem, p[:n])
        beyond = np.maximum(np.abs(p[n:]) - b, 0.0) / traction
        below_forward = np.minimum(np.maximum(du[n:], 0.0), np.abs(b - p[n:]) / traction)
        below_backward = np.minimum(np.maximum(-du[n:], 0.0), np.abs(b + p[n:]) / traction)
        worst = max(worst, float(beyond.max()), float(below_forward.max()), float(below_backward.max()))
    return worst


def _read_only(name: str, value: Floats) -> Floats:
    view = np.ascontiguousarray(value, dtype=np.float64).view()
    if not np.isfinite(view).all():
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(view))[0])
        raise NotSolvedError(
            f"contact {name}: entry {place} is {view[place]}, must be finite: check supports and loads"
        )
    view.flags.writeable = False
    return view


def _check_shape(name: str, value: Floats, shape: tuple[int, ...]) -> None:
    if value.shape != shape:
        raise ValueError(f"contact {name}: shape is {value.shape}, must be {shape}")


def _check_sign(name: str, value: Floats) -> None:
    if not np.all(value >= 0.0):
        point = int(np.flatnonzero(~(value >= 0.0))[0])
        raise ValueError(f"contact {name}: entry {point} is {value[point]:.6g}, must be zero or positive")
