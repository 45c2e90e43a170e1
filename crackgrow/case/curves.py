"""Curved cracks: arcs and splines of the case file as the vertices of a path.

A crack is straight between its vertices. K of a tip goes by the direction of the last segment: one that is off by 1.4
degrees, as that of a half circle of 64 equal segments, puts K_I off by 3.6 %. So the last segments are tangents of the
curve, and those beside them shorter than in the middle.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.report import Path
from crackgrow.case.scalars import Context

MOST_TURN: Final = np.deg2rad(3.0)
"""rad, from one segment to the next in the middle of a curve."""

LEAST_TURN: Final = np.deg2rad(1.0)
"""rad, at its ends: K of a half circle is within 5e-4."""

NEAR_END: Final = 0.1
"""Of the length of a curve: within that of an end segments turn by less, in proportion to the distance."""

SAMPLES: Final = 4001
"""Places on a curve at which its direction is taken."""


def with_curve_points(value: object, path: Path, context: Context) -> object:
    """A path with vertices in the place of an arc or a spline."""
    if not isinstance(value, dict) or not ({"arc", "spline"} & value.keys()):
        return value
    if "arc" in value:
        arc = value["arc"]
        turn = arc["to"] - arc["from"]
        if not 0.0 < abs(turn) < 360.0:
            message = f"from {arc['from']:g} to {arc['to']:g} deg given; wanted: angles that differ by less than 360"
            return context.refused((*path, "arc"), message)
        t = np.deg2rad(np.linspace(arc["from"], arc["to"], SAMPLES))
        curve = np.array(arc["center"], dtype=float) + arc["radius"] * np.stack([np.cos(t), np.sin(t)], axis=1)
    else:
        points = np.array(value["spline"], dtype=float).reshape(-1, 2)
        if len(points) < 3 or not np.hypot(*np.diff(points, axis=0).T).all():
            message = f"{len(points)} points given; wanted: three or more, no two of which in turn are the same"
            return context.refused((*path, "spline"), message)
        curve = _spline(points)
    return {"points": [context.units.coordinates(point) for point in _vertices(curve).tolist()]}


def _spline(points: Floats) -> Floats:
    """The cubic spline (SAMPLES, 2) through points (n, 2), over the length of their chords, not a knot."""
    from scipy.interpolate import CubicSpline  # here: loading it takes a time that other cases save

    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    return np.asarray(CubicSpline(along, points)(np.linspace(0.0, along[-1], SAMPLES)))


def _vertices(curve: Floats) -> Floats:
    """Vertices (n, 2) on a densely sampled curve, both of its ends among them."""
    steps = np.diff(curve, axis=0)
    along = np.append(0.0, np.cumsum(np.hypot(*steps.T)))
    middle = 0.5 * (along[1:] + along[:-1]) / along[-1]
    turn = MOST_TURN * np.minimum(np.minimum(middle, 1.0 - middle) / NEAR_END, 1.0)
    direction = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    turned = np.abs(np.gradient(direction))
    segments = np.append(0.0, np.cumsum(turned / np.maximum(turn, LEAST_TURN)))
    n = max(int(np.ceil(segments[-1])), 1)
    at = np.interp(np.linspace(0.0, segments[-1], n + 1), segments, along) if segments[-1] > 0.0 else along[[0, -1]]
    found = np.stack([np.interp(at, along, coordinate) for coordinate in curve.T], axis=1)
    if n > 2:
        for end, beside, tangent in ((0, 1, steps[0]), (-1, -2, -steps[-1])):
            length = np.hypot(*(found[beside] - found[end]))
            found[beside] = found[end] + length * tangent / np.hypot(*tangent)
    return found
