"""What makes a step's results doubtful, in words for the user."""

from __future__ import annotations

import numpy as np

from crackgrow.contact.coulomb import OPEN
from crackgrow.geometry.polyline import arc_lengths, kink_angles
from crackgrow.run.contact_cautions import contact_cautions
from crackgrow.run.reactions import imbalance
from crackgrow.run.result import CrackFaces
from crackgrow.run.scene import Scene, SurfaceLaw
from crackgrow.run.scene_cautions import closeness_cautions, settings_cautions
from crackgrow.run.step import StepSolution

SHARP_KINK = 75.0
"""Degrees: up to here closed kinks 3 spacings from a tip cost its K_II 1 % and its K_I 6 % of the larger K."""

NEAR_KINK = 8.0
"""Spacings: at sharper kinks, 90 to 150 degrees, that are as far from a tip K is within 5 % of the larger K."""

CLOSED_KINK = 20.0
"""Degrees: kinks from which on closed faces make a K_I of more than a tenth of K_II at a tip close behind."""

NEAR_CLOSED_KINK = 2.0
"""Spacings: behind a closed kink of 30 degrees K_I is off by 0.2 of K_II at 1.3 spacings, by 0.3 at 0.3."""

LARGE_OVERLAP = 0.05
"""Overlap of faces, as a fraction of the largest jump, from which a step carries a warning."""

NOISE = 1e-3
"""Jumps smaller than this fraction of the displacement are within the error of the discretization."""

AT_CORNERS = 0.05
"""The same on interfaces and foundations: the corners of bodies make such overlaps on any lattice."""

LARGE_IMBALANCE = 1e-8
"""What may be missing of the balance of forces of the whole scene, by their magnitudes, before a step says so."""

LARGE_ENERGY_ERROR = 1e-4
"""Error of the balance of energy from which a step carries a warning: ten times what a part of the load may miss."""

LARGE_RESIDUAL = 1e-9
"""Relative equilibrium residual from which a step carries a warning."""


def largest_overlap(scene: Scene, faces: tuple[CrackFaces, ...]) -> float:
    """Largest overlap (m) anywhere along surfaces that have a contact law: conditions hold on average only."""
    return max((_overlap(law, face) for law, face in zip(scene.laws, faces, strict=True)), default=0.0)


def _overlap(law: SurfaceLaw, face: CrackFaces) -> float:
    """Largest overlap (m) along a surface, beyond what its stiffness explains."""
    if law.contact is None:
        return 0.0
    return abs(float((face.opening - law.compliance * face.normal_traction).min(initial=0.0)))


def cautions(
    scene: Scene,
    solution: StepSolution,
    faces: tuple[CrackFaces, ...],
    shares: list[float],
    step: int,
    told: frozenset[str] = frozenset(),
) -> tuple[str, ...]:
    """What the user should know of this step, whose faces overlap by the `shares` of `overlap_shares`.

    What holds for all steps is said at the first; of a tip without room for the integral of K, and of things that are
    close to each other, once: where it is not among the warnings already `told`.
    """
    slower = solution.contact.system.note
    found = [*solution.outcome.notes, *solution.state.notes, *solution.notes, *([slower] if slower else [])]
    if step == 0:
        found.extend(settings_cautions(scene, solution.cover, solution.faces.n))
    found.extend(_overlapping(scene, faces, shares))
    found.extend(contact_cautions(solution))
    close_by = (*_short_of_room(solution), *closeness_cautions(scene, solution.cover), *_kinks(solution))
    found.extend(text for text in close_by if text not in told)
    if solution.residual > LARGE_RESIDUAL:
        found.append(f"the equilibrium residual is {solution.residual:.2g}: the system is ill conditioned")
    error = solution.state.energy.error
    if error > LARGE_ENERGY_ERROR:
        found.append(
            f"work, strain energy, dissipation and release are out of balance by {error:.1g} of the largest: contact "
            "points change on the way; apply the load in smaller steps (loading.history)"
        )
    left = imbalance(solution)
    if left > LARGE_IMBALANCE:
        found.append(f"loads and reactions are out of balance by {left:.1g}: bodies of very unlike stiffness")
    return tuple(found)


