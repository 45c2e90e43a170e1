"""Loads on bodies: on edges, at points, weight, in-situ stress. Those on crack faces are in `contact.face_loads`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case import model
from crackgrow.case.units import place_text
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.cover.face_edges import FaceEdges
from crackgrow.cover.shapes import body_index
from crackgrow.errors import GeometryError
from crackgrow.quadrature.elements import element_points
from crackgrow.quadrature.rims import points_on_outlines
from crackgrow.quadrature.subdivision import subdivided
from crackgrow.solid.in_situ import InSitu
from crackgrow.solid.supports import points_along
from crackgrow.vectors import across, outward_normals


def load_vector(cover: Cover, bodies: Sequence[model.Body], loads: Sequence[model.Load], n: int) -> Floats:
    """Load vector f (n_dofs,) in N per metre of thickness, paper eq. (15), of all loads but those on crack faces.

    `n` Gauss points per direction, as for the stiffness.
    """
    from crackgrow.approximation.basis import values_at  # here: who asks for the forces alone needs no basis

    points, elements, forces = point_forces(cover, bodies, loads, n)
    if not len(points):
        return np.zeros(cover.n_dofs)
    return np.asarray(values_at(cover, points, elements).T @ forces).ravel()


Forces = tuple[Floats, Ints, Floats]
"""Points (n, 2) in lattice coordinates, elements (n,) that they lie in, and forces (n, 2) N/m on the rock there."""


def point_forces(cover: Cover, bodies: Sequence[model.Body], loads: Sequence[model.Load], n: int) -> Forces:
    """The loads, all but those on crack faces, as forces at the points of their integrals."""
    parts = _edge_tractions(
        cover, [load for load in loads if isinstance(load, model.EdgeTraction | model.EdgePressure)]
    )
    for load in loads:
        if isinstance(load, model.Gravity):
            body = body_index(bodies, load.body)
            density = bodies[body].material.density
            assert density is not None  # the case was checked
            parts.append(_body_forces(cover, body, n, density * np.asarray(load.acceleration)))
        elif isinstance(load, model.InSituStress):
            body, stress = body_index(bodies, load.body), InSitu().plus(load, 1.0)
            points, elements, forces = _rim_tractions(cover, body, stress)
            parts.append((points, elements, -forces))
            if stress.varying:
                parts.append(_body_forces(cover, body, n, partial(stress.divergence, spacing=cover.lattice.spacing)))
        elif isinstance(load, model.FarField):
            parts.append(_rim_tractions(cover, body_index(bodies, load.body), InSitu().plus(load, 1.0), load.region))
        elif isinstance(load, model.PointForce):
            parts.append(_at_point(cover, body_index(bodies, load.body), load))
    parts.append((np.empty((0, 2)), np.empty(0, dtype=np.int64), np.empty((0, 2))))
    points, elements, forces = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    return points, elements, forces


def _at_point(cover: Cover, body: int, load: model.PointForce) -> Forces:
    """A force at a point. Raises GeometryError where no rock of the body is."""
    at = cover.lattice.to_lattice(load.point[None])
    element = locate(cover.lattice, cover.elements, at, body)
    if element[0] < 0:
        raise GeometryError(
            f"the force at {place_text(load.point + cover.lattice.map_origin)} lies outside of body '{load.body}'"
        )
    return at, element, np.array([load.force], dtype=float)


def _edge_tractions(cover: Cover, loads: Sequence[model.EdgeTraction | model.EdgePressure]) -> list[Forces]:
    """Tractions and pressures along edges, load by load."""
    edges = points_along(cover, [_fine_enough(cover, load, cover.edges_on(load.region)) for load in loads])
    found = []
    for edge, load in zip(edges, loads, strict=True):
        traction = load.traction_at(cover.lattice.to_metres(edge.points), edge.outward)
        found.append((edge.points, edge.elements, edge.lengths[:, None] * traction))
    return found


def _fine_enough(cover: Cover, load: model.EdgeTraction | model.EdgePressure, edges: FaceEdges) -> FaceEdges:
    """The edges along a load, cut where it varies by more than their points can tell."""
    components = (load.pressure,) if isinstance(load, model.EdgePressure) else load.traction
    if not any(map(callable, components)):
        return edges
    outward = outward_normals(edges.points[:, 1] - edges.points[:, 0])

    def traction(places: Floats, edge: Ints) -> Floats:
        return load.traction_at(cover.lattice.to_metres(places), outward[edge])

    edge, limits = subdivided(edges.points, traction)
    return edges if len(edge) == len(edges.edge) else edges.parts(edge, limits)


def _rim_tractions(cover: Cover, body: int, stress: InSitu, region: model.EdgeRegion | None = None) -> Forces:
    """Tractions sigma n along the rim of a body, or a region of it.

    By the divergence theorem this, with the crack faces' part and less the integral of phi div sigma, is the integral
    of B' sigma. On the rim it cancels tractions that balance the stress exactly, inside so does the divergence weight.
    """
    outlines = cover.elements.outlines
    mine = np.flatnonzero(outlines.body == body)
    if region is not None:
        side = outlines.side[mine]
        corner, step = np.moveaxis(np.diff(cover.bodies[body].sides[side], axis=1, prepend=0.0), 1, 0)
        share = np.sum((outlines.points[mine].mean(axis=1) - corner) * step, axis=1) / np.sum(step * step, axis=1)
        mine = mine[region.holds(side, share)]
    ends, element = outlines.points[mine], outlines.element[mine]
    edge, points, length = points_on_outlines(cover, ends, element, outlines.edge[mine])
    outward = outward_normals(ends[:, 1] - ends[:, 0])
    traction = across(stress.at(cover.lattice.to_metres(points)), outward[edge])
    return points, element[edge], length[:, None] * cover.lattice.spacing * traction


def _body_forces(cover: Cover, body: int, n: int, force: Floats | Callable[[Floats], Floats]) -> Forces:
    """A force b (2,) N/m^3, or (k, 2) at places (k, 2) m, over a body."""
    lattice, at = cover.lattice, element_points(cover, n)
    mine = np.flatnonzero(cover.elements.body[at.element] == body)
    density = force(lattice.to_metres(at.points[mine])) if callable(force) else force
    return at.points[mine], at.element[mine], at.weights[mine, None] * density * lattice.spacing**2
