"""Where a scene asks for small cells: at crack tips, at kinks and ends of cracks, at corners of bodies.

At a tip the stress is singular; tip functions follow it, as long as the cells are small by the tip's distance from
everything else. A kink is a corner of the rock on one side of the crack, and closed faces are pressed open there over
a small part of the segment behind it: no function follows that, cells have to. So do they at re-entrant corners, and
where a support or a load is a point or ends within an edge; more so beside a tip.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Literal

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.accuracy import AUTO, preset_of
from crackgrow.case.features import line_length, stretches
from crackgrow.case.model import ContactSupport, EdgeLoad, EdgeRegion, EdgeSupport, PointForce, PointSupport
from crackgrow.case.toughness import length_of_average
from crackgrow.cover.gathered import STRAIGHT
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.refinement import Focus, refined
from crackgrow.cover.shapes import CrackGeometry, body_index
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.run.halvings import AS_GIVEN
from crackgrow.run.nearby import Nearby
from crackgrow.run.rim_singularities import SHARP_CORNER, rim_singularities, ring_turns
from crackgrow.run.scene import Scene

Asking = Iterator[tuple[shapely.Geometry, float]]
"""Places and the largest cells that they allow, both in lattice units."""

BESIDE = 1.5
"""Spacings from a tip: farther away cells are no smaller for a tip, once all of them are halved."""

ROOM = 3.0
"""For a target the room at a tip counts as a third of a crack's length does: a name has a third of the cells in it."""

ACROSS = 6.0
"""Cells from a tip to a place beside it: halved, as all are, they are smaller than those that the tip makes there."""


def lattice_of_cells(scene: Scene, cracks: Sequence[CrackGeometry], before: Lattice | None) -> Lattice:
    """The lattice of a scene with these cracks; that of the configuration before if its cells are the same."""
    return refined(scene.lattice, focus_of(scene, cracks), scene.case.numerics.refine.rings, before)


def focus_of(scene: Scene, cracks: Sequence[CrackGeometry]) -> Focus:
    """The places that ask for cells smaller than the largest, and all of the scene where all cells are halved."""
    corners = (_at_corners(scene), _at_rims_beside_tips(scene, cracks), _beside_tips(scene, cracks))
    asking = chain(_at_tips(scene, cracks), _at_kinks(scene, cracks), _at_partings(scene), *corners)
    # sizes are those asked for where the cells that nothing is asked of have the side that the case gives
    everywhere = 0.5**scene.halvings.everywhere
    finer = everywhere * scene.lattice.spacing / scene.case.numerics.spacing
    found = [(place, finer * size) for place, size in asking if finer * size < everywhere]
    if scene.halvings.everywhere:
        found.append((shapely.box(0.0, 0.0, *map(float, scene.lattice.shape)), everywhere))
    return Focus(np.array([place for place, _ in found], dtype=object), np.array([size for _, size in found]))


def _at_tips(scene: Scene, cracks: Sequence[CrackGeometry]) -> Asking:
    """Tips: by the length of the crack, of the stretch behind the tip, of what it grows by, and by its room."""
    halvings, growth = scene.case.numerics.refine.tips, scene.case.growth
    times = [scene.halvings.at_tips(number) for number in range(len(cracks))]
    tips = [(n, crack.seen_from(end)) for n, crack in enumerate(cracks) for end in crack.tips()]
    if halvings != AUTO:
        given = _given(scene, halvings)
        yield from ((shapely.Point(points[0]), 0.5 ** times[n] * given) for n, points in tips)
        return
    nearby = Nearby(scene, cracks)
    if scene.case.numerics.target is not None:
        given = _given(scene, 0)
        for n, points in tips:
            size = 0.5 ** times[n] * given
            if times[n]:
                size = min(size, max(_gathering(points), 0.5 ** scene.halvings.at_kinks(n) * given))
            yield shapely.Point(points[0]), size * _tight(nearby, n, points)
        return
    preset, spacing = preset_of(scene.case.numerics.accuracy), scene.lattice.spacing
    for number, points in tips:
        grown = np.inf
        if growth is not None and growth.steps > 0:
            radius = length_of_average(growth, scene.case.bodies[scene.crack_bodies[number]].strength)
            grown = min(growth.increment / preset.per_increment, radius / preset.per_radius) / spacing
        size = min(line_length(points) / preset.per_crack, stretches(points)[1][0] / preset.per_stretch)
        room = nearby.distance(number, points[0], size * preset.per_room) / preset.per_room
        least = line_length(points) / preset.per_rough
        room = max(room, least if room <= SAME_PLACE else 0.0)  # the end of one that has met another crack has none
        yield shapely.Point(points[0]), _halved(scene, min(grown, max(size, least), room), times[number])


