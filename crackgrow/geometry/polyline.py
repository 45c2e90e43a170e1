"""Open polylines: arc length, kinks, where they are hit."""

from __future__ import annotations

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.geometry.tolerance import SAME_PART
from crackgrow.vectors import cross


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
    return np.asarray(np.arctan2(cross(t[:-1], t[1:]), np.sum(t[:-1] * t[1:], axis=1)))


def tip_direction(points: Floats, at_end: bool) -> Floats:
    """Unit outward direction (2,) of the tip at the end (or start) of a polyline `points` (n, 2)."""
    step = points[-1] - points[-2] if at_end else points[0] - points[1]
    return np.asarray(step / np.hypot(*step))


def first_hit(line: shapely.Geometry, start: Floats, end: Floats) -> Floats | None:
    """Where the segment from `start` to `end` (2,) first meets `line`, (2,); None if it does not.

    Where it begins on the line, that is no place where it meets it.
    """
    segment = shapely.linestrings([start, end])
    hits = shapely.get_coordinates(shapely.intersection(segment, line))
    distances = np.hypot(*(hits - start).T)
    hits, distances = hits[distances > SAME_PART * segment.length], distances[distances > SAME_PART * segment.length]
    return np.asarray(hits[int(np.argmin(distances))]) if len(hits) else None
