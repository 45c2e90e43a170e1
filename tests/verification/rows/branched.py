"""A branched crack among a kinked and a straight one, all open: K beside that of a fine lattice."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial

import numpy as np

from crackgrow.case import load_case
from crackgrow.case.model import Case, Crack
from tests.verification.row import Row
from tests.verification.solutions import CASES, Solved, solve_case, table

NEIGHBOURS = {"kinked": ((3, 13), (11, 11), (16, 15)), "straight": ((16, -12), (22, -4))}
"""Corners, mm. The kink turns by 59 degrees; the cracks lie 5 to 10 mm from the tips of the branches."""
PER_MM = 1e6 * np.sqrt(1e-3)  # Pa sqrt(m) of 1 MPa sqrt(mm)
REFERENCE = "branched_crack_K.csv"
"""K in MPa sqrt(mm) by `K_of` with three spacings; a slow test in test_branched_crack.py computes it again."""
CASE = "junction_static with a kinked and a straight crack beside its branches"


def branched(spacing: float) -> Case:
    """The case with its neighbours and a spacing (mm)."""
    case = load_case(CASES / "junction_static.yaml", [f"numerics.spacing={spacing}"])
    more = (Crack(name, 1e-3 * np.array(path), True, True, None, "rock") for name, path in NEIGHBOURS.items())
    return replace(case, cracks=(*case.cracks, *more))


@cache
def solved(spacing: float) -> Solved:
    """The case with a spacing (mm), solved."""
    return solve_case(branched(spacing))


def K_of(spacing: float) -> dict[tuple[str, str], tuple[float, float]]:
    """K_I and K_II (MPa sqrt(mm)) by crack and end."""
    return {(tip.crack, tip.tip): (tip.K_I / PER_MM, tip.K_II / PER_MM) for tip in solved(spacing).result.tips}


def reference(spacing: float) -> dict[tuple[str, str], tuple[float, float]]:
    """The same from the table, for one of its spacings (mm)."""
    rows = table(REFERENCE)
    rows = rows[rows["spacing_mm"] == spacing]
    return {(str(row["crack"]), str(row["tip"])): (float(row["K_I"]), float(row["K_II"])) for row in rows}


def difference(
    K: dict[tuple[str, str], tuple[float, float]], wanted: dict[tuple[str, str], tuple[float, float]]
) -> float:
    """Largest difference of K_I and K_II at all tips over the largest K."""
    assert K.keys() == wanted.keys()
    return max(float(np.abs(np.subtract(K[tip], wanted[tip])).max()) for tip in wanted) / float(
        np.abs(list(wanted.values())).max()
    )


def difference_from_finest(spacing: float) -> float:
    """Largest difference from the finest solution of the table."""
    return difference(K_of(spacing), reference(FINEST))


FINEST = 0.375
"""mm; `difference` between it and 0.5 mm, and the one extrapolated from both, is below 2e-4."""


def _rows() -> Iterator[Row]:
    for spacing, tolerance in ((1.5, 5e-3), (2.0, 2e-2)):
        ratio = 8.0 / spacing
        quantity = f"K_I and K_II over the largest K, branches of {ratio:.3g} h: largest difference"
        value = partial(difference_from_finest, spacing)
        yield Row(
            CASE, quantity, 0.0, "itself", f"references/{REFERENCE}, h = {FINEST:g} mm", tolerance, value, "at most"
        )


ROWS = [*_rows()]
