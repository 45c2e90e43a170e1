"""Where a scene asks for small cells: at crack tips, at kinks and ends of cracks, at corners of bodies.

At a tip the stress is singular; tip functions follow it, as long as the cells are small by the tip's distance from
everything else. A kink is a corner of the rock on one side of the crack, and closed faces are pressed open there over
a small part of the segment behind it: no function follows that, cells have to. So do they at re-entrant corners, and
where a support or a load is a point or ends within an edge.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.model import ContactSupport, EdgeRegion, EdgeSupport, EdgeTraction, PointSupport
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.refinement import Focus, refined
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.geometry.polyline import kink_angles
from crackgrow.run.scene import Scene

SHARP_KINK = np.deg2rad(10.0)
"""Less sharp kinks are as good as straight: of grown wings the kink at the flaw counts, not the turns of a path."""

SHARP_CORNER = np.deg2rad(20.0)
"""Less sharp re-entrant corners are those of a curve."""


def lattice_of_cells(scene: Scene, cracks: Sequence[CrackGeometry], before: Lattice | None) -> Lattice:
    """The lattice of a scene with these cracks; that of the configuration before if its cells are the same."""
    refine = scene.case.numerics.refine
    asking = (
        (refine.tips, _tips(cracks)),
        (refine.kinks, chain(_kinks(scene, cracks), _meetings(cracks))),
        (refine.corners, chain(_corners(scene), _ends_of_regions(scene))),
    )
    found = [(place, 0.5**levels) for levels, places in asking if levels for place in places]
    if not found:
        return scene.lattice
    places, sizes = (np.array(values) for values in zip(*found, strict=True))
    return refined(scene.lattice, Focus(shapely.points(places), sizes), refine.rings, before)


def _tips(cracks: Sequence[CrackGeometry]) -> Iterator[Floats]:
    return (crack.seen_from(at_end)[0] for crack in cracks for at_end in crack.tips())


def _kinks(scene: Scene, cracks: Sequence[CrackGeometry]) -> Iterator[Floats]:
    """Sharp kinks, and ends that are no tips: they lie on outlines or on other cracks."""
    for crack in cracks:
        yield from crack.points[1:-1][np.abs(kink_angles(crack.points)) > SHARP_KINK]
        yield from (crack.points[place] for place, tip in ((0, crack.tip_at_start), (-1, crack.tip_at_end)) if not tip)
    for line in scene.interfaces:
        yield from line.points[1:-1][np.abs(kink_angles(line.points)) > SHARP_KINK]


def _meetings(cracks: Sequence[CrackGeometry]) -> Iterator[Floats]:
    """Where cracks cross or end on each other."""
    lines = np.array([shapely.LineString(crack.points) for crack in cracks], dtype=object)
    first, second = shapely.STRtree(lines).query(lines, predicate="intersects")
    for i, j in zip(first.tolist(), second.tolist(), strict=True):
        if i < j:
            yield from shapely.get_coordinates(shapely.intersection(lines[i], lines[j]))


def _corners(scene: Scene) -> Iterator[Floats]:
    """Re-entrant corners; the rock lies on the left of all rings."""
    for body in scene.bodies:
        for ring in body.rings:
            turns = kink_angles(np.concatenate([ring[-1:], ring, ring[:1]]))
            yield from ring[turns < -SHARP_CORNER]


def _ends_of_regions(scene: Scene) -> Iterator[Floats]:
    """Point supports, and ends of supported, loaded and founded parts within sides of bodies."""
    case = scene.case
    numbers = {body.name: number for number, body in enumerate(case.bodies)}
    for support in case.supports:
        if isinstance(support, PointSupport):
            yield scene.lattice.to_lattice(support.point)
    on_edges = (*case.supports, *case.loads)
    regions = [part.region for part in on_edges if isinstance(part, EdgeSupport | ContactSupport | EdgeTraction)]
    for region in regions:
        yield from _ends_within_sides(region, scene.bodies[numbers[region.body]].sides)


def _ends_within_sides(region: EdgeRegion, sides: Floats) -> Iterator[Floats]:
    for side, share in ((region.sides[0], region.limits[0, 0]), (region.sides[-1], region.limits[-1, 1])):
        if 0.0 < share < 1.0:
            yield sides[side, 0] + share * (sides[side, 1] - sides[side, 0])
