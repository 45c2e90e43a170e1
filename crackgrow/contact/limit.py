"""Limit analysis: whether any tractions that the faces can carry hold the pieces of rock that contact alone holds.

The pieces are rigid here. Balance of the loads along every motion that the supports leave free asks for tractions with

    p_n <= 0,   |p_t| <= c - mu p_n

(static theorem, Drucker, Greenberg, Prager 1952). Where there are none, nothing holds the pieces. Where there are some,
faces that slide without dilating may still let the pieces go (Drucker 1954): only the contact problem tells.
"""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.contact.problem import Motions
from crackgrow.errors import NotSolvedError

AMPLE = 1e6
"""Times the mean traction of the loads: more cohesion than that is as good as that."""


def least_unbalanced(
    motions: Motions, size: float, length: float, friction: Floats, cohesion: Floats
) -> tuple[float, Floats]:
    """The least part of the loads that the faces leave unbalanced, and the motion (l,) along which they give way.

    `size` (N/m) is that of the loads, `length` (m) that of all n contact points, with friction (n,) and cohesion (n,)
    Pa. Raises NotSolvedError where linear programming fails.
    """
    from scipy.optimize import linprog  # here: loading it takes a tenth of a second, and few scenes need it

    n, k = len(friction), len(motions.pull)
    if size == 0.0:
        return 0.0, np.zeros(k)
    pressure = size / length  # Pa, as a measure
    cohesion = np.minimum(cohesion, AMPLE * pressure)
    forces = motions.force * (pressure / size)
    law = [np.concatenate([np.diag(friction), sign * np.eye(n), np.zeros((n, 2 * k))], axis=1) for sign in (1.0, -1.0)]
    found = linprog(
        np.repeat([0.0, 1.0], [2 * n, 2 * k]),
        A_ub=np.concatenate(law),
        b_ub=np.tile(cohesion / pressure, 2),
        A_eq=np.concatenate([forces, np.eye(k), -np.eye(k)], axis=1),
        b_eq=motions.pull / size,
        bounds=[(None, 0.0)] * n + [(None, None)] * n + [(0.0, None)] * (2 * k),
        method="highs",
    )
    if not found.success:
        raise NotSolvedError(f"whether contact can hold all pieces of rock was not found: {found.message}")
    return float(found.fun), np.asarray(found.eqlin.marginals)
