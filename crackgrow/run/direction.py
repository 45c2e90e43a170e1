"""The advance of the chosen tips: by the criterion's kinks, or by kinks corrected until K_II vanishes at the new tips.

The new tip of an increment along the hoop-stress kink is not free of K_II: the path zigzags about the smooth one by an
amount that shrinks with the increment. The corrected kinks follow the smooth path at large increments. Every kink is
corrected by its own tip's K_II alone (diagonal secant); one whose tip has met something is not corrected any more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
import shapely

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Growth
from crackgrow.errors import GeometryError, SolveError
from crackgrow.fracture.advance import CLEARANCE, GrowingCrack, Start, Way, advanced, closed, started
from crackgrow.fracture.criteria import hoop_stress_kink
from crackgrow.fracture.meeting import Meeting
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.run.judging import StepSolution
from crackgrow.run.result import Event
from crackgrow.run.scene import Scene
from crackgrow.run.starting import start_at

Solve = Callable[[tuple[GrowingCrack, ...]], StepSolution]

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

_END: dict[bool, Literal["start", "end"]] = {False: "start", True: "end"}


@dataclass(frozen=True, slots=True, eq=False)
class BeforeAdvance:
    """The cracks before an advance."""

    scene: Scene
    growth: Growth  # the scene's
    cracks: tuple[GrowingCrack, ...]
    step: int  # that they advance in
    starts: tuple[Start, ...] = ()  # of new cracks
    lengths: Mapping[tuple[int, bool], float] = field(default_factory=dict)  # m, of ends that go by another increment

    def way(self, end: tuple[int, bool], kink: float) -> Way:
        """How a crack goes on from an end at a kink (rad)."""
        length, link = self.lengths.get(end, self.growth.increment), self.growth.link_distance
        return Way(kink, length) if link is None else Way(kink, length, min(link / length, 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class Advance:
    """The cracks after an advance."""

    cracks: tuple[GrowingCrack, ...]
    events: tuple[Event, ...]  # tips that have met something
    solution: StepSolution | None = None  # of `cracks`, where the search for the direction has solved them


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    """What the kinks of an advance give; solutions are large, and only the best one is kept."""

    kinks: Floats  # (n,) rad
    shear: Floats  # (n,) K_II / K at the new tips, zero where a tip has met something
    error: Floats  # (n,) below which `shear` counts as zero

    @property
    def excess(self) -> float:
        """Largest shear, as a multiple of what counts as zero."""
        return float((np.abs(self.shear) / self.error).max())


def advance_tips(before: BeforeAdvance, solution: StepSolution, chosen: Ints, solve: Solve) -> Advance:
    """The cracks after they have left the sites `chosen` of a solution; `solve` gives the step that follows.

    Starts of new cracks come last.
    """
    n_tips = len(solution.cover.tips)
    tips, started_at = chosen[chosen < n_tips].tolist(), chosen[chosen >= n_tips].tolist()
    ends = [solution.cover.tip_ends[tip] for tip in tips]
    verdicts = [verdict for verdict in (solution.tips[tip].verdict for tip in tips) if verdict is not None]
    turning = [verdict.mode == "tension" for verdict in verdicts]  # what starts, and shear, keep their directions
    for number, site in enumerate(started_at):
        start = solution.starts[site - n_tips]
        new = start_at(before.scene, before.cracks, before.starts, start.site, start.verdict.mode)
        before, end = replace(before, starts=(*before.starts, new)), (len(before.cracks) + number, True)
        ends, verdicts, turning = [*ends, end], [*verdicts, start.verdict], [*turning, False]
    kinks = np.array([verdict.kink for verdict in verdicts])
    first = _advanced(before, ends, kinks)
    turned = [end for end, turns in zip(ends, turning, strict=True) if turns]
    if before.growth.direction == "explicit" or not any(_can_grow(first, end) for end in turned):
        return first
    return _without_shear(before, _Turning(ends, turning), kinks, first, solve)


@dataclass(frozen=True, slots=True)
class _Turning:
    """The ends that advance, and whether a direction is looked for in which K_II vanishes."""

    ends: list[tuple[int, bool]]
    turning: list[bool]


def _advanced(before: BeforeAdvance, ends: Sequence[tuple[int, bool]], kinks: Floats) -> Advance:
    """All cracks, with the tips `ends` advanced by `kinks` one after the other: each sees what those before have made.

    A tip that one before it has met is no tip any more and stays: an event of its own. The numbers after the last crack
    are those of new ones, which do not start where one before them has come.
    """
    scene, step = before.scene, before.step
    grown = list(before.cracks)
    events: list[Event] = []
    for (index, at_end), kink in zip(ends, kinks.tolist(), strict=True):
        way = before.way((index, at_end), kink)
        if index >= len(before.cracks):
            events += _started(before, before.starts[index - len(before.cracks)], grown, way)
            continue
        if not grown[index].can_grow(at_end):
            continue
        others = [grown[number] for number in range(len(grown)) if number != index]
        region = scene.regions[scene.crack_bodies[index]]
        earlier = list(grown)
        grown[index], met = advanced(grown[index], at_end, way, step, region, others)
        if met is not None:
            events += _told(before, earlier, grown, (index, at_end, met))
    return Advance(tuple(grown), tuple(events))


def _started(before: BeforeAdvance, start: Start, grown: list[GrowingCrack], way: Way) -> Iterator[Event]:
    """Add a new crack to those that have grown, and tell what has happened."""
    scene, earlier, n = before.scene, list(grown), len(before.cracks)
    place, near = shapely.Point(start.point), CLEARANCE * way.length
    pairs = zip(grown[:n], before.cracks, strict=True)
    ends = [
        now.crack.points[k] for now, old in pairs for k in (0, -1) if (now.crack.points[k] != old.crack.points[k]).any()
    ]
    ends += [new.crack.points[k] for new in grown[n:] for k in (0, -1)]
    if any(shapely.dwithin(shapely.Point(end), place, near) for end in ends):
        return
    body = [each.name for each in scene.case.bodies].index(start.crack.body)
    crack, meetings = started(start, way, before.step, scene.regions[body], grown)
    grown.append(crack)
    yield Event(before.step, "initiation", crack.crack.name, _END[False], start.point, start.where)
    for at_end, met in meetings:
        yield from _told(before, earlier, grown, (len(earlier), at_end, met))


def _told(
    before: BeforeAdvance, earlier: Sequence[GrowingCrack], grown: list[GrowingCrack], met_by: tuple[int, bool, Meeting]
) -> Iterator[Event]:
    """What is to be told of an end (number of its crack, whether its end) that has met something; ends met are closed.

    `earlier` are the cracks before that end has moved.
    """
    index, at_end, met = met_by
    numbers = [number for number in range(len(grown)) if number != index]
    kind, name = _named(before.scene, grown[index].crack.body, met, [grown[number] for number in numbers])
    yield Event(before.step, kind, grown[index].crack.name, _END[at_end], met.point, name)
    if met.end is None:
        return
    number = index if met.kind == "own_path" else numbers[met.number]
    grown[number] = closed(grown[number], met.end)
    if earlier[number].can_grow(met.end):
        name = "its own path" if number == index else f"crack '{grown[index].crack.name}'"
        yield Event(before.step, kind, grown[number].crack.name, _END[met.end], met.point, name)


def _named(
    scene: Scene, body: str, met: Meeting, others: Sequence[GrowingCrack]
) -> tuple[Literal["coalescence", "hole", "break_through", "interface"], str]:
    """The kind of event that it is that a crack in a body has met something, and what that is called."""
    if met.kind == "own_path":
        return "coalescence", "its own path"
    near = SAME_PLACE * scene.lattice.spacing
    paths = ((line.name, shapely.LineString(scene.lattice.to_metres(line.points))) for line in scene.interfaces)
    there = [f"interface '{name}'" for name, path in paths if shapely.dwithin(path, shapely.Point(met.point), near)]
    if met.kind == "crack":
        return "coalescence", " on ".join([f"crack '{others[met.number].crack.name}'", *there[:1]])
    if there:
        return "interface", there[0]
    if met.kind == "hole":
        return "hole", f"hole{met.number} of body '{body}'"
    return "break_through", f"the outline of body '{body}'"


def _without_shear(before: BeforeAdvance, wanted: _Turning, kinks: Floats, first: Advance, solve: Solve) -> Advance:
    """The advance whose new tips see least shear, with its solution and the cost of all solves."""
    trials: list[_Trial] = []
    seconds: dict[str, float] = {}
    least, found, gave_up = np.inf, first, ""
    while True:
        try:
            advance = _advanced(before, wanted.ends, kinks) if trials else first
            solved = solve(advance.cracks)
        except (GeometryError, SolveError) as error:
            if not trials:
                return first  # solving it again tells the user why
            gave_up = f"the search for the direction of growth ended at trial {len(trials) + 1}: {error}"
            break
        for phase, spent in solved.seconds.items():
            seconds[phase] = seconds.get(phase, 0.0) + spent
        trials.append(_judged(kinks, advance, solved, wanted))
        if found.solution is None or trials[-1].excess < least:
            least, best, found = trials[-1].excess, trials[-1], replace(advance, solution=solved)
        del solved
        if least <= 1.0 or len(trials) == MOST_SOLVES:
            break
        kinks = _corrected(trials)
    assert found.solution is not None
    notes = (*found.solution.notes, *([gave_up] if gave_up else []))
    if least > 1.0:
        left = f"the direction of growth left K_II at {np.abs(best.shear).max():.2g} of K at a new tip"
        notes = (*notes, left)
    return replace(found, solution=replace(found.solution, seconds=seconds, factorizations=len(trials), notes=notes))


def _judged(kinks: Floats, advance: Advance, solution: StepSolution, wanted: _Turning) -> _Trial:
    """The shear that new tips see."""
    shear, error = np.zeros(len(wanted.ends)), np.full(len(wanted.ends), SMALL_SHEAR)
    for number, (end, turns) in enumerate(zip(wanted.ends, wanted.turning, strict=True)):
        if not turns or not _can_grow(advance, end):
            continue  # it keeps its direction, or has met something
        state = solution.tips[solution.cover.tip_ends.index(end)]
        size = float(np.hypot(*state.K))
        if size == 0.0:
            continue  # nothing to turn it
        # the kink of the largest hoop stress is -2 K_II / K_I where that is small, and bounded everywhere
        shear[number] = -0.5 * hoop_stress_kink(*state.K)
        error[number] = np.clip(np.nan_to_num(state.intensity.K_II_spread) / size, SMALL_SHEAR, WORST_ERROR)
    return _Trial(kinks, shear, error)


def _can_grow(advance: Advance, end: tuple[int, bool]) -> bool:
    index, at_end = end
    return advance.cracks[index].can_grow(at_end)


def _corrected(trials: list[_Trial]) -> Floats:
    """The next kinks (n,): by the secant through the last two trials, else by the usual slope."""
    last = trials[-1]
    slope = np.full(len(last.kinks), USUAL_SLOPE)
    if len(trials) > 1:
        step, change = last.kinks - trials[-2].kinks, last.shear - trials[-2].shear
        secant = np.divide(change, step, out=np.zeros_like(slope), where=step != 0.0)
        slope = np.where((secant > SLOPES[0]) & (secant < SLOPES[1]), secant, slope)
    return np.asarray(last.kinks - np.clip(last.shear / slope, -LARGEST_CORRECTION, LARGEST_CORRECTION))
