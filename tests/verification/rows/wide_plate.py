"""A closed crack in a plate so wide that the closed form of the infinite plate holds: half width 20 a."""

from __future__ import annotations

from functools import partial

import numpy as np

from tests.verification.row import Row
from tests.verification.solutions import Solved, solved

HALF_LENGTH = 5e-3  # m
PRESSURE, SHEAR = 75e6, 100e6 * np.sqrt(3.0) / 4.0  # Pa, at 60 degrees between crack and load
PLATE = (
    "bodies.rock.shape.rectangle.width=200",
    "bodies.rock.shape.rectangle.height=200",
    "supports.0.at=[-100,-100]",
    "supports.1.at=[100,-100]",
    "supports.2.at=[0,-100]",
    "numerics.spacing=1.1",
)
SPACING = 1.1e-3  # m
LAWS = ((0.0, 0.0), (0.3, 0.0), (0.3, 5.0))  # friction, cohesion (MPa)
FORMULA = "infinite plate; the series solution puts this size 0.2 to 0.3 % above it in tension"


def at(friction: float, cohesion: float) -> Solved:
    # the closed form keeps the cohesion where faces slip
    law = {"friction": friction, "cohesion": cohesion, "cohesion_after_slip": "kept"}
    return solved("compression30", *PLATE, *(f"cracks.flaw.contact.{key}={value}" for key, value in law.items()))


def driving(friction: float, cohesion: float) -> float:
    """Shear (Pa) that friction and cohesion leave over."""
    return max(0.0, SHEAR - friction * PRESSURE - cohesion * 1e6)


def K_II(friction: float, cohesion: float) -> float:
    return abs(at(friction, cohesion).tip("end")[1]) / 1e6


def slip_difference(friction: float, cohesion: float) -> float:
    """Largest difference of the slip a spacing from the tips and more, relative to the exact slip there."""
    s = np.linspace(-1.0, 1.0, 101) * (HALF_LENGTH - SPACING)
    found = np.abs(at(friction, cohesion).jump(s + HALF_LENGTH)[1])
    exact = 4.0 * (1.0 - 0.25**2) / 1e10 * driving(friction, cohesion) * np.sqrt(HALF_LENGTH**2 - s**2)
    return float(np.abs(found / exact - 1.0).max())


def _rows():
    for friction, cohesion in LAWS:
        words = f"friction {friction}, cohesion {cohesion} MPa"
        K = driving(friction, cohesion) * np.sqrt(np.pi * HALF_LENGTH) / 1e6
        yield Row(
            "compression30, half width 20 a",
            f"abs(K_II), {words} [MPa sqrt(m)]",
            K,
            "exact",
            FORMULA,
            3e-3,
            partial(K_II, friction, cohesion),
        )
        yield Row(
            "compression30, half width 20 a",
            f"slip, {words}: largest difference",
            0.0,
            "exact",
            FORMULA,
            1e-2,
            partial(slip_difference, friction, cohesion),
            "at most",
        )


ROWS = list(_rows())
