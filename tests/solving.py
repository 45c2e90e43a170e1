"""Runs driven to their end; one configuration of the cracks solved; one contact system."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.load import read_case
from crackgrow.case.model import Case, LoadHistory
from crackgrow.contact.coulomb import ContactMemory
from crackgrow.contact.faces import FacePoints
from crackgrow.contact.solve import OVERLAP, ContactOutcome, Increment
from crackgrow.contact.system import ContactSystem
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.geometry.polyline import segment_directions
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.evaluation import StepSolution, evaluated
from crackgrow.run.increments import LoadState, held_loads, increment, unloaded
from crackgrow.run.loop import for_each, grow
from crackgrow.run.result import Checkpoint, RunEnd, StepResult
from crackgrow.run.scene import Scene, make_scene
from crackgrow.solid.recovery import displacement_at


def last_factor(case: Case) -> float:
    """The last load factor of a history; nan where factors are found."""
    return case.loading.factors[-1] if isinstance(case.loading, LoadHistory) else np.nan


def face_vertices(cover: Cover, surface: int) -> FacePoints:
    """Both ends of all edges along a surface, in order of arc length."""
    edges, tangents = cover.surfaces[surface].edges, segment_directions(cover.surfaces[surface].line.points)
    tangent, plus, minus = (np.repeat(part, 2, axis=0) for part in (tangents[edges.segment], edges.plus, edges.minus))
    s, points = edges.s.ravel(), edges.points.reshape(-1, 2)
    return FacePoints(np.full(len(s), surface), s, points, tangent[:, ::-1] * [-1.0, 1.0], plus, minus)


def ready(case: Case) -> Configuration:
    """The given cracks of a case, laid out and assembled."""
    return assemble(make_scene(case), tuple(map(GrowingCrack.given, case.cracks)))


def through(configuration: Configuration, *factors: float) -> list[LoadState]:
    """The states at load factors, in turn, the first one from the held loads alone."""
    start, states = held_loads(configuration), []
    for factor in factors:
        states.append(increment(configuration, start, factor))
        start = states[-1]
    return states


def solve_step(scene: Scene, growing: tuple[GrowingCrack, ...], load_factor: float) -> StepSolution:
    """Solve one configuration, loaded in one increment. Raises GeometryError or SolveError where that can't be done."""
    configuration = assemble(scene, growing)
    return evaluated(increment(configuration, unloaded(configuration), load_factor))


def solve_case(case: Case, offset: tuple[float, float] = (0.0, 0.0)) -> StepSolution:
    """The given cracks at the last load factor, on a lattice moved by `offset` spacings."""
    return solve_step(make_scene(case, offset), tuple(map(GrowingCrack.given, case.cracks)), last_factor(case))


def displacement_in(solution: StepSolution, metres: Floats, body: int | None = 0) -> Floats:
    """Displacement (n, 2) m at points (n, 2) m, all of which lie in a body, or in any."""
    cover = solution.cover
    points = cover.lattice.to_lattice(metres)
    elements = locate(cover.lattice, cover.elements, points, body)
    assert elements.min() >= 0
    return displacement_at(cover, solution.outcome.u, points, elements)


def solve_contact(
    contact: ContactSystem, loads: Floats, given: Floats, memory: ContactMemory | None = None
) -> ContactOutcome:
    """Displacements and contact tractions under `loads` (n_dofs,), with support displacements `given` (m,).

    `memory` is that of the increment before, None for the first. Raises NotSolvedError where the contact solver finds
    no solution.
    """
    without = contact.system.solve(loads, given)
    # the mean displacement along the loads: coefficients are far larger where tip functions nearly depend on each other
    along_loads = abs(loads @ without[0]) / max(np.abs(loads).sum(), np.finfo(float).tiny)
    overlap = OVERLAP * max(float(along_loads), float(np.abs(given).max(initial=0.0)))
    memory = memory or ContactMemory.fresh(len(contact.weights))
    pull = np.zeros(0) if contact.loose is None else contact.loose.along(loads)
    still = np.zeros(2 * len(contact.weights))
    free = contact.operator @ without[0]
    increment = Increment(contact, memory, free, pull, overlap, still, (loads, given))
    return increment.formed(increment.solved(), without)


def whole_run(case: Case, checkpoint: Checkpoint | None = None) -> tuple[list[StepResult], RunEnd]:
    """The results of all steps, of those from a `checkpoint` on if there is one, and why the run ended."""
    results: list[StepResult] = []
    return results, for_each(grow(case, checkpoint), results.append)


def steps_of(text: str, *settings: str) -> list[StepResult]:
    """The steps of a case that is written out."""
    return whole_run(read_case(text, "scene", "scene", settings))[0]


def seen(results: Iterable[StepResult], column: str) -> Floats:
    """A column of history.csv, on the way of all steps."""
    told = [result.history for result in results]
    return np.concatenate([each.values[:, each.columns.index(column)] for each in told if each is not None])
