"""Paths of growing cracks and the time they take: against other codes, references of K_II = 0, and closed forms."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import shapely
from scipy.integrate import quad

from crackgrow import grow, load_case
from crackgrow.case.toughness import radius_of
from crackgrow.fracture.subcritical import mean_velocity
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.run.result import StepResult
from tests.scenes import MPA, plate, winged
from tests.verification.rows import test_limits as limits
from tests.verification.slit_body import plate as series
from tests.verification.solutions import CASES, QUIET, Floats, case_of, table
from tests.verification.table import Record, Row, parameters


@cache
def grown(case: str, *settings: str) -> list[StepResult]:
    """The steps of a shipped case."""
    return list(grow(load_case(CASES / f"{case}.yaml", [*QUIET, *settings])))


def right_wing(step: StepResult) -> Floats:
    """Vertices (n, 2) mm of what has grown at the end of the flaw, its tip first."""
    path = step.cracks[0]
    return 1e3 * path.points[np.flatnonzero(path.steps == 0)[-1] :]


# The right wing of compression30, against a code that remeshes.


def beside_wing(*settings: str) -> float:
    """Largest difference in x (mm) for y from 5 to 22 mm."""
    wing, rows = right_wing(grown("compression30", *settings)[-1]), table("wing_path_theta30.csv")
    inside = (rows["y_mm"] >= 5.0) & (rows["y_mm"] <= 22.0)
    x = np.interp(rows["y_mm"][inside], wing[:, 1], wing[:, 0], right=np.nan)
    return float(np.abs(x - rows["x_mm_LS_inc05"][inside]).max())


# confined30: where lateral pressure stops the wings. K_I falls as they grow; the length at arrest is where it falls
# through the toughness, on the straight line between two steps: increments do not limit it.

ON = ("growth.criterion=directional_strength", "growth.direction=explicit", "bodies.rock.strength.tension=0.6")
STEPS = {2: 2.6, 5: 1.3, 10: 0.6}
"""Increments (mm) of wings that a low strength makes grow on, by the lateral pressure (% of the axial stress)."""

TOUGHNESS = 6.3 * np.sqrt(2e-3 * np.pi)  # MPa sqrt(m)


def wing_of(percent: int | None) -> tuple[Floats, Floats]:
    """Lengths (n,) mm of the wing and its K_I (n,) MPa sqrt(m), step by step; None: of the case as it is."""
    more: tuple[str, ...] = ()
    if percent is not None:
        sides = (f"loads.2.traction=[{percent}, 0]", f"loads.3.traction=[{-percent}, 0]")
        more = (*ON, *sides, f"growth.increment={STEPS[percent]}", "growth.steps=5")
    steps = grown("confined30", *more)[1:]
    K_I = [1e-6 * next(tip.K_I for tip in step.tips if tip.tip == "end") for step in steps]
    return np.array([arc_lengths(right_wing(step))[-1] for step in steps]), np.array(K_I)


def arrest(percent: int | None) -> float:
    """The length (mm) at arrest."""
    length, K_I = wing_of(percent)
    (below, *_) = np.flatnonzero(K_I < TOUGHNESS)
    assert below > 0
    return float(np.interp(-TOUGHNESS, -K_I[below - 1 : below + 1], length[below - 1 : below + 1]))


ELEMENTS = "displacement discontinuities on the same path in an infinite plate; the case has 160 x 120 mm"


def _wings() -> Iterator[Row]:
    implicit = ("growth.criterion=max_hoop_stress", "growth.direction=implicit")
    for words, settings, tolerance in (
        ("directional_strength", (), 0.25),
        ("max_hoop_stress, implicit", implicit, 0.1),
        ("max_hoop_stress, implicit, both tips", (*implicit, "growth.advance=all", "growth.steps=11"), 0.1),
    ):
        value = partial(beside_wing, *settings)
        name, source = f"compression30, {words}", "wing_path_theta30.csv"
        yield Row(name, "distance of a path [mm]", value, 0.0, source, tolerance, slow=True)
    for percent, length, tolerance in ((2, 10.889, 0.2), (5, 5.654, 0.08), (10, 2.599, 0.08), (None, 5.52, 0.08)):
        name = f"confined30, {'as it is' if percent is None else f'{percent} %'}"
        yield Row(name, "length at arrest [mm]", partial(arrest, percent), length, ELEMENTS, tolerance, slow=True)


# Cracks of a millimetre in plates two hundred times as wide, that grow where K_II is zero.


def growing(scene: dict[str, Any], n: int) -> list[StepResult]:
    """n steps of a fifth of a millimetre, of all tips."""
    scene["bodies"]["rock"]["strength"] = {"tension": 1e-4, "cohesion": 1, "friction_angle": 30}
    growth = {"steps": n, "increment": 0.2, "advance": "all", "criterion": "max_hoop_stress", "direction": "implicit"}
    growth["tip_stress"] = {"radius": 0.05}
    return list(grow(case_of({**scene, "loading": "critical", "growth": growth, "numerics": {"accuracy": "standard"}})))


def vertices(name: str, n: int) -> Floats:
    """The first vertices (n, 2) mm that a tip makes; the flaw's half length is 1 mm."""
    rows = table(name)[:n]
    return np.column_stack([rows["x"], rows["y"]])


