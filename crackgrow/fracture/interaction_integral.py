"""Stress intensity factors by the domain interaction integral (Yau, Wang, Corten 1980; Moran, Shih 1987).

With an auxiliary field a of known K, P_j = sigma_ij u^a_i,1 + sigma^a_ij u_i,1 - sigma_ik u^a_i,k delta_1j has the
divergence -b_i u^a_i,1 under a body force b, and with q falling from 1 at the tip to 0 on the rim of a disc A

    M = int_A P_j q_,j dA - int_A q b_i u^a_i,1 dA - int_faces P_j n_j q ds,    K = E'/2 M.

The auxiliary fields are Williams' with their angle counted so that it jumps on the crack itself, kinks included: exact
in the slit body, so that M does not depend on the disc. On a face with unit tangent s, s_1 n_2 - n_1 s_2 = +-1 leaves
P_j n_j = t_i u^a_i,1 +- sigma^a_i2 u_i,s: of the body's own field it needs the tractions t, which are known, and the
derivative along the face. On the last straight segment sigma^a_i2 vanishes and the tractions alone are left.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.contact.faces import points_at
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.cover.tips import Tip, crack_angle
from crackgrow.fracture.williams import williams_gradient
from crackgrow.geometry.polyline import arc_lengths, segment_directions
from crackgrow.quadrature.rules import gauss
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.recovery import gradient_at

Floats = NDArray[np.float64]

DomainField = Callable[[Floats, Floats], Floats]
"""Elastic displacement gradient (n, 2, 2) in the tip's axes at polar coordinates r, t (n,)."""

FaceField = Callable[[Floats], tuple[Floats, Floats]]
"""At arc lengths (n,) from the tip, in the tip's axes: stress vectors sigma . n on the crack's left normal (n, 2) and
elastic displacement gradients (n, 2, 2), the sums of both faces. The gradients may be zero on the last segment."""

FaceTraction = Callable[[Floats], tuple[Floats, Floats]]
"""Normal and tangential traction (n,) Pa at arc lengths (n,), spacings, from the crack's start."""

RADIUS = 2.5
"""Radius of the disc in spacings: from 1.5 on K is within 0.2 % on straight cracks, and kinks of the last increments,
which the cover does not resolve, disturb a disc that reaches beyond them least."""

STRAIGHT_RADIUS = 5.0
"""The same as far as the crack is straight: a larger disc averages the stress, which ripples, over more tiles."""

KEPT_CLEAR = 0.8
"""Part of the clearance that a disc may take: one that touches another tip was 0.7 to 1.6 % off, this one 0.1."""

SMALLEST_RADIUS = 1e-4
"""Spacings: a smaller disc is as large as rounding. Tip functions make small ones worth something: 0.1 spacings from
another tip K is within 3 %, where the displacement of the faces misses by 15."""

PARTS = np.array([0.7, 0.85, 1.0])
"""The discs, as fractions of the radius, whose spread is the error estimate."""

N_RADIAL = 6
"""Points per panel along a ray; panels end at the discs' radii, at kinks and after every spacing."""

N_ANGULAR = 24
"""Least number of points on a circle, from face to face."""

ANGULAR_DENSITY = 10
"""Points on a circle per spacing of the largest radius: the stress ripples from tile to tile."""

FACE_PANEL = 0.25
"""Length of a panel on the faces, spacings, at the tip in terms of the square root."""

N_FACE = 5
"""Points per panel on the faces."""

TIPS_AT_ONCE = 4
"""Tips whose points are evaluated together: a call costs as much as some hundred points."""

SAME = 1e-9
"""Stops of panels closer than this are one."""


@dataclass(frozen=True, slots=True, eq=False)
class StressIntensity:
    """K of one tip. K_II is positive where the face on the left of the outward direction moves outward."""

    K_I: float  # Pa sqrt(m)
    K_II: float  # Pa sqrt(m)
    K_I_error: float  # Pa sqrt(m): spread over three radii
    K_II_error: float  # Pa sqrt(m)
    radius: float  # m, of the largest disc; nan where none fits
    shrunk: bool  # whether the disc is smaller than the default
    note: str  # why, in words; empty where it is not


def interaction_integrals(
    cover: Cover,
    materials: Sequence[PlaneElasticity],
    u: Floats,
    tips: Sequence[int],
    tractions: Sequence[FaceTraction],
    body_forces: Sequence[Floats] | None = None,
    radius: float | None = None,
) -> list[StressIntensity]:
    """K_I and K_II of the `tips` of a cover; `u` (n_dofs,) m, `body_forces` (2,) N/m^3 each, `radius` m.

    `tractions` are, tip by tip, all that acts between the faces: contact tractions less fluid pressure.
    """
    forces = [np.zeros(2)] * len(tips) if body_forces is None else body_forces
    discs = [_disc(cover, tip, None if radius is None else radius / cover.lattice.spacing) for tip in tips]
    gradients = _domain_gradients(cover, materials, u, [disc for disc in discs if not np.isnan(disc.radius)])
    return [
        _no_room(disc)
        if np.isnan(disc.radius)
        else _in_disc(cover, materials, u, disc, next(gradients), traction, force)
        for disc, traction, force in zip(discs, tractions, forces, strict=True)
    ]


