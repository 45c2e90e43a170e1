"""Violation of the contact law by faces between contact points: it holds on average there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.contact.coulomb import OPEN
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.increments import LoadState
from crackgrow.run.result import CrackFaces
from crackgrow.run.surface_laws import SurfaceLaw
from crackgrow.run.warning_causes import WarningCause

PRESSED_FLAT = 0.03
"""Overlap of a crack's faces, over what the rock of a cell gives way to the largest pressure, that is small:
a stuck flaw under a gradient of pressure has 0.05 at 5 cells, where K is felt, 0.02 at 10. Where faces stick
their jump is next to nothing, and no measure of what overlaps."""

AT_CORNERS = 0.25
"""The same on interfaces and foundations: blocks at rest have 0.14 to 0.2 at their corners on any lattice, and sticking
between two corners next to nothing; two cells a block 0.3."""


@dataclass(frozen=True, slots=True, eq=False)
class ContactViolation:
    """By how much the faces of one surface violate its contact law."""

    face: CrackFaces
    overlap: float  # m, the largest beyond what the contact stiffness explains
    how: str  # in words, of what is the worst
    off: Floats  # (n,) m, along the surface
    shares: Floats  # (n,) of what is small there
    strain: float  # of the rock under the pressure

    @property
    def share(self) -> float:
        """The largest share of what is small: beyond 1 it warns."""
        return float(self.shares.max())


def contact_violations(solution: StepSolution, faces: tuple[CrackFaces, ...]) -> list[ContactViolation]:
    """Overlap, or gap under pressure, of each surface. It is small beside its jump, or what pressure does to rock."""
    strain, found = pressed_strain(solution, faces), []
    for surface, law, face in zip(solution.cover.surfaces, solution.scene.laws, faces, strict=True):
        overlap = np.zeros(len(face.s)) if law.contact is None else np.abs(np.minimum(inelastic_gap(law, face), 0.0))
        ways = (("overlap", overlap), ("stand apart under pressure", _apart(law, face)))
        how, off = max(ways, key=lambda way: float(way[1].max()))
        part = PRESSED_FLAT if surface.name.is_crack else AT_CORNERS
        small = np.maximum(WarningCause.OVERLAP.limit * largest_jump(face), part * strain * face.cell_size)
        shares = np.divide(off, small, out=np.zeros(len(off)), where=off > 0.0)
        found.append(ContactViolation(face, float(overlap.max()), how, off, shares, strain))
    return found


def inelastic_gap(law: SurfaceLaw, face: CrackFaces) -> Floats:
    """Gap (n,) m along a surface beyond what its stiffness explains; negative where faces overlap."""
    return np.asarray(face.opening - law.elastic_gap(face.cell_size, face.normal_traction))


def _apart(law: SurfaceLaw, face: CrackFaces) -> Floats:
    """Gap (n,) m along the pressed parts of a surface, beyond what its stiffness and its dilation explain."""
    apart = np.zeros(len(face.s))
    if law.contact is None or law.contact.worn[1] != law.contact.dilation_angle:
        return apart  # of dilation that wears slip alone does not tell what it has opened
    closed = face.state != OPEN
    within = closed[1:-1] & closed[:-2] & closed[2:]
    elastic = law.elastic_gap(face.cell_size, face.normal_traction)
    risen = law.dilation * np.abs(face.slip) + elastic
    apart[1:-1][within] = np.maximum(face.opening - risen, 0.0)[1:-1][within]
    return apart


def largest_jump(face: CrackFaces) -> float:
    """Largest jump (m) of the faces of a surface."""
    return float(np.hypot(face.opening, face.slip).max())


def pressed_strain(solution: StepSolution, faces: tuple[CrackFaces, ...]) -> float:
    """Strain of the rock under the largest pressure on any face, or under its own mean stress if larger.

    Times the side of the cells a length that neither the size of the specimen nor its rigid motion changes.
    """
    pressure = max((np.abs(f.normal_traction).max() for f in faces), default=0.0)
    return float(max(pressure, mean_stress(solution.state)) / min(m.young_prime for m in solution.scene.materials))


def mean_stress(state: LoadState) -> float:
    """Stress (Pa) that would give the softest of the rock, all over, the strain energy that there is."""
    scene = state.scene
    softest, area = min(m.young_prime for m in scene.materials), sum(region.area for region in scene.regions)
    return float(np.sqrt(2.0 * max(state.energy.strain, 0.0) * softest / area))