def overlap_shares(scene: Scene, solution: StepSolution, faces: tuple[CrackFaces, ...]) -> list[float]:
    """Overlap of each surface over what is small beside its jump and the displacement: beyond 1 a step warns."""
    n_cracks, size = len(solution.cover.cracks), _elastic_size(scene, solution, faces)
    shares = []
    for index, (law, face) in enumerate(zip(scene.laws, faces, strict=True)):
        small = max(LARGE_OVERLAP * _largest_jump(face), (NOISE if index < n_cracks else AT_CORNERS) * size)
        overlap = _overlap(law, face)
        shares.append(overlap / small if overlap > 0.0 else 0.0)
    return shares


def _largest_jump(face: CrackFaces) -> float:
    return float(np.hypot(face.opening, face.slip).max())


def _overlapping(scene: Scene, faces: tuple[CrackFaces, ...], shares: list[float]) -> list[str]:
    """The surface whose faces overlap most by the size of their jump, and how many others do."""
    found = [
        (overlap / _largest_jump(face), overlap, face.crack)
        for law, face, share in zip(scene.laws, faces, shares, strict=True)
        if share > 1.0 and (overlap := _overlap(law, face))
    ]
    if not found:
        return []
    part, overlap, name = max(found)
    others = f", and those of {len(found) - 1} more by less" if len(found) > 1 else ""
    return [
        f"the faces of '{name}' overlap by {overlap:.2g} m between contact points, {100.0 * part:.3g} % of their "
        f"largest jump{others}: what happens there is unsure; use a smaller spacing"
    ]


def _short_of_room(solution: StepSolution) -> list[str]:
    """Tips whose K comes from a smaller disc than usual, or from the displacement of the faces alone."""
    found = []
    for state, (index, at_end) in zip(solution.tips, solution.cover.tip_ends, strict=True):
        if state.intensity.shrunk:
            place = f"the {'end' if at_end else 'start'} of crack '{solution.cover.cracks[index].name}'"
            found.append(f"K at {place}: {state.intensity.note}; see the columns K_*_error of tips.csv")
    return found


def _kinks(solution: StepSolution) -> list[str]:
    """Tips behind a kink whose field, which has no functions of its own, disturbs theirs."""
    found = []
    for index, at_end in solution.cover.tip_ends:
        crack = solution.cover.cracks[index]
        points = crack.points[::-1] if at_end else crack.points
        turns, distance = np.rad2deg(np.abs(kink_angles(points))), arc_lengths(points)[1:-1]
        where = f"spacings from its {'end' if at_end else 'start'}"
        sharp = np.flatnonzero((turns > SHARP_KINK) & (distance < NEAR_KINK))
        young = np.flatnonzero((turns > CLOSED_KINK) & (distance < NEAR_CLOSED_KINK))
        if len(sharp):
            found.append(
                f"crack '{crack.name}' turns by {turns[sharp[0]]:.0f} degrees less than {NEAR_KINK:g} {where}: so "
                "sharp a corner is not resolved, and K there can be off by half of the larger of K_I and K_II"
            )
        elif len(young) and _pressed(solution, index, at_end):
            found.append(
                f"crack '{crack.name}' is closed and turns by {turns[young[0]]:.0f} degrees less than "
                f"{NEAR_CLOSED_KINK:g} {where}: K_I there can be off by a third of K_II, and by all of it where the "
                "kink is closer than half a spacing"
            )
    return found


def _pressed(solution: StepSolution, crack: int, at_end: bool) -> bool:
    """Whether the contact point next to a tip is closed."""
    mine = np.flatnonzero(solution.faces.surface == crack)
    return len(mine) > 0 and bool(solution.outcome.state[mine[-1 if at_end else 0]] != OPEN)


def _elastic_size(scene: Scene, solution: StepSolution, faces: tuple[CrackFaces, ...]) -> float:
    """Displacement (m) that overlaps are held against; also where nothing but the given stress presses the faces."""
    pressure = max((np.abs(f.normal_traction).max() for f in faces), default=0.0)
    softest = min(material.young_prime for material in scene.materials)
    return float(max(solution.displacement_size, 2.0 * scene.lattice.spacing * pressure / softest))
