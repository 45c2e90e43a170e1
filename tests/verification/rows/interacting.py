"""Open cracks that interact in an infinite plate: a box cut out of it, whose four edges displace as the plate does."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
from scipy.special import ellipe, ellipk

from crackgrow.case.model import (
    Body,
    Case,
    ContactNumerics,
    Crack,
    EdgeRegion,
    EdgeSupport,
    LoadHistory,
    Material,
    Numerics,
    Output,
    Ring,
)
from tests.verification.crack_array import CrackArray, StraightCrack, Tip, solve_crack_array
from tests.verification.row import Row
from tests.verification.solutions import Solved, solve_case

YOUNG, POISSON = 1e10, 0.25  # Pa, plane strain
HALF_LENGTH = 5e-3  # m
TENSION = 1e6  # Pa
EDGES = ("bottom", "right", "top", "left")
BOX = "box of an infinite plate, its displacement on all edges"
SOLVER = "singular integral equations, tests/verification/crack_array.py"
ERDOGAN = "Erdogan 1962, infinite plate"
PER_MM = 1e6 * np.sqrt(1e-3)  # Pa sqrt(m) of 1 MPa sqrt(mm)


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
              (-8.0, 7.0, 4.5, 10.0))  # fmt: skip
    return solve_crack_array(
        [StraightCrack(x * 1e-3, y * 1e-3, a * 1e-3, angle) for x, y, a, angle in places],
        (0.6 * TENSION, TENSION, 0.2 * TENSION),
    )


ARRAYS = {"collinear": collinear, "stacked": stacked, "scattered": scattered}
BOXES = {"collinear": (40.0, 30.0), "stacked": (30.0, 30.0), "scattered": (40.0, 36.0)}
"""Width and height, mm."""


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
        loading=LoadHistory((1.0,)),
        growth=None,
        numerics=Numerics(spacing=spacing, support=2.0, quadrature=3, contact=ContactNumerics(spacing=1.0)),
        output=Output("none", (), False),
        resolved={},
    )


@cache
def solved(name: str, spacing: float) -> Solved:
    """The box with a spacing (mm), solved."""
    width, height = BOXES[name]
    return solve_case(box(array(name), width * 1e-3, height * 1e-3, spacing * 1e-3))


def K_of(name: str, spacing: float) -> Iterator[tuple[int, Tip, tuple[float, float]]]:
    """Crack, tip, K_I and K_II (Pa sqrt(m)) of all tips."""
    for tip in solved(name, spacing).result.tips:
        yield int(tip.crack.removeprefix("crack")), tip.tip, (tip.K_I, tip.K_II)


def worst(name: str, spacing: float, mode: int, tips: tuple[tuple[int, Tip], ...], wanted: float) -> float:
    """K_I or abs(K_II) (MPa sqrt(mm)) of the tips that is furthest from the reference."""
    found = [abs(K[mode]) / PER_MM for crack, tip, K in K_of(name, spacing) if (crack, tip) in tips]
    return float(max(found, key=lambda K: abs(K - wanted)))


def largest_difference(name: str, spacing: float) -> float:
    """Largest difference of K_I and K_II at all tips, signs included, over the largest K."""
    plate = array(name)
    differences = [np.subtract(K, plate.K(crack, tip)) for crack, tip, K in K_of(name, spacing)]
    return float(np.abs(differences).max() / plate.largest_K())


def opening_difference(name: str, spacing: float) -> float:
    """Largest difference of opening and slip a spacing from the tips and more, over the largest opening."""
    plate, solution = array(name), solved(name, spacing)
    differences, size = [], 0.0
    for number, crack in enumerate(plate.cracks):
        s = np.linspace(-1.0, 1.0, 101) * (1.0 - spacing * 1e-3 / crack.half_length)
        wanted = plate.opening_and_slip(number, s, YOUNG / (1.0 - POISSON**2))
        found = solution.jump((1.0 + s) * crack.half_length, number)
        differences.append(np.abs(np.subtract(found, wanted)).max())
        size = max(size, float(wanted[0].max()))
    return float(max(differences) / size)


def _collinear() -> Iterator[Row]:
    inner, outer = collinear_K()
    tips: dict[str, tuple[tuple[int, Tip], ...]] = {
        "inner": ((0, "end"), (1, "start")),
        "outer": ((0, "start"), (1, "end")),
    }
    for name, K in (("inner", inner / PER_MM), ("outer", outer / PER_MM)):
        value = partial(worst, "collinear", 0.8, 0, tips[name], K)
        quantity = f"K_I, {name} tips, a/h = 6.25 [MPa sqrt(mm)]"
        yield Row(f"two collinear cracks, {BOX}", quantity, K, "exact", ERDOGAN, 5e-3, value)


def _stacked() -> Iterator[Row]:
    tips: tuple[tuple[int, Tip], ...] = ((0, "start"), (0, "end"), (1, "start"), (1, "end"))
    case = f"two cracks one above the other at a distance a, {BOX}"
    largest = array("stacked").largest_K() / PER_MM
    for spacing, ratio in ((0.8, 6.25), (1.0, 5)):
        for mode, K in enumerate(array("stacked").K(1, "start")):
            wanted = K / PER_MM

            quantity = ("K_I", "abs(K_II)")[mode] + f", a/h = {ratio} [MPa sqrt(mm)]"
            value = partial(worst, "stacked", spacing, mode, tips, wanted)
            yield Row(case, quantity, wanted, "independent code", SOLVER, 5e-3 * largest, value, "absolute")


def _scattered() -> Iterator[Row]:
    case = f"five cracks at different angles, {BOX}"
    for quantity, tolerance, value in (
        ("K_I and K_II over the largest K, a/h = 5 to 6.25: largest difference", 1e-2, largest_difference),
        ("opening and slip over the largest opening, a/h = 5 to 6.25: largest difference", 1e-2, opening_difference),
    ):
        yield Row(
            case, quantity, 0.0, "independent code", SOLVER, tolerance, partial(value, "scattered", 0.8), "at most"
        )


ROWS = [*_collinear(), *_stacked(), *_scattered()]
