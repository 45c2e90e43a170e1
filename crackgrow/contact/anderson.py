"""Anderson's acceleration of a repetition that is nearly linear (Anderson 1965)."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

NO_CHANGE: Final = 1e-9
"""A change of the drift by less than this fraction is round-off."""


def accelerated(ends: list[Floats], drifts: list[Floats]) -> Floats:
    """The next ends (k,) of springs after `ends` (k,) that gave `drifts` (k,), by Anderson's method (1965).

    Where the drift is linear in the ends, as it is once the contact states are found, k steps suffice, however loose
    or stiff the springs. Steps that changed the drift by round-off alone say nothing and are left out.
    """
    steps = np.diff(np.array(ends), axis=0)[-len(ends[0]) :]
    changes = np.diff(np.array(drifts), axis=0)[-len(ends[0]) :]
    telling = np.abs(changes).max(axis=1, initial=0.0) > NO_CHANGE * np.abs(drifts[-1]).max()
    plain = ends[-1] + drifts[-1]
    if not telling.any():
        return plain
    share = np.linalg.lstsq(changes[telling].T, drifts[-1], rcond=NO_CHANGE)[0]
    return np.asarray(plain - share @ (steps + changes)[telling])
