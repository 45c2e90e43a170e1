"""What a loaded state shows: along its surfaces, at supports and interfaces, in the whole specimen, at output points.

What a testing machine measures are the mean stress and strain of the specimen. With the displacement u and the outward
normal n along the outer outline of the area A,

    mean strain = 1/(2 A) int (u n' + n u') ds,    mean stress = 1/A int sigma dA    (Hill 1963),

so that the opening and slip of cracks are in the strain. Holes are a part of A that bears no stress, whatever presses
on their rims. The functions of the patches hold a linear displacement with the places x of their nodes as coefficients:
with the internal forces f = K u the integral of the stress is the sum of (x f' + f x')/2 over the patches, to which the
in-situ stress comes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.model import ContactSupport, FacePoint, FluidVolume, RockPoint
from crackgrow.contact.coulomb import OPEN
from crackgrow.contact.face_loads import filled_length
from crackgrow.contact.faces import joined, points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.cover.cover import Foundation
from crackgrow.cover.elements import locate
from crackgrow.cover.shapes import CrackGeometry, body_index
from crackgrow.geometry.tolerance import ROUND_OFF, SAME_PLACE
from crackgrow.quadrature.elements import element_points
from crackgrow.quadrature.rims import points_on_outlines
from crackgrow.run.result import ContactPoints, CrackFaces, History, Reaction
from crackgrow.solid.recovery import displacement_at, stress_at
from crackgrow.vectors import outward_normals

if TYPE_CHECKING:
    from crackgrow.run.increments import LoadState

MOST_ROWS = 100
"""Of more states on the way of one load these many are told of, evenly spread: each is a back substitution."""

TOGETHER = 25
"""States whose displacements are solved for together; each costs a tenth of a solve of its own then."""

Components = tuple[float, float, float]
"""xx, yy and xy of a symmetric tensor."""


def along_surfaces(state: LoadState) -> tuple[ContactPoints, tuple[CrackFaces, ...]]:
    """Contact points and samples of all surfaces; opening and slip are the jump of displacement at the points.

    Samples are the ends of all edges and the contact points, each place once.
    """
    configuration, outcome = state.configuration, state.outcome
    cover, faces, points = configuration.cover, configuration.faces, outcome.points
    lattice, samples = cover.lattice, []
    for index, surface in enumerate(cover.surfaces):
        s = np.sort(np.concatenate([surface.edges.s.ravel(), faces.s[faces.surface == index]]))
        samples.append(points_at(cover, index, s[np.diff(s, prepend=-np.inf) > SAME_PLACE]))
    jumps = np.stack(configuration.gap_and_slip(state.level, joined([faces.nodes, *samples]), outcome.u))
    jump, *along = np.split(jumps, np.cumsum([len(part.s) for part in (faces.nodes, *samples)])[:-1], axis=1)
    contact = ContactPoints(
        crack=tuple(str(cover.surfaces[index].name) for index in faces.surface.tolist()),
        s=faces.s * lattice.spacing,
        points=lattice.to_metres(faces.nodes.points),
        normal_traction=points.normal,
        tangential_traction=points.tangential,
        opening=jump[0],
        slip=jump[1],
        state=points.state,
        mean_opening=points.opening,
        mean_slip=points.slip,
    )
    found = []
    for index, (surface, sample, (opening, slip)) in enumerate(zip(cover.surfaces, samples, along, strict=True)):
        normal, tangential = faces.between(index, sample.s, points.normal, points.tangential)
        nearest = faces.nearest(index, sample.s)
        found.append(
            CrackFaces(
                crack=str(surface.name),
                s=sample.s * lattice.spacing,
                points=lattice.to_metres(sample.points),
                opening=opening,
                slip=slip,
                normal_traction=normal,
                tangential_traction=tangential,
                state=np.append(points.state, OPEN)[nearest],  # the last serves -1
                cell_size=surface.in_cells.size(sample.s) * lattice.spacing,
            )
        )
    return contact, tuple(found)


def reactions(state: LoadState) -> tuple[Reaction, ...]:
    """Force of every support and foundation on the rock, and of the second body of an interface on the first.

    Those of rock that is gone are zero.
    """
    at_start = state.scene.at_start
    at, here = (  # excavation takes out loads, but no cracks
        [number for number, load in enumerate(scene.case.loads) if isinstance(load, FluidVolume)]
        for scene in (at_start, state.scene)
    )
    volumes = [(f"loads.{n}", volume_pressure(state, number)) for n, number in zip(at, here, strict=True)]
    return (
        *_of_supports(state),
        *_on_surfaces(state, (*at_start.interfaces, *at_start.foundations)),
        *(Reaction(where, (0.0, 0.0), pressure) for where, pressure in volumes),
    )


def volume_pressure(state: LoadState, number: int) -> float:
    """The pressure (Pa) that the volume of fluid of a load takes: the force that holds it over the length wetted."""
    load, held = state.scene.case.loads[number], state.configuration.held
    assert isinstance(load, FluidVolume)
    return -float(state.outcome.multipliers[held.load == number][0]) / filled_length(state.cover, load)


def _of_supports(state: LoadState) -> Iterator[Reaction]:
    """Forces of supports that prescribe displacements."""
    held, multipliers = state.configuration.held, state.outcome.multipliers
    for number, support in enumerate(state.scene.case.supports):
        if not isinstance(support, ContactSupport):
            of_it = [(held.support == number) & (held.component == axis) for axis in range(2)]
            x, y = (-float(multipliers[mine].sum()) for mine in of_it)
            yield Reaction(f"supports.{number}", (x, y))


def _on_surfaces(state: LoadState, surfaces: Sequence[CrackGeometry | Foundation]) -> Iterator[Reaction]:
    """Forces of interfaces and foundations, each on the body on its plus face; none of those that are gone.

    A force is the sum over the patches' own functions, which add up to one everywhere.
    """
    cover = state.cover
    numbers = {surface.name: index for index, surface in enumerate(cover.surfaces)}
    for name in (surface.name for surface in surfaces):
        x = y = 0.0
        if name in numbers:
            body = cover.elements.body[cover.surfaces[numbers[name]].edges.plus[0]]
            patches = np.unique(cover.patches.of_element.taken(np.flatnonzero(cover.elements.body == body)).values)
            x, y = face_forces(state, numbers[name]).reshape(-1, 2)[patches].sum(axis=0).tolist()
        yield Reaction(str(name), (x, y))


def face_forces(state: LoadState, surface: int) -> Floats:
    """Forces (n_dofs,) N/m of a surface's contact or bond on the rock on both of its sides."""
    held, contact, points = state.configuration.held, state.configuration.contact, state.outcome.points
    mine, here = held.surface == surface, state.configuration.faces.surface == surface
    bond = held.matrix[mine].T @ state.outcome.multipliers[mine]
    normal = contact.gap_of[here].T @ (contact.weights * points.normal)[here]
    tangential = contact.slip_of[here].T @ (contact.weights * points.tangential)[here]
    return np.asarray(-(bond + normal + tangential))


