"""The discs round a tip that its interaction integrals extend over: how large they may be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import Tip
from crackgrow.geometry.polyline import kink_angles

NOWHERE = np.zeros((0, 2))
"""No points."""

KEPT_CLEAR = 0.85
"""Part of the clearance that a disc takes: with 0.9 a point load beside it puts K off by 2e-4. In one of n cells
ripples of the stress put K of straight cracks off by 1e-3 at n = 1.5, 2e-4 at 5, 5e-5 at 10: K converges with the
cells. Kinks of its own crack inside disturb no more than those outside."""

SHARP = np.deg2rad(20.0)
"""A kink of more is a corner of the rock on one side of the crack."""

BEFORE_KINK = 1.0
"""Cells at the tip: discs are not ended at a pressed kink where they would be smaller."""

SMALL = 2.5
"""Cells at the tip: a disc below is told of."""

SMALLEST_RADIUS = 1e-4
"""Cells: a smaller disc is as large as rounding. Tip functions make small ones worth something: 0.1 cells from
another tip K is within 3 %, where the displacement of the faces misses by 15."""

PARTS = np.array([0.7, 0.85, 1.0])
"""The discs, as fractions of the radius, whose spread tells how far K depends on them."""


@dataclass(frozen=True, slots=True, eq=False)
class Disc:
    """The largest disc of a tip's integrals."""

    tip: Tip
    radius: float  # spacings; nan where none fits
    small: bool  # whether it spans but few cells
    obstacle: str

    @property
    def radii(self) -> Floats:
        """Of all discs (n,), spacings, increasing."""
        return self.radius * PARTS


def disc_round(cover: Cover, tip: Tip, singular: Floats = NOWHERE, *, pressed: bool = False) -> Disc:
    """The disc of a tip, clear of `singular` points; where faces are `pressed` it ends before the first sharp kink.

    There tractions are as singular as the stress, and what they do not resolve puts K off by up to 5 %, the more at
    random the smaller the cells are.
    """
    room, obstacle = clearance(cover, tip, singular)
    if pressed:
        corner = first_corner(tip)
        if BEFORE_KINK * tip.size < KEPT_CLEAR * corner < KEPT_CLEAR * room:
            room, obstacle = corner, "the crack's kink"
    radius = KEPT_CLEAR * room
    if radius < SMALLEST_RADIUS * tip.size:
        return Disc(tip, float("nan"), True, obstacle)
    return Disc(tip, radius, radius < SMALL * tip.size, obstacle)


def first_corner(tip: Tip) -> float:
    """Distance (spacings) of the first sharp kink from a tip; inf where its crack has none."""
    corners = tip.points[1:-1][np.abs(kink_angles(tip.points)) > SHARP]
    return float(np.hypot(*(corners[0] - tip.point))) if len(corners) else np.inf


def clearance(cover: Cover, tip: Tip, singular: Floats = NOWHERE) -> tuple[float, str]:
    """Largest radius (spacings) of a disc round a tip that holds one stretch of its own crack alone; what limits it.

    No disc holds one of the points `singular` (k, 2), either, at which forces act.
    """
    place = shapely.Point(tip.point)
    obstacles = {"the crack's other end": shapely.distance(place, shapely.Point(tip.points[-1]))}
    if len(tip.path) < len(tip.points):  # the crack turns back towards its tip
        bend = shapely.LineString(tip.points[len(tip.path) - 1 :])
        obstacles["the crack's own bend"] = shapely.distance(place, bend)
    if len(singular):
        obstacles["what acts on a point"] = float(np.hypot(*(singular - tip.point).T).min())
    reach = min(obstacles.values())  # what lies farther away does not count
    for number in cover.crack_tree.query(place, predicate="dwithin", distance=reach):
        if number != tip.crack:
            line = cover.crack_tree.geometries[number]
            obstacles[cover.cracks[number].name.words] = shapely.distance(place, line)
    sides = cover.outline_tree.geometries[cover.outline_tree.query(place, predicate="dwithin", distance=reach)]
    if len(sides):
        obstacles["the outline"] = shapely.distance(place, sides).min()
    return min((float(distance), name) for name, distance in obstacles.items())
