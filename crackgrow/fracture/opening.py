"""How a tip opens by K: the kink with the largest hoop stress, with bedding over the resistance of its direction."""

from __future__ import annotations

from typing import Literal

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Strength
from crackgrow.fracture.sites import LARGEST_KINK

UNEVEN = 1e-5
"""rad: samples whose distances differ by more are not evenly spaced."""

KINKS = np.linspace(-LARGEST_KINK, LARGEST_KINK, 881)
"""rad: directions in which a tip may go, a quarter of a degree apart."""

Resisting = Literal["tension", "toughness"]
"""What bedding gives a direction."""


def opening(K: tuple[float, float], limits: Strength, direction: float) -> tuple[float, float]:
    """The K_I (Pa sqrt(m)) that is as critical across bedding as K_I, K_II of a tip; the kink (rad) by which it opens.

    There the hoop stress of K_I and K_II is largest; with bedding that stress over the resistance in the `direction`
    (rad from x) of the tip and beside it.
    """
    if limits.bedding is None:
        kink = hoop_stress_kink(*K)
        return float(hoop_K(*K, kink)), kink
    of: Resisting = "tension" if limits.toughness is None else "toughness"
    return peak_of(KINKS, hoop_K(*K, KINKS) / share_across(limits, of, direction + KINKS))


def share_across(limits: Strength, of: Resisting, t: Floats | float) -> Floats:
    """Tensile strength or toughness of cracks in directions t (rad from x), over that across bedding; 1 without any.

    along + (across - along) sin^2 of the angle to it: Buczek, Herakovich 1985 (strength), Saouma, Ayari, Leavell 1987
    (toughness).
    """
    along = None if limits.bedding is None else getattr(limits.bedding, of)
    if limits.bedding is None or along is None:
        return np.ones(np.shape(t))
    share = along / getattr(limits, of)
    return np.asarray(share + (1.0 - share) * np.sin(t - np.deg2rad(limits.bedding.angle)) ** 2)


def hoop_stress_kink(K_I: float, K_II: float) -> float:
    """Direction (rad) of the largest hoop stress, from the tip's, at most LARGEST_KINK to either side.

    tan(t/2) = (K_I - sqrt(K_I^2 + 8 K_II^2)) / (4 K_II), written so that a small K_II costs no digits.
    """
    root = np.hypot(K_I, np.sqrt(8.0) * K_II)
    if K_I > 0.0:
        kink = -2.0 * np.arctan(2.0 * K_II / (K_I + root))
    elif K_II != 0.0:
        kink = -2.0 * np.sign(K_II) * np.arctan2(root - K_I, 4.0 * abs(K_II))
    else:
        kink = 0.0
    return float(np.clip(kink, -LARGEST_KINK, LARGEST_KINK))


def hoop_K(K_I: float, K_II: float, t: Floats | float) -> Floats:
    """The K_I (Pa sqrt(m)) that alone has, straight ahead, the hoop stress of K_I and K_II at an angle t (rad).

    cos(t/2) (K_I cos^2(t/2) - 3/2 K_II sin t), Erdogan, Sih 1963.
    """
    half = np.cos(0.5 * t)
    return np.asarray(half * (K_I * half**2 - 1.5 * K_II * np.sin(t)))


def peak_of(angles: Floats, values: Floats) -> tuple[float, float]:
    """Largest of values (n,) and its angle, as `peaks_of` has them."""
    (value,), (angle,) = peaks_of(angles, values[None])
    return float(value), float(angle)


def peaks_of(angles: Floats, values: Floats) -> tuple[Floats, Floats]:
    """The largest of values (m, n) on n > 0 rays, row by row, and its angle, by a parabola through three samples.

    A value that still rises at the end of the range is no peak, unless there is no other.
    """
    rows, last = np.arange(len(values)), len(angles) - 1
    inner = np.zeros(values.shape, dtype=bool)
    inner[:, 1:-1] = (values[:, 1:-1] >= values[:, :-2]) & (values[:, 1:-1] >= values[:, 2:])
    i = np.where(inner.any(axis=1), np.where(inner, values, -np.inf).argmax(axis=1), values.argmax(axis=1))
    below, above = np.maximum(i - 1, 0), np.minimum(i + 1, last)
    before, at, after = (values[rows, place] for place in (below, i, above))
    curvature = before - 2.0 * at + after
    even = np.abs(angles[above] - 2.0 * angles[i] + angles[below]) <= UNEVEN
    bends = (i > 0) & (i < last) & even & (curvature < 0.0)
    shift = np.divide(0.5 * (before - after), curvature, out=np.zeros(len(values)), where=bends)
    return at - 0.25 * (before - after) * shift, angles[i] + shift * (angles[i] - angles[below])


def kinked_release(K: tuple[float, float], kink: float, young_prime: float) -> float:
    """Energy (J/m^2) that a tip with K_I, K_II (Pa sqrt(m)) releases as it begins to grow along a kink (rad).

    (k_1^2 + k_2^2) / E' of the K right behind the kink, Cotterell, Rice 1980: to first order in the kink, which is 2 %
    low at 20 degrees and 12 % at 72. Faces that would overlap release nothing by that.
    """
    K_I, K_II = K
    opens = max(float(hoop_K(K_I, K_II, kink)), 0.0)
    shears = 0.5 * np.cos(0.5 * kink) * (K_I * np.sin(kink) + K_II * (3.0 * np.cos(kink) - 1.0))
    return float((opens**2 + shears**2) / young_prime)
