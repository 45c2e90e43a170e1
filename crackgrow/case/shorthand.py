"""Short forms of supports and loads that stand for what the scene makes of them: `outline`, `far_field`, `minimal`.

The outline of all rock is held or loaded as a whole: outer rings of bodies, as far as no other body lies there.
`supports: minimal` holds a body whose loads balance, and takes no force.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, Final

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.check_regions import knows
from crackgrow.case.format import FORMAT, MINIMAL
from crackgrow.case.layout import Scene
from crackgrow.case.model import EdgeLoad, EdgePressure, EdgeTraction, FarField
from crackgrow.case.regions import Edge, EdgeRegion, edge_of, ends_of
from crackgrow.case.report import Faults, Path
from crackgrow.case.shapes import BodyShape, Resolved
from crackgrow.case.touching import sides_on
from crackgrow.errors import CaseError
from crackgrow.vectors import cross, outward_normals

KEY: Final = "supports"
BALANCED: Final = 1e-4  # of all forces together; what the loads leave over is less
GAUSS_POINTS: Final = 8  # on the loaded part of a side

Run = tuple[Resolved, float, float]
"""What is held along an edge, and from where to where (m) as it was drawn."""


def settle_outlines(scene: Scene) -> Faults:
    """Put supports of edges in the place of `outline`, and loads of single bodies in that of `far_field`.

    The first takes the place of the item, others come last: the numbers of other items stay.
    """
    for key, word in (("supports", "outline"), ("loads", "far_field")):
        for index, item in scene.listed(key):
            if word not in item or not scene.report.sound(key, index):
                continue
            names = [item["body"]] if "body" in item else list(scene.bodies)
            if not scene.complete or not all(knows(scene, (key, index, "body"), "body", name) for name in names):
                scene.report.doubt((key, index))  # the faults of bodies are told
                continue
            outer = {name: _outer_sides(scene, scene.bodies[name]) for name in names}
            if not any(outer.values()):
                yield (key, index), f"other bodies lie all round {', '.join(names)}: there is no outline"
            number = index
            for name, sides in outer.items():
                body = scene.bodies[name]
                loaded = [{"body": name, **item}] if sides else []
                for each in _held(scene, (key, index), item, body, sides) if word == "outline" else loaded:
                    scene.resolved[key][number : number + 1] = [each]
                    if word == "far_field":
                        limits = np.tile([0.0, 1.0], (len(sides), 1))
                        scene.regions[key, number, "on"] = EdgeRegion(name, "outline", np.array(sides), limits)
                    number = len(scene.resolved[key])


def _outer_sides(scene: Scene, body: BodyShape) -> list[int]:
    """Sides of the outline of a body where no other body lies."""
    shared = sides_on(body, [line for pair, lines in scene.shared.items() if body.name in pair for line in lines])
    return [side for side in range(len(body.outline)) if side not in shared]


def _held(scene: Scene, key: Path, item: Resolved, body: BodyShape, sides: list[int]) -> Iterator[Resolved]:
    """Supports of the edges that these sides belong to; reports parts of them that can't be held so."""
    for name in dict.fromkeys(body.rings[0].edge_names):
        edge = edge_of(body, name, scene.tolerance)
        total = float(edge.lengths.sum())
        for held, start, end in _runs(scene, edge, sides, item["outline"] == "fixed"):
            whole = start <= scene.tolerance and end >= total - scene.tolerance
            what = f"edge '{name}' of body '{body.name}'"
            if not held:
                inclined = "rollers hold edges along x or y, and it is inclined"
                scene.report.fault((*key, "outline"), f"{what}: {inclined}; take fixed, or load it by loads: far_field")
                return
            if not whole and edge.measure == "angle":
                scene.report.fault((*key, "outline"), f"{what} lies partly on another body: give a list of supports")
                return
            places = () if whole else _places(scene, edge, start, end)
            part = dict(zip(("from", "to"), places, strict=False))
            yield {"on": {"body": body.name, "edge": name, **part}, "displacement": held}


