"""Linear elasticity in the plane: isotropic, or transversely isotropic about the normal of planes of bedding."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import ElasticBedding
from crackgrow.cover.shapes import Roots, turned_roots
from crackgrow.solid.in_situ import NONE, InSitu


@dataclass(frozen=True, slots=True, eq=False)
class PlaneElasticity:
    """Stress (xx, yy, xy) = `matrix` times strain (xx, yy, 2 xy), and sigma_zz = `zz` times that stress.

    `initial` is the in-situ stress, which comes on top.
    """

    matrix: Floats  # (3, 3) Pa
    zz: Floats  # (3,)
    roots: Roots
    release: Floats  # (2, 2) 1/Pa: k . release k is the energy release rate of a tip with (K_II, K_I) = k in its axes
    initial: InSitu = NONE

    @property
    def young_prime(self) -> float:
        """E' (Pa), E / (1 - nu^2) in plane strain and E in plane stress; with bedding a mean of its directions."""
        return float(2.0 / np.trace(self.release))

    def turned(self, axes: Floats) -> PlaneElasticity:
        """The same in other axes, whose directions are the rows of (2, 2), without in-situ stress."""
        strain = _strain_in(axes.T)
        zz, release = self.zz @ _strain_in(axes).T, axes @ self.release @ axes.T
        return PlaneElasticity(strain.T @ self.matrix @ strain, zz, turned_roots(self.roots, axes), release)


def plane_elasticity(
    young: float, poisson: float, plane: Literal["strain", "stress"], bedding: ElasticBedding | None = None
) -> PlaneElasticity:
    """Elasticity for Young's modulus (Pa) and Poisson's ratio, with bedding along its planes, in the plane.

    With x along the planes of bedding, y across them and z out of the plane, strain (xx, yy, zz, 2 xy) is a compliance
    times stress; plane strain leaves that of b_ij = a_ij - a_iz a_jz / a_zz (Lekhnitskii 1963, section 21). Without a
    shear modulus it is that of Saint-Venant, 1 / G' = 1 / E + (1 + 2 nu') / E'.
    """
    across = ElasticBedding(0.0, young, poisson) if bedding is None else bedding
    shear = 1.0 / across.shear if across.shear else 1.0 / young + (1.0 + 2.0 * across.poisson) / across.young
    full = np.diag([1.0 / young, 1.0 / across.young, 1.0 / young, shear])
    full[0, 1] = full[1, 0] = full[1, 2] = full[2, 1] = -across.poisson / across.young
    full[0, 2] = full[2, 0] = -poisson / young
    inside, of_zz = np.delete(np.delete(full, 2, 0), 2, 1), np.delete(full[2], 2)
    zz = -of_zz / full[2, 2] if plane == "strain" else np.zeros(3)
    compliance = inside + np.outer(of_zz, zz)
    # a_11 s^4 + (2 a_12 + a_66) s^2 + a_22 = 0, whose roots with positive imaginary parts have real sums of squares
    product = -np.sqrt(compliance[1, 1] / compliance[0, 0])
    total = np.sqrt((2.0 * compliance[0, 1] + compliance[2, 2]) / compliance[0, 0] - 2.0 * product)
    half = 0.5j * float(total)
    apart = (half**2 - float(product)) ** 0.5  # of two equal roots round-off alone
    release = 0.5 * np.diag([compliance[0, 0] * total, -compliance[1, 1] * total / product])
    c, s = np.cos(np.deg2rad(across.angle)), np.sin(np.deg2rad(across.angle))
    roots = (1j, 1j) if bedding is None else (half + apart, half - apart)
    along_planes = PlaneElasticity(np.linalg.inv(compliance), zz, roots, release)
    return along_planes.turned(np.array([[c, -s], [s, c]]))


def _strain_in(axes: Floats) -> Floats:
    """The matrix (3, 3) that turns strain xx, yy, 2 xy into that of axes whose directions are the rows of (2, 2)."""
    (c, s), _ = axes
    return np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2.0 * c * s, 2.0 * c * s, c * c - s * s]])


def energy_components(materials: Sequence[PlaneElasticity], stress: Floats, body: Ints) -> Floats:
    """Components (n, 3) sqrt(Pa) of stresses (n, 3) Pa, in bodies (n,), whose squares add up to s . C^-1 s."""
    factors = np.array([np.linalg.cholesky(np.linalg.inv(material.matrix)) for material in materials])
    return np.asarray(np.einsum("ni,nij->nj", stress, factors[body]))


def principal(stress: Floats) -> tuple[Floats, Floats, Floats]:
    """Principal stresses s1 >= s3 (n,) Pa and the angle (n,) rad of s1's axis from +x, for stresses (n, 3)."""
    xx, yy, xy = stress.T
    centre, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    radius = np.hypot(half, xy)
    return centre + radius, centre - radius, 0.5 * np.arctan2(xy, half)
