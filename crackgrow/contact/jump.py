"""The jump: gap and slip of contact points as linear functions of the unknowns, paper eq. (4); elastic tractions."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from crackgrow.approximation.basis import fields_at, of_component, values_at
from crackgrow.arrays import Floats, Ints
from crackgrow.contact.coulomb import EPSILON, SLIP, STICK, ContactLaw
from crackgrow.contact.faces import ContactFaces, FacePoints, points_at
from crackgrow.contact.solve import ContactOutcome
from crackgrow.cover.cover import Cover


def jump_matrix(cover: Cover, points: FacePoints) -> csr_array:
    """Scalar jump (n, n_functions): value on the plus face minus value on the minus face, zero on a foundation."""
    n, (rock, places, elements) = len(points.s), _both_faces(points)
    sides = np.concatenate([np.ones(n), -np.ones(len(rock))])
    both = csr_array((sides, (np.append(np.arange(n), rock), np.arange(len(sides)))), shape=(n, len(sides)))
    return csr_array(both @ values_at(cover, places, elements))


def gap_and_slip(cover: Cover, points: FacePoints, u: Floats) -> tuple[Floats, Floats]:
    """Gap (n,) and slip (n,), m, at points: the jump along the normal and along the surface; `u` (n_dofs,)."""
    n, (rock, places, elements) = len(points.s), _both_faces(points)
    both = fields_at(cover, places, elements, u, derivatives=False)[0]
    jump = both[:n].copy()
    jump[rock] -= both[n:]
    return across_and_along(points, jump)


def across_and_along(points: FacePoints, jumps: Floats) -> tuple[Floats, Floats]:
    """Gaps (n,) and slips (n,) m of jumps (n, 2) m at points."""
    nx, ny = points.normal.T
    return jumps[:, 0] * nx + jumps[:, 1] * ny, jumps[:, 0] * ny - jumps[:, 1] * nx


def averaged(faces: ContactFaces, jumps: Floats) -> Floats:
    """Average gaps, then slips (2 contact points,) m, of jumps (n, 2) m at the integration points."""
    both = across_and_along(faces.points, jumps)
    return np.concatenate([faces.functions @ (faces.lengths * part) / faces.weights for part in both])


def contact_operators(cover: Cover, faces: ContactFaces) -> tuple[csr_array, csr_array]:
    """Matrices (contact points, n_dofs) that give the average gap and the average slip, m, of every contact point."""
    if faces.n == 0:
        return csr_array((0, cover.n_dofs)), csr_array((0, cover.n_dofs))
    jump, average = jump_matrix(cover, faces.points), faces.functions.tocsr()
    per_node = np.repeat(1.0 / faces.weights, np.diff(average.indptr)) * average.data

    def averaged(direction: Floats) -> csr_array:
        shares = per_node * (direction * faces.lengths)[average.indices]
        return csr_array(csr_array((shares, average.indices, average.indptr), average.shape) @ jump)

    x, y = (averaged(direction) for direction in faces.points.normal.T)
    gap, slip = (of_component(a, 0) + of_component(b, 1) for a, b in ((x, y), (y, -x)))
    return csr_array(gap), csr_array(slip)


def _both_faces(points: FacePoints) -> tuple[Ints, Floats, Ints]:
    """Which of the points (r,) have rock on their minus face; places and elements of the plus faces, then of those."""
    rock = np.flatnonzero(points.minus >= 0)
    return rock, np.concatenate([points.points, points.points[rock]]), np.concatenate([points.plus, points.minus[rock]])


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
    nearest = faces.nearest(crack, s)
    gap, slip = gap_and_slip(cover, points_at(cover, crack, s), outcome.u)
    points = outcome.points
    known = (points.normal, points.tangential, law.compliance, law.shear_compliance)
    normal, tangential, across, along = faces.between(crack, s, *known)
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
