"""Coulomb's law of contact points: its branches, and what points remember from load to load.

Every point satisfies (Li, Zheng, Guo 2017, equations (4) to (6), in total slip from the unloaded state)

    gap = du_n >= 0,   p_n <= 0,   gap p_n = 0,
    |p_t| <= b = cohesion - friction p_n,   du_t = 0 where |p_t| < b, else du_t has the sign of p_t.

Faces that dilate are pushed apart by slip (m_g with tan psi): with s0 the slip that du_t does not count, from earlier
increments, and d = tan(psi)

    gap = du_n - d |s0 + du_t|.

A point with a tensile strength T bears p_n <= T while its faces are together: of q = p_n - T it is the law above, with
a cohesion c - friction T, which is not negative. Solvers know of no other.

A point that slips or opens is broken: its friction is the residual one from then on, its tensile strength lost, and its
cohesion unless it is kept. With a weakening length D slip takes them by and by. Of what can be lost a share |s - s0|/D
is lost besides what was before, until all is; or of what is left 1 - exp(-|s - s0| / D). A point that opens loses all.
Dilation that wears is a rate, d' |s| with the d of what is lost by then: faces that slip back do not close all of what
they have opened.

Faces whose closure has a limit v_m close by v = e q / (1 + e q / v_m) under a pressure q (Bandis et al. 1983).
Friction of rough faces is tan(phi + JRC log10(JCS / q)), at least that of flat ones, phi, and at most 70 degrees
(Barton, Choubey 1977). Closure is taken by its tangent, and friction as the secant, at a pressure, and again until that
is the one that comes of it. Nothing of it is remembered.

The law is taken as written: b is the cohesion at an open point too. Whoever knows the history of a
point passes a cohesion of zero where the bond is lost; an open point then carries no shear.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.case.model import STEEPEST
from crackgrow.contact.points import read_only
from crackgrow.contact.problem import ContactProblem

OPEN: Final = 0
STICK: Final = 1
SLIP: Final = 2

SAME_SHARE: Final = 1e-9  # shares that are lost are the same if they differ by less
EPSILON: Final = float(np.finfo(float).eps)
SOLVED_RESIDUAL: Final = 1e-8  # a solver that ends above this complementarity residual does not say "solved"


def closed_by(linear: Floats, most: Floats | float) -> Floats:
    """What faces close by (n,) m that would close by `linear` (n,) m at their first softness, and by `most` at most."""
    return np.asarray(linear / (1.0 + np.maximum(linear, 0.0) / most))


@dataclass(frozen=True, slots=True, eq=False)
class ContactLaw:
    """Law of every contact point; what slip wears is linear between `shares` of it that are lost, from 0 to 1."""

    compliance: Floats  # (n,) m/Pa: 1/k across the faces, zero for rigid contact
    shear_compliance: Floats  # (n,) m/Pa: the same along the faces
    weakening: Floats  # (n,) m: slip that takes all that can be lost; 0: any slip does
    decays: Bools  # (n,) whether it takes all but 1/e of it
    shares: Floats  # (k, n)
    friction: Floats  # (k, n)
    cohesion: Floats  # (k, n) Pa, of points that are closed
    tension: Floats  # (k, n) Pa: tensile strength
    dilation: Floats  # (k, n) tan(dilation angle)
    most: Floats  # (n,) m: the limit of closure; infinite where it is linear
    rough: Floats  # (n,) radians per decade of pressure: JRC
    wall: Floats  # (n,) Pa: JCS

    @property
    def bends(self) -> Bools:
        """Which points (n,) are elastic, or slip, in no proportion to their pressure."""
        return np.isfinite(self.most) | (self.rough > 0.0)

    def closure(self, normal: Floats) -> Floats:
        """What elastic faces close by (n,) m under normal tractions (n,) Pa; negative where these are tension."""
        return closed_by(-self.compliance * normal, self.most)

    def softness(self, normal: Floats) -> Floats:
        """Its derivative (n,) by pressure, of that without pressure."""
        return np.asarray((1.0 + np.maximum(-self.compliance * normal, 0.0) / self.most) ** -2)

    def stored(self, normal: Floats) -> Floats:
        """Energy (n,) J/m^2 of the closure beyond half of traction times closure."""
        pressure, some = np.maximum(-normal, 0.0), np.isfinite(self.most)
        closes = np.divide(self.compliance * pressure, self.most, out=np.zeros(len(normal)), where=some)
        area = np.divide(self.most**2, self.compliance, out=np.zeros(len(normal)), where=some)
        return np.where(some, area * (np.log1p(closes) - closes + 0.5 * closes**2 / (1.0 + closes)), 0.0)

    def changed(self, normal: Floats, other: Floats) -> float:
        """How far apart softness or friction are at two normal tractions (n,) Pa, at most."""
        lost = np.zeros(len(normal))
        soft, friction = self.softness(normal) - self.softness(other), self.bound_of(lost, normal)[0]
        return float(np.max(np.maximum(np.abs(soft), np.abs(friction - self.bound_of(lost, other)[0])), initial=0.0))

    @property
    def weakens(self) -> Bools:
        """Which points (n,) lose by and by what they can lose."""
        return self.weakening > 0.0

    @property
    def flattens(self) -> Bools:
        """Which points (n,) dilate by less the more they have lost."""
        return np.asarray(self.dilation[-1] < self.dilation[0])

    def worn(self, lost: Floats, slip: Floats) -> Floats:
        """The share (n,) of what can be lost that slip (n,) m, less its elastic part, takes besides what was `lost`.

        Of points that weaken; it may be more than was left, but where they decay.
        """
        length = np.divide(np.abs(slip), self.weakening, out=np.zeros(len(slip)), where=self.weakens)
        return np.where(self.decays, -(1.0 - lost) * np.expm1(-length), length)

    def following(self, lost: Floats) -> Floats:
        """The next of the shares (n,) at which the law bends, or ends."""
        return np.asarray(np.min(self.shares, axis=0, initial=1.0, where=self.shares > lost + SAME_SHARE))

    @property
    def compliances(self) -> Floats:
        """Compliance (2 n,) m/Pa across the faces, then along them."""
        return np.concatenate([self.compliance, self.shear_compliance])

    def bound_of(self, lost: Floats, normal: Floats | None = None) -> tuple[Floats, Floats]:
        """Friction (n,) and cohesion (n,) where a share `lost` (n,), 0 to 1, of what points can lose is gone.

        Friction of rough faces is that under normal tractions (n,) Pa, the most that it can be without.
        """
        friction = self._at(self.friction, lost)
        if self.rough.any():
            flat, pressure = np.arctan(friction), np.zeros(len(lost)) if normal is None else -normal
            decades = np.log10(self.wall) - np.log10(np.maximum(pressure, np.finfo(float).tiny))
            steep = np.minimum(flat + self.rough * np.maximum(decades, 0.0), np.maximum(flat, np.deg2rad(STEEPEST)))
            friction = np.where(self.rough > 0.0, np.tan(steep), friction)
        return friction, self._at(self.cohesion, lost)

    def tension_of(self, lost: Floats) -> Floats:
        """Tensile strength (n,) Pa where a share `lost` (n,) is gone."""
        return self._at(self.tension, lost)

    def dilation_of(self, lost: Floats) -> Floats:
        """How fast (n,) slip opens by dilation where a share `lost` (n,) is gone."""
        return np.where(self.flattens, self._at(self.dilation, lost), self.dilation[0])

    def dilation_between(self, first: Floats, last: Floats) -> Floats:
        """The mean of that (n,) over slip one way that has taken what is lost from a share to another one, (n,) both.

        All slip beyond all that can be lost is slip on.
        """
        if not self.flattens.any():
            return np.asarray(self.dilation[0])
        ends = np.concatenate([self.shares[1:], np.full((1, len(first)), np.inf)])
        low, high = (np.clip(lost, self.shares, ends) for lost in (first, last))
        parts, middles = high - low, 0.5 * (low + high)
        rates = np.array(
            [parts * self._at(self.dilation, middle) for parts, middle in zip(parts, middles, strict=True)]
        )
        mean = np.divide(rates.sum(axis=0), parts.sum(axis=0), out=self.dilation_of(first), where=last > first)
        part = np.divide(last - first, 1.0 - first, out=np.zeros(len(first)), where=self.decays & (first < 1.0))
        length = -np.log1p(-np.minimum(part, 1.0 - EPSILON))
        decayed = np.divide(part, length, out=np.ones(len(first)), where=length > 0.0)  # mean of what is left
        decayed = self._at(self.dilation, 1.0 - (1.0 - first) * decayed)
        return np.where(self.flattens, np.where(self.decays, decayed, mean), self.dilation[0])

    def _at(self, of: Floats, lost: Floats) -> Floats:
        """(n,) of the rows `of` the law (k, n), where a share `lost` (n,) is gone."""
        point, lost = np.arange(of.shape[1]), np.minimum(lost, 1.0)
        row = (lost > self.shares[1:-1]).sum(axis=0)
        first, last = self.shares[row, point], self.shares[row + 1, point]
        share = (lost - first) / (last - first)
        return np.asarray((1.0 - share) * of[row, point] + share * of[row + 1, point])

    @property
    def resists(self) -> Bools:
        """At which points (n,) something can resist slip: others carry no shear in any state."""
        return np.asarray(np.any((self.friction > 0.0) | (self.cohesion > 0.0) | (self.dilation > 0.0), axis=0))

    @property
    def breakable(self) -> Bools:
        """Which points (n,) have something to lose."""
        falls = [of[-1] < of[0] for of in (self.friction, self.cohesion, self.tension, self.dilation)]
        return np.asarray(np.any(falls, axis=0))


@dataclass(frozen=True, slots=True, eq=False)
class ContactMemory:
    """What contact points keep from one increment to the next."""

    slip: Floats  # (n,) m, less its elastic part
    lost: Floats  # (n,) share, 0 to 1, of what it can lose; without a weakening length all, once it has slipped
    closed: Bools  # (n,) is not open
    risen: Floats  # (n,) m that dilation, worn on the way, has opened beyond that of all slip at the rate of now
    normal: Floats  # (n,) Pa
    tangential: Floats  # (n,) Pa
    dilation: Floats  # (n,) m that slip has opened

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that points remember (n,), by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def tractions(self) -> Floats:
        """(2 n,) Pa, all normals, then all tangentials."""
        return np.concatenate([self.normal, self.tangential])

    @property
    def at_rest(self) -> bool:
        """Whether nothing has happened yet."""
        return not (self.tractions.any() or self.slip.any() or self.lost.any())

    @property
    def broken(self) -> Bools:
        """Which points (n,) have slipped or opened."""
        return np.asarray(self.lost > 0.0)

    def coheres(self, law: ContactLaw) -> Bools:
        """Which points (n,) the bond holds."""
        _, cohesion = law.bound_of(self.lost)
        return np.asarray(((cohesion > 0.0) | (law.tension_of(self.lost) > 0.0)) & self.closed)

    def dilates(self, law: ContactLaw, lost: Floats) -> tuple[Floats, Floats]:
        """How fast (n,) slip opens while what is lost comes to a share (n,), and what (n,) m is open without slip."""
        rate = law.dilation_between(self.lost, lost)
        return rate, self.risen + (law.dilation_of(self.lost) - rate) * np.abs(self.slip)

    @classmethod
    def fresh(cls, n: int) -> ContactMemory:
        """Memory of n points that nothing has happened to."""
        nothing = np.zeros(n)
        return cls(nothing, nothing, np.ones(n, dtype=bool), nothing, nothing, nothing, nothing)


@dataclass(frozen=True, slots=True, eq=False)
class ActiveSet:
    """Which branch of the contact law every point is on."""

    closed: Bools  # (n,): gap = 0 is imposed, else p_n = 0
    slip: Ints  # (n,): 0 sticks (du_t = 0), +1 or -1 slips (p_t = slip * b)
    sense: Ints  # (n,): the sign of all slip, s0 + du_t, by which faces dilate

    def key(self) -> bytes:
        """Bytes that are equal for equal sets."""
        return b"".join(part.astype(np.int8).tobytes() for part in (self.closed, self.slip, self.sense))

    def states(self) -> Ints:
        """(n,) OPEN, STICK or SLIP; an open point is OPEN whatever shear its cohesion carries."""
        return np.where(self.closed, np.where(self.slip == 0, STICK, SLIP), OPEN).astype(np.int64)


def opening(problem: ContactProblem, du: Floats) -> Floats:
    """(n,) m: the gap, which is du_n less what slip has opened by dilation."""
    n = problem.n_points
    return np.asarray(du[:n] - problem.dilation * np.abs(problem.slipped + du[n:]))


def shear_bound(problem: ContactProblem, p_n: Floats) -> Floats:
    """(n,) Pa: b = cohesion - friction p_n, not below zero, for normal tractions p_n (n,); equation (6)."""
    bound: Floats = np.maximum(0.0, problem.cohesion - problem.friction * p_n)
    return bound


def project(problem: ContactProblem, p: Floats, du: Floats) -> Floats:
    """(2 n,) Pa: tractions of the contact law for p pushed by the jump, r = 1/scale; a solution is a fixed point.

    p_n = min(0, p_n + r gap), p_t = clip(p_t + r du_t, -b, b) with b from the projected p_n.
    """
    n, trial = problem.n_points, _trial(problem, p, du)
    trial[:n] = np.minimum(trial[:n], 0.0)
    b = shear_bound(problem, trial[:n])
    trial[n:] = np.clip(trial[n:], -b, b)
    return trial


def active_set(problem: ContactProblem, p: Floats, du: Floats) -> ActiveSet:
    """Return the branch of `project` that each point is on, for tractions p (2 n,) and jump du (2 n,)."""
    n, trial = problem.n_points, _trial(problem, p, du)
    closed = trial[:n] < 0.0
    b = shear_bound(problem, np.minimum(trial[:n], 0.0))
    slip = np.where(trial[n:] < b, np.where(trial[n:] <= -b, -1, 0), 1)
    forward = slip * np.maximum(slip * du[n:], 0.0)  # slip against the traction is about to end
    sense = np.sign(problem.slipped + forward).astype(np.int64)
    slip[~problem.resists] = 1  # where the way does not matter it is one and the same
    return ActiveSet(closed, slip, np.where((sense == 0) | ~problem.resists, slip, sense))


def _trial(problem: ContactProblem, p: Floats, du: Floats) -> Floats:
    """(2 n,) Pa: tractions p pushed by the gap and the slip."""
    n = problem.n_points
    return p + np.concatenate([opening(problem, du), du[n:]]) / problem.points.scale


def complementarity_residual(problem: ContactProblem, x: Floats, jump: Floats | None = None) -> float:
    """Worst relative violation of the contact law by unknowns x (2 n + l,): zero for a solution, one for a wrong one.

    Their `jump` (2 n,) m may be known. Jumps are measured by the largest one without tractions, or the largest
    diag(A) |p| where that is more; tractions by the largest |p|, or the least traction that could make up that jump.
    Raises NotSolvedError where x is not finite.
    """
    x = read_only("traction", x)
    if problem.free.size == 0:
        return 0.0
    n, m, du = problem.n_points, problem.free.size, problem.jump(x) if jump is None else jump
    p, largest_free = x[:m], float(np.abs(problem.free + problem.points.jump @ x[m:]).max())
    length = max(largest_free, float((problem.points.scale * np.abs(p)).max()))
    traction = max(float(np.abs(p).max()), problem.least_traction)
    if length == 0.0:
        return problem.imbalance(x)
    gap, slip, b = opening(problem, du) / length, du[n:] / length, shear_bound(problem, p[:n])
    violations = (
        np.abs(np.minimum(gap, -p[:n] / traction)),
        np.maximum(np.abs(p[n:]) - b, 0.0) / traction,
        np.minimum(np.maximum(slip, 0.0), np.abs(b - p[n:]) / traction),
        np.minimum(np.maximum(-slip, 0.0), np.abs(b + p[n:]) / traction),
    )
    return max(problem.imbalance(x), *(float(violation.max()) for violation in violations))
