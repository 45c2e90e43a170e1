"""Bodies that share a boundary: common corners, the shared lines, and overlaps."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.segments import distances
from crackgrow.case.shapes import BodyShape, frozen


def close_pairs(bodies: list[BodyShape], tolerance: float) -> list[tuple[int, int]]:
    """Return the pairs of bodies that come within the tolerance, in order."""
    polygons = np.array([body.polygon for body in bodies], dtype=object)
    first, second = shapely.STRtree(polygons).query(polygons, predicate="dwithin", distance=tolerance)
    return sorted((int(a), int(b)) for a, b in zip(first, second, strict=True) if a < b)


def overlap(first: BodyShape, second: BodyShape, tolerance: float) -> Floats | None:
    """Return a point `(2,) float` of a common part that is wider than the tolerance, None if there is none."""
    common = first.polygon.intersection(second.polygon)
    for part in shapely.get_parts(common):
        if part.area > tolerance * part.length:  # of a thin part of width w and length l: w l > tolerance 2 (w + l)
            return np.array(part.representative_point().coords[0])
    return None


def shared_lines(first: BodyShape, second: BodyShape, tolerance: float) -> tuple[Floats, ...]:
    """Return the boundary that two bodies share: open polylines `(n, 2) float`, the first body on their left.

    They have a vertex at every corner of both; a closed one comes as two. Sides count as shared where they lie
    within the tolerance of each other over a positive length.
    """
    others = second.sides
    tree = shapely.STRtree(shapely.linestrings(others))
    lines: list[list[Floats]] = []
    for ring in first.rings:
        ends = np.stack([ring.points, np.roll(ring.points, -1, axis=0)], axis=1)
        near, candidates = tree.query(shapely.linestrings(ends), predicate="dwithin", distance=tolerance)
        pieces: list[tuple[Floats, Floats]] = []
        for side in np.unique(near):
            pieces += _pieces(ends[side], others[candidates[near == side]], tolerance)
        lines += _chained(pieces, tolerance)
    return tuple(frozen(line) for line in lines)


def _pieces(side: Floats, others: Floats, tolerance: float) -> list[tuple[Floats, Floats]]:
    """Return the parts of a side `(2, 2)` that lie on other sides `(k, 2, 2)`, in its order."""
    along = side[1] - side[0]
    length = float(np.hypot(*along))
    found = []
    for other in others:
        # Where the other side's ends project to; they run against the side, with their body on the other hand.
        t = (other - side[0]) @ along / length**2
        low, high = sorted(zip(t.tolist(), other, strict=True), key=lambda end: end[0])
        start = (0.0, side[0]) if low[0] * length <= tolerance else low
        end = (1.0, side[1]) if high[0] * length >= length - tolerance else high
        if (end[0] - start[0]) * length <= tolerance:
            continue
        if (distances(side[0] + np.outer([start[0], end[0]], along), np.stack([other, other])) <= tolerance).all():
            found.append((start, end))
    found.sort(key=lambda piece: piece[0][0])
    return [(start[1], end[1]) for start, end in found]


def _chained(pieces: list[tuple[Floats, Floats]], tolerance: float) -> list[list[Floats]]:
    """Join the pieces along one ring, in its order, to polylines; a closed one is halved."""
    chains: list[list[Floats]] = []
    for start, end in pieces:
        if chains and np.hypot(*(start - chains[-1][-1])) <= tolerance:
            chains[-1].append(end)
        else:
            chains.append([start, end])
    if not chains or np.hypot(*(chains[-1][-1] - chains[0][0])) > tolerance:
        return chains
    if len(chains) > 1:  # the ring begins inside of a shared line
        return [chains[-1] + chains[0][1:], *chains[1:-1]]
    closed = [*chains[0][:-1], chains[0][0]]
    lengths = np.cumsum([0.0, *(float(np.hypot(*(b - a))) for a, b in pairwise(closed))])
    middle = int(np.argmin(np.abs(lengths - lengths[-1] / 2)))
    return [closed[: middle + 1], closed[middle:]]
