"""The discs round a tip that its interaction integrals extend over: how large they may be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import Tip

RADIUS = 2.5
"""Radius of the disc in cells at the tip: from 1.5 on K is within 0.2 % on straight cracks, and kinks of the last
increments, which the cover does not resolve, disturb a disc that reaches beyond them least."""

STRAIGHT_RADIUS = 5.0
"""The same as far as the crack is straight: a larger disc averages the stress, which ripples, over more cells."""

KEPT_CLEAR = 0.8
"""Part of the clearance that a disc may take: one that touches another tip was 0.7 to 1.6 % off, this one 0.1."""

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
    shrunk: bool
    obstacle: str

    @property
    def radii(self) -> Floats:
        """Of all discs (n,), spacings, increasing."""
        return self.radius * PARTS


def disc_round(cover: Cover, tip: Tip) -> Disc:
    """The disc of a tip."""
    straight = min(float(tip.radii[1]), STRAIGHT_RADIUS * tip.size)
    room, obstacle = clearance(cover, tip)
    room *= KEPT_CLEAR
    wanted = max(RADIUS * tip.size, min(straight, room))
    if room < SMALLEST_RADIUS * tip.size:
        return Disc(tip, float("nan"), True, obstacle)
    return Disc(tip, min(wanted, room), room < wanted, obstacle)


def clearance(cover: Cover, tip: Tip) -> tuple[float, str]:
    """Largest radius (spacings) of a disc round a tip that holds one stretch of its own crack alone; what limits it."""
    place = shapely.Point(tip.point)
    obstacles = {"the crack's other end": shapely.distance(place, shapely.Point(tip.points[-1]))}
    if len(tip.path) < len(tip.points):  # the crack turns back towards its tip
        bend = shapely.LineString(tip.points[len(tip.path) - 1 :])
        obstacles["the crack's own bend"] = shapely.distance(place, bend)
    reach = min(obstacles.values())  # what lies farther away does not count
    for number in cover.crack_tree.query(place, predicate="dwithin", distance=reach):
        if number != tip.crack:
            line = cover.crack_tree.geometries[number]
            obstacles[f"crack '{cover.cracks[number].name}'"] = shapely.distance(place, line)
    sides = cover.outline_tree.geometries[cover.outline_tree.query(place, predicate="dwithin", distance=reach)]
    if len(sides):
        obstacles["the outline"] = shapely.distance(place, sides).min()
    return min((float(distance), name) for name, distance in obstacles.items())
