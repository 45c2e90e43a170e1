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

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


@dataclass(frozen=True)
class SlitSolution:
    """K and T of the tip at +a, and the largest traction by which the outline is missed."""

    K_I: float
    K_II: float  # positive where the upper face moves outward
    T: float
    residual: float


def solve_slit(
    a: float, places: Complexes, normals: Complexes, tractions: Complexes, on_faces: Complexes, n_terms: int = 30
) -> SlitSolution:
    """K of a slit |x| < a of a body whose outline has tractions (n,), as t_x + i t_y, at places with outward normals.

    on_faces: coefficients of 1, z^2, z^4 ... of sigma_yy - i sigma_xy on the faces, as functions of z/a
    """
    size = np.abs(places).max()
    columns = []
    for n in range(n_terms):
        for factor in (1.0, 1j):
            columns.append(_traction_of(a, places, normals, (factor, 2 * n + 1, size), None, None))
            columns.append(_traction_of(a, places, normals, None, (factor, 2 * n, size), None))
    known = _traction_of(a, places, normals, None, None, on_faces)
    matrix = np.array(columns).T
    matrix = np.concatenate([matrix.real, matrix.imag])
    wanted = tractions - known
    right = np.concatenate([wanted.real, wanted.imag])
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale < 1e-12 * scale.max()] = np.inf  # an imaginary constant D is a rotation: no stress
    found = np.linalg.lstsq(matrix / scale, right, rcond=1e-14)[0] / scale
    of_E = found[0::4] + 1j * found[2::4]
    E_at_tip = sum(c * (a / size) ** (2 * n + 1) for n, c in enumerate(of_E))
    K = 2.0 * np.sqrt(np.pi / a) * E_at_tip
    of_D = found[1::4] + 1j * found[3::4]
    D_at_tip = sum(c * (a / size) ** (2 * n) for n, c in enumerate(of_D))
    T = float(4.0 * D_at_tip.real + on_faces.sum().real)
    return SlitSolution(float(K.real), float(-K.imag), T, float(np.abs(matrix @ found - right).max()))


def solve_closed_slit(
    a: float, places: Complexes, normals: Complexes, tractions: Complexes, shear_share: float, n_terms: int = 30
) -> SlitSolution:
    """K of the same slit with faces that are pressed together and slide: E and f are found with D.

    The faces stay together, so E is imaginary; their pressure is an unknown even series f that carries `shear_share`
    as much shear: sigma_xy over sigma_yy.
    """
    size = np.abs(places).max()
    columns = []
    for n in range(n_terms):
        columns.append(_traction_of(a, places, normals, (1j, 2 * n + 1, size), None, None))
        columns.append(_traction_of(a, places, normals, None, (1.0, 2 * n, size), None))
        columns.append(_traction_of(a, places, normals, None, (1j, 2 * n, size), None))
        on_faces = np.zeros(n + 1, dtype=complex)
        on_faces[n] = (1.0 - 1j * shear_share) * (a / size) ** (2 * n)
        columns.append(_traction_of(a, places, normals, None, None, on_faces))
    matrix = np.array(columns).T
    matrix = np.concatenate([matrix.real, matrix.imag])
    right = np.concatenate([tractions.real, tractions.imag])
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale < 1e-12 * scale.max()] = np.inf
    found = np.linalg.lstsq(matrix / scale, right, rcond=1e-14)[0] / scale
    E_at_tip = 1j * sum(c * (a / size) ** (2 * n + 1) for n, c in enumerate(found[0::4]))
    K = 2.0 * np.sqrt(np.pi / a) * E_at_tip
    powers = (a / size) ** (2 * np.arange(n_terms))
    T = float(4.0 * found[1::4] @ powers + found[3::4] @ powers)
    return SlitSolution(float(K.real), float(-K.imag), T, float(np.abs(matrix @ found - right).max()))


