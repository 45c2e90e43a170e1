"""K_I and K_II of the tips of a cover by the interaction integral: what `interaction` needs, from the displacement."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.contact.faces import points_at
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.cover.tips import Tip
from crackgrow.fracture.interaction import interaction
from crackgrow.fracture.tip_disc import Disc, disc_round, first_corner
from crackgrow.fracture.tip_rule import TipRule, tip_rule
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.in_situ import across
from crackgrow.solid.recovery import gradient_at

FaceTraction = Callable[[Floats], tuple[Floats, Floats]]
"""Normal and tangential traction (n,) Pa at arc lengths (n,), spacings, from the crack's start."""

BodyForce = Callable[[Floats], Floats]
"""Force (n, 2) N/m^3 on the rock at places (n, 2) m, besides a uniform in-situ stress."""

TIPS_AT_ONCE = 4
"""Tips whose points are evaluated together: a call costs as much as some hundred points."""


@dataclass(frozen=True, slots=True, eq=False)
class StressIntensity:
    """K of one tip. K_II is positive where the face on the left of the outward direction moves outward."""

    K_I: float  # Pa sqrt(m)
    K_II: float  # Pa sqrt(m)
    K_I_spread: float  # Pa sqrt(m): over three radii
    K_II_spread: float  # Pa sqrt(m)
    radius: float  # m, of the largest disc; nan where none fits
    small: bool  # whether the disc spans but few cells
    note: str  # why, in words; empty where it is not


def interaction_integrals(
    cover: Cover,
    materials: Sequence[PlaneElasticity],
    u: Floats,
    tips: Sequence[int],
    tractions: Sequence[FaceTraction],
    body_forces: Sequence[BodyForce | None] | None = None,
) -> list[StressIntensity]:
    """K_I and K_II of the `tips` of a cover; `u` (n_dofs,) m.

    `tractions` are, tip by tip, all that acts between the faces: contact tractions less fluid pressure. In-situ stress
    that varies counts by what it is at the tip; the rest of it by its divergence and what it does on the faces.
    """
    forces = [None] * len(tips) if body_forces is None else body_forces
    discs = [
        disc_round(cover, cover.tips[tip], pressed=_pressed(cover.tips[tip], traction))
        for tip, traction in zip(tips, tractions, strict=True)
    ]
    sampled = _sampled(cover, materials, u, [disc for disc in discs if not np.isnan(disc.radius)])
    return [
        _no_room(disc)
        if np.isnan(disc.radius)
        else _in_disc(materials[disc.tip.body], cover, next(sampled), traction, force)
        for disc, traction, force in zip(discs, tractions, forces, strict=True)
    ]


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
    return StressIntensity(nan, nan, nan, nan, nan, True, note)


@dataclass(frozen=True, slots=True, eq=False)
class _Samples:
    """The elastic displacement gradients round a tip, in its axes."""

    disc: Disc
    rule: TipRule
    around: Floats  # (2, 2, n) at the points of the rule's circles
    on_faces: Floats  # (2, 2, m) sums of both faces; zero on the last segment, where they don't matter


def _in_disc(
    material: PlaneElasticity, cover: Cover, samples: _Samples, traction: FaceTraction, body_force: BodyForce | None
) -> StressIntensity:
    """K of a tip."""
    disc, rule, tip, spacing = samples.disc, samples.rule, samples.disc.tip, cover.lattice.spacing
    normal, tangential = _less_varying(material, cover, tip, rule, traction)
    along_x, along_y = rule.faces.toward_tip.T
    vectors = 2.0 * np.stack([tangential * along_x - normal * along_y, tangential * along_y + normal * along_x])
    force = None
    if body_force is not None:
        force = spacing * tip.rotation @ body_force(cover.lattice.to_metres(rule.circles.points(tip))).T
    M = interaction(material, rule, samples.around, vectors, samples.on_faces, force)
    K = 0.5 * material.young_prime * np.sqrt(spacing) * M
    (K_I, K_II), (spread_I, spread_II) = K[-1].tolist(), np.ptp(K, axis=0).tolist()
    note = f"{disc.obstacle} makes the disc of the integral small" if disc.small else ""
    return StressIntensity(K_I, K_II, spread_I, spread_II, disc.radius * spacing, disc.small, note)


def _sampled(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, discs: Sequence[Disc]
) -> Iterator[_Samples]:
    """What the integrals need of the displacement, disc by disc."""
    for first in range(0, len(discs), TIPS_AT_ONCE):
        some = discs[first : first + TIPS_AT_ONCE]
        rules = [tip_rule(disc.tip, disc.tip.size, disc.radii) for disc in some]
        points = [rule.circles.points(disc.tip) for disc, rule in zip(some, rules, strict=True)]
        elements = [locate(cover.lattice, cover.elements, np.concatenate(points))]
        kinked = []
        for disc, rule in zip(some, rules, strict=True):
            beyond = np.flatnonzero(rule.faces.arc > disc.tip.radii[1])
            there = points_at(cover, disc.tip.crack, disc.tip.from_start(rule.faces.arc[beyond]))
            kinked.append(beyond)
            points += [there.points, there.points]
            elements += [there.plus, there.minus]
        found = gradient_at(cover, u, np.concatenate(points), np.concatenate(elements)).transpose(1, 2, 0)
        parts = np.split(found, np.cumsum([len(part) for part in points])[:-1], axis=2)
        for number, (disc, rule, beyond) in enumerate(zip(some, rules, kinked, strict=True)):
            turn, place = disc.tip.rotation, cover.lattice.to_metres(disc.tip.point)
            initial = _initial_gradient(materials[disc.tip.body], place)
            plus, minus = parts[len(some) + 2 * number : len(some) + 2 * number + 2]
            both = np.zeros((2, 2, len(rule.faces.arc)))
            both[:, :, beyond] = _turned(turn, plus + minus + 2.0 * initial)
            yield _Samples(disc, rule, _turned(turn, parts[number] + initial), both)


def _turned(rotation: Floats, gradients: Floats) -> Floats:
    """Gradients (2, 2, n) in other axes."""
    return np.asarray((np.kron(rotation, rotation) @ gradients.reshape(4, -1)).reshape(2, 2, -1))


def _initial_gradient(material: PlaneElasticity, tip: Floats) -> Floats:
    """The symmetric gradient (2, 2, 1) whose stress is the in-situ stress at a tip (2,) m."""
    if not any(material.initial.uniform) and not material.initial.varying:
        return np.zeros((2, 2, 1))
    xx, yy, xy2 = np.linalg.solve(material.matrix, material.initial.at(tip[None])[0])
    return np.array([[[xx], [0.5 * xy2]], [[0.5 * xy2], [yy]]])


def _less_varying(
    material: PlaneElasticity, cover: Cover, tip: Tip, rule: TipRule, traction: FaceTraction
) -> tuple[Floats, Floats]:
    """Tractions at the points of the faces, less those of in-situ stress that differs from the tip's."""
    s = tip.from_start(rule.faces.arc)
    normal, tangential = traction(s)
    if material.initial.varying:
        points = points_at(cover, tip.crack, s)
        there, at_tip = (material.initial.at(cover.lattice.to_metres(at)) for at in (points.points, tip.point[None]))
        x, y = across(there - at_tip, points.normal).T
        nx, ny = points.normal.T
        normal, tangential = normal - (x * nx + y * ny), tangential - (x * ny - y * nx)
    return normal, tangential
