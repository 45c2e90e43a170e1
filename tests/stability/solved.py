"""A static scene, solved: the cracks as given, under the last load of their case; and how far apart two such are.

All deviations are relative.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.checkpoint import RunState
from crackgrow.run.judging import StepSolution
from crackgrow.run.loading import load
from crackgrow.run.reactions import imbalance
from crackgrow.run.report import step_result
from crackgrow.run.result import StepResult
from crackgrow.run.scene import make_scene
from crackgrow.run.uniqueness import under_its_loads
from tests.solving import displacement_size
from tests.stability.placed import Placement, scaled


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """What a scene gives; numbers are told as they were before it was placed."""

    case: Case
    solution: StepSolution
    result: StepResult
    K: Floats  # (tips, 2) Pa sqrt(m), K_I and K_II
    tip_stress: Floats  # (tips, 2) Pa, averaged principal stresses; nan without growth
    criticality: Floats  # (tips,); nan without growth
    tractions: Floats  # (2, n) Pa, normal and tangential, of the contact points
    jumps: Floats  # (2, n) m, opening and slip there
    energies: Floats  # (3,) J/m, work, strain energy and dissipation
    forces: Floats  # (k,) N/m, sizes of those that supports, foundations and interfaces carry
    load_displacement: float  # m, mean along the loads
    displacement_size: float  # m, of the displacement field
    load_size: float  # N/m, sum of the sizes of the loads


def _told(case: Case, solution: StepSolution, result: StepResult, by: Placement) -> Solved:
    """What a placed scene gives."""
    tips, contact, energy = result.tips, result.contact, result.energy
    flip = np.array([[1.0], [-1.0 if by.mirrors else 1.0]])  # of what goes along faces
    given = solution.configuration.given(solution.state.level)
    forces = np.array([reaction.force for reaction in result.reactions]).reshape(-1, 2)
    return Solved(
        case,
        solution,
        result,
        K=flip.T * np.array([(tip.K_I, tip.K_II) for tip in tips]).reshape(-1, 2) / (by.stress * np.sqrt(by.size)),
        tip_stress=np.array([(tip.sigma_1, tip.sigma_3) for tip in tips]).reshape(-1, 2) / by.stress,
        criticality=np.array([tip.criticality for tip in tips]),
        tractions=flip * np.stack([contact.normal_traction, contact.tangential_traction]) / by.stress,
        jumps=flip * np.stack([contact.opening, contact.slip]) / by.displacement,
        energies=np.array([energy.work, energy.strain, energy.dissipated]) / (by.displacement * by.stress * by.size),
        forces=np.hypot(*forces.T) / (by.stress * by.size),
        load_displacement=result.load_displacement / by.displacement,
        displacement_size=displacement_size(solution.loads, solution.outcome.u, given) / by.displacement,
        load_size=float(np.abs(solution.loads).sum() / (by.stress * by.size)),
    )


def solved(case: Case, placement: Placement | None = None, offset: tuple[float, float] = (0.0, 0.0)) -> Solved:
    """Solve a case that has been placed, on a lattice moved by `offset` spacings.

    Raises CrackgrowError where the program refuses it.
    """
    quiet = replace(under_its_loads(case), output=replace(case.output, frames="none", figures=False))
    growing = tuple(map(GrowingCrack.given, quiet.cracks))
    scene = make_scene(quiet, offset)
    solution = load(scene, growing)
    result = step_result(RunState(0, growing), solution, np.empty(0, dtype=np.int64), False)
    return _told(quiet, solution, result, placement or scaled())


def stress_intensity(found: Solved, plain: Solved) -> float:
    """Largest difference of K_I and K_II, by the largest |K|, or what the contact tractions could make of a spacing."""
    pressure = np.abs(plain.tractions).max(initial=0.0)
    size = max(np.abs(np.nan_to_num(plain.K)).max(initial=0.0), pressure * np.sqrt(plain.case.numerics.spacing))
    return difference(found.K, plain.K, float(size))


def overall(found: Solved, plain: Solved) -> float:
    """Largest difference of K, the displacement along the loads, energies and forces: what no lattice may change."""
    return max(
        stress_intensity(found, plain),
        difference(np.array(found.load_displacement), np.array(plain.load_displacement), plain.displacement_size),
        difference(found.energies, plain.energies, float(np.abs(plain.energies).max())),
        difference(found.forces, plain.forces, float(max(plain.load_size, plain.forces.max(initial=0.0)))),
    )


def everything(found: Solved, plain: Solved) -> float:
    """As `overall`, with tractions and jumps of every contact point, its state, tip stress and criticality."""
    if not np.array_equal(found.result.contact.state, plain.result.contact.state):
        return float("inf")
    return max(
        overall(found, plain),
        difference(found.tractions, plain.tractions, float(np.abs(plain.tractions).max(initial=0.0))),
        difference(found.jumps, plain.jumps, plain.displacement_size),
        difference(found.tip_stress, plain.tip_stress, float(np.abs(plain.tip_stress).max(initial=0.0))),
        difference(found.criticality, plain.criticality, float(np.abs(plain.criticality).max(initial=0.0))),
    )


def balanced(found: Solved) -> float:
    """What loads and reactions leave, the energy balance and the equilibrium residual, whichever is largest."""
    return max(imbalance(found.solution), found.result.energy.error, found.result.residual)


def difference(found: Floats, plain: Floats, size: float) -> float:
    """Largest difference by `size`; infinite where only one of the two has a number, or the shapes are unlike."""
    if found.shape != plain.shape or not np.array_equal(np.isnan(found), np.isnan(plain)):
        return float("inf")
    left = float(np.nan_to_num(np.abs(found - plain)).max(initial=0.0))
    return left / size if size > 0.0 else left
