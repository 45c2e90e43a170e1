"""The forces that supports, foundations and interfaces carry."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import ContactSupport
from crackgrow.cover.cover import Cover, Foundation
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.geometry.tolerance import ROUND_OFF
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.increments import LoadState
from crackgrow.run.result import Reaction


def reactions(state: LoadState) -> tuple[Reaction, ...]:
    """Force of every support and foundation on the rock, and of the second body of an interface on the first.

    Those of rock that is gone are zero.
    """
    at_start = state.scene.at_start
    return (*_of_supports(state), *_on_surfaces(state, (*at_start.interfaces, *at_start.foundations)))


def _of_supports(state: LoadState) -> Iterator[Reaction]:
    """Forces of supports that prescribe displacements."""
    held, multipliers = state.configuration.held, state.outcome.multipliers
    for number, support in enumerate(state.scene.case.supports):
        if not isinstance(support, ContactSupport):
            of_it = [(held.support == number) & (held.component == axis) for axis in range(2)]
            x, y = (-float(multipliers[mine].sum()) for mine in of_it)
            yield Reaction(f"supports.{number}", (x, y))


def _on_surfaces(state: LoadState, surfaces: Sequence[CrackGeometry | Foundation]) -> Iterator[Reaction]:
    """Forces of interfaces and foundations, each on the body on its plus face; none of those that are gone."""
    cover = state.cover
    numbers = {surface.name: number for number, surface in enumerate(cover.surfaces)}
    for name in (surface.name for surface in surfaces):
        force = (0.0, 0.0)
        if name in numbers:
            index = numbers[name]
            body = cover.elements.body[cover.surfaces[index].edges.plus[0]]
            force = _resultant(cover, face_forces(state, index), int(body))
        yield Reaction(str(name), force)


def face_forces(state: LoadState, surface: int) -> Floats:
    """Forces (n_dofs,) N/m of a surface's contact or bond on the rock on both of its sides."""
    held, contact, points = state.configuration.held, state.configuration.contact, state.outcome.points
    mine, here = held.surface == surface, state.configuration.faces.surface == surface
    bond = held.matrix[mine].T @ state.outcome.multipliers[mine]
    normal = contact.gap_of[here].T @ (contact.weights * points.normal)[here]
    tangential = contact.slip_of[here].T @ (contact.weights * points.tangential)[here]
    return np.asarray(-(bond + normal + tangential))


def _resultant(cover: Cover, forces: Floats, body: int) -> tuple[float, float]:
    """Sum of forces (n_dofs,) on a body: over its patches' own functions, which add up to one everywhere."""
    patches = np.unique(cover.patches.of_element.taken(np.flatnonzero(cover.elements.body == body)).values)
    x, y = forces.reshape(-1, 2)[patches].sum(axis=0)
    return float(x), float(y)


def total_load(solution: StepSolution) -> Floats:
    """Resultant (2,) N/m of all loads: the sum over the patches' own functions, which add up to one everywhere."""
    n_patches = len(solution.cover.patches.nodes)
    return np.asarray(solution.loads.reshape(-1, 2)[:n_patches].sum(axis=0))


def imbalance(solution: StepSolution) -> float:
    """What loads and the forces on the whole scene leave, by the sum of their magnitudes.

    Rows of the system can each be in balance to round-off while their sum is not: where a stiff body is held by one
    that is many times softer, and moves that many times further than it strains. Where nothing is stressed, as behind
    faces that have parted, nothing is out of balance.
    """
    state = solution.state
    external = [*_of_supports(state), *_on_surfaces(state, state.scene.foundations)]
    held = [np.array(reaction.force) for reaction in external]
    size = float(np.abs(solution.loads).sum() + sum(np.hypot(*force) for force in held))
    left = float(np.abs(sum(held, start=total_load(solution))).max())
    return 0.0 if size <= ROUND_OFF * state.outcome.largest_terms else left / size
