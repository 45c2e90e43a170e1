"""Whether `on` names an edge, or a part of one, and `at` a place in the rock or on a face; notes in the scene where."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, Literal

import numpy as np
import shapely
from shapely import LineString, Point

from crackgrow.arrays import Floats, frozen
from crackgrow.case.layout import Scene, named
from crackgrow.case.regions import FULL_CIRCLE, SAME_PLACE, Edge, edge_of, region_of
from crackgrow.case.report import Faults, Path, did_you_mean, listed, quoted
from crackgrow.case.shapes import Resolved
from crackgrow.case.units import QuantityError, parse_quantity

AXES: Final = {"x": 0, "y": 1}  # of what tells a place on an edge


def check_regions(scene: Scene) -> Faults:
    """Report unknown bodies and edges and parts that are none; bring `from` and `to` to m, or degrees on arcs."""
    for kind in ("supports", "loads"):
        for index, item in scene.listed(kind):
            key = (kind, index, "on")
            if "on" in item and scene.report.sound(*key) and knows(scene, (*key, "body"), "body", item["on"]["body"]):
                yield from _region(scene, key, item["on"])


def settle_bodies(scene: Scene) -> Faults:
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
                yield (*key, "body"), f"missing: name of a body; {which}: {', '.join(names)}"
            else:
                scene.report.doubt((*key, "body"))  # that there is none is told elsewhere


def knows(scene: Scene, key: Path, thing: Literal["body", "crack"], name: str) -> bool:
    """Whether there is a body or a crack of this name; reports it at the key if not, but for a case without bodies."""
    names = list(named(scene.resolved, {"body": "bodies", "crack": "cracks"}[thing]))
    if name not in names and (names or thing == "crack"):
        hint = f"{', '.join(names) or 'none'}{did_you_mean(name, names)}"
        scene.report.fault(key, f"no {thing} {quoted(name)}; the case has: {hint}")
    return name in names


def _region(scene: Scene, key: Path, on: dict[str, Any]) -> Faults:
    """Note the region of a known body that `on` says, or report why there is none."""
    body = scene.bodies.get(on["body"])
    if body is None or not scene.report.sound("bodies", body.name, "edges"):
        return
    if on["edge"] not in body.edge_names:
        allowed = listed(body.edge_names) + did_you_mean(on["edge"], body.edge_names)
        yield (*key, "edge"), f"body '{body.name}' has no edge {quoted(on['edge'])}; it has: {allowed}"
        return
    edge = edge_of(body, on["edge"], scene.tolerance)
    for end in [end for end in ("from", "to") if isinstance(on.get(end), str)]:  # others are settled
        yield from _settle(scene, (*key, end), on, end, edge)
    if scene.report.sound(*key):
        yield from _part(scene, key, on, edge)
    if scene.report.sound(*key):
        scene.regions[key] = region_of(body, edge, on)


def _settle(scene: Scene, key: Path, on: dict[str, Any], end: str, edge: Edge) -> Faults:
    """Bring `from` or `to` to what the edge measures; report the other kind, and places off the edge."""
    try:
        kind, axis = "angle" if edge.measure == "angle" else "length", AXES.get(edge.measure)
        value = on[end] = parse_quantity(on[end], kind, scene.units, axis)
    except QuantityError:
        wanted, given = ("an angle", "a length") if edge.measure == "angle" else ("a length", "an angle")
        yield key, f"a place on edge '{on['edge']}' is given by {wanted}, not by {given}"
        return
    low, high = edge.reach
    if edge.measure == "angle":
        if not -FULL_CIRCLE <= value <= 2 * FULL_CIRCLE:
            wanted = f"an angle from {-FULL_CIRCLE:g} to {2 * FULL_CIRCLE:g}"
            yield key, f"{value:g} deg is out of range; wanted: {wanted}"
    elif not low - scene.tolerance <= value <= high + scene.tolerance:
        shown, first, last = (_shown(scene, edge, place) for place in (value, low, high))
        yield key, f"{shown} is not on edge '{on['edge']}', which has {edge.measure} from {first} to {last}"


def _shown(scene: Scene, edge: Edge, place: float) -> str:
    """Write a place on an edge."""
    if edge.measure == "angle":
        return f"{place:g} deg"
    return scene.length(place) if edge.measure == "distance" else scene.units.coordinate(place, AXES[edge.measure])


def _part(scene: Scene, key: Path, on: dict[str, Any], edge: Edge) -> Faults:
    """Report a part without length, or of more than the whole arc."""
    start, end = on.get("from", edge.reach[0]), on.get("to", edge.reach[1])
    at, is_arc = (*key, "from" if "from" in on else "to"), edge.measure == "angle"
    part = f"the part from {' to '.join(_shown(scene, edge, value) for value in (start, end))}"
    least = FULL_CIRCLE * SAME_PLACE if is_arc else scene.tolerance
    if end - start < -least:
        hint = f"; angles grow counter-clockwise, past {FULL_CIRCLE:g} deg too: `to: {end + FULL_CIRCLE:g}`"
        through = hint if is_arc and 0.0 < end + FULL_CIRCLE - start <= FULL_CIRCLE else ""
        yield at, f"{part} ends before it begins; `from` must be less than `to`{through}"
    elif end - start <= least:
        yield at, f"{part} has no length; `from` must be less than `to`"
    elif is_arc and end - start > FULL_CIRCLE:
        yield at, f"{part} is more than the whole arc; wanted: at most {FULL_CIRCLE:g} deg"


def place_points(scene: Scene) -> Faults:
    """Note where points of supports, forces and outputs lie, and in which body; report those that are off.

    What is nearer to the rock, or to the line that it is to lie on, than ends of cracks are moved, is moved onto it.
    """
    if not scene.complete:
        return
    for kind in ("supports", "loads"):
        for index, item in scene.items(kind, "at"):
            yield from _place_in_rock(scene, (kind, index, "at"), item["at"], item)
    for name, point in (scene.get("output", "points") or {}).items():
        key: Path = ("output", "points", name)
        if not scene.report.sound(*key):
            continue
        if "between" in point:
            for end in range(2):
                yield from _place_in_rock(scene, (*key, "between", end), point["between"][end], {})
            if np.array_equal(*point["between"]):
                yield (*key, "between"), "the two points are one"
        elif "crack" in point or "interface" in point:
            if lines := lines_of(scene, key, point):
                yield from _place_on(scene, key, point, lines)
        else:
            yield from _place_in_rock(scene, (*key, "at"), point["at"], point)


def _place_in_rock(scene: Scene, key: Path, at: Sequence[float], item: Resolved) -> Faults:
    """Note the body of a point, and where it lies; it lies on no crack, where fields have two values."""
    where, point = scene.exact_point(np.array(at)), Point(at)
    distances = {name: float(body.polygon.distance(point)) for name, body in scene.bodies.items()}
    if "body" in item:
        if not knows(scene, (*key[:-1], "body"), "body", item["body"]):
            return
        distances = {item["body"]: distances[item["body"]]}
    nearest = min(distances, key=lambda name: distances[name])
    onto = _onto(scene.bodies[nearest].polygon, point)
    holding = [name for name, distance in distances.items() if distance <= scene.tolerance]
    if distances[nearest] > scene.reach:
        off = f"{scene.units.show(distances[nearest], 'length', 3)} from it at {scene.exact_point(onto)}"
        yield key, f"{where} lies outside of body '{nearest}', {off}"
    elif len(holding) > 1:
        say = f"say whose point it is, such as body: {holding[0]}" if "between" not in key else "move it a little"
        yield key, f"{where} lies on bodies {', '.join(holding)}, which may move apart; {say}"
    else:
        for name, line in scene.cracks.items():
            if len(line) > 1 and LineString(line).dwithin(point, scene.tolerance):
                remedy = f", or give {{crack: {name}, at: [x, y]}} for its opening and slip"
                message = f"{where} lies on crack '{name}', where fields have two values; move it a little"
                yield key, message + (remedy if key[0] == "output" else "")
        scene.places[key], scene.holders[key] = onto, nearest


def lines_of(scene: Scene, key: Path, item: Resolved) -> tuple[Floats, ...]:
    """The lines (n, 2) m of the crack, or the interface, that an item names; reports one that there is not."""
    if "crack" in item:
        known = knows(scene, (*key, "crack"), "crack", item["crack"])
        line = scene.cracks.get(item["crack"], np.empty((0, 2)))
        return (line,) if known and len(line) > 1 else ()
    first, second = item["interface"]
    if not scene.report.sound("interfaces"):  # one with a fault may be the one that is meant
        return ()
    are_bodies = [knows(scene, (*key, "interface", end), "body", name) for end, name in enumerate(item["interface"])]
    if not all(are_bodies):
        return ()
    given = [set(its["between"]) for _, its in scene.items("interfaces", "between")]
    if {first, second} not in given:
        known_ones = ", ".join(" and ".join(sorted(pair)) for pair in given) or "none"
        message = f"there is no interface between bodies {quoted(first)} and {quoted(second)}; those given are:"
        scene.report.fault((*key, "interface"), f"{message} {known_ones}")
        return ()
    return scene.lines_between(first, second)


def _place_on(scene: Scene, key: Path, item: Resolved, lines: Sequence[Floats]) -> Faults:
    """Note where on the lines (n, 2) m of a crack or an interface a point lies; report one that is off them."""
    shape, point = shapely.multilinestrings([LineString(line) for line in lines]), Point(item["at"])
    distance, onto = float(shape.distance(point)), _onto(shape, point)
    if distance <= scene.reach:
        scene.places[*key, "at"] = onto
        return
    what = f"crack '{item['crack']}'" if "crack" in item else "the interface between bodies "
    what += "" if "crack" in item else " and ".join(map(quoted, item["interface"]))
    where = f"{scene.exact_point(np.array(item['at']))} is {scene.units.show(distance, 'length', 3)} from {what}"
    yield (*key, "at"), f"{where}; the nearest point of it is {scene.exact_point(onto)}"


def _onto(shape: shapely.Geometry, point: Point) -> Floats:
    """The place (2,) of a shape that is nearest to a point."""
    return frozen(shapely.get_coordinates(shapely.shortest_line(shape, point))[0])
