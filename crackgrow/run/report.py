"""From a solved configuration to what is handed out: the step's result."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache, partial

import numpy as np

from crackgrow.accuracy.companion import BOUND, EXPECTED, Errors
from crackgrow.accuracy.energy_norm import ErrorEstimate, error_estimate
from crackgrow.case.model import CriticalLoad, Fatigue, Subcritical
from crackgrow.case.on_map import on_map
from crackgrow.case.segments import line_length
from crackgrow.case.surface import end_word
from crackgrow.cover.shapes import body_index
from crackgrow.fracture.advance import STARTS, advancing_sites
from crackgrow.fracture.opening import kinked_release
from crackgrow.fracture.singular_stress import SingularStress
from crackgrow.fracture.subcritical import velocities
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.run.checkpoint import RunState
from crackgrow.run.clock import SPENT
from crackgrow.run.evaluation import InterfaceTipState, StepSolution
from crackgrow.run.frame import make_frame
from crackgrow.run.growth import Advances
from crackgrow.run.result import (
    CrackFaces,
    Event,
    Frame,
    FrameOnDemand,
    InterfaceTipResult,
    StartResult,
    StepResult,
    TipResult,
)
from crackgrow.run.state_values import history, history_of, mean_stress, reactions, specimen_means
from crackgrow.run.step_warnings import STILL, contact_violations, pressed_strain, step_warnings

Estimate = Callable[[], ErrorEstimate]


def step_result(state: RunState, solution: StepSolution, advances: Advances, with_frame: bool) -> StepResult:
    """The result of a step, after which its tips advance."""
    started = time.perf_counter()
    outcome, scene, paths = solution.outcome, solution.scene, state.paths
    contact, faces = solution.along_surfaces
    unknown, missed = (math.nan,) * len(solution.tips), contact_violations(solution, faces)
    errors = solution.errors or Errors(scene.grading, K=unknown, T=unknown, kinks=unknown)  # cells are by hand
    percent = {goal: 100.0 * BOUND * share for goal, share in errors.shares.items()}
    name, moved = np.array(contact.crack), np.hypot(contact.mean_opening, contact.mean_slip)
    strain = pressed_strain(solution, faces)
    # faces have not moved that have by less than a faint part of what the stress could make them slip
    least = {path.name: STILL * strain * arc_lengths(path.points)[-1] for path in paths if path.name in contact.crack}
    still = {crack for crack, slip in least.items() if moved[name == crack].max() <= slip}
    means = specimen_means(solution)
    critical = isinstance(scene.case.loading, CriticalLoad)
    estimate = cache(estimate_maker(solution))
    asked = estimate if "energy_error" in scene.case.output.fields else None
    return StepResult(
        step=state.step,
        load_factor=solution.factor,
        cracks=paths,
        events=state.events,
        tips=tuple(_tip(solution, tip, tip in advances.sites, errors, still) for tip in range(len(solution.tips))),
        interface_tips=tuple(
            _interface_tip(solution, known, len(solution.configuration.sites) + number in advances.sites)
            for number, known in enumerate(solution.interface_tips)
        ),
        contact=contact,
        faces=faces,
        reactions=reactions(solution),
        mesh=FrameOnDemand(frame_maker(solution, asked)) if with_frame else None,
        n_dofs=solution.cover.n_dofs,
        n_contact=outcome.points.n_unknowns,
        contact_iterations=outcome.points.iterations,
        contact_status=outcome.points.status,
        factorizations=SPENT.n_factorizations if state.factorizations is None else state.factorizations,
        residual=outcome.residual,
        penetration=outcome.penetration,
        complementarity=outcome.complementarity,
        overlap=max((surface.overlap for surface in missed), default=0.0),
        overlap_share=max((surface.share for surface in missed), default=0.0),
        energy=solution.energy,
        load_displacement=_load_displacement(solution),
        mean_stress=means[0],
        mean_strain=means[1],
        crack_length=sum(float(arc_lengths(path.points)[-1]) for path in paths),
        step_warnings=step_warnings(solution, faces, missed, state.step),
        norm_error=estimate().relative if state.step == 0 else math.nan,
        time=state.time if isinstance(scene.case.rate_law, Subcritical) else math.nan,
        cycles=state.time if isinstance(scene.case.rate_law, Fatigue) else math.nan,
        goal_error=percent.get(scene.case.numerics.goal, math.nan),  # those of K are of tips
        slip_error=percent.get("slip", math.nan),
        reaction_error=percent.get("reaction", math.nan),
        load_factor_error=percent.get("load_factor", math.nan) if critical else math.nan,
        stress=_stress(solution, faces),
        history=history([*solution.passed, *history_of(solution)]),
        start=_start(solution),
        emissions=(
            *(replace(event, step=state.step) for event in solution.course.values()),
            *_growing(state.step, solution, advances),
        ),
        seconds={**SPENT.seconds, "output": time.perf_counter() - started},  # the last: all that is above counts
    )


def _interface_tip(solution: StepSolution, known: InterfaceTipState, advances: bool) -> InterfaceTipResult:
    """The row of a tip of a cracked interface."""
    lattice, tip, release = solution.cover.lattice, known.tip, known.release
    return InterfaceTipResult(
        crack=str(solution.cover.surfaces[tip.surface].name),
        tip=end_word(tip.at_end),
        point=lattice.to_metres(tip.point),
        G=release.G,
        G_spread=release.G_spread,
        K=release.K,
        G_radius=tip.radius * lattice.spacing,
        cell_size=tip.size * lattice.spacing,
        length=line_length(solution.cover.surfaces[tip.surface].line.points) * lattice.spacing,
        criticality=known.criticality,
        advanced=advances,
    )


def estimate_maker(solution: StepSolution) -> Estimate:
    """Makes the estimate of a solution, of which it keeps what that takes and no more."""
    singular = [SingularStress(solution.cover, number, tip.K) for number, tip in enumerate(solution.tips)]
    return partial(error_estimate, solution.cover, solution.materials, solution.outcome.u, singular)


def frame_maker(solution: StepSolution, error: Estimate | None) -> Callable[[], Frame]:
    """Makes the mesh of a solution, on the map, and keeps what that takes and no more; with its error if asked for."""
    cover, materials, u = solution.cover, solution.materials, solution.outcome.u
    scene, origin = solution.scene, solution.scene.case.origin
    numbers = np.array([body_index(scene.at_start.case.bodies, body.name) for body in scene.case.bodies])

    def made() -> Frame:
        frame = make_frame(cover, materials, u, None if error is None else error())
        return on_map(replace(frame, body=numbers[frame.body]), origin)

    return made


def _stress(solution: StepSolution, faces: Sequence[CrackFaces]) -> float:
    """The largest pressure (Pa) on the faces of cracks, or the mean stress where that is larger.

    The energy does not hold the stress in the ground, which presses on cracks that stick at no displacement.
    """
    cracks = (face for surface, face in zip(solution.cover.surfaces, faces, strict=True) if surface.name.is_crack)
    pressure = max((float(np.abs(face.normal_traction).max(initial=0.0)) for face in cracks), default=0.0)
    return max(pressure, mean_stress(solution))


def _load_displacement(solution: StepSolution) -> float:
    """Mean displacement (m) along the loads that are scaled, or the prescribed ones where there are no such loads.

    The loads on the physical patches add up to those on the rock, since their functions add up to one.
    """
    on_patches = solution.configuration.scaled[: 2 * len(solution.cover.patches.nodes)]
    total = float(np.abs(on_patches).sum())
    if total > 0.0:
        return float(solution.conjugates[0]) / total
    return solution.configuration.farthest(solution.level)


def _tip(solution: StepSolution, tip: int, advances: bool, errors: Errors, still: set[str]) -> TipResult:
    cover, state, law = solution.cover, solution.tips[tip], solution.scene.case.rate_law
    index, at_end = cover.tip_ends[tip]
    K, verdict, crack, nan = state.intensity, state.verdict, str(cover.cracks[index].name), math.nan
    in_cycles, speed = isinstance(law, Fatigue), nan
    if law is not None and verdict is not None:
        speed = float(velocities(np.array([state.K_range if in_cycles else verdict.criticality]), law)[0])
    return TipResult(
        crack=crack,
        tip=end_word(at_end),
        point=cover.lattice.to_metres(cover.tips[tip].point),
        K_I=K.K_I,
        K_II=K.K_II,
        sigma_1=verdict.sigma_1 if verdict else nan,
        sigma_3=verdict.sigma_3 if verdict else nan,
        criterion="none" if verdict is None else verdict.mode if advances else verdict.branch,
        criticality=verdict.criticality if verdict else nan,
        kink_deg=float(np.rad2deg(verdict.kink)) if verdict else nan,
        advanced=advances,
        K_I_error=BOUND * errors.K[tip],
        K_II_error=BOUND * errors.K[tip],
        K_radius=K.radius,
        K_note=K.note,
        K_I_faces=state.K_faces[0],
        K_II_faces=state.K_faces[1],
        K_I_spread=K.K_I_spread,
        K_II_spread=K.K_II_spread,
        cell_size=cover.tips[tip].size * cover.lattice.spacing,
        kink_error_deg=float(np.rad2deg(min(BOUND * errors.kinks[tip], np.pi))),
        velocity=nan if in_cycles else speed,
        K_error_expected=errors.K[tip] / EXPECTED,
        sticks=crack in still,
        K_growth=nan if crack in still else state.K_growth,
        T=K.T,
        T_error=BOUND * errors.T[tip],
        K_range=state.K_range,
        growth_per_cycle=speed if in_cycles else nan,
    )


def _growing(step: int, solution: StepSolution, advances: Advances) -> Iterator[Event]:
    """The tips that grow, each with the energy that K says is released along its advance."""
    cover, scene = solution.cover, solution.scene
    for tip in sorted(set(advances.sites.tolist()) & set(range(len(solution.tips)))):
        state, (index, at_end) = solution.tips[tip], cover.tip_ends[tip]
        assert state.verdict is not None  # it was chosen by it
        material = solution.materials[scene.crack_bodies[index]].turned(cover.tips[tip].rotation)
        length = advances.lengths.get((index, at_end), scene.growth.increment)
        energy = length * kinked_release(state.K, state.verdict.kink, material)
        place, name = cover.lattice.to_metres(cover.tips[tip].point), str(cover.cracks[index].name)
        yield Event(step, "growth", name, end_word(at_end), place, "", solution.factor, energy)
    for number, known in enumerate(solution.interface_tips):
        if len(solution.configuration.sites) + number in advances.sites:
            place, name = cover.lattice.to_metres(known.tip.point), str(cover.surfaces[known.tip.surface].name)
            energy, end = scene.growth.increment * known.release.G, end_word(known.tip.at_end)
            yield Event(step, "growth", name, end, place, "", solution.factor, energy)


def _start(solution: StepSolution) -> StartResult | None:
    """The start that is the most critical; of equally critical ones that which would be chosen."""
    criticality = np.array([start.verdict.criticality for start in solution.starts])
    largest = criticality.max(initial=0.0)
    if largest <= 0.0:
        return None
    places = np.array([start.site.point for start in solution.starts])
    first = advancing_sites(criticality / largest, np.full(len(places), STARTS), places, "most_critical")[0]
    most = solution.starts[first]
    return StartResult(solution.cover.lattice.to_metres(most.site.point), most.verdict.mode, most.verdict.criticality)