@dataclass(frozen=True, slots=True, eq=False)
class _Disc:
    """The largest disc of a tip's integrals."""

    tip: int
    radius: float  # spacings; nan where none fits
    shrunk: bool
    obstacle: str

    @property
    def radii(self) -> Floats:
        """Of all discs (n,), spacings, increasing."""
        return self.radius * PARTS


def _disc(cover: Cover, tip: int, radius: float | None) -> _Disc:
    """The disc of a tip; `radius` (spacings) is the one wanted, None for the usual one."""
    straight = min(float(cover.tips[tip].radii[1]), STRAIGHT_RADIUS)
    room, obstacle = clearance(cover, tip)
    room *= KEPT_CLEAR
    wanted = max(RADIUS, min(straight, room)) if radius is None else radius
    if room < min(SMALLEST_RADIUS, wanted):
        return _Disc(tip, float("nan"), True, obstacle)
    return _Disc(tip, min(wanted, room), room < wanted, obstacle)


def _no_room(disc: _Disc) -> StressIntensity:
    nan = float("nan")
    note = f"{disc.obstacle} leaves no room for an integral round the tip"
    return StressIntensity(nan, nan, nan, nan, nan, True, note)


def _in_disc(
    cover: Cover,
    materials: Sequence[PlaneElasticity],
    u: Floats,
    disc: _Disc,
    gradient: Floats,
    traction: FaceTraction,
    body_force: Floats,
) -> StressIntensity:
    """K of a tip from the elastic displacement gradient at the points of its disc."""
    geometry, material, spacing = cover.tips[disc.tip], _material(cover, materials, disc.tip), cover.lattice.spacing
    M = interaction(
        geometry,
        material,
        disc.radii,
        lambda r, t: gradient,
        _face_field(cover, material, u, disc.tip, traction),
        spacing * geometry.rotation @ body_force,
    )
    K = 0.5 * material.young_prime * np.sqrt(spacing) * M
    (K_I, K_II), (spread_I, spread_II) = K[-1].tolist(), np.ptp(K, axis=0).tolist()
    note = f"{disc.obstacle} makes the disc of the integral small" if disc.shrunk else ""
    return StressIntensity(K_I, K_II, spread_I, spread_II, disc.radius * spacing, disc.shrunk, note)


def interaction(
    tip: Tip,
    material: PlaneElasticity,
    radii: Floats,
    domain: DomainField,
    faces: FaceField,
    body_force: Floats,
) -> Floats:
    """M (radii, 2) of discs with increasing `radii` (n,), for the auxiliary modes I and II; lengths in spacings."""
    r, t, weight, angle_weight = _circles(tip, radii)
    rr = np.repeat(r, t.shape[1])
    flux = _radial_flux(material, rr, t.ravel(), domain(rr, t.ravel())).reshape(*t.shape, 2)
    through_circle = np.einsum("a,ram->rm", angle_weight, flux) * r[:, None]
    through_faces = _face_terms(tip, material, radii, faces)
    from_force = _force_terms(tip, material, radii, body_force) if body_force.any() else 0.0
    return -_running_average(r, weight, through_circle, radii) - through_faces - from_force


def clearance(cover: Cover, tip: int) -> tuple[float, str]:
    """Largest radius (spacings) of a disc round a tip that holds one stretch of its own crack alone; what limits it."""
    geometry, (index, at_end) = cover.tips[tip], cover.tip_ends[tip]
    own = cover.cracks[index]
    from_tip = own.points[::-1] if at_end else own.points
    place = shapely.Point(geometry.point)
    obstacles = {"the crack's other end": shapely.distance(place, shapely.Point(from_tip[-1]))}
    if len(geometry.path) < len(from_tip):  # the crack turns back towards its tip
        bend = shapely.LineString(from_tip[len(geometry.path) - 1 :])
        obstacles["the crack's own bend"] = shapely.distance(place, bend)
    reach = min(obstacles.values())  # what lies farther away does not count
    for number in cover.crack_tree.query(place, predicate="dwithin", distance=reach):
        if number != index:
            line = cover.crack_tree.geometries[number]
            obstacles[f"crack '{cover.cracks[number].name}'"] = shapely.distance(place, line)
    sides = cover.outline_tree.geometries[cover.outline_tree.query(place, predicate="dwithin", distance=reach)]
    if len(sides):
        obstacles["the outline"] = shapely.distance(place, sides).min()
    return min((float(distance), name) for name, distance in obstacles.items())


