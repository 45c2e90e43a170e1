"""Whether `on` of supports and loads names an edge, or a part of one; fills the regions of the scene."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from crackgrow.case.layout import Scene, named
from crackgrow.case.regions import FULL_CIRCLE, SAME_PLACE, Along, Edge, edge_of, region_of
from crackgrow.case.report import Path, did_you_mean, quoted
from crackgrow.case.shapes import edge_hint


def check_regions(scene: Scene) -> None:
    """Report unknown bodies and edges and parts that are none; bring `from` and `to` to m, or degrees on arcs."""
    for key in ("supports", "loads"):
        for index, item in scene.listed(key):
            if "on" in item and scene.report.sound(key, index, "on"):
                _check_region(scene, (key, index, "on"), item["on"])


def settle_bodies(scene: Scene) -> None:
    """Name the only body where supports and loads name none; report where there are several."""
    for kind in ("supports", "loads"):
        for index, item in scene.listed(kind):
            if "on" in item and scene.report.sound(kind, index, "on"):
                item["on"] = _of_body(scene, (kind, index, "on"), item["on"])
            elif ("gravity" in item or "stress" in item) and scene.report.sound(kind, index):
                scene.resolved[kind][index] = _of_body(scene, (kind, index), item)


def _of_body(scene: Scene, key: Path, item: dict[str, Any]) -> dict[str, Any]:
    names = list(named(scene.resolved, "bodies"))
    if "body" in item:
        return item
    if len(names) == 1:
        return {"body": names[0], **item}
    if names:
        which = "the case has several, so say which one"
        scene.report.fault((*key, "body"), f"missing: name of a body; {which}: {', '.join(names)}")
    else:
        scene.report.doubt((*key, "body"))  # that there is none is told elsewhere
    return item


def knows_body(scene: Scene, key: Path, name: str) -> bool:
    """Whether there is a body of this name; reports it at the key if not, but for a case without bodies."""
    names = list(named(scene.resolved, "bodies"))
    return _knows(scene, key, f"body {quoted(name)}", name, names) if names else False


def knows_crack(scene: Scene, key: Path, name: str) -> bool:
    """Whether there is a crack of this name; reports it at the key if not."""
    return _knows(scene, key, f"crack {quoted(name)}", name, list(named(scene.resolved, "cracks")))


def _knows(scene: Scene, key: Path, what: str, name: str, names: list[str]) -> bool:
    if name not in names:
        message = f"no {what}; the case has: {', '.join(names) or 'none'}{did_you_mean(name, names)}"
        scene.report.fault(key, message)
    return name in names


def _check_region(scene: Scene, key: Path, on: dict[str, Any]) -> None:
    if not knows_body(scene, (*key, "body"), on["body"]):
        return
    body = scene.bodies.get(on["body"])
    if body is None or not scene.report.sound("bodies", body.name, "edges"):
        return
    if on["edge"] not in body.edge_names:
        allowed = edge_hint(on["edge"], body.edge_names)
        message = f"body '{body.name}' has no edge {quoted(on['edge'])}; it has: {allowed}"
        scene.report.fault((*key, "edge"), message)
        return
    edge = edge_of(body, on["edge"], scene.tolerance)
    for end in ("from", "to"):
        if end in on:
            _settle(scene, (*key, end), on, end, edge)
    if scene.report.sound(*key):
        _check_part(scene, key, on, edge)
    if scene.report.sound(*key):
        scene.regions[key] = region_of(body, on, scene.tolerance)


def _settle(scene: Scene, key: Path, on: dict[str, Any], end: str, edge: Edge) -> None:
    """Bring `from` or `to` to what the edge measures; report the other kind, and places off the edge."""
    place: Along = on[end]
    kind, other = ("angle", "length") if edge.measure == "angle" else ("length", "angle")
    value = place.angle if edge.measure == "angle" else place.length
    if value is None:
        scene.report.fault(key, f"a place on edge '{on['edge']}' is given by {_an(kind)}, not by {_an(other)}")
        return
    if edge.measure in ("x", "y"):
        value = scene.units.along(repr(value), Fraction(1), "xy".index(edge.measure))
    on[end] = value
    low, high = edge.reach
    if edge.measure == "angle":
        if not -FULL_CIRCLE <= value <= 2 * FULL_CIRCLE:
            message = f"{value:g} deg is out of range; wanted: an angle from {-FULL_CIRCLE:g} to {2 * FULL_CIRCLE:g}"
            scene.report.fault(key, message)
    elif not low - scene.tolerance <= value <= high + scene.tolerance:
        shown, first, last = (_shown(scene, edge, place) for place in (value, low, high))
        reach = f"{edge.measure} from {first} to {last}"
        scene.report.fault(key, f"{shown} is not on edge '{on['edge']}', which has {reach}")


def _shown(scene: Scene, edge: Edge, place: float) -> str:
    """Write a place on an edge."""
    if edge.measure == "angle":
        return f"{place:g} deg"
    return (
        scene.length(place) if edge.measure == "distance" else scene.units.coordinate(place, "xy".index(edge.measure))
    )


def _check_part(scene: Scene, key: Path, on: dict[str, Any], edge: Edge) -> None:
    """Report a part without length, or of more than the whole arc."""
    start, end = on.get("from", edge.reach[0]), on.get("to", edge.reach[1])
    at = (*key, "from" if "from" in on else "to")
    is_arc = edge.measure == "angle"
    shown = " to ".join(_shown(scene, edge, value) for value in (start, end))
    least = FULL_CIRCLE * SAME_PLACE if is_arc else scene.tolerance
    if end - start < -least:
        hint = f"; angles grow counter-clockwise, past {FULL_CIRCLE:g} deg too: `to: {end + FULL_CIRCLE:g}`"
        through = hint if is_arc and 0.0 < end + FULL_CIRCLE - start <= FULL_CIRCLE else ""
        scene.report.fault(at, f"the part from {shown} ends before it begins; `from` must be less than `to`{through}")
    elif end - start <= least:
        scene.report.fault(at, f"the part from {shown} has no length; `from` must be less than `to`")
    elif is_arc and end - start > FULL_CIRCLE:
        scene.report.fault(at, f"the part from {shown} is more than the whole arc; wanted: at most {FULL_CIRCLE:g} deg")


def _an(kind: str) -> str:
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"
