"""Whether supports and loads stand on the body, and whether the supports hold it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from shapely import LineString, Point

from crackgrow.case.checks import BodyShape, Scene, named
from crackgrow.case.model import Floats
from crackgrow.case.report import Path, did_you_mean, quoted

FREE_MOTION = 1e-8  # singular values below this, of constraints scaled by the body's size, hold nothing


def check_supports(scene: Scene) -> None:
    """Report supports and loads off the body, supports given twice, and rigid motions left free."""
    for key in ("supports", "loads"):
        items = scene.resolved.get(key)
        for index, item in enumerate(items if isinstance(items, list) else []):
            if "on" in (item if isinstance(item, dict) else {}) and scene.report.sound(key, index, "on"):
                _check_region(scene, (key, index, "on"), item["on"])
    if not scene.report.sound("supports") or len(named(scene.resolved, "bodies")) != 1:
        return
    for body in scene.bodies.values():
        _check_points(scene, body)
        if scene.report.sound("supports"):
            _check_held(scene, body)


def _check_region(scene: Scene, key: Path, on: dict[str, Any]) -> None:
    """Report an unknown body or edge and a part that is none of the edge's."""
    report = scene.report
    names = list(named(scene.resolved, "bodies"))
    if names and on["body"] not in names:
        message = f"no body {quoted(on['body'])}; the case has: {', '.join(names)}{did_you_mean(on['body'], names)}"
        report.fault((*key, "body"), message)
    body = scene.bodies.get(on["body"])
    if body is None:
        return
    if on["edge"] not in body.edge_names:
        allowed = f"{', '.join(body.edge_names)}{did_you_mean(on['edge'], body.edge_names)}"
        report.fault((*key, "edge"), f"body '{body.name}' has no edge {quoted(on['edge'])}; it has: {allowed}")
        return
    ends, axis = _edge_ends(body, on["edge"])
    low, high = sorted(ends[:, axis])
    for end in ("from", "to"):
        if end in on and not low - body.tolerance <= on[end] <= high + body.tolerance:
            reach = f"{'xy'[axis]} from {scene.length(low)} to {scene.length(high)}"
            report.fault((*key, end), f"{scene.length(on[end])} is not on edge '{on['edge']}', which has {reach}")
    start, end_at = on.get("from", low), on.get("to", high)
    if report.sound(*key) and end_at - start <= body.tolerance:
        end = "from" if "from" in on else "to"
        part = f"the part from {scene.length(start)} to {scene.length(end_at)}"
        report.fault((*key, end), f"{part} has no length; `from` must be less than `to`")


def _edge_ends(body: BodyShape, edge: str) -> tuple[Floats, int]:
    """Return the two corners `(2, 2) float` of an edge and the coordinate that varies along it (0: x, 1: y)."""
    first = body.edge_names.index(edge)
    ends = body.outline[[first, (first + 1) % len(body.outline)]]
    return ends, int(np.argmax(np.ptp(ends, axis=0)))


def _check_points(scene: Scene, body: BodyShape) -> None:
    """Report support points off the body or on a crack, and a component held twice at a point."""
    seen: list[tuple[int, Floats, set[str]]] = []
    for index, support in enumerate(scene.resolved["supports"]):
        if "at" not in support:
            continue
        point, components = np.array(support["at"]), set(support["displacement"])
        where = scene.point(point)
        if body.polygon.distance(Point(point)) > body.tolerance:
            scene.report.fault(("supports", index, "at"), f"{where} is neither in nor on body '{body.name}'")
        for name, line in scene.cracks.items():
            if len(line) > 1 and LineString(line).dwithin(Point(point), body.tolerance):
                message = f"{where} lies on crack '{name}', where the displacement has two values"
                scene.report.fault(("supports", index, "at"), message)
        for other, at, held in seen:
            twice = sorted(held & components)
            if twice and np.hypot(*(point - at)) <= body.tolerance:
                message = f"{' and '.join(twice)} at {where} is prescribed already by supports.{other}"
                scene.report.fault(("supports", index, "displacement"), message)
        seen.append((index, point, components))


def _check_held(scene: Scene, body: BodyShape) -> None:
    """Report the rigid motions that the supports leave free."""
    motions = free_motions(body, _held_points(scene, body))
    if motions.size:
        scale = body.size / 2
        free = " and ".join(_describe(scene, motion, _center(body), scale) for motion in motions)
        message = f"body '{body.name}' is free to move: {free}; it needs supports against that"
        scene.report.fault(("supports",), message)


def free_motions(body: BodyShape, held: list[tuple[Floats, int]]) -> Floats:
    """Return the rigid motions, `(n, 3) float`, that displace no held component.

    body: the body, whose centre is c and half size R
    held: points and the component held there (0: x, 1: y)

    A motion (a, b, w) displaces x by a - w (y - c_y) / R and y by b + w (x - c_x) / R. The first ones are pure
    translations, the last one rotates if any does.
    """
    if not held:
        return np.eye(3)
    rows = []
    for point, component in held:
        dx, dy = (point - _center(body)) / (body.size / 2)
        rows.append((1.0, 0.0, -dy) if component == 0 else (0.0, 1.0, dx))
    free = _null_space(np.array(rows))
    # Combine the basis so that only one motion turns: split off the null space of the rotation component.
    if len(free) < 2:
        return free
    translations = _null_space(free[:, 2][None, :]) @ free
    turning = free - (free @ translations.T) @ translations
    turning = turning[[np.argmax(np.abs(turning[:, 2]))]]
    return np.vstack([translations, turning]) if len(translations) < len(free) else translations


def _null_space(A: Floats) -> Floats:
    """Return an orthonormal basis, as rows, of the vectors that A maps to zero."""
    n = A.shape[1]
    _, singular, Vt = np.linalg.svd(np.vstack([A, np.zeros((n, n))]), full_matrices=False)
    rank = int(np.sum(singular > FREE_MOTION * max(1.0, float(singular.max()))))
    return np.asarray(Vt[rank:], dtype=float)


def _held_points(scene: Scene, body: BodyShape) -> list[tuple[Floats, int]]:
    return [
        (point, "xy".index(component))
        for support in scene.resolved["supports"]
        for component in support["displacement"]
        for point in _support_points(support, body)
    ]


def _support_points(support: dict[str, Any], body: BodyShape) -> Iterator[Floats]:
    """Yield the point of a support, or both ends of its part of an edge: they hold as much as the whole part."""
    if "at" in support:
        yield np.array(support["at"])
    elif support["on"]["body"] == body.name:
        ends, axis = _edge_ends(body, support["on"]["edge"])
        low, high = ends[np.argsort(ends[:, axis])]
        span = high[axis] - low[axis]
        for key, default in (("from", low[axis]), ("to", high[axis])):
            yield low + (support["on"].get(key, default) - low[axis]) / span * (high - low)


def _center(body: BodyShape) -> Floats:
    return np.asarray((body.outline.min(axis=0) + body.outline.max(axis=0)) / 2, dtype=float)


def _describe(scene: Scene, motion: Floats, center: Floats, scale: float) -> str:
    """Say which rigid motion this is."""
    a, b, w = (float(part) for part in np.where(np.abs(motion) < FREE_MOTION, 0.0, motion))
    if w:
        x, y = center + np.array([-b, a]) / w * scale
        return f"rotation about {scene.point(np.where(np.abs([x, y]) < FREE_MOTION * scale, 0.0, [x, y]))}"
    return f"translation in {'x' if a else 'y'}"  # never oblique: supports hold x or y
