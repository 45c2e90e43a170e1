"""Shapes of bodies: the rings of an outline and its holes, with the names of their edges."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Final

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from crackgrow.arrays import Floats, frozen
from crackgrow.case.report import Path, Report, listed, quoted
from crackgrow.case.segments import close_segments, places_between, segments_of
from crackgrow.case.units import Units

Resolved = dict[str, Any]  # a part of the resolved case

RECTANGLE_EDGES: Final = ("bottom", "right", "top", "left")
ARC: Final = "arc"  # the edge of a disk
HOLE: Final = "hole{}"  # the edge of a hole
DISK_SIDES: Final = 360  # a disk is a polygon with a corner at every whole degree
REPEATED_VERTEX: Final = 1e-9  # vertices nearer than this part of the line's extent are one


@dataclass(frozen=True, slots=True, eq=False)
class Ring:
    """A closed line round rock, which lies on its left: an outline runs counter-clockwise, a hole clockwise."""

    points: Floats  # (n, 2) m, corners, not closed
    edge_names: tuple[str, ...]  # (n,): name of the edge that the side from corner i to corner i + 1 belongs to

    @property
    def sides(self) -> Floats:
        """Ends `(n, 2, 2) float` of its sides in m."""
        return np.stack([self.points, np.roll(self.points, -1, axis=0)], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class DrawnRing(Ring):
    """A ring, and how it was drawn."""

    given: Floats  # (m, 2) m, the corners before neighbours moved them or gave it more
    drawn: NDArray[np.int64]  # (n,) number of the given corner that each side begins at, or at whose side it lies
    backwards: bool  # whether it runs against the direction in which it was drawn
    is_arc: bool  # whether it is a circle, on which places are angles


class Ringed:
    """What rings bound: the outline, then the holes."""

    __slots__ = ()
    rings: tuple[Ring, ...]

    @property
    def outline(self) -> Floats:
        """Corners `(n, 2) float` of the outline in m."""
        return self.rings[0].points

    @property
    def sides(self) -> Floats:
        """Ends `(n, 2, 2) float` of all sides in m, ring by ring."""
        return np.concatenate([ring.sides for ring in self.rings])


@dataclass(frozen=True, eq=False)
class BodyShape(Ringed):
    """Geometry of a body whose shape has no fault."""

    name: str
    rings: tuple[DrawnRing, ...]

    @cached_property
    def polygon(self) -> Polygon:
        """The body as a shape."""
        polygon = Polygon(self.outline, [ring.points for ring in self.rings[1:]])
        shapely.prepare(polygon)
        return polygon

    @cached_property
    def side_tree(self) -> shapely.STRtree:
        """Its sides in their order."""
        return shapely.STRtree(shapely.linestrings(self.sides))

    @property
    def extent(self) -> Floats:
        """Width and height of the bounding box, `(2,) float` in m."""
        return np.asarray(np.ptp(self.outline, axis=0), dtype=float)

    @property
    def size(self) -> float:
        """Diagonal of the bounding box in m."""
        return float(np.hypot(*self.extent))

    @property
    def center(self) -> Floats:
        """Centre of the bounding box, `(2,) float` in m."""
        return np.asarray((self.outline.min(axis=0) + self.outline.max(axis=0)) / 2, dtype=float)

    @property
    def corners(self) -> Floats:
        """Corners `(n, 2) float` of all rings in m."""
        return np.concatenate([ring.points for ring in self.rings])

    @property
    def edge_names(self) -> tuple[str, ...]:
        """Names of the edges, each once."""
        return tuple(dict.fromkeys(name for ring in self.rings for name in ring.edge_names))


def shape_of(name: str, body: Resolved, report: Report, units: Units) -> BodyShape | None:
    """Return the geometry of a body, or None after reporting why it has none."""
    key: Path = ("bodies", name, "shape")
    shape = body["shape"]
    parts = [(shape, key), *((hole, (*key, "holes", k)) for k, hole in enumerate(shape.get("holes", ())))]
    rings = []
    for index, (part, where) in enumerate(parts):
        points, names = _drawn(part)
        problem = _problem_of(points, names, units)
        if problem:
            report.fault(where, problem)
            continue
        names = names if index == 0 else (HOLE.format(index - 1),) * len(points)
        backwards = shapely.is_ccw(shapely.LinearRing(points)) == (index > 0)
        if backwards:  # the first corner stays the first
            points, names = frozen(np.roll(points[::-1], 1, axis=0)), names[::-1]
        rings.append(DrawnRing(points, names, points, np.arange(len(points)), backwards, "disk" in part))
    if not report.sound(*key):
        return None
    _check_holes(rings, key, report)
    if not report.sound(*key):
        return None
    if "edges" in body and report.sound("bodies", name, "edges"):
        rings[0] = _renamed(rings[0], body, ("bodies", name, "edges"), report)
    return BodyShape(name, tuple(rings))


def without_repeats(points: Floats, *, closed: bool, smallest: float = 0.0) -> NDArray[np.int64]:
    """Return the numbers `(m,) int` of the points `(n, 2) float` that do not repeat the one kept before them.

    Points no farther apart than `smallest` (m), or a small part of their extent, are the same.
    """
    smallest = max(smallest, REPEATED_VERTEX * math.hypot(*np.ptp(points, axis=0))) if len(points) else 0.0
    kept: list[int] = []
    for index, point in enumerate(points):
        if not kept or math.dist(point, points[kept[-1]]) > smallest:
            kept.append(index)
    while closed and len(kept) > 1 and math.dist(points[kept[-1]], points[0]) <= smallest:
        kept.pop()
    return np.array(kept, dtype=np.int64)


def direction_of(angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle in degrees, exact at right angles."""
    quarter, rest = divmod(angle % 360.0, 90.0)
    if rest == 0.0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
    radians = math.radians(angle % 360.0)
    return math.cos(radians), math.sin(radians)


