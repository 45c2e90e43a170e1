"""Warnings of missing loads: free edges that relax the in-situ stress, and dry surfaces that meet a fluid."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case import model
from crackgrow.case.formula import component_at
from crackgrow.cover.cover import Cover
from crackgrow.geometry.tolerance import ON_LINE, SAME_PLACE
from crackgrow.quadrature.rules import gauss
from crackgrow.run.scene import Scene
from crackgrow.run.warning_causes import StepWarning, WarningCause
from crackgrow.solid.in_situ import InSitu
from crackgrow.vectors import across, outward_normals

POINTS = 8
"""Along each side: what is held or loaded over less than an eighth of it may be missed."""

MOST_NAMED = 6
"""Of more edges only the number is told."""


Fluid = model.FluidPressure | model.EdgePressure


def free_edges(scene: Scene) -> Iterator[StepWarning]:
    """Edges of outlines, body by body, where nothing takes the traction of the in-situ stress: there it relaxes.

    Holes are openings, whose walls are to give way.
    """
    case = scene.at_start.case
    for body in case.bodies:
        ends = np.stack([body.outline, np.roll(body.outline, -1, axis=0)], axis=1)
        places = (ends[:, :1] + gauss(POINTS)[0][:, None] * (ends[:, 1:] - ends[:, :1])).reshape(-1, 2)
        outward = np.repeat(outward_normals(ends[:, 1] - ends[:, 0]), POINTS, axis=0)
        size, left = _left_over(case, body, places, outward)
        lines = [line for interface in case.interfaces if body.name in interface.bodies for line in interface.lines]
        near = shapely.dwithin(
            shapely.MultiLineString(lines), shapely.points(places), SAME_PLACE * scene.lattice.spacing
        )
        left[near] = 0.0
        sides = np.flatnonzero((left > WarningCause.FREE_EDGES.limit * size).reshape(-1, POINTS).any(axis=1))
        names = list(dict.fromkeys(body.rings[0].edge_names[side] for side in sides))
        if names:
            more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
            what = f"edge{'s' if len(names) > 1 else ''} {', '.join(names[:MOST_NAMED])}{more} of body '{body.name}'"
            are = "are" if len(names) > 1 else "is"
            yield WarningCause.FREE_EDGES.at(
                f"body '{body.name}'", left.max(), what=what, are=are, stress=1e-6 * left.max()
            )


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
    fluids = [load for load in scene.case.loads if isinstance(load, Fluid)]
    if not fluids:
        return
    surfaces = zip((*cover.cracks, *scene.interfaces), scene.laws, strict=False)
    lines = [(line.name, shapely.LineString(line.points)) for line, law in surfaces if not law.bonded]
    wet: list[tuple[str, Fluid, shapely.Geometry]] = []
    for load in fluids:
        if isinstance(load, model.FluidPressure):
            wet += [(name.words, load, line) for name, line in lines if name.is_of(load.surface)]
        else:
            edges = shapely.MultiLineString(list(cover.edges_on(load.region).points))
            wet.append((f"edge {load.region.edge} of body '{load.region.body}'", load, edges))
    given = [load.surface for load in fluids if isinstance(load, model.FluidPressure)]
    for name, line in lines:
        if any(name.is_of(other) for other in given):
            continue
        for words, load, fluid in wet:
            dry = line if isinstance(load, model.FluidPressure) else line.boundary
            if shapely.dwithin(dry, fluid, ON_LINE) and _presses(scene, load, fluid, dry):
                yield WarningCause.DRY.at(f"{name.words} at {words}", dry=name.words, fluid=words)


def _presses(scene: Scene, load: Fluid, fluid: shapely.Geometry, dry: shapely.Geometry) -> bool:
    """Whether a fluid presses where something dry meets it, beside round-off of what it does elsewhere."""
    meeting = shapely.get_coordinates(shapely.shortest_line(fluid, dry))[:1]
    along = shapely.get_coordinates(shapely.segmentize(fluid, 0.1 * fluid.length))
    pressure = np.abs(component_at(load.pressure, scene.lattice.to_metres(np.concatenate([meeting, along]))))
    return bool(pressure[0] > SAME_PLACE * pressure.max())
