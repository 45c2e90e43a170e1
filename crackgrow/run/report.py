"""From a solved configuration to what is handed out: the step's result."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.toughness import averaging_radius, toughness_of
from crackgrow.contact.cell_lengths import cell_lengths
from crackgrow.contact.coulomb import OPEN
from crackgrow.contact.faces import FacePoints, joined, points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.contact.tractions import between_contact_points, nearest_contact_point
from crackgrow.cover.cover import Cover
from crackgrow.estimate.error_estimate import ErrorEstimate
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.run.cautions import cautions, largest_overlap, overlap_shares
from crackgrow.run.checkpoint import RunState
from crackgrow.run.error import estimate_with, estimated_error
from crackgrow.run.frame import make_frame
from crackgrow.run.history import history
from crackgrow.run.intensity_error import intensity_errors
from crackgrow.run.judging import StepSolution
from crackgrow.run.reactions import reactions
from crackgrow.run.result import (
    ContactPoints,
    CrackFaces,
    CrackPath,
    Frame,
    FrameOnDemand,
    StepResult,
    TipResult,
)
from crackgrow.run.scene import Scene
from crackgrow.solid.elasticity import PlaneElasticity


def paths_of(cracks: tuple[GrowingCrack, ...]) -> tuple[CrackPath, ...]:
    """The cracks as they lie."""
    return tuple(CrackPath(g.crack.name, g.crack.points, g.steps) for g in cracks)


def step_result(state: RunState, solution: StepSolution, chosen: Ints, with_frame: bool) -> StepResult:
    """The result of a step, of whose tips the `chosen` advance."""
    started = time.perf_counter()
    outcome, scene, paths = solution.outcome, solution.configuration.scene, paths_of(state.cracks)
    contact, faces = _along_surfaces(solution, scene)
    errors = intensity_errors(scene, solution, faces)
    tips = tuple(_tip(solution, tip, tip in chosen, scene, error) for tip, error in enumerate(errors))
    shares = overlap_shares(scene, solution, faces)
    error = estimated_error(solution) if state.step == 0 else None
    K = [tip.K for tip in solution.tips]
    make = partial(_frame, solution.cover, solution.materials, outcome.u, K, error)
    return StepResult(
        step=state.step,
        load_factor=solution.state.factor,
        cracks=paths,
        events=state.events,
        tips=tips,
        contact=contact,
        faces=faces,
        reactions=reactions(solution.state),
        mesh=FrameOnDemand(make) if with_frame else None,
        n_dofs=solution.cover.n_dofs,
        n_contact=outcome.n_unknowns,
        contact_iterations=outcome.iterations,
        contact_status=outcome.status,
        factorizations=solution.factorizations,
        residual=solution.residual,
        penetration=outcome.penetration,
        complementarity=outcome.complementarity,
        overlap=largest_overlap(scene, faces),
        overlap_share=max(shares, default=0.0),
        energy=solution.state.energy,
        load_displacement=_load_displacement(solution),
        crack_length=sum(float(arc_lengths(path.points)[-1]) for path in paths),
        effective_toughness=_toughness(scene),
        cautions=cautions(scene, solution, faces, shares, state.step),
        norm_error=error.relative if error else float("nan"),
        history=history([*solution.passed, solution.state]),
        seconds={**solution.seconds, "output": time.perf_counter() - started},  # the last: all that is above counts
    )


def _frame(
    cover: Cover,
    materials: Sequence[PlaneElasticity],
    u: Floats,
    K: Sequence[tuple[float, float]],
    error: ErrorEstimate | None,
) -> Frame:
    """The mesh of a solution, its error estimated if it is not known."""
    return make_frame(cover, materials, u, estimate_with(cover, materials, u, K) if error is None else error)


def _load_displacement(solution: StepSolution) -> float:
    """Mean displacement (m) along the loads that are scaled, or the prescribed ones where there are no such loads.

    The loads on the physical patches add up to those on the rock, since their functions add up to one.
    """
    on_patches = solution.configuration.scaled[: 2 * len(solution.cover.patch_nodes)]
    total = float(np.abs(on_patches).sum())
    if total > 0.0:
        return float(solution.state.conjugates[0]) / total
    return solution.state.factor * float(np.abs(solution.held.given).max(initial=0.0))


def _tip(solution: StepSolution, tip: int, advances: bool, scene: Scene, K_error: tuple[float, float]) -> TipResult:
    cover, state = solution.cover, solution.tips[tip]
    index, at_end = cover.tip_ends[tip]
    verdict = state.verdict
    nan = float("nan")
    return TipResult(
        crack=cover.cracks[index].name,
        tip="end" if at_end else "start",
        point=scene.lattice.to_metres(cover.tips[tip].point),
        K_I=state.intensity.K_I,
        K_II=state.intensity.K_II,
        sigma_1=verdict.sigma_1 if verdict else nan,
        sigma_3=verdict.sigma_3 if verdict else nan,
        criterion="none" if verdict is None else verdict.mode if advances else verdict.branch,
        criticality=verdict.criticality if verdict else nan,
        kink_deg=float(np.rad2deg(verdict.kink)) if verdict else nan,
        advanced=advances,
        K_I_error=K_error[0],
        K_II_error=K_error[1],
        K_radius=state.intensity.radius,
        K_note=state.intensity.note,
        K_I_faces=state.K_faces[0],
        K_II_faces=state.K_faces[1],
        K_I_spread=state.intensity.K_I_spread,
        K_II_spread=state.intensity.K_II_spread,
        cell_size=cover.tips[tip].size * scene.lattice.spacing,
    )


def _along_surfaces(solution: StepSolution, scene: Scene) -> tuple[ContactPoints, tuple[CrackFaces, ...]]:
    """Contact points and samples of all surfaces; opening and slip are the jump of displacement at the points."""
    cover, nodes = solution.cover, solution.faces.nodes
    samples = [_samples(solution, index) for index in range(len(cover.surfaces))]
    jumps = np.stack(gap_and_slip(cover, joined([nodes, *samples]), solution.outcome.u))
    at_nodes, *along = np.split(jumps, np.cumsum([len(part.s) for part in (nodes, *samples)])[:-1], axis=1)
    faces = [_faces(solution, scene, *each) for each in zip(range(len(samples)), samples, along, strict=True)]
    return _contact(solution, scene, at_nodes), tuple(faces)


def _contact(solution: StepSolution, scene: Scene, jump: Floats) -> ContactPoints:
    """Tractions and states as solved, with the `jump` (2, n) m at the points."""
    faces, outcome = solution.faces, solution.outcome
    return ContactPoints(
        crack=tuple(solution.cover.surfaces[index].name for index in faces.surface.tolist()),
        s=faces.s * scene.lattice.spacing,
        points=scene.lattice.to_metres(faces.nodes.points),
        normal_traction=outcome.normal_traction,
        tangential_traction=outcome.tangential_traction,
        opening=jump[0],
        slip=jump[1],
        state=outcome.state,
        mean_opening=outcome.gap,
        mean_slip=outcome.slip,
    )


def _samples(solution: StepSolution, index: int) -> FacePoints:
    """The ends of all edges of a surface and its contact points, each place once."""
    cover, faces = solution.cover, solution.faces
    places = np.sort(np.concatenate([cover.surfaces[index].edges.s.ravel(), faces.s[faces.surface == index]]))
    return points_at(cover, index, places[np.diff(places, prepend=-np.inf) > SAME_PLACE])


def _faces(solution: StepSolution, scene: Scene, index: int, samples: FacePoints, jump: Floats) -> CrackFaces:
    """Jump (2, n) m, tractions and state of one surface at its samples."""
    faces, outcome, s = solution.faces, solution.outcome, samples.s
    nearest = nearest_contact_point(faces, index, s)
    normal, tangential = between_contact_points(faces, index, s, outcome.normal_traction, outcome.tangential_traction)
    return CrackFaces(
        crack=solution.cover.surfaces[index].name,
        s=s * scene.lattice.spacing,
        points=scene.lattice.to_metres(samples.points),
        opening=jump[0],
        slip=jump[1],
        normal_traction=normal,
        tangential_traction=tangential,
        state=np.append(outcome.state, OPEN)[nearest],  # the last entry serves the index -1
        cell_size=cell_lengths(solution.cover, index).size(s) * scene.lattice.spacing,
    )


def _toughness(scene: Scene) -> float:
    """Effective toughness of the criterion in the first crack's body, nan without growth."""
    growth = scene.case.growth
    strength = scene.case.bodies[scene.crack_bodies[0]].strength if scene.crack_bodies else None
    if growth is None or strength is None:
        return float("nan")
    return toughness_of(growth.criterion, strength.tension, averaging_radius(growth, strength))
