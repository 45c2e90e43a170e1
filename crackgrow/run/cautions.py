"""What makes a step's results doubtful."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import CriticalLoad, Gravity, PointSupport
from crackgrow.contact.coulomb import OPEN
from crackgrow.cover.closeness import tip_name
from crackgrow.geometry.polyline import arc_lengths, kink_angles
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.run.caution import Cause, Caution
from crackgrow.run.contact_cautions import contact_cautions
from crackgrow.run.judging import StepSolution
from crackgrow.run.reactions import imbalance, reactions
from crackgrow.run.result import CrackFaces
from crackgrow.run.scene import Scene, SurfaceLaw
from crackgrow.run.scene_cautions import closeness_cautions, settings_cautions, unbalanced_loads

NEAR_SHARP_KINK = 8.0
"""Cells: behind open kinks of 90, 120 and 150 degrees K is off by 5, 8 and 26 % of the K of the crack without a kink
at 3 cells, by 2, 4 and 6 % at 5."""

NEAR_CLOSED_KINK = 2.0
"""Cells: behind closed kinks of 18 to 150 degrees K is off by up to 50 % of the K of the crack without a kink at half a
cell, by 15 % at one, by 10 % from two on and by 2 % from five on; where both arms are 1.7 cells long, by 41 %."""

SAW_TEETH = 2
"""Kinks in turn, to and fro, from which on a path is a saw."""

PRESSED_FLAT = 0.03
"""Overlap of a crack's faces, over what the rock of a cell gives way to the largest pressure, that is small:
a stuck flaw under a gradient of pressure has 0.05 at 5 cells, where K is felt, 0.02 at 10. Where faces stick
their jump is next to nothing, and no measure of what overlaps."""

AT_CORNERS = 0.25
"""The same on interfaces and foundations: blocks at rest have 0.14 to 0.2 at their corners on any lattice, and sticking
between two corners next to nothing; two cells a block 0.3."""


def largest_overlap(scene: Scene, faces: tuple[CrackFaces, ...]) -> float:
    """Largest overlap (m) anywhere along surfaces that have a contact law: conditions hold on average only."""
    return max((float(_overlap(law, face).max()) for law, face in zip(scene.laws, faces, strict=True)), default=0.0)


def _overlap(law: SurfaceLaw, face: CrackFaces) -> Floats:
    """Overlap (n,) m along a surface, beyond what its stiffness explains."""
    if law.contact is None:
        return np.zeros(len(face.s))
    gap = face.opening - law.compliance(face.cell_size) * face.normal_traction
    return np.abs(np.minimum(gap, 0.0))


def _apart(law: SurfaceLaw, face: CrackFaces) -> Floats:
    """Gap (n,) m along the pressed parts of a surface, beyond what its stiffness and its dilation explain."""
    apart = np.zeros(len(face.s))
    if law.contact is None:
        return apart
    closed = face.state != OPEN
    within = closed[1:-1] & closed[:-2] & closed[2:]
    elastic = law.compliance(face.cell_size) * face.normal_traction
    risen = np.tan(np.deg2rad(law.contact.dilation_angle)) * np.abs(face.slip) + elastic
    apart[1:-1][within] = np.maximum(face.opening - risen, 0.0)[1:-1][within]
    return apart


def _off(law: SurfaceLaw, face: CrackFaces) -> tuple[str, Floats]:
    """How the faces of a surface miss its contact law between contact points, in words, and by how much (n,) m."""
    ways = (("overlap", _overlap(law, face)), ("stand apart under pressure", _apart(law, face)))
    return max(ways, key=lambda way: float(way[1].max()))


def cautions(
    scene: Scene, solution: StepSolution, faces: tuple[CrackFaces, ...], shares: list[float], step: int
) -> tuple[Caution, ...]:
    """What the user should know of this step, whose faces overlap by the `shares` of `overlap_shares`.

    What holds for all steps is said at the first.
    """
    return tuple(sorted(_all_cautions(scene, solution, faces, shares, step), key=lambda caution: caution.rank))


def _all_cautions(
    scene: Scene, solution: StepSolution, faces: tuple[CrackFaces, ...], shares: list[float], step: int
) -> Iterator[Caution]:
    for note in (*solution.outcome.notes, *solution.state.notes, *solution.notes):
        yield Cause.NOTE.at(words=note)
    yield from _off_target(solution)
    if step == 0:
        yield from settings_cautions(scene, solution.cover, solution.faces.n)
    yield from _passing_through(scene, solution, faces)
    yield from _overlapping(scene, solution, faces, shares)
    yield from _jumps(scene, solution)
    yield from _sawing(scene, solution)
    yield from contact_cautions(solution)
    for state, end in zip(solution.tips, solution.cover.tip_ends, strict=True):
        if state.intensity.small:
            radius = state.intensity.radius
            size = np.inf if np.isnan(radius) else 1.0 / radius
            yield Cause.SMALL_DISC.at(_tip_name(solution, *end), size, note=state.intensity.note)
    yield from _unstable(scene, solution)
    yield from closeness_cautions(scene, solution.cover)
    yield from _kinks(solution)
    yield from _on_points(scene, solution)
    sizes = ((Cause.RESIDUAL, solution.residual), (Cause.ENERGY, solution.state.energy.error))
    for cause, size in (*sizes, (Cause.IMBALANCE, imbalance(solution))):
        if size > cause.limit:
            yield cause.at(size=size, percent=100.0 * size)


def _unstable(scene: Scene, solution: StepSolution) -> Iterator[Caution]:
    """Tips that are beyond their toughness, where a law of subcritical growth gives them a velocity."""
    if scene.case.growth is None or scene.case.growth.subcritical is None:
        return
    for state, end in zip(solution.tips, solution.cover.tip_ends, strict=True):
        if state.verdict is not None and state.verdict.criticality >= Cause.UNSTABLE.limit:
            yield Cause.UNSTABLE.at(_tip_name(solution, *end), state.verdict.criticality)


def _off_target(solution: StepSolution) -> Iterator[Caution]:
    """A target of the error of K that is not met."""
    known, target = solution.accuracy, solution.configuration.scene.case.numerics.target
    if known is None or target is None or not known.missed:
        return
    share = max(known.shares(), default=math.inf)
    what = solution.configuration.scene.case.numerics.goal
    came = f"is within {100.0 * share:.2g} %" if share < 1.0 else "is not known to be within anything"
    yield Cause.TARGET.at(size=share, what=what, wanted=100.0 * target, came=came, why=known.missed)


def _on_points(scene: Scene, solution: StepSolution) -> Iterator[Caution]:
    """Supports at points that carry forces. Of a heavy scene only what its other loads leave is told."""
    case = scene.case
    if any(isinstance(load, Gravity) for load in case.loads):
        yield from unbalanced_loads(scene, solution.cover)
        return
    found = reactions(solution.state)
    size = float(np.abs(solution.loads).sum() + sum(np.hypot(*reaction.force) for reaction in found))
    points = {f"supports.{n}" for n, support in enumerate(case.supports) if isinstance(support, PointSupport)}
    for reaction in found:
        force = float(np.hypot(*reaction.force))
        if reaction.where in points and force > Cause.UNBALANCED.limit * size:
            yield Cause.UNBALANCED.at(reaction.where, force, what=f"{force:.3g} N/m at {reaction.where}")


def _passing_through(scene: Scene, solution: StepSolution, faces: tuple[CrackFaces, ...]) -> Iterator[Caution]:
    """Cracks whose faces never touch, and lie in each other."""
    strain = _pressed_strain(scene, solution, faces)
    for law, face in zip(scene.laws, faces, strict=True):
        if law.contact is not None or law.bonded:
            continue
        jump = _largest_jump(face)
        deep = -face.opening > np.maximum(Cause.CONTACT_NONE.limit * jump, PRESSED_FLAT * strain * face.cell_size)
        if deep.any():
            depth = -float(face.opening[deep].min())
            yield Cause.CONTACT_NONE.at(f"'{face.crack}'", depth, depth=depth, percent=100.0 * depth / jump)


def overlap_shares(scene: Scene, solution: StepSolution, faces: tuple[CrackFaces, ...]) -> list[float]:
    """Overlap, or gap under pressure, of each surface over what is small there: beyond 1 it warns.

    Small is what is small beside the surface's jump, or beside what pressure does to rock.
    """
    strain = _pressed_strain(scene, solution, faces)
    shares = []
    for law, face in zip(scene.laws, faces, strict=True):
        _, off = _off(law, face)
        shares.append(float(_over_small(law, face, off, strain).max()))
    return shares


def _over_small(law: SurfaceLaw, face: CrackFaces, off: Floats, strain: float) -> Floats:
    """What the faces of a surface miss its law by (n,), over what is small there."""
    part = PRESSED_FLAT if law.kind == "crack" else AT_CORNERS
    small = np.maximum(Cause.OVERLAP.limit * _largest_jump(face), part * strain * face.cell_size)
    return np.divide(off, small, out=np.zeros(len(off)), where=off > 0.0)


def _largest_jump(face: CrackFaces) -> float:
    return float(np.hypot(face.opening, face.slip).max())


def _overlapping(
    scene: Scene, solution: StepSolution, faces: tuple[CrackFaces, ...], shares: list[float]
) -> Iterator[Caution]:
    """Surfaces whose faces overlap, or stand apart where they are pressed, by more than is small."""
    strain = _pressed_strain(scene, solution, faces)
    for law, face, share in zip(scene.laws, faces, shares, strict=True):
        if share <= 1.0:
            continue
        (how, off), of_flat = _off(law, face), ""
        worst = int(np.argmax(_over_small(law, face, off, strain)))
        overlap = float(off[worst])
        if strain:
            percent = 100.0 * overlap / (strain * float(face.cell_size[worst]))
            of_flat = f" and {percent:.3g} % of what a spacing of rock gives way to the pressure"
        percent = 100.0 * overlap / _largest_jump(face)
        yield Cause.OVERLAP.at(f"'{face.crack}'", share, how=how, overlap=overlap, percent=percent, of_flat=of_flat)


def _pressed_strain(scene: Scene, solution: StepSolution, faces: tuple[CrackFaces, ...]) -> float:
    """Strain of the rock under the largest pressure on any face, or under its own mean stress if larger.

    Times the side of the cells a length that neither the size of the specimen nor its rigid motion changes.
    """
    pressure = max((np.abs(f.normal_traction).max() for f in faces), default=0.0)
    return float(max(pressure, mean_stress(scene, solution)) / min(m.young_prime for m in scene.materials))


def mean_stress(scene: Scene, solution: StepSolution) -> float:
    """Stress (Pa) that would give the softest of the rock, all over, the strain energy that there is."""
    softest, area = min(m.young_prime for m in scene.materials), sum(region.area for region in scene.regions)
    return float(np.sqrt(2.0 * max(solution.state.energy.strain, 0.0) * softest / area))


def _jumps(scene: Scene, solution: StepSolution) -> Iterator[Caution]:
    """Tips that can grow whose stress is beyond the strength at the critical load factor."""
    if not isinstance(scene.case.loading, CriticalLoad):
        return
    for state, (index, at_end) in zip(solution.tips, solution.cover.tip_ends, strict=True):
        crack, verdict = scene.case.cracks[index], state.verdict
        grows = crack.tip_at_end if at_end else crack.tip_at_start
        if grows and verdict is not None and verdict.criticality - 1.0 > Cause.JUMP.limit:
            yield Cause.JUMP.at(_tip_name(solution, index, at_end), verdict.criticality)


def _tip_name(solution: StepSolution, crack: int, at_end: bool) -> str:
    return tip_name(solution.cover.cracks[crack].name, at_end)


def _sawing(scene: Scene, solution: StepSolution) -> Iterator[Caution]:
    """Tips whose last increments turn to and fro: steps too long for a direction that is found at their beginning."""
    growth = scene.case.growth
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
        yield Cause.SAWING.at(_tip_name(solution, index, at_end), np.abs(turns).min(), criterion=criterion)


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
            told = {"crack": f"crack '{crack.name}'", "turn": turns[found[0]], "near": near}
            yield cause.at(_tip_name(solution, index, at_end), size, end="end" if at_end else "start", **told)


def _pressed(solution: StepSolution, crack: int, at_end: bool) -> bool:
    """Whether the contact point next to a tip is closed."""
    mine = np.flatnonzero(solution.faces.surface == crack)
    return len(mine) > 0 and bool(solution.outcome.state[mine[-1 if at_end else 0]] != OPEN)
