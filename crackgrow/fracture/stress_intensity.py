"""K_I, K_II and T of tips by the interaction integral: what `interaction` needs, from the displacement."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from crackgrow.approximation.basis import fields_at
from crackgrow.arrays import Floats, Ints
from crackgrow.contact.faces import points_at
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.cover.tips import Tip
from crackgrow.fracture.interaction import Weights, of_body_force, of_uniform_stress, weights_of
from crackgrow.fracture.tip_disc import NOWHERE, Disc, disc_round, first_corner
from crackgrow.fracture.tip_rule import TipRule, n_angular, tip_rule
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.vectors import across

FaceTraction = Callable[[Floats], tuple[Floats, Floats]]
"""Normal and tangential traction (n,) Pa at arc lengths (n,), spacings, from the crack's start."""

BodyForce = Callable[[Floats], Floats]
"""Force (n, 2) N/m^3 on the rock at places (n, 2) m, besides a uniform in-situ stress."""


@dataclass(frozen=True, slots=True, eq=False)
class StressIntensity:
    """K and T of one tip. K_II is positive where the face on the left of the outward direction moves outward."""

    K_I: float  # Pa sqrt(m)
    K_II: float  # Pa sqrt(m)
    K_I_spread: float  # Pa sqrt(m): over three radii
    K_II_spread: float  # Pa sqrt(m)
    T: float  # Pa: the stress along the crack at the tip, without what is singular
    T_spread: float  # Pa
    radius: float  # m, of the largest disc; nan where none fits
    small: bool  # whether the disc spans but few cells
    note: str  # why, in words; empty where it is not
    K_opening: float = math.nan  # Pa sqrt(m): the K_I that alone opens the faces as far; below 0 these would overlap


@dataclass(frozen=True, slots=True, eq=False)
class _Integral:
    """The integrals over the discs round a tip: rule and weights, and where the displacement is read."""

    rule: TipRule
    weights: Weights
    of_stress: Floats  # (3,) 1/Pa: what M of the third field has of a uniform stress xx, yy, xy
    beyond: Ints  # (b,) points of the faces that are beyond the last segment; nearer their gradients do not matter
    points: Floats  # (n + 2 b, 2) of the circles, then those `beyond` on the left face and on the right one
    elements: Ints  # (n + 2 b,)


class Integrals:
    """The integrals of K of the tips of a cover: their points and weights are found once."""

    def __init__(self, cover: Cover, singular: Floats = NOWHERE) -> None:
        """`singular` (k, 2) are points at which forces act."""
        self._cover, self._singular = cover, singular
        self._known: dict[tuple[int, bool], tuple[Disc, _Integral | None]] = {}  # None: no disc fits

    def intensities(
        self,
        materials: Sequence[PlaneElasticity],
        u: Floats,
        tips: Sequence[int],
        tractions: Sequence[FaceTraction],
        body_forces: Sequence[BodyForce | None] | None = None,
    ) -> list[StressIntensity]:
        """K_I and K_II of some `tips`; `u` (n_dofs,) m.

        `tractions` are, tip by tip, all that acts between the faces: contact tractions less fluid pressure. In-situ
        stress that varies counts by what it is at the tip; the rest of it by its divergence and what it does on the
        faces.
        """
        cover = self._cover
        forces = [None] * len(tips) if body_forces is None else body_forces
        pressed = [_pressed(cover.tips[tip], traction) for tip, traction in zip(tips, tractions, strict=True)]
        wanted = list(zip(tips, pressed, strict=True))
        self._find(materials, [each for each in dict.fromkeys(wanted) if each not in self._known])
        return [
            _no_room(disc) if integral is None else _in_disc(materials, cover, u, disc, integral, traction, force)
            for (disc, integral), traction, force in zip(
                map(self._known.__getitem__, wanted), tractions, forces, strict=True
            )
        ]

    def _find(self, materials: Sequence[PlaneElasticity], new: Sequence[tuple[int, bool]]) -> None:
        """Find the integrals of some tips, whose faces are pressed or not."""
        cover = self._cover
        discs = [disc_round(cover, cover.tips[tip], self._singular, pressed=pressed) for tip, pressed in new]
        found = iter(_integrals(cover, materials, [disc for disc in discs if not np.isnan(disc.radius)]))
        self._known |= {
            each: (disc, None if np.isnan(disc.radius) else next(found)) for each, disc in zip(new, discs, strict=True)
        }


def _pressed(tip: Tip, traction: FaceTraction) -> bool:
    """Whether the faces are pressed half way from a tip to the first sharp kink, if there is one."""
    corner = first_corner(tip)
    if not np.isfinite(corner):
        return False
    normal, _ = traction(tip.from_start(np.array([0.5 * corner])))
    return bool(normal[0] < 0.0)


def _no_room(disc: Disc) -> StressIntensity:
    nan = float("nan")
    note = f"{disc.obstacle} leaves no room for an integral round the tip"
    return StressIntensity(nan, nan, nan, nan, nan, nan, nan, True, note)


