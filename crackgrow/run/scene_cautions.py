"""What makes the results of a scene doubtful before anything is solved, in words for the user."""

from __future__ import annotations

from typing import Any

import shapely

from crackgrow.case.accuracy import PRESETS
from crackgrow.case.features import Length, feature_lengths, line_length, part_lengths
from crackgrow.case.layout import SHORTEST, points_of
from crackgrow.case.meetings import scene_size
from crackgrow.case.model import EdgeTraction, PointSupport
from crackgrow.case.snapping import SNAP
from crackgrow.cover.cover import Cover
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.run.scene import Scene

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

SOFT_CONTACT = 0.1
"""What faces give way to pressure, over what a crack of their length would open under it: r = E'/(2 k length). Of the
pressure on rigid faces a crack bears 1/(1 + r), within 0.04 with mortar nodes and 0.06 with gauss points."""

NEARLY_INCOMPRESSIBLE = 0.49
"""Poisson's ratio in plane strain up to which K is within 1 %, and, at a support of 1.5, the displacement."""

MOST_MOVED = 8
"""Of more points that were moved only the number is told."""

COARSE = 0.9
"""What a lattice resolves worse than `accuracy: draft` by more than this factor is named."""

CLOSE = 1.0
"""Spacings: things closer than this share all of their patches."""

THINNEST_LAYER = 1e-4
"""Length over which elastic contact gives way at a tip, over the distance of the nodes, from which it is as rigid."""


def settings_cautions(scene: Scene, cover: Cover, n_contact: int) -> list[str]:
    """What holds for all steps."""
    found = []
    growth, spacing = scene.case.growth, scene.case.numerics.spacing
    if growth is not None and growth.tip_radius < SMALL_RADIUS * spacing:
        found.append(
            f"the averaging radius {growth.tip_radius:g} m is below {SMALL_RADIUS:g} spacings ({spacing:g} m): "
            "the tip stress may depend on the spacing"
        )
    growing = any(crack.tip_at_start or crack.tip_at_end for crack in scene.case.cracks)
    if growth is not None and growth.steps > 0 and not growing:
        found.append(f"{growth.steps} growth steps are asked for, but no crack has a tip that could grow")
    support = scene.case.numerics.support
    if support < GOOD_SUPPORT and scene.case.cracks:
        found.append(
            f"numerics.support is {support:g}: below {GOOD_SUPPORT:g} tips are resolved badly, and K can be 2 % low"
        )
    contact = scene.case.numerics.contact
    if contact.discretization == "mortar" and contact.spacing < GOOD_CONTACT_SPACING and n_contact:
        found.append(
            f"numerics.contact.spacing is {contact.spacing:g}: below {GOOD_CONTACT_SPACING:g} contact tractions can "
            "oscillate from node to node, where faces stick up to their full size"
        )
    found.extend(_soft_contact(scene, cover))
    found.extend(_elastic_contact_warnings(scene))
    found.extend(_incompressible_warnings(scene))
    found.extend(_left_out(scene))
    found.extend(_short_cracks(cover))
    found.extend(_unresolved(scene))
    found.extend(_moved(scene))
    return found


def _moved(scene: Scene) -> list[str]:
    """What was brought to what it nearly touched when the case was read."""
    moved = scene.case.moved
    if not moved:
        return []
    shown = ", ".join(
        f"{move.what} by {move.distance:.2g} m onto {move.onto} at ({move.place[0]:.12g} m, {move.place[1]:.12g} m)"
        for move in moved[:MOST_MOVED]
    )
    more = f", and {len(moved) - MOST_MOVED} more" if len(moved) > MOST_MOVED else ""
    more += "; ends of cracks that were moved are no tips" if any(move.end for move in moved) else ""
    within = f"{SNAP:g} of the scene's size, {SNAP * scene_size(scene.case):.2g} m"
    return [f"what comes nearer than {within}, touches; so these were moved: {shown}{more}"]


def _unresolved(scene: Scene) -> list[str]:
    """The hole, corner, bridge of rock, or part of an edge that a lattice given by hand resolves worst."""
    case, draft = scene.case, PRESETS["draft"]
    supports = [support.region for support in case.supports if not isinstance(support, PointSupport)]
    loads = [load.region for load in case.loads if isinstance(load, EdgeTraction)]
    lengths = [length for body in case.bodies for length in feature_lengths(body)]
    lengths += part_lengths("support", case.bodies, supports, "supported")
    lengths += part_lengths("load", case.bodies, loads, "loaded")
    for interface in case.interfaces:
        between = " and ".join(f"'{name}'" for name in interface.bodies)
        shortest = min(line_length(line) for line in interface.lines)
        lengths.append(Length("support", shortest, f"interface between bodies {between}"))
    coarse = [length for length in lengths if length.metres < draft.parts(length.kind) * scene.lattice.spacing * COARSE]
    if not coarse:
        return []
    worst = min(coarse, key=lambda length: length.metres / draft.parts(length.kind))
    more = f", and {len(coarse) - 1} more {'are' if len(coarse) > 2 else 'is'} short" if len(coarse) > 1 else ""
    return [
        f"{worst.what}: {worst.metres:.3g} m, {worst.metres / scene.lattice.spacing:.2g} spacings long{more}: stresses "
        "and displacements near it are not resolved, and can be off by tens of per cent; use a spacing of "
        f"{worst.metres / draft.parts(worst.kind):.2g} m or less, or auto"
    ]


