"""K on cells that a run chooses, for a target of its error or by a name: within the target, and the bound holds.

Of all scenes of tests/benchmarks/errors.md these are the quick ones, and those whose cells do not see what matters.
"""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.fft import dct
from scipy.optimize import brentq

from crackgrow.accuracy.companion import BOUND
from crackgrow.case import Case
from crackgrow.run.loading import load
from crackgrow.run.loop import grow, solved_steps
from crackgrow.run.result import StepResult, TipResult
from tests.benchmarks.errors import wings
from tests.benchmarks.target_scenes import SCENES as TABLE
from tests.scenes import plate, shipped_case
from tests.verification.solutions import QUIET, case_of

QUICK = ("grown wings", "young wings", "wings, friction 0.3, 30", "friction 0.3, 45 degrees", "open, 20 degrees",
         "closed kink of 30", "edge crack", "disk, along the load", "cross", "stacked", "star", "fork")  # fmt: skip
"""Of the table of targets."""
SCENES = {name: TABLE[name] for name in QUICK}
GOOD_TO = {"closed kink of 30": 3e-3, "grown wings": 5e-4, "young wings": 5e-4}
"""What truths are good to, of the largest K; plates a hundred half lengths wide add 8e-4."""


@pytest.mark.parametrize(
    ("name", "target"),
    [
        *((name, 0.03) for name in SCENES),
        *((name, 0.003) for name in ("young wings", "friction 0.3, 45 degrees", "edge crack", "stacked", "star")),
        *((name, 0.01) for name in ("grown wings", "closed kink of 30", "star")),
        ("grown wings", 0.1),
    ],
)
def test_K_is_within_the_target_and_the_bound_holds(name: str, target: float) -> None:
    """All but what the truth is good to: tests/benchmarks/errors.md has more scenes."""
    known = SCENES[name]()
    assert known.truth is not None
    step = next(grow(case_of({**known.case, "numerics": {"accuracy": target}})))
    pairs = [(tip, K) for tip in step.tips if (K := known.truth.get((tip.crack, tip.tip)))]
    off = max(np.hypot(tip.K_I - K[0], abs(tip.K_II) - abs(K[1])) for tip, K in pairs)
    off /= max(np.hypot(*K) for K in known.truth.values())
    largest = max(np.hypot(tip.K_I, tip.K_II) for tip in step.tips)
    assert off <= max(tip.K_I_error for tip in step.tips) / largest + GOOD_TO.get(name, 1e-3)
    assert all(tip.K_I_error > tip.K_error_expected for tip in step.tips)
    if target != 0.003 or name in ("young wings", "friction 0.3, 45 degrees"):  # of others the truth is not good enough
        assert off <= target
        assert not is_missed(step)
        assert step.n_dofs < 25_000


def is_missed(step: StepResult) -> bool:
    """Whether the run says that its target is missed."""
    return any(warning.cause == "TARGET" for warning in step.step_warnings)


def test_faces_that_touch_next_to_a_tip_are_seen() -> None:
    """Wings whose tips are closed over less than a cell: K_I was below zero there, and K_II 1.4 % off.

    Both meshes miss that alike. The truth is that of cells three levels finer.
    """
    _, scene = [*wings(2)][4]
    ((step, solution),) = solved_steps(Case.from_dict({**scene, "numerics": {"accuracy": "standard"}}))
    levels = tuple(level + 3 for level in solution.scene.grading.cracks or (0,))
    finer = load(solution.scene.with_grading(replace(solution.scene.grading, cracks=levels)), solution.cracks)
    for tip, true in zip(step.tips, finer.tips, strict=True):
        assert np.hypot(tip.K_I - true.K[0], tip.K_II - true.K[1]) <= tip.K_I_error


