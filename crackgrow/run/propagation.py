"""The advance of cracks by given kinks: tip after tip, then those that start, and what they meet on the way."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import shapely

from crackgrow.arrays import Floats
from crackgrow.case.surface import end_word
from crackgrow.case.touching import scene_size
from crackgrow.cover.shapes import body_index
from crackgrow.fracture.advance import CLEARANCE, GrowingCrack, Segment, Start, advanced, started, without_tip
from crackgrow.fracture.meeting import Meeting
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.result import Event
from crackgrow.run.scene import Scene

LONGEST_SEGMENT = 2.0
"""Sizes of the scene: so long a segment ends outside. Where a much longer one meets something has lost its digits."""

End = tuple[int, bool]
"""Number of a crack, and whether it is its end or its start."""


@dataclass(frozen=True, slots=True, eq=False)
class BeforeAdvance:
    """The cracks before an advance."""

    scene: Scene
    cracks: tuple[GrowingCrack, ...]
    step: int  # that they advance in
    lengths: Mapping[End, float] = field(default_factory=dict)  # m, of ends that go by another increment
    starts: tuple[Start, ...] = ()  # of new cracks

    def segment(self, end: End, kink: float) -> Segment:
        """How a crack goes on from an end at a kink (rad), no farther than what leads out of the rock."""
        case = self.scene.case
        assert case.growth is not None
        link, length = case.growth.link_distance, self.lengths.get(end, case.growth.increment)
        length = min(length, LONGEST_SEGMENT * scene_size(case))
        return Segment(kink, length) if link is None else Segment(kink, length, min(link / length, 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class AfterAdvance:
    """The cracks after an advance."""

    cracks: tuple[GrowingCrack, ...]
    events: tuple[Event, ...]  # tips that have met something
    solution: StepSolution | None = None  # of `cracks`, where the search for the direction has solved them

    def can_grow(self, end: End) -> bool:
        """Whether there still is a tip at an end."""
        index, at_end = end
        return self.cracks[index].can_grow(at_end)


def advanced_by(before: BeforeAdvance, ends: Sequence[End], kinks: Floats) -> AfterAdvance:
    """All cracks, with the tips `ends` advanced by `kinks` one after the other: each sees what those before have made.

    A tip that one before it has met is no tip any more and stays: an event of its own. The numbers after the last crack
    are those of new ones, which do not start where one before them has come.
    """
    scene, step = before.scene, before.step
    grown = list(before.cracks)
    events: list[Event] = []
    for (index, at_end), kink in zip(ends, kinks.tolist(), strict=True):
        segment = before.segment((index, at_end), kink)
        if index >= len(before.cracks):
            events += _started(before, before.starts[index - len(before.cracks)], grown, segment)
            continue
        if not grown[index].can_grow(at_end):
            continue
        others = [grown[number] for number in range(len(grown)) if number != index]
        region = scene.regions[scene.crack_bodies[index]]
        earlier = list(grown)
        grown[index], met = advanced(grown[index], at_end, segment, step, region, others)
        if met is not None:
            events += _events_of(before, earlier, grown, (index, at_end, met))
    return AfterAdvance(tuple(grown), tuple(events))


def _started(before: BeforeAdvance, start: Start, grown: list[GrowingCrack], segment: Segment) -> Iterator[Event]:
    """Add a new crack to those that have grown, and tell what has happened."""
    scene, earlier, n = before.scene, list(grown), len(before.cracks)
    place, near = shapely.Point(start.point), CLEARANCE * segment.length
    pairs = zip(grown[:n], before.cracks, strict=True)
    ends = [
        now.crack.points[k] for now, old in pairs for k in (0, -1) if (now.crack.points[k] != old.crack.points[k]).any()
    ]
    ends += [new.crack.points[k] for new in grown[n:] for k in (0, -1)]
    if any(shapely.dwithin(shapely.Point(end), place, near) for end in ends):
        return
    body = body_index(scene.case.bodies, start.crack.body)
    crack, meetings = started(start, segment, before.step, scene.regions[body], grown)
    grown.append(crack)
    yield Event(before.step, "initiation", crack.crack.name, end_word(False), start.point, start.where)
    for at_end, met in meetings:
        yield from _events_of(before, earlier, grown, (len(earlier), at_end, met))


def _events_of(
    before: BeforeAdvance, earlier: Sequence[GrowingCrack], grown: list[GrowingCrack], met_by: tuple[int, bool, Meeting]
) -> Iterator[Event]:
    """What is to be told of an end (number of its crack, whether its end) that has met something; ends met are closed.

    `earlier` are the cracks before that end has moved.
    """
    index, at_end, met = met_by
    numbers = [number for number in range(len(grown)) if number != index]
    kind, name = _named(before.scene, grown[index].crack.body, met, [grown[number] for number in numbers])
    yield Event(before.step, kind, grown[index].crack.name, end_word(at_end), met.point, name)
    if met.end is None:
        return
    number = index if met.kind == "own_path" else numbers[met.number]
    grown[number] = without_tip(grown[number], met.end)
    if earlier[number].can_grow(met.end):
        name = "its own path" if number == index else grown[index].crack.surface.words
        yield Event(before.step, kind, grown[number].crack.name, end_word(met.end), met.point, name)


def _named(
    scene: Scene, body: str, met: Meeting, others: Sequence[GrowingCrack]
) -> tuple[Literal["coalescence", "hole", "break_through", "interface"], str]:
    """The kind of event that it is that a crack in a body has met something, and what that is called."""
    if met.kind == "own_path":
        return "coalescence", "its own path"
    near = SAME_PLACE * scene.lattice.spacing
    paths = ((line.name, shapely.LineString(scene.lattice.to_metres(line.points))) for line in scene.interfaces)
    there = [name.words for name, path in paths if shapely.dwithin(path, shapely.Point(met.point), near)]
    if met.kind == "crack":
        return "coalescence", " on ".join([others[met.number].crack.surface.words, *there[:1]])
    if there:
        return "interface", there[0]
    if met.kind == "hole":
        return "hole", f"hole{met.number} of body '{body}'"
    return "break_through", f"the outline of body '{body}'"
