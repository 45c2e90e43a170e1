"""What makes a step's results doubtful."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from crackgrow.case.model import CriticalLoad, Gravity, PointSupport
from crackgrow.case.surface import end_word
from crackgrow.case.units import Metres, place_text
from crackgrow.contact.coulomb import OPEN
from crackgrow.contact.ripple import worst_ripple
from crackgrow.geometry.polyline import arc_lengths, kink_angles
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.run.caution import Cause, Caution
from crackgrow.run.judging import StepSolution
from crackgrow.run.leaving import site_criticality
from crackgrow.run.misfit import PRESSED_FLAT, Misfit, largest_jump, pressed_strain
from crackgrow.run.reactions import imbalance, reactions
from crackgrow.run.result import CrackFaces
from crackgrow.run.scene_cautions import closeness_cautions, settings_cautions, unbalanced_loads
from crackgrow.run.small_strains import large_displacements

NEAR_SHARP_KINK = 8.0
"""Cells: behind open kinks of 90, 120 and 150 degrees K is off by 5, 8 and 26 % of the K of the crack without a kink
at 3 cells, by 2, 4 and 6 % at 5."""

NEAR_CLOSED_KINK = 2.0
"""Cells: behind closed kinks of 18 to 150 degrees K is off by up to 50 % of the K of the crack without a kink at half a
cell, by 15 % at one, by 10 % from two on and by 2 % from five on; where both arms are 1.7 cells long, by 41 %."""

SAW_TEETH = 2
"""Kinks in turn, to and fro, from which on a path is a saw."""


def cautions(
    solution: StepSolution, faces: tuple[CrackFaces, ...], off: Sequence[Misfit], step: int
) -> tuple[Caution, ...]:
    """What the user should know of this step, whose `faces` miss their laws by `off`.

    What holds for all steps is said at the first.
    """
    return tuple(sorted(_all_cautions(solution, faces, off, step), key=lambda caution: caution.rank))


def _all_cautions(
    solution: StepSolution, faces: tuple[CrackFaces, ...], off: Sequence[Misfit], step: int
) -> Iterator[Caution]:
    scene = solution.scene
    for note in (*solution.outcome.notes, *solution.state.notes, *solution.notes):
        yield Cause.NOTE.at(words=note)
    yield from _off_target(solution)
    if step == 0:
        yield from settings_cautions(scene, solution.cover, solution.faces.n)
    yield from _passing_through(solution, faces)
    yield from _overlapping(off)
    yield from _jumps(solution)
    yield from _sawing(solution)
    yield from ripples(solution)
    for state, (index, at_end) in zip(solution.tips, solution.cover.tip_ends, strict=True):
        if state.intensity.small:
            radius = state.intensity.radius
            size = np.inf if np.isnan(radius) else 1.0 / radius
            place = solution.cover.cracks[index].name.end(at_end)
            yield Cause.SMALL_DISC.at(place, size, note=state.intensity.note)
    yield from _unstable(solution)
    yield from large_displacements(solution, faces)
    yield from closeness_cautions(scene, solution.cover)
    yield from _kinks(solution)
    yield from _on_points(solution)
    sizes = ((Cause.RESIDUAL, solution.outcome.residual), (Cause.ENERGY, solution.state.energy.error))
    for cause, size in (*sizes, (Cause.IMBALANCE, imbalance(solution))):
        if size > cause.limit:
            yield cause.at(size=size, percent=100.0 * size)


def ripples(solution: StepSolution) -> Iterator[Caution]:
    """Contact tractions that oscillate as no rock makes them."""
    outcome, cover, contact = solution.outcome, solution.cover, solution.scene.case.numerics.contact
    worst = worst_ripple(cover, solution.faces, outcome.points.normal, outcome.points.tangential)
    if worst is not None and worst.part > Cause.RIPPLE.limit:
        place = f"'{cover.surfaces[worst.surface].name}'"
        why, remedy = "contact points are closer than the displacement can follow", "numerics.contact."
        if contact.discretization != "mortar":
            remedy += "discretization mortar"
        elif contact.spacing < Cause.CONTACT_SPACING.limit:
            remedy += f"spacing {Cause.CONTACT_SPACING.limit:g} or more"
        else:
            why, remedy = "the pressure changes within less than two cells", "smaller cells there"
        yield Cause.RIPPLE.at(place, worst.part, percent=100.0 * worst.part, why=why, remedy=remedy)


def _unstable(solution: StepSolution) -> Iterator[Caution]:
    """A load that is far beyond the critical one, or at all where a law of growth in time has no more than v_max."""
    case, cover = solution.scene.case, solution.cover
    if case.growth is None or case.growth.steps == 0 or isinstance(case.loading, CriticalLoad):
        return
    cause, criticality = Cause.UNSTABLE if case.subcritical else Cause.OVERLOAD, site_criticality(solution)
    if criticality.max(initial=0.0) < cause.limit:
        return
    worst = int(np.argmax(criticality))
    where = place_text(cover.lattice.to_metres(solution.configuration.sites[worst].point))
    if worst < len(cover.tip_ends):
        index, at_end = cover.tip_ends[worst]
        where = cover.cracks[index].name.end(at_end)
    yield cause.at(size=criticality[worst], where=where)


def _off_target(solution: StepSolution) -> Iterator[Caution]:
    """A target of the error of K that is not met."""
    known, numerics = solution.accuracy, solution.scene.case.numerics
    if known is None or numerics.target is None or not known.missed:
        return
    share = max(known.shares(), default=math.inf)
    came = f"is within {100.0 * share:.2g} %" if share < 1.0 else "is not known to be within anything"
    yield Cause.TARGET.at(size=share, what=numerics.goal, wanted=100.0 * numerics.target, came=came, why=known.missed)


def _on_points(solution: StepSolution) -> Iterator[Caution]:
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
        if reaction.where in points and force > Cause.UNBALANCED.limit * size:
            yield Cause.UNBALANCED.at(reaction.where, force, what=f"{force:.3g} N/m at {reaction.where}")


def _passing_through(solution: StepSolution, faces: tuple[CrackFaces, ...]) -> Iterator[Caution]:
    """Cracks whose faces never touch, and lie in each other."""
    strain = pressed_strain(solution, faces)
    for law, face in zip(solution.scene.laws, faces, strict=True):
        if law.contact is not None or law.bonded:
            continue
        jump = largest_jump(face)
        deep = -face.opening > np.maximum(Cause.CONTACT_NONE.limit * jump, PRESSED_FLAT * strain * face.cell_size)
        if deep.any():
            depth = -float(face.opening[deep].min())
            yield Cause.CONTACT_NONE.at(f"'{face.crack}'", depth, depth=Metres(depth), percent=100.0 * depth / jump)


def _overlapping(surfaces: Sequence[Misfit]) -> Iterator[Caution]:
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
        yield Cause.OVERLAP.at(f"'{face.crack}'", surface.share, of_flat=of_flat, **told)


def _jumps(solution: StepSolution) -> Iterator[Caution]:
    """Tips that can grow whose stress is beyond the strength at the critical load factor."""
    for beyond, (index, at_end) in zip(solution.jumps, solution.cover.tip_ends, strict=True):
        if beyond:
            yield Cause.JUMP.at(solution.cover.cracks[index].name.end(at_end), 1.0 + beyond)


def _sawing(solution: StepSolution) -> Iterator[Caution]:
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
        if len(turns) < SAW_TEETH or np.abs(turns).min() < Cause.SAWING.limit or (turns[1:] * turns[:-1]).max() > 0.0:
            continue
        criterion = "" if growth.criterion == "max_hoop_stress" else "growth.criterion: max_hoop_stress with "
        yield Cause.SAWING.at(crack.name.end(at_end), np.abs(turns).min(), criterion=criterion)


def _kinks(solution: StepSolution) -> Iterator[Caution]:
    """Tips behind a kink whose field, which has no functions of its own, disturbs theirs."""
    for index, at_end in solution.cover.tip_ends:
        crack = solution.cover.cracks[index]
        turns = np.rad2deg(np.abs(kink_angles(crack.seen_from(at_end))))
        along = solution.cover.surfaces[index].in_cells
        cells = along.at(arc_lengths(crack.points)[1:-1])
        distance = along.total - cells[::-1] if at_end else cells
        closed = _pressed(solution, index, at_end)
        cause, near = (Cause.CLOSED_KINK, NEAR_CLOSED_KINK) if closed else (Cause.SHARP_KINK, NEAR_SHARP_KINK)
        found = np.flatnonzero((turns > cause.limit) & (distance < near - ON_LINE))
        if len(found):
            size = 1.0 / distance[found[0]] if closed else turns[found[0]]
            told = {"crack": crack.name.words, "turn": turns[found[0]], "near": near}
            yield cause.at(crack.name.end(at_end), size, end=end_word(at_end), **told)


def _pressed(solution: StepSolution, crack: int, at_end: bool) -> bool:
    """Whether the contact point next to a tip is closed."""
    mine = np.flatnonzero(solution.faces.surface == crack)
    return len(mine) > 0 and bool(solution.outcome.points.state[mine[-1 if at_end else 0]] != OPEN)
