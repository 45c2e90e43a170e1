"""How far compression30 is from its references: benchmarks of speed that say what was reached in that time."""

from __future__ import annotations

import numpy as np

from crackgrow.run.result import StepResult
from tests.benchmarks.paths import REFERENCES


def K_II_error(result: StepResult) -> float:
    """Largest relative error of |K_II| of step 0 at the tips of the closed crack without friction, rigid contact."""
    table = np.genfromtxt(REFERENCES / "closed_crack_K.csv", delimiter=",", names=True)
    (row,) = table[(table["friction"] == 0.0) & np.isinf(table["stiffness_N_per_m3"])]
    return max(abs(abs(tip.K_II) / (1e6 * float(row["K_II_abs_MPa_sqrtm"])) - 1.0) for tip in result.tips)


def path_deviation_mm(result: StepResult) -> float:
    """Largest distance in x (mm) of the right wing from that of the reference, for y from 5 to 22 mm."""
    path = result.cracks[0]
    wing = 1e3 * path.points[np.flatnonzero(path.steps == 0)[-1] :]
    table = np.genfromtxt(REFERENCES / "wing_path_theta30.csv", delimiter=",", names=True)
    inside = (table["y_mm"] >= 5.0) & (table["y_mm"] <= 22.0)
    x = np.interp(table["y_mm"][inside], wing[:, 1], wing[:, 0])
    return float(np.abs(x - table["x_mm_LS_inc05"][inside]).max())
