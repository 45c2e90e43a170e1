"""Warnings of a scene: what makes results doubtful before anything is solved, and loads that are missing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case import model
from crackgrow.case.dump import changes_of
from crackgrow.case.formula import component_at
from crackgrow.case.segments import line_length
from crackgrow.case.touching import SNAP, scene_size
from crackgrow.case.toughness import BY_K, shear_radius
from crackgrow.case.units import Metres, place_text
from crackgrow.cover.cover import Cover
from crackgrow.cover.shapes import ends_at_bonds
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.debond import debond_number
from crackgrow.geometry.tolerance import ON_LINE, SAME_PLACE
from crackgrow.quadrature.rules import gauss
from crackgrow.run.scene import Scene
from crackgrow.run.starting import sites_of
from crackgrow.run.warning_causes import StepWarning, limit_of, warning
from crackgrow.solid.in_situ import InSitu
from crackgrow.solid.loads import point_forces
from crackgrow.vectors import across, cross, outward_normals

MOST_MOVED = 8
"""Of more points that were moved only the number is told."""

POINTS = 8
"""Along each side: what is held or loaded over less than an eighth of it may be missed."""

MOST_NAMED = 6
"""Of more edges only the number is told."""

LEAST_SUPPORT = 2.0
"""Half width of a patch, in spacings, below which rock that hardly changes its volume locks."""

FluidLoad = model.FluidPressure | model.FluidVolume | model.EdgePressure


def scene_warnings(scene: Scene, cover: Cover) -> Iterator[StepWarning]:
    """What holds for all steps."""
    case, growth = scene.case, scene.case.growth
    if not case.numerics.measured and (cover.tips or any(length.where is not None for length in scene.lengths)):
        yield warning("UNMEASURED")
    if growth is not None and growth.steps > 0:
        sites = sites_of(scene, cover, tuple(map(GrowingCrack.given, case.cracks)))
        growing = any(each.toughness is not None for each in case.interfaces) or any(
            crack.tip_at_start or crack.tip_at_end for crack in case.cracks
        )
        if not growing and all(site.kind == "tip" for site in sites):
            yield warning("NO_TIPS", steps=growth.steps)
    yield from _of_growth(scene)
    yield from _of_cracked_interfaces(scene, cover)
    for load in case.loads:
        if isinstance(load, model.PointForce) and any(load.force):
            yield warning("POINT_FORCE", f"the force at {place_text(load.point + case.origin)}")
    for body in case.bodies if case.plane == "strain" and case.numerics.support < LEAST_SUPPORT else ():
        if (ratio := body.material.poisson) > limit_of("LOCKING"):
            yield warning("LOCKING", f"body '{body.name}'", ratio, least=LEAST_SUPPORT)
    yield from free_edges(scene)
    yield from _contradictions(scene, cover)
    yield from _of_files(case)


def _of_cracked_interfaces(scene: Scene, cover: Cover) -> Iterator[StepWarning]:
    """Tips of cracked interfaces that do not grow, and what is not known of them."""
    growth, tips = scene.case.growth, ends_at_bonds([surface.line for surface in cover.surfaces])
    varying = {body.name for body, of in zip(cover.bodies, scene.materials_at(1.0), strict=True) if of.initial.varying}
    for name in dict.fromkeys(cover.surfaces[number].name for number, _ in tips):
        if growth is not None and growth.steps > 0 and debond_number(scene.debonds, name) is None:
            yield warning("BONDED_TIPS", name.words)
        if not varying.isdisjoint(name.of):
            yield warning("UNKNOWN_G", name.words)


def _of_files(case: model.Case) -> Iterator[StepWarning]:
    """What was brought to what it nearly touched, and what of cracks was left out, when the case was read; its units.

    Cracks that are all in a very small part of their body may be in another unit.
    """
    moved, cut = changes_of(case)
    if moved:
        shown = _listed(moved)
        shown += "; ends of cracks that were moved are no tips" if any(move.end for move in case.moved) else ""
        yield warning("MOVED", share=SNAP, metres=Metres(SNAP * scene_size(case)), shown=shown)
    if cut:
        yield warning("CUT", n=len(cut), shown=_listed(cut))
    for crack in case.cracks:
        if crack.left_out:
            yield warning("LEFT_OUT", crack.surface.words, crack.left_out)
    for body in case.bodies:
        lines = [crack.points for crack in case.cracks if crack.body == body.name] or [body.outline]
        share = float(np.hypot(*np.ptp(np.concatenate(lines), axis=0)) / np.hypot(*np.ptp(body.outline, axis=0)))
        if share < limit_of("TINY_CRACKS"):
            yield warning("TINY_CRACKS", f"body '{body.name}'", share)


def _listed(told: list[str]) -> str:
    more = [f"and {len(told) - MOST_MOVED} more"] if len(told) > MOST_MOVED else []
    return ", ".join([*told[:MOST_MOVED], *more])


def _contradictions(scene: Scene, cover: Cover) -> Iterator[StepWarning]:
    """Points on an edge that are held otherwise than the edge is there."""
    there = {body.name for body in cover.bodies}
    for (n, support), (m, edge) in product(enumerate(scene.case.supports), repeat=2):
        if not (isinstance(support, model.PointSupport) and isinstance(edge, model.EdgeSupport)):
            continue
        if support.body != edge.region.body or support.body not in there:
            continue
        line = shapely.MultiLineString(list(cover.edges_on(edge.region).points))
        if not shapely.dwithin(line, shapely.Point(cover.lattice.to_lattice(support.point)), SAME_PLACE):
            continue
        at = place_text(support.point + scene.case.origin)
        for component, *pair in zip("xy", support.displacement, edge.displacement, strict=True):
            mine, its = (_at_point(displacement, support.point) for displacement in pair)
            if (apart := abs(mine - its)) > limit_of("CONTRADICTION") * max(abs(mine), abs(its)):
                told = {"component": component, "mine": Metres(mine), "its": Metres(its), "point": at}
                yield warning("CONTRADICTION", f"supports.{n}", apart, other=f"supports.{m}", **told)


def _at_point(displacement: model.Component | None, point: Floats) -> float:
    """A displacement (m) at a point (2,) m; nan where it is free."""
    given = displacement(point[None])[0] if callable(displacement) else displacement
    return float("nan") if given is None else float(given)


def _of_growth(scene: Scene) -> Iterator[StepWarning]:
    """Cracks and increments that are short beside the lengths that stress is averaged over.

    Of such a crack the average in shear is not that of its K; where cracks start at kinks, those of such increments
    follow each other within the radius. By a criterion that goes by K the given cracks go on in tension alone.
    """
    growth = scene.case.growth
    if growth is None:
        return
    for crack, body in zip(scene.case.cracks, scene.crack_bodies, strict=True):
        strength = scene.case.bodies[body].strength
        length = None if strength is None or growth.criterion in BY_K else shear_radius(growth, strength)
        share = 0.0 if length is None else length / line_length(crack.points)
        if length is not None and share > limit_of("WIDE_SHEAR") and (crack.tip_at_start or crack.tip_at_end):
            percent = 100.0 * (1.0 - 1.0 / np.sqrt(1.0 + share))
            yield warning("WIDE_SHEAR", crack.surface.words, share, radius=Metres(length), percent=percent)
    at = growth.initiation.at
    if growth.steps > 0 and at not in ("tips", "ends"):
        radius = max(scene.start_radius(n) for n, body in enumerate(scene.case.bodies) if body.strength is not None)
        if growth.increment < limit_of("SHORT_START") * radius:
            increment, size = Metres(growth.increment), radius / growth.increment
            yield warning("SHORT_START", size=size, increment=increment, radius=Metres(radius), at=at)


def unbalanced_loads(scene: Scene, cover: Cover) -> Iterator[StepWarning]:
    """Loads that only points could carry: what supports at points must bear where nothing else holds the scene.

    Weight is left out, unless it balances the others: who holds a heavy body at points means to. Their size is that of
    stress in the rock and that of the others, which it may balance.
    """
    case = scene.case
    if not case.supports or not all(isinstance(support, model.PointSupport) for support in case.supports):
        return
    for held in (True, False):
        loads = [load for load in case.loads if load.held == held]
        in_situ = [load for load in loads if isinstance(load, model.InSituStress)]
        heavy = [load for load in loads if isinstance(load, model.Gravity)]
        rest = [load for load in loads if not isinstance(load, model.InSituStress | model.Gravity)]
        (stress, stress_size), (weight, _), (others, size) = (
            _resultant(case, cover, some) for some in (in_situ, heavy, rest)
        )
        size += stress_size
        left = min(max(np.hypot(x, y), abs(turn)) for x, y, turn in (stress + others, stress + others + weight))
        if left > limit_of("UNBALANCED") * size:
            what = f"{left:.3g} N/m of the loads ({100.0 * left / size:.2g} %)"
            yield warning("UNBALANCED", size=left / size, what=what)


def _resultant(case: model.Case, cover: Cover, loads: Sequence[model.Load]) -> tuple[Floats, float]:
    """Force along x and y and moment over the size of the scene (3,), N/m, of loads; and the sum of their sizes."""
    points, _, forces = point_forces(cover, case.bodies, loads, case.numerics.quadrature)
    nodes = cover.patches.nodes
    moment = cross(points - nodes.mean(axis=0), forces).sum() / np.ptp(nodes, axis=0).max()
    return np.append(forces.sum(axis=0), moment), float(np.hypot(*forces.T).sum())


def free_edges(scene: Scene) -> Iterator[StepWarning]:
    """Edges of outlines, body by body, where nothing takes the traction of the in-situ stress: there it relaxes.

    Holes are openings, whose walls are to give way.
    """
    case = scene.at_start.case
    for body in case.bodies:
        ends = body.rings[0].sides
        places = (ends[:, :1] + gauss(POINTS)[0][:, None] * (ends[:, 1:] - ends[:, :1])).reshape(-1, 2)
        outward = np.repeat(outward_normals(ends[:, 1] - ends[:, 0]), POINTS, axis=0)
        size, left = _left_over(case, body, places, outward)
        lines = [line for interface in case.interfaces if body.name in interface.bodies for line in interface.lines]
        near = shapely.dwithin(
            shapely.MultiLineString(lines), shapely.points(places), SAME_PLACE * scene.lattice.spacing
        )
        left[near] = 0.0
        sides = np.flatnonzero((left > limit_of("FREE_EDGES") * size).reshape(-1, POINTS).any(axis=1))
        names = list(dict.fromkeys(body.rings[0].edge_names[side] for side in sides))
        if names:
            more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
            what = f"edge{'s' if len(names) > 1 else ''} {', '.join(names[:MOST_NAMED])}{more} of body '{body.name}'"
            are = "are" if len(names) > 1 else "is"
            yield warning("FREE_EDGES", f"body '{body.name}'", left.max(), what=what, are=are, stress=1e-6 * left.max())


def _left_over(case: model.Case, body: model.Body, places: Floats, outward: Floats) -> tuple[float, Floats]:
    """The largest traction (Pa) of the in-situ stress at places (n, 2) m of a body, and what (n,) nothing takes of it.

    Held loads act first, alone: either those that act with the stress take it, or all loads do.
    """
    stress, left = np.zeros((2, 2, len(places), 2))  # of scaled, of held loads
    free = np.ones((len(places), 2), dtype=bool)
    side, share = np.arange(len(places)) // POINTS, np.tile(gauss(POINTS)[0], len(places) // POINTS)
    for load in case.loads:
        if isinstance(load, model.InSituStress) and load.body == body.name:
            stress[int(load.held)] += across(InSitu().plus(load, 1.0).at(places), outward)
        elif isinstance(load, model.EdgeLoad) and load.region.body == body.name:
            on = load.region.holds(side, share)
            left[int(load.held), on] -= load.traction_at(places[on], outward[on])
    for support in case.supports:
        if isinstance(support, model.ContactSupport | model.EdgeSupport) and support.region.body == body.name:
            parts = (0.0, 0.0) if isinstance(support, model.ContactSupport) else support.displacement
            free[support.region.holds(side, share)] &= [part is None for part in parts]
    left += stress
    sizes = np.hypot(*np.moveaxis(free * np.stack([*left, left.sum(axis=0)]), -1, 0))
    apart = sizes[:2][stress.any(axis=(1, 2))].max(axis=0, initial=0.0)
    return float(np.hypot(*stress.sum(axis=0).T).max()), np.minimum(apart, sizes[2])


def dry_joints(scene: Scene, cover: Cover) -> Iterator[StepWarning]:
    """Pairs of a dry surface and of a fluid that it meets and that presses there.

    The fluid is in another surface, or on an edge that the dry one ends on.
    """
    fluids = [load for load in scene.case.loads if isinstance(load, FluidLoad)]
    if not fluids:
        return
    surfaces = zip((*cover.cracks, *scene.interfaces), scene.laws, strict=False)
    lines = [(line.name, shapely.LineString(line.points)) for line, law in surfaces if not law.bonded]
    wet: list[tuple[str, FluidLoad, shapely.Geometry]] = []
    for load in fluids:
        if isinstance(load, model.Fluid):
            wet += [(name.words, load, line) for name, line in lines if load.fills(name)]
        else:
            edges = shapely.MultiLineString(list(cover.edges_on(load.region).points))
            wet.append((f"edge {load.region.edge} of body '{load.region.body}'", load, edges))
    given = [load for load in fluids if isinstance(load, model.Fluid)]
    for name, line in lines:
        if any(load.fills(name) for load in given):
            continue
        for words, load, fluid in wet:
            dry = line if isinstance(load, model.Fluid) else line.boundary
            if shapely.dwithin(dry, fluid, ON_LINE) and _presses(scene, load, fluid, dry):
                yield warning("DRY", f"{name.words} at {words}", dry=name.words, fluid=words)


def _presses(scene: Scene, load: FluidLoad, fluid: shapely.Geometry, dry: shapely.Geometry) -> bool:
    """Whether a fluid presses where something dry meets it, beside round-off of what it does elsewhere."""
    if isinstance(load, model.FluidVolume):
        return True
    meeting = shapely.get_coordinates(shapely.shortest_line(fluid, dry))[:1]
    along = shapely.get_coordinates(shapely.segmentize(fluid, 0.1 * fluid.length))
    pressure = np.abs(component_at(load.pressure, scene.lattice.to_metres(np.concatenate([meeting, along]))))
    return bool(pressure[0] > SAME_PLACE * pressure.max())