def beside_path() -> float:
    """Largest distance (mm) of the vertices of a wing from the path with K_II = 0."""
    wanted = vertices("wing_paths_infinite_plate.csv", 3)
    path = 1e3 * growing(plate(winged(1.0, 30.0, 1.0, 0.0)[1:3], 200.0, 1.0, 0.0, 0.0), 3)[-1].cracks[0].points
    return float(np.hypot(*(path[-3:] - wanted).T).max())


def passing() -> float:
    """The same (mm) of cracks that turn away from each other, then towards each other, which stay alike."""
    wanted, free = vertices("passing_cracks_paths.csv", 4), {"friction": 0, "cohesion": 0}
    scene = plate([[-4.5, -0.25], [-0.5, -0.25]], 200.0, -1.0, 0.0, 0.0)
    scene["cracks"] = {
        "lower": {"path": {"points": [[-4.5, -0.25], [-0.5, -0.25]]}, "tips": "end", "contact": dict(free)},
        "upper": {"path": {"points": [[0.5, 0.25], [4.5, 0.25]]}, "tips": "start", "contact": dict(free)},
    }
    lower, upper = (1e3 * crack.points for crack in growing(scene, 4)[-1].cracks)
    np.testing.assert_allclose(upper[:4][::-1], -lower[-4:], atol=1e-4)
    return float(np.hypot(*(lower[-4:] - wanted).T).max())


def turning() -> float:
    """Largest angle (degrees) to the major stress of a crack that a fluid opens, after four increments of 50 mm.

    It is closed where it begins: its wings alone are open.
    """
    loads = [limits.held(5, 15), {"crack": "flaw", "pressure": 1}]
    growth = {"steps": 4, "increment": 50}
    case = limits.plate(2400, limits.flaw(50, 45), loads, {"spacing": "auto", "accuracy": "draft"}, **growth)
    *_, last = grow(case)
    ends = np.diff(last.cracks[0].points, axis=0)[[0, -1]]
    return float(np.abs(np.rad2deg(np.arctan2(*ends.T[::-1])) - 90.0).max())


# A plate with two holes and two edge cracks (Bouchard, Bay, Chastel 2003), against the published extended FE program
# danassutula/XFEM_Fracture2D (MIT).

TWO_HOLES = """
title: Plate with two holes and two edge cracks
units: {length: mm, stress: MPa}
plane: strain
bodies:
  plate:
    shape:
      rectangle: {center: [0, 0], width: 20, height: 10}
      holes: [{disk: {center: [-7, 2], radius: 2}}, {disk: {center: [7, -2], radius: 2}}]
    material: {young: 98000, poisson: 0.3}
    strength: {tension: 1, cohesion: 100, friction_angle: 30, toughness: 1 MPa sqrt(m)}
cracks:
  left: {path: {points: [[-10, -2.15], [-9, -2.15]]}, contact: none, tips: end}
  right: {path: {points: [[10, 2.15], [9, 2.15]]}, contact: none, tips: end}
supports:
  - {on: {body: plate, edge: top}, displacement: {x: 0, y: 0.1}}
  - {on: {body: plate, edge: bottom}, displacement: {x: 0, y: -0.1}}
growth: {steps: 3, increment: 0.7174, advance: all, criterion: max_hoop_stress}
numerics: {spacing: auto}
"""


@cache
def two_holes() -> list[StepResult]:
    """The steps, K_II = 0 at the end of each increment."""
    steps = list(grow(case_of(TWO_HOLES)))
    left, right = (crack.points for crack in steps[-1].cracks)
    assert len(left) == len(right) == 5
    np.testing.assert_allclose(left, -right, atol=1e-7)
    return steps


