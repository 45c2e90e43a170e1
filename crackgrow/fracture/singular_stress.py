"""The singular stress of a crack tip, continued over the whole crack, kinks and far end included.

In the tip's axes, with z = r e^(it) and t counted so that it jumps on the crack (`cover.tips`), potentials after
Kolosov and Muskhelishvili (Muskhelishvili 1953, section 32)

    s_xx + s_yy = 4 Re c g,    s_yy - s_xx + 2 i s_xy = 2 (conj(z) c g' + d g),    g = z^(-1/2) ((z - e) / -e)^(3/2)

with c = (K_I - i K_II) / (2 sqrt(2 pi)) and d = conj(c) - c/2 are balanced wherever g is analytic. At the tip they are
Williams' field. In rock with bedding, of roots s_1 and s_2 (Sih, Paris, Irwin 1965), g_j is of z_j = x + s_j y, and

    (s_xx, s_yy, s_xy) = sum_j Re (s_j^2, 1, -s_j) a_j g_j,    a_1 = -(s_2 K_I + K_II) / (sqrt(2 pi) (s_1 - s_2)),

a_2 with the roots exchanged. At the crack's far end e the second factor takes the jump away; without it, where the far
end is on an outline, g = z^(-1/2). For two tips of a straight crack with the same K their sum is Griffith's field,
regular but for the uniform part of the stress.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools, Complex, Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.shapes import Roots, is_isotropic, turned_roots
from crackgrow.cover.tips import Tip, TipView, crack_angle, reach_of_tips, tip_angle
from crackgrow.geometry.tolerance import ROUND_OFF

REACH = 6.0
"""Cells from a tip to the nodes of the patches in which its field is told apart from the rest. With 4, the two ends
of a crack of 7 cells spoil each other; more changes nothing."""

ON_CUT = 1e-6
"""Radians: a place this near to the line on which both factors jump is on the side that the first one says."""


@dataclass(frozen=True, slots=True, eq=False)
class SingularStress:
    """The singular stress of one tip of a cover."""

    cover: Cover
    tip: int
    K: tuple[float, float]  # Pa sqrt(m): K_I and K_II

    @property
    def patches(self) -> Bools:
        """The physical patches (n_patches,) in which it jumps on the crack alone and is worth telling apart."""
        tip, support = self._tip, self.cover.lattice.support
        distance = np.hypot(*(self.cover.patches.nodes - tip.point).T)
        reach = REACH * tip.size
        if not self._ends_inside:
            jumps_inside = max(reach_of_tips(support) * tip.size, float(tip.radii[-1]))
            reach = min(reach, jumps_inside - np.sqrt(2.0) * support * tip.size)
        return np.asarray(distance <= reach)

    def at(self, points: Floats, elements: Ints) -> Floats:
        """Stress (n, 3) Pa: xx, yy, xy at points (n, 2), in lattice coordinates, of elements (n,)."""
        tip, reference = self._tip, self.cover.elements.reference[elements]
        r, t = tip_angle(tip, points, reference)
        r = np.maximum(r, ROUND_OFF)  # at the tip itself the field of this distance
        roots = turned_roots(self.cover.bodies[tip.body].roots, tip.rotation)
        if not is_isotropic(roots):
            return self._in_bedded(roots, r, t, points, reference)
        z = r * np.exp(1.0j * t)
        g = np.exp(-0.5j * t) / np.sqrt(r)
        slope = -0.5 * g / z
        if self._ends_inside:
            away, angle, angle_at_tip = _from_far_end(tip, points, reference)
            distance, far = np.maximum(np.abs(away), ROUND_OFF), complex(*tip.path[-1])
            factor = (distance / abs(far)) ** 1.5 * np.exp(1.5j * (angle - angle_at_tip))
            rate = 1.5 * factor / (distance * np.exp(1.0j * angle))
            g, slope = g * factor, slope * factor + g * rate
        K_I, K_II = self.K
        c = complex(K_I, -K_II) / (2.0 * np.sqrt(2.0 * np.pi * self.cover.lattice.spacing))
        total = 4.0 * (c * g).real
        deviator = 2.0 * (np.conj(z) * c * slope + (c.conjugate() - 0.5 * c) * g)
        deviator *= complex(*tip.rotation[0]) ** -2  # from the tip's axes to those of the lattice
        return np.stack([0.5 * (total - deviator.real), 0.5 * (total + deviator.real), 0.5 * deviator.imag], axis=1)

    def _in_bedded(self, roots: Roots, r: Floats, t: Floats, points: Floats, reference: Floats) -> Floats:
        """The same at polar coordinates r, t (n,) in rock with roots, in the tip's axes, that are not both i."""
        tip, (K_I, K_II), found = self._tip, self.K, np.zeros((3, len(r)), dtype=complex)
        if self._ends_inside:
            away, angle, angle_at_tip = _from_far_end(tip, points, reference)
        for s, other in (roots, roots[::-1]):
            g = np.exp(-0.5j * _near(t, np.cos(t) + s * np.sin(t))) / np.sqrt(r * np.abs(np.cos(t) + s * np.sin(t)))
            if self._ends_inside:
                z, e = away.real + s * away.imag, tip.path[-1, 0] + s * tip.path[-1, 1]
                turn = _near(angle, z) - _near(np.array([angle_at_tip]), np.array([-e]))
                g = g * (np.abs(z) / abs(e)) ** 1.5 * np.exp(1.5j * turn)
            found += np.array([[s * s], [1.0], [-s]]) * (-(other * K_I + K_II) / (s - other) * g)
        xx, yy, xy = found.real / np.sqrt(2.0 * np.pi * self.cover.lattice.spacing)
        tensor = np.einsum("abn,ac,bd->ncd", np.array([[xx, xy], [xy, yy]]), tip.rotation, tip.rotation)
        return np.stack([tensor[:, 0, 0], tensor[:, 1, 1], tensor[:, 0, 1]], axis=1)

    @property
    def _tip(self) -> Tip:
        return self.cover.tips[self.tip]

    @property
    def _ends_inside(self) -> bool:
        """Whether the jump would go on through rock beyond the crack's far end."""
        return self._tip.other_is_tip or np.isfinite(self._tip.fade)


def _near(angle: Floats, z: Complex) -> Floats:
    """The angles (n,) of z that are within pi of others."""
    return np.asarray(angle + np.angle(z * np.exp(-1.0j * angle)))


def _from_far_end(tip: TipView, points: Floats, reference: Floats) -> tuple[Complex, Floats, float]:
    """z - e (n,) and its angle at points (n, 2), each on the side of its `reference` (n, 2); the angle at the tip.

    It jumps beyond the far end, where z^(-1/2) does: on the straight extension of the last segment.
    """
    far, before = (complex(*place) for place in (tip.path[-1], tip.path[-2]))
    cut = np.angle(far - before)
    seen, local = ((places - tip.point) @ tip.rotation.T @ (1.0, 1.0j) - far for places in (reference, points))
    side = np.mod(np.angle(seen) - cut, 2.0 * np.pi)
    r, t = tip_angle(tip, reference, reference)
    left = t > crack_angle(tip, r) - np.pi
    side = np.where(left & (side < ON_CUT), side + 2.0 * np.pi, side)
    side = np.where(~left & (side > 2.0 * np.pi - ON_CUT), side - 2.0 * np.pi, side)
    angle = np.angle(local) - cut
    angle += 2.0 * np.pi * np.round((side - angle) / (2.0 * np.pi))
    return np.asarray(local), np.asarray(angle + cut), float(np.mod(np.angle(-far) - cut, 2.0 * np.pi) + cut)
