"""Whether a solved increment obeys the laws of contact, from their definitions and the displacements alone.

Gap and slip come from displacements of the elements that lie just beside the faces, found anew by their place; nothing
of the solver enters but the displacements, the tractions and which points it holds for broken. Every contact point has

    p_n <= 0,  g >= 0,  p_n g = 0           with g = gap - tan(dilation) |s| - p_n / k,
    |p_t| <= c - mu p_n,  and where s changes by ds: |p_t| = c - mu p_n, p_t ds > 0,   with s = slip - p_t / k,

and no shear where it is open; c and mu are those of a broken point where it has slipped or opened, in this increment
or before. Cohesion that broken points keep where they are closed falls by a jump where they open: where neither state
holds (with cohesion the point opens, without it is pressed) there is none, so that such a point may slip without it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.contact.coulomb import ContactMemory
from crackgrow.contact.faces import FacePoints
from crackgrow.contact.solve import ContactOutcome, PointStates
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.run.configuration import Configuration
from crackgrow.run.load_level import LoadLevel
from crackgrow.solid.recovery import displacement_at
from tests.solving import displacement_size

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BESIDE = 1e-6
"""Spacings: so far from a face lies the point whose element the face belongs to."""

CROWDED = 1e-5
"""Spacings: nearer to corners and other lines than this, a point beside the face may be behind one of them."""


LENGTH_TOLERANCE = 1e-8
"""Of the largest displacement: a change of slip or a gap below this is none, or below the residual of equilibrium or of
the contact conditions."""

ROUND_OFF = 1e-9
"""Of the displacement that loads would cause, were they not on held rock."""


@dataclass(frozen=True, slots=True, eq=False)
class Increment:
    """One increment as it was solved."""

    configuration: Configuration
    level: LoadLevel
    memory: ContactMemory  # before it
    outcome: ContactOutcome


@contextmanager
def recorded() -> Iterator[list[Increment]]:
    """Every increment whose displacements are formed inside of the block, trials of factors and directions included."""
    found: list[Increment] = []
    solve = Configuration.equilibrium

    def equilibrium(
        configuration: Configuration, level: LoadLevel, memory: ContactMemory, states: PointStates
    ) -> ContactOutcome:
        state = solve(configuration, level, memory, states)
        found.append(Increment(configuration, level, memory, state))
        return state

    Configuration.equilibrium = equilibrium  # type: ignore[method-assign]
    try:
        yield found
    finally:
        Configuration.equilibrium = solve  # type: ignore[method-assign]


def jumps(cover: Cover, points: FacePoints, u: Floats) -> tuple[Floats, Floats, float]:
    """Gap (n,) and slip (n,), m, at points of faces, and the largest displacement (m) there."""
    sides = []
    for sign, known in ((1.0, points.plus), (-1.0, points.minus)):
        rock = known >= 0
        elements = known.copy()
        beside = points.points + sign * BESIDE * points.normal
        body = cover.elements.body[known]
        sure = np.flatnonzero(rock & ~_crowded(cover, points))
        found = locate(cover.lattice, cover.elements, beside[sure], body[sure])
        assert np.all(found >= 0), "no rock beside a face"
        elements[sure] = found
        displacement = np.zeros((len(known), 2))
        displacement[rock] = displacement_at(cover, u, points.points[rock], elements[rock])
        sides.append(displacement)
    jump = sides[0] - sides[1]
    tangent = points.normal @ np.array([[0.0, -1.0], [1.0, 0.0]])
    largest = max(float(np.abs(side).max(initial=0.0)) for side in sides)
    return np.sum(jump * points.normal, axis=1), np.sum(jump * tangent, axis=1), largest


def _crowded(cover: Cover, points: FacePoints) -> NDArray[np.bool_]:
    """Which points (n,) are near corners of their surface or near other surfaces."""
    places = shapely.points(points.points)
    crowded = np.zeros(len(places), dtype=bool)
    for index, surface in enumerate(cover.surfaces):
        mine = points.surface == index
        corners = shapely.multipoints(surface.line.points)
        crowded[mine] |= shapely.dwithin(places[mine], corners, CROWDED)
        crowded[~mine] |= shapely.dwithin(places[~mine], shapely.linestrings(surface.line.points), CROWDED)
    return crowded


def violations(increment: Increment) -> dict[str, float]:
    """By how much an increment violates the conditions of contact, each relative: zero where all hold.

    Displacements count by the largest at the faces, tractions by the largest one, or either by what the other one makes
    of a spacing of the softest rock.
    """
    configuration, outcome, memory = increment.configuration, increment.outcome, increment.memory
    faces, law = configuration.faces, configuration.contact.law
    if faces.n == 0:
        return {}
    gap_there, slip_there, largest = jumps(configuration.cover, faces.points, outcome.u)
    total = faces.functions @ faces.lengths
    gap, slip = ((faces.functions @ (faces.lengths * jump)) / total for jump in (gap_there, slip_there))
    p_n, p_t = outcome.points.normal, outcome.points.tangential
    slid = slip - law.compliance * p_t
    opened = law.dilation[0] * np.abs(slid)
    room = gap - opened - law.compliance * p_n
    change = slid - memory.slip
    loads, given = configuration.loads(increment.level), increment.level.factor * configuration.held.given
    young = min(material.young_prime for material in configuration.scene.materials)
    stiffness = young / configuration.scene.lattice.spacing
    length = max(largest, displacement_size(loads, outcome.u, given))
    scale = max(float(np.abs(loads).max()), float(np.abs(configuration.loads(LoadLevel(1.0))).max()))
    noise = ROUND_OFF * scale / young  # all that is left without loads, or where they act on held rock alone
    most = max(float(np.abs(jump).max()) for jump in (gap, slip, memory.slip))  # what the increment has undone counts
    largest = max(largest, most)
    pressure = max(float(np.abs(p_n).max()), float(np.abs(p_t).max()), stiffness * most)
    length = max(length, pressure / stiffness)
    if length <= noise:
        return {}
    tolerance = max(LENGTH_TOLERANCE, increment.outcome.residual, outcome.complementarity)
    broken = memory.broken | (np.abs(change) > tolerance * length) | (room > tolerance * length)
    friction, cohesion = law.bound_of(broken)
    is_open = room > tolerance * length
    bound = np.where(is_open, 0.0, cohesion - friction * np.minimum(p_n, 0.0))
    least = np.where(broken | outcome.memory.broken, law.bound_of(np.ones_like(broken))[0], law.friction[0])
    limit = -least * np.minimum(p_n, 0.0)
    short = np.minimum(np.abs(change) / length, np.maximum(limit - np.abs(p_t), 0.0) / pressure)
    against = np.minimum(np.abs(change) / length, np.abs(p_t) / pressure) * (change * p_t < 0.0)
    return {
        "tension": float(np.max(p_n, initial=0.0)) / pressure,
        "overlap": float(np.max(-room, initial=0.0)) / length,
        "pressure at open faces": float(np.max(np.minimum(room / length, -p_n / pressure), initial=0.0)),
        "shear beyond the limit": float(np.max(np.abs(p_t) - bound, initial=0.0)) / pressure,
        "slip below the limit": float(np.where(is_open, 0.0, short).max()),
        "slip against friction": float(against.max()),
    }
