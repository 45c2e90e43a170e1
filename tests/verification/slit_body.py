"""Exact K of a straight, traction-free crack at the middle of a body of any outline, by boundary collocation.

Muskhelishvili's potentials for a slit along |x| < a,

    sigma_yy - i sigma_xy = Phi(z) + Omega(conj z) + (z - conj z) conj(Phi'(z)),
    sigma_xx + sigma_yy = 4 Re Phi,    Phi = E(z)/sqrt(z^2 - a^2) + D(z) + f(z)/2,    Omega = E/sqrt - D + f/2,

carry exactly the traction f on both faces for any power series E and D, which least squares fit to the tractions of
the outline. It converges exponentially where the outline's tractions are smooth: the residual tells. An infinite plate
under uniform stress has E = S z, D constant. K_I - i K_II = 2 sqrt(pi/a) E(a); in the mean of both faces E / sqrt falls
out, so that the stress along the crack at the tip, without what is singular, is T = Re(4 D(a) + f(a)).

The scenes are symmetric about the middle of the crack: E is odd, D and f are even.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Complexes = NDArray[np.complex128]


@dataclass(frozen=True)
class SlitSolution:
    """K and T of the tip at +a, and the largest traction by which the outline is missed."""

    K_I: float
    K_II: float  # positive where the upper face moves outward
    T: float  # the stress along the crack at the tip, without what is singular
    residual: float


def solve_slit(
    a: float, places: Complexes, normals: Complexes, tractions: Complexes, shear: float | None = None, n_terms: int = 30
) -> SlitSolution:
    """K of a slit |x| < a of a body whose outline has tractions (n,), as t_x + i t_y, at places with outward normals.

    Its faces are free, or, where `shear` is given, they are pressed together and slide: then E is imaginary, and their
    pressure is an unknown even series f that carries `shear` times as much shear: sigma_xy over sigma_yy.
    """
    size, columns, of_E, of_T = np.abs(places).max(), [], [], []
    for n in range(n_terms):
        for factor in (1.0, 1j) if shear is None else (1j,):
            of_E.append((len(columns), factor * (a / size) ** (2 * n + 1)))
            columns.append(_traction_of(a, places, normals, E=(factor, 2 * n + 1, size)))
        of_T.append((len(columns), 4.0 * (a / size) ** (2 * n)))
        for factor in (1.0, 1j):
            columns.append(_traction_of(a, places, normals, D=(factor, 2 * n, size)))
        if shear is not None:
            of_T.append((len(columns), (a / size) ** (2 * n)))
            columns.append(_traction_of(a, places, normals, f=(1.0 - 1j * shear, 2 * n, size)))
    matrix = np.array(columns).T
    matrix = np.concatenate([matrix.real, matrix.imag])
    right = np.concatenate([tractions.real, tractions.imag])
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale < 1e-12 * scale.max()] = np.inf  # an imaginary constant D is a rotation: no stress
    found = np.linalg.lstsq(matrix / scale, right, rcond=1e-14)[0] / scale
    K = 2.0 * np.sqrt(np.pi / a) * sum(found[column] * at_tip for column, at_tip in of_E)
    T = sum(found[column] * at_tip for column, at_tip in of_T)
    return SlitSolution(float(K.real), float(-K.imag), float(T), float(np.abs(matrix @ found - right).max()))


Term = tuple[complex, int, float] | None
"""A term of a power series: factor, power, and the length that the place is divided by."""


def _traction_of(
    a: float, z: Complexes, normal: Complexes, E: Term = None, D: Term = None, f: Term = None
) -> Complexes:
    """Traction t_x + i t_y (n,) of one term each of E, D and the face load f."""

    def power(term: Term, at: Complexes) -> tuple[Complexes, Complexes]:
        """A term and its derivative."""
        if term is None:
            return np.zeros((2, len(at)), dtype=complex)
        factor, n, size = term
        return factor * (at / size) ** n, factor * n / size * (at / size) ** max(n - 1, 0)

    def potentials(at: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """Phi, Phi' and Omega."""
        root = np.sqrt(at - a) * np.sqrt(at + a)
        (value, slope), (even, d_even), (load, d_load) = power(E, at), power(D, at), power(f, at)
        odd, d_odd = value / root, slope / root - value * at / root**3
        return odd + even + 0.5 * load, d_odd + d_even + 0.5 * d_load, odd - even + 0.5 * load

    phi, d_phi, _ = potentials(z)
    omega = potentials(z.conj())[2]
    lower = phi + omega + (z - z.conj()) * d_phi.conj()  # sigma_yy - i sigma_xy
    yy, xy, xx = lower.real, -lower.imag, 4.0 * phi.real - lower.real
    return (xx * normal.real + xy * normal.imag) + 1j * (xy * normal.real + yy * normal.imag)


def plate(a: float, angle_deg: float, width: float, height: float, stress_yy: float) -> SlitSolution:
    """A rectangular plate with an open crack of half length a at an angle to x, pulled by uniform tractions in y."""
    return solve_slit(a, *_plate(angle_deg, width, height, (0.0, stress_yy, 0.0)))


def closed_plate(
    a: float, angle_deg: float, width: float, height: float, stress: tuple[float, float, float], friction: float = 0.0
) -> SlitSolution:
    """The same plate under uniform tractions of a stress (xx, yy, xy) that presses the faces of the crack together.

    They slide everywhere against Coulomb friction, or nowhere, where friction holds a crack in an infinite plate.
    """
    xx, yy, xy = stress
    angle = np.deg2rad(angle_deg)
    normal = xx * np.sin(angle) ** 2 + yy * np.cos(angle) ** 2 - xy * np.sin(2.0 * angle)
    shear = 0.5 * (yy - xx) * np.sin(2.0 * angle) + xy * np.cos(2.0 * angle)
    if abs(shear) <= -friction * normal:
        along = xx * np.cos(angle) ** 2 + yy * np.sin(angle) ** 2 + xy * np.sin(2.0 * angle)
        return SlitSolution(0.0, 0.0, float(along), 0.0)
    return solve_slit(a, *_plate(angle_deg, width, height, stress), -float(np.sign(shear)) * friction)


def _plate(
    angle_deg: float, width: float, height: float, stress: tuple[float, float, float]
) -> tuple[Complexes, Complexes, Complexes]:
    """Places, outward normals and tractions (n,) of the outline, in the crack's axes."""
    xx, yy, xy = stress
    t = (np.cos(np.pi * (np.arange(200) + 0.5) / 200) + 0.0) * 0.5  # Chebyshev points: dense at the corners
    w, h = 0.5 * width, 0.5 * height
    sides = [
        (w + 1j * height * t, 1.0),
        (-w + 1j * height * t, -1.0),
        (width * t + 1j * h, 1j),
        (width * t - 1j * h, -1j),
    ]
    places = np.concatenate([side for side, _ in sides])
    normals = np.concatenate([np.full(len(t), normal, dtype=complex) for _, normal in sides])
    turn = np.exp(-1j * np.deg2rad(angle_deg))
    tractions = xx * normals.real + xy * normals.imag + 1j * (xy * normals.real + yy * normals.imag)
    return places * turn, normals * turn, tractions * turn
