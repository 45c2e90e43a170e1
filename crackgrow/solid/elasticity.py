"""Isotropic linear elasticity in the plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.solid.in_situ import NONE, InSitu


@dataclass(frozen=True, slots=True)
class PlaneElasticity:
    """sigma_xx = c11 e_xx + c12 e_yy, sigma_xy = c33 2 e_xy, sigma_zz = zz (sigma_xx + sigma_yy).

    `initial` is the in-situ stress, which comes on top.
    """

    c11: float  # Pa
    c12: float  # Pa
    c33: float  # Pa, the shear modulus
    zz: float
    young_prime: float  # Pa: E' = E / (1 - nu^2) in plane strain, E in plane stress
    initial: InSitu = NONE

    @property
    def matrix(self) -> Floats:
        """(3, 3) Pa, for the strain (e_xx, e_yy, 2 e_xy)."""
        return np.array([[self.c11, self.c12, 0.0], [self.c12, self.c11, 0.0], [0.0, 0.0, self.c33]])


def plane_elasticity(young: float, poisson: float, plane: Literal["strain", "stress"]) -> PlaneElasticity:
    """Elasticity for Young's modulus (Pa) and Poisson's ratio in plane strain or plane stress."""
    shear_modulus = young / (2.0 * (1.0 + poisson))
    if plane == "stress":
        e_prime = young
        c11 = young / (1.0 - poisson**2)
        return PlaneElasticity(c11, poisson * c11, shear_modulus, 0.0, e_prime)
    scale = young / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    return PlaneElasticity(scale * (1.0 - poisson), scale * poisson, shear_modulus, poisson, young / (1.0 - poisson**2))


def energy_components(materials: Sequence[PlaneElasticity], stress: Floats, body: Ints) -> Floats:
    """Components (n, 3) sqrt(Pa) of stresses (n, 3) Pa: xx, yy, xy in bodies (n,), whose squares add up to s . C^-1 s.

    C^-1 is diagonal for xx + yy, xx - yy and xy.
    """
    factors = np.sqrt([(0.5 / (m.c11 + m.c12), 0.5 / (m.c11 - m.c12), 1.0 / m.c33) for m in materials])
    xx, yy, xy = stress.T
    return np.asarray(factors[body] * np.stack([xx + yy, xx - yy, xy], axis=1))


def principal(stress: Floats) -> tuple[Floats, Floats, Floats]:
    """Principal stresses s1 >= s3 (n,) Pa and the angle (n,) rad of s1's axis from +x, for stresses (n, 3)."""
    xx, yy, xy = stress.T
    centre, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    radius = np.hypot(half, xy)
    return centre + radius, centre - radius, 0.5 * np.arctan2(xy, half)