def _in_disc(
    materials: Sequence[PlaneElasticity],
    cover: Cover,
    u: Floats,
    disc: Disc,
    integral: _Integral,
    traction: FaceTraction,
    body_force: BodyForce | None,
) -> StressIntensity:
    """K of a tip."""
    tip, spacing, rule = disc.tip, cover.lattice.spacing, integral.rule
    material, in_tip_axes = materials[tip.body], materials[tip.body].turned(tip.rotation)
    by_x, by_y = fields_at(cover, integral.points, integral.elements, u)[1:]
    gradient = np.stack([by_x, by_y], axis=2) + _initial_gradient(material, cover.lattice.to_metres(tip.point))
    turned = (np.kron(tip.rotation, tip.rotation) @ gradient.reshape(-1, 4).T).reshape(2, 2, -1)
    n, b = integral.weights.fall.shape[1], len(integral.beyond)
    left, right = np.zeros((2, 2, 2, len(rule.faces.arc)))
    left[..., integral.beyond], right[..., integral.beyond] = turned[..., n : n + b], turned[..., n + b :]
    normal, tangential = _less_varying(material, cover, tip, rule.faces.arc, traction)
    along_x, along_y = rule.faces.toward_tip.T
    vectors = np.stack([tangential * along_x - normal * along_y, tangential * along_y + normal * along_x])
    M = integral.weights.M(turned[..., :n], left, right, vectors)
    if body_force is not None:
        force = spacing * tip.rotation @ body_force(cover.lattice.to_metres(rule.circles.points(tip))).T
        M = M + of_body_force(in_tip_axes, rule, force)
    pressing, shearing = traction(tip.from_start(np.zeros(1)))
    K_II, K_I = 0.5 * np.sqrt(spacing) * np.linalg.solve(in_tip_axes.release, M[:, 1::-1].T)
    of_xx, of_yy, of_xy = integral.of_stress
    of_T = (M[:, 2] - of_yy * float(pressing[0]) - of_xy * float(shearing[0])) / of_xx
    found = np.stack([K_I, K_II, of_T], axis=1)
    (K_I, K_II, T), (spread_I, spread_II, spread_T) = found[-1].tolist(), np.ptp(found, axis=0).tolist()
    note = f"{disc.obstacle} makes the disc of the integral small" if disc.small else ""
    _, (by_K_II, by_K_I) = in_tip_axes.release
    K_opening, radius = K_I + float(by_K_II / by_K_I) * K_II, disc.radius * spacing
    return StressIntensity(K_I, K_II, spread_I, spread_II, T, spread_T, radius, disc.small, note, K_opening)


def _integrals(cover: Cover, materials: Sequence[PlaneElasticity], discs: Sequence[Disc]) -> list[_Integral]:
    """The integrals over some discs."""
    if not discs:
        return []
    rocks = [materials[disc.tip.body].turned(disc.tip.rotation) for disc in discs]
    rules = [
        tip_rule(disc.tip, disc.tip.size, disc.radii, n_angular(rock.roots))
        for disc, rock in zip(discs, rocks, strict=True)
    ]
    around = [rule.circles.points(disc.tip) for disc, rule in zip(discs, rules, strict=True)]
    elements = locate(cover.lattice, cover.elements, np.concatenate(around))
    found, parts = [], np.split(elements, np.cumsum([len(p) for p in around])[:-1])
    for disc, rock, rule, own, there in zip(discs, rocks, rules, around, parts, strict=True):
        beyond = np.flatnonzero(rule.faces.arc > disc.tip.radii[1])
        faces = points_at(cover, disc.tip.crack, disc.tip.from_start(rule.faces.arc[beyond]))
        on_faces = disc.tip.point + rule.faces.place[beyond] @ disc.tip.rotation  # to the bits that the tip tells
        left_right = [faces.plus, faces.minus] if disc.tip.at_end else [faces.minus, faces.plus]
        points, at = np.concatenate([own, on_faces, on_faces]), np.concatenate([there, *left_right])
        found.append(_Integral(rule, weights_of(rock, rule), of_uniform_stress(rock), beyond, points, at))
    return found


def _initial_gradient(material: PlaneElasticity, tip: Floats) -> Floats:
    """The symmetric gradient (2, 2) whose stress is the in-situ stress at a tip (2,) m."""
    if not any(material.initial.uniform) and not material.initial.varying:
        return np.zeros((2, 2))
    xx, yy, xy2 = np.linalg.solve(material.matrix, material.initial.at(tip[None])[0])
    return np.array([[xx, 0.5 * xy2], [0.5 * xy2, yy]])


def _less_varying(
    material: PlaneElasticity, cover: Cover, tip: Tip, arc: Floats, traction: FaceTraction
) -> tuple[Floats, Floats]:
    """Tractions at arc lengths (m,) from the tip, less those of in-situ stress that differs from the tip's."""
    s = tip.from_start(arc)
    normal, tangential = traction(s)
    if material.initial.varying:
        points = points_at(cover, tip.crack, s)
        there, at_tip = (material.initial.at(cover.lattice.to_metres(at)) for at in (points.points, tip.point[None]))
        x, y = across(there - at_tip, points.normal).T
        nx, ny = points.normal.T
        normal, tangential = normal - (x * nx + y * ny), tangential - (x * ny - y * nx)
    return normal, tangential
