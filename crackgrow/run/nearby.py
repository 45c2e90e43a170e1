"""What tips may come near to: other cracks, interfaces, outlines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.features import line_length
from crackgrow.cover.cover import Cover
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.run.scene import Scene


class Nearby:
    """The lines of a scene with these cracks."""

    def __init__(self, scene: Scene, cracks: Sequence[CrackGeometry]) -> None:
        rings = [np.concatenate([ring, ring[:1]]) for body in scene.bodies for ring in body.rings]
        lines = [*(crack.points for crack in cracks), *(line.points for line in scene.interfaces), *rings]
        self._lines = np.array([shapely.LineString(points) for points in lines], dtype=object)
        self._tree = shapely.STRtree(self._lines)

    def distance(self, crack: int, place: Floats, reach: float) -> float:
        """Distance of the nearest other line from a place on a crack; inf where there is none within `reach`."""
        point = shapely.Point(place)
        near = self._tree.query(point, "dwithin", distance=reach)
        return float(shapely.distance(point, self._lines[near[near != crack]]).min(initial=np.inf))


def room_at_tips(scene: Scene, cover: Cover) -> tuple[float, ...]:
    """Distance (m) of the nearest other line from each tip: at most the length of its crack, K hardly knows of more."""
    nearby, found = Nearby(scene, cover.cracks), []
    for tip in cover.tips:
        length = line_length(tip.points)
        found.append(min(length, nearby.distance(tip.crack, tip.point, length)))
    return tuple(scene.lattice.spacing * room for room in found)