def _drawn(shape: Resolved) -> tuple[Floats, tuple[str, ...]]:
    """Return the corners `(n, 2) float` in m as they are drawn, and the name of the edge after each."""
    if "rectangle" in shape:
        (x, y), width, height = (shape["rectangle"][key] for key in ("center", "width", "height"))
        a, b = width / 2, height / 2
        return frozen([(x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)]), RECTANGLE_EDGES
    if "disk" in shape:
        (x, y), radius = shape["disk"]["center"], shape["disk"]["radius"]
        rays = [direction_of(360.0 * k / DISK_SIDES) for k in range(DISK_SIDES)]
        return frozen([(x + radius * cos, y + radius * sin) for cos, sin in rays]), (ARC,) * DISK_SIDES
    points = frozen(np.array(shape["polygon"], dtype=float).reshape(-1, 2))
    every, kept = (without_repeats(points, closed=closed) for closed in (False, True))
    # A side keeps the number of the one drawn edge between two kept corners that is not a mere repetition: the
    # one that leaves the last point of the first corner's run.
    ends = [*every[1:], len(points)][: len(kept)]
    return frozen(points[kept]), tuple(str(end - 1) for end in ends)


def _problem_of(points: Floats, names: tuple[str, ...], units: Units) -> str | None:
    """Say what is wrong with a closed line, if anything is."""
    if len(points) < 3:
        return f"{len(points)} different corners given; wanted: at least three"
    size = math.hypot(*np.ptp(points, axis=0))
    if shapely.MultiPoint(points).convex_hull.area <= REPEATED_VERTEX * size**2:
        return "the corners lie on a line; they enclose no area"
    sides = segments_of([np.vstack([points, points[:1]])])
    pairs = close_segments(sides, REPEATED_VERTEX * size)
    between = pairs[:, 1] - pairs[:, 0]
    apart = pairs[(between >= 2) & (between <= len(points) - 2)]  # if neighbours fold back, one next to them touches
    if not len(apart):
        return None
    one, other = apart[0].tolist()
    return f"edges {names[one]} and {names[other]} cross or touch at {units.place(places_between(sides, apart[:1])[0])}"


def _check_holes(rings: list[DrawnRing], key: Path, report: Report) -> None:
    """Report holes that do not lie clear of the outline and of each other."""
    outline, *holes = (Polygon(ring.points) for ring in rings)
    tolerance = REPEATED_VERTEX * math.hypot(*np.ptp(rings[0].points, axis=0))
    tree = shapely.STRtree(holes)
    shapely.prepare(outline)
    for index, hole in enumerate(holes):
        where = (*key, "holes", index)
        if not outline.contains(hole) or outline.exterior.dwithin(hole.exterior, tolerance):
            report.fault(where, f"{HOLE.format(index)} is not inside of the outline, clear of it")
        for other in sorted(tree.query(hole, predicate="dwithin", distance=tolerance).tolist()):
            if other < index:
                report.fault(where, f"{HOLE.format(index)} overlaps or touches {HOLE.format(other)}")


def _renamed(ring: DrawnRing, body: Resolved, key: Path, report: Report) -> DrawnRing:
    """Give the names of `edges` to the edges of a polygon; report numbers and names that do not fit."""
    if "polygon" not in body["shape"]:
        kind = next(iter(body["shape"]))
        message = f"names the edges of a polygon or a file; a {kind} has {', '.join(dict.fromkeys(ring.edge_names))}"
        report.fault(key, message)
        return ring
    known = list(ring.edge_names)[:: -1 if ring.backwards else 1]  # in drawing order
    names = dict(zip(known, known, strict=True))
    holes = [HOLE.format(k) for k in range(len(body["shape"].get("holes", ())))]
    for name, numbers in body["edges"].items():
        where = (*key, name)
        given = list(map(str, numbers))
        strange = [number for number in given if number not in names]
        taken = [number for number in given if number in names and names[number] != number]
        if name.isdecimal() or name in holes:
            kind = "number of an edge" if name.isdecimal() else "name of a hole"
            report.fault(where, f"{quoted(name)} is the {kind}; choose another name")
        elif not given:
            report.fault(where, "no edge given; wanted: the number of an edge, or a list of them")
        elif strange:
            report.fault(where, f"no edge {strange[0]}; the polygon has {listed(known)}")
        elif taken or len(set(given)) < len(given):
            twice = taken[0] if taken else next(number for number in given if given.count(number) > 1)
            report.fault(where, f"edge {twice} is named twice")
        elif any(known.index(b) != (known.index(a) + 1) % len(known) for a, b in pairwise(given)):
            report.fault(where, f"edges {', '.join(given)} do not follow one another")
        else:
            names.update(dict.fromkeys(given, name))
    return replace(ring, edge_names=tuple(names[number] for number in ring.edge_names))
