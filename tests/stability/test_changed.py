"""A scene that is written otherwise gives the same: one list of changes, 1 to 1e12 Pa and 1 um to 10 km, one of scenes.

The cases are read as mappings: what the reader does to numbers is part of it.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from crackgrow.case.model import Case
from crackgrow.run.result import StepResult
from tests.scenes import shipped_case
from tests.stability.changed import CHANGES, Change, Scene, deviations, outcome
from tests.stability.growing_scenes import growing_scene

SAME = 1e-8
"""Relative, where nothing but the scales of numbers changes."""
TOLERANCE = 1e-6
"""Relative, where the lattice lies otherwise in the scene, and rounds otherwise."""
YOUNG, WIDTH, STRESS = 10e9, 31e-3, 100e6  # of the flaw as it is: Pa, m, Pa
SCALES = {
    "1 Pa": Change("", young=1.0 / YOUNG),
    "1e12 Pa": Change("", young=1e12 / YOUNG),
    "1 um": Change("", size=1e-6 / WIDTH),
    "10 km": Change("", size=1e4 / WIDTH),
    "load 1e-6 Pa": Change("", stress=1e-6 / STRESS),
    "load 1e9 Pa": Change("", stress=1e9 / STRESS),
    "soft, large, much load": Change("", size=1e4 / WIDTH, stress=1e9 / STRESS, young=1.0 / YOUNG),
    "stiff, small, little load": Change("", size=1e-6 / WIDTH, stress=1e-6 / STRESS, young=1e12 / YOUNG),
}
MOVED = {
    **{name: CHANGES[name] for name in ("turned by 90 degrees", "mirrored")},
    "turned by 180 degrees": Change("", -np.eye(2)),
    "moved": Change("", shift=(3.0, -2.0)),
}
TOGETHER = ("soft, large, much load", "stiff, small, little load")
COARSE = ("numerics.spacing=3", "growth.steps=2", "growth.tip_stress.radius=2")
FRICTION = "cracks.flaw.contact.friction=0.3"
FLAW: dict[str, tuple[str, ...]] = {
    "frictionless": (),
    "friction": (FRICTION, "growth.criterion=strength"),
    "cohesion": (FRICTION, "cracks.flaw.contact.cohesion=10", "cracks.flaw.contact.cohesion_after_slip=kept"),
    "elastic contact": (FRICTION, "numerics.contact={stiffness: 1000, discretization: gauss}"),
    "lemke": (FRICTION, "numerics.contact.solver=lemke"),
    "implicit": ("growth.criterion=max_hoop_stress", "growth.direction=implicit"),
    "load stays": (FRICTION, "growth.unload_between_steps=false"),
    "critical load": (FRICTION, "loading=critical"),
}
"""compression30 in coarse cells, two steps of growth."""
OTHERS: dict[str, tuple[str, ...]] = {
    "block_foundation": ("numerics.spacing=0.4",),  # held by contact alone
    "block_rigid": (),
    "interface_friction04": ("numerics.spacing=0.11",),  # displacements by a formula
    "cyclic_friction": ("loading.history=[1, 0.5, -0.3]", "numerics.spacing=5"),
    "junction_static": ("numerics.support=2", "numerics.spacing=1.7"),
}
"""In cells whose lines do not lie on outlines: there round-off decides where the lattice begins."""


LOOSE = ("jumps", "states", "energy", "displacement", "tractions")


def document(name: str) -> Scene:
    settings = (*COARSE, *FLAW[name]) if name in FLAW else OTHERS[name]
    file = "compression30" if name in FLAW else name
    return shipped_case(file, settings).to_dict()


@cache
def plain(name: str) -> tuple[Scene, list[StepResult]]:
    scene = document(name)
    steps, error = outcome(scene)
    assert not error
    assert len(steps) == (3 if name in (*FLAW, "cyclic_friction") else 1)
    return scene, steps


def off(name: str, change: Change) -> dict[str, float]:
    scene, first = plain(name)
    steps, error = outcome(change.apply(scene))
    assert not error
    return deviations(scene, first, steps, change)


@pytest.mark.parametrize(
    ("name", "scale"),
    [
        *(("friction", scale) for scale in SCALES),
        *((name, scale) for name in OTHERS for scale in TOGETHER),
        *(
            pytest.param(name, scale, marks=pytest.mark.slow)
            for name in FLAW
            if name != "friction"
            for scale in TOGETHER
        ),
    ],
)
def test_over_its_units_a_scene_is_the_same(name: str, scale: str) -> None:
    found = off(name, SCALES[scale])
    assert max(found.values()) < SAME, found


@pytest.mark.parametrize("change", {**MOVED, **CHANGES})
@pytest.mark.parametrize("name", ["friction", *OTHERS])
def test_a_scene_that_is_written_otherwise_is_the_same(name: str, change: str) -> None:
    found = off(name, {**MOVED, **CHANGES}[change])
    assert max(found.values()) < TOLERANCE, found


def test_other_loads_are_seen() -> None:
    scene, first = plain("friction")
    doubled = Change("", stress=2.0).apply(scene)
    assert deviations(scene, first, outcome(doubled)[0], Change(""))["K"] > 0.5


@pytest.mark.parametrize("seeds", [(1,), pytest.param(range(40), marks=pytest.mark.slow)])
def test_a_random_scene_that_is_written_otherwise_is_the_same(seeds: range) -> None:
    """What a lattice can't resolve is left to it: jumps of loose pieces, states of faces that nothing presses."""
    for seed in seeds:
        scene = Case.from_dict(growing_scene(seed)).to_dict()
        first, error = outcome(scene)
        for name, change in CHANGES.items():
            steps, again = outcome(change.apply(scene))
            found = deviations(scene, first, steps, change)
            known = {quantity: off for quantity, off in found.items() if quantity not in LOOSE}
            assert again == error, f"seed {seed}, {name}"
            assert max(known.values(), default=0.0) < TOLERANCE, f"seed {seed}, {name}: {known}"
