"""A step with its errors, on cells that meet the target: solved, held against its companion, refined, in rounds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from crackgrow.accuracy.companion import Errors, Grading, Quantities, coarsened, errors_of, refined, unresolved_shear
from crackgrow.arrays import Floats
from crackgrow.contact.coulomb import OPEN, STICK
from crackgrow.contact.faces import points_at
from crackgrow.cover.tips import Tip
from crackgrow.errors import GeometryError, SolveError
from crackgrow.fracture.stress_intensity import StressIntensity
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.run.evaluation import StepSolution, TipState
from crackgrow.run.increments import LoadState
from crackgrow.run.layout import cells_of
from crackgrow.run.loading import HistorySolver, NextStepSolver
from crackgrow.run.state_values import mean_stress, reactions

MOST_ROUNDS = 5
"""Times that cells are refined for one step."""

TOO_MANY_ROUNDS = f"cells were refined in {MOST_ROUNDS} rounds for it"

MOST_UNKNOWNS = 200_000
"""Cells are not refined where that gives more: some 6 GB with the companion (56 joints: 4.4 GB at 150,000)."""

FAINT = 0.01
"""Errors are parts of the largest value, or where that is smaller of this part of what a free crack would have, whose K
is sigma sqrt(pi a) and whose slip is that strain over its length; of reactions, of all loads."""

PLACES = 65
"""Along each surface, at which jumps are held against each other."""


StepSolver = NextStepSolver | HistorySolver


def solved_to_target(solution: StepSolution, solver: StepSolver) -> StepSolution:
    """The step with its errors, on cells that meet the target, or come as near to it as they can."""
    numerics, before = solution.scene.case.numerics, None
    for n_rounds in range(MOST_ROUNDS + 1):
        errors = _held_against(solution, solver)
        if errors.estimate(numerics.goal) <= numerics.target:
            break
        finer = _finer(solution, solver, errors, before) if n_rounds < MOST_ROUNDS else TOO_MANY_ROUNDS
        if isinstance(finer, str):
            errors = replace(errors, missed=finer)
            break
        before, solution = errors, finer
    return replace(solution, errors=errors)


def _finer(solution: StepSolution, solver: StepSolver, errors: Errors, before: Errors | None) -> StepSolution | str:
    """The step on smaller cells for its errors, and those of the round `before`; or why there is none."""
    numerics, refine = solution.scene.case.numerics, solution.scene.case.numerics.refine
    if before is not None and math.isinf(errors.estimate(numerics.goal)) and math.isinf(before.estimate(numerics.goal)):
        return errors.missed or "the companion mesh does not have it"  # nor on smaller cells
    changes = tuple(_changes(solution))
    wanted = refined(errors, before, numerics.target, numerics.goal, _lines(solution), changes)
    scene = solution.scene.with_grading(wanted)
    try:
        cells, now = cells_of(scene, solution.cracks), solution.cover.lattice.cells
        if cells.equal(now):
            by_hand = any(isinstance(level, int) for level in (refine.tips, refine.kinks, refine.corners))
            return f"cells are as small as {'numerics.refine lets them' if by_hand else 'they can'} be"
        n_dofs = solution.cover.n_dofs * cells.n // now.n
        if n_dofs > MOST_UNKNOWNS:
            return f"smaller cells make some {n_dofs:,} unknowns, and at most {MOST_UNKNOWNS:,} are taken"
        return solver.solve(scene)
    except (GeometryError, SolveError) as error:
        return f"smaller cells are not to be had: {error}"


def _held_against(solution: StepSolution, solver: StepSolver) -> Errors:
    """The errors of a step; not known where its companion has no solution."""
    scene = solution.scene
    here = quantities(solution, solution.factor)
    try:
        on = scene.with_grading(replace(scene.grading, companion=True))
        there, own_factor = solver.companion(on, solution)
    except (GeometryError, SolveError) as error:
        missed = f"the companion mesh has no solution to hold it against: {error}"
        return replace(errors_of(scene.grading, here, None), missed=missed)
    return errors_of(scene.grading, here, quantities(there, own_factor))


def next_grading(solution: StepSolution) -> Grading:
    """The grading that the step after a solution begins with."""
    errors, numerics = solution.errors, solution.scene.case.numerics
    if errors is None:
        return solution.scene.grading
    return coarsened(errors, numerics.target, numerics.goal, _lines(solution), tuple(_changes(solution)))


def _lines(solution: StepSolution) -> list[Floats]:
    """The points (n, 2) m of each crack."""
    return [growing.crack.points for growing in solution.cracks]


def _changes(state: LoadState) -> Iterator[tuple[int, float, float]]:
    """Where the contact status of cracks changes from one point to the next: crack, x and y (m)."""
    faces, lattice, status = state.configuration.faces, state.cover.lattice, state.outcome.points.state
    points = lattice.to_metres(faces.nodes.points)
    for first in np.flatnonzero((status[1:] != status[:-1]) & (faces.surface[1:] == faces.surface[:-1])).tolist():
        crack = int(faces.surface[first])
        if state.cover.surfaces[crack].name.is_crack:
            x, y = (0.5 * (points[first] + points[first + 1])).tolist()
            yield crack, x, y


def quantities(solution: StepSolution, own_factor: float) -> Quantities:
    """What a solution says of all that errors are stated of."""
    tips = solution.tips
    intensities = [tip.intensity for tip in tips]
    wetted = solution.configuration.held.load >= 0
    of_volumes = -solution.outcome.multipliers[wetted]  # pressure times the length
    forces = np.array([*(reaction.force for reaction in reactions(solution)), *((f, 0.0) for f in of_volumes)])
    forces = forces.reshape(-1, 2)
    loads = solution.configuration.loads(solution.level)
    moves = [not _sticks(solution, tip.crack) for tip in solution.cover.tips]
    length = max((float(arc_lengths(line)[-1]) for line in _lines(solution)), default=0.0)
    longest = max((float(np.ptp(surface.edges.s)) for surface in solution.cover.surfaces), default=0.0)
    stress = _stress(solution)
    strain = stress / min(material.young_prime for material in solution.scene.materials)
    return Quantities(
        ends=tuple(solution.cover.tip_ends),
        K=np.array([tip.K if moved else (math.nan,) * 2 for tip, moved in zip(tips, moves, strict=True)]).reshape(
            -1, 2
        ),
        spread=np.array([_spread(solution, *each) for each in zip(solution.cover.tips, intensities, strict=True)]),
        T=np.array([known.T for known in intensities]),
        T_spread=np.array([known.T_spread for known in intensities]),
        unresolved=np.array([_unresolved(solution, *each) for each in zip(solution.cover.tips, tips, strict=True)]),
        kinks=np.array([math.nan if tip.verdict is None else tip.verdict.kink for tip in tips]),
        load_factor=own_factor,
        jumps=_jumps(solution),
        forces=forces,
        small={
            "K": FAINT * stress * math.sqrt(math.pi * 0.5 * length),
            "slip": FAINT * strain * longest * solution.cover.lattice.spacing,
            "reaction": FAINT * float(np.abs(loads).sum() + np.abs(forces).sum()),
        },
    )


def _stress(state: LoadState) -> float:
    """Mean pressure (Pa) on the faces, or the mean stress where that is larger."""
    pressure = np.abs(state.outcome.points.normal)
    return max(float(pressure.mean()) if len(pressure) else 0.0, mean_stress(state))


def _sticks(state: LoadState, crack: int) -> bool:
    """Whether the faces of a crack have never moved: its K is zero, and what cells leave of it tells nothing."""
    mine, outcome = state.configuration.faces.surface == crack, state.outcome
    moved = (outcome.points.state[mine] != STICK) | (outcome.memory.slip[mine] != 0.0)
    return bool(mine.any()) and not moved.any() and not state.scene.laws[crack].elastic


def _spread(state: LoadState, tip: Tip, known: StressIntensity) -> float:
    """What K of a tip says itself that it is off by (Pa sqrt(m))."""
    law = state.scene.laws[tip.crack]
    overlap = 0.0 if law.contact is None or law.elastic else max(-known.K_opening, 0.0)
    return float(np.nan_to_num(math.hypot(known.K_I_spread, known.K_II_spread, overlap)))


def _unresolved(state: LoadState, tip: Tip, known: TipState) -> float:
    """What K_II of a tip may miss before the first contact point (Pa sqrt(m))."""
    law, faces, spacing = state.scene.laws[tip.crack], state.configuration.faces, state.cover.lattice.spacing
    points = np.flatnonzero(faces.surface == tip.crack)
    if law.contact is None or not len(points):
        return 0.0
    away = np.maximum(tip.from_start(faces.s[points]) * spacing, 0.0)
    first, outcome = points[np.argmin(away)], state.outcome.points
    if outcome.state[first] == OPEN:
        return 0.0
    friction = law.contact.worn[0]
    pressure = -float(outcome.normal[first])
    shear = max(abs(float(outcome.tangential[first])) - friction * max(pressure, 0.0), 0.0)
    return unresolved_shear(known.intensity.K_opening, float(away.min()), pressure, shear)


def _jumps(state: LoadState) -> Floats:
    """Opening and slip (n, 2) m, at places that do not depend on the cells."""
    cover, found = state.cover, [np.zeros((0, 2))]
    for index, surface in enumerate(cover.surfaces):
        s = surface.edges.s
        places = s.min() + np.linspace(0.0, 1.0, PLACES) * (s.max() - s.min())
        points = points_at(cover, index, places)
        found.append(np.column_stack(state.configuration.gap_and_slip(state.level, points, state.outcome.u)))
    return np.concatenate(found)
