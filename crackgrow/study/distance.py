"""Distances between polylines: Hausdorff with its place, Frechet, and the part that two of them have in common.

All are those of the continuous curves: vertices that lie elsewhere on the same line change nothing.
Polylines are (n, 2) float, m; a single point, (1, 2), is a polyline of no length.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.ops import substring

from crackgrow.arrays import Floats
from crackgrow.geometry.polyline import arc_lengths

RESOLUTION = 1e-7  # of the extent: how exactly a distance and its place are found
SAMPLES = 1000  # places along a line that are looked at first
WALKED = 500  # places of both lines that are walked through, besides vertices
ROUNDING = 1e-13  # of the largest coordinate: distances below are those of equal points


def nearest(points: Floats, line: Floats) -> tuple[Floats, Floats]:
    """Distance of each of `points` (n, 2) from a polyline, and the arc length of its nearest point there: (n,), (n,).

    Of several nearest points it is the first.
    """
    other, places = _geometry(line), shapely.points(points)
    distance = shapely.distance(places, other)
    s = shapely.line_locate_point(other, places) if len(line) > 1 else np.zeros(len(points))
    return np.where(distance > ROUNDING * np.abs(line).max(), distance, 0.0), s


def farthest(a: Floats, b: Floats) -> tuple[float, float, float]:
    """The directed Hausdorff distance, max over a of min over b, and the arc lengths of its place on `a` and on `b`, m.

    It is looked for at the vertices and at places between, then between the neighbours of the best, to RESOLUTION: on
    random walks of up to 60 segments, of which several may hold it, within 4e-5 of their extent.
    """
    along = arc_lengths(a)
    s = np.union1d(along, np.linspace(0.0, along[-1], SAMPLES))
    while True:
        distance, near_s = nearest(point_at(a, s), b)
        best = int(np.argmax(distance))
        low, high = s[max(best - 1, 0)], s[min(best + 1, len(s) - 1)]
        if high - low <= RESOLUTION * along[-1]:
            return float(distance[best]), float(s[best]), float(near_s[best])
        s = np.union1d(s[best], np.linspace(low, high, SAMPLES))


def frechet(a: Floats, b: Floats) -> float:
    """Return the discrete Frechet distance (m) of two polylines (n, 2) and (k, 2) m.

    Both are sampled at WALKED equal parts of their lengths and at all vertices of either (Eiter and Mannila 1994,
    Computing discrete Frechet distance). It is too large by less than the distance of two samples, and by 2e-4 of
    itself on random walks of 12 segments.
    """
    along_a, along_b = arc_lengths(a), arc_lengths(b)
    if not min(along_a[-1], along_b[-1]) > 0.0:  # a point and a line: the farthest vertex
        return float(np.hypot(*(a[:, None, :] - b[None, :, :]).transpose(2, 0, 1)).max())
    parts = np.union1d(np.linspace(0.0, 1.0, WALKED), np.concatenate([along_a / along_a[-1], along_b / along_b[-1]]))
    p, q = point_at(a, parts * along_a[-1]), point_at(b, parts * along_b[-1])
    leash = float(shapely.frechet_distance(shapely.LineString(p), shapely.LineString(q)))
    return leash if leash > ROUNDING * max(np.abs(a).max(), np.abs(b).max()) else 0.0


def between(line: Floats, s_from: float, s_to: float) -> Floats:
    """The part of a polyline between two arc lengths, walked from the first to the second."""
    part: Floats = shapely.get_coordinates(substring(_geometry(line), s_from, s_to))
    return np.asarray(part[np.concatenate([[True], np.any(np.diff(part, axis=0) != 0.0, axis=1)])])


def overhang(line: Floats, other: Floats, *, at_both: bool) -> float:
    """Arc length of `line` from which on, to its end, the nearest point of `other` is its end; the length if nowhere.

    So far the two run side by side; from there `line` goes on beyond the other. With `at_both` the other's start
    counts as an end of it too. It is 0 where the whole of `line` is beyond.
    """
    s = arc_lengths(line)
    length = float(arc_lengths(other)[-1])
    slack = RESOLUTION * float(np.ptp(np.concatenate([line, other]), axis=0).max())

    def beyond(at: Floats) -> NDArray[np.bool_]:
        _, near_s = nearest(point_at(line, at), other)
        return (near_s >= length - slack) | (at_both & (near_s <= slack))

    inside = np.flatnonzero(~beyond(s))
    if len(inside) == 0:
        return 0.0
    if inside[-1] == len(line) - 1:
        return float(s[-1])
    low, high = float(s[inside[-1]]), float(s[inside[-1] + 1])
    while high - low > slack:
        middle = (low + high) / 2
        low, high = (low, middle) if beyond(np.array([middle]))[0] else (middle, high)
    return high


def point_at(line: Floats, s: Floats) -> Floats:
    """Points (k, 2) of a polyline at arc lengths `s` (k,)."""
    along = arc_lengths(line)
    return np.column_stack([np.interp(s, along, line[:, 0]), np.interp(s, along, line[:, 1])])


def _geometry(line: Floats) -> shapely.LineString:
    """A polyline as shapely has it; a single point as a line of no length."""
    return shapely.LineString(line if len(line) > 1 else np.repeat(line, 2, axis=0))
