"""The contact laws of a scene: surface by surface, and from these point by point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Case, CoulombContact, Wear
from crackgrow.contact.coulomb import ContactLaw, closed_by
from crackgrow.contact.faces import ContactFaces
from crackgrow.cover.cover import Cover
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.debond import Debond, debond_number
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.geometry.tolerance import SAME_PLACE


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceLaw:
    """What holds the two faces of a surface."""

    contact: CoulombContact | None  # None: they never touch
    bonded: bool
    stiffness: float  # Pa: kappa E, of which k = kappa E / h; infinite for rigid contact

    @property
    def joint(self) -> tuple[float, float] | None:
        """Its own stiffness, Pa/m: normal and shear; None: that of the numerics holds."""
        return None if self.contact is None else self.contact.stiffness

    @property
    def elastic(self) -> bool:
        """Whether closed faces give way."""
        return self.joint is not None or bool(np.isfinite(self.stiffness))

    @property
    def table(self) -> Floats:
        """(5, k): shares that are lost; friction, cohesion (Pa), tensile strength (Pa), tan(dilation angle) then."""
        law = self.contact
        if law is None:
            return np.array([[0.0, 1.0], *np.zeros((4, 2))])
        wear = law.wear or Wear((1.0,), law.worn[:1], law.worn[1:])
        angles = wear.dilation_angle or (law.dilation_angle,) * len(wear.slip)
        lost, friction = np.array([0.0, *wear.slip]) / wear.slip[-1], [law.friction, *wear.friction]
        angle = [law.dilation_angle, *angles]
        left = 1.0 - lost
        cohesion = law.cohesion * (np.ones(len(left)) if law.cohesion_kept else left)
        return np.array([lost, friction, cohesion, law.tension * left, np.tan(np.deg2rad(angle))])

    def compliance(self, size: Floats) -> Floats:
        """1/k (2, n) m/Pa across the faces and along them, beside cells of these sizes h (n,) m; zero where rigid."""
        if self.joint is None:
            return np.tile(size / self.stiffness, (2, 1))
        return np.tile(1.0 / np.array(self.joint)[:, None], (1, len(size)))

    def elastic_gap(self, size: Floats, normal: Floats) -> Floats:
        """Gap (n,) m of closed faces under normal tractions (n,) Pa, beside such cells: not positive in compression."""
        most = (self.contact and self.contact.max_closure) or np.inf
        return -closed_by(-self.compliance(size)[0] * normal, most)


def surface_law(case: Case, contact: CoulombContact | Literal["bonded"] | None, *bodies: str) -> SurfaceLaw:
    """What holds the faces of a surface on some bodies, of which the case says this; E is that of the softer one."""
    kappa, law = case.numerics.contact.stiffness, contact if isinstance(contact, CoulombContact) else None
    softer = min(body.material.least_young for body in case.bodies if body.name in bodies)
    return SurfaceLaw(law, contact == "bonded", np.inf if kappa is None else kappa * softer)


def laws_at_points(
    laws: Sequence[SurfaceLaw],
    cover: Cover,
    faces: ContactFaces,
    growing: Sequence[GrowingCrack],
    debonds: Sequence[Debond],
) -> ContactLaw:
    """The law point by point. Faces that growth has made are broken from the start: they do not cohere."""
    compliance, along, weakening, rough = np.zeros((4, faces.n))
    most, wall, decays = np.full(faces.n, np.inf), np.ones(faces.n), np.zeros(faces.n, dtype=bool)
    tables = [law.table for law in laws]
    n_rows = max((table.shape[1] for table in tables), default=2)
    rows = np.zeros((5, n_rows, faces.n))
    for index, (law, table) in enumerate(zip(laws, tables, strict=True)):
        mine, given = faces.surface == index, law.contact
        rows[:, :, mine] = np.pad(table, ((0, 0), (0, n_rows - table.shape[1])), mode="edge")[:, :, None]
        if given is None:
            continue
        size = cover.surfaces[index].in_cells.size(faces.s[mine]) * cover.lattice.spacing
        compliance[mine], along[mine] = law.compliance(size)
        weakening[mine] = given.wear.slip[-1] if given.wear else given.decay_length or given.weakening_length
        decays[mine], most[mine] = given.decay_length > 0.0, given.max_closure or np.inf
        if given.barton is not None:
            rough[mine], wall[mine] = np.deg2rad(given.barton.jrc), given.barton.jcs
        name = cover.surfaces[index].name
        number = debond_number(debonds, name)
        if name.is_crack or number is not None:
            if number is None:
                rooted = arc_lengths(cover.lattice.to_lattice(growing[index].crack.points))[growing[index].rooted]
            else:
                rooted = debonds[number].given / cover.lattice.spacing
            new = mine & ((faces.s < rooted[0] - SAME_PLACE) | (faces.s > rooted[-1] + SAME_PLACE))
            rows[1:, :, new] = rows[1:, -1:, new]
            rows[2:4, :, new] = 0.0
    shares, friction, cohesion, tension, dilation = rows
    return ContactLaw(
        compliance, along, weakening, decays, shares, friction, cohesion, tension, dilation, most, rough, wall
    )
