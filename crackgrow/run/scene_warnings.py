"""Warnings of a scene: what makes results doubtful before anything is solved."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.changes import changes_of
from crackgrow.case.model import (
    Case,
    Component,
    Crack,
    EdgeSupport,
    Gravity,
    InSituStress,
    Load,
    PointForce,
    PointSupport,
)
from crackgrow.case.segments import line_length
from crackgrow.case.touching import SNAP, scene_size
from crackgrow.case.toughness import BY_K, shear_radius
from crackgrow.case.units import Metres, place_text
from crackgrow.cover.cover import Cover
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.run.missing_loads import free_edges
from crackgrow.run.scene import Scene
from crackgrow.run.starting import sites_of
from crackgrow.run.warning_causes import StepWarning, WarningCause
from crackgrow.solid.loads import point_forces
from crackgrow.vectors import cross

MOST_MOVED = 8
"""Of more points that were moved only the number is told."""

THINNEST_LAYER = 1e-4
"""Length over which elastic contact gives way at a tip, over the distance of the nodes, from which it is as rigid."""


LEAST_SUPPORT = 2.0
"""Half width of a patch, in spacings, below which rock that hardly changes its volume locks."""


def scene_warnings(scene: Scene, cover: Cover) -> Iterator[StepWarning]:
    """What holds for all steps."""
    case = scene.case
    growth, given = case.growth, tuple(map(GrowingCrack.given, case.cracks))
    starts = any(site.kind != "tip" for site in sites_of(scene, cover, given))
    if not case.numerics.measured and (cover.tips or any(length.where is not None for length in scene.lengths)):
        yield WarningCause.UNMEASURED.at()
    yield from _wide_in_shear(scene)
    yield from _short_starts(scene)
    growing = any(crack.tip_at_start or crack.tip_at_end for crack in case.cracks)
    if growth is not None and growth.steps > 0 and not growing and not starts:
        yield WarningCause.NO_TIPS.at(steps=growth.steps)
    for load in case.loads:
        if isinstance(load, PointForce) and any(load.force):
            yield WarningCause.POINT_FORCE.at(f"the force at {place_text(load.point + case.origin)}")
    yield from _soft_contact(scene, cover)
    yield from _contact_layers(scene, cover)
    yield from _incompressible(scene)
    for crack in case.cracks:
        if crack.left_out:
            yield WarningCause.LEFT_OUT.at(crack.surface.words, crack.left_out)
    yield from free_edges(scene)
    yield from _contradictions(scene, cover)
    yield from _tiny_cracks(case)
    yield from _moved(scene)
    yield from _cut(scene)


def _tiny_cracks(case: Case) -> Iterator[StepWarning]:
    """Bodies with cracks that are all in so small a part of them that their unit may be another one."""
    for body in case.bodies:
        lines = [crack.points for crack in case.cracks if crack.body == body.name]
        share = (
            float(np.hypot(*np.ptp(np.concatenate(lines), axis=0)) / np.hypot(*np.ptp(body.outline, axis=0)))
            if lines
            else 1.0
        )
        if share < WarningCause.TINY_CRACKS.limit:
            yield WarningCause.TINY_CRACKS.at(f"body '{body.name}'", share)


def _contradictions(scene: Scene, cover: Cover) -> Iterator[StepWarning]:
    """Points on an edge that are held otherwise than the edge is there."""
    supports, there = list(enumerate(scene.case.supports)), {body.name for body in cover.bodies}
    edges = [
        (m, edge, shapely.MultiLineString(list(cover.edges_on(edge.region).points)))
        for m, edge in supports
        if isinstance(edge, EdgeSupport) and edge.region.body in there
    ]
    points = [(n, support) for n, support in supports if isinstance(support, PointSupport)]
    for (n, support), (m, edge, line) in product(points, edges):
        place = shapely.Point(cover.lattice.to_lattice(support.point))
        if support.body != edge.region.body or not shapely.dwithin(line, place, SAME_PLACE):
            continue
        for component, *pair in zip("xy", support.displacement, edge.displacement, strict=True):
            mine, its = (_at_point(displacement, support.point) for displacement in pair)
            if (
                mine is None
                or its is None
                or abs(mine - its) <= WarningCause.CONTRADICTION.limit * max(abs(mine), abs(its))
            ):
                continue
            told = {"mine": Metres(mine), "its": Metres(its), "point": place_text(support.point + scene.case.origin)}
            yield WarningCause.CONTRADICTION.at(
                f"supports.{n}", abs(mine - its), other=f"supports.{m}", component=component, **told
            )


def _at_point(displacement: Component | None, point: Floats) -> float | None:
    """A displacement (m) at a point (2,) m; None where it is free."""
    return float(displacement(point[None])[0]) if callable(displacement) else displacement


def _by_shear_toughness(scene: Scene) -> Iterator[tuple[float, Crack]]:
    """Radii (m) that shear is averaged over by a toughness of its own, crack by crack."""
    for crack, body in zip(scene.case.cracks, scene.crack_bodies, strict=True):
        strength = scene.case.bodies[body].strength
        if scene.case.growth is not None and strength is not None:
            radius = shear_radius(scene.case.growth, strength)
            if radius is not None:
                yield radius, crack


def _wide_in_shear(scene: Scene) -> Iterator[StepWarning]:
    """Cracks so short beside the length that shear is averaged over that the average is not that of their K."""
    if scene.case.growth is None or scene.case.growth.criterion in BY_K:
        return  # the given cracks go on in tension alone
    for radius, crack in _by_shear_toughness(scene):
        share = radius / line_length(crack.points)
        if share > WarningCause.WIDE_SHEAR.limit:
            told = {"radius": Metres(radius), "percent": 100.0 * (1.0 - 1.0 / np.sqrt(1.0 + share))}
            yield WarningCause.WIDE_SHEAR.at(crack.surface.words, share, **told)


def _short_starts(scene: Scene) -> Iterator[StepWarning]:
    """Increments whose kinks, at which cracks may start, follow each other within the averaging radius."""
    growth = scene.case.growth
    if growth is None or growth.steps == 0 or growth.initiation.at in ("tips", "ends"):
        return
    radius = max(scene.start_radius(n) for n, body in enumerate(scene.case.bodies) if body.strength is not None)
    if growth.increment < WarningCause.SHORT_START.limit * radius:
        increment, long = Metres(growth.increment), Metres(radius)
        size = radius / growth.increment
        yield WarningCause.SHORT_START.at(size=size, increment=increment, radius=long, at=growth.initiation.at)


def _moved(scene: Scene) -> Iterator[StepWarning]:
    """What was brought to what it nearly touched when the case was read."""
    moved, told = scene.case.moved, changes_of(scene.case)[0]
    if told:
        shown = _listed(told)
        shown += "; ends of cracks that were moved are no tips" if any(move.end for move in moved) else ""
        yield WarningCause.MOVED.at(share=SNAP, metres=Metres(SNAP * scene_size(scene.case)), shown=shown)


def _cut(scene: Scene) -> Iterator[StepWarning]:
    """What of cracks was left out when the case was read."""
    told = changes_of(scene.case)[1]
    if told:
        yield WarningCause.CUT.at(n=len(told), shown=_listed(told))


def _listed(told: list[str]) -> str:
    return ", ".join([*told[:MOST_MOVED], *([f"and {len(told) - MOST_MOVED} more"] if len(told) > MOST_MOVED else [])])


def _soft_contact(scene: Scene, cover: Cover) -> Iterator[StepWarning]:
    """Surfaces whose elastic contact holds their faces apart too little."""
    stiffness = scene.case.numerics.contact.stiffness
    if stiffness is None:
        return
    softest, limit = min(material.young_prime for material in scene.materials), WarningCause.SOFT_CONTACT.limit
    for index, (surface, law) in enumerate(zip(cover.surfaces, scene.laws, strict=True)):
        share = cover.surfaces[index].in_cells.mean_size / float(arc_lengths(surface.line.points)[-1])
        ratio = 0.0 if law.contact is None or law.joint else 0.5 * share * softest / law.stiffness
        if ratio > limit:
            told = {"stiffness": stiffness, "percent": 100.0 / (1.0 + ratio), "enough": stiffness * ratio / limit}
            yield WarningCause.SOFT_CONTACT.at(f"'{surface.name}'", ratio, **told)


def _contact_layers(scene: Scene, cover: Cover) -> Iterator[StepWarning]:
    """Tips at which faces give way over less than contact points resolve, and by more than next to nothing.

    The K_I of that layer is the pressure times the root of its length.
    """
    contact = scene.case.numerics.contact
    least, most = 0.0, WarningCause.CONTACT_LAYER.limit
    points, much, other = "gauss points", "a quarter of the spacing", ""
    if contact.discretization == "mortar":
        least, most, points, much = THINNEST_LAYER * contact.spacing, contact.spacing, "mortar nodes", "their distance"
        other = "numerics.contact.discretization gauss with "
    for index, (body, law) in enumerate(zip(scene.crack_bodies, scene.laws, strict=False)):  # cracks come first
        size = np.array([cover.surfaces[index].in_cells.mean_size * scene.lattice.spacing])
        layer = 0.5 * scene.materials[body].young_prime * float(law.compliance(size)[0]) / float(size[0])  # cells
        if law.contact is not None and least < layer < most:
            yield WarningCause.CONTACT_LAYER.at(points=points, much=much, other=other)
            return


def _incompressible(scene: Scene) -> Iterator[StepWarning]:
    """What bodies that hardly change their volume cost in accuracy."""
    cause, least = WarningCause.NEARLY_INCOMPRESSIBLE, LEAST_SUPPORT
    for index, body in enumerate(scene.case.bodies if scene.case.plane == "strain" else ()):
        ratio, place = body.material.poisson, f"body '{body.name}'"
        if ratio <= cause.limit:
            continue
        if scene.case.numerics.support < least:
            locks = "it locks, displacements can be 3 % too small at 0.499 and 7 % at 0.4999"
            yield cause.at(place, 1.0 + ratio, ratio=ratio, and_so=f" and numerics.support is below {least:g}: {locks}")
        if index in scene.crack_bodies:
            off = "on a coarse lattice K can be off by 3 % at 0.499 and by 20 % at 0.4999"
            yield cause.at(place, ratio, ratio=ratio, and_so=f": {off}")


def unbalanced_loads(scene: Scene, cover: Cover) -> Iterator[StepWarning]:
    """Loads that only points could carry: what supports at points must bear where nothing else holds the scene.

    Weight is left out, unless it balances the others: who holds a heavy body at points means to. Their size is that of
    stress in the rock and that of the others, which it may balance.
    """
    case = scene.case
    if not case.supports or not all(isinstance(support, PointSupport) for support in case.supports):
        return
    for held in (True, False):
        loads = [load for load in case.loads if load.held == held]
        stress, stress_size = _resultant(case, cover, [load for load in loads if isinstance(load, InSituStress)])
        weight, _ = _resultant(case, cover, [load for load in loads if isinstance(load, Gravity)])
        others, size = _resultant(case, cover, [x for x in loads if not isinstance(x, InSituStress | Gravity)])
        size += stress_size
        left = min(max(np.hypot(x, y), abs(turn)) for x, y, turn in (stress + others, stress + others + weight))
        if left > WarningCause.UNBALANCED.limit * size:
            what = f"{left:.3g} N/m of the loads ({100.0 * left / size:.2g} %)"
            yield WarningCause.UNBALANCED.at(size=left / size, what=what)


def _resultant(case: Case, cover: Cover, loads: Sequence[Load]) -> tuple[Floats, float]:
    """Force along x and y and moment over the size of the scene (3,), N/m, of loads; and the sum of their sizes."""
    points, _, forces = point_forces(cover, case.bodies, loads, case.numerics.quadrature)
    nodes = cover.patches.nodes
    moment = cross(points - nodes.mean(axis=0), forces).sum() / np.ptp(nodes, axis=0).max()
    return np.append(forces.sum(axis=0), moment), float(np.hypot(*forces.T).sum())
