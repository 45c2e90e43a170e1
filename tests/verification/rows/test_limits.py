"""Loads at which cracks grow, and factors of safety, in closed form."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache, partial
from itertools import product
from typing import Any

import numpy as np
import pytest
import shapely
from scipy.optimize import brentq

from crackgrow.case import Case
from crackgrow.case.toughness import MODE_I, shear_radius_of
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.criteria import CRITERIA
from crackgrow.run.configuration import assemble
from crackgrow.run.critical_load import critically_loaded
from crackgrow.run.loop import grow
from crackgrow.run.result import Safety
from crackgrow.run.scene import make_scene
from tests.scenes import ROCK_TOUGHNESS, crack_at_bond, shipped_case, specimen
from tests.solving import whole_run
from tests.verification.solutions import QUIET, case_of
from tests.verification.table import Record, Row, parameters

TOUGHNESS = 1.0  # MPa sqrt(m)
ROCK = {"tension": 5, "cohesion": 20, "friction_angle": 40, "toughness": "1 MPa sqrt(m)"}


def flaw(half: float, angle: float = 0.0, friction: float = 0.6) -> dict[str, Any]:
    """A crack of a half length (mm) in the middle at an angle (degrees) to x."""
    path = {"center": [0, 0], "length": 2.0 * half, "angle": angle}
    return {"flaw": {"path": path, "contact": {"friction": friction, "cohesion": 0}}}


def plate(
    width: float,
    cracks: Mapping[str, Any],
    loads: list[dict[str, Any]],
    numerics: Mapping[str, Any],
    strength: Mapping[str, Any] = ROCK,
    criterion: str = "max_hoop_stress",
    hole: float = 0.0,
    loading: Any = "critical",
    **growth: Any,
) -> Case:
    """A wide plate (mm, MPa) at its critical load."""
    shape: dict[str, Any] = {"rectangle": {"center": [0, 0], "width": width, "height": width}}
    if hole:
        shape["holes"] = [{"disk": {"center": [0, 0], "radius": hole}}]
    rock = {"shape": shape, "material": {"young": 20000, "poisson": 0.2}, "strength": dict(strength)}
    growth = {"steps": 0, "increment": 2, "advance": "all", "criterion": criterion, **growth}
    more = {"supports": "minimal", "loads": loads, "loading": loading, "growth": growth, "numerics": dict(numerics)}
    return case_of({**specimen(dict(cracks), **more), "bodies": {"rock": rock}})


def held(along: float, across: float) -> dict[str, Any]:
    """A pressure along x and across it (MPa), whatever the load factor."""
    return {"far_field": [-along, -across, 0], "held": True}


def critical(case: Case) -> float:
    """The load factor of the first step."""
    step = next(grow(case))
    assert not any("averag" in words or "ill conditioned" in words for words in step.warnings)
    return step.load_factor


# Growth at the toughness, in mode I, by every criterion and under any pressure.


def in_mode_I(criterion: str, lengths: int, along: float) -> float:
    """Largest relative error of the load at which a crack of 60 mm grows, that of K being below 0.1 %.

    A fluid, and the rock across the crack, press by some times the tensile strength, rock along it by `along` times:
    neither has a K. The crack is so many averaging radii long. The plate's width adds 0.15 %.
    """
    tension = MODE_I[criterion] * TOUGHNESS / np.sqrt(2.0 * np.pi * 0.06 / lengths)
    found = []
    for pressure in (0, 2, 10):
        fluid, pull = {"crack": "flaw", "pressure": pressure * tension, "held": True}, {"far_field": [0, 1, 0]}
        loads = [held(along * tension, pressure * tension), fluid, pull]
        strength = {**ROCK, "tension": tension, "cohesion": 1000, "friction_angle": 30}
        case = plate(1200, flaw(30), loads, {"spacing": 40, "refine": {"tips": 5}}, strength, criterion, increment=10)
        state = critically_loaded(assemble(make_scene(case), tuple(map(GrowingCrack.given, case.cracks))), 1.0)
        K = [K for tip in state.tips for K in (tip.K[0], tip.K_growth)]
        np.testing.assert_allclose(K, 1e6 * TOUGHNESS, rtol=1e-3)
        found.append(state.factor * np.sqrt(np.pi * 0.03))
    return float(np.abs(np.array(found) / TOUGHNESS - 1.0).max())


def wings(angle: float, friction: float, criterion: str) -> float:
    """The pressure (MPa) at which wings of a closed flaw of 20 mm start; the plate's width adds 0.6 %."""
    strength, growth = {**ROCK, "tension": 10, "cohesion": 1000, "friction_angle": 30}, {"advance": "most_critical"}
    loads, numerics = [{"far_field": [0, -1, 0]}], {"spacing": 4}
    return critical(plate(200, flaw(10, angle, friction), loads, numerics, strength, criterion, **growth))


