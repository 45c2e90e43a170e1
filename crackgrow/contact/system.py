"""What the contact points need of the rock: jumps, and displacements per unit traction."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.sparse import csr_array, vstack

from crackgrow.arrays import Floats, Ints
from crackgrow.contact.condensation import ByCompliance, BySolutions, Condensation
from crackgrow.contact.law import ContactLaw
from crackgrow.solid.linear_solver import ConstrainedSystem
from crackgrow.solid.rigid_modes import RigidMotions

FEW_NUMBERS = 1_000_000
"""Up to so many numbers the displacements per unit traction at all contact points are solved for, as they are needed.

Measured: one load then costs about the same by elimination, and each further one more, a solve that columns save.
"""


@dataclass(frozen=True, slots=True, eq=False)
class ContactSystem:
    """All that the contact points need of the rock."""

    system: ConstrainedSystem
    gap_of: csr_array  # (n, n_dofs)
    slip_of: csr_array  # (n, n_dofs)
    weights: Floats  # (n,) m, length of every contact point
    law: ContactLaw
    solver: Literal["newton", "lemke"]
    loose: RigidMotions | None = None  # of pieces that contact alone holds; `system` holds each of them just once
    columns: _Columns = field(init=False, repr=False)  # displacements per unit traction, found when needed
    _between: _Between = field(init=False, repr=False)  # the compliance between the points, found when needed

    def __post_init__(self) -> None:
        object.__setattr__(self, "columns", _Columns(self.system, self.gap_of, self.slip_of, self.weights))
        object.__setattr__(self, "_between", _Between(self.system, self.gap_of, self.slip_of))

    def onto(self, rows: Ints, sliding: Ints) -> Condensation:
        """The rock condensed onto the normal tractions of points `rows` (k,) and the tangential ones of `sliding` (l,).

        Which way depends on nothing but the system. Columns take memory and time in proportion to unknowns and points,
        but then give displacements without any other solve. Where they are many the compliance of all points is found
        at once by elimination alone. The displacements of pieces that contact holds are always solved for: under single
        tractions supports let them turn much farther than under all.
        """
        operator, between = self._between.operator, None
        if self.loose is not None or 2 * self.gap_of.shape[0] * self.gap_of.shape[1] > FEW_NUMBERS:
            between = self._between.compliance
        if between is not None:
            at = np.concatenate([rows, len(self.weights) + sliding])
            taken = between[:, at] * np.tile(self.weights, 2)[at]
            return ByCompliance(self.system, operator, self.weights, taken, rows, sliding)
        responses = self.columns.of(rows, sliding)
        if self.loose is not None:
            return ByCompliance(self.system, operator, self.weights, operator @ responses, rows, sliding)
        multipliers = self.columns.multipliers(rows, sliding)
        return BySolutions(self.gap_of, self.slip_of, rows, sliding, responses, multipliers)

    def jumps_of(self, motions: csr_array) -> Floats:
        """Gap, then slip (2 n, k) of all points in displacements (n_dofs, k)."""
        return np.asarray((self._between.operator @ motions).toarray())

    @property
    def moving(self) -> Floats:
        """Gap, then slip (2 n, l) of all points in each of the rigid motions that supports leave free."""
        return self._between.moving(self.loose)


class _Columns:
    """Displacements per unit traction of contact points, K0^-1 G' W, each solved for once and only when needed."""

    def __init__(self, system: ConstrainedSystem, gap_of: csr_array, slip_of: csr_array, weights: Floats) -> None:
        self._system, self._weights = system, weights
        self._operators = (gap_of, slip_of)
        self._known: tuple[dict[int, tuple[Floats, Floats]], ...] = ({}, {})  # of gap, of slip
        self._batches: list[tuple[Ints, Ints]] = []

    @property
    def batches(self) -> tuple[tuple[Ints, Ints], ...]:
        """The points of gap and of slip that were solved for together, in turn: in others, round-off is another."""
        return tuple(self._batches)

    def of(self, rows: Ints, sliding: Ints) -> Floats:
        """(n_dofs, k + l) for normal tractions at points `rows` (k,) and tangential ones at `sliding` (l,)."""
        self._find(rows, sliding)
        columns = [u for u, _ in self._parts(rows, sliding)]
        return np.stack(columns, axis=1) if columns else np.empty((self._operators[0].shape[1], 0))

    def multipliers(self, rows: Ints, sliding: Ints) -> Floats:
        """(m, k + l) support multipliers per unit traction; of columns that are known."""
        return np.stack([multipliers for _, multipliers in self._parts(rows, sliding)], axis=1)

    def _parts(self, rows: Ints, sliding: Ints) -> list[tuple[Floats, Floats]]:
        pairs = zip(self._known, (rows, sliding), strict=True)
        return [known[row] for known, wanted in pairs for row in wanted.tolist()]

    def _find(self, rows: Ints, sliding: Ints) -> None:
        """Solve for all columns that are not known yet, at once."""
        pairs = zip(self._known, (rows, sliding), strict=True)
        new = [[row for row in wanted.tolist() if row not in known] for known, wanted in pairs]
        if not any(new):
            return
        forces = [(op[some].T * self._weights[some]).toarray() for op, some in zip(self._operators, new, strict=True)]
        u, multipliers = self._system.solve(np.concatenate(forces, axis=1))
        self._batches.append((np.array(new[0], dtype=np.int64), np.array(new[1], dtype=np.int64)))
        found = zip(u.T, multipliers.T, strict=True)
        for known, some in zip(self._known, new, strict=True):
            known.update({row: next(found) for row in some})


class _Between:
    """The compliance between all contact points, S = G K0^-1 G', found once and only when needed."""

    def __init__(self, system: ConstrainedSystem, gap_of: csr_array, slip_of: csr_array) -> None:
        self._system, self._operators = system, (gap_of, slip_of)
        self._moving: Floats | None = None

    @cached_property
    def operator(self) -> csr_array:
        """G (2 n, n_dofs), gaps first."""
        return csr_array(vstack(self._operators, format="csr"))

    def moving(self, loose: RigidMotions | None) -> Floats:
        """Jumps (2 n, l) in the motions."""
        if self._moving is None:
            self._moving = np.zeros((self.operator.shape[0], 0)) if loose is None else loose.seen_by(self.operator)
        return self._moving

    @cached_property
    def compliance(self) -> Floats | None:
        """S (2 n, 2 n), None where elimination alone does not give it."""
        return self._system.compliance(self.operator)