def beside(what: str, room: float) -> dict[str, Any]:
    """A crack of 10 mm in a plate under tension whose right tip lies `room` (mm) beside a stiff body or a hole."""
    scene, x = plate([[-5, 0], [5, 0]], 100.0, -1.0, 0.0, 0.0), 5.0 + room
    scene["cracks"]["flaw"]["contact"] = "none"
    if what == "hole":
        scene["bodies"]["rock"]["shape"]["holes"] = [{"disk": {"center": [x + 4.0, 0], "radius": 4.0}}]
        return scene
    for name, low, high, young in (("rock", -50, x, 20_000), ("stiff", x, 50, 60_000)):
        shape = {"polygon": [[low, -50], [high, -50], [high, 50], [low, 50]]}
        scene["bodies"][name] = {"shape": shape, "material": {"young": young, "poisson": 0.25}}
    scene["interfaces"] = [{"between": ["rock", "stiff"], "contact": "bonded"}]
    pulled = [(body, edge, sign) for body in scene["bodies"] for edge, sign in ((0, -1.0), (2, 1.0))]
    scene["loads"] = [{"on": {"body": body, "edge": edge}, "traction": [0, t]} for body, edge, t in pulled]
    return scene


@pytest.mark.parametrize(("what", "room", "asked"), [("hole", 0.1, 0.03), ("interface", 0.01, "standard")])
def test_cells_at_a_tip_are_small_by_its_room(what: str, room: float, asked: float | str) -> None:
    """Two cells of different size, both larger than the room, agreed on what was 2.6 and 2 % off.

    The truth is that of `fine`, which has four cells in the room.
    """
    found = []
    for accuracy in ("fine", asked):
        step = next(grow(case_of({**beside(what, room), "numerics": {"accuracy": accuracy}})))
        found.append({tip.tip: tip for tip in step.tips}["end"])
        largest = max(np.hypot(tip.K_I, tip.K_II) for tip in step.tips)
    true, tip = found
    off, bound = (np.hypot(tip.K_I - true.K_I, tip.K_II - true.K_II), max(tip.K_I_error, tip.K_II_error))
    assert off <= bound + true.K_I_error
    assert bound <= BOUND * (asked if isinstance(asked, float) else 0.01) * largest


# A flaw |x| < a of 20 mm under the pressure p = 10 MPa across it and a shear along it, in a plate 40 times as wide. A
# fluid takes pressure off it in a way that cells may not see.

HALF, PRESSURE, FRICTION = 0.01, 10e6, 0.5  # m, Pa
ROOT = np.sqrt(np.pi * HALF)
WIDE = 0.001
"""What the plate's width adds to K, of itself; 0.0007 where there is no friction."""


FLAW = """
title: a flaw under pressure and shear
units: {length: mm, stress: MPa}
plane: strain
bodies: {rock: {shape: {rectangle: {center: [0, 0], width: 800, height: 800}}, material: {young: 10000, poisson: 0.2}}}
cracks: {flaw: {path: {points: [[-10, 0], [10, 0]]}, contact: LAW}}
loads: [{far_field: [0, -10, SHEAR]}, {crack: flaw, pressure: FLUID}]
supports: minimal
numerics: {accuracy: ACCURACY}
"""


def pressed(shear: float, law: dict[str, Any], fluid: str | float, accuracy: str) -> StepResult:
    """The flaw under a shear (MPa) and the pressure of a fluid (MPa), by a formula of x in mm."""
    return next(grow(case_of(FLAW, LAW=json.dumps(law), SHEAR=shear, FLUID=json.dumps(fluid), ACCURACY=accuracy)))


RISING, FALLING = "9 - 9 * (x / 10)**8", "9 * (x / 10)**8"
"""What a fluid takes off the pressure across the flaw, which rises towards its tips or falls."""


@pytest.mark.parametrize(
    ("fluid", "share", "angle", "accuracy"),
    [
        (0, 0.0, 25.0, "draft"),
        (RISING, 93.0 / 128.0, 10.0, "0.3 %"),
        (RISING, 93.0 / 128.0, 25.0, "draft"),
        (FALLING, 35.0 / 128.0, 0.0, "standard"),
        (FALLING, 35.0 / 128.0, 25.0, "0.3 %"),
    ],
)
def test_faces_that_slip_open_by_dilation_up_to_the_tips(
    fluid: str | float, share: float, angle: float, accuracy: str
) -> None:
    """They open by tan(psi) times the slip, which adds to the pressure what a crack opened so far would carry.

    K_II = (t - mu (p - m)) sqrt(pi a) / (1 + mu tan(psi)) and K_I = tan(psi) K_II, m the weighted mean of the fluid.
    """
    step = pressed(9, {"friction": FRICTION, "dilation_angle": angle}, fluid, accuracy)
    slope = np.tan(np.radians(angle))
    K_II = (9e6 - FRICTION * (PRESSURE - share * 9e6)) * ROOT / (1.0 + FRICTION * slope)
    for tip in step.tips:
        off = np.hypot(tip.K_I - slope * K_II, abs(tip.K_II) - K_II)
        assert off <= max(tip.K_I_error, tip.K_II_error) + WIDE * K_II


