"""Quadrature of the interaction integrals round a tip: points on circles and along the faces; lengths in spacings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.cover.shapes import Roots, is_isotropic
from crackgrow.cover.tips import TipView, crack_angle
from crackgrow.geometry.polyline import arc_lengths, segment_directions
from crackgrow.geometry.tolerance import SAME_PART
from crackgrow.quadrature.rules import gauss

N_RADIAL = 6
"""Points per panel along a ray; panels end at the discs' radii and at kinks, too."""

N_ANGULAR = 40
"""Points on a circle, from face to face: with three times as many K changes by 3e-5, in discs of two cells by 2e-4."""

ANGULAR_ERROR = 1e-5
"""What Gauss' rule may leave of the fields of bedded rock on a circle; K is as good."""

PANEL = 1.5
"""Longest panel on a ray near the tip, cells: the stress ripples from element to element."""

GROWTH = 1.0 / 3.0
"""Longest panel over its distance from the tip, where that is more: the ripple is the less the farther the tip is."""

KINK = 0.25
"""Cells: of kinks so close to each other panels end at one."""

FACE_PANEL = 0.1
"""Length of a panel on the faces over that on a ray: tractions have a bend at every contact point."""

N_FACE = 5
"""Points per panel on the faces."""


@dataclass(frozen=True, slots=True, eq=False)
class Circles:
    """Circles round a tip, each with points from face to face: circle by circle."""

    r: Floats  # (c,) radii
    weight: Floats  # (c,) of the circles, for integrals over the radius
    t: Floats  # (c, a) angles of the points, from the tip's direction
    angle_weight: Floats  # (a,) for integrals over the angle

    @property
    def polar(self) -> tuple[Floats, Floats]:
        """Polar coordinates (c a,) of all points."""
        return np.repeat(self.r, self.t.shape[1]), self.t.ravel()

    def points(self, tip: TipView) -> Floats:
        """All points (c a, 2), in lattice coordinates."""
        r, t = self.polar
        return np.asarray(tip.point + np.stack([r * np.cos(t), r * np.sin(t)], axis=1) @ tip.rotation)


@dataclass(frozen=True, slots=True, eq=False)
class FaceLine:
    """Points along a crack from its tip on, for both of its faces."""

    arc: Floats  # (n,) arc length from the tip
    weight: Floats  # (n,)
    place: Floats  # (n, 2) in the tip's axes
    toward_tip: Floats  # (n, 2) unit tangent, in the tip's axes
    r: Floats  # (n,) distance from the tip
    alpha: Floats  # (n,) angle of the left face


@dataclass(frozen=True, slots=True, eq=False)
class TipRule:
    """The rule for discs with increasing `radii`, all with the points of the largest."""

    radii: Floats  # (n,)
    circles: Circles
    faces: FaceLine


def tip_rule(tip: TipView, size: float, radii: Floats, n: int = N_ANGULAR) -> TipRule:
    """The rule of discs with increasing `radii` (m,) round a tip among cells of side `size`, n points on a circle."""
    return TipRule(radii, _circles(tip, size, radii, n), _face_line(tip, size, radii))


def n_angular(roots: Roots) -> int:
    """Points on a circle in rock with these roots in the axes of the tip.

    The fields are singular where cos t + s sin t = 0, at a distance d of t from the real axis: Gauss' rule of n points
    over 2 pi leaves exp(-2 n d / pi).
    """
    if is_isotropic(roots):
        return N_ANGULAR
    distance = min(abs(np.arctan(1.0 / root).imag) for root in roots)
    return max(N_ANGULAR, int(np.ceil(-0.5 * np.pi * np.log(ANGULAR_ERROR) / distance)))


def fall_weights(r: Floats, weight: Floats, radii: Floats) -> Floats:
    """Weights (radii, n) of points for averages over 0 < r < R by -dq/dr = 12 x (1 - x)^2 / R, x = r / R."""
    x = np.minimum(r / radii[:, None], 1.0)
    return np.asarray(weight * 12.0 * x * (1.0 - x) ** 2 / radii[:, None])


def step_weights(r: Floats, weight: Floats, radii: Floats) -> Floats:
    """Weights (radii, n) of points for integrals of q, which is (1 - x)^3 (1 + 3 x)."""
    x = np.minimum(r / radii[:, None], 1.0)
    return np.asarray(weight * (1.0 - x) ** 3 * (1.0 + 3.0 * x))


def _circles(tip: TipView, size: float, radii: Floats, n: int) -> Circles:
    kinks = tip.radii[1:][tip.radii[1:] < radii[-1]]
    kinks = kinks[np.unique(kinks // (KINK * size), return_index=True)[1]]
    r, weight = panels_from_tip(panel_ends(np.append(kinks, radii), PANEL * size, GROWTH), N_RADIAL)
    x, w = gauss(n)
    t = crack_angle(tip, r)[:, None] - 2.0 * np.pi * (1.0 - x)
    return Circles(r, weight, t, 2.0 * np.pi * w)


def _face_line(tip: TipView, size: float, radii: Floats) -> FaceLine:
    arcs = arc_lengths(tip.path)
    ends = _arc_at(tip, arcs, radii)
    kinks = arcs[1:][arcs[1:] < ends[-1]]
    stops = panel_ends(np.append(kinks, ends), FACE_PANEL * PANEL * size, FACE_PANEL * GROWTH)
    arc, weight = panels_from_tip(stops, N_FACE)
    segment = np.searchsorted(arcs, arc, side="right") - 1
    toward_tip = -segment_directions(tip.path)[segment]
    place = tip.path[segment] - (arc - arcs[segment])[:, None] * toward_tip
    r = np.hypot(place[:, 0], place[:, 1])
    return FaceLine(arc, weight, place, toward_tip, r, crack_angle(tip, r))


def panel_ends(given: Floats, short: float, growth: float) -> Floats:
    """Ends (n,) of panels from 0 on, with the `given` ones (m,): at most `short`, or `growth` times the way, long."""
    stops = [0.0]
    for end in np.sort(given).tolist():
        while end - stops[-1] > SAME_PART:
            left = end - stops[-1]
            n = np.ceil(left / max(short, growth * stops[-1]))
            stops.append(end if n == 1.0 else stops[-1] + left / n)
    return np.array(stops)


def panels_from_tip(stops: Floats, n: int) -> tuple[Floats, Floats]:
    """Gauss points and weights between stops, for half powers of the distance from the tip."""
    stops = np.sqrt(stops)
    x, w = gauss(n)
    size = np.diff(stops)[:, None]
    root, weight = (stops[:-1, None] + size * x).ravel(), (size * w).ravel()
    return root**2, 2.0 * root * weight


def _arc_at(tip: TipView, arcs: Floats, r: Floats) -> Floats:
    """Arc length (n,) at which the crack leaves the circle of radius r (n,)."""
    alpha = crack_angle(tip, r)
    at = r[:, None] * np.stack([np.cos(alpha), np.sin(alpha)], axis=1)
    segment = np.clip(np.searchsorted(tip.radii, r, side="right") - 1, 0, len(tip.radii) - 2)
    return np.asarray(arcs[segment] + np.hypot(*(at - tip.path[segment]).T))
