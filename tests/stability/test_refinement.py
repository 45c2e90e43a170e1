"""Every solve checks its residual and refines: a factorization that is off by 1e-5 changes no result.

What a step solves by: supports' responses, loads, columns of contact points, pieces on springs, tractions of a critical
load, a corrected direction. All of it goes through `ConstrainedSystem.solve`, or is corrected by what does.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array

from crackgrow.linear.factorization import Factorization
from crackgrow.run import grow
from crackgrow.run.result import StepResult
from tests.scenes import shipped_case

OFF = 1e-5
ROUGH = ("numerics.spacing=3", "growth.steps=1", "growth.tip_stress.radius=2", "output.figures=false")

SCENES = {
    "contact": ("compression30", (*ROUGH, "cracks.flaw.contact.friction=0.3")),
    "critical load": ("compression30", (*ROUGH, "loading=critical")),
    "corrected direction": ("compression30", (*ROUGH, "growth.criterion=max_hoop_stress", "growth.direction=implicit")),
    "springs": ("block_rigid", ("numerics.spacing=0.4", "output.figures=false")),
}


def last_step(name: str, settings: tuple[str, ...]) -> StepResult:
    *_, last = grow(shipped_case(name, [*settings, "output.frames=none"]))
    return last


@pytest.mark.parametrize("scene", SCENES)
def test_rough_factorization_changes_no_result(scene: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = last_step(*SCENES[scene])
    exact, exact_compliance = Factorization.solve, Factorization.compliance
    n_solves = 0

    def off(n: int) -> np.ndarray:
        return 1.0 + OFF * np.random.default_rng(n).choice([-1.0, 1.0], n)

    def rough(self: Factorization, loads: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        nonlocal n_solves
        n_solves += 1
        u, multipliers = exact(self, loads, wanted)
        return off(len(u))[:, None] * u, off(len(multipliers))[:, None] * multipliers

    def rough_compliance(self: Factorization, rows: csr_array) -> np.ndarray:
        found = exact_compliance(self, rows)
        return off(len(found))[:, None] * found * off(len(found))

    monkeypatch.setattr(Factorization, "solve", rough)
    monkeypatch.setattr(Factorization, "compliance", rough_compliance)
    found = last_step(*SCENES[scene])
    assert n_solves > 2
    assert found.residual < 1e-9
    pressure = np.abs(plain.contact.normal_traction).max()
    assert np.abs(found.contact.normal_traction - plain.contact.normal_traction).max() < 1e-7 * pressure
    assert found.load_displacement == pytest.approx(plain.load_displacement, rel=1e-7)
    assert [tip.K_II for tip in found.tips] == pytest.approx([tip.K_II for tip in plain.tips], rel=1e-6)
