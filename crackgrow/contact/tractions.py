"""Between the contact points of a surface: tractions are interpolated along each stretch, states are the nearest's."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from crackgrow.contact.coulomb import SLIP, STICK
from crackgrow.contact.faces import ContactFaces, points_at, stretch_ends
from crackgrow.contact.jump import gap_and_slip
from crackgrow.contact.law import ContactLaw
from crackgrow.contact.solve import ContactOutcome
from crackgrow.cover.cover import Cover

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def between_contact_points(cover: Cover, faces: ContactFaces, surface: int, s: Floats, values: Floats) -> Floats:
    """Values (n,) at arc lengths s (n,) of a surface from those of all contact points (contact points,).

    Constant towards the ends of a stretch, zero on a surface without contact points.
    """
    found = np.zeros(len(s))
    for there, nodes in _stretches(cover, faces, surface, s):
        found[there] = np.interp(s[there], faces.s[nodes], values[nodes])
    return found


def nearest_contact_point(cover: Cover, faces: ContactFaces, surface: int, s: Floats) -> Ints:
    """Number (n,) of the contact point nearest to arc lengths s (n,) of a surface on the same stretch; -1 for none."""
    found = np.full(len(s), -1, dtype=np.int64)
    for there, nodes in _stretches(cover, faces, surface, s):
        found[there] = nodes[np.abs(s[there, None] - faces.s[nodes]).argmin(axis=1)]
    return found


def _stretches(cover: Cover, faces: ContactFaces, surface: int, s: Floats) -> Iterator[tuple[Ints, Ints]]:
    """Stretch by stretch: which of s (n,) lie on it, and the numbers of its contact points."""
    mine = np.flatnonzero(faces.surface == surface)
    if len(mine) == 0:
        return
    stretch = np.searchsorted(stretch_ends(cover.surfaces[surface])[1:-1], s, side="right")
    for number in np.unique(stretch):
        yield np.flatnonzero(stretch == number), mine[faces.stretch[mine] == number]


def elastic_tractions(
    cover: Cover, faces: ContactFaces, crack: int, s: Floats, law: ContactLaw, outcome: ContactOutcome
) -> tuple[Floats, Floats]:
    """Normal and tangential traction (n,) Pa at arc lengths s (n,) of a crack, from the jump there by the elastic law.

    For contact points that are the points where the law holds: between them and on to the tip, where the jump vanishes
    with the square root of the distance, the law says more than their tractions, interpolated, do. With e the
    compliance (m/Pa) and d the tangent of the dilation angle

        p_n = (gap - d |slip - e p_t|) / e,    p_t = slip / e where the faces have never slipped.

    Elsewhere p_t is in proportion to p_n, as at the contact points, but for the cohesion of faces that slip.
    """
    if not (faces.surface == crack).any():  # it cannot touch
        return np.zeros(len(s)), np.zeros(len(s))
    nearest = nearest_contact_point(cover, faces, crack, s)
    gap, slip = gap_and_slip(cover, points_at(cover, crack, s), outcome.u)
    normal = between_contact_points(cover, faces, crack, s, outcome.normal_traction)
    tangential = between_contact_points(cover, faces, crack, s, outcome.tangential_traction)
    compliance, broken = law.compliance[nearest], outcome.memory.broken
    if law.dilation is not None:
        gap = gap - np.where(broken, law.dilation, 0.0)[nearest] * np.abs(slip - compliance * tangential)
    p_n = np.where(normal < 0.0, np.minimum(gap, 0.0) / compliance, 0.0)
    ratio = np.divide(p_n, normal, out=np.zeros_like(normal), where=normal < 0.0)
    _, cohesion = law.bound_of(broken)
    cohesive = np.where(outcome.state == SLIP, np.copysign(cohesion, outcome.tangential_traction), 0.0)[nearest]
    never_slipped = ((outcome.state == STICK) & ~broken)[nearest]
    return p_n, np.where(never_slipped, slip / compliance, cohesive + ratio * (tangential - cohesive))
