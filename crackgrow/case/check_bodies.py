"""Whether bodies that share a boundary say what holds between them, and loads name bodies and cracks."""

from __future__ import annotations

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.check_points import place_in_rock
from crackgrow.case.check_regions import knows_body, knows_crack
from crackgrow.case.check_supports import check_formula, sampled
from crackgrow.case.layout import Scene
from crackgrow.case.regions import ends_of
from crackgrow.case.report import Path, quoted
from crackgrow.case.shapes import BodyShape, Resolved

SAMPLES_ACROSS = 17  # places across a body at which the formula of a stress must have a value


def check_interfaces(scene: Scene) -> None:
    """Report shared boundaries without an interface, and interfaces without a shared boundary."""
    seen: dict[frozenset[str], int] = {}
    all_clear = True
    listing = scene.resolved.get("interfaces")
    for index, interface in enumerate(listing if isinstance(listing, list) else []):
        key = ("interfaces", index, "between")
        if not isinstance(interface, dict) or not scene.report.sound(*key):
            all_clear = False
            continue
        pair = interface["between"]
        known = [knows_body(scene, (*key, k), name) for k, name in enumerate(pair)]
        if all(known):
            _check_pair(scene, key, pair, seen)
            seen.setdefault(frozenset(pair), index)
        else:
            all_clear = False
    if all_clear and isinstance(listing, list):  # else the missing one may be that which cannot be read
        for first, second in scene.shared:
            if frozenset((first, second)) not in seen:
                line = f"- {{between: [{first}, {second}], contact: {{friction: 0.5, cohesion: 0}}}}"
                message = f"bodies '{first}' and '{second}' share a boundary; say what holds there, such as {line}"
                scene.report.fault(("interfaces",), f"{message}, or with contact: bonded")


def _check_pair(scene: Scene, key: Path, pair: list[str], seen: dict[frozenset[str], int]) -> None:
    """Report a body that meets itself, a pair given before, and a pair without a shared boundary."""
    first, second = pair
    if first == second:
        scene.report.fault(key, f"{quoted(first)} is given twice; wanted: two bodies")
    elif frozenset(pair) in seen:
        number = seen[frozenset(pair)]
        scene.report.fault(key, f"'{first}' and '{second}' have an interface already, interfaces.{number}")
    elif not scene.lines_between(first, second) and all(scene.report.sound("bodies", name, "shape") for name in pair):
        gap = scene.bodies[first].polygon.distance(scene.bodies[second].polygon)
        apart = f"they are {scene.length(gap)} apart" if gap > scene.tolerance else "they touch at points only"
        scene.report.fault(key, f"'{first}' and '{second}' share no boundary: {apart}")


def check_loads(scene: Scene) -> None:
    """Report loads on bodies and cracks that the case does not have, and formulas without a value where they act."""
    for kind in ("gravity", "stress"):
        for index, load in scene.items("loads", kind):
            knows_body(scene, ("loads", index, "body"), load["body"])
            if kind == "stress" and load["body"] in scene.bodies:
                for axis, component in enumerate(load["stress"]):
                    places = _places_in(scene.bodies[load["body"]])
                    check_formula(scene, ("loads", index, "stress", axis), component, places)
    for index, load in scene.items("loads", "pressure"):
        if "on" in load:
            continue
        lines = _pressed_interface(scene, index, load) if "interface" in load else _pressed_crack(scene, index, load)
        for points in lines:
            ends = np.stack([points[:-1], points[1:]], axis=1)
            check_formula(scene, ("loads", index, "pressure"), load["pressure"], sampled(ends))
    for index, load in scene.listed("loads"):
        region = scene.regions.get(("loads", index, "on"))
        if region is not None and scene.report.sound("loads", index):
            points = sampled(ends_of(scene.bodies[region.body], region))
            kind = "far_field" if "far_field" in load else "traction"
            for axis, component in enumerate(load.get(kind, ())):
                check_formula(scene, ("loads", index, kind, axis), component, points)
            check_formula(scene, ("loads", index, "pressure"), load.get("pressure"), points)
    for index, load in scene.items("loads", "force") if scene.complete else ():
        place_in_rock(scene, ("loads", index, "at"), load["at"], load)


def _pressed_crack(scene: Scene, index: int, load: Resolved) -> list[Floats]:
    """The line (n, 2) m of the crack that a pressure acts in; reports one that there is not."""
    name = load["crack"]
    known = knows_crack(scene, ("loads", index, "crack"), name)
    return [scene.cracks[name]] if known and len(scene.cracks.get(name, ())) > 1 else []


def _pressed_interface(scene: Scene, index: int, load: Resolved) -> tuple[Floats, ...]:
    """The lines (n, 2) m of the interface that a pressure acts in; reports one that there is not, or that is bonded."""
    key, pair = ("loads", index, "interface"), load["interface"]
    known = [knows_body(scene, (*key, k), name) for k, name in enumerate(pair)]
    if not all(known) or not scene.report.sound("interfaces"):
        return ()
    meant = [item for _, item in scene.items("interfaces", "between") if set(item["between"]) == set(pair)]
    if not meant:
        scene.report.fault(key, f"'{pair[0]}' and '{pair[1]}' have no interface that a fluid could press apart")
    elif meant[0]["contact"] == "bonded":
        message = "is bonded: no fluid gets between faces that never part; give it a law of contact"
        scene.report.fault(key, f"the interface of '{pair[0]}' and '{pair[1]}' {message}")
    return scene.lines_between(pair[0], pair[1])


def _places_in(body: BodyShape) -> Floats:
    """Places (n, 2) m on the rim of a body and in it."""
    low, high = body.sides.reshape(-1, 2).min(axis=0), body.sides.reshape(-1, 2).max(axis=0)
    inside = low + (np.indices((SAMPLES_ACROSS, SAMPLES_ACROSS)).reshape(2, -1).T + 0.5) / SAMPLES_ACROSS * (high - low)
    return np.concatenate([sampled(body.sides), inside[shapely.contains_xy(body.polygon, *inside.T)]])
