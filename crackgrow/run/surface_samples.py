"""What the surfaces of a solution show: their contact points, and samples all along them."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.contact.coulomb import OPEN
from crackgrow.contact.faces import FacePoints, joined, points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.contact.solve import ContactOutcome, PointStates
from crackgrow.contact.tractions import between_contact_points, nearest_contact_point
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.run.configuration import Configuration
from crackgrow.run.result import ContactPoints, CrackFaces


def along_surfaces(
    configuration: Configuration, outcome: ContactOutcome
) -> tuple[ContactPoints, tuple[CrackFaces, ...]]:
    """Contact points and samples of all surfaces; opening and slip are the jump of displacement at the points."""
    cover, nodes = configuration.cover, configuration.faces.nodes
    samples = [_samples(configuration, index) for index in range(len(cover.surfaces))]
    jumps = np.stack(gap_and_slip(cover, joined([nodes, *samples]), outcome.u))
    at_nodes, *along = np.split(jumps, np.cumsum([len(part.s) for part in (nodes, *samples)])[:-1], axis=1)
    each = zip(range(len(samples)), samples, along, strict=True)
    faces = [_faces(configuration, outcome.points, *surface) for surface in each]
    return _contact(configuration, outcome.points, at_nodes), tuple(faces)


def _contact(configuration: Configuration, at_points: PointStates, jump: Floats) -> ContactPoints:
    """Tractions and states as solved, with the `jump` (2, n) m at the points."""
    faces, cover, lattice = configuration.faces, configuration.cover, configuration.cover.lattice
    return ContactPoints(
        crack=tuple(str(cover.surfaces[index].name) for index in faces.surface.tolist()),
        s=faces.s * lattice.spacing,
        points=lattice.to_metres(faces.nodes.points),
        normal_traction=at_points.normal,
        tangential_traction=at_points.tangential,
        opening=jump[0],
        slip=jump[1],
        state=at_points.state,
        mean_opening=at_points.opening,
        mean_slip=at_points.slip,
    )


def _samples(configuration: Configuration, index: int) -> FacePoints:
    """The ends of all edges of a surface and its contact points, each place once."""
    cover, faces = configuration.cover, configuration.faces
    places = np.sort(np.concatenate([cover.surfaces[index].edges.s.ravel(), faces.s[faces.surface == index]]))
    return points_at(cover, index, places[np.diff(places, prepend=-np.inf) > SAME_PLACE])


def _faces(
    configuration: Configuration, at_points: PointStates, index: int, samples: FacePoints, jump: Floats
) -> CrackFaces:
    """Jump (2, n) m, tractions and state of one surface at its samples."""
    faces, s, surface = configuration.faces, samples.s, configuration.cover.surfaces[index]
    lattice = configuration.cover.lattice
    nearest = nearest_contact_point(faces, index, s)
    normal, tangential = between_contact_points(faces, index, s, at_points.normal, at_points.tangential)
    return CrackFaces(
        crack=str(surface.name),
        s=s * lattice.spacing,
        points=lattice.to_metres(samples.points),
        opening=jump[0],
        slip=jump[1],
        normal_traction=normal,
        tangential_traction=tangential,
        state=np.append(at_points.state, OPEN)[nearest],  # the last entry serves the index -1
        cell_size=surface.in_cells.size(s) * lattice.spacing,
    )
