"""Straight cracks that do not meet, in an infinite plate under uniform stress: K, stress and displacement.

Each crack is a distribution of dislocations along |x| < a in its own axes. With the density

    2 G / (i (kappa + 1)) d/dx [u + i v] = sum_n c_n T_n(s) / sqrt(1 - s^2),    s = x/a,    n = 1, 2, ..., N

(no n = 0: the displacement is single-valued) Muskhelishvili's potentials are Cauchy integrals with closed forms,

    Phi(z) = 1/(2 pi) int density/(x - z) dx = -1/2 sum c_n rho^n / sqrt(w^2 - 1),
    rho = w - sqrt(w^2 - 1),    w = z/a,    sigma_xx + sigma_yy = 4 Re Phi,
    sigma_yy + i sigma_xy = conj(Phi(z) + Phi(conj z)) + (conj z - z) Phi'(z),
    2 G (u + i v) = kappa phi(z) - phi(conj z) - (z - conj z) conj Phi(z),    phi = a/2 sum c_n rho^n / n,

so that a crack's own traction on its line is sum conj(c_n) U_{n-1}(s). The tractions of all cracks and of the uniform
stress are made what is given on the faces, at the zeros of U_N: the singular integral equations of Panasyuk, Savruk
and Datsyshyn (Engineering Fracture Mechanics 9, 1977, 481-497) by the Gauss-Chebyshev method of Erdogan and Gupta
(Quarterly of Applied Mathematics 29, 1972, 525-534), with the density as a series in place of its values. The
potentials satisfy elasticity for any c_n, so the tractions left over on the faces (`residual`) tell the whole error;
they fall exponentially with N. K_I - i K_II = -sqrt(pi a) sum c_n at s = 1, with (-1)^(n+1) c_n at s = -1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crackgrow.case.model import Formula

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Tip = Literal["start", "end"]


@dataclass(frozen=True, slots=True)
class StraightCrack:
    """A crack with uniform tractions on its faces."""

    x: float  # m, of its middle
    y: float  # m
    half_length: float  # m
    angle_deg: float  # from x, counter-clockwise
    normal: float = 0.0  # Pa, on the faces, positive in tension: minus the pressure of a fluid
    shear: float = 0.0  # Pa, on the faces, sigma_xy in axes along the crack

    @property
    def middle(self) -> complex:
        """x + i y of the middle, m."""
        return complex(self.x, self.y)

    @property
    def direction(self) -> complex:
        """Unit vector from start to end."""
        return complex(np.exp(1j * np.deg2rad(self.angle_deg)))

    @property
    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Start and end, m."""
        start = self.middle - self.half_length * self.direction
        end = self.middle + self.half_length * self.direction
        return (start.real, start.imag), (end.real, end.imag)


@dataclass(frozen=True, slots=True, eq=False)
class CrackArray:
    """The solved plate."""

    cracks: tuple[StraightCrack, ...]
    stress: tuple[float, float, float]  # Pa, far away: xx, yy, xy
    coefficients: tuple[Complexes, ...]  # (N,) Pa each, c_1 ... c_N
    residual: float  # Pa, largest traction on a face beyond what is given, between the points of collocation

    def K(self, crack: int, tip: Tip) -> tuple[float, float]:
        """K_I and K_II (Pa sqrt(m)); K_II positive where the face on the left of the tip's direction moves outward."""
        c = self.coefficients[crack]
        signs = np.ones(len(c)) if tip == "end" else (-1.0) ** np.arange(len(c))
        K = -np.sqrt(np.pi * self.cracks[crack].half_length) * (signs @ c)
        return float(K.real), float(-K.imag)

    def largest_K(self) -> float:
        """The largest |K_I - i K_II| (Pa sqrt(m)) of all tips."""
        tips: tuple[Tip, Tip] = ("start", "end")
        return max(float(np.hypot(*self.K(n, tip))) for n in range(len(self.cracks)) for tip in tips)

    def stress_at(self, points: Floats) -> Floats:
        """Stress (n, 3) Pa, xx, yy, xy, at points (n, 2) m off the cracks."""
        z = points[:, 0] + 1j * points[:, 1]
        xx, yy, xy = self.stress
        total = np.zeros(len(z)) + (xx + yy)
        deviator = np.zeros(len(z)) + complex(yy - xx, 2.0 * xy)
        for crack, c in zip(self.cracks, self.coefficients, strict=True):
            mean, turned = _stresses(crack, z, c.size)
            total += 4.0 * (mean @ c).real
            deviator += turned[0] @ c + turned[1] @ c.conj()
        return np.stack([0.5 * (total - deviator.real), 0.5 * (total + deviator.real), 0.5 * deviator.imag], axis=1)

    def opening_and_slip(self, crack: int, s: Floats, young_prime: float) -> tuple[Floats, Floats]:
        """Jump (n,) m of the displacement across and along a crack at s = x/a; the left face less the right one."""
        c = self.coefficients[crack]
        n = np.arange(1, len(c) + 1)
        sines = np.sin(np.arccos(s)[:, None] * n) / n
        jump = -4j / young_prime * self.cracks[crack].half_length * (sines @ c)
        return jump.imag, jump.real

    def displacement_at(self, points: Floats, young: float, poisson: float) -> Floats:
        """Displacement (n, 2) m in plane strain at points (n, 2) m off the cracks; no rotation far away."""
        z = points[:, 0] + 1j * points[:, 1]
        kappa, twice_shear_modulus = 3.0 - 4.0 * poisson, young / (1.0 + poisson)
        xx, yy, xy = self.stress
        u = 0.25 * (kappa - 1.0) * (xx + yy) * z - 0.5 * complex(yy - xx, -2.0 * xy) * z.conj()
        for crack, c in zip(self.cracks, self.coefficients, strict=True):
            place = (z - crack.middle) / crack.direction
            n = np.arange(1, len(c) + 1)
            _, rho, root = _joukowski(place / crack.half_length)
            across = _joukowski(place.conj() / crack.half_length)[1]
            phi = 0.5 * crack.half_length * (rho[:, None] ** n / n) @ c
            phi_across = 0.5 * crack.half_length * (across[:, None] ** n / n) @ c
            slope = -0.5 * (rho[:, None] ** n / root[:, None]) @ c
            u += crack.direction * (kappa * phi - phi_across - (place - place.conj()) * slope.conj())
        u /= twice_shear_modulus
        return np.stack([u.real, u.imag], axis=1)

    def displacement_formulas(self, young: float, poisson: float) -> tuple[Formula, Formula]:
        """The two components of `displacement_at`, to be prescribed along an edge."""
        return (
            lambda points: self.displacement_at(points, young, poisson)[:, 0],
            lambda points: self.displacement_at(points, young, poisson)[:, 1],
        )


