"""A straight closed crack under constant pressure and a shear that goes back and forth: slip and dissipated energy.

The crack |x| < a lies in an infinite plate under a uniform normal stress -p and a shear tau along the crack. A uniform
shear traction q on its faces leaves tau - q to open it in mode II, whose slip is

    slip(x) = 4 w / E' sqrt(a^2 - x^2),    w = tau - q,    K_II = w sqrt(pi a)                       (Griffith, Irwin)

and whose normal traction on the crack's line is none: the pressure stays p everywhere. So q uniform with |q| <= tau_f =
mu p satisfies Coulomb's law at all points at once: while |q| < tau_f the faces stick, w stays and q follows tau; once
q = +-tau_f they slide in its direction. This is the play operator, w being dragged along by tau with a play of tau_f,

    w_k = min(max(w_{k-1}, tau_k - tau_f), tau_k + tau_f),    w_0 = 0

(Brokate, Sprekels 1996, Hysteresis and Phase Transitions), exact from one turning point of tau to the
next. First slip at |tau| = tau_f; after a reversal tau has to change by 2 tau_f.

Means over the crack: slip pi a w / E'. Friction takes q times the slip rate, so per unit thickness, along 2 a,

    dissipated = 2 pi a^2 tau_f / E' sum |w_k - w_{k-1}|.

Between +T and -T w goes from T - tau_f to its opposite and back: 8 pi a^2 tau_f (T - tau_f)/E' a cycle, for T > tau_f.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ShearedCrack:
    """The crack in an infinite plate."""

    half_length: float  # m, a
    young_prime: float  # Pa, E': E/(1 - nu^2) in plane strain
    friction: float
    pressure: float  # Pa, positive in compression

    @property
    def limit(self) -> float:
        """Friction's shear tau_f, Pa."""
        return self.friction * self.pressure

    def driving(self, shear: ArrayLike) -> Floats:
        """w (n,) Pa at the values (n,) Pa of the shear stress, between which it is monotone; unloaded before."""
        w = [0.0]
        for tau in np.asarray(shear, dtype=float):
            w.append(float(min(max(w[-1], tau - self.limit), tau + self.limit)))
        return np.array(w[1:])

    def traction(self, shear: ArrayLike) -> Floats:
        """Shear traction q (n,) Pa on the faces, along the same history."""
        return np.asarray(shear, dtype=float) - self.driving(shear)

    def slip(self, shear: ArrayLike, x: Floats) -> Floats:
        """Slip (n, k) m at places x (k,) m from the middle."""
        shape = np.sqrt(self.half_length**2 - np.asarray(x) ** 2)
        return np.asarray(4.0 / self.young_prime * np.multiply.outer(self.driving(shear), shape))

    def mean_slip(self, shear: ArrayLike) -> Floats:
        """Slip (n,) m averaged over the crack."""
        return np.pi * self.half_length / self.young_prime * self.driving(shear)

    def K_II(self, shear: ArrayLike) -> Floats:
        """K_II (n,) Pa sqrt(m)."""
        return np.asarray(np.sqrt(np.pi * self.half_length) * self.driving(shear))

    def dissipated(self, shear: ArrayLike) -> Floats:
        """Energy (n,) J/m that friction has taken since the start."""
        path = np.cumsum(np.abs(np.diff(self.driving(shear), prepend=0.0)))
        return 2.0 * np.pi * self.half_length**2 * self.limit / self.young_prime * path

    def dissipated_per_cycle(self, amplitude: float) -> float:
        """Energy (J/m) that friction takes in one cycle from +amplitude to -amplitude (Pa) and back."""
        sliding = max(0.0, amplitude - self.limit)
        return 8.0 * np.pi * self.half_length**2 * self.limit * sliding / self.young_prime