def notched(criterion: str) -> float:
    """The pressure (MPa) in a borehole of 10 mm at which its notches of 5 mm grow."""
    points = {"n1": [[8.6603, 5], [12.9904, 7.5]], "n2": [[-8.6603, -5], [-12.9904, -7.5]]}
    cracks = {name: {"path": {"points": p}, "contact": {"friction": 0.6}, "tips": "end"} for name, p in points.items()}
    fluid = [{"on": {"edge": "hole0"}, "pressure": 1}, *({"crack": name, "pressure": 1} for name in points)]
    return critical(plate(400, cracks, [held(5, 10), *fluid], {}, ROCK, criterion, hole=10, increment=4))


def fluid_in(half: float, angle: float, along: float, across: float, width: float, criterion: str = "max_hoop_stress",
             **numerics: Any) -> float:  # fmt: skip
    """The pressure (MPa) in a crack at which it grows."""
    loads = [held(along, across), {"crack": "flaw", "pressure": 1}]
    return critical(plate(width, flaw(half, angle), loads, numerics, ROCK, criterion, increment=25))


def breakdown(major: float, minor: float) -> float:
    """The same (MPa) in closed form for 100 mm at 45 degrees to the stresses S and s (MPa), friction 0.6.

    Open: K_I = (p - sigma_n) sqrt(pi a), K_II = tau sqrt(pi a), and it grows at K_eq = K_Ic (Erdogan, Sih 1963).
    Closed, where p < sigma_n: K_II = (tau - mu (sigma_n - p)) sqrt(pi a), and it grows at K_II = sqrt(3)/2 K_Ic.
    """
    normal, shear, root = 0.5 * (major + minor), 0.5 * (major - minor), np.sqrt(np.pi * 0.05)

    def equivalent(pressure: float) -> float:
        K_I = (pressure - normal) * root
        if K_I <= 0.0:
            return float((shear + 0.6 * (pressure - normal)) * root * 2.0 / np.sqrt(3.0))
        t = -2.0 * np.arctan(2.0 * shear * root / (K_I + np.hypot(K_I, np.sqrt(8.0) * shear * root)))
        return float(np.cos(0.5 * t) * (K_I * np.cos(0.5 * t) ** 2 - 1.5 * shear * root * np.sin(t)))

    return float(brentq(lambda pressure: equivalent(pressure) - TOUGHNESS, 0.0, 30.0))


