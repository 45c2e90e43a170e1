"""Loads on crack faces: the pressure of a fluid, and the share of in-situ stress that a cut sets free."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.formula import component_at
from crackgrow.case.model import CrackPressure, InSituStress, Load
from crackgrow.contact.faces import integration_points
from crackgrow.contact.jump import jump_matrix
from crackgrow.cover.cover import Cover


def face_load_vector(cover: Cover, crack_bodies: Sequence[str], loads: Sequence[Load]) -> Floats:
    """Load vector f (n_dofs,) in N per metre of thickness; `crack_bodies` are the bodies that the cracks lie in.

    A pressure pushes each face away from the other. An in-situ stress would need the traction sigma n across the cut
    to stay what it is; on the cut faces that traction is missing.
    """
    f = np.zeros((cover.n_functions, 2))
    for index, crack in enumerate(cover.cracks):
        pressures = [load.pressure for load in loads if isinstance(load, CrackPressure) and load.crack == crack.name]
        stress = np.sum(
            [load.stress for load in loads if isinstance(load, InSituStress) and load.body == crack_bodies[index]],
            axis=0,
            initial=0.0,
        ) * np.ones(3)
        if not stress.any() and all(pressure == 0.0 for pressure in pressures):
            continue
        points, lengths = integration_points(cover, index, np.empty(0))
        xx, yy, xy = stress
        places = cover.lattice.to_metres(points.points)
        pressure = np.sum([np.zeros(len(places)), *(component_at(each, places) for each in pressures)], axis=0)
        push = points.normal @ np.array([[xx, xy], [xy, yy]]) + pressure[:, None] * points.normal
        f += jump_matrix(cover, points).T @ (lengths[:, None] * cover.lattice.spacing * push)
    return f.ravel()
