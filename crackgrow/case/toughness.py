"""The radius over which a criterion averages stress: from the toughness of the rock, or as it is given.

In pure mode I a criterion sees the stress mode_I K_I / sqrt(2 pi R) beside what is not singular. It reaches the tensile
strength T0 at K_I = T0 sqrt(2 pi R) / mode_I, so that a toughness stands for a radius.

Shear may have its own: on a ray straight ahead mode II reaches the cohesion c at K_II = c sqrt(2 pi R) / 2. A straight
crack of length 2a that slides needs K_II = K_IIc / sqrt(1 + R / 2a) by the average over R. There the stress over a
length and the energy of an advance by it both suffice (Cornetti et al. 2006).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from crackgrow.case.model import Growth, Strength

MODE_I: Final[Mapping[str, float]] = {"strength": 1.5279, "directional_strength": 2.0, "max_hoop_stress": 1.0}
"""s_yy sqrt(2 pi R) / K_I that a criterion sees in pure mode I: over the disc (4.8 / pi), a ray, at the radius."""

MODE_II: Final = 2.0  # s_xy sqrt(2 pi R) / K_II on a ray straight ahead in pure mode II
BY_K: Final = frozenset({"max_hoop_stress"})  # criteria that need K alone, and no radius where the toughness is known
RAY_CRITERIA: Final = frozenset({"directional_strength", "max_hoop_stress"})
"""Criteria that judge shear on rays; the second one at tips of cracks that have started in shear."""


def averaging_radius(growth: Growth, strength: Strength) -> float:
    """R (m) in rock of a strength."""
    if strength.toughness is not None:
        return radius_of(growth.criterion, strength.tension, strength.toughness)
    assert growth.tip_radius is not None  # the case was checked
    return growth.tip_radius


def start_radius(growth: Growth, strength: Strength) -> float:
    """R (m) over which stress is averaged where cracks start, and at tips of those that have started in shear.

    Criteria that go by K leave these to `directional_strength`, with the radius that stands for the same toughness.
    """
    radius = averaging_radius(growth, strength)
    if growth.criterion not in BY_K:
        return radius
    return radius * (MODE_I["directional_strength"] / MODE_I[growth.criterion]) ** 2


def shear_radius(growth: Growth, strength: Strength) -> float | None:
    """R (m) over which stress is averaged for shear at tips; None where that is as for tension, or no tip shears."""
    if strength.shear_toughness is None or goes_by_K(growth):
        return None
    return shear_radius_of(strength.cohesion, strength.shear_toughness)


def goes_by_K(growth: Growth) -> bool:
    """Whether K_I and K_II are all that counts in rock with a toughness."""
    return growth.criterion in BY_K and growth.initiation.at == "tips"


def length_of_average(growth: Growth, strength: Strength | None) -> float:
    """The radius (m) that cells at a tip are to resolve; infinite where K_I and K_II are all that counts."""
    own = np.inf if growth.tip_radius is None else growth.tip_radius
    if strength is None:
        return own
    if strength.toughness is not None:
        own = np.inf if goes_by_K(growth) else start_radius(growth, strength)
    return min(own, shear_radius(growth, strength) or np.inf)


def radius_of(criterion: str, tension: float, toughness: float) -> float:
    """R (m) at which a criterion lets mode I grow at a toughness (Pa sqrt(m)), for a tensile strength (Pa)."""
    return float((MODE_I[criterion] * toughness / tension) ** 2 / (2.0 * np.pi))


def shear_radius_of(cohesion: float, shear_toughness: float) -> float:
    """R (m) at which mode II grows straight on at a toughness in shear (Pa sqrt(m)), for a cohesion (Pa)."""
    return float((MODE_II * shear_toughness / cohesion) ** 2 / (2.0 * np.pi))
