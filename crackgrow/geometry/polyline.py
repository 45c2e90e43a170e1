"""Open polylines: arc length, kinks, the way out of a body."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def arc_lengths(points: Floats) -> Floats:
    """Arc length of every vertex of a polyline `points` (n, 2): (n,), the first is 0."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def segment_directions(points: Floats) -> Floats:
    """Unit direction of every segment of a polyline `points` (n, 2): (n - 1, 2)."""
    steps = np.diff(points, axis=0)
    return np.asarray(steps / np.hypot(steps[:, 0], steps[:, 1])[:, None])


def kink_angles(points: Floats) -> Floats:
    """Signed turning angle at every inner vertex of `points` (n, 2): (n - 2,) radians, counter-clockwise positive."""
    t = segment_directions(points)
    cross = t[:-1, 0] * t[1:, 1] - t[:-1, 1] * t[1:, 0]
    return np.asarray(np.arctan2(cross, np.sum(t[:-1] * t[1:], axis=1)))


def tip_direction(points: Floats, at_end: bool) -> Floats:
    """Unit outward direction (2,) of the tip at the end (or start) of a polyline `points` (n, 2)."""
    step = points[-1] - points[-2] if at_end else points[0] - points[1]
    return np.asarray(step / np.hypot(*step))


def exit_point(region: shapely.Polygon, start: Floats, end: Floats) -> Floats | None:
    """Where the segment from `start` (2,), inside `region`, first meets its boundary; None if it stays inside."""
    hits = shapely.get_coordinates(shapely.intersection(shapely.linestrings([start, end]), region.boundary))
    if len(hits) == 0:
        return None
    distances = np.hypot(*(hits - start).T)
    return np.asarray(hits[int(np.argmin(distances))])
