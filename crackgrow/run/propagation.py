"""The advance of cracks: tip after tip by their kinks, then those that start, and what they meet on the way.

Kinks are the criterion's, or corrected until K_II vanishes at the new tips. The new tip of an increment along the
hoop-stress kink is not free of K_II: the path zigzags about the smooth one by an amount that shrinks with the
increment. The corrected kinks follow the smooth path at large increments. Every kink is corrected by its own tip's K_II
alone (diagonal secant); one whose tip has met something is not corrected any more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest

import numpy as np
import shapely

from crackgrow.accuracy.companion import End
from crackgrow.arrays import Floats, Ints
from crackgrow.case.surface import end_word
from crackgrow.case.touching import scene_size
from crackgrow.cover.shapes import body_index
from crackgrow.errors import GeometryError, SolveError
from crackgrow.fracture.advance import CLEARANCE, GrowingCrack, Segment, Start, advanced, started, without_tip
from crackgrow.fracture.debond import Debond, ends_of
from crackgrow.fracture.meeting import Meeting
from crackgrow.fracture.opening import opening
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.result import Event, EventKind
from crackgrow.run.scene import Scene
from crackgrow.run.starting import start_at

LONGEST_SEGMENT = 2.0
"""Sizes of the scene: so long a segment ends outside. Where a much longer one meets something has lost its digits."""

MOST_SOLVES = 6
"""Solves for one advance."""

SMALL_SHEAR = 1e-3
"""K_II below this fraction of K has vanished: it turns a crack by 0.1 degrees."""

WORST_ERROR = 1e-2
"""K_II within its spread over radii has vanished too, as long as that is below this fraction of K."""

USUAL_SLOPE = 1.0
"""d(K_II / K)/dkink, 1/rad: 0.5 for a small kink of an open crack, measured 2 for the wing of a closed one."""

SLOPES = (0.1, 20.0)
"""Secants outside of this range say nothing."""

LARGEST_CORRECTION = np.deg2rad(30.0)
"""rad, of one trial."""

Solve = Callable[[tuple[GrowingCrack, ...]], StepSolution]


@dataclass(frozen=True, slots=True, eq=False)
class BeforeAdvance:
    """The cracks before an advance."""

    scene: Scene
    cracks: tuple[GrowingCrack, ...]
    step: int  # that they advance in
    lengths: Mapping[End, float] = field(default_factory=dict)  # m, of ends that go by another increment
    starts: tuple[Start, ...] = ()  # of new cracks


@dataclass(frozen=True, slots=True, eq=False)
class AfterAdvance:
    """The cracks after an advance."""

    cracks: tuple[GrowingCrack, ...]
    events: tuple[Event, ...]  # tips that have met something
    solution: StepSolution | None = None  # of `cracks`, where the search for the direction has solved them


def advance_tips(before: BeforeAdvance, solution: StepSolution, chosen: Ints, solve: Solve) -> AfterAdvance:
    """The cracks after they have left the sites `chosen` of a solution; `solve` gives the step that follows.

    Starts of new cracks come last.
    """
    n_tips = len(solution.tips)
    chosen = chosen[chosen < len(solution.configuration.sites)]
    kinks: list[float] = []
    turns: dict[End, bool] = {}  # what starts, and shear, keep their directions
    for site in chosen.tolist():
        if site < n_tips:
            end, verdict = solution.cover.tip_ends[site], solution.tips[site].verdict
            assert verdict is not None  # it was chosen by it
            turns[end] = verdict.mode == "tension"
        else:
            start = solution.starts[site - n_tips]
            new = start_at(before.scene, before.cracks, before.starts, start.site, start.verdict.mode)
            turns[len(before.cracks) + len(before.starts), True] = False
            verdict, before = start.verdict, replace(before, starts=(*before.starts, new))
        kinks.append(verdict.kink)
    first = _advanced_by(before, turns, np.array(kinks))
    implicit = before.scene.growth.direction == "implicit"
    if not implicit or not any(turning and first.cracks[n].can_grow(end) for (n, end), turning in turns.items()):
        return first
    return _without_shear(before, turns, np.array(kinks), first, solve)


def advance_debonds(
    solution: StepSolution, chosen: Ints, step: int, new: Sequence[Debond]
) -> tuple[tuple[Debond, ...], tuple[Event, ...]]:
    """The cracked parts of interfaces after they have grown at those of their tips that are among some sites.

    They end on the `new` ones, too, which begin in this step.
    """
    scene, growth, events = solution.scene, solution.scene.growth, list[Event]()
    grown = list(scene.debonds)
    for number in chosen[chosen >= len(solution.configuration.sites)].tolist():
        known = solution.interface_tips[number - len(solution.configuration.sites)]
        assert known.debond is not None  # it was chosen by its toughness
        index, at_end = scene.debonds.index(known.debond), known.tip.at_end
        ends = ends_of(solution.cracks, (*grown, *new))
        grown[index], has_met = grown[index].advanced(at_end, growth.increment, step, ends)
        if has_met:
            name, place = str(solution.cover.surfaces[known.tip.surface].name), grown[index].points[-1 if at_end else 0]
            on_others = shapely.dwithin(ends, shapely.Point(place), SAME_PLACE * scene.lattice.spacing)
            kind: EventKind = "coalescence" if on_others else "break_through"
            met = "the end of a crack" if on_others else "the end of the interface"
            events.append(Event(step, kind, name, end_word(at_end), place, met))
    return tuple(grown), tuple(events)


def _advanced_by(before: BeforeAdvance, ends: Mapping[End, bool], kinks: Floats) -> AfterAdvance:
    """All cracks, with the tips `ends` advanced by `kinks` one after the other: each sees what those before have made.

    A tip that one before it has met is no tip any more and stays: an event of its own. The numbers after the last crack
    are those of new ones, which do not start where one before them has come.
    """
    scene, growth, grown, events = before.scene, before.scene.growth, list(before.cracks), list[Event]()
    for (index, at_end), kink in zip(ends, kinks.tolist(), strict=True):
        length = before.lengths.get((index, at_end), growth.increment)
        length = min(length, LONGEST_SEGMENT * scene_size(scene.case))  # no farther than what leads out of the rock
        link = growth.link_distance
        segment = Segment(kink, length) if link is None else Segment(kink, length, min(link / length, 1.0))
        if index >= len(before.cracks):
            events += _started(before, before.starts[index - len(before.cracks)], grown, segment)
        elif grown[index].can_grow(at_end):
            others = [grown[number] for number in range(len(grown)) if number != index]
            region, earlier = scene.regions[scene.crack_bodies[index]], list(grown)
            grown[index], met = advanced(grown[index], at_end, segment, before.step, region, others)
            if met is not None:
                events += _events_of(before, earlier, grown, (index, at_end, met))
    return AfterAdvance(tuple(grown), tuple(events))


def _started(before: BeforeAdvance, start: Start, grown: list[GrowingCrack], segment: Segment) -> Iterator[Event]:
    """Add a new crack to those that have grown, and tell what has happened."""
    scene, earlier = before.scene, list(grown)
    place, near = shapely.Point(start.point), CLEARANCE * segment.length
    ends = [
        now.crack.points[k]
        for now, was in zip_longest(grown, before.cracks)
        for k in (0, -1)
        if was is None or (now.crack.points[k] != was.crack.points[k]).any()
    ]
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


def _named(scene: Scene, body: str, met: Meeting, others: Sequence[GrowingCrack]) -> tuple[EventKind, str]:
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


def _without_shear(
    before: BeforeAdvance, turns: Mapping[End, bool], kinks: Floats, first: AfterAdvance, solve: Solve
) -> AfterAdvance:
    """The advance whose new tips see least shear, with its solution; others, which are large, are not kept."""
    trials = list[tuple[Floats, Floats]]()  # kinks and K_II / K at the new tips of each
    least, found, doubts = np.inf, first, list[str]()
    while not least <= 1.0 and len(trials) < MOST_SOLVES:
        try:
            advance = _advanced_by(before, turns, kinks) if trials else first
            solved = solve(advance.cracks)
        except (GeometryError, SolveError) as error:
            if not trials:
                return first  # solving it again tells the user why
            doubts.append(f"the search for the direction of growth ended at trial {len(trials) + 1}: {error}")
            break
        shear, nothing = _shear(advance, solved, turns)
        trials.append((kinks, shear))
        excess = float((np.abs(shear) / nothing).max())
        if found.solution is None or excess < least:
            least, left, found = excess, np.abs(shear).max(), replace(advance, solution=solved)
        del solved
        kinks = _corrected(trials)
    assert found.solution is not None
    if least > 1.0:
        doubts.append(f"the direction of growth left K_II at {left:.2g} of K at a new tip")
    return replace(found, solution=replace(found.solution, doubts=tuple(doubts)))


def _shear(advance: AfterAdvance, solution: StepSolution, turns: Mapping[End, bool]) -> tuple[Floats, Floats]:
    """K_II / K (n,) at the new tips, zero where one keeps its direction or has met something; what counts as zero.

    With bedding it is what turns them as much.
    """
    shear, nothing = np.zeros(len(turns)), np.full(len(turns), SMALL_SHEAR)
    for number, (end, turning) in enumerate(turns.items()):
        if not turning or not advance.cracks[end[0]].can_grow(end[1]):
            continue
        site = solution.cover.tip_ends.index(end)
        tip, (_, strength) = solution.tips[site], solution.scene.growing_in(solution.configuration.sites[site].body)
        if (size := float(np.hypot(*tip.K))) and tip.loading is not None:  # else nothing turns it
            # the kink of the largest hoop stress is -2 K_II / K_I where that is small, and bounded everywhere
            shear[number] = -0.5 * opening(tip.K, tip.loading.roots, strength, tip.loading.field.direction)[1]
            nothing[number] = np.clip(np.nan_to_num(tip.intensity.K_II_spread) / size, SMALL_SHEAR, WORST_ERROR)
    return shear, nothing


def _corrected(trials: Sequence[tuple[Floats, Floats]]) -> Floats:
    """The next kinks (n,): by the secant through the last two trials, else by the usual slope."""
    kinks, shear = trials[-1]
    slope = np.full(len(kinks), USUAL_SLOPE)
    if len(trials) > 1:
        step, change = kinks - trials[-2][0], shear - trials[-2][1]
        secant = np.divide(change, step, out=np.zeros_like(slope), where=step != 0.0)
        slope = np.where((secant > SLOPES[0]) & (secant < SLOPES[1]), secant, slope)
    return np.asarray(kinks - np.clip(shear / slope, -LARGEST_CORRECTION, LARGEST_CORRECTION))