def _growth() -> Iterator[Row]:
    for criterion, (lengths, along) in product(CRITERIA, ((10, 10), (1000, 0))):
        name, value = f"{criterion}, {lengths} radii, {along} T along", partial(in_mode_I, criterion, lengths, along)
        yield Row(name, "load in mode I", value, 0.0, "K_I = sigma sqrt(pi a)", 0.01)
    flaws = [(30.0, 0.0), (37.5, 0.4), (52.5, 0.2), (60.0, 0.4)]
    for (angle, friction), criterion in (*product(flaws, ["max_hoop_stress"]), *product([(45.0, 0.2)], CRITERIA)):
        c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
        wanted = 0.5 * np.sqrt(3.0) * TOUGHNESS / (np.sqrt(np.pi * 0.01) * (s * c - friction * c * c))
        name, value = f"{angle} degrees, friction {friction}, {criterion}", partial(wings, angle, friction, criterion)
        yield Row(name, "load of a closed flaw [MPa]", value, wanted, "K_eq = 2 K_II / sqrt(3)", 0.01)
    for criterion in CRITERIA:
        value, wanted = partial(fluid_in, 30, 0, 12, 5, 1200, criterion), 5.0 + TOUGHNESS / np.sqrt(np.pi * 0.03)
        yield Row(f"crack, {criterion}", "breakdown pressure [MPa]", value, wanted, "sigma + K_Ic / sqrt(pi a)", 0.01)
    value = partial(notched, "max_hoop_stress")
    yield Row("borehole", "breakdown pressure [MPa]", value, 13.6, "K of notches", 0.01)
    for major, minor in ((6, 5), (8, 4), (15, 5)):
        name, value = f"{major} and {minor} MPa", partial(fluid_in, 50, 45, minor, major, 2400, spacing="auto")
        yield Row(name, "breakdown pressure [MPa]", value, breakdown(major, minor), "Erdogan, Sih 1963", 5e-3)
    for width, length, angle in ((1000, 99, 45), (2000, 104, 135)):
        wanted = 5.0 + TOUGHNESS / np.sqrt(0.5e-3 * np.pi * length)  # faces part all at once: all jumps are round-off
        value = partial(fluid_in, 0.5 * length, angle, 5, 5, width, spacing="auto")
        yield Row(f"{length} mm, {angle} degrees", "breakdown pressure [MPa]", value, wanted, "infinite plate", 0.01)


# In shear, of a closed crack of 20 mm at 45 degrees under uniaxial compression p: K_II = (1 - mu) p/2 sqrt(pi a).


def cohesion_of(radius: float) -> float:
    """The cohesion (MPa) by which a toughness in shear of 1 MPa sqrt(m) stands for a radius (m)."""
    cohesion = 2.0 * TOUGHNESS / float(np.sqrt(2.0 * np.pi * radius))
    assert abs(shear_radius_of(1e6 * cohesion, 1e6 * TOUGHNESS) / radius - 1.0) < 1e-12
    return cohesion


@cache
def in_shear(friction: float, phi: float, part: float, levels: int) -> tuple[float, float]:
    """Pressure (MPa) and K_II (MPa sqrt(m)) where it goes on in shear, straight; its radius is a part of its length."""
    cohesion = cohesion_of(0.02 * part)
    strength = {"tension": 8, "cohesion": cohesion, "friction_angle": phi, "toughness": "3 MPa sqrt(m)",
                "shear_toughness": "1 MPa sqrt(m)"}  # fmt: skip
    loads, numerics = [{"far_field": [0, -1, 0]}], {"spacing": 4, "refine": {"tips": levels}}
    case = plate(300, flaw(10, 45.0, friction), loads, numerics, strength, initiation="ends")
    cracks = tuple(replace(GrowingCrack.given(crack), in_shear=True) for crack in case.cracks)
    found = critically_loaded(assemble(make_scene(case), cracks), 1.0)
    verdicts = [tip.verdict for tip in found.tips if tip.verdict]
    assert [verdict.mode for verdict in verdicts] == ["shear", "shear"]
    assert max(abs(verdict.kink) for verdict in verdicts) < np.deg2rad(1.0) or part > 0.01
    K_II = [1e-6 * abs(tip.K[1]) for tip in found.tips]
    assert abs(K_II[0] / K_II[1] - 1.0) < 0.01
    return found.factor, K_II[0]


def over_pressure(friction: float, phi: float) -> float:
    """K_II of a long crack over K_IIc and what the rock has more of friction than the faces, by the pressure p/2."""
    load, K_II = in_shear(friction, phi, 0.01, 5)
    return K_II / (1.0 + (np.tan(np.deg2rad(phi)) - friction) * 0.5 * load / cohesion_of(2e-4))


