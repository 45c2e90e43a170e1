"""The advance of cracks: which tips grow, and the new vertices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.case.model import Crack
from crackgrow.fracture.meeting import Meeting, first_met, other_crack, own_path, rims
from crackgrow.geometry.polyline import tip_direction

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

TIE = 1e-3
"""Tips whose criticality differs by less than this fraction, which is what the discretization resolves, are equally
critical: the first one grows. A symmetric scene then never depends on round-off."""

CLEARANCE = 0.1
"""Increments: a segment that comes this close to something has reached it. A path is not known more finely than that:
the segment is turned by 6 degrees at most. It is not a matter of the spacing: tips a thousandth of a spacing in front
of a crack or an outline were solved as well as others, without the integral for K."""


@dataclass(frozen=True, slots=True, eq=False)
class GrowingCrack:
    """A crack and the step in which each of its vertices was made (0: given)."""

    crack: Crack
    steps: Ints  # (n,)

    def can_grow(self, at_end: bool) -> bool:
        """Whether the tip at the end (or start) may advance."""
        return self.crack.tip_at_end if at_end else self.crack.tip_at_start

    def n_advances(self, at_end: bool) -> int:
        """How often the tip at the end (or start) has advanced."""
        given = np.flatnonzero(self.steps == 0)
        return int(len(self.steps) - 1 - given[-1] if at_end else given[0])


def growing_tips(criticality: Floats, n_advances: Ints, advance: Literal["most_critical", "in_turn", "all"]) -> Ints:
    """Numbers of the tips that grow, of those whose criticality (n,) is 1 or more.

    `all`: all of them; `most_critical`: the largest; `in_turn`: the largest of those that have advanced least often,
    `n_advances` (n,).
    """
    critical = np.flatnonzero(criticality >= 1.0)
    if advance == "all" or len(critical) == 0:
        return critical
    if advance == "in_turn":
        critical = critical[n_advances[critical] == n_advances[critical].min()]
    largest = criticality[critical].max()
    return np.asarray(critical[criticality[critical] >= largest * (1.0 - TIE)][:1])


def advanced(
    growing: GrowingCrack,
    at_end: bool,
    kink: float,
    increment: float,
    step: int,
    region: shapely.Polygon,
    others: Sequence[GrowingCrack] = (),
) -> tuple[GrowingCrack, Meeting | None]:
    """The crack with `increment` (m) added to a tip, turned by `kink` (rad), and what the tip has met.

    The new segment stays in `region` (m). It ends on the first of the region's rims, the `others` and its own path
    that it meets, and the crack has no tip there any more. The segment then is shorter than `increment`, or turned by
    up to CLEARANCE and longer by as much. An end of one of the `others` that is met is left as it is: see `closed`.
    """
    crack = growing.crack
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
