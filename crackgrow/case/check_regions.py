"""Whether `on` names an edge, or a part of one, and `at` a place in the rock or on a face; notes in the scene where."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import shapely
from shapely import LineString, Point

from crackgrow.arrays import Floats
from crackgrow.case.layout import Scene, named
from crackgrow.case.regions import FULL_CIRCLE, SAME_PLACE, Along, Edge, edge_of, region_of
from crackgrow.case.report import Path, did_you_mean, quoted
from crackgrow.case.shapes import Resolved, edge_hint, frozen


def check_regions(scene: Scene) -> None:
    """Report unknown bodies and edges and parts that are none; bring `from` and `to` to m, or degrees on arcs."""
    for key in ("supports", "loads"):
        for index, item in scene.listed(key):
            if "on" in item and scene.report.sound(key, index, "on"):
                _check_region(scene, (key, index, "on"), item["on"])


def settle_bodies(scene: Scene) -> None:
    """Name the only body where supports and loads name none; report where there are several."""
    names = list(named(scene.resolved, "bodies"))
    for kind in ("supports", "loads"):
        for index, item in scene.listed(kind):
            key: Path = (kind, index, "on") if "on" in item else (kind, index)
            wants = item.get("on", item if item.keys() & {"gravity", "stress"} else None)
            if wants is None or not scene.report.sound(*key) or "body" in wants:
                continue
            if len(names) == 1:
                wants["body"] = names[0]
            elif names:
                which = "the case has several, so say which one"
                scene.report.fault((*key, "body"), f"missing: name of a body; {which}: {', '.join(names)}")
            else:
                scene.report.doubt((*key, "body"))  # that there is none is told elsewhere


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


def place_points(scene: Scene) -> None:
    """Note where points of supports, forces and outputs lie, and in which body; report those that are off.

    What is nearer to the rock, or to the line that it is to lie on, than ends of cracks are moved, is moved onto it.
    """
    if not scene.complete:
        return
    for kind in ("supports", "loads"):
        for index, item in scene.items(kind, "at"):
            _place_in_rock(scene, (kind, index, "at"), item["at"], item)
    for name, point in (scene.get("output", "points") or {}).items():
        key: Path = ("output", "points", name)
        if not scene.report.sound(*key):
            continue
        if "between" in point:
            for end in range(2):
                _place_in_rock(scene, (*key, "between", end), point["between"][end], {})
            if np.array_equal(*point["between"]):
                scene.report.fault((*key, "between"), "the two points are one")
        elif "crack" in point or "interface" in point:
            if lines := lines_of(scene, key, point):
                _place_on(scene, key, point, lines)
        else:
            _place_in_rock(scene, (*key, "at"), point["at"], point)


def _place_in_rock(scene: Scene, key: Path, at: Sequence[float], item: Resolved) -> None:
    """Note the body of a point, and where it lies; it lies on no crack, where fields have two values."""
    place = np.array(at)
    where, point = scene.exact_point(place), Point(place)
    distances = {name: float(body.polygon.distance(point)) for name, body in scene.bodies.items()}
    if "body" in item:
        if not knows_body(scene, (*key[:-1], "body"), item["body"]):
            return
        distances = {item["body"]: distances[item["body"]]}
    nearest = min(distances, key=lambda name: distances[name])
    holding = [name for name, distance in distances.items() if distance <= scene.tolerance]
    if distances[nearest] > scene.reach:
        onto = shapely.get_coordinates(shapely.shortest_line(scene.bodies[nearest].polygon, point))[0]
        off = scene.units.show(distances[nearest], "length", 3)
        message = f"{where} lies outside of body '{nearest}', {off} from it at {scene.exact_point(onto)}"
        scene.report.fault(key, message)
    elif len(holding) > 1:
        message = f"{where} lies on bodies {', '.join(holding)}, which may move apart"
        say = f"; say whose point it is, such as body: {holding[0]}" if "between" not in key else "; move it a little"
        scene.report.fault(key, message + say)
    else:
        for name, line in scene.cracks.items():
            if len(line) > 1 and LineString(line).dwithin(point, scene.tolerance):
                message = f"{where} lies on crack '{name}', where fields have two values; move it a little"
                if key[0] == "output":
                    message = f"{message}, or give {{crack: {name}, at: [x, y]}} for its opening and slip"
                scene.report.fault(key, message)
        _note(scene, key, scene.bodies[nearest].polygon, point)
        scene.holders[key] = nearest


def lines_of(scene: Scene, key: Path, item: Resolved) -> tuple[Floats, ...]:
    """The lines (n, 2) m of the crack, or the interface, that an item names; reports one that there is not."""
    if "crack" in item:
        known = knows_crack(scene, (*key, "crack"), item["crack"])
        line = scene.cracks.get(item["crack"], np.empty((0, 2)))
        return (line,) if known and len(line) > 1 else ()
    first, second = item["interface"]
    if not scene.report.sound("interfaces"):  # one with a fault may be the one that is meant
        return ()
    are_bodies = [knows_body(scene, (*key, "interface", end), name) for end, name in enumerate(item["interface"])]
    if not all(are_bodies):
        return ()
    given = [set(its["between"]) for _, its in scene.items("interfaces", "between")]
    if {first, second} not in given:
        known_ones = ", ".join(" and ".join(sorted(pair)) for pair in given) or "none"
        message = f"there is no interface between bodies {quoted(first)} and {quoted(second)}; those given are:"
        scene.report.fault((*key, "interface"), f"{message} {known_ones}")
        return ()
    return scene.lines_between(first, second)


def _place_on(scene: Scene, key: Path, item: Resolved, lines: Sequence[Floats]) -> None:
    """Note where on the lines (n, 2) m of a crack or an interface a point lies; report one that is off them."""
    shape, point = shapely.multilinestrings([LineString(line) for line in lines]), Point(item["at"])
    distance = float(shape.distance(point))
    if distance <= scene.reach:
        _note(scene, (*key, "at"), shape, point)
        return
    what = f"crack '{item['crack']}'" if "crack" in item else "the interface between bodies "
    what += "" if "crack" in item else " and ".join(map(quoted, item["interface"]))
    onto = shapely.get_coordinates(shapely.shortest_line(shape, point))[0]
    where = f"{scene.exact_point(np.array(item['at']))} is {scene.units.show(distance, 'length', 3)} from {what}"
    scene.report.fault((*key, "at"), f"{where}; the nearest point of it is {scene.exact_point(onto)}")


def _note(scene: Scene, key: Path, shape: shapely.Geometry, point: Point) -> None:
    onto: Floats = shapely.get_coordinates(shapely.shortest_line(shape, point))[0]
    scene.places[key] = frozen(onto)
