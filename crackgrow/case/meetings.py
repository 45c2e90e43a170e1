"""Where the cracks of a case cross, touch and branch."""

from __future__ import annotations

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.layout import ON_OUTLINE
from crackgrow.case.model import Case
from crackgrow.case.segments import close_segments, places_between, segments_of
from crackgrow.case.snapping import size_of

SAME_MEETING = 10.0  # places nearer than so many tolerances are one: each lies within the tolerance of its cracks


def meeting_places(case: Case) -> Floats:
    """Return the places `(k, 2) float` in m where two or more cracks meet."""
    tolerance = ON_OUTLINE * scene_size(case)
    segments = segments_of([crack.points for crack in case.cracks])
    pairs = close_segments(segments, tolerance)
    pairs = pairs[segments.lines[pairs[:, 0]] != segments.lines[pairs[:, 1]]]
    places = places_between(segments, pairs)
    if not len(places):
        return places
    points = shapely.points(places)
    same = shapely.STRtree(points).query(points, predicate="dwithin", distance=SAME_MEETING * tolerance)
    first = np.arange(len(places))  # the first place that each is known to be one with
    while True:
        least = first.copy()
        np.minimum.at(least, same[0], first[same[1]])
        if np.array_equal(least, first):
            return places[np.unique(first)]
        first = least


def scene_size(case: Case) -> float:
    """Return the diameter of the least circle round all bodies in m."""
    return size_of(np.concatenate([body.outline for body in case.bodies]))
