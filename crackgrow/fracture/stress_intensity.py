"""K_I, K_II and T of tips by the interaction integral: what `interaction` needs, from the displacement."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from crackgrow.approximation.basis import gradient_sums
from crackgrow.arrays import Floats, Ints
from crackgrow.contact.faces import points_at
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.cover.tips import Tip
from crackgrow.fracture.functionals import Functional
from crackgrow.fracture.interaction import FIELDS, of_body_force, of_uniform_stress, weights_of
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
class InteractionFunctional:
    """The integrals of a tip, as what they take of the displacement and of what acts on the faces."""

    disc: Disc
    functional: Functional | None  # None: no disc fits


class Integrals:
    """The integrals of K of the tips of a cover: what each disc reads off is found once."""

    def __init__(self, cover: Cover, singular: Floats = NOWHERE) -> None:
        """`singular` (k, 2) are points at which forces act."""
        self._cover, self._singular = cover, singular
        self._known: dict[tuple[int, bool], InteractionFunctional] = {}

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
        known = self.functionals_of(materials, list(zip(tips, pressed, strict=True)))
        return [_in_disc(materials, cover, u, *each) for each in zip(known, tractions, forces, strict=True)]

    def functionals_of(
        self, materials: Sequence[PlaneElasticity], wanted: Sequence[tuple[int, bool]]
    ) -> list[InteractionFunctional]:
        """What the integrals of some tips read off, whose faces are pressed or not."""
        cover, new = self._cover, [each for each in dict.fromkeys(wanted) if each not in self._known]
        discs = [disc_round(cover, cover.tips[tip], self._singular, pressed=pressed) for tip, pressed in new]
        found = iter(_functionals(cover, materials, [disc for disc in discs if not np.isnan(disc.radius)]))
        for each, disc in zip(new, discs, strict=True):
            self._known[each] = InteractionFunctional(disc, None if np.isnan(disc.radius) else next(found))
        return [self._known[each] for each in wanted]


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
    known: InteractionFunctional,
    traction: FaceTraction,
    body_force: BodyForce | None,
) -> StressIntensity:
    """K of a tip."""
    disc, tip, spacing = known.disc, known.disc.tip, cover.lattice.spacing
    if known.functional is None:
        return _no_room(disc)
    material, in_tip_axes = materials[tip.body], materials[tip.body].turned(tip.rotation)
    arc, toward_tip, of_uniform, of_vectors, of_stress = known.functional.more
    normal, tangential = _less_varying(material, cover, tip, arc, traction)
    along_x, along_y = toward_tip.T
    vectors = np.stack([tangential * along_x - normal * along_y, tangential * along_y + normal * along_x])
    by_component = known.functional.of(u).reshape(2, -1, 2)  # [c of its weights, M, c]
    M = by_component[0, :, 0] + by_component[1, :, 1] + of_vectors @ vectors.ravel()
    M += of_uniform @ _initial_gradient(material, cover.lattice.to_metres(tip.point)).ravel()
    M = M.reshape(-1, FIELDS)
    if body_force is not None:
        rule = tip_rule(tip, tip.size, disc.radii, n_angular(in_tip_axes.roots))
        force = spacing * tip.rotation @ body_force(cover.lattice.to_metres(rule.circles.points(tip))).T
        M = M + of_body_force(in_tip_axes, rule, force)
    pressing, shearing = traction(tip.from_start(np.zeros(1)))
    K_II, K_I = 0.5 * np.sqrt(spacing) * np.linalg.solve(in_tip_axes.release, M[:, 1::-1].T)
    of_T = (M[:, 2] - of_stress[1] * float(pressing[0]) - of_stress[2] * float(shearing[0])) / of_stress[0]
    found = np.stack([K_I, K_II, of_T], axis=1)
    (K_I, K_II, T), (spread_I, spread_II, spread_T) = found[-1].tolist(), np.ptp(found, axis=0).tolist()
    note = f"{disc.obstacle} makes the disc of the integral small" if disc.small else ""
    _, (by_K_II, by_K_I) = in_tip_axes.release
    K_opening, radius = K_I + float(by_K_II / by_K_I) * K_II, disc.radius * spacing
    return StressIntensity(K_I, K_II, spread_I, spread_II, T, spread_T, radius, disc.small, note, K_opening)


def _functionals(cover: Cover, materials: Sequence[PlaneElasticity], discs: Sequence[Disc]) -> list[Functional]:
    """What the integrals of some discs read off."""
    if not discs:
        return []
    rocks = [materials[disc.tip.body].turned(disc.tip.rotation) for disc in discs]
    rules = [
        tip_rule(disc.tip, disc.tip.size, disc.radii, n_angular(rock.roots))
        for disc, rock in zip(discs, rocks, strict=True)
    ]
    around = [rule.circles.points(disc.tip) for disc, rule in zip(discs, rules, strict=True)]
    elements = locate(cover.lattice, cover.elements, np.concatenate(around))
    found = []
    for disc, rock, rule, own, there in zip(
        discs, rocks, rules, around, np.split(elements, np.cumsum([len(p) for p in around])[:-1]), strict=True
    ):
        beyond = np.flatnonzero(rule.faces.arc > disc.tip.radii[1])
        faces = points_at(cover, disc.tip.crack, disc.tip.from_start(rule.faces.arc[beyond]))
        on_faces = disc.tip.point + rule.faces.place[beyond] @ disc.tip.rotation  # to the bits that the tip tells
        at = np.concatenate([own, on_faces, on_faces])
        left_right = [faces.plus, faces.minus] if disc.tip.at_end else [faces.minus, faces.plus]
        found.append(_functional(cover, rock, disc, rule, beyond, (at, np.concatenate([there, *left_right]))))
    return found


def _functional(
    cover: Cover, material: PlaneElasticity, disc: Disc, rule: TipRule, beyond: Ints, at: tuple[Floats, Ints]
) -> Functional:
    """What the integrals of a disc read off at its points and elements, for a material in the axes of its tip.

    These n points are those of the circles, and those `beyond` the last segment on both faces; nearer to the tip the
    derivative along the faces does not matter.
    """
    weights, turn = weights_of(material, rule), disc.tip.rotation
    at_points = np.concatenate([weights.around, weights.left[..., beyond], weights.right[..., beyond]], axis=-1)
    turned = np.kron(turn, turn).T @ at_points.reshape(FIELDS * len(rule.radii), 4, -1)  # [M, c and d, n]
    of_c = turned.reshape(len(turned), 2, 2, -1).transpose(2, 3, 1, 0)
    functions, sums = gradient_sums(cover, *at, of_c.reshape(2, -1, 2 * len(turned)))
    of_uniform = turned.sum(axis=-1)
    of_vectors = weights.vectors.reshape(FIELDS * len(rule.radii), -1)
    more = (rule.faces.arc, rule.faces.toward_tip, of_uniform, of_vectors, of_uniform_stress(material))
    return Functional(functions, np.ascontiguousarray(sums.T), more)


def _initial_gradient(material: PlaneElasticity, tip: Floats) -> Floats:
    """The symmetric gradient (2, 2, 1) whose stress is the in-situ stress at a tip (2,) m."""
    if not any(material.initial.uniform) and not material.initial.varying:
        return np.zeros((2, 2, 1))
    xx, yy, xy2 = np.linalg.solve(material.matrix, material.initial.at(tip[None])[0])
    return np.array([[[xx], [0.5 * xy2]], [[0.5 * xy2], [yy]]])


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
