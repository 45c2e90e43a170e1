"""Linear functionals of the displacement near a place: rows of a matrix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats, Ints


@dataclass(frozen=True, slots=True, eq=False)
class Functional:
    """Linear functionals of the displacement near a place."""

    functions: Ints  # (k,) of a cover, ascending
    rows: Floats  # (q, k) of a component of the displacement, by the coefficients of these
    more: tuple[NDArray[Any], ...]  # that goes with it

    def of(self, u: Floats) -> Floats:
        """Their values (q, 2), by component, for the displacement `u` (n_dofs,)."""
        return np.asarray(self.rows @ u.reshape(-1, 2)[self.functions])
