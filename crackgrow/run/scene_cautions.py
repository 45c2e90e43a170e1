"""What makes the results of a scene doubtful before anything is solved."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import shapely

from crackgrow.case.accuracy import PRESETS
from crackgrow.case.features import Length, feature_lengths, line_length, part_lengths
from crackgrow.case.meetings import scene_size
from crackgrow.case.model import Case, EdgeTraction, Gravity, PointSupport
from crackgrow.case.snapping import SNAP
from crackgrow.cover.cover import Cover
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.run.caution import Cause, Caution
from crackgrow.run.scene import Scene
from crackgrow.solid.loads import load_vector

MOST_MOVED = 8
"""Of more points that were moved only the number is told."""

THINNEST_LAYER = 1e-4
"""Length over which elastic contact gives way at a tip, over the distance of the nodes, from which it is as rigid."""


def settings_cautions(scene: Scene, cover: Cover, n_contact: int) -> Iterator[Caution]:
    """What holds for all steps."""
    growth, spacing = scene.case.growth, scene.case.numerics.spacing
    if growth is not None and growth.tip_radius < Cause.SMALL_RADIUS.limit * spacing:
        yield Caution(
            Cause.SMALL_RADIUS,
            f"the averaging radius {growth.tip_radius:g} m is below {Cause.SMALL_RADIUS.limit:g} spacings "
            f"({spacing:g} m): the tip stress may depend on the spacing",
        )
    growing = any(crack.tip_at_start or crack.tip_at_end for crack in scene.case.cracks)
    if growth is not None and growth.steps > 0 and not growing:
        yield Caution(
            Cause.NO_TIPS, f"{growth.steps} growth steps are asked for, but no crack has a tip that could grow"
        )
    support, least = scene.case.numerics.support, Cause.SUPPORT.limit
    if support < least and scene.case.cracks:
        yield Caution(
            Cause.SUPPORT,
            f"numerics.support is {support:g}: below {least:g} tips are resolved badly, and K can be 2 % low",
        )
    contact, least = scene.case.numerics.contact, Cause.CONTACT_SPACING.limit
    if contact.discretization == "mortar" and contact.spacing < least and n_contact:
        yield Caution(
            Cause.CONTACT_SPACING,
            f"numerics.contact.spacing is {contact.spacing:g}: below {least:g} contact tractions can "
            "oscillate from node to node, where faces stick up to their full size",
        )
    yield from _soft_contact(scene, cover)
    yield from _contact_layers(scene)
    yield from _incompressible(scene)
    yield from _left_out(scene)
    yield from _short_cracks(cover)
    yield from _unresolved(scene)
    yield from _moved(scene)


def _unresolved(scene: Scene) -> Iterator[Caution]:
    """Holes, corners, bridges of rock, and parts of edges that a lattice given by hand does not resolve."""
    draft, spacing = PRESETS["draft"], scene.lattice.spacing
    for length in _lengths(scene.case):
        needed = length.metres / draft.parts(length.kind)
        if needed < Cause.UNRESOLVED.limit * spacing:
            yield Caution(
                Cause.UNRESOLVED,
                f"{length.what}: {length.metres:.3g} m, {length.metres / spacing:.2g} spacings long: stresses and "
                f"displacements near it are not resolved, and can be off by tens of per cent; use a spacing of "
                f"{needed:.2g} m or less, or auto",
                length.what,
                spacing / needed,
            )


def _lengths(case: Case) -> list[Length]:
    """What the stress varies over besides cracks."""
    supports = [support.region for support in case.supports if not isinstance(support, PointSupport)]
    loads = [load.region for load in case.loads if isinstance(load, EdgeTraction)]
    lengths = [length for body in case.bodies for length in feature_lengths(body)]
    lengths += part_lengths("support", case.bodies, supports, "supported")
    lengths += part_lengths("load", case.bodies, loads, "loaded")
    for interface in case.interfaces:
        between = " and ".join(f"'{name}'" for name in interface.bodies)
        shortest = min(line_length(line) for line in interface.lines)
        lengths.append(Length("support", shortest, f"interface between bodies {between}"))
    return lengths


def _moved(scene: Scene) -> Iterator[Caution]:
    """What was brought to what it nearly touched when the case was read."""
    moved = scene.case.moved
    if not moved:
        return
    shown = ", ".join(
        f"{move.what} by {move.distance:.2g} m onto {move.onto} at ({move.place[0]:.12g} m, {move.place[1]:.12g} m)"
        for move in moved[:MOST_MOVED]
    )
    more = f", and {len(moved) - MOST_MOVED} more" if len(moved) > MOST_MOVED else ""
    more += "; ends of cracks that were moved are no tips" if any(move.end for move in moved) else ""
    within = f"{SNAP:g} of the scene's size, {SNAP * scene_size(scene.case):.2g} m"
    yield Caution(Cause.MOVED, f"what comes nearer than {within}, touches; so these were moved: {shown}{more}")


def _short_cracks(cover: Cover) -> Iterator[Caution]:
    """Cracks that the cover does not resolve."""
    for crack in cover.cracks:
        length = float(arc_lengths(crack.points)[-1])
        if length < Cause.SHORT_CRACK.limit and not _ends_on(crack, cover.cracks):
            yield Caution(
                Cause.SHORT_CRACK,
                f"crack '{crack.name}' is {length:.3g} spacings long: below {Cause.SHORT_CRACK.limit:g} the cover does "
                "not resolve a crack, and K can be off: by 2 % from one spacing on, by 8 % at half a spacing, by 20 % "
                "below",
                f"crack '{crack.name}'",
                1.0 / length,
            )


def _soft_contact(scene: Scene, cover: Cover) -> Iterator[Caution]:
    """Surfaces whose elastic contact holds their faces apart too little."""
    stiffness = scene.case.numerics.contact.stiffness
    if stiffness is None:
        return
    softest = min(material.young_prime for material in scene.materials)
    for surface, law in zip(cover.surfaces, scene.laws, strict=True):
        length = float(arc_lengths(surface.points)[-1]) * scene.lattice.spacing
        ratio = 0.0 if law.contact is None else 0.5 * law.compliance * softest / length
        if ratio > Cause.SOFT_CONTACT.limit:
            yield Caution(
                Cause.SOFT_CONTACT,
                f"numerics.contact.stiffness is {stiffness:g}, soft for '{surface.name}': its faces give way to "
                f"pressure by {ratio:.2g} of what a crack of its length would open under it, and overlap; of its "
                f"pressure a crack bears about {100.0 / (1.0 + ratio):.0f} %; use "
                f"{stiffness * ratio / Cause.SOFT_CONTACT.limit:.2g} or more, or rigid",
                f"'{surface.name}'",
                ratio,
            )


def _contact_layers(scene: Scene) -> Iterator[Caution]:
    """Tips at which faces give way over less than contact points resolve."""
    contact = scene.case.numerics.contact
    if contact.stiffness is None:
        return
    if contact.discretization == "gauss":
        layers, points, much = _layers(scene, Cause.CONTACT_LAYER.limit), "gauss points", "a quarter of the spacing"
        other = ""
    else:
        layers = _layers(scene, contact.spacing, THINNEST_LAYER * contact.spacing)
        points, much, other = "mortar nodes", "their distance", "numerics.contact.discretization gauss with "
    if any(layers):
        yield Caution(
            Cause.CONTACT_LAYER,
            f"elastic contact with {points}: the pressure falls to a closed tip over E'/(2k), less than {much}, and "
            f"K_I there is not resolved; use a rigid contact, or {other}a spacing of the size of E'/(2k)",
        )


def _incompressible(scene: Scene) -> Iterator[Caution]:
    """What bodies that hardly change their volume cost in accuracy."""
    if scene.case.plane == "stress":
        return
    for index, body in enumerate(scene.case.bodies):
        ratio, place = body.material.poisson, f"body '{body.name}'"
        if ratio <= Cause.NEARLY_INCOMPRESSIBLE.limit:
            continue
        if scene.case.numerics.support < Cause.SUPPORT.limit:
            yield Caution(
                Cause.NEARLY_INCOMPRESSIBLE,
                f"{place} has a Poisson's ratio of {ratio:g} and numerics.support is below {Cause.SUPPORT.limit:g}:"
                " it locks, displacements can be 3 % too small at 0.499 and 7 % at 0.4999",
                place,
                1.0 + ratio,
            )
        if index in scene.crack_bodies:
            yield Caution(
                Cause.NEARLY_INCOMPRESSIBLE,
                f"{place} has a Poisson's ratio of {ratio:g}: on a coarse lattice K can be off by 3 % at "
                "0.499 and by 20 % at 0.4999",
                place,
                ratio,
            )


def _left_out(scene: Scene) -> Iterator[Caution]:
    """Cracks that were given with more vertices than they have."""
    given: Any = scene.case.resolved.get("cracks", {})  # nothing where the case was not read from a file
    for crack in scene.case.cracks:
        path = given.get(crack.name, {}).get("path", {})
        n = len(path.get("points", crack.points)) - len(crack.points)
        if n:
            words = f"crack '{crack.name}': {n} of its vertices repeat the one before them, and are left out"
            yield Caution(Cause.LEFT_OUT, words, f"crack '{crack.name}'", n)


def _layers(scene: Scene, most: float, least: float = 0.0) -> list[bool]:
    """Crack by crack: whether its elastic contact gives way at a tip over `least` to `most` spacings.

    The K_I of that layer is the pressure times the root of its length: of the thinnest ones it is next to nothing.
    """
    stiff = (scene.materials[body].young_prime for body in scene.crack_bodies)
    lengths = (0.5 * modulus * law.compliance for modulus, law in zip(stiff, scene.laws, strict=False))
    return [least < length / scene.lattice.spacing < most for length in lengths]


def _short_arms(cover: Cover) -> Iterator[Caution]:
    """Cracks that lead from a tip to another crack in a few spacings."""
    cracks = cover.cracks
    for crack in cracks:
        length = float(arc_lengths(crack.points)[-1])
        if length < Cause.SHORT_ARM.limit and (others := _ends_on(crack, cracks)):
            yield Caution(
                Cause.SHORT_ARM,
                f"crack '{crack.name}' ends on {' and '.join(others)} and is shorter than {Cause.SHORT_ARM.limit:g} "
                "spacings: K at its tip can be off by 60 %, and at the other tips by 25 %; use a smaller spacing, or "
                "give cracks that continue each other as one",
                f"crack '{crack.name}'",
                1.0 / length,
            )


def _ends_on(crack: CrackGeometry, cracks: tuple[CrackGeometry, ...]) -> list[str]:
    """The cracks that one with a tip at its other end ends on."""
    if crack.tip_at_start == crack.tip_at_end:
        return []
    end = shapely.Point(crack.seen_from(not crack.tip_at_end)[0])
    lines = [(other, shapely.LineString(other.points)) for other in cracks if other is not crack]
    return [f"crack '{other.name}'" for other, line in lines if shapely.dwithin(line, end, ON_LINE)]


def _close_pairs(scene: Scene, cover: Cover) -> list[tuple[str, str]]:
    """Pairs of cracks, and tips and what they lie near, that are closer than a spacing.

    Cracks that meet are close to each other there: of them only tips count.
    """
    close = Cause.CLOSE.limit
    lines = [shapely.LineString(crack.points) for crack in cover.cracks]
    names = [f"crack '{crack.name}'" for crack in cover.cracks]
    found = cover.crack_tree.query(cover.crack_tree.geometries, predicate="dwithin", distance=close).T.tolist()
    near = sorted((i, j) for i, j in found if j < i)
    meeting = [pair for pair in near if shapely.dwithin(lines[pair[0]], lines[pair[1]], ON_LINE)]
    pairs = [(names[i], names[j]) for i, j in sorted(set(near) - set(meeting))]
    outline = shapely.multilinestrings(shapely.linestrings(cover.elements.outlines.points))
    interfaces = scene.interfaces
    for tip, (index, at_end) in zip(cover.tips, cover.tip_ends, strict=True):
        name, place = f"the {'end' if at_end else 'start'} of {names[index]}", shapely.Point(tip.point)
        others = [i if j == index else j for i, j in meeting if index in (i, j)]
        pairs.extend((name, names[other]) for other in others if shapely.dwithin(lines[other], place, close))
        if shapely.dwithin(outline, place, close):
            there = [x.name for x in interfaces if shapely.dwithin(shapely.LineString(x.points), place, close)]
            pairs.append((name, f"interface '{there[0]}'" if there else "the outline"))
    return pairs


def unbalanced_loads(scene: Scene, cover: Cover) -> Iterator[Caution]:
    """Loads that only points could carry: what supports at points must bear where nothing else holds the scene.

    Weight is left out: who holds a heavy body at points means to.
    """
    case = scene.case
    if not case.supports or not all(isinstance(support, PointSupport) for support in case.supports):
        return
    for held in (True, False):
        loads = [load for load in case.loads if load.held == held and not isinstance(load, Gravity)]
        forces = load_vector(cover, case.bodies, loads, case.numerics.quadrature).reshape(-1, 2)
        forces = forces[: len(cover.patch_nodes)]  # of the patches' own functions, which add up to one everywhere
        size, arms = float(np.hypot(*forces.T).sum()), cover.patch_nodes - cover.patch_nodes.mean(axis=0)
        turning = float((arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0]).sum())
        extent = float(np.ptp(cover.patch_nodes, axis=0).max())
        left = max(float(np.hypot(*forces.sum(axis=0))), abs(turning) / extent)
        if left > Cause.UNBALANCED.limit * size:
            yield unbalanced(f"{left:.3g} N/m of the loads ({100.0 * left / size:.2g} %)", "", left / size)


def unbalanced(what: str, place: str, size: float) -> Caution:
    """What to say of a force that supports at points carry."""
    words = (
        f"{what} are carried by supports at points, where a plane gives way without bound: displacements depend on the "
        "spacing, and the stress there is not that of a specimen; balance the loads, or hold an edge"
    )
    return Caution(Cause.UNBALANCED, words, place, size)


def closeness_cautions(scene: Scene, cover: Cover) -> Iterator[Caution]:
    """Cracks that are short, and cracks and tips that lie close to other things."""
    yield from _short_arms(cover)
    for first, second in _close_pairs(scene, cover):
        yield Caution(
            Cause.CLOSE,
            f"{first} is closer than a spacing to {second}: the cover does not resolve what is between, and K there is "
            "too small, at a tenth of a spacing by up to 10 %, at a hundredth by 30 %",
            f"{first} and {second}",
        )
