"""Whether supports stand on the bodies, agree and hold them; foundations lie where no other contact does."""

from __future__ import annotations

import math

import numpy as np
import shapely
from shapely import LineString, Point

from crackgrow.arrays import Floats
from crackgrow.case.check_regions import knows_body
from crackgrow.case.formula import CoordinateFormula, component_of
from crackgrow.case.layout import Scene
from crackgrow.case.model import EdgeRegion
from crackgrow.case.regions import SAME_PLACE, ends_of
from crackgrow.case.report import Path
from crackgrow.case.shapes import BodyShape, Resolved

SAMPLES = np.linspace(0.0, 1.0, 65)  # places along a side at which a formula must have a value
ENDS = SAMPLES[[0, -1]]  # of a side, which hold as much as all of it
FREE_MOTION = 1e-8  # singular values below this, of constraints scaled by the body's size, hold nothing

ALIKE = 1e-6
"""Of the largest displacement of both supports: two that differ by less are one."""


def check_supports(scene: Scene) -> None:
    """Report supports off the bodies, supports given twice, formulas without value and rigid motions left free.

    Every support at a point gets the body that it holds.
    """
    _check_points(scene)
    _check_formulas(scene)
    settled = all(("supports", index, "on") in scene.regions for index, _ in scene.items("supports", "on"))
    if scene.complete and scene.report.sound("supports") and settled:
        for body in scene.bodies.values():
            if not _is_in_contact(scene, body):
                _check_held(scene, body)


def _check_points(scene: Scene) -> None:
    """Report support points off the bodies or on a crack, and a component held twice at a point."""
    seen: list[tuple[int, str, Floats, set[str]]] = []
    for index, support in scene.items("supports", "at"):
        point, components = np.array(support["at"]), set(support["displacement"])
        where, key = scene.point(point), ("supports", index)
        body = _body_at(scene, key, support, point)
        for name, line in scene.cracks.items():
            if len(line) > 1 and LineString(line).dwithin(Point(point), scene.tolerance):
                message = f"{where} lies on crack '{name}', where the displacement has two values"
                scene.report.fault((*key, "at"), message)
        if body is None:
            continue
        support["body"] = body
        for other, its_body, at, held in seen:
            twice = sorted(held & components)
            if twice and its_body == body and math.dist(point, at) <= scene.tolerance:
                message = f"{' and '.join(twice)} at {where} is prescribed already by supports.{other}"
                scene.report.fault((*key, "displacement"), message)
                break
        seen.append((index, body, point, components))


def _body_at(scene: Scene, key: Path, support: Resolved, point: Floats) -> str | None:
    """Return the body that a support holds, None if that cannot be told; report why."""
    where = scene.point(point)
    at = [name for name, body in scene.bodies.items() if body.polygon.dwithin(Point(point), scene.tolerance)]
    if "body" in support:
        name = str(support["body"])
        if not knows_body(scene, (*key, "body"), name) or name not in scene.bodies:
            return None
        if name not in at:
            scene.report.fault((*key, "at"), f"{where} is neither in nor on body '{name}'")
            return None
        return name
    if not scene.complete:
        return None
    if not at:
        names = list(scene.bodies)
        off = f"body '{names[0]}'" if len(names) == 1 else f"any body: {', '.join(names)}"
        scene.report.fault((*key, "at"), f"{where} is neither in nor on {off}")
    elif len(at) > 1:
        message = f"{where} lies on bodies {', '.join(at)}; say which one is held, such as body: {at[0]}"
        scene.report.fault((*key, "at"), message)
    return at[0] if len(at) == 1 else None


def _check_formulas(scene: Scene) -> None:
    """Report displacements that have no finite value at the point, or at places along the sides of the region."""
    for index, support in scene.items("supports", "displacement"):
        places = _places(scene, index)
        for component, value in support["displacement"].items():
            if places is not None:
                check_formula(scene, ("supports", index, "displacement", component), value, places)


def check_formula(scene: Scene, key: Path, value: object, points: Floats) -> None:
    """Report a formula that has no finite value at one of some points (n, 2) m."""
    formula = component_of(value) if isinstance(value, str) else None
    if isinstance(formula, CoordinateFormula):
        _, nowhere = formula.values(points)
        if nowhere is not None:
            scene.report.fault(key, f"has no finite value at {scene.point(nowhere)}")


def sampled(ends: Floats, parts: Floats = SAMPLES) -> Floats:
    """Places (n, 2) m along lines (k, 2, 2) m, at parts of each; if none are given, many with both ends."""
    return np.asarray(ends[:, :1] + parts[:, None] * (ends[:, 1:] - ends[:, :1])).reshape(-1, 2)


def _is_in_contact(scene: Scene, body: BodyShape) -> bool:
    """Whether other bodies or a foundation hold the body too; only the solution tells how."""
    foundations = [item["on"]["body"] for _, item in scene.items("supports", "contact")]
    return body.name in foundations or any(body.name in pair for pair in scene.shared)


def _check_held(scene: Scene, body: BodyShape) -> None:
    """Report the rigid motions that the supports leave free."""
    motions = free_motions(body, _held_points(scene, body))
    if motions.size:
        scale = body.size / 2
        free = " and ".join(_describe(scene, motion, body.center, scale) for motion in motions)
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
        dx, dy = (point - body.center) / (body.size / 2)
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
    held = []
    for index, support in scene.items("supports", "displacement"):
        name = support["body"] if "at" in support else support["on"]["body"]
        places = _places(scene, index, ENDS) if name == body.name else None
        if places is not None:
            held += [(place, "xy".index(component)) for component in support["displacement"] for place in places]
    return held


