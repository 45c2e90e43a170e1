"""Rigid motions: whether the supports hold every piece that cracks leave of a body."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.cover.cover import Cover
from crackgrow.errors import SolveError
from crackgrow.geometry.arrangement import connected

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

HOLDS_NOTHING = 1e-8
"""Singular values below this, of constraints on the three rigid motions scaled by the piece's size, hold nothing."""


def check_held(cover: Cover, constraints: csr_array) -> None:
    """Raise SolveError, naming the motion, where `constraints` (m, n_dofs) leave a piece of a body free to move."""
    for functions in pieces(cover):
        motion = free_motion(cover, functions, constraints)
        if motion is not None:
            centre = cover.lattice.to_metres(cover.patch_nodes[functions].mean(axis=0))
            raise SolveError(
                f"the piece of rock round ({centre[0]:.3g}, {centre[1]:.3g}) m is free to move: {_named(motion)}; "
                "it needs supports of its own (a piece held by contact alone is not supported in this version)"
            )


def pieces(cover: Cover) -> list[Ints]:
    """Physical patches of each piece of rock that no way inside the rock joins to the others."""
    edges, passable = cover.elements.edges, cover.elements.passable
    label = connected(cover.elements.n, edges.left[passable], edges.right[passable])
    found = (np.unique(cover.functions[label == number]) for number in range(label.max(initial=-1) + 1))
    return [patches[patches >= 0] for patches in found]


def rigid_motions(cover: Cover, functions: Ints) -> Floats:
    """Unknowns (n_dofs, 3) of unit translations in x and y and of a rotation (1 at the rim) of physical patches."""
    nodes = cover.patch_nodes[functions]
    arm = nodes - nodes.mean(axis=0)
    arm = arm / max(np.abs(arm).max(), 1.0)
    motions = np.zeros((cover.n_dofs, 3))
    motions[2 * functions, 0] = 1.0
    motions[2 * functions + 1, 1] = 1.0
    motions[2 * functions, 2], motions[2 * functions + 1, 2] = -arm[:, 1], arm[:, 0]
    return motions


def free_motion(cover: Cover, functions: Ints, constraints: csr_array) -> Floats | None:
    """A rigid motion (3,) of a piece that the constraints do not see, None where they hold it."""
    held = constraints @ rigid_motions(cover, functions)
    _, values, motions = np.linalg.svd(np.vstack([held, np.zeros((3, 3))]))
    return None if values[-1] > HOLDS_NOTHING else np.asarray(motions[-1])


def _named(motion: Floats) -> str:
    """A rigid motion in words."""
    if abs(motion[2]) > HOLDS_NOTHING:
        return "rotation"
    angle = np.rad2deg(np.arctan2(motion[1], motion[0])) % 180.0
    return f"translation at {angle:.3g} degrees from x"
