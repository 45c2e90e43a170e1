"""A flat, stiff block on a joint, that moves as one: what the joint does is a closed form of how it is moved."""

from __future__ import annotations

from crackgrow.run.result import StepResult
from tests.verification.solutions import case_of
from tests.whole_run import whole_run

WIDTH, HEIGHT, SHEAR, NORMAL = 0.1, 0.002, 1e10, 1e12  # m, m, Pa/m, Pa/m
SOFT = "stiffness: {normal: 1e12, shear: 1e10}"

BLOCK = """
title: a flat, stiff block, sheared
plane: stress
bodies:
  top: {shape: {rectangle: {center: [0, 0.001], width: 0.1, height: 0.002}}, material: {young: 1e14, poisson: 0}}
supports:
  - {on: {body: top, edge: bottom}, contact: {LAW}}
  - {on: {body: top, edge: top}, displacement: {MOVED}}
loads: [{on: {body: top, edge: top}, traction: [0, -PRESSURE], held: true}]
numerics: {spacing: 0.001, contact: {spacing: 4}}
output: {points: {joint: {at: [0, 0.002]}}}
"""


def sheared(law: str, moved: str, *settings: str, pressure: float = 2e6) -> list[StepResult]:
    """The steps of the block on a joint with a law, its top moved so far (m) and pressed by a pressure (Pa)."""
    return whole_run(case_of(BLOCK, *settings, LAW=law, MOVED=moved, PRESSURE=pressure))[0]
