"""Tensile cracks of specimens that were tested in laboratories: kinks, paths and holes that cracks meet.

What was measured is as it is quoted in the literature. Sheets and beams are of acrylic glass, the shear
beam is of concrete.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
import pytest

from crackgrow.run.result import CrackPath, RunEnd, StepResult
from tests.solving import whole_run
from tests.verification.solutions import case_of
from tests.verification.table import Record, Row, parameters

INCH = 25.4  # mm
HEAD = """
title: a specimen
units: {length: mm, stress: MPa}
plane: stress
loading: critical
numerics: {accuracy: draft}
"""
PMMA = """
    material: {young: 3000, poisson: 0.35}
    strength: {tension: 70, cohesion: 100, friction_angle: 0, toughness: 1 MPa sqrt(m)}
"""

SLANTED = f"""{HEAD}
bodies:
  sheet:
    shape: {{rectangle: {{center: [0, 0], width: 229, height: 457}}}}{PMMA}
cracks:
  crack: {{path: {{center: [0, 0], length: 50.8, angle: ANGLE}}, contact: none}}
supports: minimal
loads:
  - {{on: {{body: sheet, edge: top}}, traction: [0, 1]}}
  - {{on: {{body: sheet, edge: bottom}}, traction: [0, -1]}}
growth: {{steps: 1, increment: 2, criterion: max_hoop_stress, direction: explicit}}
"""
KINKS = {30: 62.4, 40: 55.6, 50: 51.1, 60: 43.1, 70: 30.7, 80: 17.3}
"""Degrees, by the angle between crack and load."""


THREE_HOLES = f"""{HEAD}
bodies:
  beam:
    shape:
      rectangle: {{center: [0, 101.6], width: 508, height: 203.2}}
      holes:
        - disk: {{center: [-101.6, 69.85], radius: 6.35}}
        - disk: {{center: [-101.6, 120.65], radius: 6.35}}
        - disk: {{center: [-101.6, 171.45], radius: 6.35}}{PMMA}
cracks:
  notch: {{path: {{points: [[{-6 * INCH}, 0], [{-6 * INCH}, {INCH}]]}}, contact: none, tips: end}}
supports:
  - {{at: [-228.6, 0], displacement: {{x: 0, y: 0}}}}
  - {{at: [228.6, 0], displacement: {{y: 0}}}}
loads: [{{at: [0, 203.2], force: [0, -1 kN/m]}}]
growth: {{steps: 60, increment: 6, criterion: max_hoop_stress}}
"""

SHEAR_BEAM = f"""{HEAD}
bodies:
  beam:
    shape: {{rectangle: {{center: [661, 153], width: 1322, height: 306}}}}
    material: {{young: 24800, poisson: 0.18}}
    strength: {{tension: 3, cohesion: 100, friction_angle: 0, toughness: 1.57 MPa sqrt(m)}}
cracks:
  notch: {{path: {{points: [[661, 0], [661, 82]]}}, contact: none, tips: end}}
supports:
  - {{at: [600, 0], displacement: {{x: 0, y: 0}}}}
  - {{at: [1119, 0], displacement: {{y: 0}}}}
loads:
  - {{at: [203, 306], force: [0, -0.13 kN/mm]}}
  - {{at: [722, 306], force: [0, -1 kN/mm]}}
growth: {{steps: 60, increment: 10, criterion: max_hoop_stress}}
"""

ROUND = [[float(50.0 * np.cos(t)), float(50.0 * np.sin(t))] for t in np.linspace(0.0, np.pi, 61)]
HALF_DISK = f"""{HEAD}
bodies:
  half:
    shape: {{polygon: {ROUND}}}{PMMA}
cracks:
  notch: {{path: {{points: [[0, 0], [ACROSS, UP]]}}, contact: none, tips: end}}
supports:
  - {{at: [-SPAN, 0], displacement: {{x: 0, y: 0}}}}
  - {{at: [SPAN, 0], displacement: {{y: 0}}}}
loads: [{{at: [0, 50], force: [0, -1 kN/mm]}}]
growth: {{steps: STEPS, increment: 2, criterion: max_hoop_stress}}
"""


@cache
def grown(text: str, **words: float) -> tuple[CrackPath, ...]:
    """The cracks at the end of a run."""
    return whole_run(case_of(text, **words))[1].cracks


def kink(angle: int) -> float:
    """Degrees by which the end of a crack at an angle to the load turns."""
    old, new = np.diff(grown(SLANTED, ANGLE=90 - angle)[0].points[-3:], axis=0)
    return float(abs(np.rad2deg(np.arctan2(old[0] * new[1] - old[1] * new[0], old @ new))))


def from_middle_hole() -> float:
    """Distance (mm) of the end of the crack from the rim of the middle hole."""
    return float(abs(np.hypot(*(1e3 * grown(THREE_HOLES)[0].points[-1] - [-101.6, 120.65])) - 6.35))


def beyond_the_force() -> float:
    """By how much (mm) beyond the larger force the crack leaves the beam at its top."""
    x, y = 1e3 * grown(SHEAR_BEAM)[0].points[-1]
    assert y > 305.9
    return float(x - 722.0)


def bent(degrees: float, span: float, steps: int) -> tuple[list[StepResult], RunEnd]:
    """A semi-circular bend specimen with a notch of 25 mm, degrees from the load, on rollers at +- span (mm)."""
    across, up = 25.0 * np.sin(np.deg2rad(degrees)), 25.0 * np.cos(np.deg2rad(degrees))
    return whole_run(case_of(HALF_DISK, ACROSS=across, UP=up, SPAN=span, STEPS=steps))


def bend_factor() -> float:
    """K_I over P sqrt(pi a) / (2 R), with rollers at half the radius."""
    (step,), _ = bent(0.0, 25.0, 0)
    return step.tips[0].K_I / (step.load_factor * 1e6 * np.sqrt(np.pi * 0.025) / 0.1)


def beside_the_load(degrees: float) -> float:
    """Where the crack leaves the half disk, from the load, over the radius."""
    end = bent(degrees, 21.5, 25)[1].cracks[0].points[-1]
    assert np.hypot(*end) > 0.0498
    return float(np.hypot(*(end - [0.0, 0.05])) / 0.05)


def _rows() -> Iterator[Row]:
    for angle, measured in KINKS.items():
        name = f"slanted crack, {angle} degrees to the load"
        yield Row(name, "kink [degrees]", partial(kink, angle), measured, "Erdogan, Sih 1963", 3.0, "absolute")
    source = "Ingraffea, Grigoriu 1990"
    yield Row("beam with three holes", "end from the middle hole [mm]", from_middle_hole, 0.0, source, 1e-3)
    source = "Arrea, Ingraffea 1982"
    name, quantity = "four-point shear beam", "end beyond the force [mm]"
    yield Row(name, quantity, beyond_the_force, 0.0, source, 0.0, "at least", slow=True)
    name, source = "semi-circular bend", "Kuruppu et al. 2014 (ISRM), a fit"
    yield Row(f"{name}, straight notch", "K_I / (P sqrt(pi a) / 2R)", bend_factor, 3.680, source, 0.02)
    for degrees in (20.0, 40.0):
        value, source = partial(beside_the_load, degrees), "Ayatollahi, Aliha 2006: to the load"
        yield Row(
            f"{name}, notch at {degrees:g} degrees", "end from the load, over R", value, 0.1, source, 0.0, "at most"
        )


@pytest.mark.parametrize("row", parameters(_rows()))
def test_value_is_within_its_tolerance(row: Row, record_property: Record) -> None:
    row.check(record_property)
