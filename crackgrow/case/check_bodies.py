"""Whether bodies that share a boundary say what holds between them, and loads name bodies and cracks."""

from __future__ import annotations

import numpy as np

from crackgrow.case.check_points import place_in_rock
from crackgrow.case.check_regions import knows_body
from crackgrow.case.check_supports import check_formula, sampled
from crackgrow.case.layout import Scene, named
from crackgrow.case.regions import ends_of
from crackgrow.case.report import Path, did_you_mean, quoted


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
    elif not scene.touch(first, second) and all(scene.report.sound("bodies", name, "shape") for name in pair):
        gap = scene.bodies[first].polygon.distance(scene.bodies[second].polygon)
        apart = f"they are {scene.length(gap)} apart" if gap > scene.tolerance else "they touch at points only"
        scene.report.fault(key, f"'{first}' and '{second}' share no boundary: {apart}")


def check_loads(scene: Scene) -> None:
    """Report loads on bodies and cracks that the case does not have, and formulas without a value where they act."""
    for kind in ("gravity", "stress"):
        for index, load in scene.items("loads", kind):
            knows_body(scene, ("loads", index, "body"), load["body"])
    cracks = list(named(scene.resolved, "cracks"))
    for index, load in scene.items("loads", "pressure"):
        if load["crack"] not in cracks:
            hint = f"{', '.join(cracks) or 'none'}{did_you_mean(load['crack'], cracks)}"
            message = f"no crack {quoted(load['crack'])}; the case has: {hint}"
            scene.report.fault(("loads", index, "crack"), message)
        elif load["crack"] in scene.cracks and len(scene.cracks[load["crack"]]) > 1:
            points = scene.cracks[load["crack"]]
            ends = np.stack([points[:-1], points[1:]], axis=1)
            check_formula(scene, ("loads", index, "pressure"), load["pressure"], sampled(ends))
    for index, load in scene.items("loads", "traction"):
        region = scene.regions.get(("loads", index, "on"))
        if region is not None:
            points = sampled(ends_of(scene.bodies[region.body], region))
            for axis, component in enumerate(load["traction"]):
                check_formula(scene, ("loads", index, "traction", axis), component, points)
    for index, load in scene.items("loads", "force") if scene.complete else ():
        place_in_rock(scene, ("loads", index, "at"), load["at"], load)
