"""What stays the same through a run: the lattice, the materials and the regions of a case."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from crackgrow.case.model import Case
from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.solid.elasticity import PlaneElasticity, plane_elasticity


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A case made ready for its steps."""

    case: Case
    lattice: Lattice
    materials: tuple[PlaneElasticity, ...]  # body by body
    regions: tuple[shapely.Polygon, ...]  # body by body, m

    @property
    def contact_compliance(self) -> float:
        """1/k (m/Pa) of the contact with k = kappa E / h, zero for rigid contact."""
        kappa = self.case.numerics.contact.stiffness
        return 0.0 if kappa is None else self.lattice.spacing / (kappa * self.case.bodies[0].material.young)


def make_scene(case: Case) -> Scene:
    """Place the lattice and evaluate the materials of a case."""
    corners = np.concatenate([body.outline for body in case.bodies])
    lattice = place_lattice(corners.min(axis=0), corners.max(axis=0), case.numerics.spacing, case.numerics.support)
    materials = tuple(plane_elasticity(body.material.young, body.material.poisson, case.plane) for body in case.bodies)
    return Scene(case, lattice, materials, tuple(shapely.Polygon(body.outline) for body in case.bodies))
