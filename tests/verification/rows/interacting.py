"""Open cracks that interact in an infinite plate: a box cut out of it, whose four edges displace as the plate does."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.special import ellipe, ellipk

from crackgrow.case.model import (
    Body,
    Case,
    ContactNumerics,
    Crack,
    EdgeRegion,
    EdgeSupport,
    Material,
    Numerics,
    Output,
    Ring,
)
from tests.verification.crack_array import CrackArray, StraightCrack, solve_crack_array
from tests.verification.row import Row
from tests.verification.solutions import Solved, solve_case

YOUNG, POISSON = 1e10, 0.25  # Pa, plane strain
HALF_LENGTH = 5e-3  # m
TENSION = 1e6  # Pa
EDGES = ("bottom", "right", "top", "left")
SOLVER = "singular integral equations, tests/verification/crack_array.py"
ERDOGAN = "Erdogan 1962, infinite plate"

Tip = tuple[int, Literal["start", "end"]]


def collinear() -> CrackArray:
    """Cracks at 2 mm < |x| < 12 mm pulled in y."""
    return solve_crack_array(
        [StraightCrack(-7e-3, 0.0, HALF_LENGTH, 0.0), StraightCrack(7e-3, 0.0, HALF_LENGTH, 0.0)], (0.0, TENSION, 0.0)
    )


def collinear_K() -> tuple[float, float]:
    """K_I (Pa sqrt(m)) at the inner and the outer tips of cracks at a < |x| < b (Erdogan 1962; Tada, Paris, Irwin)."""
    a, b = 2e-3, 12e-3
    m = 1.0 - (a / b) ** 2  # k^2
    ratio, root = ellipe(m) / ellipk(m), np.sqrt(b**2 - a**2)
    inner = TENSION * np.sqrt(np.pi / a) * (b**2 * ratio - a**2) / root
    return float(inner), float(TENSION * np.sqrt(np.pi / b) * (b**2 - b**2 * ratio) / root)


def stacked() -> CrackArray:
    """Two parallel cracks, one half length apart, pulled across."""
    return solve_crack_array(
        [StraightCrack(0.0, y, HALF_LENGTH, 0.0) for y in (-0.5 * HALF_LENGTH, 0.5 * HALF_LENGTH)], (0.0, TENSION, 0.0)
    )


def scattered() -> CrackArray:
    """Five cracks at different angles, all of them open."""
    places = ((0.0, 0.0, 5.0, 20.0), (3.0, 7.0, 4.0, -35.0), (-9.0, -2.0, 4.0, 75.0), (9.0, -4.0, 4.0, 105.0),
              (-5.0, 8.0, 4.5, 10.0))  # fmt: skip
    return solve_crack_array(
        [StraightCrack(x * 1e-3, y * 1e-3, a * 1e-3, angle) for x, y, a, angle in places],
        (0.6 * TENSION, TENSION, 0.2 * TENSION),
    )


ARRAYS = {"collinear": collinear, "stacked": stacked, "scattered": scattered}
BOXES = {"collinear": (40.0, 30.0, 0.8), "stacked": (30.0, 30.0, 0.8), "scattered": (40.0, 36.0, 0.8)}
"""Width, height and spacing, mm."""


@cache
def array(name: str) -> CrackArray:
    """The infinite plate."""
    return ARRAYS[name]()


def box(plate: CrackArray, width: float, height: float, spacing: float) -> Case:
    """A box (m) round the origin with the plate's cracks and the plate's displacement along its edges."""
    x, y = 0.5 * width, 0.5 * height
    outline = np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
    displacement = plate.displacement_formulas(YOUNG, POISSON)
    whole = np.array([[0.0, 1.0]])
    return Case(
        name="infinite_plate",
        title="a box of an infinite plate",
        source="",
        plane="strain",
        bodies=(Body("rock", (Ring(outline, EDGES),), Material(YOUNG, POISSON), None),),
        cracks=tuple(
            Crack(f"crack{n}", np.array(crack.ends), True, True, None, "rock") for n, crack in enumerate(plate.cracks)
        ),
        interfaces=(),
        supports=tuple(
            EdgeSupport(EdgeRegion("rock", edge, np.array([side]), whole), displacement)
            for side, edge in enumerate(EDGES)
        ),
        loads=(),
        load_factors=(1.0,),
        growth=None,
        numerics=Numerics(spacing, 2.0, 4, ContactNumerics(None, "mortar", "newton", 1.0)),
        output=Output("none", (), False),
        resolved={},
    )


@cache
def solved(name: str) -> Solved:
    """The box, solved."""
    width, height, spacing = BOXES[name]
    return solve_case(box(array(name), width * 1e-3, height * 1e-3, spacing * 1e-3))