def solve_crack_array(
    cracks: Sequence[StraightCrack], stress: tuple[float, float, float], n_terms: int = 60
) -> CrackArray:
    """K, stress and displacement of open cracks under a stress (xx, yy, xy) Pa far away, with N = n_terms."""
    s = np.cos(np.pi * np.arange(1, n_terms + 1) / (n_terms + 1))  # zeros of U_N
    size = 2 * n_terms * len(cracks)
    matrix = _traction_matrix(cracks, s, n_terms).reshape(size, size)
    wanted = np.concatenate([np.full(len(s), _given(crack, stress)) for crack in cracks])
    found = np.linalg.solve(matrix, np.stack([wanted.real, wanted.imag], axis=1).ravel()).reshape(-1, n_terms, 2)
    between = np.cos(np.pi * (np.arange(n_terms + 1) + 0.5) / (n_terms + 1))
    left = _traction_matrix(cracks, between, n_terms).reshape(-1, size) @ found.ravel()
    missed = left.reshape(len(cracks), -1, 2) - np.array(
        [[[g.real, g.imag]] for g in (_given(c, stress) for c in cracks)]
    )
    coefficients = tuple(c[:, 0] + 1j * c[:, 1] for c in found)
    return CrackArray(tuple(cracks), stress, coefficients, float(np.abs(missed).max()))


def _given(crack: StraightCrack, stress: tuple[float, float, float]) -> complex:
    """sigma_nn + i sigma_tn on the faces less that of the uniform stress: what the dislocations have to make."""
    xx, yy, xy = stress
    uniform = 0.5 * (xx + yy + complex(yy - xx, 2.0 * xy) * crack.direction**2)
    return complex(crack.normal, crack.shear) - uniform


def _traction_matrix(cracks: Sequence[StraightCrack], s: Floats, n_terms: int) -> Floats:
    """Parts of sigma_nn + i sigma_tn at s on every crack by the parts of every c: (cracks, s, 2, cracks, n, 2)."""
    matrix = np.empty((len(cracks), len(s), 2, len(cracks), n_terms, 2))
    theta = np.arccos(s)[:, None]
    own = np.sin(np.arange(1, n_terms + 1) * theta) / np.sin(theta)  # U_{n-1}
    for row, on in enumerate(cracks):
        z = np.asarray(on.middle + on.half_length * on.direction * s, dtype=np.complex128)
        for column, of in enumerate(cracks):
            if row == column:
                by_c, by_conj = np.zeros_like(own, dtype=complex), own.astype(complex)
            else:
                mean, (turned, turned_conj) = _stresses(of, z, n_terms)
                by_c = mean + 0.5 * on.direction**2 * turned
                by_conj = mean.conj() + 0.5 * on.direction**2 * turned_conj
            for part, factor in enumerate((1.0, 1j)):
                traction = factor * by_c + np.conj(factor) * by_conj
                matrix[row, :, 0, column, :, part] = traction.real
                matrix[row, :, 1, column, :, part] = traction.imag
    return matrix


def _stresses(crack: StraightCrack, z: Complexes, n_terms: int) -> tuple[Complexes, tuple[Complexes, Complexes]]:
    """Phi by c, and sigma_yy - sigma_xx + 2 i sigma_xy in the plate's axes by c and by conj c, each (n, N)."""
    a = crack.half_length
    place = (z - crack.middle) / crack.direction
    w, rho, root = (value[:, None] for value in _joukowski(place / a))
    n = np.arange(1, n_terms + 1)
    phi = -0.5 * rho**n / root
    slope = -phi * (n / root + w / root**2) / a
    away = (place.conj() - place)[:, None]
    turn = crack.direction**-2
    return phi, (2.0 * turn * (away * slope - phi), 2.0 * turn * phi)


def _joukowski(w: Complexes) -> tuple[Complexes, Complexes, Complexes]:
    """w, rho = w - sqrt(w^2 - 1) inside of the unit circle, and the root, cut along -1 < w < 1."""
    root = np.sqrt(w - 1.0) * np.sqrt(w + 1.0)
    return w, 1.0 / (w + root), root
