"""What makes a step's results doubtful, in words for the user."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from crackgrow.contact.coulomb import OPEN
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.geometry.polyline import arc_lengths, kink_angles
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.run.contact_cautions import contact_cautions
from crackgrow.run.reactions import imbalance
from crackgrow.run.result import CrackFaces
from crackgrow.run.scene import Scene, SurfaceLaw
from crackgrow.run.step import StepSolution

SMALL_RADIUS = 0.5
"""Averaging radius, in spacings, from which the averaged stress varies by less than 2.5 % with the spacing."""

SHORT_CRACK = 3.0
"""Spacings: the two tips of a shorter crack share all of their patches (K_II within 2 % from here on)."""

SHORT_ARM = 4.0
"""Spacings: where a shorter crack ends on another one, the tip functions fade out too near its tip. Of two cracks in
line or at 30 degrees one of 1, 2, 3 spacings has K off by 55, 22, 11 %, the other, of 4 or more, by 16, 6, 2 %."""

GOOD_SUPPORT = 2.0
"""Half width of a patch, in spacings, from which K is within 1 %."""

GOOD_CONTACT_SPACING = 1.25
"""Distance of the contact nodes, in spacings, from which tractions follow the displacement without oscillating."""

GAUSS_LAYER = 0.25
"""Least E'/(2k), in spacings, over which gauss points resolve how pressure falls to a closed tip: K_I is within 5 % of
its own at 0.18, 20 % off at 0.05, and of the wrong sign or size far below."""

NEARLY_INCOMPRESSIBLE = 0.49
"""Poisson's ratio in plane strain up to which K is within 1 %, and, at a support of 1.5, the displacement."""

CLOSE = 1.0
"""Spacings: things closer than this share all of their patches."""

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

THINNEST_LAYER = 1e-4
"""Length over which elastic contact gives way at a tip, over the distance of the nodes, from which it is as rigid."""

NOISE = 1e-3
"""Jumps smaller than this fraction of the displacement are within the error of the discretization."""

AT_CORNERS = 0.05
"""The same on interfaces and foundations: the corners of bodies make such overlaps on any lattice."""

LARGE_IMBALANCE = 1e-8
"""What may be missing of the balance of forces of the whole scene, by their magnitudes, before a step says so."""

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
    step: int,
    told: frozenset[str] = frozenset(),
) -> tuple[str, ...]:
    """What the user should know of this step.

    What holds for all steps is said at the first; of a tip without room for the integral of K, and of things that are
    close to each other, once: where it is not among the warnings already `told`.
    """
    slower = solution.contact.system.note
    found = [*solution.outcome.notes, *solution.notes, *([slower] if slower else [])]
    if step == 0:
        found.extend(_settings_warnings(scene, solution))
    found.extend(_overlapping(scene, solution, faces))
    found.extend(contact_cautions(solution))
    close = [
        f"{first} is closer than a spacing to {second}: the cover does not resolve what is between, and K there is too "
        "small, at a tenth of a spacing by up to 10 %, at a hundredth by 30 %"
        for first, second in _close(solution)
    ]
    close_by = (*_short_of_room(solution), *_short_arms(solution), *close, *_kinks(solution))
    found.extend(text for text in close_by if text not in told)
    if solution.residual > LARGE_RESIDUAL:
        found.append(f"the equilibrium residual is {solution.residual:.2g}: the system is ill conditioned")
    left = imbalance(solution)
    if left > LARGE_IMBALANCE:
        found.append(f"loads and reactions are out of balance by {left:.1g}: bodies of very unlike stiffness")
    return tuple(found)


