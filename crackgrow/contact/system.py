"""The rock as its contact points see it: condensed to the compliance between all of them, unless they are many.

Gap and slip are free - A p + B a, with A = G K0^-1 G' W between all points and B the jumps in the rigid motions a of
pieces that contact alone holds (traction form of paper eqs. (15), (16): no penalty enters K, and k = infinity is
allowed). K0 holds such pieces by supports that are just enough. All is found whole, once and only when needed, so that
its bits do not depend on what was asked for first.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.sparse import csr_array, vstack

from crackgrow.arrays import Bools, Floats, Ints, key_of
from crackgrow.contact.coulomb import ContactLaw
from crackgrow.contact.points import CondensedPoints, RockPoints
from crackgrow.contact.sparse_points import SparsePoints
from crackgrow.errors import NotSolvedError
from crackgrow.linear import ConstrainedSystem
from crackgrow.solid.rigid_modes import RigidMotions

FEW_NUMBERS = 1_000_000
"""Up to so many numbers the displacements per unit traction are solved for and kept: each state then costs no solve.

Beyond that one elimination gives the compliance alone. Measured: one load costs about the same either way.
"""

ROUGH = 1e-6
"""Jumps under some tractions that elimination misses by more, relative to the largest, are solved for, and refined.

Less is put right by the jumps of the displacements themselves (`Increment.formed`). On a map of 56 joints 814 of 5,574
are off by 1e-8 to 3e-8: to solve for what is as rough as that took 27 s, or 12 GB where it was most.
"""

DOUBTFUL = 0.1
"""Times what is rough: points whose jumps differ by more are solved for where those of others are rough."""

MANY = 0.25
"""Of all loads: where more of them are to be solved for, all are."""

MOST_CONDENSED = 1500
"""Points. Measured with one load: of 1,500 both take a second, of 2,800 the compliance 7 and the factors 3."""

MOST_ROWS = 20_000
"""Of a compliance: it takes 3.2 GB, and its factors as much."""

AT_HAND = 2
"""Sets of points of which the compliance is kept: increments try the same ones, with those that overlap and without."""

UNSYMMETRIC = 1e-2
"""A compliance of contact that is unsymmetric by more than this fraction of its largest entry is refused."""


@dataclass(frozen=True, eq=False)
class ContactSystem:
    """All that the contact points need of the rock."""

    system: ConstrainedSystem
    gap_of: csr_array  # (n, n_dofs)
    slip_of: csr_array  # (n, n_dofs)
    weights: Floats  # (n,) m, length of every contact point
    law: ContactLaw
    solver: Literal["newton", "lemke"]
    loose: RigidMotions | None = None  # of pieces that contact alone holds; `system` holds each of them just once
    loads: Floats = field(default_factory=lambda: np.zeros((0, 0)))  # (n_dofs, l) N/m, what acts besides tractions
    given: Floats = field(default_factory=lambda: np.zeros((0, 0)))  # (m, l) m, at supports beside each of the loads

    @cached_property
    def operator(self) -> csr_array:
        """G (2 n, n_dofs): gaps of all points, then slips."""
        operator = csr_array(vstack([self.gap_of, self.slip_of], format="csr"))
        operator.sum_duplicates()  # now: `abs` does so in place, and sums would have other bits after it than before
        return operator

    @cached_property
    def operator_sizes(self) -> csr_array:
        """|G|, entry by entry: of |u| it makes the terms that jumps are the sums of."""
        return abs(self.operator)

    def release(self) -> None:
        """Let go of what is large, with which nothing is solved any more."""
        self.system.release()
        for points in self.__dict__.pop("_condensed", {}).values():
            points.release()

    @property
    def without_tractions(self) -> tuple[Floats, Floats]:
        """Displacements (n_dofs, l) m and multipliers (m, l) under each of the loads alone."""
        return self._at_once[:2]

    @cached_property
    def _at_once(self) -> tuple[Floats, Floats, Floats, Floats]:
        """What is `without_tractions`, and displacements and multipliers of what is asked of the rock besides.

        These are those per unit traction that there can be, where they are few, or those under `_push`. They are solved
        for together: factors are read once.
        """
        more = self._tractions[:, self._can_be].toarray() if self._few else (self.operator.T @ self._push)[:, None]
        (m, n_dofs), k = self.system.constraints.shape, self.loads.shape[1]
        loads, given = np.zeros((n_dofs, k + more.shape[1])), np.zeros((m, k + more.shape[1]))
        if k:
            loads[:, :k], given[:, :k] = self.loads, self.given
        loads[:, k:] = more
        u, multipliers = np.zeros(loads.shape), np.zeros(given.shape)
        some = loads.any(axis=0) | given.any(axis=0)
        if some.any():
            u[:, some], multipliers[:, some] = self.system.solve(loads[:, some], given[:, some])
        return u[:, :k], multipliers[:, :k], u[:, k:], multipliers[:, k:]

    @property
    def _tractions(self) -> csr_array:
        """Forces G' W (n_dofs, 2 n) N/m of unit tractions."""
        return csr_array(self.operator.T * np.tile(self.weights, 2))

    @property
    def _can_be(self) -> Bools:
        """Which tractions (2 n,) there can be: faces without friction and cohesion carry no shear."""
        return np.append(np.ones(len(self.weights), dtype=bool), self.law.resists)

    @property
    def _push(self) -> Floats:
        """Forces (2 n,) N/m of tractions at all points at once, which tell where elimination is rough."""
        signs = np.random.default_rng(0).choice([-1.0, 1.0], 2 * len(self.weights))
        return np.asarray(np.tile(self.weights, 2) * signs)

    @cached_property
    def rock(self) -> Floats:
        """G K0^-1 G' W (2 n, 2 n) m/Pa: gap and slip that unit tractions take away."""
        compliance = None if self._few else self._refined(self.system.compliance(self.operator))
        return self._solved_for() if compliance is None else compliance

    def _solved_for(self) -> Floats:
        """The same from the displacements per unit traction.

        Raises NotSolvedError where round-off has spoilt it: it comes from a symmetric matrix (Betti).
        """
        rock = np.asarray(self.operator @ self._per_traction[0])
        can_be = np.flatnonzero(self._can_be)
        symmetric = rock[np.ix_(can_be, can_be)] / np.tile(self.weights, 2)[can_be]
        off, largest = (float(np.abs(part).max(initial=0.0)) for part in (symmetric - symmetric.T, symmetric))
        if off > UNSYMMETRIC * largest:
            raise ill_conditioned(f"unsymmetric by {off / largest:.1g} of its largest entry")
        return rock

    def _refined(self, compliance: Floats) -> Floats | None:
        """G K0^-1 G' W of G K0^-1 G' by elimination; None where that is rough at too many points.

        Mostly it is at a few, where functions nearly depend on others: their loads are solved for. That tells them from
        others, too, at which the solution for tractions at all points is what is rough.
        """
        known = self.operator @ self._at_once[2][:, 0]
        off, size = np.abs(compliance @ self._push - known), ROUGH * float(np.abs(known).max(initial=0.0))
        if off.max(initial=0.0) > size:
            some = np.flatnonzero(off > DOUBTFUL * size)
            if len(some) > MANY * len(off):
                return None
            columns = self.operator @ self.system.solve(self.operator[some].T.toarray())[0]
            columns[some] = 0.5 * (columns[some] + columns[some].T)
            compliance[:, some], compliance[some] = columns, columns.T
        compliance *= np.tile(self.weights, 2)
        return compliance

    def with_law(self, law: ContactLaw) -> ContactSystem:
        """The same rock behind another law; what is known of it stays known where the same points resist slip."""
        other, known = replace(self, law=law), {"operator", "operator_sizes", "moving", "force"}
        if np.array_equal(law.resists, self.law.resists):
            known |= {"rock", "_at_once", "_per_traction", "sparse"}
        other.__dict__.update({name: self.__dict__[name] for name in known if name in self.__dict__})
        return other

    @property
    def _few(self) -> bool:
        """Whether displacements per unit traction are few numbers: what to find is the same whatever is asked for."""
        return self.loose is None and self.operator.shape[0] * self.operator.shape[1] <= FEW_NUMBERS

    @cached_property
    def _per_traction(self) -> tuple[Floats, Floats]:
        """Displacements (n_dofs, 2 n) m and multipliers (m, 2 n) per unit traction; zero for those that can't be."""
        can_be, found = self._can_be, self._at_once[2:]
        if not self._few:
            found = self.system.solve(self._tractions[:, can_be].toarray())
        u, multipliers = (np.zeros((len(some), len(can_be))) for some in found)
        u[:, can_be], multipliers[:, can_be] = found
        return u, multipliers

    @cached_property
    def moving(self) -> Floats:
        """B (2 n, l): gap and slip in each of the rigid motions that supports leave free."""
        return np.zeros((2 * len(self.weights), 0)) if self.loose is None else self.loose.seen_by(self.operator)

    @cached_property
    def force(self) -> Floats:
        """F (l, 2 n), N/m per Pa: what tractions do on each of these motions."""
        return (self.moving * np.tile(self.weights, 2)[:, None]).T

    @cached_property
    def sparse(self) -> bool:
        """Whether the rock is kept as its factors, and not condensed."""
        return self.solver == "newton" and len(self.weights) > MOST_CONDENSED

    def condense(self) -> None:
        """Condense the rock after all. Raises NotSolvedError where its points are too many."""
        if self.operator.shape[0] > MOST_ROWS:
            raise NotSolvedError(
                f"{len(self.weights)} contact points are too many to be condensed, as they are where faces that have "
                "slipped dilate, or slip is not found otherwise: use a larger numerics.contact.spacing"
            )
        self.release()
        self.__dict__.pop("scale", None)
        self.__dict__["sparse"] = False

    @cached_property
    def scale(self) -> Floats:
        """(2 n,) m/Pa: the diagonal of G K0^-1 G' W; of many points as if each function moved by itself."""
        if not self.sparse:
            return self.rock.diagonal()
        each = self.operator.multiply(self.operator) @ (1.0 / self.system.stiffness.diagonal())
        return np.asarray(each * np.tile(self.weights, 2))

    def condensed(self, points: Ints, resists: Bools, softer: Floats | None = None) -> RockPoints:
        """The rock as some points (k,) see it, elastic contact included, which may be `softer` (2 k,) m/Pa by so much.

        Slip that nothing `resists` (k,) has a row of its own that no other knows of: the rock may hold it altogether.
        Raises NotSolvedError where round-off has spoilt the compliance of the rock, which resists.
        """
        known: dict[bytes, RockPoints] = self.__dict__.setdefault("_condensed", {})
        key = key_of((points, resists) if softer is None else (points, resists, softer))
        if key not in known:
            while len(known) >= AT_HAND:
                known.pop(next(iter(known))).release()
            at, counts = (
                np.append(points, len(self.weights) + points),
                np.append(np.ones(len(points), dtype=bool), resists),
            )
            jump, force = self.moving[at] * counts[:, None], self.force[:, at] * counts
            weights = np.tile(self.weights[points], 2)
            if self.sparse:
                normal = np.tile(self.scale[points], 2)
                softness = np.where(counts, self.law.compliances[at], normal)
                scale = np.where(counts, self.scale[at] + softness, normal)
                rows = csr_array(self.operator[at].multiply(counts[:, None]))
                rows.eliminate_zeros()
                found: RockPoints = SparsePoints(self.system, rows, jump, force, weights, softness, scale)
            else:
                found = CondensedPoints(self._compliance(points, resists), jump, force, weights)
            known[key] = found if softer is None else found.softer(softer)
        return known[key]

    def _compliance(self, points: Ints, resists: Bools) -> Floats:
        """A (2 k, 2 k) of some points (k,), elastic contact included."""
        k, at = len(points), np.concatenate([points, len(self.weights) + points[resists]])
        soft = self.law.compliances[at]
        whole = len(at) == len(self.rock) and not soft.any()  # it is large: not twice
        rock: Floats = self.rock if whole else self.rock[np.ix_(at, at)]
        if float(rock.diagonal().min()) <= 0.0:
            raise ill_conditioned("not positive")
        if soft.any():
            rock[np.diag_indices_from(rock)] += soft
        if len(rock) == 2 * k:
            return rock
        rows = np.concatenate([np.arange(k), k + np.flatnonzero(resists)])
        compliance = np.diag(np.tile(rock.diagonal()[:k], 2))
        compliance[np.ix_(rows, rows)] = rock
        return compliance

    def displacements(
        self, loads: tuple[Floats, Floats], without: tuple[Floats, Floats], tractions: Floats, motion: Floats
    ) -> tuple[Floats, Floats]:
        """Displacements (n_dofs,) m and multipliers (m,) under loads (n_dofs,) N/m, and given (m,) m at supports.

        `without` are those without tractions. These are all normals, then all tangentials (2 n,) Pa, `motion` (l,) the
        amplitudes of rigid motions: supports that follow pieces carry nothing. Under single tractions pieces turn much
        farther than under all. With k columns in each array it is k states, found together.

        Slivers of rock bend far more under single tractions than under all: what the sum of these loses is made good.
        """
        force = loads[0] - self.operator.T @ (np.tile(self.weights, 2) * tractions.T).T
        if self._few:
            u, multipliers = (free - per @ tractions for free, per in zip(without, self._per_traction, strict=True))
            return self.system.corrected((u, multipliers), force, loads[1])
        return self.system.solve(force if self.loose is None else force + self.loose.carrying(motion), loads[1])


def ill_conditioned(what: str) -> NotSolvedError:
    """The error where the compliance of the rock is `what`."""
    return NotSolvedError(
        f"the system is ill conditioned: the compliance of the rock between contact points is {what}; a sliver of rock "
        "or a crack's tip may lie too close to a lattice line: change numerics.spacing or the crack a little"
    )
