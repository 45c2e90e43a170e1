"""The linear solve K u + C' m = f, C u - B m = g: a stiffness, positive semidefinite, with linear constraints.

B is a diagonal, zero for the constraints that hold what K leaves free. The others, which may be compliant, are ties of
what these hold.

One factorization serves many loads. The forces that its solution leaves unbalanced are solved for in turn, until they
are round-off.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, vstack

from crackgrow.arrays import Floats, Ints
from crackgrow.errors import SolveError
from crackgrow.linear.factorization import AT_ONCE, Factorization
from crackgrow.linear.matrix import SymmetricMatrix

REFINEMENTS = 3
"""Most corrections for round-off."""

ROUND_OFF = 1e-14
"""Residuals below this fraction of the terms that they are sums of are round-off."""

INCONSISTENT = 1e-6
"""A constraint that misses more than this fraction of what it prescribes, and of its terms, contradicts others."""


class ConstrainedSystem:
    """K with constraints C u - B m = g, factorized once for many loads, when it is first solved."""

    def __init__(
        self,
        stiffness: SymmetricMatrix,
        constraints: csr_array,
        boxes: tuple[Ints, Ints],
        compliance: Floats | None = None,
        n_holding: int | None = None,
    ) -> None:
        """`stiffness` (n, n) Pa, `constraints` (m, n), `boxes` of its functions: see `Factorization`.

        `compliance` (m,) is the diagonal of B, None where all of it is zero. The first `n_holding` constraints hold
        what K leaves free; None: all that are rigid, which come first.
        """
        self.stiffness = stiffness
        self.constraints = constraints
        self._share = abs(constraints)
        self._compliance = np.zeros(constraints.shape[0]) if compliance is None else compliance
        n = self._n_holding = int(np.sum(self._compliance == 0.0)) if n_holding is None else n_holding
        self._parts = csr_array(constraints[:n]), boxes, csr_array(constraints[n:]), self._compliance[n:]

    @cached_property
    def _factorization(self) -> Factorization:
        """The factors. Raises SolveError where there are none."""
        return Factorization(self.stiffness, *self._parts)

    def factorize(self) -> None:
        """Factorize now, before anything is solved. Raises SolveError where there are no factors."""
        _ = self._factorization

    def tied(self, rows: csr_array, softness: Floats) -> ConstrainedSystem:
        """The system with more constraints (k, n), of a compliance `softness` (k,): ties of what is held."""
        constraints = csr_array(vstack([self.constraints, rows], format="csr"))
        compliance = np.append(self._compliance, softness)
        return ConstrainedSystem(self.stiffness, constraints, self._parts[1], compliance, self._n_holding)

    def release(self) -> None:
        """Let go of the factors: nothing is solved for some time."""
        self.__dict__.pop("_factorization", None)

    def solve(self, loads: Floats, given: Floats | None = None) -> tuple[Floats, Floats]:
        """Displacements (n,) or (n, k) and multipliers (m,) or (m, k) for loads (n,) or (n, k).

        `given` (m,) or (m, k) are the prescribed values g, zero if None; (m,) are those of all loads. Raises SolveError
        where constraints contradict.
        """
        n, m = self.constraints.shape[1], self.constraints.shape[0]
        columns = loads.reshape(n, -1)
        each = np.zeros(m) if given is None else given
        wanted = np.broadcast_to(each[:, None] if each.ndim == 1 else each, (m, columns.shape[1]))
        u, multipliers = np.empty(columns.shape), np.empty((m, columns.shape[1]))
        for start in range(0, columns.shape[1], AT_ONCE):
            block = slice(start, start + AT_ONCE)
            found = self._factorization.solve(columns[:, block], wanted[:, block])
            u[:, block], multipliers[:, block] = self._corrected(found, columns[:, block], wanted[:, block])
        given_in = wanted[: self._n_holding].any(axis=0)  # the others contradict nothing
        if given_in.any():
            self._check_agreement(wanted[:, given_in])
        return u.reshape(loads.shape), multipliers.reshape(m, *loads.shape[1:])

    def _check_agreement(self, wanted: Floats) -> None:
        """Raise SolveError where no displacement takes the values `wanted` (m, k), whatever the loads are."""
        nothing = np.zeros((self.constraints.shape[1], wanted.shape[1]))
        u, multipliers = self._corrected(self._factorization.solve(nothing, wanted), nothing, wanted)
        left = np.abs(self.constraints @ u - self._compliance[:, None] * multipliers - wanted)
        if np.any(left > INCONSISTENT * (np.abs(wanted) + self._share @ np.abs(u))):
            raise SolveError(f"the supports contradict each other by {left.max():.3g} m")

    def compliance(self, rows: csr_array) -> Floats:
        """G x (k, k) of `rows` G (k, n), the displacements x by the loads G', unrefined; symmetric to the last bit.

        G may have columns of multipliers besides, of ties: x has these then, too.
        """
        return self._factorization.compliance(rows)

    def unrefined(self, loads: Floats, given: Floats) -> tuple[Floats, Floats]:
        """What `solve` gives for loads (n,) and `given` (m,), as the factors give it."""
        u, multipliers = self._factorization.solve(loads[:, None], given[:, None])
        return u[:, 0], multipliers[:, 0]

    def corrected(self, found: tuple[Floats, Floats], loads: Floats, given: Floats) -> tuple[Floats, Floats]:
        """What `solve` gives for loads (n,) or (n, k) and `given` (m,) or (m, k), from what was `found` otherwise.

        Nothing is changed where that misses no more than round-off.
        """
        u, multipliers = found
        columns = loads.reshape(len(loads), -1)
        wanted = given.reshape(len(given), columns.shape[1])
        near = (u.reshape(columns.shape), multipliers.reshape(wanted.shape))
        better = self._corrected(near, columns, wanted)
        return better[0].reshape(u.shape), better[1].reshape(multipliers.shape)

    def _corrected(self, found: tuple[Floats, Floats], loads: Floats, wanted: Floats) -> tuple[Floats, Floats]:
        """Displacements (n, k) and multipliers (m, k) for loads (n, k) with C u = `wanted` (m, k), from those `found`.

        Corrections go on until residuals are round-off by the terms that they are sums of, or gain no more, in one sum
        of all columns with signs at random: products with all of them cost more than their solutions.
        """
        (u, multipliers), sign, last = found, _signs(loads), np.inf
        for _ in range(REFINEMENTS):
            error = self._backward_error(loads @ sign, wanted @ sign, u @ sign, multipliers @ sign)
            if error <= ROUND_OFF or error > 0.5 * last:
                break
            last = error
            residual = loads - self.stiffness @ u - self.constraints.T @ multipliers
            missed = wanted - self.constraints @ u + self._compliance[:, None] * multipliers
            du, dm = self._factorization.solve(residual, missed)
            u, multipliers = u + du, multipliers + dm
        return u, multipliers

    def _backward_error(self, loads: Floats, wanted: Floats, u: Floats, multipliers: Floats) -> float:
        """The largest residual of both equations, row by row relative to the absolute terms (Oettli, Prager 1964)."""
        forces = loads - self.stiffness @ u - self.constraints.T @ multipliers
        forces_of = np.abs(loads) + self.stiffness.sizes(u) + self._share.T @ np.abs(multipliers)
        given = self._compliance * multipliers
        moved, moved_of = (
            wanted - self.constraints @ u + given,
            np.abs(wanted) + self._share @ np.abs(u) + np.abs(given),
        )
        residual, terms = np.append(forces, moved), np.append(forces_of, moved_of)
        return float(np.max(np.abs(residual[terms > 0.0]) / terms[terms > 0.0], initial=0.0))


def _signs(loads: Floats) -> Floats:
    """Weights (k,) of the columns of `loads` (n, k) in a sum of them all: alike in size, with signs at random."""
    if loads.shape[1] == 1:
        return np.ones(1)
    size = np.abs(loads).max(axis=0)
    sign = np.random.default_rng(0).choice([-1.0, 1.0], loads.shape[1])
    # nothing is left to refine of what is smaller
    return np.asarray(sign / np.where(size >= np.finfo(float).tiny, size, 1.0))
