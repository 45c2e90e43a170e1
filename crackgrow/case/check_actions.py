"""Whether supports stand on the bodies, agree and hold them; loads act on what there is, with values where they act."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.check_regions import knows, lines_of
from crackgrow.case.formula import CoordinateFormula
from crackgrow.case.layout import Scene
from crackgrow.case.model import EdgeRegion
from crackgrow.case.regions import SAME_PLACE, ends_of
from crackgrow.case.report import Faults, Path
from crackgrow.case.shapes import BodyShape, Resolved
from crackgrow.case.touching import sides_on

SAMPLES = np.linspace(0.0, 1.0, 65)  # places along a side at which a formula must have a value
ENDS = SAMPLES[[0, -1]]  # of a side, which hold as much as all of it
NOWHERE = np.empty((0, 2))  # no place
FREE_MOTION = 1e-8  # displacements of held components, scaled by the body's size, below which a motion is free

SAMPLES_ACROSS = 17  # places across a body at which the formula of a stress must have a value

ALIKE = 1e-6
"""Of the largest displacement of both supports: two that differ by less are one."""


def check_supports(scene: Scene) -> Faults:
    """Report supports given twice, formulas without value and rigid motions left free."""
    yield from _held_twice(scene)
    for index, support in scene.items("supports", "displacement"):
        key = ("supports", index, "displacement")
        yield from _without_value(scene, key, support["displacement"], _places(scene, index))
    settled = all(("supports", index, "on") in scene.regions for index, _ in scene.items("supports", "on"))
    if not (scene.complete and scene.report.sound("supports") and settled):
        return
    foundations = [item["on"]["body"] for _, item in scene.items("supports", "contact")]
    for body in scene.bodies.values():  # where others or a foundation hold it too, only the solution tells how
        if body.name not in foundations and not any(body.name in pair for pair in scene.shared):
            yield from _free_motions(scene, body)


def _held_twice(scene: Scene) -> Faults:
    """Report a component that is held twice at a point."""
    seen: list[tuple[int, str, Floats, set[str]]] = []
    for index, support in scene.listed("supports"):
        key = ("supports", index, "at")
        if key not in scene.holders:
            continue
        body, point, components = scene.holders[key], scene.places[key], set(support["displacement"])
        for other, its_body, at, held in seen:
            twice = sorted(held & components)
            if twice and its_body == body and math.dist(point, at) <= scene.tolerance:
                message = (
                    f"{' and '.join(twice)} at {scene.units.place(point)} is prescribed already by supports.{other}"
                )
                yield ("supports", index, "displacement"), message
                break
        seen.append((index, body, point, components))


def _without_value(scene: Scene, key: Path, value: Any, points: Floats) -> Faults:
    """Report a formula, or those of several components, without a finite value at one of some points (n, 2) m."""
    parts = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for part, component in parts:
        yield from _without_value(scene, (*key, part), component, points)
    if isinstance(value, CoordinateFormula):
        _, nowhere = value.values(points)
        if nowhere is not None:
            yield key, f"has no finite value at {scene.units.place(nowhere)}"


def sampled(ends: Floats, parts: Floats = SAMPLES) -> Floats:
    """Places (n, 2) m along lines (k, 2, 2) m, at parts of each; if none are given, many with both ends."""
    return np.asarray(ends[:, :1] + parts[:, None] * (ends[:, 1:] - ends[:, :1])).reshape(-1, 2)


def _free_motions(scene: Scene, body: BodyShape) -> Faults:
    """Report the rigid motions that the supports leave free.

    A motion (a, b, w) displaces x by a - w (y - c_y) / R and y by b + w (x - c_x) / R, about the body's centre c, with
    R half its size. Rows are the displacements of held components.
    """
    held, R = [np.zeros(3)], body.size / 2
    for index, support in scene.items("supports", "displacement"):
        name = scene.holders["supports", index, "at"] if "at" in support else support["on"]["body"]
        for dx, dy in (_places(scene, index, ENDS) - body.center) / R if name == body.name else ():
            rows = {"x": np.array([1.0, 0.0, -dy]), "y": np.array([0.0, 1.0, dx])}
            held += [rows[component] for component in support["displacement"]]
    A = np.array(held)
    free = [f"translation in {axis}" for column, axis in enumerate("xy") if not A[:, column].any()]
    a, b = np.linalg.lstsq(A[:, :2], -A[:, 2], rcond=None)[0]  # of the turn by w = 1 that comes nearest to free
    if np.abs(A @ [a, b, 1.0]).max() <= FREE_MOTION:
        about = body.center + R * np.array([-b, a])
        free.append(f"rotation about {scene.units.place(np.where(np.abs(about) < FREE_MOTION * R, 0.0, about))}")
    if free:
        yield ("supports",), f"body '{body.name}' is free to move: {' and '.join(free)}; it needs supports against that"


def _places(scene: Scene, index: int, parts: Floats = SAMPLES) -> Floats:
    """The point of a support, or places along the part of an edge that it holds, (n, 2) m; none if they are unknown."""
    support = scene.resolved["supports"][index]
    if "at" in support:
        return np.array([support["at"]])
    region = scene.regions.get(("supports", index, "on"))
    return NOWHERE if region is None else sampled(ends_of(scene.bodies[region.body], region), parts)


def check_foundations(scene: Scene) -> Faults:
    """Report foundations under a boundary that two bodies share, and two foundations in one place."""
    seen: list[tuple[int, EdgeRegion]] = []
    for index, _ in scene.items("supports", "contact"):
        key = ("supports", index, "on")
        region = scene.regions.get(key)
        if region is None:
            continue
        for pair, lines in scene.shared.items():
            if region.body in pair and np.isin(region.sides, sides_on(scene.bodies[region.body], lines)).any():
                other = pair[1 - pair.index(region.body)]
                yield key, f"a rigid foundation cannot lie where body '{region.body}' touches body '{other}'"
        for earlier, its_region in seen:
            if len(_shared(scene, region, its_region)):
                yield key, f"lies partly on the foundation of supports.{earlier}"
        seen.append((index, region))


def check_agreement(scene: Scene) -> Faults:
    """Report components of a displacement that another support prescribes otherwise at a place of both.

    Edges that meet at a corner have no part in common: what a corner alone would have to do two ways, no edge is held
    to. Points on a held edge are warned of (`run.scene_warnings`).
    """
    held = [
        (index, scene.regions.get(("supports", index, "on"))) for index, _ in scene.items("supports", "displacement")
    ]
    edges = [(index, region) for index, region in held if region is not None]
    for number, (index, mine) in enumerate(edges):
        for other, its in edges[:number]:
            places = _shared(scene, mine, its)
            if len(places):
                yield from _otherwise(scene, index, other, places)


def _otherwise(scene: Scene, index: int, other: int, places: Floats) -> Faults:
    """Report the components that differ at one of the places (n, 2) m of two supports."""
    both = {each: scene.resolved["supports"][each]["displacement"] for each in (index, other)}
    for component in [name for name in both[index] if name in both[other]]:
        here, there = (_values(each[component], places) for each in both.values())
        own = [_values(each[component], _places(scene, which)) for which, each in both.items()]
        with np.errstate(invalid="ignore"):  # of formulas without a value, which is told elsewhere
            apart, largest = np.abs(here - there), np.abs(np.concatenate(own)).max()
        if np.isfinite(apart).all() and np.any(apart > ALIKE * largest):
            worst = int(np.argmax(apart))
            message = (
                f"{component} at {scene.units.place(places[worst])} is {scene.length(float(here[worst]))} here and "
                f"{scene.length(float(there[worst]))} by supports.{other}; a place can be held in one way alone"
            )
            yield ("supports", index, "displacement", component), message


def _values(value: float | CoordinateFormula, places: Floats) -> Floats:
    """Displacements (n,) m at places (n, 2) m, finite or not."""
    return value.values(places)[0] if isinstance(value, CoordinateFormula) else np.full(len(places), value)


def _shared(scene: Scene, first: EdgeRegion, second: EdgeRegion) -> Floats:
    """Places (n, 2) m along the parts of sides that two regions have in common."""
    mine, its = np.nonzero((first.sides[:, None] == second.sides) & (first.body == second.body))
    low = np.maximum(first.limits[mine, 0], second.limits[its, 0])
    high = np.minimum(first.limits[mine, 1], second.limits[its, 1])
    kept = high - low > SAME_PLACE
    region = EdgeRegion(first.body, first.edge, first.sides[mine[kept]], np.stack([low, high], axis=1)[kept])
    return sampled(ends_of(scene.bodies[first.body], region))


def check_loads(scene: Scene) -> Faults:
    """Report loads on what the case does not have, or without a value where they act."""
    bonded = [set(its["between"]) for _, its in scene.items("interfaces", "between") if its["contact"] == "bonded"]
    for index, load in scene.listed("loads"):
        key: Path = ("loads", index)
        if not scene.report.sound(*key):
            continue
        places = _loaded_places(scene, key, load)
        if set(load.get("interface", ())) in bonded:
            why = "no fluid gets between faces that never part; give it a law of contact"
            yield (*key, "interface"), f"the interface of {' and '.join(load['interface'])} is bonded: {why}"
        fluids = [its for n, its in scene.listed("loads") if n <= index and its.get("crack") == load.get("crack", "")]
        if len(fluids) > 1 and any("volume" in its for its in fluids):
            why = "the volume of a fluid gives its pressure, so it is the only fluid there"
            yield (*key, "crack"), f"crack '{load['crack']}' has a fluid already; {why}"
        for kind in load.keys() & {"traction", "far_field", "pressure", "stress"}:  # it has one of them
            yield from _without_value(scene, (*key, kind), load[kind], places)


def _loaded_places(scene: Scene, key: Path, load: Resolved) -> Floats:
    """Places (n, 2) m where a load may vary, none where they are not known; reports what it cannot act on."""
    if region := scene.regions.get((*key, "on")):
        return sampled(ends_of(scene.bodies[region.body], region))
    if "gravity" in load or "stress" in load:
        body = scene.bodies.get(load["body"]) if knows(scene, (*key, "body"), "body", load["body"]) else None
        if body is None or "stress" not in load:
            return NOWHERE
        low, high = body.corners.min(axis=0), body.corners.max(axis=0)
        inside = np.indices((SAMPLES_ACROSS, SAMPLES_ACROSS)).reshape(2, -1).T
        inside = low + (inside + 0.5) / SAMPLES_ACROSS * (high - low)
        return np.concatenate([sampled(body.sides), inside[shapely.contains_xy(body.polygon, *inside.T)]])
    lines = lines_of(scene, key, load) if "crack" in load or "interface" in load else ()
    ends = [np.stack([points[:-1], points[1:]], axis=1) for points in lines]
    return sampled(np.concatenate([np.empty((0, 2, 2)), *ends]))