def _material(cover: Cover, materials: Sequence[PlaneElasticity], tip: int) -> PlaneElasticity:
    """The material at a tip."""
    index, at_end = cover.tip_ends[tip]
    element = cover.elements.lines[index].plus[-1 if at_end else 0]
    return materials[int(cover.elements.body[element])]


def _domain_gradients(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, discs: Sequence[_Disc]
) -> Iterator[Floats]:
    """Disc by disc, the elastic displacement gradients (n, 2, 2), in the tip's axes, at the points of its circles."""
    for first in range(0, len(discs), TIPS_AT_ONCE):
        some = discs[first : first + TIPS_AT_ONCE]
        points = [_on_circles(cover.tips[disc.tip], disc.radii) for disc in some]
        all_points = np.concatenate(points)
        found = gradient_at(cover, u, all_points, locate(cover.lattice, cover.elements, all_points))
        ends = np.cumsum([len(part) for part in points])[:-1]
        for disc, gradient in zip(some, np.split(found, ends), strict=True):
            rotation = cover.tips[disc.tip].rotation
            initial = _initial_gradient(_material(cover, materials, disc.tip))
            yield rotation @ (gradient + initial) @ rotation.T


def _on_circles(tip: Tip, radii: Floats) -> Floats:
    """The points (n, 2) of `_circles`, in lattice coordinates."""
    r, t, _, _ = _circles(tip, radii)
    return np.asarray(
        tip.point + (r[:, None, None] * np.stack([np.cos(t), np.sin(t)], axis=-1) @ tip.rotation).reshape(-1, 2)
    )


def _face_field(cover: Cover, material: PlaneElasticity, u: Floats, tip: int, traction: FaceTraction) -> FaceField:
    geometry, (index, at_end) = cover.tips[tip], cover.tip_ends[tip]
    length = float(arc_lengths(cover.cracks[index].points)[-1])
    last_segment = float(geometry.radii[1])
    initial = _initial_gradient(material)

    def field(arc: Floats) -> tuple[Floats, Floats]:
        s = length - arc if at_end else arc
        points = points_at(cover, index, s)
        left = points.normal if at_end else -points.normal  # the tip's left normal, not the crack's
        outward = np.stack([left[:, 1], -left[:, 0]], axis=1)
        normal, tangential = traction(s)
        vectors = 2.0 * (normal[:, None] * left + tangential[:, None] * outward)
        gradients = np.zeros((len(arc), 2, 2))
        kinked = np.flatnonzero(arc > last_segment)
        if len(kinked):
            elements = np.concatenate([points.plus[kinked], points.minus[kinked]])
            both = gradient_at(cover, u, np.tile(points.points[kinked], (2, 1)), elements) + initial
            gradients[kinked] = both[: len(kinked)] + both[len(kinked) :]
        return vectors @ geometry.rotation.T, geometry.rotation @ gradients @ geometry.rotation.T

    return field


def _initial_gradient(material: PlaneElasticity) -> Floats:
    """The symmetric gradient (2, 2) whose stress is the in-situ stress."""
    xx, yy, xy2 = np.linalg.solve(material.matrix, np.array(material.initial))
    return np.array([[xx, 0.5 * xy2], [0.5 * xy2, yy]])


def _stress(material: PlaneElasticity, gradient: Floats) -> Floats:
    """Stress (..., 2, 2) Pa of displacement gradients (..., 2, 2)."""
    xx = material.c11 * gradient[..., 0, 0] + material.c12 * gradient[..., 1, 1]
    yy = material.c12 * gradient[..., 0, 0] + material.c11 * gradient[..., 1, 1]
    xy = material.c33 * (gradient[..., 0, 1] + gradient[..., 1, 0])
    return np.stack([np.stack([xx, xy], axis=-1), np.stack([xy, yy], axis=-1)], axis=-2)


def _radial_flux(material: PlaneElasticity, r: Floats, t: Floats, gradient: Floats) -> Floats:
    """P_j r_j (n, 2) for both auxiliary modes, r_j the unit vector away from the tip."""
    away = np.stack([np.cos(t), np.sin(t)], axis=1)
    auxiliary = williams_gradient(material, r, t)
    stress = _stress(material, gradient)
    own = np.einsum("nij,nj,nmi->nm", stress, away, auxiliary[..., 0])
    other = np.einsum("nmij,nj,ni->nm", _stress(material, auxiliary), away, gradient[..., 0])
    energy = np.einsum("nij,nmij->nm", stress, auxiliary)
    return np.asarray(own + other - energy * away[:, :1])


