"""The specimen with its fields, for output: an output mesh, and values at its nodes and in its cells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import KDTree

from crackgrow.approximation.basis import basis_at
from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import Elements
from crackgrow.estimate.error_estimate import ErrorEstimate
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.run.output_mesh import OutputMesh, output_mesh
from crackgrow.run.result import Frame
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.recovery import stress_at, stress_of
from crackgrow.vectors import cross


def make_frame(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, error: ErrorEstimate | None = None
) -> Frame:
    """The frame of displacements `u` (n_dofs,) m, and of their `error` if it is known."""
    elements, mesh = cover.elements, output_mesh(cover.elements, cover.tips)
    displacement, point_stress = _at_nodes(cover, materials, u, mesh)
    centres = np.concatenate([mesh.points[cells].mean(axis=1) for cells in (mesh.triangles, mesh.quads)])
    stress = stress_at(cover, materials, u, centres, mesh.element)
    body = elements.body[mesh.element]
    body_of_node = np.empty(len(mesh.points), dtype=np.int64)
    body_of_node[mesh.place_node] = elements.body[mesh.place_element]
    out_of_plane = np.array([material.zz for material in materials])
    return Frame(
        points=cover.lattice.to_metres(mesh.points),
        triangles=mesh.triangles,
        quads=mesh.quads,
        displacement=displacement,
        stress=stress,
        stress_zz=out_of_plane[body] * (stress[:, 0] + stress[:, 1]),
        point_stress=point_stress,
        point_stress_zz=out_of_plane[body_of_node] * (point_stress[:, 0] + point_stress[:, 1]),
        body=body,
        error_density=None if error is None else _densities(elements, cover.lattice.spacing, error)[mesh.element],
    )


def _at_nodes(cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, mesh: OutputMesh) -> tuple[Floats, Floats]:
    """Displacement (n, 2) m and stress (n, 3) Pa at the nodes: means of what the elements that meet there say.

    Plain elements say the same.
    """
    told = np.zeros(len(mesh.points), dtype=bool)
    told[mesh.place_node[~cover.plain[mesh.place_element]]] = True
    told = told[mesh.place_node]
    told[np.unique(mesh.place_node, return_index=True)[1]] = True
    node, element = mesh.place_node[told], mesh.place_element[told]
    value, *slopes = basis_at(cover, mesh.points[node], element).field(u.reshape(-1, 2))
    places = cover.lattice.to_metres(mesh.points[node])
    stress = stress_of(materials, np.stack(slopes, axis=2), cover.elements.body[element], places)
    found = _means(node, np.concatenate([value, stress], axis=1), len(mesh.points))
    if cover.tips:
        distance, _ = KDTree([tip.point for tip in cover.tips]).query(mesh.points)
        ends = np.concatenate([mesh.sides, mesh.sides[:, ::-1]])
        ends = np.unique(ends[(distance[ends[:, 0]] < ON_LINE) & (distance[ends[:, 1]] >= ON_LINE)], axis=0)
        at_tip, index = np.unique(ends[:, 0], return_inverse=True)
        found[at_tip, 2:] = _means(index, found[ends[:, 1], 2:], len(at_tip))
    return found[:, :2], found[:, 2:]


def _means(row: Ints, values: Floats, n: int) -> Floats:
    """Means (n, m) of the `values` (k, m) of each row (k,)."""
    sums = [np.bincount(row, column, n) for column in values.T]
    return np.asarray(np.stack(sums, axis=1) / np.bincount(row, minlength=n)[:, None])


def _densities(elements: Elements, spacing: float, error: ErrorEstimate) -> Floats:
    """Root of the energy density of the error in each element (n,), by the mean density of the computed stress."""
    start, end = elements.vertices[elements.rings.start], elements.vertices[elements.rings.end]
    area = 0.5 * spacing**2 * np.bincount(elements.rings.face, cross(start, end), elements.n)
    mean = error.norm**2 / area.sum()
    there = area > 0.0  # slivers that the grid leaves no area hold no error
    density = np.divide(error.elements, area, out=np.zeros(elements.n), where=there)
    return np.sqrt(density / mean) if mean > 0.0 else np.zeros(elements.n)