def _places(scene: Scene, index: int, parts: Floats = SAMPLES) -> Floats | None:
    """The point of a support, or places along the part of an edge that it holds, (n, 2) m; None if they are unknown."""
    support = scene.resolved["supports"][index]
    if "at" in support:
        return np.array([support["at"]])
    region = scene.regions.get(("supports", index, "on"))
    return None if region is None else sampled(ends_of(scene.bodies[region.body], region), parts)


def _describe(scene: Scene, motion: Floats, center: Floats, scale: float) -> str:
    """Say which rigid motion this is."""
    a, b, w = (float(part) for part in np.where(np.abs(motion) < FREE_MOTION, 0.0, motion))
    if w:
        x, y = center + np.array([-b, a]) / w * scale
        return f"rotation about {scene.point(np.where(np.abs([x, y]) < FREE_MOTION * scale, 0.0, [x, y]))}"
    return f"translation in {'x' if a else 'y'}"  # never oblique: supports hold x or y


def check_foundations(scene: Scene) -> None:
    """Report foundations under a boundary that two bodies share, and two foundations in one place."""
    seen: list[tuple[int, EdgeRegion]] = []
    for index, _ in scene.items("supports", "contact"):
        key = ("supports", index, "on")
        region = scene.regions.get(key)
        if region is None:
            continue
        for pair in scene.shared:
            if region.body in pair and _lies_on(scene, region, pair):
                other = pair[1 - pair.index(region.body)]
                message = f"a rigid foundation cannot lie where body '{region.body}' touches body '{other}'"
                scene.report.fault(key, message)
        for earlier, its_region in seen:
            if len(_shared(scene, region, its_region)):
                scene.report.fault(key, f"lies partly on the foundation of supports.{earlier}")
        seen.append((index, region))


def _lies_on(scene: Scene, region: EdgeRegion, pair: tuple[str, str]) -> bool:
    """Whether a part of positive length of a region lies on the boundary shared by two bodies."""
    sides = shapely.linestrings(ends_of(scene.bodies[region.body], region))
    shared = shapely.multilinestrings([shapely.linestrings(line) for line in scene.shared[pair]])
    near = shared.buffer(2 * scene.tolerance)
    # A line that only touches the shared one runs inside of the buffer for a few tolerances.
    return bool(np.any(shapely.length(shapely.intersection(sides, near)) > 100 * scene.tolerance))


def check_agreement(scene: Scene) -> None:
    """Report components of a displacement that another support prescribes otherwise at a place of both.

    Edges that meet at a corner have no part in common: what a corner alone would have to do two ways, no edge is held
    to. Points on a held edge are warned of (`run.scene_warnings`).
    """
    earlier: list[int] = []
    for index, _ in scene.items("supports", "displacement"):
        for other in earlier:
            mine, its = (scene.regions.get(("supports", each, "on")) for each in (index, other))
            places = np.empty((0, 2)) if mine is None or its is None else _shared(scene, mine, its)
            if len(places):
                _compare(scene, index, other, places)
        earlier.append(index)


def _compare(scene: Scene, index: int, other: int, places: Floats) -> None:
    """Report the components that differ at one of the places (n, 2) m of two supports."""
    displacement, its = (scene.resolved["supports"][each]["displacement"] for each in (index, other))
    for component in [name for name in displacement if name in its]:
        here, there = (_values(each[component], places) for each in (displacement, its))
        of_mine = _values(displacement[component], _places(scene, index))
        of_other = _values(its[component], _places(scene, other))
        if here is None or there is None or of_mine is None or of_other is None:
            continue
        apart, largest = np.abs(here - there), float(np.abs(np.concatenate([of_mine, of_other])).max())
        if np.any(apart > ALIKE * largest):
            worst = int(np.argmax(apart))
            message = (
                f"{component} at {scene.point(places[worst])} is {scene.length(float(here[worst]))} here and "
                f"{scene.length(float(there[worst]))} by supports.{other}; a place can be held in one way alone"
            )
            scene.report.fault(("supports", index, "displacement", component), message)


def _values(value: float | str, places: Floats | None) -> Floats | None:
    """Displacements (n,) m at places (n, 2) m; None where these or the values of a formula are not known."""
    if places is None:
        return None
    formula = component_of(value)
    if not isinstance(formula, CoordinateFormula):
        return np.full(len(places), value)
    values, nowhere = formula.values(places)
    return values if nowhere is None else None


def _shared(scene: Scene, first: EdgeRegion, second: EdgeRegion) -> Floats:
    """Places (n, 2) m along the parts of sides that two regions have in common."""
    if first.body != second.body:
        return np.empty((0, 2))
    sides, found = scene.bodies[first.body].sides, []
    for side, limits in zip(first.sides.tolist(), first.limits, strict=True):
        for its_side, its_limits in zip(second.sides.tolist(), second.limits, strict=True):
            low, high = max(limits[0], its_limits[0]), min(limits[1], its_limits[1])
            if side == its_side and high - low > SAME_PLACE:
                start, end = sides[side]
                found.append([start + share * (end - start) for share in (low, high)])
    return sampled(np.array(found)) if found else np.empty((0, 2))
