"""A static scene, solved: the cracks as given, under the last load of their case."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.checkpoint import RunState
from crackgrow.run.judging import StepSolution
from crackgrow.run.loading import load
from crackgrow.run.report import step_result
from crackgrow.run.result import StepResult
from crackgrow.run.scene import make_scene
from crackgrow.study.invariance.placed import Placement, placed, scaled


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """What a scene gives, and how it has been placed: results are told as they were before."""

    case: Case
    solution: StepSolution
    result: StepResult
    placement: Placement

    @property
    def K(self) -> Floats:
        """K_I and K_II (tips, 2) Pa sqrt(m)."""
        factor = self.placement.stress * np.sqrt(self.placement.size)
        sign = -1.0 if self.placement.mirrors else 1.0
        return np.asarray(np.array([(tip.K_I, sign * tip.K_II) for tip in self.result.tips]).reshape(-1, 2) / factor)

    @property
    def tractions(self) -> Floats:
        """Normal and tangential traction (2, n) Pa of the contact points."""
        contact = self.result.contact
        sign = -1.0 if self.placement.mirrors else 1.0
        return np.stack([contact.normal_traction, sign * contact.tangential_traction]) / self.placement.stress

    @property
    def jumps(self) -> Floats:
        """Opening and slip (2, n) m of the contact points."""
        contact = self.result.contact
        sign = -1.0 if self.placement.mirrors else 1.0
        return np.stack([contact.opening, sign * contact.slip]) / self.placement.displacement

    @property
    def tip_stress(self) -> Floats:
        """Averaged principal stresses (tips, 2) Pa; nan without growth."""
        stresses = [(tip.sigma_1, tip.sigma_3) for tip in self.result.tips]
        return np.array(stresses).reshape(-1, 2) / self.placement.stress

    @property
    def criticality(self) -> Floats:
        """Of every tip (tips,); nan without growth."""
        return np.array([tip.criticality for tip in self.result.tips])

    @property
    def energies(self) -> Floats:
        """Work, strain energy and dissipation (3,) J/m."""
        energy, by = self.result.energy, self.placement
        return np.array([energy.work, energy.strain, energy.dissipated]) / (by.displacement * by.stress * by.size)

    @property
    def load_displacement(self) -> float:
        """Mean displacement (m) along the loads."""
        return self.result.load_displacement / self.placement.displacement

    @property
    def displacement_size(self) -> float:
        """Size (m) of the displacement field."""
        return self.solution.displacement_size / self.placement.displacement

    @property
    def forces(self) -> Floats:
        """Magnitude (k,) N/m of the force that each support, foundation and interface carries."""
        forces = np.array([reaction.force for reaction in self.result.reactions]).reshape(-1, 2)
        return np.asarray(np.hypot(*forces.T) / (self.placement.stress * self.placement.size))

    @property
    def load_size(self) -> float:
        """Sum (N/m) of the magnitudes of the loads."""
        return float(np.abs(self.solution.loads).sum() / (self.placement.stress * self.placement.size))


def solved_placed(case: Case, placement: Placement) -> Solved:
    """Solve a case in another place, size or unit. Raises CrackgrowError where the program refuses it."""
    return solved(placed(case, placement), placement)


def solved(case: Case, placement: Placement | None = None, offset: tuple[float, float] = (0.0, 0.0)) -> Solved:
    """Solve a case that has been placed, on a lattice moved by `offset` spacings.

    Raises CrackgrowError where the program refuses it.
    """
    quiet = replace(case, output=replace(case.output, frames="none", figures=False))
    growing = tuple(map(GrowingCrack.given, quiet.cracks))
    scene = make_scene(quiet, offset)
    solution = load(scene, growing)
    result = step_result(RunState(0, growing), solution, np.empty(0, dtype=np.int64), False)
    return Solved(quiet, solution, result, placement or scaled())
