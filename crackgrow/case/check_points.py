"""Whether the places whose course is written lie in the rock, and on what they say they lie on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from shapely import LineString, Point

from crackgrow.arrays import Floats
from crackgrow.case.check_regions import knows_body, knows_crack
from crackgrow.case.layout import Scene
from crackgrow.case.report import Path, quoted
from crackgrow.case.shapes import Resolved, frozen


def check_points(scene: Scene) -> None:
    """Report points off the rock, or off the crack or interface that they are to lie on; note where they lie.

    What is nearer to the rock, or to the line, than ends of cracks are moved, is moved onto it.
    """
    points = scene.get("output", "points")
    if points is None or not scene.complete:
        return
    for name, point in points.items():
        key: Path = ("output", "points", name)
        if not scene.report.sound(*key):
            continue
        if "between" in point:
            for end in range(2):
                place_in_rock(scene, (*key, "between", end), point["between"][end], {})
            if np.array_equal(*point["between"]):
                scene.report.fault((*key, "between"), "the two points are one")
        elif "crack" in point:
            _on_crack(scene, key, point)
        elif "interface" in point:
            _on_interface(scene, key, point)
        else:
            place_in_rock(scene, (*key, "at"), point["at"], point)


def place_in_rock(scene: Scene, key: Path, at: Sequence[float], item: Resolved) -> None:
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


def _on_crack(scene: Scene, key: Path, point: Resolved) -> None:
    name = point["crack"]
    if knows_crack(scene, (*key, "crack"), name) and len(scene.cracks.get(name, ())) > 1:
        _on_lines(scene, key, point, LineString(scene.cracks[name]), f"crack '{name}'")


def _on_interface(scene: Scene, key: Path, point: Resolved) -> None:
    bodies = tuple(point["interface"])
    if not scene.report.sound("interfaces"):  # one with a fault may be the one that is meant
        return
    given = [set(item["between"]) for _, item in scene.items("interfaces", "between")]
    if set(bodies) not in given:
        known = ", ".join(" and ".join(sorted(pair)) for pair in given) or "none"
        message = f"there is no interface between bodies {' and '.join(map(quoted, bodies))}; those given are: {known}"
        scene.report.fault((*key, "interface"), message)
        return
    lines = scene.lines_between(bodies[0], bodies[1])
    if lines:
        shape = shapely.multilinestrings([LineString(line) for line in lines])
        _on_lines(scene, key, point, shape, f"the interface between bodies {' and '.join(map(quoted, bodies))}")


def _on_lines(scene: Scene, key: Path, item: Resolved, lines: shapely.Geometry, what: str) -> None:
    point = Point(item["at"])
    distance = float(lines.distance(point))
    if distance > scene.reach:
        onto = shapely.get_coordinates(shapely.shortest_line(lines, point))[0]
        off = scene.units.show(distance, "length", 3)
        where = f"{scene.exact_point(np.array(item['at']))} is {off} from {what}"
        scene.report.fault((*key, "at"), f"{where}; the nearest point of it is {scene.exact_point(onto)}")
    else:
        _note(scene, (*key, "at"), lines, point)


def _note(scene: Scene, key: Path, shape: shapely.Geometry, point: Point) -> None:
    onto: Floats = shapely.get_coordinates(shapely.shortest_line(shape, point))[0]
    scene.places[key] = frozen(onto)
