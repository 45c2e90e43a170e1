"""How a configuration lies on its cells: cover, contact points and constraints. Nothing is integrated for them."""

from __future__ import annotations

import numpy as np
import shapely

from crackgrow.case.model import FluidVolume
from crackgrow.contact.faces import ContactFaces, gauss_faces
from crackgrow.contact.mortar import mortar_faces
from crackgrow.cover.cover import Cover, build_cover
from crackgrow.cover.refinement import divided, refined
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.cover.squares import Squares
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.geometry.tolerance import ON_LINE, SAME_PART
from crackgrow.run.scene import Scene
from crackgrow.run.size_field import size_field
from crackgrow.solid.supports import Constraints, constraints, joined_constraints, n_constraints, ties


def cover_of(scene: Scene, growing: tuple[GrowingCrack, ...]) -> Cover:
    """The cover of a scene with its cracks. Raises GeometryError where it can't be made."""
    cracks = _geometries(scene, growing)
    lattice = refined(scene.lattice, size_field(scene.at_start, cracks), quartered=scene.grading.quartered)
    return build_cover(lattice, scene.bodies, cracks, scene.interfaces, scene.foundations)


def cells_of(scene: Scene, growing: tuple[GrowingCrack, ...]) -> Squares:
    """The cells of `cover_of`, without the lattice that is made of them."""
    cells = divided(scene.lattice, size_field(scene.at_start, _geometries(scene, growing)))
    return cells.quartered() if scene.grading.quartered else cells


def _geometries(scene: Scene, growing: tuple[GrowingCrack, ...]) -> list[CrackGeometry]:
    return [crack_geometry(scene, crack, body) for crack, body in zip(growing, scene.crack_bodies, strict=True)]


def crack_geometry(scene: Scene, growing: GrowingCrack, body: int) -> CrackGeometry:
    """The crack in lattice coordinates. An end is a tip unless it lies on its body's rim, whether it can grow or not.

    `body` is the one that it lies in. Given vertices at which the crack does not turn are left out: a straight stretch
    is one whatever it was put together from, for the cover as for the disc of the integrals of K. Where growth began
    a vertex stays: faces remember up to there.
    """
    points = growing.crack.points.copy()
    inside = [True, True]
    boundary = scene.regions[body].boundary
    for index, end in enumerate((0, -1)):
        place = shapely.Point(points[end])
        if shapely.dwithin(boundary, place, SAME_PART * boundary.length):
            points[end] = shapely.shortest_line(boundary, place).coords[0]
            inside[index] = False
    points = scene.lattice.to_lattice(points)
    first, last = np.flatnonzero(growing.rooted)[[0, -1]]
    given = shapely.get_coordinates(shapely.simplify(shapely.LineString(points[first : last + 1]), ON_LINE))
    points = np.concatenate([points[:first], given, points[last + 1 :]])
    gathered = scene.case.numerics.gathers_tip_functions
    return CrackGeometry(growing.crack.surface, points, inside[0], inside[1], gathered=gathered)


def contact_faces(scene: Scene, cover: Cover) -> ContactFaces:
    """The contact points of the surfaces that have a contact law."""
    touching = [index for index, law in enumerate(scene.laws) if law.contact is not None]
    settings = scene.case.numerics.contact
    if settings.discretization == "gauss":
        return gauss_faces(cover, touching)
    return mortar_faces(cover, touching, settings.spacing, nested=scene.grading.quartered)


def constraints_of(scene: Scene, cover: Cover) -> Constraints:
    """The supports, bonded interfaces (no gap and no slip, averaged at mortar nodes), and volumes of fluid."""
    from scipy.sparse import csr_array, vstack  # here: who counts conditions alone needs neither it nor the basis

    from crackgrow.contact.face_loads import volumes
    from crackgrow.contact.jump import contact_operators

    parts, faces = [constraints(cover, scene.case.supports)], _bonded_faces(scene, cover)
    if len(faces.surface):
        rows = csr_array(vstack(contact_operators(cover, faces), format="csr"))
        parts.append(ties(rows, np.tile(faces.surface, 2)))
    modulus = min(material.young_prime for material in scene.materials)
    return joined_constraints([*parts, *volumes(cover, modulus, scene.case.loads)])


def n_constraints_of(scene: Scene, cover: Cover) -> int:
    """How many rows `constraints_of` has."""
    n_volumes = sum(isinstance(load, FluidVolume) for load in scene.case.loads)
    return n_constraints(cover, scene.case.supports) + 2 * len(_bonded_faces(scene, cover).surface) + n_volumes


def _bonded_faces(scene: Scene, cover: Cover) -> ContactFaces:
    """Mortar nodes along bonded interfaces."""
    bonded = [index for index, law in enumerate(scene.laws) if law.bonded]
    return mortar_faces(cover, bonded, scene.case.numerics.contact.spacing, nested=scene.grading.quartered)
