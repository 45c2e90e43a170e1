"""Slivers: rock far thinner than a cell between cracks, or between a crack and an outline, that contact holds.

Cells by hand do not resolve a sliver, yet the same scene written otherwise has the same K: neither its
functions, which nearly depend on each other, nor how far it would bend without contact decides.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from crackgrow.case.model import Case
from tests.scenes import plate
from tests.stability.changed import CHANGES, Scene, deviations, outcome
from tests.stability.growing_scenes import growing_scene


def beside_outline(width: float) -> Scene:
    """A closed crack that leaves the corner of a block and is `width` (cells) away from its side at the tip."""
    scene = growing_scene(29)
    points = scene["cracks"]["c0"]["path"]["points"]
    points[1][0] = points[0][0] - width * scene["numerics"]["spacing"]
    return {name: part for name, part in scene.items() if name != "growth"}


def beside_crack(second: list[list[float]], tips: str) -> Scene:
    """A pressed and sheared plate, cells of 1 mm, with a crack of 8 mm along x, and a second one."""
    scene = plate([[-3.87, 0.29], [4.13, 1.69]], 20.0, 20.0, 4.0, 0.3)
    shear = {"top": [3.0, 0.0], "bottom": [-3.0, 0.0], "right": [0.0, 3.0], "left": [0.0, -3.0]}
    scene["loads"] += [{"on": {"body": "rock", "edge": edge}, "traction": force} for edge, force in shear.items()]
    scene["cracks"]["b"] = {**scene["cracks"]["flaw"], "path": {"points": second}, "tips": tips}
    return scene


def parallel(width: float) -> Scene:
    """Two cracks side by side."""
    return beside_crack([[-2.37, 0.5525 + width], [5.33, 1.9 + width]], "both")


def branched(width: float) -> Scene:
    """The second one leaves the first one at its middle and stays within a `width`."""
    return beside_crack([[0.13, 0.99], [2.73, 1.445 + width]], "end")


@pytest.mark.parametrize(
    ("made", "width"),
    [
        *((beside_outline, width) for width in (0.03, 0.008, 2e-3, 3e-4)),
        *((made, width) for made in (parallel, branched) for width in (0.03, 3e-3)),
    ],
)
def test_a_sliver_written_otherwise_has_the_same_K(made: Callable[[float], Scene], width: float) -> None:
    """Before, slivers beside an outline had K off by 56 %, 0.8 % and 3e-5 of the largest when mirrored."""
    scene = Case.from_dict(made(width)).to_dict()
    first, _ = outcome(scene)
    off = {name: deviations(scene, first, outcome(by.apply(scene))[0], by)["K"] for name, by in CHANGES.items()}
    assert max(off.values()) < 1e-6, off


def test_pressure_passes_through_a_sliver() -> None:
    """Contact beside the outline bears what presses there, as if the crack was not there."""
    scene = beside_outline(3e-4)
    (press,) = (load["traction"][0] for load in scene["loads"] if load["on"]["edge"] == "right")
    (faces,) = (faces for faces in outcome(scene)[0][0].faces if faces.crack == "c0")
    np.testing.assert_allclose(faces.normal_traction, 1e3 * press, rtol=1e-3)
