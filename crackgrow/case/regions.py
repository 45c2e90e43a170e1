"""From a named edge, or a part of one, to sides of the body's rings.

A part begins and ends at a length on most edges, at an angle on arcs: only the edge tells which.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints, frozen
from crackgrow.case.scalars import Context, Numeric
from crackgrow.case.shapes import BodyShape, Resolved
from crackgrow.case.units import UNITS, QuantityError, parse_quantity

Measure = Literal["x", "y", "distance", "angle"]  # what tells a place on an edge
FULL_CIRCLE = 360.0  # degrees
SAME_PLACE = 1e-9  # parts of a side shorter than this part of it are none


@dataclass(frozen=True, slots=True, eq=False)
class EdgeRegion:
    """A named edge of a body, or a part of it: sides of its rings, each from one fraction of its length to another."""

    body: str
    edge: str
    sides: Ints  # (k,) numbers of the body's sides, in order along the ring
    limits: Floats  # (k, 2) where the part begins and ends on each of them: 0 at its first corner, 1 at its second

    def holds(self, side: Ints, share: Floats) -> Bools:
        """Which places (n,) on sides of the body, at shares of their lengths, lie on it."""
        order = np.argsort(self.sides, kind="stable")
        first, last = (np.searchsorted(self.sides[order], side, at) for at in ("left", "right"))  # parts of each side
        found = np.zeros(len(side), dtype=bool)
        for part in range(int(np.max(last - first, initial=0))):
            there = np.flatnonzero(first + part < last)
            low, high = self.limits[order[first[there] + part]].T
            found[there] |= (low <= share[there]) & (share[there] <= high)
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """The sides under one name, in the order in which they were drawn."""

    sides: tuple[int, ...]  # numbers of the body's sides
    ends: Floats  # (k, 2, 2) m, first and second corner of each as drawn
    drawn: Ints  # (k,) number of the drawn side that each is, or is a part of
    backwards: bool  # whether the stored sides run the other way
    measure: Measure
    reach: tuple[float, float]  # m or degrees, least and largest place

    @property
    def lengths(self) -> Floats:
        """Lengths (k,) m of the sides."""
        return np.asarray(np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T))

    def along(self, place: float) -> float:
        """Distance (m) from the begin of the edge, as drawn, to a place (m or degrees); it grows from turn to turn."""
        if self.measure == "distance":
            return place
        begins = np.append(0.0, np.cumsum(self.lengths))
        if self.measure == "angle":
            chords = np.append(np.flatnonzero(np.append(True, self.drawn[1:] != self.drawn[:-1])), len(self.sides))
            step = FULL_CIRCLE / (len(chords) - 1)
            turn, chord = divmod(math.floor(place / step), len(chords) - 1)
            half = math.radians(step) / 2
            part = 0.5 + math.tan((2.0 * (place / step % 1.0) - 1.0) * half) / math.tan(half) / 2  # of the chord
            first, last = begins[chords[chord : chord + 2]]
            return float(turn * begins[-1] + first + part * (last - first))
        axis = "xy".index(self.measure)
        first, last = self.ends[0, 0, axis], self.ends[-1, 1, axis]
        return float((place - first) / (last - first) * begins[-1])

    def parts(self, start: float, end: float) -> list[tuple[int, float, float]]:
        """The sides between two distances (m) along it, each with the fractions at which its part begins and ends.

        Fractions hardly more than 0 or less than 1 are these.
        """
        total, found = self.lengths.sum(), []
        for turn in range(math.floor(start / total), math.ceil(end / total)) if self.measure == "angle" else (0,):
            passed = turn * total
            for side, length in zip(self.sides, self.lengths.tolist(), strict=True):
                limits = ((start - passed) / length, (end - passed) / length)
                low, high = (0.0 if t <= SAME_PLACE else 1.0 if t >= 1.0 - SAME_PLACE else t for t in limits)
                found += [(side, low, high)] if high > low else []
                passed += length
        return found


def edge_of(body: BodyShape, name: str, tolerance: float) -> Edge:
    """Return the edge of a body that has one of that name."""
    number = next(k for k, ring in enumerate(body.rings) if name in ring.edge_names)
    ring, first_side = body.rings[number], sum(len(ring.points) for ring in body.rings[:number])
    n = len(ring.points)
    ends = ring.sides
    given = np.stack([ring.given, np.roll(ring.given, -1, axis=0)], axis=1)[ring.drawn]
    ids = np.arange(n)
    if ring.backwards:
        ends, given, ids = ends[::-1, ::-1], given[::-1, ::-1], ids[::-1]
    has_name = np.array(ring.edge_names)[ids] == name
    starts = np.flatnonzero(has_name & ~np.roll(has_name, 1))
    order = np.roll(np.arange(n), -int(starts[0])) if len(starts) else np.arange(n)
    order = order[has_name[order]]
    drawn = ring.drawn[ids[order]]
    first_parts = np.append(True, drawn[1:] != drawn[:-1])
    measure, reach = _measure(ends[order], given[order][first_parts], ring.is_arc, tolerance)
    return Edge(tuple((first_side + ids[order]).tolist()), ends[order], drawn, ring.backwards, measure, reach)


def region_of(body: BodyShape, edge: Edge, on: Resolved) -> EdgeRegion:
    """Return the part of an edge between the places `from` and `to` of `on` (m, degrees on an arc), which lie on it."""
    places = (on.get("from", edge.reach[0]), on.get("to", edge.reach[1]))
    parts = edge.parts(*sorted(map(edge.along, places)))
    if edge.backwards:
        parts = [(side, 1.0 - end, 1.0 - start) for side, start, end in reversed(parts)]
    sides = np.array([side for side, *_ in parts], dtype=np.int64)
    sides.setflags(write=False)
    return EdgeRegion(body.name, on["edge"], sides, frozen([limits for _, *limits in parts]))


def ends_of(body: BodyShape, region: EdgeRegion) -> Floats:
    """Return both ends `(k, 2, 2) float` in m of the region's part of every side."""
    start, end = np.moveaxis(body.sides[region.sides], 1, 0)
    return np.asarray(start[:, None] + region.limits[:, :, None] * (end - start)[:, None], dtype=float)


def _measure(ends: Floats, given: Floats, is_arc: bool, tolerance: float) -> tuple[Measure, tuple[float, float]]:
    """Return what tells a place on an edge, which was drawn as sides `given` (m, 2, 2), and its range."""
    if is_arc:
        return "angle", (0.0, FULL_CIRCLE)
    width, height = np.abs(given[-1, 1] - given[0, 0])
    low, high = np.sort([ends[0, 0], ends[-1, 1]], axis=0)
    if len(given) == 1 and height <= tolerance:
        return "x", (float(low[0]), float(high[0]))
    if len(given) == 1 and width <= tolerance:
        return "y", (float(low[1]), float(high[1]))
    return "distance", (0.0, float(np.hypot(*(ends[:, 1] - ends[:, 0]).T).sum()))


class PlaceOnEdge(Numeric):
    """A length or an angle, as text: which of them a bare number is, the edge tells."""

    def describe(self) -> str:
        return "a length, or an angle on an arc"

    def hint(self, context: Context) -> str:
        named = " | ".join((*UNITS["length"], *UNITS["angle"]))
        return f" ({named}; a bare number means {context.units.length} or deg)"

    def parse(self, text: str, context: Context) -> str:
        """The text; raises QuantityError where it is neither of them."""
        try:
            parse_quantity(text, "length", context.units)
        except QuantityError:
            parse_quantity(text, "angle", context.units)
        return text
