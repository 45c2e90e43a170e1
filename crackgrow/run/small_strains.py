"""Whether displacements are as small as the equations take them: strains, rotations and slips below a few per cent.

Of a body the mean gradient of the displacement counts, of a surface its largest jump over its length, of stress in the
ground what it would strain the rock by.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.run.contact_violation import largest_jump
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.result import CrackFaces
from crackgrow.run.warning_causes import StepWarning, WarningCause
from crackgrow.solid.recovery import displacement_at

ALONG = np.array([[1.0, 0.0, 1.0, 1.0], [0.0, 1.0, 1.0, -1.0]])
"""Axes at whose ends the outmost places of a body lie."""


def large_displacements(solution: StepSolution, faces: tuple[CrackFaces, ...]) -> Iterator[StepWarning]:
    """The worst of what is not small in a step, if anything is."""
    found = [
        (largest_jump(face) / float(face.s[-1]), f"the faces of '{face.crack}' part or slip by {{}} of its length")
        for face in faces
    ]
    bodies = zip(solution.scene.case.bodies, solution.materials, _gradients(solution), strict=True)
    for body, material, gradient in bodies:
        stress = float(np.abs(material.initial.at(body.outline)).max())
        found.append(
            (stress / material.young_prime, f"the stress in the ground would strain body '{body.name}' by {{}}")
        )
        found.append((float(np.linalg.norm(gradient, 2)), f"the loads strain or turn body '{body.name}' by {{}}"))
    size, what = max(found)
    if size > WarningCause.NOT_SMALL.limit:
        yield WarningCause.NOT_SMALL.at(size=size, what=what.format(f"{100.0 * size:.2g} %"))


def _gradients(solution: StepSolution) -> Iterator[Floats]:
    """Mean gradient of the displacement (2, 2) of each body: the linear field nearest to that of its outmost places."""
    elements, spacing = solution.cover.elements, solution.cover.lattice.spacing
    for number in range(len(solution.scene.case.bodies)):
        mine = np.flatnonzero(elements.body == number)
        along = elements.reference[mine] @ ALONG
        some = mine[np.concatenate([along.argmin(axis=0), along.argmax(axis=0)])]
        places = elements.reference[some]
        u = displacement_at(solution.cover, solution.outcome.u, places, some) / spacing
        linear = np.column_stack([np.ones(len(some)), places])
        yield np.asarray(np.linalg.lstsq(linear, u, rcond=None)[0][1:].T)