def opening_ends(fluid: float, power: int) -> tuple[float, float]:
    """K_I and K_II (Pa sqrt(m)) under a fluid f (x / a)^n, which opens the ends b < |x| < a under q = f (x / a)^n - p.

    With s = x^2 = (a^2 + b^2) / 2 + (a^2 - b^2) / 2 cos(theta) over the ends, and q (1 - cos(theta)) the sum of
    c_n cos(n theta), the slope of the opening that is smooth at b is (Muskhelishvili 1953, chapter 18)

        B = const sqrt((s - b^2) / (a^2 - s)) sum of c_n sin(n theta) / sin(theta).

    The opening is zero at both ends: the integral of B dx tells b. K_I = sqrt((a^2 - b^2) / (pi a)) integral of q
    dtheta from 0 to pi, and K_II = t sqrt(pi a) - mu (K_I + (p - m) sqrt(pi a)), m = f (n - 1)!! / n!!.
    """
    points = 400
    theta = (np.arange(points) + 0.5) * np.pi / points

    def ends(b: float) -> tuple[np.ndarray, np.ndarray]:
        s = 0.5 * (1.0 + b**2) + 0.5 * (1.0 - b**2) * np.cos(theta)  # over a^2
        return s, fluid * s ** (power / 2) - PRESSURE

    def opening(b: float) -> float:
        s, q = ends(b)
        terms = dct(q * (1.0 - np.cos(theta)), type=2) / points
        rising = np.sin(np.outer(theta, np.arange(points))) @ np.append(0.0, terms[1:])
        return float(np.sum((1.0 + np.cos(theta)) * rising / np.sin(theta) / np.sqrt(s)))

    b = brentq(opening, 0.05, 1.0 - 1e-6)
    K_I = np.sqrt(HALF * (1.0 - b**2) / np.pi) * np.mean(ends(b)[1]) * np.pi
    mean = fluid * np.prod(np.arange(1, power, 2) / np.arange(2, power + 1, 2))
    return float(K_I), float(9e6 * ROOT - FRICTION * (K_I + (PRESSURE - mean) * ROOT))


@pytest.mark.parametrize("accuracy", ["draft", "standard"])
@pytest.mark.parametrize(("fluid", "power"), [(12, 8), (30, 8), (11, 20), (20, 20)])
def test_the_bound_holds_where_ends_open_that_cells_may_not_see(fluid: int, power: int, accuracy: str) -> None:
    """The open ends are 0.02 to 0.2 of the half length; K_I on coarse cells is up to 0.34 K_II too large."""
    step = pressed(9, {"friction": FRICTION}, f"{fluid} * (x / 10)**{power}", accuracy)
    K_I, K_II = opening_ends(1e6 * fluid, power)
    for tip in step.tips:
        assert abs(tip.K_I - K_I) <= tip.K_I_error + WIDE * K_II
        assert abs(abs(tip.K_II) - K_II) <= tip.K_II_error + WIDE * K_II


