"""The contact laws of a scene: surface by surface, and from these point by point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Case, CoulombContact
from crackgrow.contact.coulomb import ContactLaw
from crackgrow.contact.faces import ContactFaces
from crackgrow.cover.cover import Cover
from crackgrow.fracture.advance import GrowingCrack
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
    def dilation(self) -> float:
        """What slip opens: tan(dilation angle)."""
        return 0.0 if self.contact is None else float(np.tan(np.deg2rad(self.contact.dilation_angle)))

    def compliance(self, size: Floats) -> Floats:
        """1/k (n,) m/Pa across the faces beside cells of these sizes h (n,) m; zero for rigid contact."""
        return np.asarray(size / self.stiffness) if self.joint is None else np.full(len(size), 1.0 / self.joint[0])

    def shear_compliance(self, size: Floats) -> Floats:
        """The same along the faces."""
        return np.asarray(size / self.stiffness) if self.joint is None else np.full(len(size), 1.0 / self.joint[1])


def contact_stiffness(case: Case, bodies: tuple[str, ...]) -> float:
    """kappa E (Pa) of contact, E of the softer body; infinite for rigid contact."""
    kappa = case.numerics.contact.stiffness
    if kappa is None:
        return np.inf
    young = min(body.material.young for body in case.bodies if body.name in bodies)
    return kappa * young


def laws_at_points(
    laws: Sequence[SurfaceLaw], cover: Cover, faces: ContactFaces, growing: Sequence[GrowingCrack]
) -> ContactLaw:
    """The law point by point. Faces that growth has made are broken from the start: they do not cohere."""
    friction, cohesion, compliance, along, residual, dilation, weakening, tension = np.zeros((8, faces.n))
    kept = np.zeros(faces.n, dtype=bool)
    for index, law in enumerate(laws):
        if law.contact is None:
            continue
        mine = faces.surface == index
        friction[mine], cohesion[mine] = law.contact.friction, law.contact.cohesion
        size = cover.surfaces[index].in_cells.size(faces.s[mine]) * cover.lattice.spacing
        compliance[mine], along[mine] = law.compliance(size), law.shear_compliance(size)
        residual[mine], kept[mine] = law.contact.residual_friction, law.contact.cohesion_kept
        dilation[mine] = law.dilation
        weakening[mine], tension[mine] = law.contact.weakening_length, law.contact.tension
        if cover.surfaces[index].name.is_crack:
            crack = growing[index]
            given = arc_lengths(cover.lattice.to_lattice(crack.crack.points))[crack.rooted]
            new = mine & ((faces.s < given[0] - SAME_PLACE) | (faces.s > given[-1] + SAME_PLACE))
            cohesion[new], tension[new], friction[new] = 0.0, 0.0, law.contact.residual_friction
    return ContactLaw(friction, cohesion, compliance, along, residual, kept, dilation, weakening, tension)
