"""Cracks that stick: their K is zero, and is told as that, not with an error in per cent of what cells leave of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.results.log import told_line
from crackgrow.results.summary import K_error
from crackgrow.run import grow
from crackgrow.run.result import STICK
from tests.scenes import shipped_case

NETWORK = """
title: zigzag joints that cross in pressed rock
units: {length: mm, stress: MPa}
plane: strain
bodies:
  rock: {shape: {rectangle: {center: [0, 0], width: 100, height: 100}}, material: {young: 30 GPa, poisson: 0.25}}
cracks:
  a: {path: {points: [[-25, -5], [-18, 0], [-11, -5], [-4, 0], [3, -5], [10, 0], [17, -5], [24, 0]]}, contact: LAW}
  b: {path: {points: [[-22, 8], [-15, 3], [-8, 8], [-1, 3], [6, 8], [13, 3], [20, 8], [27, 3]]}, contact: LAW}
  c: {path: {points: [[0, -20], [3, 0.5], [-2, 25]]}, contact: LAW}
supports: minimal
loads:
  - {on: {edge: top}, traction: [0, -20]}
  - {on: {edge: bottom}, traction: [0, 20]}
  - {on: {edge: left}, traction: [5, 0]}
  - {on: {edge: right}, traction: [-5, 0]}
numerics: {accuracy: draft}
output: {frames: none, figures: false}
"""


@pytest.mark.parametrize(("friction", "sticks"), [(5.0, True), (0.2, False)])
def test_a_kinked_network_that_sticks_is_told_to(friction: float, sticks: bool, tmp_path: Path) -> None:
    """Uniform stress goes through it; what cells leave is 31 kPa sqrt(m), and the bounds of that were 6300 % of it."""
    path = tmp_path / "network.yaml"
    path.write_text(NETWORK.replace("LAW", f"{{friction: {friction}, cohesion: 0}}"), encoding="utf-8")
    case = load_case(path)
    step = next(grow(case))
    assert [tip.sticks for tip in step.tips] == [sticks] * 6
    assert np.isnan(K_error(step)) == sticks
    assert (" sticks, cracks " in told_line(step, case, 0.0)) == sticks
    assert ("K_I" in told_line(step, case, 0.0)) != sticks


def test_a_crack_that_sticks_after_it_has_slipped_has_its_K() -> None:
    settings = ["loading={history: [1, 0.9]}", "output.frames=none", "output.figures=false"]
    slipped, back = grow(shipped_case("cyclic_friction", settings))
    assert (back.contact.state == STICK).all()
    assert not any(tip.sticks for tip in (*slipped.tips, *back.tips))
    assert np.isfinite(K_error(back))
