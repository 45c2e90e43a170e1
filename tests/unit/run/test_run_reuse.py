"""What a step takes over from the configuration before it: the run is that of fresh assemblies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import crackgrow.run.loading as loading
from crackgrow.case import load_case
from crackgrow.run import grow
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.load_level import LoadLevel
from crackgrow.solid.stiffness import stiffness

CRACKS = {  # the first two meet, the third ends on the fourth, the last two are far away
    "left": {"center": [-20, 0], "length": 9, "angle": 0},
    "right": {"center": [-8, 0.5], "length": 9, "angle": 0},
    "short": {"center": [14, 0], "length": 9, "angle": 0},
    "wall": {"center": [21, 0], "length": 8, "angle": 90},
    "above": {"center": [-12, 24], "length": 10, "angle": 60},
    "below": {"center": [12, -24], "length": 10, "angle": 75},
}


def scene(folder: Path, advance: str, *overrides: str) -> Any:
    """A plate pulled along y, with six flaws of which those in the middle grow."""
    file = folder / "plate.yaml"
    document = {
        "title": "flaws that meet",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "rock": {
                "shape": {"rectangle": {"center": [0, 0], "width": 60, "height": 70}},
                "material": {"young": 10000, "poisson": 0.25},
                "strength": {"tension": 0.5, "cohesion": 10, "friction_angle": 40},
            }
        },
        "cracks": {
            name: {
                "path": path,
                "contact": {"friction": 0.3, "cohesion": 0.0},
                "tips": "none" if name == "wall" else "both",
            }
            for name, path in CRACKS.items()
        },
        "supports": [
            {"at": [-30, -35], "displacement": {"y": 0}},
            {"at": [30, -35], "displacement": {"y": 0}},
            {"at": [0, -35], "displacement": {"x": 0}},
        ],
        "loads": [
            {"on": {"body": "rock", "edge": "top"}, "traction": [0, 1]},
            {"on": {"body": "rock", "edge": "bottom"}, "traction": [0, -1]},
        ],
        "growth": {
            "steps": 4,
            "increment": 2,
            "advance": advance,
            "criterion": "max_hoop_stress",
            "tip_stress": {"radius": 1},
        },
        "numerics": {"spacing": 2},
        "output": {"frames": "none", "figures": False},
    }
    file.write_text(yaml.safe_dump(document))
    return load_case(file, overrides)


@pytest.mark.parametrize("advance", ["most_critical", "all"])
def test_every_stiffness_of_a_run_is_that_of_a_fresh_assembly(
    advance: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where a tip has met another crack, and its factors and solution are, to the last bit.

    Most of what a step needs is known if one tip has grown.
    """
    shares = []

    def checked(*arguments: Any) -> Configuration:
        configuration = assemble(*arguments)
        own = configuration.scene
        fresh = stiffness(configuration.cover, own.materials, own.case.numerics.quadrature)
        np.testing.assert_array_equal(configuration.stiffness.matrix.column, fresh.matrix.column)
        np.testing.assert_array_equal(configuration.stiffness.matrix.block, fresh.matrix.block)
        alone = assemble(own, arguments[1])
        system, rebuilt = configuration.contact.system, alone.contact.system
        assert system.factorization.factors.keys() == rebuilt.factorization.factors.keys()
        loads = configuration.loads(LoadLevel(1.0))
        for taken_over, anew in zip(
            system.solve(loads, configuration.held.given), rebuilt.solve(loads, alone.held.given), strict=True
        ):
            np.testing.assert_array_equal(taken_over, anew)
        shares.append(configuration.stiffness.n_integrated / fresh.n_integrated)
        return configuration

    monkeypatch.setattr(loading, "assemble", checked)
    results = list(grow(scene(tmp_path, advance)))
    assert len(results) == 5
    assert shares[0] == 1.0
    if advance == "most_critical":
        assert max(shares[1:]) < 0.6
        assert np.median(shares[1:]) < 0.4
    else:
        assert sum(len(result.events) for result in results) >= 1


@pytest.mark.parametrize(
    "settings",
    [
        ["growth.direction=explicit"],
        ["growth.direction=implicit"],
        ["numerics.refine.tips=2", "numerics.tip_functions=gathered"],
    ],
)
def test_a_run_is_the_same_without_anything_taken_over(
    settings: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = scene(tmp_path, "most_critical", "growth.steps=2", *settings)
    with_it = list(grow(case))
    monkeypatch.setattr(loading, "assemble", lambda own, cracks, before: assemble(own, cracks))
    for result, alone in zip(with_it, grow(case), strict=True):
        for crack, other in zip(result.cracks, alone.cracks, strict=True):
            np.testing.assert_array_equal(crack.points, other.points)
        K, other_K = ([(tip.K_I, tip.K_II) for tip in step.tips] for step in (result, alone))
        np.testing.assert_allclose(K, other_K, rtol=1e-12)  # nan where there is no room for an integral
