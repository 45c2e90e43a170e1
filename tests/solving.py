"""One configuration of the cracks solved, without the loop over the steps."""

from __future__ import annotations

from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import assemble
from crackgrow.run.increments import increment, unloaded
from crackgrow.run.judging import StepSolution, judged
from crackgrow.run.scene import Scene


def solve_step(scene: Scene, growing: tuple[GrowingCrack, ...], load_factor: float) -> StepSolution:
    """Solve one configuration, loaded in one increment. Raises GeometryError or SolveError where that can't be done."""
    configuration = assemble(scene, growing)
    return judged(increment(configuration, unloaded(configuration), load_factor))
