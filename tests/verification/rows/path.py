"""The path of the right wing of compression30 against a code that remeshes."""

from __future__ import annotations

from functools import cache, partial

import numpy as np

from crackgrow import grow, load_case
from tests.verification.row import Row
from tests.verification.solutions import CASES, Floats, table

QUIET = ("output.frames=none", "output.figures=false")
CODE = "wing_path_theta30.csv, K_II = 0 at steps of 0.5 mm, good to 0.03 mm"


@cache
def right_wing(*settings: str) -> Floats:
    """Vertices (n, 2) mm of what has grown at the end of the flaw, its tip first."""
    for result in grow(load_case(CASES / "compression30.yaml", [*QUIET, *settings])):
        path = result.cracks[0]
    return path.points[np.flatnonzero(path.steps == 0)[-1] :] * 1e3


def deviation(*settings: str) -> float:
    """Largest difference in x (mm) for y from 5 to 22 mm."""
    wing, rows = right_wing(*settings), table("wing_path_theta30.csv")
    inside = (rows["y_mm"] >= 5.0) & (rows["y_mm"] <= 22.0)
    x = np.interp(rows["y_mm"][inside], wing[:, 1], wing[:, 0], right=np.nan)
    return float(np.abs(x - rows["x_mm_LS_inc05"][inside]).max())


IMPLICIT = ("growth.criterion=max_hoop_stress", "growth.direction=implicit")

ROWS = [
    Row(
        "compression30",
        "right wing, y from 5 to 22 mm, directional_strength, steps of 2 mm: distance [mm]",
        0.0,
        "independent code",
        CODE,
        0.25,
        deviation,
        "at most",
    ),
    Row(
        "compression30",
        "right wing, y from 5 to 22 mm, max_hoop_stress, implicit, steps of 2 mm: distance [mm]",
        0.0,
        "independent code",
        CODE,
        0.15,
        partial(deviation, *IMPLICIT),
        "at most",
    ),
    Row(
        "compression30",
        "right wing, y from 5 to 22 mm, the same, both tips at a time: distance [mm]",
        0.0,
        "independent code",
        CODE,
        0.1,
        partial(deviation, *IMPLICIT, "growth.advance=all", "growth.steps=11"),
        "at most",
    ),
]
