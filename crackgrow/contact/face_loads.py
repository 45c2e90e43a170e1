"""Loads on crack faces: a fluid by its pressure or by its volume, and the share of in-situ stress that a cut sets free.

The mean opening of faces is the work that a unit force does on them as a pressure. So the volume of a fluid is a linear
constraint, and the force that holds it the pressure. Faces that are shut hold no volume, whatever the pressure: the
fluid is a little compressible, and its pressure is told where all faces touch, too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array

from crackgrow.arrays import Floats
from crackgrow.case.formula import component_at
from crackgrow.case.model import Component, FluidPressure, FluidVolume, InSituStress, Load
from crackgrow.contact.faces import integration_points
from crackgrow.contact.jump import jump_matrix
from crackgrow.cover.cover import Cover
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.quadrature.subdivision import subdivided
from crackgrow.solid.in_situ import InSitu
from crackgrow.solid.supports import Constraints
from crackgrow.vectors import across

STORAGE = 1e-5
"""Compliance of a fluid, over 1/E' of the rock: of the pressure in an open crack it takes less than 1e-5."""


def face_load_vector(cover: Cover, crack_bodies: Sequence[str], loads: Sequence[Load]) -> Floats:
    """Load vector f (n_dofs,) in N per metre of thickness; `crack_bodies` are the bodies that the cracks lie in.

    A pressure pushes each face away from the other. An in-situ stress would need the traction sigma n across the cut
    to stay what it is; on the cut faces that traction is missing. On interfaces the rims of both bodies see to that.
    """
    f = np.zeros((cover.n_functions, 2))
    for index, surface in enumerate(cover.surfaces):
        fluids = [load for load in loads if isinstance(load, FluidPressure)]
        pressures = [load.pressure for load in fluids if load.fills(surface.name)]
        stress = InSitu()
        for load in loads if surface.name.is_crack else ():
            if isinstance(load, InSituStress) and load.body == crack_bodies[index]:
                stress = stress.plus(load, 1.0)
        if stress == InSitu() and all(pressure == 0.0 for pressure in pressures):
            continue
        points, lengths = integration_points(cover, index, _breaks(cover, index, pressures))
        places = cover.lattice.to_metres(points.points)
        push = across(stress.at(places), points.normal) + _sum_at(pressures, places)[:, None] * points.normal
        f += jump_matrix(cover, points).T @ (lengths[:, None] * cover.lattice.spacing * push)
    return f.ravel()


def volumes(cover: Cover, modulus: float, loads: Sequence[Load]) -> list[Constraints]:
    """The constraints of all volumes of fluid: mean opening + compliance times force = volume over length of the faces.

    `modulus` is E' (Pa) of the softest rock.
    """
    found, none, compliance = [], np.full(1, -1), np.array([STORAGE / modulus])
    for number, load in enumerate(loads):
        if isinstance(load, FluidVolume):
            length = filled_length(cover, load)
            pressed = FluidPressure(surface=load.surface, beyond=load.beyond, pressure=1.0)
            row = csr_array((face_load_vector(cover, [], [pressed]) / length)[None])
            given = np.array([load.volume / length])
            found.append(Constraints(row, given, none, none, none, np.array([number]), compliance))
    return found


def filled_length(cover: Cover, load: FluidVolume) -> float:
    """Return the length (m) of all cracks and interfaces that a volume of fluid fills, each line once."""
    lines = [surface.line.points for surface in cover.surfaces if load.fills(surface.name)]
    return cover.lattice.spacing * sum(float(arc_lengths(points)[-1]) for points in lines)


def _sum_at(pressures: Sequence[Component], places: Floats) -> Floats:
    """The sum (n,) Pa of some pressures at places (n, 2) m."""
    return np.asarray(np.sum([np.zeros(len(places)), *(component_at(each, places) for each in pressures)], axis=0))


def _breaks(cover: Cover, index: int, pressures: Sequence[Component]) -> Floats:
    """Arc lengths (n,) along a surface between which its points integrate the pressures."""
    edges = cover.surfaces[index].edges
    edge, limits = subdivided(edges.points, lambda at, _: _sum_at(pressures, cover.lattice.to_metres(at))[:, None])
    return np.asarray(edges.parts(edge, limits).s[limits[:, 0] > 0.0, 0])
