"""Warnings of a step: what makes its results doubtful."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from crackgrow.case.model import CriticalLoad, Gravity, PointSupport
from crackgrow.case.units import Metres, place_text
from crackgrow.contact.ripple import worst_ripple
from crackgrow.geometry.polyline import kink_angles
from crackgrow.run.advances import site_criticality
from crackgrow.run.contact_violation import PRESSED_FLAT, ContactViolation, largest_jump, pressed_strain
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.missing_loads import dry_joints
from crackgrow.run.reactions import imbalance, reactions
from crackgrow.run.result import CrackFaces
from crackgrow.run.scene_warnings import scene_warnings, unbalanced_loads
from crackgrow.run.small_strains import large_displacements
from crackgrow.run.warning_causes import StepWarning, WarningCause

FARTHER = 1.25
"""Cells between contact points, below which tractions can oscillate up to their full size where faces stick."""

SAW_TEETH = 2
"""Kinks in turn, to and fro, from which on a path is a saw."""


def step_warnings(
    solution: StepSolution, faces: tuple[CrackFaces, ...], off: Sequence[ContactViolation], step: int
) -> tuple[StepWarning, ...]:
    """What the user should know of this step, whose `faces` miss their laws by `off`.

    What holds for all steps is said at the first.
    """
    return tuple(sorted(_all_warnings(solution, faces, off, step), key=lambda warning: warning.rank))


def _all_warnings(
    solution: StepSolution, faces: tuple[CrackFaces, ...], off: Sequence[ContactViolation], step: int
) -> Iterator[StepWarning]:
    scene = solution.scene
    for note in (*solution.outcome.notes, *solution.state.notes, *solution.notes):
        yield WarningCause.NOTE.at(words=note)
    yield from _off_target(solution)
    if step == 0:
        yield from scene_warnings(scene, solution.cover)
    yield from _passing_through(solution, faces)
    yield from _overlapping(off)
    yield from _jumps(solution)
    yield from _sawing(solution)
    yield from ripples(solution)
    yield from _unstable(solution)
    yield from large_displacements(solution, faces)
    yield from dry_joints(scene, solution.cover)
    yield from _on_points(solution)
    sizes = ((WarningCause.RESIDUAL, solution.outcome.residual), (WarningCause.ENERGY, solution.state.energy.error))
    for cause, size in (*sizes, (WarningCause.IMBALANCE, imbalance(solution))):
        if size > cause.limit:
            yield cause.at(size=size, percent=100.0 * size)


def ripples(solution: StepSolution) -> Iterator[StepWarning]:
    """Contact tractions that oscillate as no rock makes them."""
    outcome, cover, contact = solution.outcome, solution.cover, solution.scene.case.numerics.contact
    worst = worst_ripple(cover, solution.faces, outcome.points.normal, outcome.points.tangential)
    if worst is not None and worst.part > WarningCause.RIPPLE.limit:
        place = f"'{cover.surfaces[worst.surface].name}'"
        why, remedy = "contact points are closer than the displacement can follow", "numerics.contact."
        if contact.discretization != "mortar":
            remedy += "discretization mortar"
        elif contact.spacing < FARTHER:
            remedy += f"spacing {FARTHER:g} or more"
        else:
            why, remedy = "the pressure changes within less than two cells", "smaller cells there"
        yield WarningCause.RIPPLE.at(place, worst.part, percent=100.0 * worst.part, why=why, remedy=remedy)


def _unstable(solution: StepSolution) -> Iterator[StepWarning]:
    """A load that is far beyond the critical one, or at all where a law of growth in time has no more than v_max."""
    case, cover = solution.scene.case, solution.cover
    if case.growth is None or case.growth.steps == 0 or isinstance(case.loading, CriticalLoad):
        return
    cause, criticality = (
        WarningCause.UNSTABLE if case.subcritical else WarningCause.OVERLOAD,
        site_criticality(solution),
    )
    if criticality.max(initial=0.0) < cause.limit:
        return
    worst = int(np.argmax(criticality))
    where = place_text(cover.lattice.to_metres(solution.configuration.sites[worst].point))
    if worst < len(cover.tip_ends):
        index, at_end = cover.tip_ends[worst]
        where = cover.cracks[index].name.end(at_end)
    yield cause.at(size=criticality[worst], where=where)


def _off_target(solution: StepSolution) -> Iterator[StepWarning]:
    """A target that is not met."""
    errors, numerics = solution.errors, solution.scene.case.numerics
    if errors is None or not errors.missed:
        return
    off = errors.estimate(numerics.goal)
    came = f"is off by an estimated {100.0 * off:.2g} %" if np.isfinite(off) else "has no error estimate"
    yield WarningCause.TARGET.at(
        size=off, what=numerics.goal, wanted=100.0 * numerics.target, came=came, why=errors.missed
    )


def _on_points(solution: StepSolution) -> Iterator[StepWarning]:
    """Supports at points that carry forces. Of a heavy scene only what its other loads leave is told."""
    case = solution.scene.case
    if any(isinstance(load, Gravity) for load in case.loads):
        yield from unbalanced_loads(solution.scene, solution.cover)
        return
    found = reactions(solution.state)
    size = float(np.abs(solution.loads).sum() + sum(np.hypot(*reaction.force) for reaction in found))
    points = {f"supports.{n}" for n, support in enumerate(case.supports) if isinstance(support, PointSupport)}
    for reaction in found:
        force = float(np.hypot(*reaction.force))
        if reaction.where in points and force > WarningCause.UNBALANCED.limit * size:
            yield WarningCause.UNBALANCED.at(reaction.where, force, what=f"{force:.3g} N/m at {reaction.where}")


def _passing_through(solution: StepSolution, faces: tuple[CrackFaces, ...]) -> Iterator[StepWarning]:
    """Cracks whose faces never touch, and lie in each other."""
    strain = pressed_strain(solution, faces)
    for law, face in zip(solution.scene.laws, faces, strict=True):
        if law.contact is not None or law.bonded:
            continue
        jump = largest_jump(face)
        deep = -face.opening > np.maximum(
            WarningCause.CONTACT_NONE.limit * jump, PRESSED_FLAT * strain * face.cell_size
        )
        if deep.any():
            depth = -float(face.opening[deep].min())
            yield WarningCause.CONTACT_NONE.at(
                f"'{face.crack}'", depth, depth=Metres(depth), percent=100.0 * depth / jump
            )


def _overlapping(surfaces: Sequence[ContactViolation]) -> Iterator[StepWarning]:
    """Surfaces whose faces overlap, or stand apart where they are pressed, by more than is small."""
    for surface in surfaces:
        if surface.share <= 1.0:
            continue
        worst, face, of_flat = int(np.argmax(surface.shares)), surface.face, ""
        overlap = Metres(surface.off[worst])
        if surface.strain:
            percent = 100.0 * overlap / (surface.strain * float(face.cell_size[worst]))
            of_flat = f" and {percent:.3g} % of what a spacing of rock gives way to the pressure"
        told = {"how": surface.how, "overlap": overlap, "percent": 100.0 * overlap / largest_jump(face)}
        yield WarningCause.OVERLAP.at(f"'{face.crack}'", surface.share, of_flat=of_flat, **told)


def _jumps(solution: StepSolution) -> Iterator[StepWarning]:
    """Tips that can grow whose stress is beyond the strength at the critical load factor."""
    for beyond, (index, at_end) in zip(solution.jumps, solution.cover.tip_ends, strict=True):
        if beyond:
            yield WarningCause.JUMP.at(solution.cover.cracks[index].name.end(at_end), 1.0 + beyond)


def _sawing(solution: StepSolution) -> Iterator[StepWarning]:
    """Tips whose last increments turn to and fro: steps too long for a direction that is found at their beginning."""
    scene, growth = solution.scene, solution.scene.case.growth
    if growth is None or growth.direction == "implicit":
        return
    for index, at_end in solution.cover.tip_ends:
        crack = solution.cover.cracks[index]
        given = scene.lattice.to_lattice(scene.case.cracks[index].points[-1 if at_end else 0])
        points = crack.seen_from(at_end)
        n_grown = int(np.argmin(np.hypot(*(points - given).T)))  # segments that growth has added
        turns = np.rad2deg(kink_angles(points))[: max(n_grown - 1, 0)][:SAW_TEETH]
        if (
            len(turns) < SAW_TEETH
            or np.abs(turns).min() < WarningCause.SAWING.limit
            or (turns[1:] * turns[:-1]).max() > 0.0
        ):
            continue
        criterion = "" if growth.criterion == "max_hoop_stress" else "growth.criterion: max_hoop_stress with "
        yield WarningCause.SAWING.at(crack.name.end(at_end), np.abs(turns).min(), criterion=criterion)