def round_hole() -> float:
    """Largest distance (mm) of the vertices from the stored paths, which differ by 0.02 mm."""
    found, stored = [], table("two_holes_path.csv")
    for crack, step in enumerate((1, -1)):
        mine = stored[stored["crack"] == crack]
        line = shapely.LineString(np.column_stack([mine["x"], mine["y"]]))
        points = two_holes()[-1].cracks[crack].points
        found.append(float(shapely.distance(line, shapely.points(1e3 * points[::step])).max()))
    return max(found)


def K_beside_hole(step: int) -> float:
    """Error of K of both tips over K_I, the mean of both stored cracks, which differ by 0.4 %."""
    stored = table("two_holes_K.csv")
    K = np.array([stored[name][stored["step"] == step].mean() for name in ("K_I", "K_II")]) * MPA / 1e3**0.5
    return float(np.abs([np.subtract((tip.K_I, tip.K_II), K) for tip in two_holes()[step].tips]).max() / K[0])


def _others() -> Iterator[Row]:
    for name, value, source, tolerance in (
        ("a wing in a wide plate", beside_path, "wing_paths_infinite_plate.csv", 0.01),
        ("cracks that pass each other", passing, "passing_cracks_paths.csv", 1e-3),
    ):
        yield Row(name, "distance of a path [mm]", value, 0.0, source, tolerance)
    yield Row("fluid", "angle to the major stress [degrees]", turning, 0.0, "it turns there", 4.0, slow=True)
    holes = "danassutula/XFEM_Fracture2D, two holes"
    yield Row("two holes, 3 steps", "distance of a path [mm]", round_hole, 0.0, holes, 0.05)
    for step in (0, 1, 2):  # the next two, beside the hole, are 1.5 and 1.9 % off
        yield Row(f"two holes, step {step}", "K of growing cracks", partial(K_beside_hole, step), 0.0, holes, 1e-2)


# Directions of growth in rock with bedding. Its elasticity is isotropic, and K what it is without bedding.

ALONG = 0.4  # of the toughness across the planes


def kink_in_bedding(criterion: str, angle: float, planes: float) -> float:
    """Kink (degrees) of a crack of 40 mm in a pulled plate 20 times as wide; angles are from x, across the pull."""
    bedding = {"angle": planes, "toughness": f"{ALONG} MPa sqrt(m)"}
    strength = {**limits.ROCK, "tension": 50, "cohesion": 1000, "friction_angle": 30, "bedding": bedding}
    cells, pull = {"spacing": "auto", "accuracy": "draft"}, [{"far_field": [0, 1, 0]}]
    (step,) = grow(limits.plate(800, limits.flaw(20, angle), pull, cells, strength, criterion))
    tip = step.tips[1]
    assert abs(tip.criticality - 1.0) < 1e-6
    return tip.kink_deg


def largest_over_toughness(criterion: str, angle: float, planes: float) -> float:
    """The kink (degrees) at which the hoop stress of the exact K is largest over the toughness of a direction.

    `directional_strength` sees its average over R, 2 / sqrt(2 pi R) times that of K, and T, which is not singular.
    """
    exact, t = series(HALF, angle, WIDTH, WIDTH, 1.0), np.linspace(-110.0, 110.0, 220_001)
    half, away = np.deg2rad(0.5 * t), np.deg2rad(angle + t - planes)
    hoop = np.cos(half) * (exact.K_I * np.cos(half) ** 2 - 1.5 * exact.K_II * np.sin(2.0 * half))
    if criterion == "directional_strength":
        hoop = 2.0 / np.sqrt(2.0 * np.pi * radius_of(criterion, 50.0, 1.0)) * hoop + exact.T * np.sin(2.0 * half) ** 2
    return float(t[np.argmax(hoop / (ALONG + (1.0 - ALONG) * np.sin(away) ** 2))])


def _bedding() -> Iterator[Row]:
    for criterion, tolerance in (("max_hoop_stress", 0.1), ("directional_strength", 0.5)):
        for angle, planes in ((0, 45), (30, -20), (60, 20)):
            name, value = f"{criterion}, {angle}, {planes} degrees", partial(kink_in_bedding, criterion, angle, planes)
            exact = largest_over_toughness(criterion, angle, planes)
            yield Row(name, "kink in bedding [degrees]", value, exact, "slit_body.py", tolerance, "absolute")