def _short_cracks(cover: Cover) -> list[str]:
    """The shortest of the cracks that the cover does not resolve, and how many others there are."""
    lengths = [(float(arc_lengths(crack.points)[-1]), crack) for crack in cover.cracks]
    short = [(length, c.name) for length, c in lengths if length < SHORT_CRACK and not _ends_on(c, cover.cracks)]
    if not short:
        return []
    length, name = min(short)
    others = f", and {len(short) - 1} more {'are' if len(short) > 2 else 'is'} short" if len(short) > 1 else ""
    return [
        f"crack '{name}' is {length:.3g} spacings long{others}: below {SHORT_CRACK:g} the cover does not resolve a "
        "crack, and K can be off: by 2 % from one spacing on, by 8 % at half a spacing, by 20 % below"
    ]


def _soft_contact(scene: Scene, cover: Cover) -> list[str]:
    """The surface whose elastic contact holds its faces apart least."""
    stiffness = scene.case.numerics.contact.stiffness
    if stiffness is None:
        return []
    softest = min(material.young_prime for material in scene.materials)
    ratios = [
        (
            0.5 * law.compliance * softest / (float(arc_lengths(surface.points)[-1]) * scene.lattice.spacing),
            surface.name,
        )
        for surface, law in zip(cover.surfaces, scene.laws, strict=True)
        if law.contact is not None
    ]
    ratio, name = max(ratios, default=(0.0, ""))
    if ratio <= SOFT_CONTACT:
        return []
    return [
        f"numerics.contact.stiffness is {stiffness:g}, soft for '{name}': its faces give way to pressure by {ratio:.2g}"
        " of what a crack of its length would open under it, and overlap; of its pressure a crack bears about "
        f"{100.0 / (1.0 + ratio):.0f} %; use {stiffness * ratio / SOFT_CONTACT:.2g} or more, or rigid"
    ]


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


def _left_out(scene: Scene) -> list[str]:
    """Cracks that were given with more vertices than they have."""
    found = []
    given: Any = scene.case.resolved.get("cracks", {})  # nothing where the case was not read from a file
    for crack in scene.case.cracks:
        path = given.get(crack.name, {}).get("path", {})
        n = len(path["points"]) - len(points_of(path, SHORTEST * scene.lattice.spacing)) if "points" in path else 0
        if n:
            found.append(f"crack '{crack.name}': {n} of its vertices repeat the one before them, and are left out")
    return found


def _layers(scene: Scene, most: float, least: float = 0.0) -> list[bool]:
    """Crack by crack: whether its elastic contact gives way at a tip over `least` to `most` spacings.

    The K_I of that layer is the pressure times the root of its length: of the thinnest ones it is next to nothing.
    """
    stiff = (scene.materials[body].young_prime for body in scene.crack_bodies)
    lengths = (0.5 * modulus * law.compliance for modulus, law in zip(stiff, scene.laws, strict=False))
    return [least < length / scene.lattice.spacing < most for length in lengths]


def _short_arms(cover: Cover) -> list[str]:
    """Cracks that lead from a tip to another crack in a few spacings."""
    cracks = cover.cracks
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


def _close_pairs(scene: Scene, cover: Cover) -> list[tuple[str, str]]:
    """Pairs of cracks, and tips and what they lie near, that are closer than a spacing.

    Cracks that meet are close to each other there: of them only tips count.
    """
    lines = [shapely.LineString(crack.points) for crack in cover.cracks]
    names = [f"crack '{crack.name}'" for crack in cover.cracks]
    found = cover.crack_tree.query(cover.crack_tree.geometries, predicate="dwithin", distance=CLOSE).T.tolist()
    near = sorted((i, j) for i, j in found if j < i)
    meeting = [pair for pair in near if shapely.dwithin(lines[pair[0]], lines[pair[1]], ON_LINE)]
    pairs = [(names[i], names[j]) for i, j in sorted(set(near) - set(meeting))]
    outline = shapely.multilinestrings(shapely.linestrings(cover.elements.outlines.points))
    interfaces = scene.interfaces
    for tip, (index, at_end) in zip(cover.tips, cover.tip_ends, strict=True):
        name, place = f"the {'end' if at_end else 'start'} of {names[index]}", shapely.Point(tip.point)
        others = [i if j == index else j for i, j in meeting if index in (i, j)]
        pairs.extend((name, names[other]) for other in others if shapely.dwithin(lines[other], place, CLOSE))
        if shapely.dwithin(outline, place, CLOSE):
            there = [x.name for x in interfaces if shapely.dwithin(shapely.LineString(x.points), place, CLOSE)]
            pairs.append((name, f"interface '{there[0]}'" if there else "the outline"))
    return pairs


def closeness_cautions(scene: Scene, cover: Cover) -> list[str]:
    """Cracks that are short, and cracks and tips that lie close to other things."""
    return _short_arms(cover) + [
        f"{first} is closer than a spacing to {second}: the cover does not resolve what is between, and K there is too "
        "small, at a tenth of a spacing by up to 10 %, at a hundredth by 30 %"
        for first, second in _close_pairs(scene, cover)
    ]
