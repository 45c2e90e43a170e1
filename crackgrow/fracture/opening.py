"""How a tip opens by K: the kink with the largest hoop stress, with bedding over the resistance of its direction."""

from __future__ import annotations

from typing import Literal

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Strength
from crackgrow.cover.shapes import Roots, is_isotropic
from crackgrow.fracture.near_tip import near_tip_stress
from crackgrow.fracture.sites import LARGEST_KINK
from crackgrow.solid.elasticity import PlaneElasticity

UNEVEN = 1e-5
"""rad: samples whose distances differ by more are not evenly spaced."""

KINKS = np.linspace(-LARGEST_KINK, LARGEST_KINK, 881)
"""rad: directions in which a tip may go, a quarter of a degree apart."""

Resisting = Literal["tension", "toughness"]
"""What bedding gives a direction."""


def opening(
    K: tuple[float, float], roots: Roots, limits: Strength | None = None, direction: float = 0.0
) -> tuple[float, float]:
    """The K_I (Pa sqrt(m)) that is as critical across bedding as K_I, K_II of a tip; the kink (rad) by which it opens.

    There the hoop stress of K_I and K_II is largest in rock with these `roots` in the tip's axes; with bedding in the
    `limits` that stress over the resistance in the `direction` (rad from x) of the tip and beside it.
    """
    bedded = limits is not None and limits.bedding is not None
    if not bedded and is_isotropic(roots):
        kink = hoop_stress_kink(*K)
        return float(ahead(K, kink, roots)[0]), kink
    resistance: Floats | float = 1.0
    if limits is not None:
        of: Resisting = "tension" if limits.toughness is None else "toughness"
        resistance = share_across(limits, of, direction + KINKS)
    return peak_of(KINKS, ahead(K, KINKS, roots)[0] / resistance)


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


def ahead(K: tuple[float, float], t: Floats | float, roots: Roots) -> Floats:
    """The K_I and K_II (2, ...) Pa sqrt(m) that alone have, straight ahead, what K has at an angle t (rad).

    That is hoop stress and shear stress: in isotropic rock cos(t/2) (K_I cos^2(t/2) - 3/2 K_II sin t) and
    cos(t/2) (K_I sin t + K_II (3 cos t - 1)) / 2, Erdogan, Sih 1963.
    """
    if is_isotropic(roots):
        half, (K_I, K_II) = np.cos(0.5 * t), K
        opens, shears = K_I * half**2 - 1.5 * K_II * np.sin(t), 0.5 * (K_I * np.sin(t) + K_II * (3.0 * np.cos(t) - 1.0))
        return half * np.stack([opens, shears])
    stress = near_tip_stress(roots, np.atleast_1d(t)) @ K
    return np.stack(hoop_and_shear_at(t, stress if np.ndim(t) else stress[0]))


def hoop_and_shear_at(t: Floats | float, stress: Floats) -> tuple[Floats, Floats]:
    """Hoop stress and shear stress (...) Pa on rays at angles t (...) rad from +x, from stress (..., 3) there."""
    c, s = np.cos(t), np.sin(t)
    xx, yy, xy = stress[..., 0], stress[..., 1], stress[..., 2]
    return xx * s * s + yy * c * c - 2.0 * xy * s * c, (yy - xx) * s * c + xy * (c * c - s * s)


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


def kinked_release(K: tuple[float, float], kink: float, material: PlaneElasticity) -> float:
    """Energy (J/m^2) that a tip with K_I, K_II (Pa sqrt(m)) releases as it begins to grow along a kink (rad).

    It is that of the K right behind the kink, Cotterell, Rice 1980, with the material in the axes of the tip: to first
    order in the kink, which in isotropic rock is 2 % low at 20 degrees and 12 % at 72. Faces that would overlap release
    nothing by that.
    """
    opens, shears = ahead(K, kink, material.roots)
    c, s = np.cos(kink), np.sin(kink)
    behind = np.array([shears, max(opens, 0.0)])
    return float(behind @ material.turned(np.array([[c, s], [-s, c]])).release @ behind)
