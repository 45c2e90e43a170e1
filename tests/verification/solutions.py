"""Cases, solved configurations and references for the verification, each case solved once in a process."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.case import load_case
from crackgrow.case.load import read_case
from crackgrow.case.model import Case
from crackgrow.contact.faces import points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.run.checkpoint import RunState, beginning
from crackgrow.run.configuration import Configuration
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.growth import Advances
from crackgrow.run.loop import solved_steps
from crackgrow.run.report import step_result
from crackgrow.run.result import StepResult
from crackgrow.run.scene import Scene, make_scene
from tests.solving import displacement_in, last_factor, solve_step

ROOT = Path(__file__).parents[2]
CASES = ROOT / "cases"
REFERENCES = Path(__file__).parent / "references"

QUIET = ("output.frames=none", "output.figures=false", "output.report=false")


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """A case before growth, solved."""

    case: Case
    scene: Scene
    solution: StepSolution
    result: StepResult

    def tip(self, name: str) -> tuple[float, float]:
        """K_I and K_II (Pa sqrt(m)) at the `start` or the `end` of the only crack, by the interaction integral."""
        tip = next(tip for tip in self.result.tips if tip.tip == name)
        return tip.K_I, tip.K_II

    def displacement(self, points: Floats) -> Floats:
        """Displacement (n, 2) m at points (n, 2) m of a body in one piece."""
        return displacement_in(self.solution, points)

    def jump(self, s: Floats, surface: int = 0) -> tuple[Floats, Floats]:
        """Opening and slip (n,) m at arc lengths s (n,) m of a surface."""
        return jump_of(self.solution.configuration, self.solution.outcome.u, s, surface)

    def tractions(self, s: Floats, surface: int = 0) -> tuple[Floats, Floats]:
        """Normal and shear traction (n,) Pa at arc lengths s (n,) m: sum of N_k p_k, linear between Gauss points."""
        faces, outcome = self.solution.configuration.faces, self.solution.outcome
        mine = faces.points.surface == surface
        places = faces.points.s[mine] * self.scene.lattice.spacing
        tractions = (outcome.points.normal, outcome.points.tangential)
        normal, shear = (np.interp(s, places, (faces.functions.T @ p)[mine]) for p in tractions)
        return normal, shear


@cache
def solved(name: str, *settings: str) -> Solved:
    """The case cases/NAME.yaml with `settings` such as "numerics.spacing=1"."""
    return solve_case(load_case(CASES / f"{name}.yaml", settings))


def case_of(scene: str | Mapping[str, Any], *settings: str, **words: object) -> Case:
    """A case from its text, in which words stand for values, or from a document; without pictures."""
    text = scene if isinstance(scene, str) else json.dumps(scene)
    for word, value in words.items():
        text = text.replace(word, str(value))
    return read_case(text, "scene", "scene", [*QUIET, *settings])


@cache
def solved_text(text: str, *settings: str) -> Solved:
    return solve_case(case_of(text, *settings))


def solve_case(case: Case) -> Solved:
    """Solve a case before growth, on cells that meet its target where the run chooses them."""
    if case.numerics.measured:
        steps = solved_steps(case)
        result, solution = next(steps) if case.growth is not None else [*steps][-1]
        return Solved(case, solution.scene, solution, result)
    scene = make_scene(case)
    growing = beginning(case).cracks
    solution = solve_step(scene, growing, last_factor(case))
    result = step_result(RunState(0, growing), solution, Advances(growing), True)
    return Solved(case, scene, solution, result)


def jump_of(configuration: Configuration, u: Floats, s: Floats, surface: int = 0) -> tuple[Floats, Floats]:
    """Opening and slip (n,) m at arc lengths s (n,) m of a surface under displacements u (n_dofs,)."""
    points = points_at(configuration.cover, surface, s / configuration.scene.lattice.spacing)
    return gap_and_slip(configuration.cover, points, u)


@cache
def table(name: str) -> NDArray[np.void]:
    """A reference table by file name; text columns are text."""
    return np.genfromtxt(REFERENCES / name, delimiter=",", names=True, encoding="utf-8", dtype=None)


def rows(name: str) -> list[dict[str, str]]:
    """The rows of a reference table by file name, as text by columns."""
    with (REFERENCES / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def relative_L2(s: Floats, found: Floats, reference: Floats) -> float:
    """Relative difference in the mean square of two functions sampled at increasing s."""
    return float(np.sqrt(np.trapezoid((found - reference) ** 2, s) / np.trapezoid(reference**2, s)))


def rate(spacings: Sequence[float], errors: Sequence[float]) -> float:
    """Power of the spacing that the errors fall with, by least squares."""
    return float(np.polyfit(np.log(spacings), np.log(errors), 1)[0])