def _shear() -> Iterator[Row]:
    quantity, load = "K_II of growth in shear", "load of growth in shear [MPa]"
    for friction, phi in ((0.0, 0.0), (0.3, 16.69924), (0.3, 32.0)):
        value = partial(over_pressure, friction, phi)
        yield Row(f"long, friction {friction}, rock {phi:g} degrees", quantity, value, 1.0, "K_IIc and pressure", 0.01)
    for part in (0.1, 2.0):  # a length R over which stress suffices, and the energy of an advance by R
        value, wanted = partial(shear_part, 1, 16.69924, part, 3), 1.0 / np.sqrt(1.0 + part)
        yield Row(f"R = {part} x 2a", quantity, value, wanted, "K_IIc / sqrt(1 + R / 2a)", 0.01)
    wanted = 2.0 * cohesion_of(0.002) / (0.7 * np.sqrt(11.0) + 0.3 - np.tan(np.deg2rad(32.0)))
    for levels in (0, 2):
        value = partial(shear_part, 0, 32.0, 0.1, levels)
        yield Row(f"cells of {4 / 2**levels:g} mm, R = 2 mm", load, value, wanted, "average of stress over R", 0.01)


def shear_part(which: int, phi: float, part: float, levels: int) -> float:
    """The pressure or K_II of `in_shear` with friction 0.3."""
    return in_shear(0.3, phi, part, levels)[which]


# Factors of safety. A block on a plane at an angle t: F = (c A + mu (W cos t - U)) / (W sin t), U by water.

SLOPE, WEIGHT = np.deg2rad(40.0), 2500.0 * 9.81  # rad, N/m^3

INCLINE = """
title: a block on an incline
plane: strain
bodies:
  wedge: {shape: {polygon: [[0, 0], [8, 0], [8, 4.618802153517006]]}, material: {young: 1e10, poisson: 0.2}}
  block:
    shape: {polygon: [[2.598076, 1.5], [4.330127, 2.5], [3.830127, 3.366025], [2.098076, 2.366025]]}
    material: {young: 1e10, poisson: 0.2, density: 2500}
interfaces: [{between: [wedge, block], contact: {LAW}}]
supports: [{on: {body: wedge, edge: 0}, displacement: {x: 0, y: 0}}]
loads: [{body: block, gravity: [0, -9.81]}]
loading: strength_reduction
numerics: {spacing: 0.5}
"""
LIMIT = (1e4 * 2.0 + 0.4 * 2.0 * WEIGHT * np.cos(np.pi / 6.0)) / (2.0 * WEIGHT * np.sin(np.pi / 6.0))
"""Limit equilibrium of the block with friction 0.4 and a cohesion of 1e4 Pa, all of which acts at once."""

JOINT, TOP = np.array([[0.36397, 1.0], [7.514492, 7.0]]), [[7.514492, 10.0], [3.6397, 10.0]]
"""m: the joint of cases/slope_safety.yaml, and the crest above what slides on it."""

UNIFORM = """
title: a block on a floor under uniform pressure and shear
plane: strain
bodies: {block: {shape: {rectangle: {center: [0, 0.5], width: 2, height: 1}}, material: {young: YOUNG, poisson: 0.25}}}
supports: [{on: {body: block, edge: bottom}, contact: {friction: 0.3, cohesion: 1e4, cohesion_after_slip: AFTER}}]
loads:  # without strain along the floor sxx = nu/(1 - nu) syy
  - {on: {edge: top}, traction: [1e4, -2e4]}
  - {on: {edge: left}, traction: [6666.6666666667, -1e4]}
  - {on: {edge: right}, traction: [-6666.6666666667, 1e4]}
loading: strength_reduction
numerics: {spacing: 0.25, contact: {stiffness: RATIO}}
"""

