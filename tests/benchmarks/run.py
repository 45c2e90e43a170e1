"""Speed and accuracy of compression30 over the lattice spacing: prints a table and appends it to history.csv.

Every row is measured in one process: the median step of a growth run by phase, and as a floor the bare factorization
and one solve of the same stiffness matrix. Ratios to the floor hold on a noisy machine where seconds don't.
"""

from __future__ import annotations

import csv
import platform
import time
from pathlib import Path

import numpy as np
from scipy.sparse import eye_array

from crackgrow import __version__
from crackgrow.case import load_case
from crackgrow.contact.faces import points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run import grow
from crackgrow.run.result import StepResult
from crackgrow.run.scene import make_scene
from crackgrow.run.step import solve_step
from crackgrow.solid.linear_solver import Factorization
from crackgrow.solid.stiffness import stiffness

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
REFERENCES = HERE.parent / "verification" / "references"
PHASES = ("cover", "assembly", "factorize", "contact", "criterion")
SLIP_AT_MIDDLE = 86.086e-6  # m, closed_crack_K.csv, rigid, frictionless


def growth_run(spacing: float) -> tuple[list[StepResult], np.ndarray]:
    """All steps of compression30 at a spacing (mm), and the right wing (n, 2) in mm."""
    settings = [f"numerics.spacing={spacing}", "output.frames=none", "output.figures=false"]
    results = list(grow(load_case(ROOT / "cases" / "compression30.yaml", settings)))
    path = results[-1].cracks[0]
    return results, path.points[np.flatnonzero(path.steps == 0)[-1] :] * 1e3


def first_step(spacing: float) -> tuple[float, float]:
    """Error of the slip at the flaw's middle, and the floor: seconds to factorize its stiffness and solve once."""
    case = load_case(ROOT / "cases" / "compression30.yaml", [f"numerics.spacing={spacing}"])
    scene = make_scene(case)
    solution = solve_step(scene, (GrowingCrack(case.cracks[0], np.zeros(2, dtype=np.int64)),), 1.0)
    middle = points_at(solution.cover, 0, np.array([5e-3 / scene.lattice.spacing]))
    slip = abs(float(gap_and_slip(solution.cover, middle, solution.outcome.u)[1][0]))
    matrix = stiffness(solution.cover, scene.materials, case.numerics.quadrature)
    matrix = matrix + 1e-6 * abs(matrix).max() * eye_array(matrix.shape[0], format="csc")  # the rigid modes held
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        Factorization(matrix).solve(np.ones(matrix.shape[0]))
        seconds.append(time.perf_counter() - start)
    return slip / SLIP_AT_MIDDLE - 1.0, float(np.median(seconds))


def path_deviation(wing: np.ndarray) -> float:
    """Largest distance in x (mm) from the reference wing for y from 5 to 22 mm."""
    table = np.genfromtxt(REFERENCES / "wing_path_theta30.csv", delimiter=",", names=True)
    inside = (table["y_mm"] >= 5.0) & (table["y_mm"] <= 22.0)
    x = np.interp(table["y_mm"][inside], wing[:, 1], wing[:, 0])
    return float(np.abs(x - table["x_mm_LS_inc05"][inside]).max())


def main() -> None:
    """Measure, print, and append to history.csv."""
    rows = []
    for spacing in (3.0, 1.5, 0.75):
        results, wing = growth_run(spacing)
        error, floor = first_step(spacing)
        phases = {phase: float(np.median([result.seconds[phase] for result in results])) for phase in PHASES}
        step = sum(phases.values())
        row = {
            "version": __version__,
            "python": platform.python_version(),
            "spacing_mm": spacing,
            "n_dofs": results[0].n_dofs,
            "slip_error_percent": round(100.0 * error, 3),
            "path_deviation_mm": round(path_deviation(wing), 3),
            "step_seconds": round(step, 4),
            "floor_seconds": round(floor, 4),
            "ratio_to_floor": round(step / floor, 2),
            **{f"{phase}_seconds": round(seconds, 4) for phase, seconds in phases.items()},
        }
        rows.append(row)
        print("  ".join(f"{key}={value}" for key, value in row.items() if key not in ("version", "python")))
    history = HERE / "history.csv"
    new = not history.exists()
    with history.open("a", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        if new:
            writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
