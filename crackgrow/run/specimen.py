"""Mean stress and mean strain of the whole specimen: what a testing machine measures.

With the displacement u and the outward normal n along the outer outline of the area A,

    mean strain = 1/(2 A) int (u n' + n u') ds,    mean stress = 1/A int sigma dA    (Hill 1963),

so that the opening and slip of cracks are in the strain. Holes are a part of A that bears no stress, whatever presses
on their rims. The functions of the patches hold a linear displacement with the places x of their nodes as coefficients:
with the internal forces f = K u the integral of the stress is the sum of (x f' + f x')/2 over the patches, to which the
in-situ stress comes.
"""

from __future__ import annotations

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.quadrature.elements import element_points
from crackgrow.quadrature.rims import points_on_outlines
from crackgrow.run.increments import LoadState
from crackgrow.solid.recovery import displacement_at
from crackgrow.vectors import outward_normals

Components = tuple[float, float, float]
"""xx, yy and xy of a symmetric tensor."""


def specimen_means(state: LoadState) -> tuple[Components, Components]:
    """Mean stress (Pa) and mean strain of the specimen; the shear strain is half the angle."""
    whole = shapely.union_all(state.scene.regions)
    outer = shapely.union_all(shapely.polygons(shapely.get_exterior_ring(shapely.get_parts(whole))))
    (a, b, c), (d, e, f) = _stress_integral(state) / outer.area, _strain_integral(state, outer) / outer.area
    return (float(a), float(b), float(c)), (float(d), float(e), float(f))


def _stress_integral(state: LoadState) -> Floats:
    cover, lattice = state.cover, state.cover.lattice
    nodes = lattice.to_metres(cover.patches.nodes)
    forces = (state.configuration.stiffness.matrix @ state.outcome.u).reshape(-1, 2)[: len(nodes)]
    total = _symmetric(nodes.T @ forces)
    for region, material in zip(state.scene.regions, state.materials, strict=True):
        total += region.area * np.array(material.initial.uniform)
    if any(material.initial.varying for material in state.materials):
        at = element_points(cover, state.scene.case.numerics.quadrature)
        body, places = cover.elements.body[at.element], lattice.to_metres(at.points)
        for number, material in enumerate(state.materials):
            mine = body == number
            total += lattice.spacing**2 * at.weights[mine] @ material.initial.more_at(places[mine])
    return total


def _strain_integral(state: LoadState, outer: shapely.Geometry) -> Floats:
    cover, lattice, outlines = state.cover, state.cover.lattice, state.cover.elements.outlines
    middle = shapely.points(lattice.to_metres(outlines.points.mean(axis=1)))
    on_rim = shapely.dwithin(outer.boundary, middle, SAME_PLACE * lattice.spacing)
    ends, element = outlines.points[on_rim], outlines.element[on_rim]
    edge, points, length = points_on_outlines(cover, ends, element, outlines.edge[on_rim])
    u = displacement_at(cover, state.outcome.u, points, element[edge])
    normals = outward_normals(ends[:, 1] - ends[:, 0])[edge]
    return _symmetric((length[:, None] * lattice.spacing * u).T @ normals)


def _symmetric(of: Floats) -> Floats:
    """xx, yy and xy of the symmetric part of a tensor (2, 2)."""
    return np.array([of[0, 0], of[1, 1], 0.5 * (of[0, 1] + of[1, 0])])
