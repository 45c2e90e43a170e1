"""What a step takes over from the configuration before it: the run is that of fresh assemblies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml

import crackgrow.run.loading as loading
from crackgrow.case.load import read_case
from crackgrow.case.model import Case
from crackgrow.contact import system as contact_system
from crackgrow.run import grow
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.load_level import LoadLevel
from crackgrow.solid.stiffness import stiffness
from tests.scenes import specimen

CRACKS = {  # the first two meet, the third ends on the fourth, the last two are far away
    "left": {"center": [-20, 0], "length": 9, "angle": 0},
    "right": {"center": [-8, 0.5], "length": 9, "angle": 0},
    "short": {"center": [14, 0], "length": 9, "angle": 0},
    "wall": {"center": [21, 0], "length": 8, "angle": 90},
    "above": {"center": [-12, 24], "length": 10, "angle": 60},
    "below": {"center": [12, -24], "length": 10, "angle": 75},
}


def scene(advance: str, *overrides: str) -> Case:
    """A plate pulled along y, with six flaws of which those in the middle grow."""
    law = {"friction": 0.3, "cohesion": 0.0}
    cracks = {
        name: {"path": path, "contact": dict(law), "tips": "none" if name == "wall" else "both"}
        for name, path in CRACKS.items()
    }
    growth = {
        "steps": 4,
        "increment": 2,
        "advance": advance,
        "criterion": "max_hoop_stress",
        "tip_stress": {"radius": 1},
    }
    document = specimen(cracks, (60.0, 70.0), growth=growth, numerics={"spacing": 2})
    return read_case(yaml.safe_dump(document), "plate", "plate", overrides)


@pytest.mark.parametrize("advance", ["most_critical", "all"])
def test_every_stiffness_of_a_run_is_that_of_a_fresh_assembly(advance: str, monkeypatch: pytest.MonkeyPatch) -> None:
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
    results = list(grow(scene(advance)))
    assert len(results) == 5
    assert shares[0] == 1.0
    if advance == "most_critical":
        assert max(shares[1:]) < 0.6
        assert np.median(shares[1:]) < 0.4
    else:
        assert sum(len(result.events) for result in results) >= 1


@pytest.mark.parametrize("few", [contact_system.FEW_NUMBERS, 0])
@pytest.mark.parametrize(
    "settings",
    [
        ["growth.direction=explicit"],
        ["growth.direction=implicit"],
        ["growth.criterion=directional_strength", "numerics.refine={tips: 2, kinks: 3}"],
        ["numerics.refine.tips=2", "numerics.tip_functions=gathered"],
    ],
)
def test_a_run_is_the_same_without_anything_taken_over(
    settings: list[str], few: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With `few` of 0 also what subtrees far from the growth give to the compliance of contact is taken over."""
    monkeypatch.setattr(contact_system, "FEW_NUMBERS", few)
    case = scene("most_critical", "growth.steps=2", *settings)
    with_it = list(grow(case))
    monkeypatch.setattr(loading, "assemble", lambda own, cracks, before: assemble(own, cracks))
    for result, alone in zip(with_it, grow(case), strict=True):
        for crack, other in zip(result.cracks, alone.cracks, strict=True):
            np.testing.assert_array_equal(crack.points, other.points)
        K, other_K = ([(tip.K_I, tip.K_II, tip.criticality) for tip in step.tips] for step in (result, alone))
        np.testing.assert_allclose(K, other_K, rtol=1e-12)  # nan where there is no room for an integral
        np.testing.assert_array_equal(result.contact.state, alone.contact.state)
        for found, expected in ((result.contact.slip, alone.contact.slip), (result.contact.s, alone.contact.s)):
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