def _face_terms(tip: Tip, material: PlaneElasticity, radii: Floats, faces: FaceField) -> Floats:
    """int P_j n_j q ds over both faces (radii, 2)."""
    arcs = arc_lengths(tip.path)
    ends = _arc_at(tip, arcs, radii)
    stops = np.concatenate([arcs[arcs < ends[-1]], ends, np.arange(0.0, ends[-1], FACE_PANEL)])
    arc, weight = _panels_from_tip(stops, N_FACE)
    segment = np.searchsorted(arcs, arc, side="right") - 1
    toward_tip = -segment_directions(tip.path)[segment]
    place = tip.path[segment] - (arc - arcs[segment])[:, None] * toward_tip
    r = np.hypot(place[:, 0], place[:, 1])
    auxiliary = williams_gradient(material, r, crack_angle(tip, r))  # of the left face; minus that on the right
    vectors, gradients = faces(arc)
    along = np.einsum("nij,nj->ni", gradients, toward_tip)
    second = _stress(material, auxiliary)[..., 1]
    flux = np.einsum("ni,nmi->nm", vectors, auxiliary[..., 0]) + np.einsum("nmi,ni->nm", second, along)
    return -_weighted_by_cone(r, weight, flux, radii)


def _force_terms(tip: Tip, material: PlaneElasticity, radii: Floats, force: Floats) -> Floats:
    """int q b_i u^a_i,1 dA (radii, 2)."""
    r, t, weight, angle_weight = _circles(tip, radii)
    auxiliary = williams_gradient(material, np.repeat(r, t.shape[1]), t.ravel())[..., 0]
    around = np.einsum("a,rami,i->rm", angle_weight, auxiliary.reshape(*t.shape, 2, 2), force)
    return _weighted_by_cone(r, weight * r, around, radii)


def _running_average(r: Floats, weight: Floats, values: Floats, radii: Floats) -> Floats:
    """Averages (radii, m) of values (n, m) over 0 < r < R: -dq/dr = 1/R of the cone q."""
    return np.stack([(weight * (r < R)) @ values / R for R in radii])


def _weighted_by_cone(r: Floats, weight: Floats, values: Floats, radii: Floats) -> Floats:
    """Integrals (radii, m) of q times values (n, m), with the cone q = 1 - r/R, at least 0."""
    return np.stack([(weight * np.maximum(1.0 - r / R, 0.0)) @ values for R in radii])


def _with_kinks(tip: Tip, radii: Floats) -> Floats:
    """Zero, the radii, those of the kinks between them, and every spacing, increasing."""
    return np.unique(np.concatenate([tip.radii[tip.radii < radii[-1]], radii, np.arange(1.0, radii[-1])]))


def _panels(stops: Floats, n: int) -> tuple[Floats, Floats]:
    """Gauss points and weights between neighbouring stops."""
    x, w = gauss(n)
    size = np.diff(stops)[:, None]
    return (stops[:-1, None] + size * x).ravel(), (size * w).ravel()


def _panels_from_tip(stops: Floats, n: int) -> tuple[Floats, Floats]:
    """Gauss points and weights between stops (any order), for half powers of the distance from the tip."""
    stops = np.unique(stops)
    root, weight = _panels(np.sqrt(stops[np.diff(stops, prepend=-1.0) > SAME]), n)
    return root**2, 2.0 * root * weight


def _circles(tip: Tip, radii: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Radii (r,) of circles and angles (r, a) on them, the weights (r,) of the circles and (a,) of the angles."""
    r, weight = _panels_from_tip(_with_kinks(tip, radii), N_RADIAL)
    t, angle_weight = _angles(tip, r)
    return r, t, weight, angle_weight


def _angles(tip: Tip, r: Floats) -> tuple[Floats, Floats]:
    """Angles (r, n) once round the tip from face to face at distances r, and their weights (n,)."""
    x, w = gauss(max(N_ANGULAR, int(np.ceil(ANGULAR_DENSITY * r.max()))))
    return crack_angle(tip, r)[:, None] - 2.0 * np.pi * (1.0 - x), 2.0 * np.pi * w


def _arc_at(tip: Tip, arcs: Floats, r: Floats) -> Floats:
    """Arc length (n,) at which the crack leaves the circle of radius r (n,)."""
    alpha = crack_angle(tip, r)
    at = r[:, None] * np.stack([np.cos(alpha), np.sin(alpha)], axis=1)
    segment = np.clip(np.searchsorted(tip.radii, r, side="right") - 1, 0, len(tip.radii) - 2)
    return np.asarray(arcs[segment] + np.hypot(*(at - tip.path[segment]).T))
