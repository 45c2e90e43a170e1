"""Warnings of a step: what makes its results doubtful.

Faces meet the contact law on average only between contact points: how far they miss it there is a result as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import CriticalLoad, Gravity, PointSupport
from crackgrow.case.units import Metres, place_text
from crackgrow.contact.coulomb import OPEN
from crackgrow.contact.ripple import worst_ripple
from crackgrow.geometry.polyline import kink_angles
from crackgrow.geometry.tolerance import ROUND_OFF
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.growth import site_criticality, site_places
from crackgrow.run.result import CrackFaces
from crackgrow.run.scene_warnings import dry_joints, scene_warnings, unbalanced_loads
from crackgrow.run.state_values import imbalance, mean_stress, reactions
from crackgrow.run.surface_laws import SurfaceLaw
from crackgrow.run.warning_causes import StepWarning, limit_of, warning
from crackgrow.solid.recovery import displacement_at

FARTHER = 1.25
"""Cells between contact points, below which tractions can oscillate up to their full size where faces stick."""

SAW_TEETH = 2
"""Kinks in turn, to and fro, from which on a path is a saw."""

PRESSED_FLAT = 0.03
"""Overlap of a crack's faces, over what the rock of a cell gives way to the largest pressure, that is small:
a stuck flaw under a gradient of pressure has 0.05 at 5 cells, where K is felt, 0.02 at 10. Where faces stick
their jump is next to nothing, and no measure of what overlaps."""

AT_CORNERS = 0.25
"""The same on interfaces and foundations: blocks at rest have 0.14 to 0.2 at their corners on any lattice, and sticking
between two corners next to nothing; two cells a block 0.3."""

STILL = 1e-6
"""Of what the stress could make a crack of its length slip: faces have not moved by less, 3e-9 of it in 56 joints."""

ALONG = np.array([[1.0, 0.0, 1.0, 1.0], [0.0, 1.0, 1.0, -1.0]])
"""Axes at whose ends the outmost places of a body lie."""


def step_warnings(
    solution: StepSolution, faces: Sequence[CrackFaces], off: Sequence[ContactViolation], step: int
) -> tuple[StepWarning, ...]:
    """What the user should know of this step, whose `faces` miss their laws by `off`; what is most important first.

    What holds for all steps is said at the first.
    """
    found = [
        *(warning("NOTE", words=note) for note in (*solution.outcome.notes, *solution.notes, *solution.doubts)),
        *_missed(solution),
        *(scene_warnings(solution.scene, solution.cover) if step == 0 else ()),
        *_passing_through(solution, faces),
        *(each.warning for each in off if each.share > 1.0),
        *_of_tips(solution),
        *_ripples(solution),
        *_unstable(solution),
        *_large_displacements(solution, faces),
        *dry_joints(solution.scene, solution.cover),
        *(
            warning("SUCTION", volume.where, -volume.pressure)  # it would pull at the faces
            for volume in reactions(solution)
            if volume.pressure < -limit_of("SUCTION") * mean_stress(solution)
        ),
        *_on_points(solution),
    ]
    return tuple(sorted(found, key=lambda each: each.rank))


@dataclass(frozen=True, slots=True, eq=False)
class ContactViolation:
    """By how much the faces of one surface violate its contact law."""

    overlap: float  # m, the largest beyond what the contact stiffness explains
    share: float  # of the worst, over what is small there: beyond 1 it warns
    warning: StepWarning


def contact_violations(solution: StepSolution, faces: Sequence[CrackFaces]) -> list[ContactViolation]:
    """Overlap, or gap under pressure, of each surface. It is small beside its jump, or what pressure does to rock.

    Faces are looked at along samples, and at the contact points of kinks, of which there is one for each normal.
    """
    strain, found, (points, _) = pressed_strain(solution, faces), [], solution.along_surfaces
    names, round_off = np.array(points.crack), ROUND_OFF * float(np.abs(solution.outcome.u).max())
    for surface, law, face in zip(solution.cover.surfaces, solution.scene.laws, faces, strict=True):
        mine = np.flatnonzero(names == face.crack)
        mine = mine[np.isin(points.s[mine], points.s[mine][1:][np.diff(points.s[mine]) == 0.0])]
        size = np.append(face.cell_size, np.interp(points.s[mine], face.s, face.cell_size))
        opening = np.append(face.opening, points.opening[mine])
        elastic = law.elastic_gap(size, np.append(face.normal_traction, points.normal_traction[mine]))
        overlap = np.zeros(len(size)) if law.contact is None else np.abs(np.minimum(opening - elastic, 0.0))
        apart = np.zeros(len(size))
        apart[: len(face.s)] = _apart(law, face, elastic[: len(face.s)])
        part, jump = PRESSED_FLAT if surface.name.is_crack else AT_CORNERS, _largest_jump(face)
        small = np.maximum(max(limit_of("OVERLAP") * jump, round_off), part * strain * size)
        off = np.stack([overlap, apart])
        shares = np.divide(off, small, out=np.zeros(off.shape), where=off > 0.0)
        way, worst = np.unravel_index(int(np.argmax(shares)), shares.shape)
        most, share, flat = float(off[way, worst]), float(shares[way, worst]), size[worst] * strain
        told = {"how": ("overlap", "stand apart under pressure")[way], "overlap": Metres(most), "of_flat": ""}
        if flat:
            told["of_flat"] = f" and {100.0 * most / flat:.3g} % of what a spacing of rock gives way to the pressure"
        percent = 100.0 * most / jump if jump else 0.0
        told_of = warning("OVERLAP", f"'{face.crack}'", share, percent=percent, **told)
        found.append(ContactViolation(float(overlap.max()), share, told_of))
    return found


def _apart(law: SurfaceLaw, face: CrackFaces, elastic: Floats) -> Floats:
    """Gap (n,) m along the pressed parts of a surface, beyond what its stiffness and its dilation explain."""
    if law.contact is None or law.contact.worn[1] != law.contact.dilation_angle:
        return np.zeros(len(face.s))  # of dilation that wears slip alone does not tell what it has opened
    closed = face.state != OPEN
    within = closed & np.append(True, closed[:-1]) & np.append(closed[1:], True)
    risen = float(law.table[4, 0]) * np.abs(face.slip) + elastic  # the tangent of the dilation angle
    return np.where(within, np.maximum(face.opening - risen, 0.0), 0.0)


def _largest_jump(face: CrackFaces) -> float:
    """Largest jump (m) of the faces of a surface."""
    return float(np.hypot(face.opening, face.slip).max())


def pressed_strain(solution: StepSolution, faces: Sequence[CrackFaces]) -> float:
    """Strain of the softest rock under the largest pressure on any face, or under its own mean stress if larger."""
    pressure = max((np.abs(f.normal_traction).max() for f in faces), default=0.0)
    return float(max(pressure, mean_stress(solution)) / min(m.young_prime for m in solution.scene.materials))


def _passing_through(solution: StepSolution, faces: Sequence[CrackFaces]) -> Iterator[StepWarning]:
    """Cracks whose faces never touch, and lie in each other."""
    strain = pressed_strain(solution, faces)
    for law, face in zip(solution.scene.laws, faces, strict=True):
        if law.contact is not None or law.bonded:
            continue
        jump = _largest_jump(face)
        deep = -face.opening > limit_of("CONTACT_NONE") * jump
        if jump > STILL * strain * (face.s[-1] - face.s[0]) and deep.any():
            depth = -float(face.opening[deep].min())
            yield warning("CONTACT_NONE", f"'{face.crack}'", depth, depth=Metres(depth), percent=100.0 * depth / jump)


def _ripples(solution: StepSolution) -> Iterator[StepWarning]:
    """Contact tractions that oscillate as no rock makes them."""
    points, cover, contact = solution.outcome.points, solution.cover, solution.scene.case.numerics.contact
    worst = worst_ripple(cover, solution.configuration.faces, points.normal, points.tangential)
    if worst is not None and worst[1] > limit_of("RIPPLE"):
        surface, part = worst
        why, remedy = "contact points are closer than the displacement can follow", "numerics.contact."
        if contact.discretization != "mortar":
            remedy += "discretization mortar"
        elif contact.spacing < FARTHER:
            remedy += f"spacing {FARTHER:g} or more"
        else:
            why, remedy = "the pressure changes within less than two cells", "smaller cells there"
        place = f"'{cover.surfaces[surface].name}'"
        yield warning("RIPPLE", place, part, percent=100.0 * part, why=why, remedy=remedy)


def _missed(solution: StepSolution) -> Iterator[StepWarning]:
    """A target that is not met; forces and energies that miss each other."""
    errors, numerics = solution.errors, solution.scene.case.numerics
    if errors is not None and errors.missed:
        off, wanted = errors.estimate(numerics.goal), 100.0 * numerics.target
        came = f"is off by an estimated {100.0 * off:.2g} %" if np.isfinite(off) else "has no error estimate"
        yield warning("TARGET", size=off, what=numerics.goal, wanted=wanted, came=came, why=errors.missed)
    for cause, size in (
        ("RESIDUAL", solution.outcome.residual),
        ("ENERGY", solution.energy.error),
        ("IMBALANCE", imbalance(solution)),
    ):
        if size > limit_of(cause):
            yield warning(cause, size=size, percent=100.0 * size)
    if (size := solution.energy.created) > max(limit_of("CREATED"), solution.energy.error):
        yield warning("CREATED", size=size, percent=100.0 * size, released=solution.energy.released)


def _of_tips(solution: StepSolution) -> Iterator[StepWarning]:
    """Tips whose stress jumps beyond the strength at the critical load factor, and those whose path is a saw.

    The last increments of those turn to and fro: they are too long for a direction that is found at their beginning.
    """
    scene, growth = solution.scene, solution.scene.case.growth
    for beyond, (index, at_end) in zip(solution.jumps, solution.cover.tip_ends, strict=True):
        crack = solution.cover.cracks[index]
        if beyond:
            yield warning("JUMP", crack.name.end(at_end), 1.0 + beyond)
        if growth is None or growth.direction == "implicit":
            continue
        given = scene.lattice.to_lattice(scene.case.cracks[index].points[-1 if at_end else 0])
        points = crack.seen_from(at_end)
        n_grown = int(np.argmin(np.hypot(*(points - given).T)))  # segments that growth has added
        turns = np.rad2deg(kink_angles(points))[: max(n_grown - 1, 0)][:SAW_TEETH]
        to_and_fro = len(turns) == SAW_TEETH and bool((turns[1:] * turns[:-1] <= 0.0).all())
        if to_and_fro and (least := np.abs(turns).min()) >= limit_of("SAWING"):
            criterion = "" if growth.criterion == "max_hoop_stress" else "growth.criterion: max_hoop_stress with "
            yield warning("SAWING", crack.name.end(at_end), least, criterion=criterion)


def _unstable(solution: StepSolution) -> Iterator[StepWarning]:
    """A load that is far beyond the critical one, or at all where growth has a rate, which tips outrun then."""
    case, cover = solution.scene.case, solution.cover
    if case.growth is None or case.growth.steps == 0 or isinstance(case.loading, CriticalLoad):
        return
    cause = "UNSTABLE" if case.rate_law else "OVERLOAD"
    criticality = site_criticality(solution)
    if criticality.max(initial=0.0) < limit_of(cause):
        return
    worst = int(np.argmax(criticality))
    where = place_text(cover.lattice.to_metres(site_places(solution)[worst]))
    if worst < len(cover.tip_ends):
        index, at_end = cover.tip_ends[worst]
        where = cover.cracks[index].name.end(at_end)
    yield warning(cause, size=criticality[worst], where=where)


def _large_displacements(solution: StepSolution, faces: Sequence[CrackFaces]) -> Iterator[StepWarning]:
    """The worst of strains, rotations and slips, if any is too large for the equations of small ones.

    Of a body the mean gradient of the displacement counts, that of the linear field nearest to that of its outmost
    places; of a surface its largest jump over its length; of stress in the ground what it would strain the rock by.
    """
    found = [
        (_largest_jump(face) / face.s[-1], f"the faces of '{face.crack}' part or slip by {{}} of its length")
        for face in faces
    ]
    elements, spacing = solution.cover.elements, solution.cover.lattice.spacing
    for number, (body, material) in enumerate(zip(solution.scene.case.bodies, solution.materials, strict=True)):
        mine = np.flatnonzero(elements.body == number)
        along = elements.reference[mine] @ ALONG
        some = mine[np.concatenate([along.argmin(axis=0), along.argmax(axis=0)])]
        places = elements.reference[some]
        u = displacement_at(solution.cover, solution.outcome.u, places, some) / spacing
        gradient = np.linalg.lstsq(np.column_stack([np.ones(len(some)), places]), u, rcond=None)[0][1:].T
        strain = np.abs(material.initial.at(body.outline)).max() / material.young_prime
        found.append((strain, f"the stress in the ground would strain body '{body.name}' by {{}}"))
        found.append((np.linalg.norm(gradient, 2), f"the loads strain or turn body '{body.name}' by {{}}"))
    size, what = max(found)
    if size > limit_of("NOT_SMALL"):
        yield warning("NOT_SMALL", size=size, what=what.format(f"{100.0 * size:.2g} %"))


def _on_points(solution: StepSolution) -> Iterator[StepWarning]:
    """Supports at points that carry forces. Of a heavy scene only what its other loads leave is told."""
    case = solution.scene.case
    if any(isinstance(load, Gravity) for load in case.loads):
        yield from unbalanced_loads(solution.scene, solution.cover)
        return
    forces = {reaction.where: float(np.hypot(*reaction.force)) for reaction in reactions(solution)}
    size = float(np.abs(solution.configuration.loads(solution.level)).sum()) + sum(forces.values())
    for number, support in enumerate(case.supports):
        where = f"supports.{number}"
        if isinstance(support, PointSupport) and forces[where] > limit_of("UNBALANCED") * size:
            yield warning("UNBALANCED", where, forces[where], what=f"{forces[where]:.3g} N/m at {where}")
