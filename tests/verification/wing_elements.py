"""A sliding flaw with open wings in an infinite plate, by elements of constant displacement discontinuity.

Independent of the program: no lattice, no contact search. The flaw is closed and slides everywhere under Coulomb
friction, the wings carry no traction and follow any given path (Crouch 1976, International Journal for Numerical
Methods in Engineering 10, 301-343; the stress of an element's two dislocations by Muskhelishvili's potentials).
Elements shrink towards both ends of the flaw and of the wings. K comes from the jump over the last element, whose
ratio to K is taken from a straight crack with the same elements.

Tension is positive here; lengths, stresses and K in consistent units. Young's modulus cancels: E' = 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, eq=False)
class Elements:
    """Straight elements in a row from tip to tip."""

    ends: Complex  # (n + 1,)
    sliding: NDArray[np.bool_]  # (n,) closed, on the flaw

    @property
    def middle(self) -> Complex:
        """Midpoints (n,)."""
        return np.asarray(0.5 * (self.ends[1:] + self.ends[:-1]))

    @property
    def along(self) -> Complex:
        """Unit tangents (n,)."""
        step = np.diff(self.ends)
        return np.asarray(step / np.abs(step))


def winged_flaw(flaw: Floats, wing: Floats, n: int) -> Elements:
    """Elements of a flaw (2, 2) with a wing (k, 2) at its end, which starts there, and the same turned at its start.

    There are n elements on each of the three.
    """
    share = graded(n)
    line = wing[:, 0] + 1j * wing[:, 1]
    s = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(line)))])
    there = np.interp(share * s[-1], s, line.real) + 1j * np.interp(share * s[-1], s, line.imag)
    start, end = flaw[:, 0] + 1j * flaw[:, 1]
    closed = start + share * (end - start)
    other = start + end - there[::-1]  # turned about the middle
    return Elements(np.concatenate([other[:-1], closed[:-1], there]), np.repeat([False, True, False], n))


def graded(n: int) -> Floats:
    """Ends (n + 1,) of n elements of the unit length, which shrink towards both of its ends."""
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.arange(n + 1) / n))


def stress_intensities(elements: Elements, axial: float, lateral: float, friction: float) -> tuple[float, float]:
    """K_I and K_II at the last tip, under stress `axial` in y and `lateral` in x (compression negative).

    K_II is positive where the left face moves outward.
    """
    n_last = len(elements.sliding) - int(np.append(-1, np.flatnonzero(elements.sliding))[-1]) - 1  # beyond the flaw
    shear, normal = _influence(elements)
    n = len(elements.sliding)
    t = elements.along
    far_normal = lateral * t.imag**2 + axial * t.real**2
    far_shear = (axial - lateral) * t.real * t.imag
    sense = np.sign(far_shear[elements.sliding].sum())
    held = np.where(elements.sliding, sense * friction, 0.0)  # shear + held * normal = 0 on the flaw
    above = shear + held[:, None] * normal
    closed = np.concatenate([np.zeros((n, n)), np.eye(n)], axis=1)
    below = np.where(elements.sliding[:, None], closed, normal)
    load = np.concatenate([-(far_shear + held * far_normal), np.where(elements.sliding, 0.0, -far_normal)])
    jump = np.linalg.solve(np.concatenate([above, below]), load)
    last = float(np.abs(elements.ends[-1] - elements.ends[-2]))
    ratio = np.sqrt(last) * _jump_of_unit_K(n_last)
    return float(jump[-1] / ratio), float(jump[n - 1] / ratio)


def wing_K(flaw: Floats, wing: Floats, n: int, axial: float, lateral: float, friction: float) -> tuple[float, float]:
    """K_I and K_II of a wing without the elements' error of first order in 1/n: by n and 2 n elements on each part."""
    coarse, fine = (
        np.array(stress_intensities(winged_flaw(flaw, wing, m), axial, lateral, friction)) for m in (n, 2 * n)
    )
    K_I, K_II = (2.0 * fine - coarse).tolist()
    return K_I, K_II


def _jump_of_unit_K(n: int) -> float:
    """Opening of the last of n elements over the root of its length, for K_I = 1: by a straight crack of length 2."""
    crack = Elements((2.0 * graded(n) - 1.0).astype(complex), np.zeros(n, dtype=bool))
    _, normal = _influence(crack)
    opening = np.linalg.solve(normal[:, n:], -np.ones(n))
    return float(opening[-1] / np.sqrt(np.abs(crack.ends[-1] - crack.ends[-2])) / np.sqrt(np.pi))


def _influence(elements: Elements) -> tuple[Floats, Floats]:
    """Shear and normal traction (n, 2 n) at the midpoints, of unit slips and then unit openings of all elements.

    An element is a pair of dislocations: phi' = A/(z - z0), psi' = conj(A)/(z - z0) + A conj(z0)/(z - z0)^2 with
    A = E' b/(8 pi i), s_xx + s_yy = 4 Re phi', s_yy - s_xx + 2 i s_xy = 2 (conj(z) phi'' + psi').
    """
    z, t = elements.middle[:, None], elements.along
    shear, normal = [], []
    for b in (t, 1j * t):
        parts = []
        for sign, z0 in ((-1.0, elements.ends[:-1]), (1.0, elements.ends[1:])):
            A, r = sign * b / (8j * np.pi), z - z0
            hydrostatic = 4.0 * (A / r).real
            deviator = 2.0 * (-np.conj(z) * A / r**2 + np.conj(A) / r + A * np.conj(z0) / r**2)
            turned = deviator * (t**2)[:, None]  # s_nn - s_tt + 2 i s_tn in the axes of the element
            parts.append((0.5 * turned.imag, 0.5 * (hydrostatic + turned.real)))
        shear.append(parts[0][0] + parts[1][0])
        normal.append(parts[0][1] + parts[1][1])
    return np.concatenate(shear, axis=1), np.concatenate(normal, axis=1)
