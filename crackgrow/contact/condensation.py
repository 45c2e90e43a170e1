"""The rock condensed onto some of the contact points: their compliance, and what tractions there make of the rock."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.sparse import csr_array

from crackgrow.arrays import Floats, Ints
from crackgrow.solid.linear_solver import ConstrainedSystem

FEW_POINTS = 64
"""Up to so many points their jumps are all computed at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Rock:
    """A state of the rock."""

    u: Floats  # (n_dofs,) m
    multipliers: Floats  # (m,) of the supports
    gap: Floats  # (n,) m, at all contact points
    slip: Floats  # (n,) m


class Condensation(Protocol):
    """The rock under normal tractions at k contact points and tangential ones at l of them, t (k + l,) Pa."""

    compliance: Floats
    """(k + l, k + l) m/Pa, S W: gap and slip of these points that unit tractions take away."""

    def jumps(self, free: Rock, t: Floats) -> tuple[Floats, Floats]:
        """Gap and slip (n,) m of all points where the tractions are added to a state of the rock."""
        ...

    def displacements(self, free: Rock, loads: Floats, given: Floats, t: Floats) -> tuple[Floats, Floats]:
        """Displacements (n_dofs,) m and multipliers (m,) under `loads`, with `given` at supports, and tractions.

        `free` is the state without these.
        """
        ...


class BySolutions:
    """The condensation from displacements per unit traction."""

    def __init__(
        self, gap_of: csr_array, slip_of: csr_array, rows: Ints, sliding: Ints, responses: Floats, multipliers: Floats
    ) -> None:
        """`responses` (n_dofs, k + l) and `multipliers` (m, k + l) to tractions at `rows` (k,) and `sliding` (l,)."""
        self._gap_of, self._slip_of = gap_of, slip_of
        self._responses, self._multipliers = responses, multipliers
        self.compliance = np.concatenate([_jumps(gap_of, rows, responses), _jumps(slip_of, sliding, responses)])

    def jumps(self, free: Rock, t: Floats) -> tuple[Floats, Floats]:
        """As of `Condensation`: of the displacements."""
        u = free.u - self._responses @ t
        return self._gap_of @ u, self._slip_of @ u

    def displacements(self, free: Rock, loads: Floats, given: Floats, t: Floats) -> tuple[Floats, Floats]:
        """As of `Condensation`: the state without tractions less the responses to them."""
        return free.u - self._responses @ t, free.multipliers - self._multipliers @ t


class ByCompliance:
    """The condensation from the jumps of all contact points per unit traction."""

    def __init__(
        self,
        system: ConstrainedSystem,
        gap_and_slip_of: csr_array,
        weights: Floats,
        taken: Floats,
        rows: Ints,
        sliding: Ints,
    ) -> None:
        """`taken` (2 n, k + l) m/Pa is of all gaps, then all slips, of `gap_and_slip_of` (2 n, n_dofs).

        `weights` W (n,) m are the points' lengths.
        """
        self._system, self._gap_and_slip_of = system, gap_and_slip_of
        self._at = np.concatenate([rows, len(weights) + sliding])
        self._weights = np.tile(weights, 2)[self._at]
        self._taken = taken
        self.compliance = taken[self._at]

    def jumps(self, free: Rock, t: Floats) -> tuple[Floats, Floats]:
        """As of `Condensation`: those without tractions less what the compliance says."""
        gap, slip = np.split(self._taken @ t, 2)
        return free.gap - gap, free.slip - slip

    def displacements(self, free: Rock, loads: Floats, given: Floats, t: Floats) -> tuple[Floats, Floats]:
        """As of `Condensation`: solved for, with all loads together."""
        forces = np.zeros(self._gap_and_slip_of.shape[0])
        forces[self._at] = self._weights * t
        return self._system.solve(loads - self._gap_and_slip_of.T @ forces, given)


def _jumps(operator: csr_array, rows: Ints, responses: Floats) -> Floats:
    """Jumps (k, l) of the points `rows` (k,) in the displacements `responses` (n_dofs, l)."""
    if operator.shape[0] <= FEW_POINTS and len(rows):  # then taking rows out of a sparse matrix is what takes time
        return np.asarray((operator @ responses)[rows])
    return np.asarray(operator[rows] @ responses)
