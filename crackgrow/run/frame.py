"""The specimen with its fields, for output: an output mesh, and values at its nodes and in its cells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crackgrow.accuracy.energy_norm import ErrorEstimate
from crackgrow.approximation.basis import fields_at
from crackgrow.arrays import Floats
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import Elements
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.run.output_mesh import OutputMesh, output_mesh
from crackgrow.run.result import Frame
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.recovery import stress_of
from crackgrow.vectors import cross


def make_frame(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, error: ErrorEstimate | None = None
) -> Frame:
    """The frame of displacements `u` (n_dofs,) m, and of their `error` if it is known."""
    elements, mesh = cover.elements, output_mesh(cover.elements, cover.tips)
    n, middles = len(mesh.points), [mesh.points[cells].mean(axis=1) for cells in (mesh.triangles, mesh.quads)]
    _, first = np.unique(mesh.place_node, return_index=True)  # all elements that meet at a node say the same
    at, element = np.concatenate([mesh.points, *middles]), np.append(mesh.place_element[first], mesh.element)
    value, *slopes = fields_at(cover, u.reshape(-1, 2), at, element)
    places, bodies = cover.lattice.to_metres(at), elements.body[element]
    stress = stress_of(materials, np.stack(slopes, axis=2), bodies, places)
    _away_from_tips(cover, mesh, stress[:n])
    zz = np.array([material.zz for material in materials])[bodies] * (stress[:, 0] + stress[:, 1])
    return Frame(
        points=places[:n],
        triangles=mesh.triangles,
        quads=mesh.quads,
        displacement=value[:n],
        stress=stress[n:],
        stress_zz=zz[n:],
        point_stress=stress[:n],
        point_stress_zz=zz[:n],
        body=bodies[n:],
        error_density=None if error is None else _densities(elements, cover.lattice.spacing, error)[mesh.element],
    )


def _away_from_tips(cover: Cover, mesh: OutputMesh, stress: Floats) -> None:
    """Put the means of the neighbours into the stress (n, 3) at nodes at tips, where it is infinite."""
    at_tip = np.zeros(len(mesh.points), dtype=bool)
    for tip in cover.tips:
        at_tip |= (np.abs(mesh.points - tip.point) < ON_LINE).all(axis=1)
    ends = np.concatenate([mesh.sides, mesh.sides[:, ::-1]])
    ends = np.unique(ends[at_tip[ends[:, 0]] & ~at_tip[ends[:, 1]]], axis=0)
    nodes, index = np.unique(ends[:, 0], return_inverse=True)
    sums = [np.bincount(index, column, len(nodes)) for column in stress[ends[:, 1]].T]
    stress[nodes] = np.stack(sums, axis=1) / np.bincount(index, minlength=len(nodes))[:, None]


def _densities(elements: Elements, spacing: float, error: ErrorEstimate) -> Floats:
    """Root of the energy density of the error in each element (n,), by the mean density of the computed stress."""
    start, end = elements.vertices[elements.rings.start], elements.vertices[elements.rings.end]
    area = 0.5 * spacing**2 * np.bincount(elements.rings.face, cross(start, end), elements.n)
    mean = error.norm**2 / area.sum()
    there = area > 0.0  # slivers that the grid leaves no area hold no error
    density = np.divide(error.elements, area, out=np.zeros(elements.n), where=there)
    return np.sqrt(density / mean) if mean > 0.0 else np.zeros(elements.n)
