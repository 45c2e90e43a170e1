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
from crackgrow.fracture.tip_rule import TipRule, fall_weights, step_weights
from crackgrow.solid.elasticity import PlaneElasticity

RIGHT_FACE = np.array([-1.0, -1.0, 1.0])
"""The gradients of the auxiliary fields on the right face over those on the left one."""

FIELDS = len(RIGHT_FACE)


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """What M of a rule, field by field, takes of the body's own field, in the tip's axes."""

    around: Floats  # (FIELDS, 2, 2, n) of elastic gradients [field, c, d] at the points of the circles
    fall: Floats  # (radii, n) of these points
    left: Floats  # (FIELDS, 2, 2, m) of those at the points of the left face
    vectors: Floats  # (FIELDS, 2, m) of the stress vectors there; those on the right are opposite
    step: Floats  # (radii, m) of points of the faces

    def M(self, around: Floats, left: Floats, right: Floats, vectors: Floats) -> Floats:
        """M (radii, FIELDS) of gradients (2, 2, n) on the circles, (2, 2, m) on both faces, and vectors (2, m)."""
        of_left, of_right = (np.einsum("mcdn,cdn->nm", self.left, face) for face in (left, right))
        # on the right face the outward normal is opposite, and so may be the auxiliary field
        of_faces = of_left - RIGHT_FACE * of_right + np.einsum("mcn,cn->nm", self.vectors, vectors)
        return np.asarray(self.fall @ np.einsum("mcdn,cdn->nm", self.around, around) + self.step @ of_faces)


def weights_of(material: PlaneElasticity, rule: TipRule) -> Weights:
    """The weights of a rule, for a material in the axes of the tip."""
    circles, faces, radii = rule.circles, rule.faces, rule.radii
    around, beside = _auxiliary(material, rule)
    fall = fall_weights(circles.r, circles.weight * circles.r, radii)[:, :, None] * circles.angle_weight
    (a_11, _), (a_21, _) = beside
    _, yy, xy = _stress(material, beside)
    tx, ty = faces.toward_tip.T
    return Weights(
        _radial_flux(material, circles.t.ravel(), around),
        -fall.reshape(len(radii), -1),
        np.array([[xy * tx, xy * ty], [yy * tx, yy * ty]]).transpose(2, 0, 1, 3),
        (1.0 - RIGHT_FACE)[:, None, None] * np.stack([a_11, a_21], axis=1),
        step_weights(faces.r, faces.weight, radii),
    )


def of_body_force(material: PlaneElasticity, rule: TipRule, body_force: Floats) -> Floats:
    """What M (radii, FIELDS) has of a body force (2, n) at the points of the circles."""
    circles = rule.circles
    around, _ = _auxiliary(material, rule)
    work = np.einsum("in,imn->mn", body_force, around[:, 0]).reshape(FIELDS, *circles.t.shape) @ circles.angle_weight
    return np.asarray(-step_weights(circles.r, circles.weight * circles.r, rule.radii) @ work.T)


def of_uniform_stress(material: PlaneElasticity) -> Floats:
    """What M of the third field has (3,) 1/Pa of a uniform stress xx, yy, xy."""
    auxiliary = point_force_gradient(material, np.ones_like(EVERY_ANGLE), EVERY_ANGLE).transpose(1, 2, 0)[:, :, None]
    xx, xy, yx, yy = -2.0 * np.pi * _radial_flux(material, EVERY_ANGLE, auxiliary).mean(axis=-1).ravel()
    return np.asarray(np.linalg.inv(material.matrix) @ (xx, yy, 0.5 * (xy + yx)))


def _auxiliary(material: PlaneElasticity, rule: TipRule) -> tuple[Floats, Floats]:
    """Gradients (2, 2, FIELDS, points) of the auxiliary fields on the circles, and on the left face."""
    r, t = rule.circles.polar
    points = (np.append(r, rule.faces.r), np.append(t, rule.faces.alpha))
    fields = [near_tip_gradient(material, *points), point_force_gradient(material, *points)[:, None]]
    auxiliary = np.concatenate(fields, axis=1).transpose(2, 3, 1, 0)
    return auxiliary[..., : len(r)], auxiliary[..., len(r) :]


def _radial_flux(material: PlaneElasticity, t: Floats, auxiliary: Floats) -> Floats:
    """What P_j r_j of auxiliary fields (2, 2, m, n), r_j away from the tip at angles t (n,), takes of gradients.

    Returns (m, 2, 2, n) [field, c, d] of du_c/dx_d. With r = (c, s) the stress of the body's own field counts in
    sigma_ij (u^a_i,1 r_j - u^a_i,j r_1), in which that along x falls out.
    """
    c, s = np.cos(t), np.sin(t)
    (a_11, a_12), (a_21, a_22) = auxiliary
    xx, yy, xy = _stress(material, auxiliary)
    of_yy, of_xy = s * a_21 - c * a_22, s * a_11 - c * a_12
    e_xx, e_yy, e_xy = (across * of_yy + shear * of_xy for _, across, shear in material.matrix.T.tolist())
    found = np.array([[e_xx + xx * c + xy * s, e_xy], [e_xy + xy * c + yy * s, e_yy]])
    return np.asarray(found.transpose(2, 0, 1, 3))


def _stress(material: PlaneElasticity, gradient: Floats) -> tuple[Floats, Floats, Floats]:
    """Stress xx, yy, xy (...) Pa of displacement gradients (2, 2, ...)."""
    (ux_x, ux_y), (uy_x, uy_y) = gradient
    strain = (ux_x, uy_y, ux_y + uy_x)
    xx, yy, xy = (sum(c * e for c, e in zip(row, strain, strict=True)) for row in material.matrix.tolist())
    return xx, yy, xy