def _runs(scene: Scene, edge: Edge, sides: list[int], fixed: bool) -> list[Run]:
    """Parts of an edge, as it was drawn, whose sides are among these and held alike; rollers hold no inclined side."""
    runs: list[Run] = []
    begin = 0.0
    for side, (first, last) in zip(edge.sides, edge.ends, strict=True):
        step = last - first
        end, flat = begin + float(np.hypot(*step)), np.abs(step) <= scene.tolerance
        held = {axis: 0.0 for axis, along in zip("xy", flat, strict=True) if fixed or (along and flat.sum() == 1)}
        if side in sides:
            goes_on = runs and runs[-1][0] == held and runs[-1][2] == begin
            runs.append((held, runs.pop()[1] if goes_on else begin, end))
        begin = end
    return runs


def _places(scene: Scene, edge: Edge, start: float, end: float) -> list[float]:
    """From where to where on an edge, m, by its own measure, a part between two distances (m) from its begin is."""
    if edge.measure == "distance":
        return [start, end]
    first, step = edge.ends[0, 0], edge.ends[-1, 1] - edge.ends[0, 0]
    places = [first + along * step / np.hypot(*step) for along in (start, end)]
    return sorted(scene.units.coordinates(place)["xy".index(edge.measure)] for place in places)


def settle_supports(scene: Scene) -> Faults:
    """Put three constraints in the place of the word; report loose bodies, and loads that do not balance."""
    if scene.resolved.get(KEY) != MINIMAL:
        return
    scene.resolved[KEY] = []
    if not (scene.complete and all(map(scene.report.sound, ("loads", "interfaces")))):
        scene.report.doubt((KEY,))  # the faults of what they follow from are reported
        return
    loose = _loose_groups(scene)
    if len(loose) > 1:
        listed = " and ".join(", ".join(group) for group in loose)
        message = f"'{MINIMAL}' holds one body, or bodies that are bonded; loose from each other are {listed}"
        yield (KEY,), f"{message}: give a list of supports"
        return
    yield from _unbalanced(scene)
    points = _points(scene, max(scene.bodies.values(), key=lambda body: body.size))
    if points is None:
        yield (KEY,), "no two corners of the outline are clear of cracks; give a list of supports"
    else:
        scene.resolved[KEY] = points


def _loose_groups(scene: Scene) -> list[list[str]]:
    """The bodies, those that are bonded to each other together."""
    group = {name: [name] for name in scene.bodies}
    for _, interface in scene.items("interfaces", "between"):
        first, second = (group.get(name) for name in interface["between"])
        holds = interface["contact"] == "bonded" or not interface.keys().isdisjoint(("cracked", "toughness"))
        if holds and first and second and first is not second:
            first.extend(second)
            group.update(dict.fromkeys(second, first))
    return list({id(names): names for names in group.values()}.values())


def _points(scene: Scene, body: BodyShape) -> list[dict[str, Any]] | None:
    """Both components at one point and one at another: far apart, clear of cracks, and of loads where there is room."""
    sides = body.sides[: len(body.outline)]
    places = np.concatenate([sides[:, 0], sides.mean(axis=1)])  # corners, then the middle of each side
    spacing = scene.get("numerics", "spacing") or 0.0
    from_cracks, from_loads = _distances(scene.cracks.values(), places), _distances(_loaded(scene), places)
    clear = from_cracks > scene.tolerance
    for wanted in ((from_cracks > spacing) & (from_loads > scene.tolerance), clear & (from_loads > 0.0), clear):
        found = places[wanted]
        axis = int(np.argmax(np.ptp(found, axis=0))) if len(found) else 0
        if len(found) and np.ptp(found[:, axis]) >= 0.25 * body.size:
            break
    else:
        if not len(found) or np.ptp(found[:, axis]) <= scene.tolerance:
            return None
    first, second = found[np.argmin(found[:, axis])], found[np.argmax(found[:, axis])]
    across = "yx"[axis]
    return [
        {"at": scene.units.coordinates(first), "displacement": {"x": 0.0, "y": 0.0}, "body": body.name},
        {"at": scene.units.coordinates(second), "displacement": {across: 0.0}, "body": body.name},
    ]


