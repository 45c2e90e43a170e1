"""Whether cracks lie inside their body and stay clear of themselves and each other."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import LineString, Point, Polygon

from crackgrow.case.checks import SHORTEST
from crackgrow.case.layout import Scene
from crackgrow.case.model import Floats
from crackgrow.case.shapes import BodyShape


def check_cracks(scene: Scene) -> None:
    """Report cracks that are too short, leave the body, or meet another crack or themselves."""
    lines: dict[str, LineString] = {}
    for name, points in scene.cracks.items():
        key = ("cracks", name, "path")
        if len(points) < 2:
            scene.report.fault(key, "has no length: at least two different points are wanted")
            continue
        lines[name] = LineString(points)
        spacing = scene.get("numerics", "spacing")
        if spacing is not None and lines[name].length < SHORTEST * spacing:
            limit = f"{SHORTEST:g} of the lattice spacing, {scene.length(SHORTEST * spacing)}"
            scene.report.fault(key, f"length {scene.length(lines[name].length)} is less than {limit}")
    grown = {name: body.polygon.buffer(scene.tolerance) for name, body in scene.bodies.items()}
    interfaces = [(pair, LineString(line)) for pair, lines in scene.shared.items() for line in lines]
    inside: dict[str, LineString] = {}
    for name, line in lines.items():
        reached = next((pair for pair, shared in interfaces if line.dwithin(shared, scene.tolerance)), None)
        if reached is not None:
            between = f"the one between '{reached[0]}' and '{reached[1]}'"
            message = f"cracks that reach an interface are not supported in this version; this one reaches {between}"
            scene.report.fault(("cracks", name, "path"), message)
        elif name in scene.hosts and _is_inside(scene, name, scene.bodies[scene.hosts[name]], grown[scene.hosts[name]]):
            inside[name] = line
            if _meets_itself(scene.cracks[name], line, scene.tolerance):
                message = "the crack crosses or touches itself, which is not supported in this version"
                scene.report.fault(("cracks", name, "path"), message)
    if inside:
        _check_clear(scene, inside, scene.tolerance)


def _check_clear(scene: Scene, lines: dict[str, LineString], tolerance: float) -> None:
    """Report every pair of cracks that meet, at the later one."""
    names, geometries = list(lines), np.array(list(lines.values()), dtype=object)
    pairs = shapely.STRtree(geometries).query(geometries, predicate="dwithin", distance=tolerance)
    for first, second in sorted(zip(*pairs.tolist(), strict=True)):
        if first < second:
            message = f"crosses or touches crack '{names[first]}', which is not supported in this version"
            scene.report.fault(("cracks", names[second], "path"), message)


def _is_inside(scene: Scene, name: str, body: BodyShape, grown: Polygon) -> bool:
    """Report the first place where a crack leaves its body; an end without a tip may lie on an edge of it.

    grown: the body, larger by the tolerance
    """
    points = scene.cracks[name]
    tips = scene.get("cracks", name, "tips")
    last = len(points) - 1
    has_tip = {0: tips in ("both", "start"), last: tips in ("both", "end")}
    named = {0: "start", last: "end"}
    boundary = body.polygon.boundary
    for index, point in enumerate(points):
        where = f"{named.get(index, f'vertex {index}')} {scene.point(point)}"
        on_edge = Point(point).dwithin(boundary, scene.tolerance)
        if not on_edge and not body.polygon.contains(Point(point)):
            return _refuse(scene, name, f"{where} lies {_outside(body, Point(point))}")
        if not on_edge:
            continue
        edge = f"{_ring_at(body, Point(point))} of body '{body.name}'"
        if has_tip.get(index, False):
            remedy = "put it inside, or leave this end out of `tips`"
            return _refuse(scene, name, f"the tip at the {where} lies on {edge}; {remedy}")
        if index not in has_tip:
            return _refuse(scene, name, f"{where} lies on {edge}; only an end without a tip may")
    middles = (points[1:] + points[:-1]) / 2
    along = shapely.dwithin(shapely.points(middles), boundary, scene.tolerance)
    if along.any() or not grown.covers(LineString(points)):
        edges = "outline" if len(body.rings) == 1 else "outline or a hole"
        return _refuse(scene, name, f"a segment leaves body '{body.name}' or runs along its {edges}")
    return True


def _outside(body: BodyShape, point: Point) -> str:
    """Say where a point lies that is not in the body."""
    if Polygon(body.polygon.exterior).contains(point):
        return f"in {_ring_at(body, point)} of body '{body.name}'"
    return f"outside the outline of body '{body.name}'"


def _ring_at(body: BodyShape, point: Point) -> str:
    """Name the ring nearest to a point: the outline, or a hole."""
    rings = [body.polygon.exterior, *body.polygon.interiors]
    nearest = int(np.argmin([ring.distance(point) for ring in rings]))
    return "the outline" if nearest == 0 else body.rings[nearest].edge_names[0]


def _refuse(scene: Scene, name: str, message: str) -> bool:
    scene.report.fault(("cracks", name, "path"), message)
    return False


def _meets_itself(points: Floats, line: LineString, tolerance: float) -> bool:
    """Whether two segments that are no neighbours come within the tolerance, or neighbours overlap."""
    if not line.is_simple:
        return True
    segments = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
    first, second = shapely.STRtree(segments).query(segments, predicate="dwithin", distance=tolerance)
    return bool(np.any(second - first > 1))