def _overlapping(scene: Scene, solution: StepSolution, faces: tuple[CrackFaces, ...]) -> list[str]:
    """The surface whose faces overlap most by the size of their jump, and how many others do."""
    n_cracks, size = len(solution.cover.cracks), _elastic_size(scene, solution, faces)
    found = []
    for index, (law, face) in enumerate(zip(scene.laws, faces, strict=True)):
        largest, overlap = float(np.hypot(face.opening, face.slip).max()), _overlap(law, face)
        if overlap > max(LARGE_OVERLAP * largest, (NOISE if index < n_cracks else AT_CORNERS) * size):
            found.append((overlap / largest, overlap, face.crack))
    if not found:
        return []
    part, overlap, name = max(found)
    others = f", and those of {len(found) - 1} more by less" if len(found) > 1 else ""
    return [
        f"the faces of '{name}' overlap by {overlap:.2g} m between contact points, {100.0 * part:.3g} % of their "
        f"largest jump{others}: what happens there is unsure; use a smaller spacing"
    ]


def _settings_warnings(scene: Scene, solution: StepSolution) -> list[str]:
    """What holds for all steps."""
    found = []
    growth, spacing = scene.case.growth, scene.case.numerics.spacing
    if growth is not None and growth.tip_radius < SMALL_RADIUS * spacing:
        found.append(
            f"the averaging radius {growth.tip_radius:g} m is below {SMALL_RADIUS:g} spacings ({spacing:g} m): "
            "the tip stress may depend on the spacing"
        )
    support = scene.case.numerics.support
    if support < GOOD_SUPPORT and scene.case.cracks:
        found.append(
            f"numerics.support is {support:g}: below {GOOD_SUPPORT:g} tips are resolved badly, and K can be 2 % low"
        )
    contact = scene.case.numerics.contact
    if contact.discretization == "mortar" and contact.spacing < GOOD_CONTACT_SPACING and solution.faces.n:
        found.append(
            f"numerics.contact.spacing is {contact.spacing:g}: below {GOOD_CONTACT_SPACING:g} contact tractions can "
            "oscillate from node to node, where faces stick up to their full size"
        )
    found.extend(_elastic_contact_warnings(scene))
    found.extend(_incompressible_warnings(scene))
    found.extend(_left_out(scene))
    for crack in solution.cover.cracks:
        length = arc_lengths(crack.points)[-1]
        if length < SHORT_CRACK and not _ends_on(crack, solution.cover.cracks):
            found.append(
                f"crack '{crack.name}' is {length:.3g} spacings long: below {SHORT_CRACK:g} the cover does not resolve "
                "it, and K can be off: by 2 % from one spacing on, by 8 % at half a spacing, by 20 % below"
            )
    return found


def _elastic_contact_warnings(scene: Scene) -> list[str]:
    """Tips at which faces give way over less than contact points resolve."""
    contact = scene.case.numerics.contact
    if contact.stiffness is None:
        return []
    if contact.discretization == "gauss":
        layers, points, much = _layers(scene, GAUSS_LAYER), "gauss points", "a quarter of the spacing"
        other = ""
    else:
        layers = _layers(scene, contact.spacing, THINNEST_LAYER * contact.spacing)
        points, much, other = "mortar nodes", "their distance", "numerics.contact.discretization gauss with "
    if not any(layers):
        return []
    return [
        f"elastic contact with {points}: the pressure falls to a closed tip over E'/(2k), less than {much}, and K_I "
        f"there is not resolved; use a rigid contact, or {other}a spacing of the size of E'/(2k)"
    ]


def _incompressible_warnings(scene: Scene) -> list[str]:
    """What bodies that hardly change their volume cost in accuracy."""
    if scene.case.plane == "stress":
        return []
    found = []
    for index, body in enumerate(scene.case.bodies):
        ratio = body.material.poisson
        if ratio <= NEARLY_INCOMPRESSIBLE:
            continue
        if scene.case.numerics.support < GOOD_SUPPORT:
            found.append(
                f"body '{body.name}' has a Poisson's ratio of {ratio:g} and numerics.support is below {GOOD_SUPPORT:g}:"
                " it locks, displacements can be 3 % too small at 0.499 and 7 % at 0.4999"
            )
        if index in scene.crack_bodies:
            found.append(
                f"body '{body.name}' has a Poisson's ratio of {ratio:g}: on a coarse lattice K can be off by 3 % at "
                "0.499 and by 20 % at 0.4999; see the columns K_*_error of tips.csv"
            )
    return found


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


