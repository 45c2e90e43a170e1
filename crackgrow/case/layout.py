"""Where the bodies and cracks of a case lie, as far as their shapes are sound: what the checks look at."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import shapely
from shapely import LineString

from crackgrow.arrays import Floats, frozen
from crackgrow.case.joining import joined, rims_of
from crackgrow.case.model import Cut, EdgeRegion, Move
from crackgrow.case.report import Path, Report
from crackgrow.case.segments import line_length, segments_of
from crackgrow.case.shapes import BodyShape, Resolved, direction_of, shape_of, without_repeats
from crackgrow.case.touching import ITS_OWN, SNAP, overlap, shared_lines, size_of, snapped_bodies
from crackgrow.case.toughness import BY_K, MODE_I, radius_of, shear_radius_of
from crackgrow.case.units import UNITS, Units

EXACT: Final = 12  # digits of a place that the user is to write
ENDS_WITH_TIP: Final[dict[str | None, tuple[str, ...]]] = {
    "both": ("start", "end"), "start": ("start",), "end": ("end",), "none": (), None: (),
}  # fmt: skip

SHORTEST = 1e-3  # least segment, in lattice spacings and in crack lengths
SMALLEST = 1e-4  # least crack length and increment, in lattice spacings: some of the smallest cells

ON_OUTLINE = 1e-9  # points nearer to an outline than this part of the scene's size lie on it
FARTHEST = 1e5  # largest distance of a scene from the origin, in sizes: coordinates must resolve ON_OUTLINE


@dataclass(frozen=True, slots=True)
class Scene:
    """The resolved case, sound or not, with what checks need of it."""

    resolved: dict[str, Any]
    report: Report
    units: Units
    box: Floats  # (2, 2) m, lower left and upper right of the bodies
    size: float  # m, diameter of the least circle round all bodies
    bodies: dict[str, BodyShape] = field(default_factory=dict)  # those with a sound shape
    cracks: dict[str, Floats] = field(default_factory=dict)  # points (n, 2) m of those with a sound path
    moves: list[Move] = field(default_factory=list)  # what was brought to what it nearly touched
    cuts: list[Cut] = field(default_factory=list)  # what of sets of cracks was left out
    shared: dict[tuple[str, str], tuple[Floats, ...]] = field(default_factory=dict)  # of bodies with a common boundary
    hosts: dict[str, str] = field(default_factory=dict)  # for a crack, the body in which most of it lies
    regions: dict[Path, EdgeRegion] = field(default_factory=dict)  # by key of `on`, filled by check_regions
    places: dict[Path, Floats] = field(default_factory=dict)  # (2,) m by key, where `output.points` lie
    holders: dict[Path, str] = field(default_factory=dict)  # by key, the bodies that they lie in

    @property
    def tolerance(self) -> float:
        """Distance in m; what is nearer is the same place."""
        return ON_OUTLINE * self.size

    @property
    def reach(self) -> float:
        """Distance in m; corners and ends of cracks that are nearer to what they may touch are moved onto it."""
        return SNAP * self.size

    @property
    def complete(self) -> bool:
        """Whether every body of the case has a sound shape."""
        return len(self.bodies) == len(named(self.resolved, "bodies")) > 0

    @property
    def starts_cracks(self) -> bool:
        """Whether cracks may start elsewhere than at the tips that are given."""
        return self.get("growth", "initiation", "at") not in (None, "tips")

    @property
    def parts_interfaces(self) -> bool:
        """Whether the cracked part of an interface may grow."""
        return any("toughness" in interface for _, interface in self.listed("interfaces"))

    def lines_between(self, first: str, second: str) -> tuple[Floats, ...]:
        """The boundary that two bodies share: lines (n, 2) m, none where they share no boundary."""
        return self.shared.get((first, second)) or self.shared.get((second, first)) or ()

    def tips_of(self, crack: str) -> tuple[str, ...]:
        """The ends of a crack, `start` and `end`, with a tip that can grow: not those that were moved."""
        own = [move for move in self.moves if move.end is not None and move.end[0] == crack]
        moved = [move.end for move in own if move.distance > self.tolerance]
        return tuple(end for end in ENDS_WITH_TIP[self.get("cracks", crack, "tips")] if (crack, end) not in moved)

    def get(self, *path: str) -> Any:
        """Return the value at a key path if it is given and sound, else None."""
        value: Any = self.resolved
        if not self.report.sound(*path):
            return None
        for key in path:
            if key not in value:
                return None
            value = value[key]
        return value

    def averaging_radii(self) -> Iterator[tuple[str | None, tuple[str, ...], float]]:
        """Radii (m) to average over, with their keys: the one that is given, then, with its name, those of each body
        whose toughnesses are known, unless the criterion goes by K alone: it does at tips, not where cracks start."""
        given, criterion = self.get("growth", "tip_stress", "radius"), self.get("growth", "criterion")
        by_K = frozenset() if self.starts_cracks else BY_K
        if given is not None:
            yield None, ("growth", "tip_stress", "radius"), given
        for name in named(self.resolved, "bodies") if criterion in MODE_I.keys() - by_K else ():
            key = ("bodies", name, "strength")
            strength = self.get(*key)
            if not isinstance(strength, dict):
                continue
            if "toughness" in strength:
                yield name, (*key, "toughness"), radius_of(criterion, strength["tension"], strength["toughness"])
            if "shear_toughness" in strength and strength["cohesion"] > 0.0:
                radius = shear_radius_of(strength["cohesion"], strength["shear_toughness"])
                yield name, (*key, "shear_toughness"), radius

    def listed(self, key: str) -> list[tuple[int, Resolved]]:
        """Return the items of a list that could be read, as a whole or in part, with their numbers."""
        listing = self.resolved.get(key)
        items = enumerate(listing if isinstance(listing, list) else [])
        return [(index, item) for index, item in items if isinstance(item, dict)]

    def items(self, key: str, kind: str) -> list[tuple[int, Resolved]]:
        """Return the items of a list that have a key and no fault, with their numbers."""
        return [(index, item) for index, item in self.listed(key) if kind in item and self.report.sound(key, index)]

    def length(self, value: float) -> str:
        """Write a length in the units of the case."""
        return self.units.show(value, "length")

    def exact_point(self, point: Floats) -> str:
        """Write a point with as many digits as tell it from what lies within reach of it."""
        return self.units.place(point, EXACT)


def named(resolved: dict[str, Any], key: str) -> dict[str, Any]:
    """Return the things under names, empty if they could not be read."""
    things = resolved.get(key)
    return things if isinstance(things, dict) else {}


def scene_of(resolved: dict[str, Any], report: Report, units: Units) -> Scene:
    """Collect the bodies whose shapes are sound and bring them together; report shapes that are not, and overlaps."""
    shapes = [
        shape
        for name, body in named(resolved, "bodies").items()
        if report.sound("bodies", name, "shape") and (shape := shape_of(name, body, report, units)) is not None
    ]
    outlines = np.concatenate([shape.outline for shape in shapes] or [np.zeros((1, 2))])
    box, size = np.stack([outlines.min(axis=0), outlines.max(axis=0)]), size_of(outlines) if shapes else 0.0
    scene = Scene(resolved, report, units, box, size)
    if shapes:
        _place(scene, shapes)
    return scene


def place_cracks(scene: Scene) -> None:
    """Collect the cracks whose paths are sound, and find out what body each lies in."""
    spacing = scene.get("numerics", "spacing")
    for name, crack in named(scene.resolved, "cracks").items():
        # the lines of a map are cracks by now, but for a map of a faulty crack
        if scene.report.sound("cracks", name, "path") and "traces" not in crack["path"]:
            least = min(np.inf if spacing is None else spacing, line_length(points_of(crack["path"])))
            scene.cracks[name] = points_of(crack["path"], SHORTEST * least)
    scene.hosts.update(_hosts(scene.cracks, list(scene.bodies.values())))
    reach = {}  # the segments that move with an end turn by less than half a degree
    for name, points in scene.cracks.items():
        lengths = np.hypot(*np.diff(points, axis=0).T) if len(points) > 1 else np.zeros(1)
        reach[name] = (min(scene.reach, ITS_OWN * lengths[0]), min(scene.reach, ITS_OWN * lengths[-1]))
    cracks, moves = joined(scene.cracks, reach, rims_of(scene.bodies.values()), scene.tolerance)
    scene.cracks.update(cracks)
    scene.moves.extend(moves)


def points_of(path: Resolved, smallest: float = 0.0) -> Floats:
    """Return the vertices `(n, 2) float` of a crack in m from start to end, repeated ones once.

    Those no farther than `smallest` (m) from the one before them are repeated, too; the end stays where it is. n is 1
    if all vertices are one and 0 if none is given.
    """
    if "points" not in path:
        x, y = path["center"]
        cos, sin = direction_of(path["angle"])
        a = path["length"] / 2
        return frozen([(x - a * cos, y - a * sin), (x + a * cos, y + a * sin)])
    points = np.array(path["points"], dtype=float).reshape(-1, 2)
    kept = without_repeats(points, closed=False, smallest=smallest)
    if len(kept) < 2:  # not even as long as that, which is told elsewhere
        kept = without_repeats(points, closed=False)
    if len(kept) > 1:
        kept[-1] = len(points) - 1
    return frozen(points[kept])


def _place(scene: Scene, shapes: list[BodyShape]) -> None:
    """Bring neighbours together and find out what lies where."""
    distance, name = max((float(np.abs(shape.outline).max()), shape.name) for shape in shapes)
    if distance > FARTHEST * scene.size:
        message = f"{scene.length(distance)} from the origin is too far for a scene of size {scene.length(scene.size)}"
        step = 10.0 ** np.ceil(np.log10(scene.size))
        near = step * np.round(scene.box[0] / step) / float(UNITS["length"][scene.units.length])
        remedy = f"give the map an origin near it, such as `units: {{origin: [{near[0]:.0f}, {near[1]:.0f}]}}`"
        scene.report.fault(("bodies", name, "shape"), f"{message}: coordinates lose accuracy; {remedy}")
        return
    bodies, moves = snapped_bodies(shapes, scene.reach)
    scene.moves.extend(moves)
    for body in bodies:
        shortest = np.hypot(*(body.sides[:, 1] - body.sides[:, 0]).T).min()
        if shortest <= scene.tolerance or not body.polygon.is_valid:
            message = f"has details below the smallest length of this scene, {scene.length(scene.tolerance)}"
            scene.report.fault(("bodies", body.name, "shape"), message)
    bodies = [body for body in bodies if scene.report.sound("bodies", body.name, "shape")]
    scene.bodies.update((body.name, body) for body in bodies)
    polygons = np.array([body.polygon for body in bodies], dtype=object)
    pairs = shapely.STRtree(polygons).query(polygons, predicate="dwithin", distance=scene.tolerance).T.tolist()
    for first, second in [(bodies[one], bodies[other]) for one, other in sorted(pairs) if one < other]:
        place = overlap(first, second, scene.tolerance)
        if place is not None:
            message = f"overlaps body '{first.name}', such as at {scene.units.place(place)}"
            scene.report.fault(("bodies", second.name, "shape"), message)
        elif lines := shared_lines(first, second):
            scene.shared[first.name, second.name] = lines


def _hosts(cracks: dict[str, Floats], bodies: list[BodyShape]) -> dict[str, str]:
    """Return for every crack the body in which most of it lies, or else the one nearest to it.

    A crack that begins or ends on a boundary of two bodies lies in the one that its inside lies in.
    """
    names = [name for name, points in cracks.items() if len(points) > 1]
    if not names or not bodies:
        return {}
    segments = segments_of([cracks[name] for name in names])  # one by one: a line that crosses itself often takes long
    polygons = np.array([body.polygon for body in bodies], dtype=object)
    tree, inside = shapely.STRtree(polygons), np.zeros((len(names), len(bodies)))
    segment, body = tree.query(segments.shapes, predicate="intersects")
    lengths = shapely.length(shapely.intersection(segments.shapes[segment], polygons[body]))
    np.add.at(inside, (segments.lines[segment], body), lengths)
    nearest = tree.nearest([LineString(cracks[name]) for name in names])
    hosts = np.where(inside.any(axis=1), inside.argmax(axis=1), nearest)
    return {name: bodies[host].name for name, host in zip(names, hosts.tolist(), strict=True)}
