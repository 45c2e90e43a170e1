"""The automatic spacing of a scene, and the lengths that it follows from: cracks, holes, corners, bridges of rock.

A curve given as many short sides counts by its radius, and what an outline does over less than ROUGHNESS is not seen.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
import shapely
from shapely.ops import substring

from crackgrow.arrays import Floats, Ints
from crackgrow.case.accuracy import AUTO, LEVELS_OF_SPACING, REFINED_AT, Kind, cells_along
from crackgrow.case.layout import Scene, named, points_of
from crackgrow.case.regions import EdgeRegion
from crackgrow.case.segments import line_length
from crackgrow.case.units import place_text
from crackgrow.vectors import cross

ROUGHNESS: Final = 0.01  # shallower or shorter details, over the width of the ring that they are part of, are none
SHARP: Final = np.deg2rad(30.0)  # a ring that turns by more at a vertex has a corner there, by less it is a curve
SHARP_KINK: Final = np.deg2rad(10.0)  # a crack that turns by less at a vertex is as good as straight there
NARROWER: Final = 0.8  # corners and curves of a hole count beside its width where they are smaller by this factor
SAME_PLACE: Final = 1e-9  # over the length of a ring: parts of it that are no farther apart are one
IN_ROCK: Final = 0.99  # part of a bridge that must lie in rock: its ends lie on the boundary but for rounding
SPACED_BY: Final = ("bodies", "cracks", "growth", "supports", "loads")  # what an automatic spacing follows from


@dataclass(frozen=True, slots=True, eq=False)
class Length:
    """A length that the lattice must resolve."""

    kind: Kind
    metres: float
    what: str  # in words, such as "length of crack 'flaw'"
    where: shapely.Geometry | None = None  # m, parts of rims that it is of; None where it is of no rim


Rims = Mapping[str, Sequence[Floats]]
"""By name of a body its rings, closed lines with rock on their left: corners (n, 2) m of the outline, then of holes."""


def settle_spacing(scene: Scene) -> None:
    """Give an automatic spacing its number and its rule; a rule of an earlier case stays where it still holds.

    Cells are refined as accuracy asks where the spacing is automatic or a target is a number, else by hand.
    """
    given = scene.get("numerics", "spacing")
    accuracy = scene.get("numerics", "accuracy")
    if given is None:
        return
    if not (accuracy and scene.bodies and all(scene.report.sound(key) for key in SPACED_BY)):
        if given == AUTO:
            scene.report.doubt(("numerics", "spacing"))  # the faults of what it depends on are reported
        return
    numerics = scene.resolved["numerics"]
    spacing, rule, refine = given, "", numerics["refine"] if isinstance(numerics["refine"], dict) else {}
    if given == AUTO or "auto_rule" in numerics:
        refined = [kind for key in REFINED_AT if refine.get(key, AUTO) == AUTO for kind in REFINED_AT[key]]
        spacing, rule = automatic_spacing(accuracy, _lengths(scene), refined)
    followed = given == AUTO or (numerics.get("auto_rule") == rule and given == spacing)
    levels = dict.fromkeys(REFINED_AT, AUTO if followed or not isinstance(accuracy, str) else 0)
    numerics |= {"spacing": spacing if followed else given, "refine": {**levels, **refine}}
    numerics.pop("auto_rule", None)
    if followed:
        numerics["auto_rule"] = rule


def _lengths(scene: Scene) -> Iterator[Length]:
    """Every length of the scene that the lattice must resolve."""
    for name, crack in named(scene.resolved, "cracks").items():
        points = points_of(crack["path"])
        if line_length(points) > 0.0:
            yield Length("tip", line_length(points), f"length of crack '{name}'")
            kinks, parts = stretches(points)
            if len(kinks):
                yield Length("stretch", float(parts.min()), f"shortest part between kinks of crack '{name}'")
    for body in scene.bodies.values():
        yield Length("width", float(body.extent.min()), f"smaller side of body '{body.name}'")
    rims = {name: [ring.points for ring in body.rings] for name, body in scene.bodies.items()}
    supported = [region for key, region in scene.regions.items() if key[0] == "supports"]
    loaded = [region for key, region in scene.regions.items() if key[0] == "loads"]
    yield from rim_lengths(rims, scene.shared.items(), supported, loaded, scene.units.origin or (0.0, 0.0))
    increment = scene.get("growth", "increment")
    if increment is not None:
        yield Length("increment", increment, "growth.increment")
    for body_name, key, radius in scene.averaging_radii():
        by = key[-1].replace("_", " ")
        what = ".".join(key) if body_name is None else f"averaging radius by the {by} of body '{body_name}'"
        yield Length("radius", radius, what)


def automatic_spacing(
    accuracy: str | float, lengths: Iterable[Length], refined: Container[Kind] = ()
) -> tuple[float, str]:
    """The spacing (m) that resolves every one of the lengths, of which there is one at least, and what gave it.

    At lengths of the kinds `refined` cells are refined.
    """
    found = []
    for length in lengths:
        n, levels = cells_along(length.kind, accuracy), LEVELS_OF_SPACING if length.kind in refined else 0
        rule = f"{length.what} / {n:g}" + (f" x 2^{levels}" if levels else "")
        found.append((2**levels * length.metres / n, rule))
    return min(found)


def rim_lengths(
    rims: Rims,
    interfaces: Iterable[tuple[tuple[str, str], Sequence[Floats]]],
    supported: Sequence[EdgeRegion],
    loaded: Sequence[EdgeRegion],
    origin: tuple[float, float] = (0.0, 0.0),
) -> Iterator[Length]:
    """All lengths of rims, those that two bodies share by these and their lines (n, 2) m.

    origin: m, on the map on which places are told
    """
    for body, rings in rims.items():
        yield from feature_lengths(body, rings, origin)
    yield from _part_lengths("support", "supported", rims, supported)
    yield from _part_lengths("load", "loaded", rims, loaded)
    for (first, second), lines in interfaces:
        what = f"interface between bodies '{first}' and '{second}'"
        yield from (Length("support", line_length(line), what, shapely.LineString(line)) for line in lines)


def feature_lengths(body: str, rings: Sequence[Floats], origin: tuple[float, float] = (0.0, 0.0)) -> Iterator[Length]:
    """Widths of the holes of a body, notches and re-entrant corners, and the rock between its rings and corners."""
    lines = np.array([shapely.LinearRing(ring) for ring in rings], dtype=object)
    names, widths = _names(rings), [_width(line) for line in lines]
    for name, width, line in zip(names[1:], widths[1:], lines[1:], strict=True):
        yield Length("feature", width, f"width of {name} of body '{body}'", line)
    pairs, distances = shapely.STRtree(lines).query_nearest(lines, exclusive=True, return_distance=True)
    nearest = {(min(pair), max(pair)): apart for pair, apart in zip(pairs.T.tolist(), distances.tolist(), strict=True)}
    for (first, second), apart in sorted(nearest.items()):
        what = f"rock between {names[first]} and {names[second]} of body '{body}'"
        link = shapely.shortest_line(lines[first], lines[second])
        yield Length("bridge", apart, what, shapely.MultiPoint(link.coords))
    region = shapely.Polygon(rings[0], rings[1:])
    shapely.prepare(region)
    for name, line, width in zip(names, lines, widths, strict=True):
        shape = _simplified(line, ROUGHNESS * width)
        least, most = ROUGHNESS * width, np.inf if line is lines[0] else NARROWER * width
        where = f"{name} of body '{body}'"
        yield from (length for length in _corner_lengths(shape, least, where, origin) if length.metres < most)
        yield from _bridges(shape, region, least, where, origin)


def _part_lengths(kind: Kind, verb: str, rims: Rims, regions: Sequence[EdgeRegion]) -> Iterator[Length]:
    """Lengths of the parts of edges that `regions` cover; parts that follow each other along a ring are one.

    verb: what is done to them, such as "loaded"
    """
    for body, rings in rims.items():
        mine = [region for region in regions if region.body == body]
        first_side = 0
        for name, ring in zip(_names(rings), rings, strict=True):
            lengths = np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)
            begin = np.concatenate([[0.0], np.cumsum(lengths)])
            places = [
                (float(begin[side] + low * lengths[side]), float(begin[side] + high * lengths[side]))
                for region in mine
                for side, (low, high) in zip((region.sides - first_side).tolist(), region.limits.tolist(), strict=True)
                if 0 <= side < len(lengths)
            ]
            first_side += len(lengths)
            twice = shapely.LineString(np.concatenate([ring, ring, ring[:1]]))  # a part may lead past the first corner
            for start, end in _united(sorted(places), float(lengths.sum())):
                begin = start + 0.5 * twice.length
                part = substring(twice, begin, begin + (end - start))
                yield Length(kind, end - start, f"{verb} part of {name} of body '{body}'", part)


def stretches(line: Floats) -> tuple[Ints, Floats]:
    """Vertices (k,) at which a polyline (n, 2) turns sharply, and the lengths (k + 1,) m of the parts between them."""
    steps = np.diff(line, axis=0)
    turns = np.arctan2(cross(steps[:-1], steps[1:]), np.sum(steps[:-1] * steps[1:], axis=1))
    sharp = 1 + np.flatnonzero(np.abs(turns) > SHARP_KINK)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))])
    return sharp, np.diff(along[np.concatenate([[0], sharp, [len(line) - 1]])])


def _names(rings: Sequence[Floats]) -> list[str]:
    """What an outline and holes are called."""
    return ["the outline", *(f"hole{number}" for number in range(len(rings) - 1))]


def _width(line: shapely.LinearRing) -> float:
    """Smaller side (m) of the least rectangle round a ring, in whatever direction."""
    corners = shapely.get_coordinates(shapely.oriented_envelope(line))
    return float(np.hypot(*np.diff(corners[:3], axis=0).T).min())


def _simplified(line: shapely.LinearRing, tolerance: float) -> Floats:
    """Corners (n, 2) of a ring that stand out by the tolerance (m) from the line between their neighbours."""
    points = shapely.get_coordinates(shapely.simplify(line, tolerance))[:-1]
    while len(points) > 3:
        before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
        chord = after - before
        lowest = np.abs(cross(chord, points - before)) / np.hypot(*chord.T)
        if lowest.min() >= tolerance:
            break
        points = np.delete(points, int(np.argmin(lowest)), axis=0)
    return np.asarray(points)


def _turns(points: Floats) -> Floats:
    """How far (n,) radians a ring turns to the left at each of its corners (n, 2)."""
    after = np.roll(points, -1, axis=0) - points
    angle = np.arctan2(after[:, 1], after[:, 0])
    return np.asarray((angle - np.roll(angle, 1) + np.pi) % (2.0 * np.pi) - np.pi)


def _corner_lengths(points: Floats, least: float, where: str, origin: tuple[float, float]) -> Iterator[Length]:
    """The re-entrant corners and curves of a ring, as diameters of circles.

    A curve has sides of l and turns by 2 l / d from one to the next; a corner counts by the shorter of its two sides,
    which may be curved. Those with sides below the `least` (m) are roughness.
    """
    turns, sides = _turns(points), np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    smaller = 0.5 * (sides + np.roll(sides, 1))
    sharp = np.flatnonzero(np.abs(turns) > SHARP)
    if len(sharp):
        ends = np.append(sharp, sharp[0] + len(points))
        stretches = np.array([np.take(sides, range(a, b), mode="wrap").sum() for a, b in pairwise(ends)])
        smaller[sharp] = np.minimum(stretches, np.roll(stretches, 1))
    inward = np.flatnonzero((turns < 0.0) & (smaller >= least))
    for place, diameter in zip(inward.tolist(), (2.0 * smaller[inward] / -turns[inward]).tolist(), strict=True):
        corner = points[place]
        what = f"corner or curve at {place_text(corner + origin)} of {where}"
        yield Length("feature", diameter, what, shapely.Point(corner))


def _bridges(
    points: Floats, region: shapely.Polygon, least: float, where: str, origin: tuple[float, float]
) -> Iterator[Length]:
    """The shortest ways through rock, not below the `least` (m), from re-entrant corners of a ring to far sides."""
    turns = _turns(points)
    sharp = np.flatnonzero(np.abs(turns) > SHARP)
    sides = shapely.linestrings(np.stack([points, np.roll(points, -1, axis=0)], axis=1))
    stretch = np.searchsorted(sharp, np.arange(len(points)), side="right") % max(len(sharp), 1)  # of each side
    for number, corner in enumerate(sharp.tolist()):
        if turns[corner] > 0.0:
            continue
        own = {number, (number + 1) % len(sharp)}
        far = np.array([index for index in range(len(points)) if stretch[index] not in own], dtype=np.int64)
        links = shapely.shortest_line(shapely.Point(points[corner]), sides[far])
        lengths = shapely.length(links)
        for link in np.flatnonzero(lengths >= least)[np.argsort(lengths[lengths >= least])]:
            if _is_in_rock(links[link], region):
                what = f"rock beside the corner {place_text(points[corner] + origin)} of {where}"
                yield Length("bridge", float(lengths[link]), what, shapely.MultiPoint(links[link].coords))
                break


def _is_in_rock(link: shapely.LineString, region: shapely.Polygon) -> bool:
    """Whether a line between two places of a rim leads through rock, and not along the rim."""
    inside = shapely.distance(region.boundary, link.interpolate(0.5, normalized=True)) > (1.0 - IN_ROCK) * link.length
    return bool(inside and shapely.length(shapely.intersection(region, link)) > IN_ROCK * link.length)


def _united(places: list[tuple[float, float]], total: float) -> list[tuple[float, float]]:
    """Intervals in order along a closed ring of length `total`, those that touch as one."""
    found: list[tuple[float, float]] = []
    for start, end in places:
        if found and start <= found[-1][1] + SAME_PLACE * total:
            found[-1] = found[-1][0], max(found[-1][1], end)
        else:
            found.append((start, end))
    if len(found) > 1 and found[0][0] + total <= found[-1][1] + SAME_PLACE * total:  # round the first corner
        found[0] = found.pop()[0] - total, found[0][1]
    return found