def _tight(nearby: Nearby, crack: int, points: Floats) -> float:
    """How much smaller the cells at a tip are for its room: the same part of all cells that K is held against.

    The end of a crack that has met another one has no room, and is no tip.
    """
    enough = line_length(points) / ROOM
    room = nearby.distance(crack, points[0], enough)
    return min(room / enough, 1.0) if room > SAME_PLACE else 1.0


def _gathering(points: Floats) -> float:
    """The size (spacings) of cells at a tip with a kink behind it whose functions gather, on cells twice as large too.

    Where the stretch between them is shorter than that, functions on every patch reach over all small cells at the
    kink: there are ten times as many.
    """
    sharp, parts = stretches(points)
    return float(parts[0]) / (2.0 * STRAIGHT) if len(sharp) else np.inf


def _at_kinks(scene: Scene, cracks: Sequence[CrackGeometry]) -> Asking:
    """Sharp kinks, meetings of cracks, and ends that are no tips: they lie on outlines or on other cracks."""
    halvings, preset = _asked(scene, scene.case.numerics.refine.kinks), preset_of(scene.case.numerics.accuracy)
    times = [scene.halvings.at_kinks(number) for number in range(len(cracks))]
    given = None if halvings == AUTO else _given(scene, halvings)
    for line, n in zip((*cracks, *scene.interfaces), times + [0] * len(scene.interfaces), strict=True):
        sharp, parts = stretches(line.points)
        beside = np.sort([parts[:-1], parts[1:]], axis=0)
        sizes = np.minimum(beside[0] / preset.per_stretch, beside[1] / preset.per_longer)
        sizes = np.maximum(sizes, line_length(line.points) / preset.per_rough)
        for place, size in zip(sharp.tolist(), sizes.tolist(), strict=True):
            yield shapely.Point(line.points[place]), _halved(scene, size if given is None else given, n)
    times = [scene.halvings.at_ends(number) for number in range(len(cracks))]
    for crack, n in zip(cracks, times, strict=True):
        size = line_length(crack.points) / preset.per_crack
        for place, is_tip in ((0, crack.tip_at_start), (-1, crack.tip_at_end)):
            if not is_tip:
                yield shapely.Point(crack.points[place]), _halved(scene, size if given is None else given, n)
    for place, length, both in _meetings(cracks):
        size = length / preset.per_crack if given is None else given
        yield shapely.Point(place), _halved(scene, size, max(times[number] for number in both))


def _at_partings(scene: Scene) -> Asking:
    """Stretches between open and closed faces, with cells as small as `run.next_cells` has found to be needed."""
    for *ends, times in scene.halvings.places:
        yield shapely.LineString(scene.lattice.to_lattice(np.reshape(ends, (2, 2)))), _given(scene, times)


def _at_corners(scene: Scene) -> Asking:
    """Re-entrant corners and places of supports and loads, or all lengths that the stress varies over."""
    halvings, preset = scene.case.numerics.refine.corners, preset_of(scene.case.numerics.accuracy)
    finer = 0.5**scene.halvings.corners
    if halvings != AUTO:
        given = finer * _given(scene, halvings)
        yield from ((shapely.Point(p), given) for p in chain(_corners(scene), _ends_of_regions(scene)))
        return
    for length in scene.lengths:
        if length.where is not None:
            where = shapely.transform(length.where, scene.lattice.to_lattice)
            yield where, finer * length.metres / preset.parts(length.kind) / scene.lattice.spacing


