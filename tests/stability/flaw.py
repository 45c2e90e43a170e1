"""The closed crack of cases/compression30.yaml before growth, laid, turned and loaded as a test wants it."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crackgrow.case.model import Case
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.scene import make_scene
from tests.one_size import one_size
from tests.scenes import shipped_case
from tests.verification.slit_body import closed_plate

QUIET = ("output.frames=none", "output.figures=false", "growth.steps=0")
HALF_LENGTH, WIDTH, HEIGHT = 5e-3, 31e-3, 55e-3  # m
IN_CRACK_AXES = (-25.0, -75.0, 25.0 * np.sqrt(3.0))
"""MPa: stress xx, yy, xy of the scene in axes along the flaw at 30 degrees."""

Stress = tuple[float, float, float]


def case(*settings: str) -> Case:
    """The static scene in mm and MPa; later settings go before earlier ones."""
    return shipped_case("compression30", [*QUIET, *one_size("compression30"), *settings])


def K(solution: StepSolution) -> NDArray[np.float64]:
    """K_I and K_II (tips, 2) Pa sqrt(m) by the interaction integral."""
    return np.array([(tip.intensity.K_I, tip.intensity.K_II) for tip in solution.tips])


def offset_with(case: Case, point: ArrayLike, wanted: ArrayLike, beyond: ArrayLike) -> tuple[float, float]:
    """Offset of the lattice that puts `point` (m) at fractions `wanted` of a cell, and `beyond` spacings further."""
    place = make_scene(case).lattice.to_lattice(np.asarray(point)) - np.asarray(wanted)
    x, y = place - np.rint(place) - np.asarray(beyond)
    return float(x), float(y)


def tip_of(angle: float) -> NDArray[np.float64]:
    """The start (2,) m of the flaw at an angle (degrees)."""
    return -HALF_LENGTH * np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])


def loads(stress: Stress) -> str:
    """The setting that puts tractions of a uniform stress xx, yy, xy (MPa) on all sides."""
    xx, yy, xy = stress
    sides = {"top": (xy, yy), "bottom": (-xy, -yy), "right": (xx, xy), "left": (-xx, -xy)}
    parts = (f"{{on: {{body: rock, edge: {edge}}}, traction: [{x}, {y}]}}" for edge, (x, y) in sides.items())
    return f"loads=[{', '.join(parts)}]"


@cache
def exact_K_II(
    angle: float,
    friction: float = 0.0,
    stress: Stress = (0.0, -100.0, 0.0),
    half_length: float = HALF_LENGTH,
    size: tuple[float, float] = (WIDTH, HEIGHT),
) -> float:
    """K_II (Pa sqrt(m)) of the sliding flaw in its plate under a stress in MPa, by collocation."""
    pascals = (1e6 * stress[0], 1e6 * stress[1], 1e6 * stress[2])
    return closed_plate(half_length, angle, *size, pascals, friction).K_II