# Time of subcritical growth of a crack in tension in a wide plate: the integral of da / (v_max (K / K_c)^n), with
# K = c s sqrt(pi a) / sqrt(cos(pi a / W)) (Feddersen), where c = 1 but for the error of the first K.

HALF, WIDTH, PULL, V_MAX = 0.02, 0.8, 1.5, 0.01  # m, m, MPa, m/s
PULLED = [{"far_field": [0, PULL, 0]}]


def slow(exponent: int, increment: float) -> list[StepResult]:
    """The steps of a crack that grows slowly to twice its length in increments (mm)."""
    law = {"direction": "explicit", "law": "subcritical", "steps": round(20 / increment), "increment": increment}
    return to_twice_its_length({**law, "subcritical": {"velocity": "10 mm/s", "exponent": exponent}}, [1])


def to_twice_its_length(law: dict[str, Any], history: list[float]) -> list[StepResult]:
    """The steps of a central crack that grows by a law of rate under loads."""
    numerics = {"spacing": 20, "refine": {"tips": 3}}
    flaw = {"flaw": {"path": {"center": [0, 0], "length": 40, "angle": 0}, "contact": "none"}}
    return list(grow(limits.plate(800, flaw, PULLED, numerics, loading={"history": history}, **law)))


@cache
def error_of_time(exponent: int, increment: float) -> float:
    """What the time is off by, relative, in which the crack has come to twice its length in increments (mm)."""
    steps = slow(exponent, increment)

    def intensity(a: float) -> float:
        return float(PULL * np.sqrt(np.pi * a / np.cos(np.pi * a / WIDTH)))

    c = 1e-6 * steps[0].tips[0].K_I / intensity(HALF)
    assert abs(c - 1.0) < 0.01
    end = 0.5 * steps[-1].crack_length
    exact, _ = quad(lambda a: 1.0 / (V_MAX * (c * intensity(a)) ** exponent), HALF, end, epsrel=1e-10)
    return steps[-1].time / exact - 1.0


def fall_of_time_error() -> float:
    """How much less the error changes from the middle increment to the short one than from the long one to it."""
    error = [error_of_time(2, increment) for increment in (10.0, 5.0, 2.5)]
    return abs(error[0] - error[1]) / abs(error[1] - error[2])


PARIS, LEAST_LOAD = {"rate": "1e-6 mm", "at": "1 MPa sqrt(m)", "exponent": 3}, 0.2  # of the largest load


@cache
def cycles_over_exact(increment: float, in_increments: bool) -> float:
    """Cycles of a central crack to twice its length over those by Paris' law with the exact K, minus 1.

    That is the integral over the length, or its sum over increments (mm) along which ln(da/dN) is linear.
    """
    n = round(20 / increment)
    law = {"direction": "explicit", "law": "fatigue", "fatigue": PARIS, "steps": n, "increment": increment}
    steps = to_twice_its_length(law, [LEAST_LOAD, 1])

    def rate(a: float) -> float:
        return 1e-9 * ((1.0 - LEAST_LOAD) * series(a, 0.0, WIDTH, WIDTH, PULL).K_I) ** 3

    half = np.array([0.5 * step.crack_length for step in steps])
    if in_increments:
        mean = [mean_velocity(rate(before), rate(after)) for before, after in pairwise(half.tolist())]
        return float(steps[-1].cycles / (np.diff(half) / mean).sum() - 1.0)
    exact, _ = quad(lambda a: 1.0 / rate(a), half[0], half[-1], epsrel=1e-6)
    return float(steps[-1].cycles / exact - 1.0)


def _times() -> Iterator[Row]:
    for exponent in (2, 10):
        name, value = f"exponent {exponent}", partial(error_of_time, exponent, 2.5)
        yield Row(name, "time of growth", value, 0.0, "Feddersen", 0.01)
    yield Row("exponent 2", "fall of the error of time", fall_of_time_error, 3.0, "order of two", 0.0, "at least")
    for increment in (10, 2.5):
        name, value = f"increments of {increment} mm", partial(cycles_over_exact, increment, True)
        yield Row(name, "cycles of growth, in increments", value, 0.0, "slit_body.py, Paris", 0.001)
    value = partial(cycles_over_exact, 2.5, False)
    yield Row("increments of 2.5 mm", "cycles of growth", value, 0.0, "slit_body.py, Paris", 0.005)


@pytest.mark.parametrize("row", parameters(_wings(), _others(), _bedding(), _times()))
def test_value_is_within_its_tolerance(row: Row, record_property: Record) -> None:
    row.check(record_property)
