"""Sets of cracks from files: each line becomes cracks of the bodies that it runs through."""

from __future__ import annotations

from typing import Any, Final

import shapely

from crackgrow.arrays import Floats
from crackgrow.case.layout import ENDS_WITH_TIP, Scene, named
from crackgrow.case.model import Cut
from crackgrow.case.schema import MOST_ITEMS

LONGEST: Final = 50  # name of a set: with two numbers it is still that of a crack


def expand_crack_sets(scene: Scene) -> None:
    """Put the cracks NAME-1, NAME-2, ... in the place of each set, cut where they leave the rock.

    Ends on a boundary are no tips. What is cut off or left out goes into the list of what was changed.
    """
    cracks = named(scene.resolved, "cracks")
    every: dict[str, Any] = {}
    for name, crack in cracks.items():
        if not (scene.report.sound("cracks", name) and "lines" in crack["path"]):
            every[name] = crack
        elif scene.complete:  # else the faults of its bodies are told
            place = scene.report.places.get(("cracks", name))
            if len(name) > LONGEST:
                scene.report.fault(("cracks", name), f"the name of a set has {LONGEST} letters at most")
            for new, part in _cracks_of(scene, name, crack):
                if new in cracks:
                    scene.report.fault(("cracks", new), f"is the name of a crack of the set '{name}'; choose another")
                elif place is not None:
                    scene.report.put(("cracks", new), place)
                every[new] = part
    if len(every) > max(MOST_ITEMS, len(cracks)):
        scene.report.fault(("cracks",), f"sets make {len(every)} cracks of it; wanted: {MOST_ITEMS} at most")
    cracks.clear()
    cracks.update(every)


def _cracks_of(scene: Scene, name: str, crack: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """The cracks of a set with their names; reports a set of which none lies in the rock."""
    found = []
    for number, line in enumerate(crack["path"]["lines"], 1):
        shape = shapely.LineString(line)
        parts = [(p, body) for body in scene.bodies for p in _inside(shape, scene.bodies[body].polygon, scene.reach)]
        for k, (part, body) in enumerate(parts, 1):
            new = f"{name}-{number}" if len(parts) == 1 else f"{name}-{number}-{k}"
            points = shapely.get_coordinates(part)
            boundary = scene.bodies[body].polygon.boundary
            free = _free_ends(points, boundary, scene.reach)
            tips = [end for end in ENDS_WITH_TIP[crack["tips"]] if end in free]
            word = "both" if len(tips) == 2 else tips[0] if tips else "none"
            found.append((new, {**crack, "path": {"points": points.tolist()}, "tips": word}))
        _tell(scene, f"{name}-{number}", shape, [part for part, _ in parts])
    if not found:
        scene.report.fault(("cracks", name, "path", "file"), "none of its lines lies in the rock")
    return found


def _inside(line: shapely.LineString, rock: shapely.Polygon, reach: float) -> list[shapely.LineString]:
    """The parts of a line in a body that are longer than `reach` (m), in the direction of the line."""
    parts = [part for part in shapely.get_parts(line.intersection(rock)) if part.length > reach]
    return sorted(parts, key=lambda part: float(line.project(shapely.Point(part.coords[0]))))


def _free_ends(points: Floats, boundary: shapely.Geometry, reach: float) -> list[str]:
    """The ends of a line (n, 2) m that lie farther than `reach` (m) from a boundary."""
    ends = shapely.points(points[[0, -1]])
    return [end for end, point in zip(("start", "end"), ends, strict=True) if not boundary.dwithin(point, reach)]


def _tell(scene: Scene, name: str, line: shapely.LineString, parts: list[shapely.LineString]) -> None:
    """List what of a line lies outside of the rock, if that is more than rounding."""
    lost = line.length - sum(part.length for part in parts)
    if lost > scene.tolerance:
        left = max(shapely.get_parts(line.difference(shapely.union_all(parts))), key=shapely.length)
        x, y = left.interpolate(0.5, normalized=True).coords[0]
        scene.cuts.append(Cut(name, float(lost), not parts, (float(x), float(y))))
