"""The forces that supports, foundations and interfaces carry."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crackgrow.run.result import Reaction
from crackgrow.run.scene import Scene
from crackgrow.run.step import StepSolution

Floats = NDArray[np.float64]


def reactions(scene: Scene, solution: StepSolution) -> tuple[Reaction, ...]:
    """Force of every support and foundation on the rock, and of the second body of an interface on the first."""
    found = []
    held, multipliers = solution.constraints, solution.outcome.multipliers
    for number in np.unique(held.support[held.support >= 0]).tolist():
        force = [-float(multipliers[(held.support == number) & (held.component == axis)].sum()) for axis in range(2)]
        found.append(Reaction(f"supports.{number}", (force[0], force[1])))
    faces, outcome = solution.faces, solution.outcome
    area = faces.weights * scene.lattice.spacing
    normal = faces.nodes.normal
    along = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    forces = -area[:, None] * (outcome.normal_traction[:, None] * normal + outcome.tangential_traction[:, None] * along)
    n_cracks = len(solution.cover.cracks)
    for index, surface in enumerate(solution.cover.surfaces[n_cracks:], start=n_cracks):
        if not scene.laws[index].bonded:
            x, y = forces[faces.surface == index].sum(axis=0)
            found.append(Reaction(surface.name, (float(x), float(y))))
    return tuple(found)


def total_load(solution: StepSolution) -> Floats:
    """Resultant (2,) N/m of all loads: the sum over the patches' own functions, which add up to one everywhere."""
    n_patches = len(solution.cover.patch_nodes)
    return np.asarray(solution.loads.reshape(-1, 2)[:n_patches].sum(axis=0))
