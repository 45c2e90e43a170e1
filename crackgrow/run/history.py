"""Histories of output points at every increment: displacement, stress, opening, slip, convergence; and reactions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.model import FacePoint, PointPair, RockPoint
from crackgrow.contact.faces import points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.cover.elements import locate
from crackgrow.cover.shapes import body_index
from crackgrow.run.increments import LoadState
from crackgrow.run.reactions import reactions
from crackgrow.run.result import History
from crackgrow.solid.recovery import displacement_at, stress_at

MOST_ROWS = 100
"""Of more states on the way of one load these many are told of, evenly spread: each is a back substitution."""

TOGETHER = 25
"""States whose displacements are solved for together; each costs a tenth of a solve of its own then."""


def history_of(state: LoadState) -> tuple[LoadState, ...]:
    """The states of an increment that have rows in the history, the last one included; each state is large."""
    if not state.scene.case.output.points:
        return ()
    via = state.via
    if len(via) > MOST_ROWS:
        via = tuple(via[number] for number in np.linspace(0, len(via) - 1, MOST_ROWS).astype(int).tolist())
    return (*via, state)


def history(states: Sequence[LoadState]) -> History | None:
    """The history of the states of a step, in order; None if the case has no output points."""
    if not states[0].configuration.scene.case.output.points:
        return None
    told = [dict(_values(state)) for state in _formed(states)]
    factors = np.array([state.factor for state in states])
    return History(tuple(told[0]), factors, np.array([list(values.values()) for values in told]))


def _formed(states: Sequence[LoadState]) -> Iterator[LoadState]:
    """The states with their displacements: those of one configuration that are not formed yet are solved together."""
    for _, some in groupby(states, lambda state: (id(state.configuration), state.formed is None)):
        alike = list(some)
        if alike[0].formed is not None:
            yield from alike
            continue
        configuration = alike[0].configuration
        for first in range(0, len(alike), TOGETHER):
            group = alike[first : first + TOGETHER]
            known = configuration.displacements([(state.level, state.states) for state in group])
            for state, each in zip(group, known, strict=True):
                yield replace(state, formed=configuration.equilibrium(state.level, state.before, state.states, each))


def _values(state: LoadState) -> Iterator[tuple[str, float]]:
    """Columns and their values, SI."""
    scene = state.scene
    for point in scene.case.output.points:
        if isinstance(point, RockPoint):
            displacement, stress = _at_point(state, point.body, point.point)
            values = zip(("u_x", "u_y", "stress_xx", "stress_yy", "stress_xy"), [*displacement, *stress], strict=True)
        elif isinstance(point, FacePoint):
            values = zip(("opening", "slip"), _jump(state, point), strict=True)
        else:
            values = zip(("convergence",), [_convergence(state, point)], strict=True)
        yield from ((f"{point.name}.{quantity}", float(value)) for quantity, value in values)
    for reaction in reactions(state):
        yield f"{reaction.where}.force_x", reaction.force[0]
        yield f"{reaction.where}.force_y", reaction.force[1]


def _at_point(state: LoadState, body: str, point: Floats) -> tuple[list[float], list[float]]:
    """Displacement (m) and stress (Pa) at a point of a body; nan where no rock is left."""
    scene, cover = state.scene, state.cover
    at = cover.lattice.to_lattice(point[None])
    if body not in (other.name for other in scene.case.bodies):
        return [np.nan] * 2, [np.nan] * 3
    element = locate(cover.lattice, cover.elements, at, body_index(scene.case.bodies, body))
    if element[0] < 0:
        return [np.nan] * 2, [np.nan] * 3
    u, materials = state.outcome.u, scene.materials_at(state.factor)
    return (
        displacement_at(cover, u, at, element)[0].tolist(),
        stress_at(cover, materials, u, at, element)[0].tolist(),
    )


def _jump(state: LoadState, point: FacePoint) -> tuple[float, float]:
    """Opening and slip (m) of the surface at the place nearest to a point, wherever its ends have grown to.

    nan where the surface has been excavated.
    """
    cover = state.cover
    at = shapely.Point(cover.lattice.to_lattice(point.point))
    lines = {
        index: shapely.LineString(surface.line.points)
        for index, surface in enumerate(cover.surfaces)
        if surface.name.is_of(point.surface)
    }
    if not lines:
        return np.nan, np.nan
    index = min(lines, key=lambda number: float(lines[number].distance(at)))
    s = np.array([shapely.line_locate_point(lines[index], at)])
    gap, slip = gap_and_slip(cover, points_at(cover, index, s), state.outcome.u)
    return float(gap[0]), float(slip[0])


def _convergence(state: LoadState, pair: PointPair) -> float:
    """By how much (m) two points have come closer."""
    moved = pair.points + [_at_point(state, body, at)[0] for body, at in zip(pair.bodies, pair.points, strict=True)]
    return float(np.hypot(*(pair.points[1] - pair.points[0])) - np.hypot(*(moved[1] - moved[0])))
