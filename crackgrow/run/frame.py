"""The specimen as a mesh for output, its nodes double along cracks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import Elements
from crackgrow.estimate.error_estimate import ErrorEstimate
from crackgrow.geometry.arrangement import connected, vertex_ids
from crackgrow.quadrature.elements import triangulate
from crackgrow.run.result import Frame
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.recovery import displacement_at, stress_at
from crackgrow.vectors import cross


def make_frame(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, error: ErrorEstimate | None = None
) -> Frame:
    """Mesh of all elements: whole tiles as quads, polygons as triangles; `u` (n_dofs,) m, and its `error` if known."""
    elements = cover.elements
    triangles, triangle_element = triangulate(elements.polygons)
    triangle_element = triangle_element + elements.n_whole
    quads = elements.ring_start[: 4 * elements.n_whole].reshape(-1, 4)
    corner_element = np.concatenate([np.repeat(triangle_element, 3), np.repeat(np.arange(elements.n_whole), 4)])
    corner_vertex = np.concatenate([_vertex_of(elements, triangles.reshape(-1, 2)), quads.ravel()])
    node, first = _nodes(elements, corner_vertex, corner_element)
    n_corners = 3 * len(triangles)
    points = elements.vertices[corner_vertex[first]]
    centres = np.concatenate([triangles.mean(axis=1), elements.vertices[quads].mean(axis=1)])
    cell_element = np.concatenate([triangle_element, np.arange(elements.n_whole)])
    stress = stress_at(cover, materials, u, centres, cell_element)
    body = elements.body[cell_element]
    density = None if error is None else _densities(elements, cover.lattice.spacing, error)[cell_element]
    out_of_plane = np.array([material.zz for material in materials])[body]
    return Frame(
        points=cover.lattice.to_metres(points),
        triangles=node[:n_corners].reshape(-1, 3),
        quads=node[n_corners:].reshape(-1, 4),
        displacement=displacement_at(cover, u, points, corner_element[first]),
        stress=stress,
        stress_zz=out_of_plane * (stress[:, 0] + stress[:, 1]),
        body=body,
        error_density=density,
    )


def _densities(elements: Elements, spacing: float, error: ErrorEstimate) -> Floats:
    """Root of the energy density of the error in each element (n,), by the mean density of the computed stress."""
    start, end = elements.vertices[elements.ring_start], elements.vertices[elements.ring_end]
    area = 0.5 * spacing**2 * np.bincount(elements.ring_element, cross(start, end), elements.n)
    mean = error.norm**2 / area.sum()
    there = area > 0.0  # slivers that the grid leaves no area hold no error
    density = np.divide(error.elements, area, out=np.zeros(elements.n), where=there)
    return np.sqrt(density / mean) if mean > 0.0 else np.zeros(elements.n)


def _vertex_of(elements: Elements, points: Floats) -> Ints:
    """Vertex ids (n,) of points (n, 2) that are vertices."""
    ids = vertex_ids(np.concatenate([elements.vertices, points]))
    vertex = np.empty(int(ids.max()) + 1, dtype=np.int64)
    vertex[ids[: len(elements.vertices)]] = np.arange(len(elements.vertices))
    return vertex[ids[len(elements.vertices) :]]


def _nodes(elements: Elements, vertex: Ints, element: Ints) -> tuple[Ints, Ints]:
    """Node (n,) of every cell corner, and a corner (m,) of every node.

    Corners at a vertex are one node if a way round the vertex leads from one to the other without crossing a crack.
    """
    pair = vertex * elements.n + element
    pairs, inverse = np.unique(pair, return_inverse=True)
    passable = elements.passable
    ends = np.concatenate([elements.edges.a[passable], elements.edges.b[passable]])
    left = np.searchsorted(pairs, ends * elements.n + np.tile(elements.edges.left[passable], 2))
    right = np.searchsorted(pairs, ends * elements.n + np.tile(elements.edges.right[passable], 2))
    node = connected(len(pairs), left, right)[inverse]
    _, first = np.unique(node, return_index=True)
    return node, first
