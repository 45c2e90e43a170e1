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


Asked = Iterator[tuple[Floats, int]]  # a place, and how often cells are halved there


def lattice_of_cells(scene: Scene, cracks: Sequence[CrackGeometry], before: Lattice | None) -> Lattice:
    """The lattice of a scene with these cracks; that of the configuration before if its cells are the same."""
    refine, halvings = scene.case.numerics.refine, scene.halvings
    asked = (
        _tips(cracks, [refine.tips + halvings.at_tips(number) for number in range(len(cracks))]),
        _kinks(cracks, [refine.kinks + halvings.at_kinks(number) for number in range(len(cracks))]),
        ((place, refine.kinks) for place in (_kinks_of_interfaces(scene) if refine.kinks else ())),
        ((place, refine.corners) for place in (_corners(scene) if refine.corners else ())),
    )
    found = [(shapely.Point(place), levels) for place, levels in chain(*asked) if levels]
    if halvings.everywhere:
        found.append((shapely.box(0.0, 0.0, *map(float, scene.lattice.shape)), 0))
    if not found:
        return scene.lattice
    sizes = np.array([0.5 ** (halvings.everywhere + levels) for _, levels in found])
    return refined(scene.lattice, Focus(np.array([place for place, _ in found]), sizes), refine.rings, before)


def _tips(cracks: Sequence[CrackGeometry], levels: Sequence[int]) -> Asked:
    return ((crack.seen_from(end)[0], n) for crack, n in zip(cracks, levels, strict=True) for end in crack.tips())


def _kinks(cracks: Sequence[CrackGeometry], levels: Sequence[int]) -> Asked:
    """Sharp kinks, ends that are no tips, since they lie on outlines or on other cracks, and where cracks meet."""
    if not any(levels):
        return
    for crack, n in zip(cracks, levels, strict=True):
        for place in crack.points[1:-1][np.abs(kink_angles(crack.points)) > SHARP_KINK]:
            yield place, n
        for place, tip in ((0, crack.tip_at_start), (-1, crack.tip_at_end)):
            if not tip:
                yield crack.points[place], n
    yield from _meetings(cracks, levels)


def _kinks_of_interfaces(scene: Scene) -> Iterator[Floats]:
    for line in scene.interfaces:
        yield from line.points[1:-1][np.abs(kink_angles(line.points)) > SHARP_KINK]


def _meetings(cracks: Sequence[CrackGeometry], levels: Sequence[int]) -> Asked:
    """Where cracks cross or end on each other."""
    lines = np.array([shapely.LineString(crack.points) for crack in cracks], dtype=object)
    first, second = shapely.STRtree(lines).query(lines, predicate="intersects")
    for i, j in zip(first.tolist(), second.tolist(), strict=True):
        if i < j:
            for place in shapely.get_coordinates(shapely.intersection(lines[i], lines[j])):
                yield place, max(levels[i], levels[j])


def _corners(scene: Scene) -> Iterator[Floats]:
    """Re-entrant corners, since the rock lies on the left of all rings, and ends of regions."""
    for body in scene.bodies:
        for ring in body.rings:
            turns = kink_angles(np.concatenate([ring[-1:], ring, ring[:1]]))
            yield from ring[turns < -SHARP_CORNER]
    yield from _ends_of_regions(scene)


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
