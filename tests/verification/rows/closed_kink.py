"""A closed, kinked crack: K at the tips of its wings, which stay closed, by the number of spacings a wing is long."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from tests.verification.row import Row
from tests.verification.solutions import Solved, solved_text, table

REFERENCE = "closed_kink_K.csv"
WING = 10.0  # mm
FLAW = 20.0  # mm, half length
FRICTION, AXIAL, LATERAL = 0.3, 10.0, 4.0  # MPa
K_FLAW = 1e6 * (0.5 * (AXIAL - LATERAL) - 0.5 * FRICTION * (AXIAL + LATERAL)) * np.sqrt(np.pi * FLAW * 1e-3)
"""Pa sqrt(m): K_II of the flaw without its wings in an infinite plate, at 45 degrees to the load."""


def corners(turn: float, wing: float = WING) -> list[list[float]]:
    """The crack, mm: flaw at 45 degrees, wings turned on by `turn` degrees."""
    flaw, along = np.deg2rad([45.0, 45.0 + turn])
    kink = FLAW * np.array([np.cos(flaw), np.sin(flaw)])
    tip = kink + wing * np.array([np.cos(along), np.sin(along)])
    return np.round([-tip, -kink, kink, tip], 5).tolist()


def scene(turn: float, spacing: float) -> str:
    """The case with a spacing, mm."""
    sides = (("left", LATERAL, 0.0), ("right", -LATERAL, 0.0), ("top", 0.0, -AXIAL), ("bottom", 0.0, AXIAL))
    loads = "\n".join(f"  - {{on: {{body: rock, edge: {edge}}}, traction: [{x}, {y}]}}" for edge, x, y in sides)
    return f"""
title: closed kinked crack
units: {{length: mm, stress: MPa}}
plane: strain
bodies:
  rock:
    shape: {{rectangle: {{center: [0, 0], width: 200, height: 200}}}}
    material: {{young: 20000, poisson: 0.25}}
cracks: {{flaw: {{path: {{points: {corners(turn)}}}, contact: {{friction: {FRICTION}, cohesion: 0}}}}}}
supports:
  - {{at: [-100, -100], displacement: {{x: 0, y: 0}}}}
  - {{at: [100, -100], displacement: {{y: 0}}}}
loads:
{loads}
numerics: {{spacing: {spacing}}}
"""


def kinked(turn: float, spacings: float) -> Solved:
    """The case with wings of so many spacings, solved."""
    return solved_text(scene(turn, WING / spacings))


def K_of(turn: float, spacings: float) -> tuple[float, float]:
    """K_I and K_II (Pa sqrt(m)) at the start, of wings of so many spacings."""
    return kinked(turn, spacings).tip("start")


def expected(turn: float) -> tuple[float, float]:
    """K_I and K_II (Pa sqrt(m)) of the table."""
    row = next(row for row in table(REFERENCE) if row["turn_deg"] == turn)
    return 1e6 * float(row["K_I_MPa_sqrtm"]), 1e6 * float(row["K_II_MPa_sqrtm"])


def error(turn: float, spacings: float) -> float:
    """Largest error of K_I and K_II over the flaw's K."""
    return float(np.abs(np.subtract(K_of(turn, spacings), expected(turn))).max()) / K_FLAW


def _rows() -> Iterator[Row]:
    for turn in (30.0, 45.0, 60.0):
        for spacings, tolerance in ((2.0, 0.1), (5.0, 0.02)):
            quantity = f"K_I and K_II over the flaw's K, turn of {turn:g} degrees, wing of {spacings:g} h: error"
            value = partial(error, turn, spacings)
            yield Row("closed kinked crack", quantity, 0.0, "independent code", REFERENCE, tolerance, value, "at most")


ROWS = [*_rows()]
