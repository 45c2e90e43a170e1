"""Stages of a construction: loads that change each by itself, and rock that is taken out.

A stage is a configuration of its own, of the rock that is left, on the lattice of the whole scene: so the functions of
what is left stay. What a body that is taken out did on it, the forces that bonds, contact and water between the two
carried, goes on acting at first, and falls in proportion to what the stage releases. The strain energy of the body is
released at once.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import FluidPressure
from crackgrow.contact.face_loads import face_load_vector
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.cover.shapes import body_index
from crackgrow.errors import NotSolvedError
from crackgrow.quadrature.elements import element_points
from crackgrow.run.configuration import Configuration, Excavated, assemble
from crackgrow.run.increments import LoadState, Origin, equilibrated
from crackgrow.run.scene import Scene
from crackgrow.run.state_values import face_forces


def next_stage(state: LoadState, origin: Origin, here: Scene) -> tuple[Configuration, Origin]:
    """The configuration of the next stage, whose scene is given, and where it starts from.

    Raises GeometryError or SolveError where it has no state.
    """
    before = state.configuration
    configuration = assemble(here, before.cracks)
    left = {body.name for body in here.case.bodies}
    newly = [body.name for body in before.scene.case.bodies if body.name not in left]
    excavated = (*origin.excavated, *(Excavated(body, _held_by(state, body)) for body in newly))
    if newly:
        same = _same_functions(before.cover, configuration.cover)
        unknowns = (2 * same[:, None] + np.arange(2)).ravel()
        excavated = tuple(replace(rock, forces=rock.forces[unknowns]) for rock in excavated)
    configuration = configuration.with_excavated(excavated)
    return configuration, Origin(start=equilibrated(state, configuration), excavated=excavated)


def _held_by(state: LoadState, body: str) -> Floats:
    """Forces (n_dofs,) N/m of what is between a body and the rest, on all rock: bonds, contact, water."""
    configuration = state.configuration
    scene, cover = configuration.scene, configuration.cover
    forces = np.zeros(cover.n_dofs)
    for index, surface in enumerate(cover.surfaces):
        if surface.name.bounds({body}):
            forces += face_forces(state, index)
    for load in scene.case.loads:
        if isinstance(load, FluidPressure) and load.surface.bounds({body}):
            forces += scene.share(load, state.factor) * face_load_vector(cover, [], [load])
    return forces


def _same_functions(before: Cover, after: Cover) -> Ints:
    """For every function of the rock that is left its number before other rock was taken out.

    Raises NotSolvedError where the functions are others.
    """
    points = element_points(after, 1)
    elements, first = np.unique(points.element, return_index=True)
    numbers = np.array([body_index(before.bodies, body.name) for body in after.bodies])
    there = locate(before.lattice, before.elements, points.points[first], numbers[after.elements.body[elements]])
    same = np.full(after.n_functions, -1, dtype=np.int64)
    if (there >= 0).all():
        mine, theirs = after.functions_on(elements), before.functions_on(there)
        if np.array_equal(mine.counts, theirs.counts):
            same[mine.values] = theirs.values
            if (same >= 0).all() and np.array_equal(same[mine.values], theirs.values):
                return same
    what = "the functions of the rock change where rock is taken out beside it"
    raise NotSolvedError(f"{what}; change numerics.spacing a little")
