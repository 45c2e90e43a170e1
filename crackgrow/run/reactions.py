"""The forces that supports, foundations and interfaces carry."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import ContactSupport
from crackgrow.cover.cover import Cover
from crackgrow.run.increments import LoadState
from crackgrow.run.judging import StepSolution
from crackgrow.run.result import Reaction


def reactions(state: LoadState) -> tuple[Reaction, ...]:
    """Force of every support and foundation on the rock, and of the second body of an interface on the first.

    Those of rock that is gone are zero.
    """
    found, scene = [], state.scene
    held, multipliers = state.configuration.held, state.outcome.multipliers
    supports = [n for n, support in enumerate(scene.case.supports) if not isinstance(support, ContactSupport)]
    for number in supports:
        force = [-float(multipliers[(held.support == number) & (held.component == axis)].sum()) for axis in range(2)]
        found.append(Reaction(f"supports.{number}", (force[0], force[1])))
    cover, first = state.cover, len(scene.case.cracks)
    numbers = {surface.name: number for number, surface in enumerate(cover.surfaces)}
    at_start = scene.at_start
    for name in [*(line.name for line in at_start.interfaces), *(each.name for each in at_start.foundations)]:
        index = numbers.get(name, -1)
        if index < first:
            found.append(Reaction(name, (0.0, 0.0)))
            continue
        body = cover.elements.body[cover.surfaces[index].edges.plus[0]]
        found.append(Reaction(name, _resultant(cover, face_forces(state, index), int(body))))
    return tuple(found)


def face_forces(state: LoadState, surface: int) -> Floats:
    """Forces (n_dofs,) N/m of a surface's contact or bond on the rock on both of its sides."""
    held, contact, outcome = state.configuration.held, state.configuration.contact, state.outcome
    mine, here = held.surface == surface, state.configuration.faces.surface == surface
    bond = held.matrix[mine].T @ outcome.multipliers[mine]
    normal = contact.gap_of[here].T @ (contact.weights * outcome.normal_traction)[here]
    tangential = contact.slip_of[here].T @ (contact.weights * outcome.tangential_traction)[here]
    return np.asarray(-(bond + normal + tangential))


def _resultant(cover: Cover, forces: Floats, body: int) -> tuple[float, float]:
    """Sum of forces (n_dofs,) on a body: over its patches' own functions, which add up to one everywhere."""
    patches = np.unique(cover.patches.of_element.taken(np.flatnonzero(cover.elements.body == body)).values)
    x, y = forces.reshape(-1, 2)[patches].sum(axis=0)
    return float(x), float(y)


def total_load(solution: StepSolution) -> Floats:
    """Resultant (2,) N/m of all loads: the sum over the patches' own functions, which add up to one everywhere."""
    n_patches = len(solution.cover.patch_nodes)
    return np.asarray(solution.loads.reshape(-1, 2)[:n_patches].sum(axis=0))


def imbalance(solution: StepSolution) -> float:
    """What loads and the forces on the whole scene leave, by the sum of their magnitudes.

    Rows of the system can each be in balance to round-off while their sum is not: where a stiff body is held by one
    that is many times softer, and moves that many times further than it strains.
    """
    interfaces = {surface.name for surface in solution.scene.at_start.interfaces}
    held = [np.array(reaction.force) for reaction in reactions(solution.state) if reaction.where not in interfaces]
    size = float(np.abs(solution.loads).sum() + sum(np.hypot(*force) for force in held))
    left = float(np.abs(sum(held, start=total_load(solution))).max())
    return left / size if size > 0.0 else 0.0
