"""The advance of cracks: which tips grow, and the new vertices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.ops import substring

from crackgrow.case.model import Crack
from crackgrow.errors import GeometryError
from crackgrow.geometry.polyline import exit_point, tip_direction

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

TIE = 1e-3
"""Tips whose criticality differs by less than this fraction, which is what the discretization resolves, are equally
critical: the first one grows. A symmetric scene then never depends on round-off."""

CLEARANCE = 0.1
"""A new segment that comes closer to a crack than this fraction of its length meets it."""


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
) -> tuple[GrowingCrack, bool]:
    """The crack with `increment` (m) added to a tip, turned by `kink` (rad), and whether it has left `region`.

    A segment that would leave the region (m) ends on its boundary, and the crack has no tip there any more. Raises
    GeometryError where the new segment would meet the crack itself or one of the `others`.
    """
    crack = growing.crack
    direction = tip_direction(crack.points, at_end)
    c, s = np.cos(kink), np.sin(kink)
    tip = crack.points[-1] if at_end else crack.points[0]
    new = tip + increment * np.array([c * direction[0] - s * direction[1], s * direction[0] + c * direction[1]])
    on_boundary = exit_point(region, tip, new)
    end = new if on_boundary is None else on_boundary
    segment = shapely.LineString([tip, end])
    behind = _behind(crack.points[::-1] if at_end else crack.points, 2.0 * CLEARANCE * increment)
    lines = [(f"crack '{other.crack.name}'", shapely.LineString(other.crack.points)) for other in others]
    for name, line in [*lines, ("itself", behind)]:
        if shapely.dwithin(segment, line, CLEARANCE * increment):
            x, y = shapely.shortest_line(segment, line).coords[1]
            raise GeometryError(
                f"step {step}: crack '{crack.name}' would meet {name} near ({x:.4g}, {y:.4g}) m; "
                "cracks that meet are not supported in this version"
            )
    points = np.vstack([crack.points, end]) if at_end else np.vstack([end, crack.points])
    steps = np.append(growing.steps, step) if at_end else np.insert(growing.steps, 0, step)
    tip_left = on_boundary is None
    longer = replace(
        crack,
        points=points,
        tip_at_start=crack.tip_at_start if at_end else tip_left,
        tip_at_end=tip_left if at_end else crack.tip_at_end,
    )
    return GrowingCrack(longer, steps), not tip_left


def _behind(points_from_tip: Floats, length: float) -> shapely.LineString:
    """A crack (n, 2), from its tip on, without the first `length` of it; empty where it is no longer than that."""
    line = shapely.LineString(points_from_tip)
    return substring(line, length, line.length) if length < line.length else shapely.LineString()
