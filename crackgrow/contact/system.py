"""What the contact points need of the rock: jumps, and displacements per unit traction."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.contact.law import ContactLaw
from crackgrow.solid.linear_solver import ConstrainedSystem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class ContactSystem:
    """All that the contact points need of the rock."""

    system: ConstrainedSystem
    gap_of: csr_array  # (n, n_dofs)
    slip_of: csr_array  # (n, n_dofs)
    weights: Floats  # (n,) m, length of every contact point
    law: ContactLaw
    solver: Literal["newton", "lemke"]
    loose: bool = False  # whether `system` holds pieces by springs, in whose compliance that of the rock is lost
    columns: _Columns = field(init=False, repr=False)  # displacements per unit traction, found when needed

    def __post_init__(self) -> None:
        object.__setattr__(self, "columns", _Columns(self.system, self.gap_of, self.slip_of, self.weights))


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
