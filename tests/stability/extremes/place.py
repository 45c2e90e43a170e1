"""Where things lie: the lattice, the crack on it, the tip next to a node, the whole scene."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import cos, pi, radians, sin, sqrt

import numpy as np

from crackgrow.case.model import Case, PointSupport
from crackgrow.run.scene import make_scene
from tests.stability.extremes.measures import K_II_against, uniform
from tests.stability.extremes.scenes import COARSE, USUAL, Scenes
from tests.stability.extremes.trial import Trial
from tests.stability.placed import Placement, mirrored, moved, placed, turned
from tests.stability.solved import Solved, against, overall, solved, solved_placed, stress_intensity

STRESS, HALF_LENGTH, ANGLE = 100e6, 5e-3, 30.0  # Pa, m, degrees: of the flaw as it is

LATTICE_TOLERANCE = 1e-2

PLACED_TOLERANCE = 1e-3
"""In another direction polygons fall into other triangles: the noise of quadrature."""

WIDE_TOLERANCE = 2e-2
"""K in a plate of ten times the crack's length, by that in an infinite one: 1 % is the plate's."""

SHORT_TOLERANCE = {0.5: 8e-2, 1.0: 2.5e-2}
"""Of cracks of so many spacings: cells are by hand, and K is as good as they let it be (test_short_and_near.py)."""

STICK_TOLERANCE = 1e-6

WIDTH = 100.0  # mm: ten times the flaw


def lattice(scenes: Scenes) -> Iterator[Trial]:
    """The lattice moved under the scene."""
    every = ((0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (0.25, 0.1), (-0.37, 0.21), (0.11, -0.43))
    for offset in scenes.few(every, ((0.5, 0.5), (-0.37, 0.21))):
        yield _offset(scenes, "lattice", f"{offset[0]:g}, {offset[1]:g} spacings", offset)


def tip_next_to(scenes: Scenes) -> Iterator[Trial]:
    """The lattice so that the flaw's end comes to lie next to a node, or a line, a part of a spacing away."""
    case = scenes.flaw()
    place = make_scene(case).lattice.to_lattice(case.cracks[0].points[-1])
    onto = place - np.round(place)
    for distance in scenes.few((0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-3), (0.0, 1e-9, 1e-3)):
        for name, offset in (("node", onto - distance), ("line", np.array([0.0, onto[1] - distance]))):
            x, y = ((offset + 0.5) % 1.0 - 0.5).tolist()
            yield _offset(scenes, "tip", f"{distance:g} spacings from a {name}", (x, y))


def angle(scenes: Scenes) -> Iterator[Trial]:
    """The flaw in a wide plate, from across the load to along it."""
    for degrees in scenes.few((0, 15, 30, 45, 60, 75, 90), (0, 45, 90)):
        settings = (*_wide(WIDTH), f"cracks.flaw.path.angle={degrees}")
        solve, value = scenes.solved_flaw(*settings), f"{degrees} degrees"
        plain = scenes.usual_flaw(*_wide(WIDTH))
        if degrees == 0:
            text, measure = "uniform tractions, K = 0 (exact)", uniform(-STRESS, 0.0)
            yield Trial("angle", value, text, STICK_TOLERANCE, solve, measure, plain)
        elif degrees == 90:
            text = "K = 0 (exact), by sigma sqrt(pi a)"
            yield Trial("angle", value, text, STICK_TOLERANCE, solve, _no_K, plain)
        else:
            text = "K_II in an infinite plate, K_I = 0"
            yield Trial("angle", value, text, WIDE_TOLERANCE, solve, K_II_against(_K_II(degrees, HALF_LENGTH)), plain)


