"""Between the contact points of a surface: tractions are interpolated along each stretch, states are the nearest's."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.contact.coulomb import EPSILON, SLIP, STICK, ContactLaw
from crackgrow.contact.faces import ContactFaces, neighbours, points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.contact.solve import ContactOutcome
from crackgrow.cover.cover import Cover


def between_contact_points(faces: ContactFaces, surface: int, s: Floats, *values: Floats) -> list[Floats]:
    """Each of `values` (contact points,) at arc lengths s (n,) of a surface: (n,).

    Constant towards the ends of a stretch, zero on a surface without contact points.
    """
    if surface not in faces.ends:
        return [np.zeros(len(s)) for _ in values]
    left, right, share = _neighbours(faces, surface, s)
    return [found[left] + share * (found[right] - found[left]) for found in values]


def nearest_contact_point(faces: ContactFaces, surface: int, s: Floats) -> Ints:
    """Number (n,) of the contact point nearest to arc lengths s (n,) of a surface on the same stretch; -1 for none."""
    if surface not in faces.ends:
        return np.full(len(s), -1, dtype=np.int64)
    left, right, share = _neighbours(faces, surface, s)
    return np.where(share > 0.5, right, left)


def _neighbours(faces: ContactFaces, surface: int, s: Floats) -> tuple[Ints, Ints, Floats]:
    """Numbers (n,) of the contact points on both sides of arc lengths s (n,), and how far from the left."""
    mine = slice(*np.searchsorted(faces.surface, (surface, surface + 1)).tolist())
    stretch = np.searchsorted(faces.ends[surface][1:-1], s, side="right")
    left, right, share = neighbours(faces.s[mine], faces.stretch[mine], s, stretch)
    return mine.start + left, mine.start + right, share


def elastic_tractions(
    cover: Cover, faces: ContactFaces, crack: int, s: Floats, law: ContactLaw, outcome: ContactOutcome
) -> tuple[Floats, Floats]:
    """Normal and tangential traction (n,) Pa at arc lengths s (n,) of a crack, from the jump there by the elastic law.

    For contact points that are the points where the law holds: between them and on to the tip, where the jump vanishes
    with the square root of the distance, the law says more than their tractions, interpolated, do. With e and e_t the
    compliances (m/Pa) across the faces and along them, and d the tangent of the dilation angle

        p_n = (gap - d |slip - e_t p_t|) / e,    p_t = slip / e_t where the faces have never slipped.

    Elsewhere p_t is in proportion to p_n, as at the contact points, but for the cohesion of faces that slip.
    """
    if crack not in faces.ends:  # it cannot touch
        return np.zeros(len(s)), np.zeros(len(s))
    nearest = nearest_contact_point(faces, crack, s)
    gap, slip = gap_and_slip(cover, points_at(cover, crack, s), outcome.u)
    points = outcome.points
    known = (points.normal, points.tangential, law.compliance, law.shear_compliance)
    normal, tangential, across, along = between_contact_points(faces, crack, s, *known)
    memory, broken = outcome.memory, outcome.memory.broken
    rate = np.where(broken, law.dilation_of(memory.lost), 0.0)
    gap = gap - rate[nearest] * np.abs(slip - along * tangential) - memory.risen[nearest]
    pulled = (normal > 0.0) & (points.normal > 0.0)[nearest]
    across = across * np.maximum(1.0 + np.minimum(gap, 0.0) / law.most[nearest], EPSILON)
    p_n = np.where((normal < 0.0) | pulled, np.where(pulled, np.maximum(gap, 0.0), np.minimum(gap, 0.0)) / across, 0.0)
    ratio = np.divide(p_n, normal, out=np.zeros_like(normal), where=normal != 0.0)
    _, cohesion = law.bound_of(outcome.memory.lost)
    cohesive = np.where(points.state == SLIP, np.copysign(cohesion, points.tangential), 0.0)[nearest]
    never_slipped = ((points.state == STICK) & ~broken)[nearest]
    return p_n, np.where(never_slipped, slip / along, cohesive + ratio * (tangential - cohesive))