def parting(slope: float, zero: float, accuracy: str, cohesion: float) -> tuple[StepResult, float, float]:
    """The flaw without friction, and K_I and K_II (Pa sqrt(m)) of its end, where faces part over a stretch.

    With the pressure g (x0 - x) that a fluid leaves, the stretch is 2 l = 4 (a - x0) / 3 long, since K_I is zero at its
    inner end, and K_I = g l sqrt(pi l) at the tip. The shear c of the cohesion is missing there alone:

        K_II = (t - c) sqrt(pi a) + c / sqrt(pi a) times the integral over the stretch of sqrt((a + x) / (a - x)).
    """
    law = {"friction": 0, "cohesion": 1e-6 * cohesion, "cohesion_after_slip": "kept"}
    step = pressed(5, law, f"10 + {slope} * (x - {zero})", accuracy)
    half = 2.0 * (HALF - 1e-3 * zero) / 3.0
    angle = np.arcsin(1.0 - 2.0 * half / HALF)  # x = a sin(angle) where the stretch begins
    missing = cohesion * np.sqrt(HALF / np.pi) * (np.pi / 2.0 - angle + np.cos(angle))
    return step, 1e9 * slope * half * np.sqrt(np.pi * half), (5e6 - cohesion) * ROOT + missing


@pytest.mark.parametrize(("slope", "zero", "accuracy"), [(0.2, 9.5, "draft"), (0.5, 9.8, "1 %"), (0.5, 9.0, "0.3 %")])
def test_cohesion_is_lost_where_faces_part_next_to_a_tip(slope: float, zero: float, accuracy: str) -> None:
    step, K_I, K_II = parting(slope, zero, accuracy, 3e6)
    tip = step.tips[1]
    if accuracy == "draft":
        assert abs(tip.K_II - K_II) <= tip.K_II_error
        return
    assert (tip.K_II_error > BOUND * 1e-2 * float(accuracy[:-2]) * tip.K_II) == is_missed(step)
    assert not is_missed(step) or accuracy == "0.3 %"
    assert abs(tip.K_II - K_II) <= tip.K_II_error + 0.0007 * K_II
    assert abs(tip.K_I - K_I) <= tip.K_I_error


@pytest.mark.parametrize("accuracy", ["draft", "0.3 %"])
@pytest.mark.parametrize(("slope", "zero"), [(3.0, 6.0), (5.0, 7.0), (0.5, 9.3), (5.0, 9.6), (50.0, 9.9)])
def test_the_bound_knows_of_faces_that_part(slope: float, zero: float, accuracy: str) -> None:
    """Far from the tip, on large cells, and more closely to it than any contact point sees."""
    step, K_I, K_II = parting(slope, zero, accuracy, 0.0)
    tip, far = step.tips[1], zero < 9.0
    off = np.hypot(tip.K_I - K_I, tip.K_II - K_II) - 0.0007 * np.hypot(K_I, K_II)
    assert off <= (max(tip.K_I_error, tip.K_II_error) if far else tip.K_I_error)
    assert not (far and is_missed(step))


PATH = [
    [-4.0155, -13.8005], [-4.4729, -12.3719], [-4.9497, -10.9497], [4.9497, -1.0503], [4.4729, 0.3719],
    [3.8018, 1.7134], [3.141, 3.0601], [2.5044, 4.4183], [1.941, 5.8084], [1.5023, 7.2428],
]  # fmt: skip
"""mm: the flaw of cases/flaw_and_hole.yaml with wings, the last vertex 0.37 from the hole; the radius is 1.5."""


def tip_beside_the_hole(accuracy: str) -> TipResult:
    """The tip of the wing, a quarter of the averaging length from the hole."""
    settings = (f"cracks.flaw.path={{points: {PATH}}}", "growth.steps=0", "loading={history: [3.2]}")
    case = shipped_case("flaw_and_hole", [*settings, *QUIET, f"numerics.accuracy={accuracy}"])
    return next(tip for tip in next(grow(case)).tips if tip.tip == "end")


def test_smaller_cells_say_the_same_of_growth_and_the_tip_grows_by_its_K() -> None:
    """As in the other steps, which are at 0.217 to 0.219 MPa sqrt(m) where the wing advances."""
    coarse, fine = tip_beside_the_hole("standard"), tip_beside_the_hole("fine")
    assert coarse.criticality == pytest.approx(fine.criticality, rel=0.01)
    assert abs(coarse.kink_deg - fine.kink_deg) < coarse.kink_error_deg
    assert coarse.K_I / coarse.criticality == pytest.approx(0.218e6, rel=0.03)