def length(scenes: Scenes) -> Iterator[Trial]:
    """From half a spacing to a hundred: short cracks by K in an infinite plate, the long one by itself."""
    spacing = COARSE if scenes.short else USUAL
    for spacings in scenes.few((0.5, 1.0, 2.0, 3.0, 5.0), (0.5, 2.0, 5.0)):
        length = spacings * spacing
        settings = (f"cracks.flaw.path.length={length}", *(_wide(10.0 * length) if 10.0 * length > 55.0 else ()))
        yield Trial(
            "length",
            f"{spacings:g} spacings",
            "K_II in an infinite plate, K_I = 0",
            SHORT_TOLERANCE.get(spacings, WIDE_TOLERANCE),
            scenes.solved_flaw(*settings),
            K_II_against(_K_II(ANGLE, 0.5e-3 * length)),
            scenes.usual_flaw(),
            refusable=spacings < 1.0,
        )
    if scenes.short:
        return
    plain = _cropped(scenes, "numerics.spacing=0.5")
    usual = scenes.usual(plain)
    yield Trial(
        "length",
        "100 spacings",
        "K at 20 spacings, in a plate of 15 mm",
        LATTICE_TOLERANCE,
        lambda: solved(_cropped(scenes, "numerics.spacing=0.1")),
        against(usual, stress_intensity),
        usual,
    )


def scene(scenes: Scenes) -> Iterator[Trial]:
    """The whole scene turned, mirrored, moved."""
    placements = {
        "turned by 90 degrees": turned(90.0),
        "turned by 180 degrees": turned(180.0),
        "mirrored": mirrored(),
        "moved by 1 km": moved(1e3, -1e3),
    }
    for name, placement in placements.items():
        yield _placed_trial(scenes, name, placement)
    plain = scenes.usual_flaw()
    for degrees in scenes.few((1.0, 37.0), (37.0,)):
        yield Trial(
            "scene",
            f"turned by {degrees:g} degrees",
            "K",
            LATTICE_TOLERANCE,
            partial(_solved_turned, scenes, degrees),
            against(plain, stress_intensity),
            plain,
        )


def _placed_trial(scenes: Scenes, value: str, placement: Placement) -> Trial:
    plain = scenes.usual_flaw()
    return Trial(
        "scene",
        value,
        "K, displacement, energies, forces",
        PLACED_TOLERANCE,
        lambda: solved_placed(scenes.flaw(), placement),
        against(plain, overall),
        plain,
    )


def _offset(scenes: Scenes, axis: str, value: str, offset: tuple[float, float]) -> Trial:
    plain = scenes.usual_flaw()
    return Trial(
        axis,
        value,
        "K on the lattice as it lies",
        LATTICE_TOLERANCE,
        lambda: solved(scenes.flaw(), None, offset),
        against(plain, stress_intensity),
        plain,
    )


def _wide(width: float) -> tuple[str, str]:
    """A square plate, mm."""
    return f"bodies.rock.shape.rectangle.width={width}", f"bodies.rock.shape.rectangle.height={width}"


def _K_II(degrees: float, half_length: float) -> float:
    """|K_II| (Pa sqrt(m)) of a closed crack without friction in an infinite plate, counted from across the load."""
    theta = radians(degrees)
    return STRESS * sin(theta) * cos(theta) * sqrt(pi * half_length)


def _no_K(found: Solved) -> float:
    return float(np.abs(found.K).max() / (STRESS * np.sqrt(np.pi * HALF_LENGTH)))


def _cropped(scenes: Scenes, spacing: str) -> Case:
    """The flaw in a small plate: the supports, which carry nothing, go to its corners."""
    plate = ("bodies.rock.shape.rectangle.width=15", "bodies.rock.shape.rectangle.height=15")
    at = ("supports.0.at=[-7.5, -7.5]", "supports.1.at=[7.5, -7.5]", "supports.2.at=[0, -7.5]")
    return scenes.flaw(*plate, *at, spacing)


def _solved_turned(scenes: Scenes, degrees: float) -> Solved:
    return solved(_turned_freely(scenes.flaw(), degrees))


def _turned_freely(case: Case, degrees: float) -> Case:
    """Turned by any angle but for its supports: they carry nothing, any three that hold the body are as good."""
    placement = turned(degrees)
    points = [s for s in case.supports if isinstance(s, PointSupport)]
    supports = tuple(replace(s, point=placement.points(s.point[None])[0]) for s in points)
    return replace(placed(replace(case, supports=()), placement), supports=supports)