def _left_out(scene: Scene) -> list[str]:
    """Cracks that were given with more vertices than they have."""
    found = []
    given: Any = scene.case.resolved.get("cracks", {})  # nothing where the case was not read from a file
    for crack in scene.case.cracks:
        path = given.get(crack.name, {}).get("path", {})
        n = len(path.get("points", crack.points)) - len(crack.points)
        if n:
            found.append(f"crack '{crack.name}': {n} of its vertices repeat the one before them, and are left out")
    return found


def _elastic_size(scene: Scene, solution: StepSolution, faces: tuple[CrackFaces, ...]) -> float:
    """Displacement (m) that overlaps are held against; also where nothing but the given stress presses the faces."""
    pressure = max((np.abs(f.normal_traction).max() for f in faces), default=0.0)
    softest = min(material.young_prime for material in scene.materials)
    return float(max(solution.displacement_size, 2.0 * scene.lattice.spacing * pressure / softest))


def _layers(scene: Scene, most: float, least: float = 0.0) -> list[bool]:
    """Crack by crack: whether its elastic contact gives way at a tip over `least` to `most` spacings.

    The K_I of that layer is the pressure times the root of its length: of the thinnest ones it is next to nothing.
    """
    stiff = (scene.materials[body].young_prime for body in scene.crack_bodies)
    lengths = (0.5 * modulus * law.compliance for modulus, law in zip(stiff, scene.laws, strict=False))
    return [least < length / scene.lattice.spacing < most for length in lengths]


def _short_arms(solution: StepSolution) -> list[str]:
    """Cracks that lead from a tip to another crack in a few spacings."""
    cracks = solution.cover.cracks
    return [
        f"crack '{crack.name}' ends on {' and '.join(others)} and is shorter than {SHORT_ARM:g} spacings: K at its tip "
        "can be off by 60 %, and at the other tips by 25 %; use a smaller spacing, or give cracks that continue each "
        "other as one"
        for crack in cracks
        if arc_lengths(crack.points)[-1] < SHORT_ARM and (others := _ends_on(crack, cracks))
    ]


def _ends_on(crack: CrackGeometry, cracks: tuple[CrackGeometry, ...]) -> list[str]:
    """The cracks that one with a tip at its other end ends on."""
    if crack.tip_at_start == crack.tip_at_end:
        return []
    end = shapely.Point(crack.tip_point(not crack.tip_at_end))
    lines = [(other, shapely.LineString(other.points)) for other in cracks if other is not crack]
    return [f"crack '{other.name}'" for other, line in lines if shapely.dwithin(line, end, ON_LINE)]


def _close(solution: StepSolution) -> list[tuple[str, str]]:
    """Pairs of cracks, and tips and what they lie near, that are closer than a spacing.

    Cracks that meet are close to each other there: of them only tips count.
    """
    cover = solution.cover
    lines = [shapely.LineString(crack.points) for crack in cover.cracks]
    names = [f"crack '{crack.name}'" for crack in cover.cracks]
    near = [(i, j) for i in range(len(lines)) for j in range(i) if shapely.dwithin(lines[i], lines[j], CLOSE)]
    meeting = [pair for pair in near if shapely.dwithin(lines[pair[0]], lines[pair[1]], ON_LINE)]
    pairs = [(names[i], names[j]) for i, j in near if (i, j) not in meeting]
    outline = shapely.multilinestrings(shapely.linestrings(cover.elements.outlines.points))
    interfaces = solution.configuration.scene.interfaces
    for tip, (index, at_end) in zip(cover.tips, cover.tip_ends, strict=True):
        name, place = f"the {'end' if at_end else 'start'} of {names[index]}", shapely.Point(tip.point)
        others = [i if j == index else j for i, j in meeting if index in (i, j)]
        pairs.extend((name, names[other]) for other in others if shapely.dwithin(lines[other], place, CLOSE))
        if shapely.dwithin(outline, place, CLOSE):
            there = [x.name for x in interfaces if shapely.dwithin(shapely.LineString(x.points), place, CLOSE)]
            pairs.append((name, f"interface '{there[0]}'" if there else "the outline"))
    return pairs
