"""Distances between polylines: Hausdorff with its place, Frechet, and the part that two of them have in common.

All are those of the continuous curves: vertices that lie elsewhere on the same line change nothing.
Polylines are (n, 2) float, m; a single point, (1, 2), is a polyline of no length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.vectors import cross

RESOLUTION = 1e-7  # of the extent: how exactly a distance and its place are found
EMPTY = np.array([2.0, -1.0])  # an interval of no point: low, high
ROUNDING = 1e-13  # of the largest coordinate: distances below are those of equal points


@dataclass(frozen=True, slots=True, eq=False)
class Farthest:
    """The point of one polyline that is farthest from another, and the point there that is nearest to it."""

    distance: float  # m
    s: float  # m, arc length on the one
    near_s: float  # m, arc length on the other


def nearest(points: Floats, line: Floats) -> tuple[Floats, Floats]:
    """Distance of each of `points` (n, 2) from a polyline, and the arc length of its nearest point there: (n,), (n,).

    Of several nearest points it is the first.
    """
    distance, t = _to_segments(points, *_segments(line))
    best = np.argmin(distance, axis=1)
    rows = np.arange(len(points))
    s = arc_lengths(line)
    lengths = np.diff(s) if len(line) > 1 else np.zeros(1)
    return _clean(distance[rows, best], line), s[best] + t[rows, best] * lengths[best]


def farthest(a: Floats, b: Floats) -> Farthest:
    """The point of `a` that is farthest from `b`: the directed Hausdorff distance, max over a of min over b.

    Along a piece of `a` the distance from one segment j of `b` is convex, so the distance from `b` is at most
    min_j max(d_j(start), d_j(end)) there. Pieces that may hold more than the largest distance found are halved until
    none is left, to RESOLUTION.
    """
    tolerance = RESOLUTION * extent(a, b)
    starts, ends = _segments(b)
    low, high = arc_lengths(a)[:-1], arc_lengths(a)[1:]
    if len(a) == 1:
        low = high = np.zeros(1)
    at_low, at_high = (_to_segments(point_at(a, s), starts, ends)[0] for s in (low, high))
    best, best_s = -1.0, 0.0
    while len(low):
        for s, distances in ((low, at_low.min(axis=1)), (high, at_high.min(axis=1))):
            top = int(np.argmax(distances))
            if distances[top] > best:
                best, best_s = float(distances[top]), float(s[top])
        bound = np.minimum.reduce(np.maximum(at_low, at_high), axis=1)
        open_ = (bound > best + tolerance) & (high - low > tolerance)
        low, high, at_low, at_high = low[open_], high[open_], at_low[open_], at_high[open_]
        middle = (low + high) / 2
        at_middle = _to_segments(point_at(a, middle), starts, ends)[0]
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        at_low, at_high = np.concatenate([at_low, at_middle]), np.concatenate([at_middle, at_high])
    distance, near_s = nearest(point_at(a, np.array([best_s])), b)
    return Farthest(float(distance[0]), best_s, float(near_s[0]))


def frechet(a: Floats, b: Floats) -> float:
    """The Frechet distance of two polylines, m: the shortest leash with which both are walked from start to end.

    Decided by the free-space diagram (Alt and Godau 1995, doi 10.1142/S0218195995000064) and found by bisection, to
    RESOLUTION. It is at least the Hausdorff distance and the distances of the starts and of the ends.
    """
    apart = np.hypot(*(a[:, None, :] - b[None, :, :]).transpose(2, 0, 1))
    if min(apart.shape) == 1:  # a point and a line: the farthest vertex
        return float(_clean(apart.max(keepdims=True), a)[0, 0])
    low = max(float(apart[0, 0]), float(apart[-1, -1]), farthest(a, b).distance, farthest(b, a).distance)
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
    low, high = min(s_from, s_to), max(s_from, s_to)
    s = arc_lengths(line)
    inner = line[(s > low) & (s < high)]
    part = np.concatenate([point_at(line, np.array([low])), inner, point_at(line, np.array([high]))])
    part = part if s_from <= s_to else part[::-1]
    kept = np.concatenate([[True], np.hypot(*np.diff(part, axis=0).T) > 0])
    return np.asarray(part[kept])


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


def _segments(line: Floats) -> tuple[Floats, Floats]:
    """Starts and ends (m, 2) of the segments; a single point is a segment of no length."""
    return (line[:-1], line[1:]) if len(line) > 1 else (line, line)


def _to_segments(points: Floats, starts: Floats, ends: Floats) -> tuple[Floats, Floats]:
    """Distances (n, m) of points from segments, and where on each segment the nearest point is, 0 to 1."""
    along = ends - starts
    length_sq = np.sum(along**2, axis=1)
    offset = points[:, None, :] - starts
    t = np.sum(offset * along, axis=2) / np.where(length_sq > 0, length_sq, 1.0)
    t = np.clip(t, 0.0, 1.0)
    away = offset - t[:, :, None] * along
    return np.hypot(away[:, :, 0], away[:, :, 1]), t


def _clean(distance: Floats, line: Floats) -> Floats:
    return np.asarray(np.where(distance > ROUNDING * np.abs(line).max(), distance, 0.0))


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