def imbalance(state: LoadState) -> float:
    """What loads and the forces on the whole scene leave, by the sum of their magnitudes.

    Rows of the system can each be in balance to round-off while their sum is not: where a stiff body is held by one
    that is many times softer, and moves that many times further than it strains. Where nothing is stressed, as behind
    faces that have parted, nothing is out of balance.
    """
    external = [*_of_supports(state), *_on_surfaces(state, state.scene.foundations)]
    held, loads = [np.array(reaction.force) for reaction in external], state.configuration.loads(state.level)
    size = float(np.abs(loads).sum() + sum(np.hypot(*force) for force in held))
    total = loads.reshape(-1, 2)[: len(state.cover.patches.nodes)].sum(axis=0)  # patches' functions add up to one
    left = float(np.abs(sum(held, start=total)).max())
    return 0.0 if size <= ROUND_OFF * state.outcome.largest_terms else left / size


def mean_stress(state: LoadState) -> float:
    """Stress (Pa) that would give the softest of the rock, all over, the strain energy that there is."""
    scene = state.scene
    softest, area = min(m.young_prime for m in scene.materials), sum(region.area for region in scene.regions)
    return float(np.sqrt(2.0 * max(state.energy.strain, 0.0) * softest / area))


def specimen_means(state: LoadState) -> tuple[Components, Components]:
    """Mean stress (Pa) and mean strain of the specimen; the shear strain is half the angle."""
    cover, lattice, outlines = state.cover, state.cover.lattice, state.cover.elements.outlines
    whole = shapely.union_all(state.scene.regions)
    outer = shapely.union_all(shapely.polygons(shapely.get_exterior_ring(shapely.get_parts(whole))))
    middle = shapely.points(lattice.to_metres(outlines.points.mean(axis=1)))
    on_rim = shapely.dwithin(outer.boundary, middle, SAME_PLACE * lattice.spacing)
    ends, element = outlines.points[on_rim], outlines.element[on_rim]
    edge, points, length = points_on_outlines(cover, ends, element, outlines.edge[on_rim])
    u = displacement_at(cover, state.outcome.u, points, element[edge])
    normals = outward_normals(ends[:, 1] - ends[:, 0])[edge]
    a, b, c = (_stress_integral(state) / outer.area).tolist()
    d, e, f = (_symmetric((length[:, None] * lattice.spacing * u).T @ normals) / outer.area).tolist()
    return (a, b, c), (d, e, f)


