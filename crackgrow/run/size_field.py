"""Features: places where the solution is not smooth, and the largest cells right there.

At a tip the stress is singular; tip functions follow it where cells are small by the lengths beside it. A kink is a
corner of the rock on one side of a crack, and closed faces are pressed open there over a small part of the stretch
behind it: no function follows that, cells have to. So do they at re-entrant corners, where a held part ends, where the
contact status changes, and where a pressure on faces varies. Lengths are measured in `case.accuracy.CELLS`; a level of
refinement (`Grading`) halves the cells at all features of a crack.

The size of cells is h(x) = max(depth of the feature, theta distance to it), balanced: a companion has theta = 1 / rings
and twice the depths, the step's cells are the companion's, each quartered.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.accuracy import AUTO, Kind, cells_along
from crackgrow.case.formula import component_at
from crackgrow.case.model import ContactSupport, EdgeLoad, EdgeSupport, FluidPressure, PointForce
from crackgrow.case.segments import line_length
from crackgrow.case.sizing import SHARP_KINK, stretches
from crackgrow.case.toughness import length_of_average
from crackgrow.cover.refinement import SizeField
from crackgrow.cover.shapes import CrackGeometry, body_index, ends_at_bonds
from crackgrow.geometry.polyline import kink_angles
from crackgrow.geometry.tolerance import SAME_PLACE

if TYPE_CHECKING:
    from crackgrow.run.scene import Scene

SHARP_CORNER = np.deg2rad(20.0)
"""Less sharp re-entrant corners are those of a curve."""

WEAKEST_KINK = np.deg2rad(0.5)
"""Less is none. A closed crack of 40 mm whose wings turn by 8 degrees has K off by 3.4 % without cells for that."""

JOG = 4.0
"""Cells at kinks and tips are at most so many times smaller than those at a kink, however short the stretch beside."""

SAMPLES = 129
"""Places along a face at which a pressure is looked at."""

THETA_OF_REST = 1.5
"""Rings of each size for each level of the rest of a scene, over those of the level before."""

Features = Iterator[tuple[shapely.Geometry, float]]
"""Places and the largest cells of a step right there, lattice units."""


def size_field(scene: Scene, cracks: Sequence[CrackGeometry]) -> SizeField:
    """Depths at features, in the largest cells, and rings of cells of each size round them.

    Tips have as many as the support: no larger patches than those at the tip hold it, on which its functions would be
    too few. A companion has half of the others, since the step's cells, each quartered, have twice as many. The
    refinement levels of a case by hand take the place of lengths.
    """
    refine, grading = scene.case.numerics.refine, scene.grading
    at_tips = max(refine.rings, scene.lattice.support)
    times, rings = (2.0, 0.5 * refine.rings) if grading.nested else (1.0, at_tips)
    classes: list[tuple[int | str, float, Features]] = [
        (refine.tips, at_tips, chain(_tips(scene, cracks), _interface_tips(scene))),
        (refine.kinks, rings, chain(_kinks(scene, cracks), _ends(scene, cracks), _meetings(scene, cracks))),
        (refine.corners, rings, _sharp_corners(scene, cracks)),
        (AUTO, rings, _rims(scene) if refine.corners == AUTO else iter(())),
    ]
    if grading.nested:
        classes.append((AUTO, rings, chain(_changes_of_status(scene, cracks), _pressures(scene, cracks))))
    found: list[tuple[shapely.Geometry, float, float]] = []
    for levels, n_rings, features in classes:
        by_hand = scene.case.numerics.spacing / scene.lattice.spacing * 0.5**levels if isinstance(levels, int) else None
        sizes = ((place, times * (by_hand or size)) for place, size in features)
        found += [(place, size, n_rings) for place, size in sizes if size < 1.0]
    places, depths, widths = zip(*found, strict=True) if found else ((), (), ())
    theta = np.array(widths, dtype=float) * THETA_OF_REST**grading.rest
    return SizeField(np.array(places, dtype=object), np.array(depths, dtype=float), theta)


def _along(scene: Scene, length: float, kind: Kind, level: int = 0) -> float:
    """Cells that a length has so many of, after some levels of refinement."""
    return 0.5**level * length / cells_along(kind, scene.case.numerics.accuracy)


def _tips(scene: Scene, cracks: Sequence[CrackGeometry]) -> Features:
    """Tips: by the crack, the stretch behind, what it grows by, and its room; never coarser than a run begins with."""
    growth = scene.case.growth
    rings = [np.concatenate([ring, ring[:1]]) for body in scene.bodies for ring in body.rings]
    others = [*(crack.points for crack in cracks), *(line.points for line in scene.interfaces), *rings]
    lines = np.array([shapely.LineString(points) for points in others], dtype=object)
    tree = shapely.STRtree(lines)
    for number, crack in enumerate(cracks):
        for end in crack.tips():
            points, level = crack.seen_from(end), scene.grading.level(number)
            tip, length = shapely.Point(points[0]), line_length(points)
            near = tree.query(tip, "dwithin", distance=length)
            room = float(shapely.distance(tip, lines[near[near != number]]).min(initial=np.inf))
            sizes = [_along(scene, length, "tip"), _along(scene, stretches(points)[1][0], "stretch")]
            if room > SAME_PLACE:  # the end of a crack that has met another one has none
                sizes.append(_along(scene, room, "room"))
            least = _along(scene, length, "kink") / JOG
            if growth is not None and growth.steps > 0:
                radius = length_of_average(growth, scene.case.bodies[scene.crack_bodies[number]].strength)
                sizes += [
                    _along(scene, growth.increment / scene.lattice.spacing, "increment"),
                    _along(scene, radius / scene.lattice.spacing, "radius"),
                ]
            yield tip, 0.5 ** max(level, 0) * max(min(sizes), least)


def _interface_tips(scene: Scene) -> Features:
    """Tips of cracked interfaces, whose stress no function follows: by the crack, its last part, increments."""
    growth = scene.case.growth
    for number, at_end in ends_at_bonds(scene.interfaces):
        points = scene.interfaces[number].seen_from(at_end)
        beside = _along(scene, float(np.hypot(*(points[1] - points[0]))), "stretch", scene.grading.rest)
        size = min(_along(scene, line_length(points), "kink", scene.grading.rest), beside)
        if growth is not None and growth.steps > 0 and scene.debonds:
            size = min(size, _along(scene, growth.increment / scene.lattice.spacing, "increment"))
        yield shapely.Point(points[0]), size


def _kinks(scene: Scene, cracks: Sequence[CrackGeometry]) -> Features:
    """Kinks of cracks and interfaces: larger cells at those that hardly turn, hardly smaller ones for jogs."""
    weakest = WEAKEST_KINK if scene.case.numerics.refine.kinks == AUTO else SHARP_KINK  # by hand all have one size
    for number, line in enumerate((*cracks, *scene.interfaces)):
        level = scene.grading.level(number) if number < len(cracks) else scene.grading.rest
        least = _along(scene, line_length(line.points), "kink", level)
        turns = np.abs(kink_angles(line.points))
        size = least * np.maximum(SHARP_KINK / np.maximum(turns, WEAKEST_KINK), 1.0) ** 2
        sharp, parts = stretches(line.points)
        beside = _along(scene, 1.0, "stretch", level) * np.minimum(parts[:-1], parts[1:])
        size[sharp - 1] = np.maximum(np.minimum(size[sharp - 1], beside), least / JOG)
        for place in np.flatnonzero(turns > weakest).tolist():
            yield shapely.Point(line.points[place + 1]), float(size[place])


def _ends(scene: Scene, cracks: Sequence[CrackGeometry]) -> Features:
    """Ends of cracks that are no tips: they lie on outlines or on other cracks."""
    for number, crack in enumerate(cracks):
        size = _along(scene, line_length(crack.points), "end", scene.grading.level(number))
        for place, is_tip in ((0, crack.tip_at_start), (-1, crack.tip_at_end)):
            if not is_tip:
                yield shapely.Point(crack.points[place]), size


def _meetings(scene: Scene, cracks: Sequence[CrackGeometry]) -> Features:
    """Where cracks cross or end on each other: by the shorter one."""
    lines = np.array([shapely.LineString(crack.points) for crack in cracks], dtype=object)
    first, second = shapely.STRtree(lines).query(lines, predicate="intersects")
    for i, j in zip(first.tolist(), second.tolist(), strict=True):
        if i < j:
            level = max(scene.grading.level(i), scene.grading.level(j))
            size = _along(scene, float(shapely.length(lines[[i, j]]).min()), "end", level)
            for place in shapely.get_coordinates(shapely.intersection(lines[i], lines[j])):
                yield shapely.Point(place), size


def _sharp_corners(scene: Scene, cracks: Sequence[CrackGeometry]) -> Features:
    """Re-entrant corners, ends of loaded, held and bonded parts within sides, forces: by their distance from a tip.

    What is small beside that distance is seen at it by the square of both.
    """
    tips = np.array([crack.seen_from(end)[0] for crack in cracks for end in crack.tips()]).reshape(-1, 2)
    for place, extent in chain(_corners(scene), _ends_of_parts(scene), _forces(scene)):
        apart = float(np.hypot(*(tips - place).T).min(initial=np.inf))
        beside = _along(scene, apart * max(1.0, apart / extent) if np.isfinite(apart) else np.inf, "distance")
        size = min(_along(scene, extent, "feature"), beside)
        if apart > SAME_PLACE:
            yield shapely.Point(place), 0.5**scene.grading.rest * size


def _corners(scene: Scene) -> Iterator[tuple[Floats, float]]:
    """Re-entrant corners of bodies, whose rock lies on the left of all rings, and the shorter of their sides."""
    for ring in chain.from_iterable(body.rings for body in scene.bodies):
        turns = _turns(ring)
        sharp = np.flatnonzero(np.abs(turns) > SHARP_CORNER)
        along = np.append(0.0, np.cumsum(np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)))
        sides = np.diff(along[sharp], append=along[sharp[:1]] + along[-1])
        for corner, extent in zip(sharp.tolist(), np.minimum(sides, np.roll(sides, 1)).tolist(), strict=True):
            if turns[corner] < 0.0:
                yield ring[corner], extent


def _ends_of_parts(scene: Scene) -> Iterator[tuple[Floats, float]]:
    """Ends of supported, loaded and founded parts that are no convex corners, and the lengths of the parts."""
    for part in (*scene.case.supports, *scene.case.loads):
        if isinstance(part, EdgeSupport | ContactSupport | EdgeLoad):
            region, body = part.region, scene.bodies[body_index(scene.bodies, part.region.body)]
            convex = np.concatenate([ring[_turns(ring) > SHARP_CORNER] for ring in body.rings])
            sides = body.sides[region.sides]
            step = sides[:, 1] - sides[:, 0]
            extent = float((np.hypot(*step.T) * np.diff(region.limits, axis=1)[:, 0]).sum())
            ends = sides[[0, -1], 0] + region.limits[[0, -1], [0, 1]][:, None] * step[[0, -1]]
            if np.hypot(*(ends[1] - ends[0])) > SAME_PLACE:  # not all round
                yield from ((end, extent) for end in ends if (np.hypot(*(convex - end).T) > SAME_PLACE).all())


def _turns(ring: Floats) -> Floats:
    """How far (n,) rad a ring (n, 2) turns to the left at its corners."""
    return kink_angles(np.concatenate([ring[-1:], ring, ring[:1]]))


def _forces(scene: Scene) -> Iterator[tuple[Floats, float]]:
    """Where forces act at points: as large as the rock."""
    for load in scene.case.loads:
        if isinstance(load, PointForce):
            yield scene.lattice.to_lattice(load.point), float(max(scene.lattice.shape))


def _rims(scene: Scene) -> Features:
    """Rims of holes, notches, narrow rock, parts of edges, along all of them."""
    for length in scene.lengths:
        if length.where is not None:
            where = shapely.transform(length.where, scene.lattice.to_lattice)
            yield where, _along(scene, length.metres / scene.lattice.spacing, length.kind, scene.grading.rest)


def _changes_of_status(scene: Scene, cracks: Sequence[CrackGeometry]) -> Features:
    """Places where faces part or slip ends, of cracks that have been refined: as small as at the tips."""
    for crack, x, y in scene.grading.changes:
        level = scene.grading.level(crack)
        if level > 0 and crack < len(cracks):
            size = _along(scene, line_length(cracks[crack].points), "tip", level)
            yield shapely.Point(scene.lattice.to_lattice(np.array([x, y]))), size


def _pressures(scene: Scene, cracks: Sequence[CrackGeometry]) -> Features:
    """Places on faces where a pressure of a fluid varies over less than the crack's length."""
    for number, crack in enumerate(cracks):
        for load in (load for load in scene.case.loads if isinstance(load, FluidPressure) and load.fills(crack.name)):
            line = shapely.LineString(crack.points)
            s = np.linspace(0.0, line.length, SAMPLES)
            places = shapely.get_coordinates(shapely.line_interpolate_point(line, s))
            pressure = component_at(load.pressure, scene.lattice.to_metres(places))
            change = np.abs(np.pad(np.diff(pressure), 1))
            change = np.maximum(change[:-1], change[1:])
            if not (varies := float(np.ptp(pressure))) > SAME_PLACE * np.abs(pressure).max():
                continue
            over = varies * s[1] / np.maximum(change, SAME_PLACE * varies)
            for place, length in zip(places[over < line.length / 2], over[over < line.length / 2], strict=True):
                yield shapely.Point(place), _along(scene, float(length), "load", scene.grading.level(number))
