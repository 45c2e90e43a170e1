"""Whether every crack lies inside one body, and meets its boundary and other cracks at points only, with no tip."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import LineString, Point, Polygon

from crackgrow.arrays import Floats, Ints
from crackgrow.case.checks import smallest
from crackgrow.case.layout import SMALLEST, Scene
from crackgrow.case.report import Faults, Path
from crackgrow.case.segments import (
    MOST_PAIRS,
    Segments,
    close_segments,
    common_parts,
    line_length,
    places_between,
    segments_of,
)
from crackgrow.case.shapes import BodyShape


def check_cracks(scene: Scene) -> Faults:
    """Report cracks that are too short, leave their body or run along its boundary, or meet others not as allowed."""
    names = [name for name, points in scene.cracks.items() if len(points) > 1]
    spacing = scene.get("numerics", "spacing") or 0.0
    for name, points in scene.cracks.items():
        length = line_length(points)
        if len(points) < 2:
            yield _path(name), "has no length: at least two different points are wanted"
        elif length < SMALLEST * spacing:
            yield _path(name), f"length {scene.length(length)} is less than {smallest(scene, spacing)}"
    segments = segments_of([scene.cracks[name] for name in names])
    pairs = close_segments(segments, scene.tolerance)
    if len(pairs) > MOST_PAIRS:
        yield ("cracks",), f"the cracks cross or touch more than {MOST_PAIRS} times"
        return
    lines = segments.lines[pairs]
    parts = common_parts(segments.ends[pairs[:, 0]], segments.ends[pairs[:, 1]], scene.tolerance)
    runs, of_one = ~np.isnan(parts[:, 0, 0]), lines[:, 0] == lines[:, 1]
    itself = np.flatnonzero(of_one & (runs | (pairs[:, 1] - pairs[:, 0] > 1)))
    found = {names[lines[k, 0]]: pairs[k] for k in itself[::-1].tolist()}  # of several the first one
    for name, pair in found.items():
        yield _path(name), _meets_itself(scene, segments, pair)
    grown = {name: body.polygon.buffer(scene.tolerance) for name, body in scene.bodies.items()}
    shapely.prepare([*grown.values()])
    inside, refused = set(), set()
    for name in [name for name in names if name in scene.hosts and name not in found]:
        body = scene.bodies[scene.hosts[name]]
        if problem := _problem(scene, scene.cracks[name], body, grown[body.name]):
            yield _path(name), problem
            continue
        inside.add(name)
        for end, point in zip(("start", "end"), scene.cracks[name][[0, -1]], strict=True):
            if end in scene.tips_of(name) and Point(point).dwithin(body.polygon.boundary, scene.tolerance):
                edge = _edge_at(scene, body, Point(point))
                remedy = "put it inside, or leave this end out of `tips`"
                yield _path(name), f"the tip at the {end} {scene.units.place(point)} lies on {edge}; {remedy}"
                refused.add((name, end))
    along = set()
    for k in np.flatnonzero(runs & ~of_one).tolist():
        one, other = (names[line] for line in lines[k])
        if {one, other} <= inside and (one, other) not in along:
            along.add((one, other))
            shown = " to ".join(scene.units.place(end) for end in parts[k])
            message = f"runs along crack '{one}' from {shown}; cracks may meet at points only: shorten one of them"
            yield _path(other), message
    yield from _tips(scene, [name for name in names if name in inside], along, refused)


def _path(name: str) -> Path:
    return "cracks", name, "path"


def _meets_itself(scene: Scene, segments: Segments, pair: Ints) -> str:
    """Say where two segments of a crack cross, touch or lie on each other."""
    first, second = pair.tolist()
    if second - first == 1:
        vertex = second - int(np.searchsorted(segments.lines, segments.lines[first]))
        where = scene.units.place(segments.ends[second, 0])
        return f"folds back on itself at vertex {vertex} {where}; end it there"
    where = scene.units.place(places_between(segments, pair[None])[0])
    return f"crosses or touches itself at {where}; give it as two cracks, which may meet there"


def _tips(scene: Scene, names: list[str], along: set[tuple[str, str]], refused: set[tuple[str, str]]) -> Faults:
    """Report tips that lie on another crack, unless they are refused already or the two run along each other."""
    lines = [LineString(scene.cracks[name]) for name in names]
    points = shapely.points(np.concatenate([np.empty((0, 2)), *(scene.cracks[name][[0, -1]] for name in names)]))
    ends, others = shapely.STRtree(lines).query(points, predicate="dwithin", distance=scene.tolerance)
    hosts: dict[str, dict[str, str]] = {}
    for end, host in sorted(zip(ends.tolist(), others.tolist(), strict=True)):
        if end // 2 != host:
            hosts.setdefault(names[end // 2], {}).setdefault(("start", "end")[end % 2], names[host])
    for name, found in hosts.items():
        tips = [end for end in scene.tips_of(name) if (name, end) not in refused]
        left = " ".join(end for end in tips if end not in found) or "none"
        for end, host in found.items():
            if end in tips and not {(name, host), (host, name)} & along:
                where = scene.units.place(scene.cracks[name][0 if end == "start" else -1])
                message = f"the tip at the {end} {where} lies on crack '{host}', where it cannot grow"
                yield _path(name), f"{message}; leave this end out of `tips`: `tips: {left}`"


def _problem(scene: Scene, points: Floats, body: BodyShape, grown: Polygon) -> str | None:
    """Say where a crack leaves its body, or touches the boundary not with an end, if it does.

    grown: the body, larger by the tolerance
    """
    vertices, line = shapely.points(points), LineString(points)
    on_edge = shapely.dwithin(vertices, body.polygon.boundary, scene.tolerance)
    outside = ~on_edge & ~shapely.contains(body.polygon, vertices)
    last = len(points) - 1
    for index in np.flatnonzero(on_edge | outside).tolist():
        where = f"{ {0: 'start', last: 'end'}.get(index, f'vertex {index}') } {scene.units.place(points[index])}"
        if outside[index]:
            return f"{where} {_outside(scene, body, vertices[index], index in (0, last))}"
        if 0 < index < last:
            return f"{where} lies on {_edge_at(scene, body, vertices[index])}; only an end may: give it as two cracks"
    found = _along(scene, points, body)
    if found is not None:
        middle = shapely.Point(found.mean(axis=0))
        shown = " to ".join(scene.units.place(end) for end in found)
        return f"runs along {_edge_at(scene, body, middle)} from {shown}; only an end may lie there"
    if not grown.covers(line):
        left = shapely.points(shapely.get_coordinates(line.difference(grown)))
        first = left[np.argmin(shapely.line_locate_point(line, left))]
        edge = _edge_at(scene, body, first)
        return f"leaves body '{body.name}' at {scene.units.place([first.x, first.y])}, through {edge}; end it there"
    near = body.side_tree.query(line, predicate="dwithin", distance=scene.tolerance)
    for at in body.corners[np.sort(near)]:
        if line.dwithin(Point(at), scene.tolerance) and np.hypot(*(points[[0, -1]] - at).T).min() > scene.tolerance:
            edge = _edge_at(scene, body, Point(at))
            return f"touches {edge} at {scene.units.place(at)}; only an end may: give it as two cracks"
    return None


def _along(scene: Scene, points: Floats, body: BodyShape) -> Floats | None:
    """Return ends `(2, 2) float` of the first part of a crack that runs along the boundary of its body."""
    segments = np.stack([points[:-1], points[1:]], axis=1)
    shapes = shapely.linestrings(segments)
    own, sides = body.side_tree.query(shapes, predicate="dwithin", distance=scene.tolerance)
    parts = common_parts(segments[own], body.sides[sides], scene.tolerance)
    found = np.flatnonzero(~np.isnan(parts[:, 0, 0]))
    return parts[found[np.argmin(own[found])]] if len(found) else None


def _outside(scene: Scene, body: BodyShape, point: Point, is_end: bool) -> str:
    """Say where a point lies that is not in the body, and where its boundary is."""
    other = next((other for other in scene.bodies.values() if other.polygon.dwithin(point, scene.tolerance)), None)
    if other is not None:
        split = "a crack lies in one body: give it as two that end on the interface"
        return f"lies in body '{other.name}' and most of the crack in body '{body.name}'; {split}"
    ring = _ring_at(body, point) if Polygon(body.polygon.exterior).contains(point) else ""
    where = f"lies in {ring} of body '{body.name}'" if ring else f"lies outside the outline of body '{body.name}'"
    nearest = shapely.get_coordinates(shapely.shortest_line(body.polygon.boundary, point))[0]
    distance = float(np.hypot(nearest[0] - point.x, nearest[1] - point.y))
    told = f"{where}, {scene.units.show(distance, 'length', 3)} from it at {scene.exact_point(nearest)}"
    return (
        f"{told}; an end within {scene.units.show(scene.reach, 'length', 2)} of it is moved there" if is_end else told
    )


def _edge_at(scene: Scene, body: BodyShape, point: Point) -> str:
    """Name what a point of the boundary lies on: an interface, the outline, or a hole."""
    for pair, lines in scene.shared.items():
        if body.name in pair and any(LineString(line).dwithin(point, scene.tolerance) for line in lines):
            return f"the interface between bodies '{pair[0]}' and '{pair[1]}'"
    return f"{_ring_at(body, point)} of body '{body.name}'"


def _ring_at(body: BodyShape, point: Point) -> str:
    """Name the ring nearest to a point: the outline, or a hole."""
    rings = [body.polygon.exterior, *body.polygon.interiors]
    nearest = int(np.argmin([ring.distance(point) for ring in rings]))
    return "the outline" if nearest == 0 else body.rings[nearest].edge_names[0]
