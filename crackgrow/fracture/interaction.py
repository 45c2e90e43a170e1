"""K_I, K_II and the T stress by the domain interaction integral (Yau, Wang, Corten 1980; Moran, Shih 1987).

With an auxiliary field a of known K, P_j = sigma_ij u^a_i,1 + sigma^a_ij u_i,1 - sigma_ik u^a_i,k delta_1j has the
divergence -b_i u^a_i,1 under a body force b, and with q falling from 1 at the tip to 0 on the rim of a disc A, smoothly
at both so that what the stress ripples by averages out,

    M = int_A P_j q_,j dA - int_A q b_i u^a_i,1 dA - int_faces P_j n_j q ds.

Since G = k . H k, k = (K_II, K_I), with the tensor H that is 1/E' in isotropic rock, M of K_II = 1 and of K_I = 1 are
2 H k. The auxiliary fields are those of `near_tip` with their angle counted so that it jumps on the crack itself, kinks
included: exact in the slit body, so that M does not depend on the disc. On a face with unit tangent s,
s_1 n_2 - n_1 s_2 = +-1 leaves P_j n_j = t_i u^a_i,1 +- sigma^a_i2 u_i,s: of the body's own field it needs the
tractions t, which are known, and the derivative along the face. On the last straight segment sigma^a_i2 vanishes and
the tractions alone are left.

A third auxiliary field, of a force on the tip along x (Kfouri 1986), has no traction on lines through the tip, and
opens faces by the same amount everywhere: its M is that of the uniform stress at the tip, T = sigma_11 of what is not
singular, and the tractions on the faces there (`of_uniform_stress`). In isotropic rock M = T - sigma_22. The gradient
of this field is the same on both faces, so that the tractions on them, which are opposite, fall out.

Arrays inside run over the points last, so that every operation is one long loop.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.fracture.near_tip import EVERY_ANGLE, near_tip_gradient, point_force_gradient
from crackgrow.fracture.tip_rule import TipRule, weighted_by_fall, weighted_by_step
from crackgrow.solid.elasticity import PlaneElasticity

UNIT_GRADIENTS = np.eye(4).reshape(2, 2, 2, 2, 1)
"""[c, d]: the gradient (2, 2, 1) whose component du_c/dx_d is one."""


RIGHT_FACE = np.array([-1.0, -1.0, 1.0])
"""The gradients of the auxiliary fields on the right face over those on the left one."""

FIELDS = len(RIGHT_FACE)


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """What M (radii, FIELDS) of a rule, field by field, takes of the body's own field, in the tip's axes."""

    around: Floats  # (radii, FIELDS, 2, 2, n) of elastic gradients [radius, field, c, d] at the points of the circles
    left: Floats  # (radii, FIELDS, 2, 2, m) of those at the points of the left face
    right: Floats  # of the right one
    vectors: Floats  # (radii, FIELDS, 2, m) of the stress vectors on the left face; those on the right are opposite


def weights_of(material: PlaneElasticity, rule: TipRule) -> Weights:
    """The weights of a rule, for a material in the axes of the tip."""
    circles, faces, radii = rule.circles, rule.faces, rule.radii
    around, beside = _auxiliary(material, rule)
    _, t = circles.polar
    away = np.stack([np.cos(t), np.sin(t)])
    fall = weighted_by_fall(circles.r, circles.weight, np.eye(len(circles.r)), radii) * circles.r
    step = weighted_by_step(faces.r, faces.weight, np.eye(len(faces.r)), radii)
    through = -(fall[:, :, None] * circles.angle_weight).reshape(len(radii), -1)
    of_circles, of_faces, of_vectors = [], [], []
    for c in (0, 1):
        for d in (0, 1):
            of_circles.append(_radial_flux(material, away, around, UNIT_GRADIENTS[c, d]))
            of_faces.append(_face_flux(material, rule, beside, np.zeros((2, 1)), UNIT_GRADIENTS[c, d]))
        of_vectors.append(_face_flux(material, rule, beside, np.eye(2)[c, :, None], np.zeros((2, 2, 1))))
    left = step[:, None, None, None] * np.stack(of_faces, axis=1).reshape(FIELDS, 2, 2, -1)
    opposite = -RIGHT_FACE[:, None, None]  # the outward normal is, and what the field is besides
    return Weights(
        through[:, None, None, None] * np.stack(of_circles, axis=1).reshape(FIELDS, 2, 2, -1),
        left,
        opposite[..., None] * left,
        step[:, None, None] * (1.0 + opposite) * np.stack(of_vectors, axis=1),
    )


def of_body_force(material: PlaneElasticity, rule: TipRule, body_force: Floats) -> Floats:
    """What M (radii, FIELDS) has of a body force (2, n) at the points of the circles."""
    circles = rule.circles
    around, _ = _auxiliary(material, rule)
    work = np.einsum("in,min->mn", body_force, around[:, :, 0]).reshape(FIELDS, *circles.t.shape) @ circles.angle_weight
    return -weighted_by_step(circles.r, circles.weight * circles.r, work, rule.radii)


def of_uniform_stress(material: PlaneElasticity) -> Floats:
    """What M of the third field has (3,) 1/Pa of a uniform stress xx, yy, xy."""
    t = EVERY_ANGLE
    auxiliary = point_force_gradient(material, np.ones_like(t), t).transpose(1, 2, 0)[None]
    away, found = np.stack([np.cos(t), np.sin(t)]), np.empty(3)
    for n, (xx, yy, xy) in enumerate(np.linalg.inv(material.matrix)):
        uniform = np.array([[[xx], [0.5 * xy]], [[0.5 * xy], [yy]]])
        found[n] = -2.0 * np.pi * _radial_flux(material, away, auxiliary, uniform).mean()
    return found


def _auxiliary(material: PlaneElasticity, rule: TipRule) -> tuple[Floats, Floats]:
    """Gradients (FIELDS, 2, 2, points) of the auxiliary fields on the circles, and on the left face."""
    r, t = rule.circles.polar
    points = (np.append(r, rule.faces.r), np.append(t, rule.faces.alpha))
    fields = [near_tip_gradient(material, *points), point_force_gradient(material, *points)[:, None]]
    auxiliary = np.concatenate(fields, axis=1).transpose(1, 2, 3, 0)
    return auxiliary[..., : len(r)], auxiliary[..., len(r) :]


def _radial_flux(material: PlaneElasticity, away: Floats, auxiliary: Floats, gradient: Floats) -> Floats:
    """P_j r_j (FIELDS, n) of the auxiliary fields, r_j the unit vectors (2, n) away from the tip."""
    c, s = away
    xx, yy, xy = _stress(material, gradient)
    of_mode = auxiliary.transpose(1, 2, 0, 3)
    xx_a, yy_a, xy_a = _stress(material, of_mode)
    own = (xx * c + xy * s) * of_mode[0, 0] + (xy * c + yy * s) * of_mode[1, 0]
    other = (xx_a * c + xy_a * s) * gradient[0, 0] + (xy_a * c + yy_a * s) * gradient[1, 0]
    energy = xx * of_mode[0, 0] + yy * of_mode[1, 1] + xy * (of_mode[0, 1] + of_mode[1, 0])
    return np.asarray(own + other - energy * c)


def _face_flux(
    material: PlaneElasticity, rule: TipRule, auxiliary: Floats, vectors: Floats, gradients: Floats
) -> Floats:
    """-P_j n_j (FIELDS, m) on the left face."""
    tx, ty = rule.faces.toward_tip.T
    along = gradients[:, 0] * tx + gradients[:, 1] * ty
    of_mode = auxiliary.transpose(1, 2, 0, 3)
    _, yy, xy = _stress(material, of_mode)
    return np.asarray(vectors[0] * of_mode[0, 0] + vectors[1] * of_mode[1, 0] + xy * along[0] + yy * along[1])


def _stress(material: PlaneElasticity, gradient: Floats) -> tuple[Floats, Floats, Floats]:
    """Stress xx, yy, xy (...) Pa of displacement gradients (2, 2, ...)."""
    (ux_x, ux_y), (uy_x, uy_y) = gradient
    strain = (ux_x, uy_y, ux_y + uy_x)
    xx, yy, xy = (sum(c * e for c, e in zip(row, strain, strict=True)) for row in material.matrix.tolist())
    return xx, yy, xy
