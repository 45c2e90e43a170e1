"""Every solve checks its residual and refines: a factorization that is off by 1e-5 changes no result.

What a step solves by: supports' responses, loads, columns of contact points, pieces on springs, tractions of a critical
load, a corrected direction. All of it goes through `ConstrainedSystem.solve`, or is corrected by what does.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array

from crackgrow.case import load_case
from crackgrow.direct.multifrontal import Multifrontal
from crackgrow.run import grow
from crackgrow.run.result import StepResult

CASES = Path(__file__).parents[2] / "cases"
OFF = 1e-5
ROUGH = ("numerics.spacing=3", "growth.steps=1", "growth.tip_stress.radius=2", "output.figures=false")

SCENES = {
    "contact": ("compression30", (*ROUGH, "cracks.flaw.contact.friction=0.3")),
    "gauss points": (
        "compression30",
        (*ROUGH, "numerics.contact.discretization=gauss", "numerics.contact.stiffness=10"),
    ),
    "critical load": ("compression30", (*ROUGH, "loading=critical")),
    "corrected direction": ("compression30", (*ROUGH, "growth.criterion=max_hoop_stress", "growth.direction=implicit")),
    "springs": ("block_rigid", ("numerics.spacing=0.4", "output.figures=false")),
    "two bodies": ("block_foundation", ("numerics.spacing=0.4", "output.figures=false")),
}


def last_step(name: str, settings: tuple[str, ...]) -> StepResult:
    *_, last = grow(load_case(CASES / f"{name}.yaml", [*settings, "output.frames=none"]))
    return last


@pytest.mark.parametrize("scene", SCENES)
def test_rough_factorization_changes_no_result(scene: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = last_step(*SCENES[scene])
    exact, exact_products = Multifrontal.solve, Multifrontal.products
    n_solves = 0

    def rough(self: Multifrontal, right: np.ndarray) -> np.ndarray:
        nonlocal n_solves
        n_solves += 1
        found = exact(self, right)
        off = 1.0 + OFF * np.random.default_rng(len(found)).choice([-1.0, 1.0], len(found))
        return found * (off if found.ndim == 1 else off[:, None])

    def rough_products(self: Multifrontal, right: csr_array) -> np.ndarray:
        found = exact_products(self, right)
        off = 1.0 + OFF * np.random.default_rng(len(found)).choice([-1.0, 1.0], len(found))
        return off[:, None] * found * off

    monkeypatch.setattr(Multifrontal, "solve", rough)
    monkeypatch.setattr(Multifrontal, "products", rough_products)
    found = last_step(*SCENES[scene])
    assert n_solves > 2
    assert found.residual < 1e-9
    pressure = np.abs(plain.contact.normal_traction).max()
    assert np.abs(found.contact.normal_traction - plain.contact.normal_traction).max() < 1e-7 * pressure
    assert found.load_displacement == pytest.approx(plain.load_displacement, rel=1e-7)
    assert [tip.K_II for tip in found.tips] == pytest.approx([tip.K_II for tip in plain.tips], rel=1e-6)