def _at_rims_beside_tips(scene: Scene, cracks: Sequence[CrackGeometry]) -> Asking:
    """Re-entrant corners and ends of held parts, by their distance from the nearest tip."""
    tips = _tips(cracks)
    if scene.case.numerics.refine.corners != AUTO or not len(tips):
        return
    finer, preset = 0.5**scene.halvings.corners, preset_of(scene.case.numerics.accuracy)
    for place in rim_singularities(scene):
        if (tips != place.point).any(axis=1).all():
            yield shapely.Point(place.point), finer * place.size_for(tips, preset.per_distance)


def _tips(cracks: Sequence[CrackGeometry]) -> Floats:
    """All tips (n, 2)."""
    return np.array([crack.seen_from(end)[0] for crack in cracks for end in crack.tips()]).reshape(-1, 2)


def _beside_tips(scene: Scene, cracks: Sequence[CrackGeometry]) -> Asking:
    """To measure the error of K: forces and supports at points, ends of loaded and held parts, that lie beside a tip.

    Cells round a tip grow with the distance from it, however small its own are: these places lie among them. Where
    nothing else asks for cells there, those that K is held against are the same, and tell nothing of such a place.
    """
    tips = _tips(cracks)
    if scene.halvings == AS_GIVEN or scene.case.numerics.measured_of != "K" or not len(tips):
        return
    finer = 0.5**scene.halvings.corners
    for place in chain(_ends_of_regions(scene), _forces(scene)):
        apart = float(np.hypot(*(tips - place).T).min())
        if 0.0 < apart < BESIDE:
            yield shapely.Point(place), finer * apart / ACROSS


def _forces(scene: Scene) -> Iterator[Floats]:
    """Where forces act at points."""
    yield from (scene.lattice.to_lattice(load.point) for load in scene.case.loads if isinstance(load, PointForce))


def _asked(scene: Scene, halvings: int | Literal["auto"]) -> int | Literal["auto"]:
    """Halvings at tips and kinks: those for a target are found by the run, and none are asked for by lengths."""
    return 0 if halvings == AUTO and scene.case.numerics.target is not None else halvings


def _given(scene: Scene, halvings: int) -> float:
    """The size (spacings) of cells of the case halved so often."""
    return 0.5**halvings * scene.case.numerics.spacing / scene.lattice.spacing


def _halved(scene: Scene, size: float, times: int) -> float:
    """Cells halved some times at a place that asks for such a size: those of the case are there where it is larger."""
    return 0.5**times * min(size, _given(scene, 0))


def _meetings(cracks: Sequence[CrackGeometry]) -> Iterator[tuple[Floats, float, tuple[int, int]]]:
    """Where cracks cross or end on each other, the length of the shorter one, and their numbers."""
    lines = np.array([shapely.LineString(crack.points) for crack in cracks], dtype=object)
    first, second = shapely.STRtree(lines).query(lines, predicate="intersects")
    for i, j in zip(first.tolist(), second.tolist(), strict=True):
        if i < j:
            shorter = float(shapely.length(lines[[i, j]]).min())
            for place in shapely.get_coordinates(shapely.intersection(lines[i], lines[j])):
                yield place, shorter, (i, j)


def _corners(scene: Scene) -> Iterator[Floats]:
    """Re-entrant corners; the rock lies on the left of all rings."""
    for body in scene.bodies:
        for ring in body.rings:
            yield from ring[ring_turns(ring) < -SHARP_CORNER]


def _ends_of_regions(scene: Scene) -> Iterator[Floats]:
    """Point supports, and ends of supported, loaded and founded parts within sides of bodies."""
    case = scene.case
    for support in case.supports:
        if isinstance(support, PointSupport):
            yield scene.lattice.to_lattice(support.point)
    on_edges = (*case.supports, *case.loads)
    regions = [part.region for part in on_edges if isinstance(part, EdgeSupport | ContactSupport | EdgeLoad)]
    for region in regions:
        yield from _ends_within_sides(region, scene.bodies[body_index(scene.bodies, region.body)].sides)


def _ends_within_sides(region: EdgeRegion, sides: Floats) -> Iterator[Floats]:
    for side, share in ((region.sides[0], region.limits[0, 0]), (region.sides[-1], region.limits[-1, 1])):
        if 0.0 < share < 1.0:
            yield sides[side, 0] + share * (sides[side, 1] - sides[side, 0])
