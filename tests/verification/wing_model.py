"""The sliding-crack model of wing cracks: K_I of wings along the axial compression, and where they stop.

A closed flaw of half length a slides and wedges two straight wings of length l open, which run along the axial
compression. Without the wings' curved beginning, the pair of wings is one crack of length 2 l, with the flaw's driving
force 2 a tau_eff, taken across the wings, as point loads at its middle, and the lateral compression on its faces:

    K_I(l) = 2 a tau_eff sin(theta) / sqrt(pi (l + 0.27 a)) - sigma_w sqrt(pi l)

(Horii and Nemat-Nasser 1986, Philosophical Transactions of the Royal Society A 319, 337-374, with their tau*, c and
l* = 0.27 c). theta is the angle between flaw and wings. l* makes the formula right for l -> 0 as well: a vanishing wing
in the direction of the largest hoop stress, 70.5 degrees, has K_I = 2/sqrt(3) tau_eff sqrt(pi a), which
2 sin(theta)/(pi sqrt(l*/a)) meets with l*/a = 0.2702. In between it is an estimate, no exact solution: Lehner and
Kachanov (1996, International Journal of Fracture 77, R69-R75) look at what such formulas are worth. The wings' own
curve and their K_II are left out.

Compression is positive here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy.optimize import brentq

SHORT_WING = 0.27
"""l*/a."""


@dataclass(frozen=True, slots=True)
class WingModel:
    """A flaw under an axial compression (vertical) and a lateral one (horizontal)."""

    half_length: float  # m, a
    angle_deg: float  # of the flaw from the horizontal, 0 to 90
    friction: float
    axial: float  # Pa, compression positive
    lateral: float  # Pa, sigma_w, compression positive

    def __post_init__(self) -> None:
        """Raises ValueError under lateral tension, where K_I rises again: wings that run on for ever."""
        if self.lateral < 0.0:
            raise ValueError(f"the lateral stress {self.lateral:g} Pa is tension; the model is for compression")

    @property
    def driving(self) -> float:
        """tau_eff, Pa: the shear stress along the flaw that friction leaves over."""
        angle = math.radians(self.angle_deg)
        shear = (self.axial - self.lateral) * math.sin(angle) * math.cos(angle)
        pressure = self.axial * math.cos(angle) ** 2 + self.lateral * math.sin(angle) ** 2
        return max(0.0, abs(shear) - self.friction * pressure)

    @property
    def wedge(self) -> float:
        """2 a tau_eff sin(theta), N/m: theta is the angle between the flaw and the axial compression."""
        return 2.0 * self.half_length * self.driving * math.cos(math.radians(self.angle_deg))

    def K_I(self, length: float) -> float:
        """K_I (Pa sqrt(m)) of wings of a length l, m."""
        wedged = self.wedge / math.sqrt(math.pi * (length + SHORT_WING * self.half_length))
        return wedged - self.lateral * math.sqrt(math.pi * length)

    def arrest_length(self, toughness: float) -> float:
        """Largest l (m) with K_I(l) >= toughness (Pa sqrt(m), not negative): zero where no wing starts.

        K_I falls with l, from K_I(0) to -inf, or to 0 without lateral stress: infinite then without toughness.
        """
        if self.K_I(0.0) <= toughness:
            return 0.0
        if self.lateral == 0.0 and toughness == 0.0:
            return math.inf
        beyond = self.half_length
        while self.K_I(beyond) > toughness:
            beyond *= 2.0
        return float(brentq(lambda length: self.K_I(length) - toughness, 0.0, beyond, xtol=1e-15 * beyond, rtol=1e-14))