TANK = """
title: a block of 2 m on a frictional floor below water
units: {length: m, stress: MPa}
plane: strain
bodies:
  rock:
    shape: {rectangle: {center: [0, 1], width: 2, height: 2}}
    material: {young: 1000, poisson: 0.25, density: 2000 kg/m^3}
supports: [{on: {edge: bottom}, contact: {friction: 0.5, cohesion: 0}}]
loads: [{gravity: [0, -10 m/s^2]}, {on: {edge: left}, pressure: "0.01*(WATER - y)"}]
loading: strength_reduction
numerics: {spacing: 0.25}
"""

SLAB = """
title: a slab hangs under a roof
plane: strain
units: {length: m, stress: MPa}
materials: {rock: {young: 20000, poisson: 0, density: 2600}}
bodies:
  roof: {shape: {rectangle: {center: [0, 1], width: 4, height: 2}}, material: rock}
  slab: {shape: {rectangle: {center: [0, -0.5], width: 4, height: 1}}, material: rock}
interfaces: [{between: [roof, slab], contact: {friction: 0.5, cohesion: 0.1, tension: 0.1}}]
supports: [{on: {body: roof, edge: top}, displacement: {x: 0, y: 0}}]
loads: [{body: slab, gravity: [0, "-9.81 m/s^2"]}]
loading: strength_reduction
numerics: {spacing: 0.5}
"""


def safety_of(text: str, **words: object) -> Safety:
    """What strength reduction finds of a scene with words in it replaced."""
    end = whole_run(case_of(text, **words))[1]
    assert end.safety is not None
    return end.safety


def factor(text: str, mechanism: str, words: Mapping[str, object]) -> float:
    """The factor of safety, of a mechanism that is told in such words."""
    safety = safety_of(text, **words)
    assert mechanism in safety.mechanism
    return safety.factor


def of_slope(law: str, pressure: str) -> float:
    """The same of the shipped slope, whose joint has a law and a pressure of water."""
    settings = [*QUIET, f"cracks.joint.contact={{{law}}}", f"loads.1.pressure={pressure}"]
    safety = whole_run(shipped_case("slope_safety", settings))[1].safety
    assert safety is not None
    assert "it slides along 'joint'" in safety.mechanism
    return safety.factor


def _safety() -> Iterator[Row]:
    weight = WEIGHT * shapely.Polygon([*JOINT, *TOP]).area
    length = float(np.hypot(*(JOINT[1] - JOINT[0])))
    slopes = {
        "a slope with friction": ("friction: 0.9, cohesion: 0", 0.9, 0.0, "0", 0.0),
        "with water": ("friction: 0.9, cohesion: 0", 0.9, 0.0, "10 kPa", 1e4),
        "with water of a triangle": ("friction: 0.9, cohesion: 0", 0.9, 0.0, "0.00981*min(y - 1, 7 - y)", 9810.0 * 1.5),
        "with cohesion": ("friction: 0.6, cohesion: 0.01, cohesion_after_slip: kept", 0.6, 1e4, "0", 0.0),
    }
    for name, (law, friction, cohesion, pressure, water) in slopes.items():
        holds = cohesion * length + friction * (weight * np.cos(SLOPE) - water * length)
        value, wanted = partial(of_slope, law, pressure), holds / (weight * np.sin(SLOPE))
        yield Row(name, "factor of safety", value, wanted, "limit equilibrium", 2e-3)
    found: list[tuple[str, str, str, dict[str, object], float]] = []
    for young, ratio, after in (("1e9", "rigid", "lost"), ("1e9", "1", "kept"), ("1e13", "1e-3", "lost")):
        words = {"YOUNG": young, "RATIO": ratio, "AFTER": after}
        name = f"uniform shear, {', '.join(map(str, words.values()))}"
        found.append((name, UNIFORM, "slides along 'block.bottom'", words, (1e4 + 0.3 * 2e4) / 1e4))
    for more in ("cohesion_after_slip: kept", "weakening_length: 10"):
        words = {"LAW": f"friction: 0.4, cohesion: 1e4, {more}"}
        found.append((f"incline, {more}", INCLINE, "slides along 'wedge/block'", words, LIMIT))
    for name, text, mechanism, words, wanted in found:
        yield Row(name, "factor of safety", partial(factor, text, mechanism, words), wanted, "limit equilibrium", 2e-3)
    for water in (2.0, 2.5):  # mu W / P, with W = 80 kN/m and P = gamma (2 water - 2), gamma = 10 kN/m^3
        value, wanted = partial(factor, TANK, "slides", {"WATER": water}), 40.0 / (10.0 * (2.0 * water - 2.0))
        yield Row(f"water of {water} m", "factor of safety", value, wanted, "limit equilibrium", 1e-3)
    value = partial(factor, SLAB, "slab", {})
    yield Row("a slab below a roof", "factor of safety", value, 0.1e6 / (2600 * 9.81), "tensile strength", 1e-3)


