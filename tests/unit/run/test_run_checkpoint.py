"""A run that goes on from a checkpoint is the whole run."""

from __future__ import annotations

import json
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest

from crackgrow.case.model import Case
from crackgrow.run.result import Checkpoint
from tests.crack_at_bond import crack_at_bond
from tests.scenes import CYCLES, SHORTER, shipped_case, slow_cracks
from tests.solving import whole_run

COARSE = ("numerics.spacing=3", "output.frames=none", "output.figures=false")
FRICTION = "cracks.flaw.contact.friction=0.3"
IMPLICIT = "growth.direction=implicit"
LOADED = "growth.unload_between_steps=false"
AIM = ("numerics.accuracy=3 %", "numerics.spacing=auto", "growth.steps=2", FRICTION)
FACING = "cracks={a: {path: [[-11, 0], [-3, 0]], contact: none}, b: {path: [[0, 0], [8, 0]], contact: none}}"
POINTS = "output.points={mouth: {crack: flaw, at: [0, 0]}}"
STARTS = ("growth.initiation.at=cracks", "bodies.rock.strength.cohesion=0.6", "growth.advance=all", LOADED)
CYCLE = "loading.history=[0.4, 1, 0.7, -0.3, -1, -0.8, 0.6]"
BLOCK = "loading.history=[0.3, 1.0, 0.1, 0.5]"
ALONG = "growth={steps: 3, increment: 5, criterion: max_hoop_stress, unload_between_steps: false}"
SCENES = {
    "unloaded between steps": ("compression30", "growth.steps=3", FRICTION),
    "history in every step": ("compression30", "growth.steps=2", FRICTION, "loading.history=[0.5, -0.2, 1.0]"),
    "implicit direction": ("compression30", "growth.steps=2", "growth.criterion=max_hoop_stress", IMPLICIT),
    "cracks that start": ("compression30", "growth.steps=3", FRICTION, *STARTS),
    "a target, loaded throughout": ("compression30", *AIM, LOADED, POINTS),
    "critical load": ("flaw_and_hole", "growth.steps=3"),
    "all tips, meeting": ("tension0", FACING, "growth.steps=3", "growth.advance=all"),
    "cyclic friction": ("cyclic_friction", "numerics.spacing=10", CYCLE),
    "subcritical, a tip that waits": ("slow_cracks", SHORTER),
    "cycles": ("slow_cracks", SHORTER, *CYCLES),
    "block on a foundation": ("block_rigid", "numerics.spacing=0.5", BLOCK),
    "stages": ("tunnel_excavated", "numerics.spacing=2", "output.points={}"),
    "interface that parts": ("17_interface", "interfaces.0.toughness=1", ALONG, "numerics.accuracy=draft"),
    "cracks that cross a bond": ("crack_at_bond", "interfaces.0.toughness=14"),
    "cracks that turn along a bond": ("crack_at_bond", "loading={history: [4]}", LOADED),
    "interface": ("interface_friction04", "numerics.spacing=0.2", BLOCK),
}


def scene(name: str) -> Case:
    file, *settings = SCENES[name]
    if file in ("slow_cracks", "crack_at_bond"):
        return {"slow_cracks": slow_cracks, "crack_at_bond": crack_at_bond}[file](*settings)
    coarse = COARSE[1:] if any("spacing" in setting for setting in settings) else COARSE
    return shipped_case(file, [*coarse, *settings])


def stored(checkpoint: Checkpoint | None) -> Checkpoint:
    """The checkpoint as it comes back from files."""
    assert checkpoint is not None
    arrays = {name: array.copy() for name, array in checkpoint.arrays.items()}
    return Checkpoint(checkpoint.step, json.loads(json.dumps(checkpoint.values)), arrays)


def assert_same(one: Any, other: Any, where: str) -> None:
    """Everything but times is equal, floats bit by bit."""
    if where.endswith(".seconds"):
        return
    if is_dataclass(one):
        for part in fields(one):
            assert_same(getattr(one, part.name), getattr(other, part.name), f"{where}.{part.name}")
    elif isinstance(one, tuple | list):
        assert len(one) == len(other), where
        for number, (a, b) in enumerate(zip(one, other, strict=True)):
            assert_same(a, b, f"{where}[{number}]")
    elif isinstance(one, dict):
        assert list(one) == list(other), where
        for key, value in one.items():
            assert_same(value, other[key], f"{where}[{key}]")
    else:
        np.testing.assert_array_equal(one, other, err_msg=where)


@pytest.mark.parametrize("name", SCENES)
def test_steps_can_be_gone_on_from(name: str) -> None:
    case = scene(name)
    results, end = whole_run(case)
    assert len(results) > 2
    again, same_end = whole_run(case, stored(results[-2].checkpoint))
    assert_same(results[-2:], again, name)
    assert_same(end, same_end, f"{name}, end")
