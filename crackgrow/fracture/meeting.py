"""What a new segment of a crack runs into: another crack, the crack's own older path, the rim of its body.

A segment ends on the first thing that it crosses. One that comes closer to something than the clearance is turned so
that it ends there. But nothing pulls it back: what the segment does not come clearly closer to (HALVED), such as the
crack that it branches off or one that it runs along, is no obstacle unless it is crossed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely
from shapely.ops import substring

from crackgrow.arrays import Floats
from crackgrow.geometry.polyline import first_hit

Kind = Literal["crack", "own_path", "outline", "hole"]

HALVED = 0.5
"""A segment heads for what it brings down to less than this fraction of its distance: within 30 degrees of it."""

AHEAD = 0.5
"""Cosine of the largest angle by which a segment is turned to a corner beside the place that it meets."""

CORNER = 0.1
"""Clearances: a segment that meets a line closer than this to one of its corners ends on the corner."""

GRAZED = 1e-6
"""Lengths of a segment: what it meets so close to its end it meets at its end; round-off decides on which side."""


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """Where a tip has met something: it ends there."""

    kind: Kind
    number: int  # of the other crack or of the hole
    point: Floats  # (2,) m
    end: bool | None = None  # which end of the crack is met, its end (True) or its start; None: none of them


@dataclass(frozen=True, slots=True, eq=False)
class Obstacle:
    """A line that no segment crosses."""

    kind: Kind
    number: int
    corners: Floats  # (n, 2) m
    line: shapely.Geometry  # through the corners; a point where there is one alone
    near: shapely.Geometry  # the part of it that segments keep clear of, perhaps nothing
    ends: tuple[tuple[bool, Floats], ...]  # of a crack: whether it is its end or its start, (2,) m
    clearance: float  # m: what comes closer has reached it


def rims(region: shapely.Polygon, clearance: float) -> list[Obstacle]:
    """The outline and the holes of a body (m)."""
    outline, *holes = (shapely.LineString(ring) for ring in (region.exterior, *region.interiors))
    found = [Obstacle("outline", 0, shapely.get_coordinates(outline), outline, outline, (), clearance)]
    for number, hole in enumerate(holes):
        found.append(Obstacle("hole", number, shapely.get_coordinates(hole), hole, hole, (), clearance))
    return found


def other_crack(number: int, points: Floats, clearance: float) -> Obstacle:
    """Another crack (n, 2) m."""
    line = shapely.LineString(points)
    return Obstacle("crack", number, points, line, line, ((False, points[0]), (True, points[-1])), clearance)


def own_path(points: Floats, at_end: bool, clearance: float) -> Obstacle:
    """A crack's own path (n, 2) m behind the segment that its tip at the end (or start) is on.

    Its last part, up to an arc length of two clearances (m) from the tip, may be crossed no more than the rest, but
    every new segment begins near it.
    """
    behind = points[-2::-1] if at_end else points[1:]  # from the tip on
    ends = ((not at_end, behind[-1]),)
    if len(behind) == 1:
        return Obstacle("own_path", 0, behind, shapely.Point(behind[0]), shapely.LineString(), ends, clearance)
    line = shapely.LineString(behind)
    tip = points[-1] if at_end else points[0]
    left_out = max(2.0 * clearance - float(np.hypot(*(tip - behind[0]))), 0.0)
    near = substring(line, left_out, line.length) if left_out < line.length else shapely.LineString()
    return Obstacle("own_path", 0, behind, line, near, ends, clearance)


def first_met(start: Floats, end: Floats, obstacles: Sequence[Obstacle]) -> Meeting | None:
    """What the segment from `start` to `end` (2,) m meets first, crossing it or closer than its clearance; or None.

    On the way from `start` to the point of the meeting nothing else is crossed.
    """
    segment = shapely.LineString([start, end])
    around = [obstacle for obstacle in obstacles if shapely.dwithin(segment, obstacle.line, 2.0 * obstacle.clearance)]
    crossed = _first_crossing(start, end, around)
    reached = end if crossed is None else crossed.point
    close = sorted(_approached(start, reached, around, crossed), key=lambda item: item[0])
    for meeting in [*(meeting for _, meeting in close), *([crossed] if crossed else [])]:
        for place in (*_corners_beside(start, meeting, around), meeting):
            if _is_free(start, place.point, around):
                return place
    return crossed


def _first_crossing(start: Floats, end: Floats, obstacles: Sequence[Obstacle]) -> Meeting | None:
    """The first place at which a segment crosses or touches an obstacle."""
    first, least = None, np.inf
    for obstacle in obstacles:
        point = first_hit(obstacle.line, start, end)
        if point is not None and float(np.hypot(*(point - start))) < least:
            least = float(np.hypot(*(point - start)))
            first = Meeting(obstacle.kind, obstacle.number, point)
    return first


def _approached(
    start: Floats, end: Floats, obstacles: Sequence[Obstacle], crossed: Meeting | None
) -> Iterator[tuple[float, Meeting]]:
    """What a segment heads for and comes close to, with the length (m) that it has run when it is closest."""
    segment, tip = shapely.LineString([start, end]), shapely.Point(start)
    for obstacle in obstacles:
        ends = [(which, shapely.Point(point)) for which, point in obstacle.ends]
        is_crossed = crossed is not None and (crossed.kind, crossed.number) == (obstacle.kind, obstacle.number)
        for which, place in ends if is_crossed else [(None, obstacle.near), *ends]:
            distance = shapely.distance(segment, place)  # nan where there is nothing near: no comparison holds
            away = shapely.distance(tip, place)  # a new crack begins on others
            if distance < obstacle.clearance and distance < HALVED * away and away > GRAZED * segment.length:
                along, point = shapely.get_coordinates(shapely.shortest_line(segment, place))
                yield float(np.hypot(*(along - start))), Meeting(obstacle.kind, obstacle.number, point, which)


def _corners_beside(start: Floats, meeting: Meeting, obstacles: Sequence[Obstacle]) -> Iterator[Meeting]:
    """Where to end so that no stub is left: ends of cracks within the clearance, corners of the line much closer."""
    if meeting.end is not None:
        return
    ends = [(Meeting(o.kind, o.number, point, which), o.clearance) for o in obstacles for which, point in o.ends]
    corners = [
        (Meeting(o.kind, o.number, point), CORNER * o.clearance)
        for o in obstacles
        if (o.kind, o.number) == (meeting.kind, meeting.number)
        for point in o.corners
    ]
    heading = meeting.point - start
    for places in (ends, corners):
        for place, reach in sorted(places, key=lambda item: float(np.hypot(*(item[0].point - meeting.point)))):
            way = place.point - start
            ahead = way @ heading >= AHEAD * np.hypot(*way) * np.hypot(*heading) > 0.0
            if ahead and np.hypot(*(place.point - meeting.point)) < reach:
                yield place


def _is_free(start: Floats, end: Floats, obstacles: Sequence[Obstacle]) -> bool:
    """Whether nothing is crossed on the way to a point on one of the obstacles."""
    crossed = _first_crossing(start, end, obstacles)
    length = float(np.hypot(*(end - start)))
    return crossed is None or bool(np.hypot(*(crossed.point - start)) >= (1.0 - GRAZED) * length)