def _traction_of(
    a: float,
    z: Complexes,
    normal: Complexes,
    E: tuple[complex, int, float] | None,
    D: tuple[complex, int, float] | None,
    f: Complexes | None,
) -> Complexes:
    """Traction t_x + i t_y (n,) of one term each of E and D, (factor, power, length), and of the face load f."""

    def potentials(at: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """Phi, Phi' and Omega."""
        root = np.sqrt(at - a) * np.sqrt(at + a)
        odd, d_odd, even, d_even, half, d_half = np.zeros((6, len(at)), dtype=complex)
        if E is not None:
            factor, power, size = E
            value, slope = factor * (at / size) ** power, factor * power / size * (at / size) ** (power - 1)
            odd, d_odd = value / root, slope / root - value * at / root**3
        if D is not None:
            factor, power, size = D
            even = factor * (at / size) ** power
            d_even = factor * power / size * (at / size) ** max(power - 1, 0)
        if f is not None:
            for n, c in enumerate(f):
                half = half + 0.5 * c * (at / a) ** (2 * n)
                d_half = d_half + 0.5 * c * 2 * n / a * (at / a) ** max(2 * n - 1, 0)
        return odd + even + half, d_odd + d_even + d_half, odd - even + half

    phi, d_phi, _ = potentials(z)
    omega = potentials(z.conj())[2]
    lower = phi + omega + (z - z.conj()) * d_phi.conj()  # sigma_yy - i sigma_xy
    yy, xy, xx = lower.real, -lower.imag, 4.0 * phi.real - lower.real
    return (xx * normal.real + xy * normal.imag) + 1j * (xy * normal.real + yy * normal.imag)


def plate(a: float, angle_deg: float, width: float, height: float, stress_yy: float) -> SlitSolution:
    """A rectangular plate with an open crack of half length a at an angle to x, pulled by uniform tractions in y."""
    return solve_slit(a, *_plate(angle_deg, width, height, (0.0, stress_yy, 0.0)), np.zeros(1, dtype=complex))


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
    return solve_closed_slit(a, *_plate(angle_deg, width, height, stress), -float(np.sign(shear)) * friction)


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


def disk(a: float, angle_deg: float, radius: float, half_arc_deg: float, pressure: float) -> SlitSolution:
    """A disk with an open crack at an angle to x, under (0, -+pressure) on arcs at 90 and 270 degrees.

    The load jumps at the arcs' ends: it acts on the disk without a crack, whose stress along the crack is a power
    series; taking that off the faces leaves a smooth problem with a free outline.
    """
    turn = np.exp(-1j * np.deg2rad(angle_deg))
    across, along = _intact_disk_on_line(angle_deg, half_arc_deg, pressure, n_terms=20)
    powers = (a / radius) ** (2 * np.arange(len(across)))
    t = 2.0 * np.pi * (np.arange(400) + 0.5) / 400
    normals = np.exp(1j * t)
    free = np.zeros(len(t), dtype=complex)
    found = solve_slit(a, radius * normals * turn, normals * turn, free, -across * powers)
    return replace(found, T=found.T + float(along @ powers))


def _intact_disk_on_line(
    angle_deg: float, half_arc_deg: float, pressure: float, n_terms: int
) -> tuple[Complexes, Floats]:
    """Coefficients of 1, (r/R)^2 ... of sigma_yy - i sigma_xy and sigma_xx on a line at an angle, of the intact disk.

    With N - i T = Phi + conj Phi - e^{2it} (conj z Phi' + Psi) on the circle (Muskhelishvili), sigma_r - i sigma_rt.
    """
    angle = np.deg2rad(angle_deg)
    # radial and tangential traction in axes turned by the angle, as N - iT = conj(t) e^{it} = sum A_k e^{ikt}
    half = np.deg2rad(half_arc_deg)
    k = 2 * np.arange(-n_terms - 2, n_terms + 3)

    def coefficient(order: int) -> complex:
        # mean over the circle of conj(traction) e^{it} e^{-i order t}: t is -+ i pressure on arcs round +-90 degrees
        total = 0j
        for centre, traction in ((0.5 * np.pi, -1j * pressure), (1.5 * np.pi, 1j * pressure)):
            m = 1 - order
            width = 2.0 * half if m == 0 else 2.0 * np.sin(m * half) / m
            total += np.conj(traction) * np.exp(1j * m * centre) * width
        return total / (2.0 * np.pi)

    A = {int(order): coefficient(int(order)) * np.exp(1j * order * angle) for order in k}
    # A in axes turned by the angle: t = t' + angle, so that A'_k = A_k e^{ik angle}
    n = 2 * np.arange(n_terms)
    a = np.array([0.5 * A[0].real if order == 0 else np.conj(A[-int(order)]) for order in n])  # Phi = sum a_n z^n
    # e^{2it} Psi = (1 - n) a_n e^{int} + conj(a_n) e^{-int} - N + iT; negative orders cancel, order 0 too
    b = np.array([(1 - (order + 2)) * np.conj(A[-int(order) - 2]) - A[int(order) + 2] for order in n])  # Psi
    # on the line conj z = z = r: sigma_yy + i sigma_xy = Phi + conj Phi + conj z Phi' + Psi
    upper = a + np.conj(a) + n * a + b
    return np.conj(upper), 4.0 * a.real - upper.real
