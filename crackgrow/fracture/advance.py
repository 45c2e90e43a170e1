"""The advance of cracks: which tips grow, and the new vertices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.case.model import Crack
from crackgrow.fracture.criteria import AT_STRENGTH
from crackgrow.fracture.meeting import Meeting, Obstacle, first_met, other_crack, own_path, rims
from crackgrow.geometry.polyline import tip_direction

TIE = 5e-3
"""Tips whose criticality differs by less than this fraction are equally critical: that is what a lattice resolves. The
two ends of one straight crack, which are equal by symmetry, differ by up to 0.16 % wherever it lies, grown at one end
or at both, by `max_hoop_stress`; by 0.2 % in the median of the other criteria, whose average sees the place in the
lattice. It is the only tolerance of which tip grows: the order of cracks in a file never matters."""

STARTS = -1
"""In place of how often a tip has advanced: a crack may start there."""

AS_FAR_LEFT = 1e-6
"""Of the extent of all tips: two that are as far to the left but for this are equally far."""

CLEARANCE = 0.1
"""Increments: a segment that comes this close to something has reached it. A path is not known more finely than that:
the segment is turned by 6 degrees at most. It is not a matter of the spacing: tips a thousandth of a spacing in front
of a crack or an outline were solved as well as others, without the integral for K."""


@dataclass(frozen=True, slots=True)
class Segment:
    """How a crack goes on from a site."""

    kink: float  # rad, from the direction of the site
    length: float  # m
    link: float = CLEARANCE  # of the length: a segment that comes this close to another crack has reached it


@dataclass(frozen=True, slots=True, eq=False)
class GrowingCrack:
    """A crack and the step in which each of its vertices was made (0: given).

    One that has started in a run has no vertex that was given; the oldest ones stand for them.
    """

    crack: Crack
    steps: Ints  # (n,)
    parent: int | None = None  # number of the crack that it has started on; None: of none
    in_shear: bool = False  # whether it has started so
    gathered: tuple[float, float] = (0.0, 0.0)  # m, that its start and its end have gathered while they wait

    @classmethod
    def given(cls, crack: Crack) -> GrowingCrack:
        """A crack that has not grown."""
        return cls(crack, np.zeros(len(crack.points), dtype=np.int64))

    @property
    def rooted(self) -> Bools:
        """Which vertices (n,) growth from tips has not made."""
        return np.asarray(self.steps == self.steps.min())

    def can_grow(self, at_end: bool) -> bool:
        """Whether the tip at the end (or start) may advance."""
        return self.crack.tip_at_end if at_end else self.crack.tip_at_start

    def n_advances(self, at_end: bool) -> int:
        """How often the tip at the end (or start) has advanced."""
        given = np.flatnonzero(self.rooted)
        return int(len(self.steps) - 1 - given[-1] if at_end else given[0])


def advancing_sites(
    criticality: Floats, n_advances: Ints, places: Floats, advance: Literal["most_critical", "in_turn", "all"]
) -> Ints:
    """Numbers of the sites that advance: of those whose criticality (n,) is 1 or more, or within TIE of such a's.

    `all`: all tips, the most critical first, then the most critical starts; `most_critical`: the largest; `in_turn`:
    the largest of those that have advanced least often, `n_advances` (n,), and of the starts, whose number is STARTS.
    Less critical cracks do not start: what the others set free may save them. Of equally critical ones a tip goes
    before a start, then that which has advanced least often, of those the leftmost, of those the lowest, by their
    `places` (n, 2): what is left is the same by symmetry.
    """
    met = criticality[criticality >= 1.0 - 10.0 * AT_STRENGTH]
    if len(met) == 0:
        return np.empty(0, dtype=np.int64)
    critical = np.flatnonzero(criticality >= min(1.0 - 10.0 * AT_STRENGTH, (1.0 - TIE) * met.min()))
    critical = critical[_from_left(places)[critical].argsort()]
    tips, starts = critical[n_advances[critical] != STARTS], critical[n_advances[critical] == STARTS]
    if advance == "all":
        return np.concatenate([largest_first(tips, criticality, places), _tied(starts, criticality)])
    if advance == "in_turn":
        tips = _least_advanced(tips, n_advances)
    tied = _tied(np.concatenate([tips, starts]), criticality)
    first = tied[n_advances[tied] != STARTS]
    return _least_advanced(first if len(first) else tied, n_advances)[:1]


def largest_first(sites: Ints, sizes: Floats, places: Floats) -> Ints:
    """The sites (k,) by their sizes (n,), and those of equal size from left to right, by their `places` (n, 2).

    A segment ends on what those before it have made. By their places alone a scene and its mirror image would differ.
    """
    left, found = sites[_from_left(places)[sites].argsort()], []
    while len(left):
        found.append(_tied(left, sizes))
        left = left[~np.isin(left, found[-1])]
    return np.concatenate(found) if found else left


def _from_left(places: Floats) -> Ints:
    """The rank (n,) of places (n, 2) from left to right, of those equally far to the left upwards."""
    apart = AS_FAR_LEFT * float(np.ptp(places, axis=0).max(initial=0.0)) or 1.0
    return np.asarray(np.lexsort((places[:, 1], np.round(places[:, 0] / apart))).argsort())


def _tied(sites: Ints, criticality: Floats) -> Ints:
    """Those that are as critical as the largest, but for what a lattice does not resolve."""
    return np.asarray(sites[criticality[sites] >= (1.0 - TIE) * criticality[sites].max(initial=-np.inf)])


def _least_advanced(sites: Ints, n_advances: Ints) -> Ints:
    return np.asarray(sites[n_advances[sites] == n_advances[sites].min(initial=np.iinfo(np.int64).max)])


def advanced(
    growing: GrowingCrack,
    at_end: bool,
    segment: Segment,
    step: int,
    region: shapely.Polygon,
    others: Sequence[GrowingCrack] = (),
) -> tuple[GrowingCrack, Meeting | None]:
    """The crack with a segment added to a tip, and what the tip has met.

    The new segment stays in `region` (m). It ends on the first of the region's rims, the `others` and its own path
    that it meets, and the crack has no tip there any more. The segment then is shorter than its length, or turned by
    up to its clearance and longer by as much. An end of one of the `others` that is met is kept: see `without_tip`.
    """
    crack, clearance = growing.crack, CLEARANCE * segment.length
    tip, direction = crack.points[-1] if at_end else crack.points[0], tip_direction(crack.points, at_end)
    near = [own_path(crack.points, at_end, clearance), *rims(region, clearance)]
    end, met = _segment(tip, direction, segment, near, others)
    points = np.vstack([crack.points, end]) if at_end else np.vstack([end, crack.points])
    steps = np.append(growing.steps, step) if at_end else np.insert(growing.steps, 0, step)
    longer = replace(growing, crack=replace(crack, points=points), steps=steps)
    if met is not None:
        longer = without_tip(longer, at_end)
        if met.kind == "own_path" and met.end is not None:
            longer = without_tip(longer, met.end)
    return longer, met


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where a crack starts, and what it will be."""

    crack: Crack  # but for its points
    parent: int | None  # number of the crack that it starts on
    in_shear: bool
    point: Floats  # (2,) m
    direction: float  # rad from +x, of the site
    both_ways: bool
    where: str  # in words