BEAMS = """
title: two beams of 10 mm that are pulled apart
units: {length: mm, stress: MPa}
plane: strain
materials: {rock: {young: 20 GPa, poisson: 0.25}}
bodies:
  upper: {shape: {polygon: [[0, 0], [120, 0], [120, 10], [0, 10]]}, material: rock}
  lower: {shape: {polygon: [[0, -10], [120, -10], [120, 0], [0, 0]]}, material: rock}
interfaces:
  - {between: [upper, lower], contact: {friction: 0, cohesion: 0}, cracked: [[0, 0], [30, 0]], toughness: 50 J/m^2}
supports: minimal
loads: [{on: {body: upper, edge: 3}, traction: [0, 1]}, {on: {body: lower, edge: 3}, traction: [0, -1]}]
loading: critical
growth: {steps: 2, increment: 10, criterion: max_hoop_stress}
numerics: {accuracy: standard}
"""


@cache
def parted_beam() -> list[tuple[float, float]]:
    """The length (m) of the crack and the load factor of each step."""
    return [(result.interface_tips[0].length, result.load_factor) for result in grow(case_of(BEAMS))]


def ratio_at_bond() -> float:
    """G of an increment along the bond over that of one straight on, by the loads at which a crack goes by each."""
    shares = 0.24, 0.28  # of the toughness of the rock: with less it turns, with more it crosses
    runs = [whole_run(crack_at_bond(f"interfaces.0.toughness={share * ROCK_TOUGHNESS}"))[0] for share in shares]
    assert [run[1].events[0].kind for run in runs] == ["deflection", "crossing"]
    along, across = (run[0].load_factor for run in runs)
    return float(shares[0] * (across / along) ** 2)


def _along_interfaces() -> Iterator[Row]:
    """Critical loads P of beams of a height h: G_c = 12 (P a)^2 / (E' h^3) (1 + 0.677 h / a)^2."""
    source, high, modulus = "beams with the rotation at the root (Suo, Bao, Fan 1992)", 0.01, 20e9 / (1.0 - 0.25**2)
    for step in range(3):
        a = 0.03 + 0.01 * step
        wanted = np.sqrt(50.0 * modulus * high**3 / 12.0) / (a + 0.677 * high) / (1e6 * high)
        name = f"double cantilever beam after {step} increments"
        yield Row(name, "load factor", partial(lambda n: parted_beam()[n][1], step), wanted, source, 3e-3)
        yield Row(name, "length of the crack [m]", partial(lambda n: parted_beam()[n][0], step), a, "itself", 1e-9)
    source = "He, Hutchinson 1989, equal bodies"
    yield Row("a crack at right angles to a bond", "G along it over G straight on", ratio_at_bond, 0.26, source, 3e-2)


@pytest.mark.parametrize("row", parameters(_growth(), _shear(), _safety(), _along_interfaces()))
def test_value_is_within_its_tolerance(row: Row, record_property: Record) -> None:
    row.check(record_property)
