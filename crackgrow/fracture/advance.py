"""The advance of cracks: which tips grow, and the new vertices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Crack
from crackgrow.fracture.criteria import AT_STRENGTH
from crackgrow.fracture.meeting import Meeting, first_met, other_crack, own_path, rims
from crackgrow.geometry.polyline import tip_direction

TIE = 5e-3
"""Tips whose criticality differs by less than this fraction are equally critical: that is what a lattice resolves. The
two ends of one straight crack, which are equal by symmetry, differ by up to 0.16 % wherever it lies, grown at one end
or at both, by `max_hoop_stress`; by 0.2 % in the median of the other criteria, whose average sees the place in the
lattice. It is the only tolerance of which tip grows: the order of cracks in a file never matters."""

AS_FAR_LEFT = 1e-6
"""Of the extent of all tips: two that are as far to the left but for this are equally far."""

CLEARANCE = 0.1
"""Increments: a segment that comes this close to something has reached it. A path is not known more finely than that:
the segment is turned by 6 degrees at most. It is not a matter of the spacing: tips a thousandth of a spacing in front
of a crack or an outline were solved as well as others, without the integral for K."""


@dataclass(frozen=True, slots=True, eq=False)
class GrowingCrack:
    """A crack and the step in which each of its vertices was made (0: given)."""

    crack: Crack
    steps: Ints  # (n,)

    @classmethod
    def given(cls, crack: Crack) -> GrowingCrack:
        """A crack that has not grown."""
        return cls(crack, np.zeros(len(crack.points), dtype=np.int64))

    def can_grow(self, at_end: bool) -> bool:
        """Whether the tip at the end (or start) may advance."""
        return self.crack.tip_at_end if at_end else self.crack.tip_at_start

    def n_advances(self, at_end: bool) -> int:
        """How often the tip at the end (or start) has advanced."""
        given = np.flatnonzero(self.steps == 0)
        return int(len(self.steps) - 1 - given[-1] if at_end else given[0])


def growing_tips(
    criticality: Floats, n_advances: Ints, places: Floats, advance: Literal["most_critical", "in_turn", "all"]
) -> Ints:
    """Numbers of the tips that grow: of those whose criticality (n,) is 1 or more, or within TIE of such a one's.

    `all`: all of them, from left to right; `most_critical`: the largest; `in_turn`: the largest of those that have
    advanced least often, `n_advances` (n,). Of equally critical ones that which has advanced least often grows, of
    those the leftmost, of those the lowest, by their `places` (n, 2): what is left is the same by symmetry.
    """
    met = criticality[criticality >= 1.0 - 10.0 * AT_STRENGTH]
    if len(met) == 0:
        return np.empty(0, dtype=np.int64)
    critical = np.flatnonzero(criticality >= min(1.0 - 10.0 * AT_STRENGTH, (1.0 - TIE) * met.min()))
    apart = AS_FAR_LEFT * float(np.ptp(places, axis=0).max()) or 1.0
    critical = critical[np.lexsort((places[critical, 1], np.round(places[critical, 0] / apart)))]
    if advance == "all":
        return critical
    if advance == "in_turn":
        critical = _least_advanced(critical, n_advances)
    tied = critical[criticality[critical] >= (1.0 - TIE) * criticality[critical].max()]
    return _least_advanced(tied, n_advances)[:1]


def _least_advanced(tips: Ints, n_advances: Ints) -> Ints:
    return np.asarray(tips[n_advances[tips] == n_advances[tips].min()])


def advanced(
    growing: GrowingCrack,
    at_end: bool,
    way: tuple[float, float],
    step: int,
    region: shapely.Polygon,
    others: Sequence[GrowingCrack] = (),
) -> tuple[GrowingCrack, Meeting | None]:
    """The crack with a segment added to a tip, and what the tip has met; `way` is its kink (rad) and its length (m).

    The new segment stays in `region` (m). It ends on the first of the region's rims, the `others` and its own path
    that it meets, and the crack has no tip there any more. The segment then is shorter than that length, or turned by
    up to CLEARANCE and longer by as much. An end of one of the `others` that is met is left as it is: see `closed`.
    """
    crack, (kink, increment) = growing.crack, way
    direction = tip_direction(crack.points, at_end)
    c, s = np.cos(kink), np.sin(kink)
    tip = crack.points[-1] if at_end else crack.points[0]
    new = tip + increment * np.array([c * direction[0] - s * direction[1], s * direction[0] + c * direction[1]])
    clearance = CLEARANCE * increment
    obstacles = [other_crack(number, other.crack.points) for number, other in enumerate(others)]
    obstacles += [own_path(crack.points, at_end, 2.0 * clearance), *rims(region)]
    met = first_met(tip, new, obstacles, clearance)
    end = new if met is None else met.point
    points = np.vstack([crack.points, end]) if at_end else np.vstack([end, crack.points])
    steps = np.append(growing.steps, step) if at_end else np.insert(growing.steps, 0, step)
    longer = GrowingCrack(replace(crack, points=points), steps)
    if met is not None:
        longer = closed(longer, at_end)
        if met.kind == "own_path" and met.end is not None:
            longer = closed(longer, met.end)
    return longer, met


def closed(growing: GrowingCrack, at_end: bool) -> GrowingCrack:
    """The crack without a tip at its end (or start)."""
    crack = growing.crack
    return replace(growing, crack=replace(crack, tip_at_end=False) if at_end else replace(crack, tip_at_start=False))
