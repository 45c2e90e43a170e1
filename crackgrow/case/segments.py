"""Lines as straight segments: which come close, which run along each other, where they meet; parts of boundaries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.ops import substring

from crackgrow.arrays import Floats, Ints, frozen

MOST_PAIRS = 200_000  # of segments that come close; cracks of a scene make a few per crack
CHUNK = 64  # segments that are looked at together
STRAIGHT = np.deg2rad(0.5)  # a boundary that turns less at a tip is straight there
SAME_MEETING = 10.0  # places nearer than so many tolerances are one: each lies within the tolerance of its lines


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """The segments of several polylines, one after another."""

    ends: Floats  # (n, 2, 2) m
    lines: Ints  # (n,) number of the polyline that each belongs to
    shapes: NDArray[np.object_]  # (n,) the same as shapes
    tree: shapely.STRtree


def line_length(line: Floats) -> float:
    """Length (m) of a polyline (n, 2), 0 of fewer than two points."""
    return float(np.hypot(*np.diff(line, axis=0).T).sum())


def segments_of(lines: Sequence[Floats]) -> Segments:
    """Return the segments of polylines, each `(k, 2) float` with k > 1."""
    ends = np.concatenate([np.zeros((0, 2, 2)), *(np.stack([line[:-1], line[1:]], axis=1) for line in lines)])
    numbers = np.repeat(np.arange(len(lines)), [len(line) - 1 for line in lines])
    shapes = np.asarray(shapely.linestrings(ends), dtype=object)
    return Segments(ends, numbers, shapes, shapely.STRtree(shapes))


def close_segments(segments: Segments, tolerance: float) -> Ints:
    """Return the pairs `(m, 2) int`, i < j in order, of segments that come within the tolerance.

    Of more than MOST_PAIRS the first ones are returned, a few more than that.
    """
    found, n = [np.zeros((0, 2), dtype=np.int64)], 0
    for start in range(0, len(segments.shapes), CHUNK):
        some = segments.shapes[start : start + CHUNK]
        pairs = segments.tree.query(some, predicate="dwithin", distance=tolerance).T + np.array([start, 0])
        pairs = pairs[pairs[:, 0] < pairs[:, 1]]
        found.append(pairs[np.lexsort(pairs.T[::-1])])
        n += len(pairs)
        if n > MOST_PAIRS:
            break
    return np.concatenate(found)


def common_parts(first: Floats, second: Floats, tolerance: float) -> Floats:
    """Return where segments run along others, `(m, 2, 2) float`; nan where they do not.

    first, second: ends (m, 2, 2) of segments, pair by pair

    Two segments run along each other where one lies within the tolerance of the other over more than the tolerance.
    """
    start, along = first[:, 0], first[:, 1] - first[:, 0]
    length = np.hypot(*along.T)
    unit = along / length[:, None]
    places = np.einsum("mkx,mx->mk", second - start[:, None], unit)
    low, high = np.clip(places.min(axis=1), 0.0, length), np.clip(places.max(axis=1), 0.0, length)
    parts = start[:, None] + np.stack([low, high], axis=1)[:, :, None] * unit[:, None]
    lines = shapely.linestrings(second)
    apart = np.max([shapely.distance(shapely.points(parts[:, end]), lines) for end in (0, 1)], axis=0, initial=0.0)
    parts[(high - low <= tolerance) | (apart > tolerance)] = np.nan
    return np.asarray(parts, dtype=float)


def places_between(segments: Segments, pairs: Ints) -> Floats:
    """Return for pairs `(m, 2) int` of segments the place `(m, 2) float` where they meet or are nearest."""
    first, second = segments.shapes[pairs[:, 0]], segments.shapes[pairs[:, 1]]
    links = shapely.get_coordinates(shapely.shortest_line(first, second)).reshape(-1, 2, 2)
    return np.asarray(links[:, 0], dtype=float)


def meeting_places(lines: Sequence[Floats], tolerance: float) -> Floats:
    """Return the places `(k, 2) float` in m where two or more polylines come within the tolerance of each other."""
    segments = segments_of(lines)
    pairs = close_segments(segments, tolerance)
    places = places_between(segments, pairs[segments.lines[pairs[:, 0]] != segments.lines[pairs[:, 1]]])
    spots = shapely.union_all(shapely.buffer(shapely.points(places), 0.5 * SAME_MEETING * tolerance))
    point, spot = shapely.STRtree(shapely.get_parts(spots)).query(shapely.points(places), predicate="intersects")
    _, first = np.unique(spot, return_index=True)
    return np.asarray(places[np.sort(point[first])])


def opened(lines: tuple[Floats, ...], ends: Sequence[Sequence[float]]) -> tuple[Floats, ...]:
    """The lines of a boundary; of one all round a body, which comes in halves, one line that ends far from a crack.

    The crack is the shorter way between its `ends`.
    """
    if len(lines) != 2 or any((one[-1] != other[0]).any() for one, other in (lines, lines[::-1])):
        return lines
    ring = shapely.LineString(np.concatenate([lines[0], lines[1][1:]]))
    first, last = (ring.project(shapely.Point(end)) for end in ends)
    over = (last - first) % ring.length
    at = (first + 0.5 * over + (0.5 * ring.length if over <= 0.5 * ring.length else 0.0)) % ring.length
    parts = [shapely.get_coordinates(substring(ring, *part)) for part in ((at, ring.length), (0.0, at))]
    return (frozen(np.concatenate([parts[0], parts[1][1:]])),)


def parted(
    lines: Sequence[Floats], ends: Sequence[Sequence[float]], reach: float
) -> tuple[Floats, tuple[Floats, ...]] | None:
    """The cracked part (n, 2) m of a boundary between two places on one of its lines, and the lines that are left.

    None where no line has both. An end within `reach` (m) of a corner is there.
    """
    places = [shapely.Point(end) for end in ends]
    for number, line in enumerate(lines):
        shape = shapely.LineString(line)
        if all(shape.dwithin(place, reach) for place in places):
            corners = [shape.project(shapely.Point(corner)) for corner in line]
            first, last = sorted(_snapped(shape.project(place), corners, reach) for place in places)
            pieces = [(start, end) for start, end in ((0.0, first), (last, shape.length)) if end > start]
            left = [frozen(shapely.get_coordinates(substring(shape, *piece))) for piece in pieces]
            crack = frozen(shapely.get_coordinates(substring(shape, first, last)))
            return crack, (*left, *lines[:number], *lines[number + 1 :])
    return None


def _snapped(at: float, corners: Sequence[float], reach: float) -> float:
    """A place along a line (m), moved onto a corner of it that is within reach."""
    nearest = min(corners, key=lambda corner: abs(corner - at))
    return nearest if abs(nearest - at) <= reach else at
