"""The energy norm of stress: its square is the integral of stress . C^-1 stress, twice the strain energy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.solid.elasticity import PlaneElasticity


def energy_components(materials: Sequence[PlaneElasticity], stress: Floats, body: Ints) -> Floats:
    """Components (n, 3) sqrt(Pa) of stresses (n, 3) Pa: xx, yy, xy in bodies (n,), whose squares add up to s . C^-1 s.

    C^-1 is diagonal for xx + yy, xx - yy and xy.
    """
    factors = np.sqrt([(0.5 / (m.c11 + m.c12), 0.5 / (m.c11 - m.c12), 1.0 / m.c33) for m in materials])
    xx, yy, xy = stress.T
    return np.asarray(factors[body] * np.stack([xx + yy, xx - yy, xy], axis=1))


def energy_density(materials: Sequence[PlaneElasticity], stress: Floats, body: Ints) -> Floats:
    """stress . C^-1 stress (n,) J/m^3 of stresses (n, 3) Pa: xx, yy, xy in bodies (n,)."""
    return np.asarray(np.sum(energy_components(materials, stress, body) ** 2, axis=1))
