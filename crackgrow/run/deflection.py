"""A crack that ends on a bonded interface stops, turns along it, or goes on straight into the other body.

After He and Hutchinson (1989): it goes where G / G_c is largest, if that reaches 1. Their G is that of a half-plane
crack at right angles; here each way is tried by an increment in the scene as it is. Straight on, sqrt(G / G_c) is the
criticality of the other body's criterion, which is K / K_c where it has a toughness.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.model import CriticalLoad
from crackgrow.case.surface import SurfaceName, end_word
from crackgrow.cover.shapes import body_index
from crackgrow.errors import GeometryError, SolveError
from crackgrow.fracture.advance import TIE, GrowingCrack, Segment, Start, started
from crackgrow.fracture.debond import Debond, ends_of
from crackgrow.geometry.polyline import tip_direction
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.run.configuration import assemble
from crackgrow.run.evaluation import StepSolution, evaluated
from crackgrow.run.growth import site_criticality
from crackgrow.run.increments import held_loads, increment
from crackgrow.run.loading import load
from crackgrow.run.result import Event, EventKind
from crackgrow.run.starting import new_crack, new_name

SETTLED = 1e-3
"""At its critical load the criticality of a way is 1 but for this."""

MOST_LOADS = 12
"""Load factors that are tried for it."""

PARTS_OF_INCREMENTS = (1.0, 0.5, 0.25)
"""By which a way along an interface is tried: the whole one, or less where that would reach something."""


@dataclass(frozen=True, slots=True, eq=False)
class Ending:
    """An end of a crack on what is bonded of an interface with a toughness."""

    crack: int
    at_end: bool
    point: Floats  # (2,) m
    debond: Debond  # of no length
    beyond: str  # the body on the other side


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """How cracks go on from there: by debonds, or by new cracks."""

    debonds: tuple[Debond, ...] = ()
    cracks: tuple[GrowingCrack, ...] = ()
    criticality: float = 0.0  # sqrt(G / G_c) at its tips, at the load of the step

    def leaves_room_for(self, other: Way) -> bool:
        """Whether no debonds of both overlap."""
        pairs = ((a.line is b.line, a.at, b.at) for a, b in product(self.debonds, other.debonds))
        return not any(same and a[0] <= b[-1] and b[0] <= a[-1] for same, a, b in pairs)

    def and_also(self, other: Way, solution: StepSolution) -> Way:
        """Both ways at once; each new crack has a name of its own."""
        cracks = list(self.cracks)
        for growing in other.cracks:
            name = new_name([*solution.cracks, *cracks])
            cracks.append(replace(growing, crack=replace(growing.crack, name=name)))
        return replace(self, debonds=(*self.debonds, *other.debonds), cracks=tuple(cracks))


def way_on(solution: StepSolution, step: int) -> tuple[StepSolution, Way, list[Event]]:
    """How cracks go on from interfaces in a step, the solution at the critical load for that, and what is told of it.

    The most critical one goes, if it is more so than the tips; with `advance: all` also those that meet the criterion
    at that load. Where one stops is told once.
    """
    growth, critical = solution.scene.growth, isinstance(solution.scene.case.loading, CriticalLoad)
    found = [
        (ending, _along(solution, ending, step), _across(solution, ending, step))
        for ending in sorted(endings(solution), key=lambda ending: tuple(ending.point))
    ]
    best = max((way.criticality for _, *ways in found for way in ways), default=0.0)
    others = 0.0 if growth.advance == "all" and not critical else site_criticality(solution).max(initial=0.0)
    goes_on = best > max(others, 0.0 if critical else 1.0 - TIE)
    load, events, way = best if goes_on and critical else 1.0, list[Event](), Way(criticality=best)
    for ending, along, across in found:
        most, crack = max(along, across, key=lambda way: way.criticality), solution.cracks[ending.crack]
        kind: EventKind = "stop"
        first = not (way.debonds or way.cracks) and most.criticality >= (1.0 - TIE) * best
        also = growth.advance == "all" and most.criticality >= (1.0 - TIE) * load and way.leaves_room_for(most)
        if goes_on and (first or also):
            way, kind = way.and_also(most, solution), "crossing" if most.cracks else "deflection"
        elif crack.steps[-1 if ending.at_end else 0] != step - 1:
            continue
        ratios = [f"{(one.criticality / load) ** 2:.3g}" if one.criticality else "unknown" for one in (along, across)]
        met = SurfaceName("interface", ending.debond.bodies).words
        met += f" (G/G_c of {ratios[0]} along it, {ratios[1]} straight on)"
        events.append(Event(step, kind, crack.crack.name, end_word(ending.at_end), ending.point, met))
    return (_at_factor(solution, solution.factor / best) if goes_on and critical else solution), way, events


def _at_factor(solution: StepSolution, factor: float) -> StepSolution:
    """The solution at another load factor."""
    configuration, share = solution.configuration, factor / solution.factor
    found, errors = evaluated(increment(configuration, held_loads(configuration), factor)), solution.errors
    if errors is not None:
        K, T = (tuple(share * value for value in values) for values in (errors.K, errors.T))
        errors = replace(errors, K=K, T=T, largest=share * errors.largest)
    return replace(found, doubts=solution.doubts, origin=solution.origin, errors=errors)


def endings(solution: StepSolution) -> Iterator[Ending]:
    """The ends of cracks that may go on along an interface or through it: nothing has yet."""
    scene, cracks = solution.scene, [growing.crack for growing in solution.cracks]
    near = SAME_PLACE * scene.lattice.spacing
    ends = np.array([crack.points[end] for crack in cracks for end in (0, -1)]).reshape(-1, 2)
    for bond in (each for each in scene.case.interfaces if each.beside_crack and each.toughness is not None):
        for line, (number, at_end) in product(bond.boundary, product(range(len(cracks)), (False, True))):
            shape, point, body = shapely.LineString(line), ends[2 * number + at_end], cracks[number].body
            s = float(shapely.line_locate_point(shape, shapely.Point(point)))
            is_on = near < s < shape.length - near and shapely.dwithin(shape, shapely.Point(point), near)
            meets = np.count_nonzero(np.hypot(*(ends - point).T) <= near) > 1
            debonds = (each.at for each in scene.debonds if each.line is line)
            if (
                is_on
                and body in bond.bodies
                and not meets
                and all(s < at[0] - near or s > at[-1] + near for at in debonds)
            ):
                assert bond.toughness is not None
                debond = Debond(bond.bodies, line, bond.toughness, np.array([s]), np.zeros(1, dtype=np.int64))
                yield Ending(number, at_end, point, debond, bond.bodies[bond.bodies[0] == body])


def _along(solution: StepSolution, ending: Ending, step: int) -> Way:
    """The way along the interface: to the side that is more critical, to both where they are equal."""
    increment, ends = solution.scene.growth.increment, ends_of(solution.cracks, solution.scene.debonds)
    parts = [_short_of_others(ending.debond, side, increment, step, ends) for side in (False, True)]
    sides = [_tried(solution, Way(debonds=(part,))) for part in parts]
    less, most = sorted(sides, key=lambda way: way.criticality)
    if less.criticality < (1.0 - TIE) * most.criticality or most.criticality == 0.0:
        return most
    return replace(most, debonds=(_short_of_others(parts[0], True, increment, step, ends),))


def _short_of_others(debond: Debond, side: bool, increment: float, step: int, ends: shapely.Geometry) -> Debond:
    """It grown at its end (or start) by an increment (m), or by a part of it with which it has a tip to judge."""
    for part in PARTS_OF_INCREMENTS:
        grown, has_met = debond.advanced(side, part * increment, step, ends)
        if not has_met:
            break
    return grown


def _across(solution: StepSolution, ending: Ending, step: int) -> Way:
    """The way straight on; not critical at all where the other body has no strength."""
    scene, cracks = solution.scene, solution.cracks
    body = body_index(scene.case.bodies, ending.beyond)
    if scene.case.bodies[body].strength is None:
        return Way()
    new = new_crack(scene.case, cracks, new_name(cracks), ending.beyond, ending.crack)
    direction = tip_direction(cracks[ending.crack].crack.points, ending.at_end)
    angle = float(np.arctan2(direction[1], direction[0]))
    start = Start(new, ending.crack, False, ending.point, angle, False, "")
    crack, _ = started(start, Segment(0.0, scene.growth.increment), step, scene.regions[body], cracks)
    return _tried(solution, Way(cracks=(crack,)))


def _tried(solution: StepSolution, way: Way) -> Way:
    """The way with its criticality, zero where that is not known, in a trial; at a critical load by that of the way."""
    scene = solution.scene.at_start.with_debonds((*solution.scene.debonds, *way.debonds))
    cracks, factor = (*solution.cracks, *way.cracks), solution.factor
    try:
        if not isinstance(scene.case.loading, CriticalLoad):
            return replace(way, criticality=_criticality(load(scene, cracks, solution), way))
        configuration, at = assemble(scene, cracks), factor
        start = held_loads(configuration)
        # held loads do not rise with the others: the root lies between a load that does not reach 1 and one that does
        below, above = (0.0, 0.0), (math.inf, math.inf)
        for _ in range(MOST_LOADS):
            found = _criticality(evaluated(increment(configuration, start, at)), way)
            if abs(found - 1.0) < SETTLED:
                return replace(way, criticality=factor / at)
            if found < 1.0:
                below = at, found
            else:
                above = at, found
            share = (1.0 - below[1]) / (above[1] - below[1]) if above[0] < math.inf else 0.0
            at = below[0] + share * (above[0] - below[0]) if share else at * min(1.0 / found if found else 2.0, 2.0)
        return way
    except (GeometryError, SolveError):
        return way


def _criticality(trial: StepSolution, way: Way) -> float:
    """The largest one at the tips of a way in its trial; zero where none is known."""
    along = [each.criticality for each in trial.interface_tips if each.debond in way.debonds]
    first = len(trial.cracks) - len(way.cracks)
    ends = zip(trial.tips, trial.cover.tip_ends, strict=True)
    across = [tip.verdict.criticality for tip, (index, _) in ends if index >= first and tip.verdict is not None]
    return max((value for value in (*along, *across) if math.isfinite(value)), default=0.0)