def started(
    start: Start, segment: Segment, step: int, region: shapely.Polygon, others: Sequence[GrowingCrack]
) -> tuple[GrowingCrack, list[tuple[bool, Meeting]]]:
    """A new crack from a site, and what its end (True) and its start have met, as `advanced` has it.

    Within rock it goes to both sides, to each with half of the length.
    """
    half = replace(segment, length=0.5 * segment.length) if start.both_ways else segment
    direction = np.array([np.cos(start.direction), np.sin(start.direction)])
    end, met = _segment(start.point, direction, half, rims(region, CLEARANCE * half.length), others)
    crack = replace(start.crack, points=np.stack([start.point, end]), tip_at_start=False, tip_at_end=met is None)
    new, found = GrowingCrack(crack, np.full(2, step), start.parent, start.in_shear), [(True, met)]
    if start.both_ways:
        new = replace(new, crack=replace(crack, tip_at_start=True))
        new, met = advanced(new, False, replace(half, kink=0.0), step, region, others)
        found.append((False, met))
    return new, [(at_end, met) for at_end, met in found if met is not None]


def _segment(
    start: Floats, direction: Floats, segment: Segment, near: Sequence[Obstacle], others: Sequence[GrowingCrack]
) -> tuple[Floats, Meeting | None]:
    """Where a segment ends that leaves `start` (2,) m, and what it meets there: one of the others, or what is `near`.

    `direction` (2,) is that of the site.
    """
    c, s = np.cos(segment.kink), np.sin(segment.kink)
    turned = np.array([c * direction[0] - s * direction[1], s * direction[0] + c * direction[1]])
    new, link = start + segment.length * turned, segment.link * segment.length
    met = first_met(start, new, [*(other_crack(n, other.crack.points, link) for n, other in enumerate(others)), *near])
    return (new if met is None else met.point), met


def without_tip(growing: GrowingCrack, at_end: bool) -> GrowingCrack:
    """The crack without a tip at its end (or start)."""
    crack = growing.crack
    return replace(growing, crack=replace(crack, tip_at_end=False) if at_end else replace(crack, tip_at_start=False))
