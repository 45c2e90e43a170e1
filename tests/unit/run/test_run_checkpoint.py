"""A run that goes on from a checkpoint is the whole run; growth by either way to the compliance of contact."""

from __future__ import annotations

import json
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case.load import read_case
from crackgrow.case.model import Case
from crackgrow.contact import system as contact_system
from crackgrow.run import grow
from crackgrow.run.result import Checkpoint
from tests.scenes import shipped_case, specimen
from tests.slow_cracks import CYCLES, SHORTER, slow_cracks
from tests.whole_run import whole_run

COARSE = ("numerics.spacing=3", "output.frames=none", "output.figures=false")


FRICTION = "cracks.flaw.contact.friction=0.3"


SCENES = {
    "unloaded between steps": ("compression30", "growth.steps=3", FRICTION),
    "loaded throughout": ("compression30", "growth.steps=3", FRICTION, "growth.unload_between_steps=false"),
    "history in every step": ("compression30", "growth.steps=2", FRICTION, "loading.history=[0.5, -0.2, 1.0]"),
    "implicit direction": (
        "compression30",
        "growth.steps=2",
        "growth.criterion=max_hoop_stress",
        "growth.direction=implicit",
    ),
    "cracks that start": (
        "compression30",
        "growth.steps=3",
        FRICTION,
        "growth.initiation.at=cracks",
        "bodies.rock.strength.cohesion=0.6",
        "growth.advance=all",
        "growth.unload_between_steps=false",
    ),
    "a target": ("compression30", "numerics.accuracy=3 %", "numerics.spacing=auto", "growth.steps=2", FRICTION),
    "a target, loaded throughout": (
        "compression30",
        "numerics.accuracy=3 %",
        "numerics.spacing=auto",
        "growth.steps=2",
        FRICTION,
        "growth.unload_between_steps=false",
    ),
    "critical load": ("flaw_and_hole", "growth.steps=3"),
    "all tips, meeting": ("two_flaws", "growth.steps=11"),  # an inner wing meets the other flaw in the tenth
    "cyclic friction": ("cyclic_friction", "numerics.spacing=10", "loading.history=[0.4, 1, 0.7, -0.3, -1, -0.8, 0.6]"),
    "subcritical, a tip that waits": ("slow_cracks", SHORTER),
    "cycles": ("slow_cracks", SHORTER, *CYCLES),
    "block on a foundation": ("block_rigid", "numerics.spacing=0.5", "loading.history=[0.3, 1.0, 0.1, 0.5]"),
    "stages": ("tunnel_excavated", "numerics.spacing=1.5", "output.points={}"),
    "interface": ("interface_friction04", "numerics.spacing=0.2", "loading.history=[0.3, 1.0, 0.1, 0.5]"),
}


def scene(name: str) -> Case:
    file, *settings = SCENES[name]
    if file == "slow_cracks":
        return slow_cracks(*settings)
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
def test_every_step_can_be_gone_on_from(name: str) -> None:
    case = scene(name)
    results, end = whole_run(case)
    assert len(results) > 2
    for number, result in list(enumerate(results))[-4:]:
        again, same_end = whole_run(case, stored(result.checkpoint))
        assert_same(results[number:], again, f"{name}, from {number}")
        assert_same(end, same_end, f"{name}, end from {number}")


CRACKS = {  # the first two meet, the third ends on the fourth, the last two are far away
    "left": {"center": [-20, 0], "length": 9, "angle": 0},
    "right": {"center": [-8, 0.5], "length": 9, "angle": 0},
    "short": {"center": [14, 0], "length": 9, "angle": 0},
    "wall": {"center": [21, 0], "length": 8, "angle": 90},
    "above": {"center": [-12, 24], "length": 10, "angle": 60},
    "below": {"center": [12, -24], "length": 10, "angle": 75},
}


def six_flaws(*overrides: str) -> Case:
    """A plate pulled along y, with six flaws of which those in the middle grow."""
    law = {"friction": 0.3, "cohesion": 0.0}
    cracks = {
        name: {"path": path, "contact": dict(law), "tips": "none" if name == "wall" else "both"}
        for name, path in CRACKS.items()
    }
    growth = {
        "steps": 4,
        "increment": 2,
        "advance": "most_critical",
        "criterion": "max_hoop_stress",
        "tip_stress": {"radius": 1},
    }
    document = specimen(cracks, (60.0, 70.0), growth=growth, numerics={"spacing": 2})
    return read_case(yaml.safe_dump(document), "plate", "plate", overrides)


def test_growth_is_the_same_by_elimination_as_by_displacements_per_unit_traction(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Tips of six flaws grow and meet other cracks: the compliance of contact is found by either way."""
    case = six_flaws("growth.advance=all", "growth.steps=4")
    results = list(grow(case))
    assert sum(len(result.events) for result in results) >= 1
    monkeypatch.setattr(contact_system, "FEW_NUMBERS", 0)
    for result, other in zip(results, grow(case), strict=True):
        K, other_K = ([(tip.K_I, tip.K_II, tip.criticality) for tip in step.tips] for step in (result, other))
        np.testing.assert_allclose(K, other_K, rtol=1e-8)  # nan where there is no room for an integral
        np.testing.assert_array_equal(result.contact.state, other.contact.state)
        size = np.abs(other.contact.slip).max()
        np.testing.assert_allclose(result.contact.slip, other.contact.slip, rtol=0, atol=1e-8 * size)
