"""Places on rims where stress has no limit though no crack ends there: re-entrant corners, and ends of held parts.

Stress grows there as r^(lambda - 1), and no function follows it: cells have to. With cells of the side h there, K of a
tip at a distance d is off by about 0.2 (h / d)^(2 lambda) of it, more than its own cells leave: the energy that the
cells miss falls so, and cells elsewhere, such as those that K is held against, say nothing of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.model import ContactSupport, EdgeSupport
from crackgrow.case.regions import EdgeRegion
from crackgrow.cover.shapes import BodyGeometry, body_index
from crackgrow.geometry.polyline import kink_angles
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.run.scene import Scene

SHARP_CORNER = np.deg2rad(20.0)
"""Less sharp re-entrant corners are those of a curve."""

CRACK = 0.5
"""lambda of a crack, and of a held part that ends on a straight rim."""

HALVINGS = 40
"""Of the interval that lambda lies in."""


@dataclass(frozen=True, slots=True, eq=False)
class RimSingularity:
    """A place at which stress has no limit, in lattice coordinates."""

    point: Floats  # (2,)
    extent: float  # of what makes it, spacings: the shorter side at a corner, the length of a held part
    exponent: float  # lambda, from 1/2 to 1

    def size_for(self, tips: Floats, per_distance: float) -> float:
        """The largest cells (spacings) for tips (n, 2): so many along the way from a crack's end to a tip.

        As many leave the same error at weaker singularities. What is small beside its distance is seen by its square.
        """
        distance = float(np.hypot(*(tips - self.point).T).min())
        parts = float(per_distance ** (CRACK / self.exponent))
        return distance * max(1.0, distance / self.extent) / parts


def rim_singularities(scene: Scene) -> Iterator[RimSingularity]:
    """All of a scene."""
    for body in scene.bodies:
        yield from chain.from_iterable(_corners(ring) for ring in body.rings)
    for support in scene.case.supports:
        if isinstance(support, EdgeSupport | ContactSupport):
            yield from _ends(support.region, scene.bodies[body_index(scene.bodies, support.region.body)])
    for line in scene.interfaces:
        for end in (line.points[0], line.points[-1]):
            angle = sum(rock_angle(body, end) for body in scene.bodies)
            if np.pi + SHARP_CORNER < angle < 2.0 * np.pi - SHARP_CORNER:
                extent = float(np.hypot(*np.diff(line.points, axis=0).T).sum())
                yield RimSingularity(end, extent, free_exponent(angle))


def free_exponent(angle: float) -> float:
    """lambda at a corner with so much rock (rad, above pi), free on both sides: sin(lambda w) + lambda sin(w) = 0.

    Williams 1952, the stronger one of both, which is symmetric. It lies between that of a crack and pi / w.
    """
    low, high = CRACK, float(np.pi / angle)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if np.sin(middle * angle) + middle * np.sin(angle) > 0.0 else (low, middle)
    return 0.5 * (low + high)


def rock_angle(body: BodyGeometry, place: Floats) -> float:
    """How much of a full turn (rad) round a place on a rim of a body is rock of it; 0 off the rims."""
    for ring in body.rings:
        near = np.flatnonzero(np.hypot(*(ring - place).T) < SAME_PLACE)
        if len(near):
            return float(np.pi - ring_turns(ring)[near[0]])
    on_side = any(shapely.dwithin(shapely.LinearRing(ring), shapely.Point(place), SAME_PLACE) for ring in body.rings)
    return float(np.pi) if on_side else 0.0


def _corners(ring: Floats) -> Iterator[RimSingularity]:
    """Re-entrant corners of a ring (n, 2) with the rock on its left, and the shorter of their sides."""
    turns = ring_turns(ring)
    sharp = np.flatnonzero(np.abs(turns) > SHARP_CORNER)
    along = np.append(0.0, np.cumsum(np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)))
    sides = np.diff(along[sharp], append=along[sharp[:1]] + along[-1])
    for corner, extent in zip(sharp.tolist(), np.minimum(sides, np.roll(sides, 1)).tolist(), strict=True):
        if turns[corner] < 0.0:
            yield RimSingularity(ring[corner], extent, free_exponent(np.pi - turns[corner]))


def _ends(region: EdgeRegion, body: BodyGeometry) -> Iterator[RimSingularity]:
    """The ends of a held part of a rim, with lambda of antiplane shear, pi / 2w; none at sharp convex corners."""
    sides = body.sides[region.sides]
    step = sides[:, 1] - sides[:, 0]
    extent = float((np.hypot(*step.T) * np.diff(region.limits, axis=1)[:, 0]).sum())
    ends = sides[[0, -1], 0] + region.limits[[0, -1], [0, 1]][:, None] * step[[0, -1]]
    if np.hypot(*(ends[1] - ends[0])) < SAME_PLACE:
        return  # all round
    for end in ends:
        exponent = max(CRACK, np.pi / (2.0 * rock_angle(body, end)))
        if exponent < 1.0 - 1e-9:
            yield RimSingularity(end, extent, exponent)


def ring_turns(ring: Floats) -> Floats:
    """How far (n,) rad a ring (n, 2) turns to the left at its corners."""
    return kink_angles(np.concatenate([ring[-1:], ring, ring[:1]]))