def _loaded(scene: Scene) -> list[Floats]:
    """Lines (2, 2) m and points (1, 2) m that loads act on."""
    regions = [region for key, region in scene.regions.items() if key[0] == "loads"]
    lines = [line for region in regions for line in ends_of(scene.bodies[region.body], region)]
    return [*lines, *(np.array([load["at"]]) for _, load in scene.items("loads", "force"))]


def _distances(lines: Iterable[Floats], places: Floats) -> Floats:
    """Distance (n,) m of places (n, 2) m from the nearest of some lines, or points, (k, 2) m."""
    shapes = [shapely.LineString(line) if len(line) > 1 else shapely.Point(line[0]) for line in lines if len(line)]
    apart = shapely.distance(shapely.points(places), shapely.GeometryCollection(shapes))
    return np.asarray(apart) if shapes else np.full(len(places), np.inf)


def _unbalanced(scene: Scene) -> Faults:
    """Report loads that leave a force, or a moment, at a load factor that they are to have."""
    sums, sizes = np.zeros((2, 3)), np.zeros(2)  # of scaled, of held loads: x, y, moment / size of the scene, N/m
    for index, load in enumerate(scene.resolved["loads"]):
        for points, forces in _forces(scene, index, load):
            moment = cross(points - scene.box.mean(axis=0), forces).sum()
            sums[int(load["held"])] += [*forces.sum(axis=0), moment / scene.size]
            sizes[int(load["held"])] += np.hypot(*forces.T).sum()
    loading = scene.get("loading")
    history = loading.get("history") if isinstance(loading, dict) else None
    for factors in np.array([(f, 1.0) for f in history] if history else [(0.0, 1.0), (1.0, 0.0)]):
        left = factors @ sums
        if np.abs(left).max() > BALANCED * (np.abs(factors) @ sizes):
            x, y, turn = left / (1.0, 1.0, 1.0 / scene.size)
            rest = f"({x:.4g}, {y:.4g}) N/m and a moment of {turn:.4g} N about the middle"
            remedy = "balance them, or give a list of supports"
            yield (KEY,), f"'{MINIMAL}' takes no force, and the loads leave {rest}: {remedy}"
            return


def _forces(scene: Scene, index: int, load: Resolved) -> Iterator[tuple[Floats, Floats]]:
    """Places (n, 2) m and forces (n, 2) N/m of a load; pressure on both faces and stress balance in themselves."""
    region = scene.regions.get(("loads", index, "on"))
    if region is not None:
        ends = ends_of(scene.bodies[region.body], region)
        step = ends[:, 1] - ends[:, 0]
        along, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        places = (ends[:, :1] + 0.5 * (1.0 + along)[:, None] * step[:, None]).reshape(-1, 2)
        lengths = np.outer(np.hypot(*step.T), 0.5 * weights).ravel()
        kind: type[Any] = EdgePressure if "pressure" in load else FarField if "far_field" in load else EdgeTraction
        try:
            outward = np.repeat(outward_normals(step), GAUSS_POINTS, axis=0)
            on_edge: EdgeLoad = FORMAT.made(kind, load, region=region)
            yield places, lengths[:, None] * on_edge.traction_at(places, outward)
        except CaseError:
            return  # a formula without a value, which is told elsewhere
    elif "gravity" in load and scene.get("bodies", load["body"], "material", "density"):
        polygon = scene.bodies[load["body"]].polygon
        mass = scene.get("bodies", load["body"], "material", "density") * polygon.area
        yield shapely.get_coordinates(polygon.centroid), mass * np.array([load["gravity"]])
    elif "force" in load:
        yield np.array([load["at"]]), np.array([load["force"]])
