"""Loads that take each other back: nothing is left of them, neither stress nor states of contact."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.run.loop import grow
from crackgrow.run.result import StepResult

SCENE = """
title: a block on rock with a flaw
plane: strain
bodies:
  rock: {shape: {rectangle: {center: [0, 0], width: 2, height: 2}}, material: {young: 1e10, poisson: 0.25}}
  block: {shape: {rectangle: {center: [0, 1.25], width: 0.6, height: 0.5}}, material: {young: 1e10, poisson: 0.25}}
cracks: {flaw: {path: {center: [0, 0], length: 0.7, angle: 35}, contact: {friction: FRICTION, cohesion: 0}}}
interfaces: [{between: [rock, block], contact: {friction: FRICTION, cohesion: 0}}]
supports: [{on: {body: rock, edge: bottom}, displacement: {x: 0, y: 0}}]
loads:
  - {on: {body: block, edge: top}, traction: [3.1e5, -3.1e6], name: down}
  - {on: {body: block, edge: top}, traction: [-1.55e5, 1.55e6], name: up}
  - {on: {body: rock, edge: left}, traction: [PUSH, 0], name: push}
  - {on: {body: rock, edge: left}, traction: [PULL, 0], name: pull}
loading: {stages: [STAGES]}
numerics: {spacing: 0.25}
output: {frames: none, figures: false}
"""


def solved(folder: Path, stages: list[str], friction: float = 0.5, push: float = 2.3e6) -> list[StepResult]:
    text = SCENE.replace("STAGES", ", ".join(stages)).replace("FRICTION", str(friction))
    path = folder / "scene.yaml"
    path.write_text(text.replace("PUSH", repr(push)).replace("PULL", repr(push / 3.0)), encoding="utf-8")
    return list(grow(load_case(path)))


def stage(down: float, up: float, push: float, pull: float) -> str:
    return f"{{loads: {{down: {down!r}, up: {up!r}, push: {push!r}, pull: {pull!r}}}}}"


@pytest.mark.parametrize("seed", range(6))
def test_loads_that_cancel_all_through_stages_leave_nothing(seed: int, tmp_path: Path) -> None:
    """Tractions of 1e-10 Pa, and the states of points that go with them, are what round-off of the sums makes."""
    random = np.random.default_rng(seed)
    sizes, push = random.uniform(0.3, 1.5, (2, 2)).tolist(), float(random.uniform(1e6, 5e6))
    stages = [stage(down, 2.0 * down, push_, -3.0 * push_) for down, push_ in sizes]
    for step in solved(tmp_path, stages, push=push):
        assert np.abs(step.contact.normal_traction).max() == np.abs(step.contact.tangential_traction).max() == 0.0
        assert (step.contact.state == 0).all()
        assert np.abs(step.contact.slip).max() == 0.0


def test_loads_that_cancel_in_one_part_leave_the_others_as_they_are(tmp_path: Path) -> None:
    """A push and a pull of the rock that cancel beside a load on the block: as if they were not there."""
    (alone,) = solved(tmp_path, [stage(1.0, 0.0, 0.0, 0.0)])
    (both,) = solved(tmp_path, [stage(1.0, 0.0, 0.7, -2.1)])
    size = np.abs(alone.contact.normal_traction).max()
    np.testing.assert_allclose(both.contact.normal_traction, alone.contact.normal_traction, atol=1e-12 * size)
    np.testing.assert_array_equal(both.contact.state, alone.contact.state)


@pytest.mark.parametrize("friction", [0.12, 0.15, 0.2, 0.3])
@pytest.mark.parametrize("last", [stage(0.0, 0.0, 0.0, 0.0), stage(0.7, 1.4, 0.0, 0.0)], ids=["off", "taken back"])
def test_a_block_that_slid_lies_free_when_its_loads_go(friction: float, last: str, tmp_path: Path) -> None:
    loaded, unloaded = solved(tmp_path, [stage(1.0, 0.0, 0.0, 0.0), last], friction)
    assert np.abs(unloaded.contact.normal_traction).max() < 1e-12 * np.abs(loaded.contact.normal_traction).max()
    assert np.isfinite(unloaded.contact.slip).all()
