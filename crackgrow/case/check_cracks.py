"""Whether cracks lie inside their body and stay clear of themselves and each other."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import LineString, Point

from crackgrow.case.checks import SHORTEST, BodyShape, Scene
from crackgrow.case.model import Floats


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
    for body in scene.bodies.values():
        inside = [name for name in lines if _check_inside(scene, name, body)]
        for name in inside:
            if _meets_itself(scene.cracks[name], lines[name], body.tolerance):
                message = "the crack crosses or touches itself, which is not supported in this version"
                scene.report.fault(("cracks", name, "path"), message)
        _check_clear(scene, {name: lines[name] for name in inside}, body.tolerance)


def _check_clear(scene: Scene, lines: dict[str, LineString], tolerance: float) -> None:
    """Report every pair of cracks that meet, at the later one."""
    names, geometries = list(lines), np.array(list(lines.values()), dtype=object)
    pairs = shapely.STRtree(geometries).query(geometries, predicate="dwithin", distance=tolerance)
    for first, second in sorted(zip(*pairs.tolist(), strict=True)):
        if first < second:
            message = f"crosses or touches crack '{names[first]}', which is not supported in this version"
            scene.report.fault(("cracks", names[second], "path"), message)


def _check_inside(scene: Scene, name: str, body: BodyShape) -> bool:
    """Report the first place where a crack leaves its body; an end without a tip may lie on the outline."""
    points = scene.cracks[name]
    tips = scene.get("cracks", name, "tips")
    last = len(points) - 1
    has_tip = {0: tips in ("both", "start"), last: tips in ("both", "end")}
    named = {0: "start", last: "end"}
    boundary = body.polygon.exterior
    for index, point in enumerate(points):
        where = f"{named.get(index, f'vertex {index}')} {scene.point(point)}"
        outside = f"of body '{body.name}'"
        on_outline = Point(point).dwithin(boundary, body.tolerance)
        if not on_outline and not body.polygon.contains(Point(point)):
            return _refuse(scene, name, f"{where} lies outside the outline {outside}")
        if on_outline and has_tip.get(index, False):
            remedy = "put it inside, or leave this end out of `tips`"
            return _refuse(scene, name, f"the tip at the {where} lies on the outline {outside}; {remedy}")
        if on_outline and index not in has_tip:
            return _refuse(scene, name, f"{where} lies on the outline {outside}; only an end without a tip may")
    middles = (points[1:] + points[:-1]) / 2
    along = shapely.dwithin(shapely.points(middles), boundary, body.tolerance)
    if along.any() or not body.polygon.buffer(body.tolerance).covers(LineString(points)):
        return _refuse(scene, name, f"a segment leaves body '{body.name}' or runs along its outline")
    return True


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
