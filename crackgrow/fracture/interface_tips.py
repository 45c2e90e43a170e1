"""Energy release rate at the tips of cracked interfaces, by the domain J integral (Shih, Asaro 1988, eqs 3.7, 3.8).

With W the energy density, x along the interface away from the crack, and q falling from 1 at the tip to 0 on the rim of
a disc A that lies in both bodies,

    G = int_A (sigma_ij u_i,1 - W delta_1j) q_,j dA - int_A q b_i u_i,1 dA + int_faces (s_n [u_n],1 + s_t [u_t],1) q ds,

b a body force, s_n and s_t the tractions across and along the faces, [u] the jump between these. Where the interface is
straight within the disc it carries no term: W jumps, but not along x, and tractions and u_i,1 are continuous.

The stress there is r^(-1/2 + i eps), with modes that can't be told apart: K_I and K_II of the formulae of one material
do not exist. What does is the size of the complex K (Malyshev, Salganik 1965), K^2 = G E* / (1 - beta^2), with 1/E* the
mean of 1/E' of both, and Dundurs' beta.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from crackgrow.approximation.basis import fields_at
from crackgrow.arrays import Floats
from crackgrow.contact.faces import points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.cover.shapes import ends_at_bonds, is_isotropic
from crackgrow.fracture.stress_intensity import BodyForce, FaceTraction
from crackgrow.fracture.tip_disc import KEPT_CLEAR, PARTS, SMALLEST_RADIUS
from crackgrow.fracture.tip_rule import (
    FACE_PANEL,
    GROWTH,
    N_RADIAL,
    PANEL,
    fall_weights,
    n_angular,
    panel_ends,
    panels_from_tip,
    step_weights,
)
from crackgrow.geometry.polyline import tip_direction
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.quadrature.rules import gauss
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.vectors import across


@dataclass(frozen=True, slots=True, eq=False)
class InterfaceTip:
    """An end of the cracked part of an interface, beyond which the bodies are bonded. Lengths in spacings."""

    surface: int  # of the cover
    at_end: bool
    point: Floats  # (2,)
    rotation: Floats  # (2, 2): the tip's axes, x along the interface away from the crack, in its rows
    bodies: tuple[int, int]  # on the left of that direction, and on the right
    size: float  # side of the cells there
    radius: float  # of the largest disc

    def from_start(self, cover: Cover, r: Floats) -> Floats:
        """Arc lengths (n,) on the surface at distances r (n,) from the tip."""
        edges = cover.surfaces[self.surface].edges.s
        return np.asarray(edges[-1, 1] - r if self.at_end else edges[0, 0] + r)


@dataclass(frozen=True, slots=True)
class Release:
    """What is known of an interface tip; nan where no disc fits."""

    G: float  # J/m^2
    G_spread: float  # J/m^2, between three discs
    K: float  # Pa sqrt(m), the size of the complex K


def interface_tips(cover: Cover, singular: Floats) -> Iterator[InterfaceTip]:
    """The tips of all cracked interfaces; stress is infinite at the points `singular` (k, 2), too."""
    names = [body.name for body in cover.bodies]
    for number, at_end in ends_at_bonds([surface.line for surface in cover.surfaces]):
        surface, end = cover.surfaces[number], -1 if at_end else 0
        point, x = surface.line.points[end], tip_direction(surface.line.points, at_end)
        first, second = (names.index(name) for name in surface.name.of)
        bodies = (first, second) if at_end else (second, first)  # the first one is on the left of the line
        axes = np.array([x, [-x[1], x[0]]])
        radius = KEPT_CLEAR * _room(cover, point, axes[1], singular)
        yield InterfaceTip(number, at_end, point, axes, bodies, float(surface.sizes[end]), radius)


def _room(cover: Cover, point: Floats, normal: Floats, singular: Floats) -> float:
    """How far (spacings) a tip is from the nearest corner, side, crack, singular point or end of an interface.

    Sides in line with it, whose `normal` (2,) that is, are none of them. It is nothing where a crack ends on the tip.
    """
    sides = np.concatenate([body.sides for body in cover.bodies])
    sides = sides[np.abs((sides - point) @ normal).max(axis=1) > SAME_PLACE]
    away = shapely.distance(shapely.linestrings(sides), shapely.Point(point))
    ends = [surface.line.points[end] for surface in cover.surfaces for end in (0, -1) if not surface.name.is_crack]
    apart = np.concatenate([np.hypot(*(np.array(ends) - point).T), away])
    cracks = shapely.distance(cover.crack_tree.geometries, shapely.Point(point))
    return float(np.concatenate([apart[apart > SAME_PLACE], cracks, np.hypot(*(singular - point).T)]).min())


def released(
    cover: Cover,
    materials: Sequence[PlaneElasticity],
    u: Floats,
    tip: InterfaceTip,
    traction: FaceTraction,
    body_forces: Sequence[BodyForce | None],
) -> Release:
    """G of a tip for the displacement `u` (n_dofs,) m, the `traction` on the faces and, body by body, body forces."""
    pair = [materials[body] for body in tip.bodies]
    varies = any(material.initial.varying for material in pair)
    if varies or tip.radius < SMALLEST_RADIUS * tip.size:
        return Release(*(float("nan"),) * 3)
    radii = tip.radius * PARTS
    found = sum(
        _of_half(cover, material, u, tip, radii, half, body_forces[body])
        for half, (body, material) in enumerate(zip(tip.bodies, pair, strict=True))
    )
    found = found + _of_faces(cover, u, tip, radii, traction)
    G = float(found[-1])
    spread = float(np.ptp(found))
    known = max(G, 0.0) if -spread <= G else np.nan
    return Release(G, spread, float(np.sqrt(known * _stiffness(*pair))))


def _of_half(
    cover: Cover,
    material: PlaneElasticity,
    u: Floats,
    tip: InterfaceTip,
    radii: Floats,
    half: int,
    body_force: BodyForce | None,
) -> Floats:
    """What the left half (0) or the right half (1) of the discs adds to G (radii,) J/m^2."""
    r, weight = panels_from_tip(panel_ends(radii, PANEL * tip.size, GROWTH), N_RADIAL)
    in_tip_axes = material.turned(tip.rotation)
    x, w = gauss(n_angular(in_tip_axes.roots))
    t = np.pi * (x - half)
    c, s = np.tile(np.cos(t), len(r)), np.tile(np.sin(t), len(r))
    places = tip.point + np.repeat(r, len(t))[:, None] * np.stack([c, s], axis=1) @ tip.rotation
    elements = locate(cover.lattice, cover.elements, places, tip.bodies[half])
    if (elements < 0).any():  # the interface bends at the tip, by less than what counts as a corner
        return np.full(len(radii), np.nan)
    gradient = _turned(fields_at(cover, places, elements, u)[1:], tip)
    strain = np.stack([gradient[0, 0], gradient[1, 1], gradient[0, 1] + gradient[1, 0]], axis=1)
    x_, y_ = tip.rotation
    xx, yy, xy = material.initial.uniform
    tensor = np.array([[xx, xy], [xy, yy]])
    initial = np.array([x_ @ tensor @ x_, y_ @ tensor @ y_, x_ @ tensor @ y_])
    stress = strain @ in_tip_axes.matrix + initial
    energy = 0.5 * np.sum((stress + initial) * strain, axis=1)
    vectors = across(stress, np.stack([c, s], axis=1))
    flux = energy * c - vectors[:, 0] * gradient[0, 0] - vectors[:, 1] * gradient[1, 0]
    angular, spacing = np.pi * w, cover.lattice.spacing
    total = spacing * fall_weights(r, weight * r, radii) @ (flux.reshape(len(r), -1) @ angular)
    if body_force is not None:
        force = body_force(cover.lattice.to_metres(places)) @ tip.rotation.T
        work = np.sum(force * gradient[:, 0].T, axis=1).reshape(len(r), -1) @ angular
        total -= spacing**2 * step_weights(r, weight * r, radii) @ work
    return np.asarray(total)


def _of_faces(cover: Cover, u: Floats, tip: InterfaceTip, radii: Floats, traction: FaceTraction) -> Floats:
    """What tractions on the faces add to G (radii,) J/m^2: a sum over short parts, on each of which these are constant.

    The jump itself is known better than its derivative, which is singular; at the tip it is zero.
    """
    r = panel_ends(radii, FACE_PANEL * PANEL * tip.size, FACE_PANEL * GROWTH)
    middle = 0.5 * (r[1:] + r[:-1])
    tractions = np.stack(traction(tip.from_start(cover, middle)))
    if not tractions.any():
        return np.zeros(len(radii))
    jump = np.stack(gap_and_slip(cover, points_at(cover, tip.surface, tip.from_start(cover, r)), u))
    jump[:, 0] = 0.0
    work = -np.sum(tractions * np.diff(jump, axis=1), axis=0)
    return np.asarray(step_weights(middle, np.ones(len(middle)), radii) @ work)


def _turned(gradient: Floats, tip: InterfaceTip) -> Floats:
    """Gradient (2, 2, n) [component, direction] in the tip's axes of derivatives (2, n, 2) by x and by y."""
    return np.asarray(np.einsum("dnc,ac,bd->abn", gradient, tip.rotation, tip.rotation))


def _stiffness(one: PlaneElasticity, other: PlaneElasticity) -> float:
    """E* / (1 - beta^2) (Pa) of two bodies; nan where one has bedding, for which there is no such K."""
    if not is_isotropic(one.roots) or not is_isotropic(other.roots):
        return float("nan")
    harmonic = 2.0 / (1.0 / one.young_prime + 1.0 / other.young_prime)
    (m1, k1), (m2, k2) = ((m.matrix[2, 2], 8.0 * m.matrix[2, 2] / m.young_prime - 1.0) for m in (one, other))
    beta = (m1 * (k2 - 1.0) - m2 * (k1 - 1.0)) / (m1 * (k2 + 1.0) + m2 * (k1 + 1.0))
    return float(harmonic / (1.0 - beta**2))