def _stress_integral(state: LoadState) -> Floats:
    """Integral (3,) N of xx, yy and xy of the stress over the specimen."""
    cover, lattice = state.cover, state.cover.lattice
    nodes = lattice.to_metres(cover.patches.nodes)
    forces = (state.configuration.stiffness @ state.outcome.u).reshape(-1, 2)[: len(nodes)]
    total = _symmetric(nodes.T @ forces)
    for region, material in zip(state.scene.regions, state.materials, strict=True):
        total += region.area * np.array(material.initial.uniform)
    if any(material.initial.varying for material in state.materials):
        at = element_points(cover, state.scene.case.numerics.quadrature)
        body, places = cover.elements.body[at.element], lattice.to_metres(at.points)
        for number, material in enumerate(state.materials):
            mine = body == number
            total += lattice.spacing**2 * at.weights[mine] @ material.initial.more_at(places[mine])
    return total


def _symmetric(of: Floats) -> Floats:
    """xx, yy and xy of the symmetric part of a tensor (2, 2)."""
    return np.array([of[0, 0], of[1, 1], 0.5 * (of[0, 1] + of[1, 0])])


def history_of(state: LoadState) -> tuple[LoadState, ...]:
    """The states of an increment that have rows in the history, the last one included; each state is large."""
    if not state.scene.case.output.points:
        return ()
    via = state.via
    if len(via) > MOST_ROWS:
        via = tuple(via[number] for number in np.linspace(0, len(via) - 1, MOST_ROWS).astype(int).tolist())
    return (*via, state)


def history(states: Sequence[LoadState]) -> History | None:
    """What named places, and the reactions, say in some states, in order; None where there are none."""
    if not states:
        return None
    told = [dict(_values(state)) for state in _formed(states)]
    factors = np.array([state.factor for state in states])
    return History(tuple(told[0]), factors, np.array([list(values.values()) for values in told]))


def _formed(states: Sequence[LoadState]) -> Iterator[LoadState]:
    """The states with their displacements: those of one configuration that are not formed yet are solved together."""
    for (_, unformed), some in groupby(states, lambda state: (id(state.configuration), state.formed is None)):
        alike = list(some)
        if not unformed:
            yield from alike
            continue
        configuration = alike[0].configuration
        for first in range(0, len(alike), TOGETHER):
            group = alike[first : first + TOGETHER]
            known = configuration.displacements([(state.level, state.states) for state in group])
            for state, each in zip(group, known, strict=True):
                yield replace(state, formed=configuration.equilibrium(state.level, state.before, state.states, each))


def _values(state: LoadState) -> Iterator[tuple[str, float]]:
    """Columns and their values, SI."""
    for point in state.scene.case.output.points:
        if isinstance(point, RockPoint):
            names: tuple[str, ...] = ("u_x", "u_y", "stress_xx", "stress_yy", "stress_xy")
            values = _at_point(state, point.body, point.point)
        elif isinstance(point, FacePoint):
            names, values = ("opening", "slip"), _jump(state, point)
        else:
            at = [_at_point(state, body, place)[:2] for body, place in zip(point.bodies, point.points, strict=True)]
            before, after = (np.hypot(*(both[1] - both[0])) for both in (point.points, point.points + at))
            names, values = ("convergence",), [before - after]
        yield from ((f"{point.name}.{name}", float(value)) for name, value in zip(names, values, strict=True))
    for reaction in reactions(state):
        if np.isfinite(reaction.pressure):
            yield f"{reaction.where}.pressure", reaction.pressure
            continue
        yield f"{reaction.where}.force_x", reaction.force[0]
        yield f"{reaction.where}.force_y", reaction.force[1]


def _at_point(state: LoadState, body: str, point: Floats) -> list[float]:
    """Displacement (m) and stress (Pa: xx, yy, xy) at a point of a body; nan where no rock is left."""
    scene, cover = state.scene, state.cover
    at = cover.lattice.to_lattice(point[None])
    if body not in (other.name for other in scene.case.bodies):
        return [np.nan] * 5
    element = locate(cover.lattice, cover.elements, at, body_index(scene.case.bodies, body))
    if element[0] < 0:
        return [np.nan] * 5
    u = state.outcome.u
    stress = stress_at(cover, state.materials, u, at, element)[0]
    return [*displacement_at(cover, u, at, element)[0].tolist(), *stress.tolist()]


def _jump(state: LoadState, point: FacePoint) -> list[float]:
    """Opening and slip (m) of the surface at the place nearest to a point; nan where it has been excavated."""
    cover = state.cover
    at = shapely.Point(cover.lattice.to_lattice(point.point))
    lines = {
        index: shapely.LineString(surface.line.points)
        for index, surface in enumerate(cover.surfaces)
        if surface.name.is_of(point.surface)
    }
    if not lines:
        return [np.nan] * 2
    index = min(lines, key=lambda number: float(lines[number].distance(at)))
    s = np.array([shapely.line_locate_point(lines[index], at)])
    return [float(jump[0]) for jump in gap_and_slip(cover, points_at(cover, index, s), state.outcome.u)]
