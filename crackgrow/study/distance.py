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
from crackgrow.vectors import cross

RESOLUTION = 1e-7  # of the extent: how exactly a distance and its place are found
EMPTY = np.array([2.0, -1.0])  # an interval of no point: low, high
SAMPLES = 1000  # places along a line that are looked at first
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
    """The Frechet distance of two polylines, m: the shortest leash with which both are walked from start to end.

    Decided by the free-space diagram (Alt and Godau 1995, doi 10.1142/S0218195995000064) and found by bisection, to
    RESOLUTION. It is at least the Hausdorff distance and the distances of the starts and of the ends.
    """
    apart = np.hypot(*(a[:, None, :] - b[None, :, :]).transpose(2, 0, 1))
    if min(apart.shape) == 1:  # a point and a line: the farthest vertex
        return float(apart.max())
    low = max(float(apart[0, 0]), float(apart[-1, -1]), farthest(a, b)[0], farthest(b, a)[0])
    tolerance = RESOLUTION * extent(a, b)
    if _walkable(a, b, low + 2 * tolerance):
        return low
    high = float(apart.max())
    while high - low > tolerance:
        middle = (low + high) / 2
        low, high = (low, middle) if _walkable(a, b, middle) else (middle, high)
    return high


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
    slack = RESOLUTION * extent(line, other)

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


def extent(*lines: Floats) -> float:
    """The longer side of the box round polylines, m."""
    points = np.concatenate(lines)
    return float(np.ptp(points, axis=0).max())


def _geometry(line: Floats) -> shapely.LineString:
    """A polyline as shapely has it; a single point as a line of no length."""
    return shapely.LineString(line if len(line) > 1 else np.repeat(line, 2, axis=0))


def _walkable(a: Floats, b: Floats, leash: float) -> bool:
    """Whether both polylines can be walked from start to end, never back, at most `leash` apart; their ends are so.

    Cell (i, j) of the free-space diagram is segment i of `a` by segment j of `b`; on a border of it the free interval
    is (low, high), empty where low > high. Cells of one anti-diagonal don't depend on each other.
    """
    n, m = len(a) - 1, len(b) - 1
    left = _free(a, b, leash)  # (2, n + 1, m): vertex i of a, along segment j of b
    bottom = _free(b, a, leash).transpose(0, 2, 1)  # (2, n, m + 1): vertex j of b, along segment i of a
    _keep_reached_from_start(left[:, 0, :])
    _keep_reached_from_start(bottom[:, :, 0])
    for diagonal in range(n + m - 1):
        i = np.arange(max(0, diagonal - m + 1), min(n, diagonal + 1))
        j = diagonal - i
        from_left, from_bottom = left[:, i, j], bottom[:, i, j]
        left[:, i + 1, j] = _reached(left[:, i + 1, j], from_left, from_bottom)
        bottom[:, i, j + 1] = _reached(bottom[:, i, j + 1], from_bottom, from_left)
    low, high = left[:, n, m - 1]
    return bool(low <= high)  # and so to the end: the ends are within the leash


def _free(points: Floats, line: Floats, leash: float) -> Floats:
    """Where the segments of `line` are within `leash` of each point: low and high (2, n, m) from 0 to 1.

    Where they are nowhere, it is EMPTY.
    """
    along = np.diff(line, axis=0)
    length_sq = np.sum(along**2, axis=1)
    offset = points[:, None, :] - line[:-1]
    foot = np.sum(offset * along, axis=2) / length_sq
    height_sq = cross(offset, along) ** 2 / length_sq
    half = np.sqrt(np.maximum(leash**2 - height_sq, 0.0) / length_sq)
    low, high = np.maximum(foot - half, 0.0), np.minimum(foot + half, 1.0)
    return np.where((height_sq <= leash**2) & (low <= high), np.stack([low, high]), EMPTY[:, None, None])


def _keep_reached_from_start(border: Floats) -> None:
    """Empty the intervals (2, k) of an outer border that a walk along it from its start doesn't reach, in place."""
    reached = np.logical_and.accumulate(border[0] == 0.0)
    border[:, ~reached] = EMPTY[:, None]


def _reached(free: Floats, opposite: Floats, adjacent: Floats) -> Floats:
    """What of a border's free interval (2, k) is reached from the opposite and the adjacent border of its cell.

    Free space within a cell is convex: from the adjacent border all of it, from the opposite one what isn't back.
    """
    low = np.maximum(free[0], opposite[0])
    ahead = np.where(low <= free[1], np.stack([low, free[1]]), EMPTY[:, None])
    ahead = np.where(opposite[0] <= opposite[1], ahead, EMPTY[:, None])
    return np.where(adjacent[0] <= adjacent[1], free, ahead)
