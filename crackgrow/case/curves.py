"""Curved cracks: arcs and splines of the case file as the vertices of a path.

A crack is straight between its vertices. K of a tip goes by the direction of the last segment: one that is off by 1.4
degrees, as that of a half circle of 64 equal segments, puts K_I off by 3.6 %. So the last segments are tangents of the
curve, and those beside them shorter than in the middle. Segments there turn by so little that what ends on the curve
ends on them within the tolerance of a scene.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.report import Path
from crackgrow.case.scalars import Context
from crackgrow.case.shapes import Resolved

MOST_TURN: Final = np.deg2rad(1.0)  # rad, from one segment to the next in the middle of a curve
LEAST_TURN: Final = np.deg2rad(0.5)  # rad, at its ends: K of a half circle is within 1e-3
NEAR_END: Final = 0.1  # of its length: so near to an end segments turn by less, in proportion to the distance from it
STRAIGHT: Final = 0.01  # segments that a part of a curve would have: with less it is straight
FEWEST: Final = 3  # segments of an arc, or between two places of a spline
SAMPLES: Final = 4000  # steps along a curve at which its direction is taken
FEWEST_SAMPLES: Final = 20  # the same between two places of a spline


def curve_points(value: Resolved, path: Path, context: Context) -> object:
    """A path with vertices in the place of an arc or a spline."""
    if "arc" in value:
        key, arc = "arc", value["arc"]
        if not 0.0 < abs(arc["to"] - arc["from"]) < 360.0:
            message = f"from {arc['from']:g} to {arc['to']:g} deg given; wanted: angles that differ, by less than 360"
            return context.refused((*path, key), message)
        t = np.deg2rad(np.linspace(arc["from"], arc["to"], SAMPLES + 1))
        curve = np.array(arc["center"], dtype=float) + arc["radius"] * np.stack([np.cos(t), np.sin(t)], axis=1)
        places = np.array([0, SAMPLES])
    else:
        key, points = "spline", np.array(value["spline"], dtype=float).reshape(-1, 2)
        if len(points) < 3 or not np.hypot(*np.diff(points, axis=0).T).all():
            message = f"{len(points)} points given; wanted: three or more, no two of which in turn are the same"
            return context.refused((*path, key), message)
        curve, places = _spline(points)
    if not np.hypot(*np.diff(curve, axis=0).T).all():
        return context.refused((*path, key), "is too small for where it lies: its places are one after rounding")
    return {"points": [context.units.coordinates(point) for point in _vertices(curve, places).tolist()]}


def _spline(points: Floats) -> tuple[Floats, Ints]:
    """The cubic spline (m, 2) through points (n, 2), over the length of their chords, not a knot; where these lie."""
    from scipy.interpolate import CubicSpline  # here: loading it takes a time that other cases save

    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    steps = max(SAMPLES // (len(points) - 1), FEWEST_SAMPLES)
    at = np.linspace(along[:-1], along[1:], steps, endpoint=False).T.ravel()
    return np.asarray(CubicSpline(along, points)(np.append(at, along[-1]))), np.arange(len(points)) * steps


def _vertices(curve: Floats, places: Ints) -> Floats:
    """Vertices (n, 2) on a densely sampled curve; the samples `places`, of which its ends are two, are among them."""
    steps = np.diff(curve, axis=0)
    along = np.append(0.0, np.cumsum(np.hypot(*steps.T)))
    middle = 0.5 * (along[1:] + along[:-1]) / along[-1]
    turn = MOST_TURN * np.minimum(np.minimum(middle, 1.0 - middle) / NEAR_END, 1.0)
    direction = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    turned = np.abs(np.gradient(direction))
    segments = np.append(0.0, np.cumsum(turned / np.maximum(turn, LEAST_TURN)))
    parts = []
    for first, last in pairwise(places.tolist()):
        span = segments[last] - segments[first]
        n = max(int(np.ceil(span)), FEWEST) if span > STRAIGHT else 1
        inner = np.linspace(segments[first], segments[last], n + 1)[1:-1]
        parts.append(np.append(along[first], np.interp(inner, segments, along)))
    at = np.append(np.concatenate(parts), along[-1])
    found = np.stack([np.interp(at, along, coordinate) for coordinate in curve.T], axis=1)
    for part, end, beside, tangent in ((parts[0], 0, 1, steps[0]), (parts[-1], -1, -2, -steps[-1])):
        if len(part) > 1:
            length = np.hypot(*(found[beside] - found[end]))
            found[beside] = found[end] + length * tangent / np.hypot(*tangent)
    return found
