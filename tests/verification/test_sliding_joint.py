"""A specimen cut through by a joint, pressed between smooth platens: it slides as one, and stress is uniform.

Under a closure d of its height H and a lateral pressure p the axial stress q and the slip s of the joint at an angle b
follow from

    d = (A q - B p) H + s sin b - |s| tan psi cos b,      A = (1 - nu^2) / E,  B = nu (1 + nu) / E,
    (q - p) sin b cos b = +- (c + mu (q cos^2 b + p sin^2 b))     where it slides,

with c and mu at the slip that has been, and the energies by quadrature over that slip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import brentq

from crackgrow.run.result import StepResult
from tests.verification.solutions import case_of
from tests.whole_run import seen, whole_run

WIDTH, HEIGHT, CLOSURE, LATERAL = 0.1, 0.2, 1e-3, 2e6  # m, m, m, Pa
SIN, COS = np.sin(np.deg2rad(55.0)), np.cos(np.deg2rad(55.0))
REACH = 0.05 * SIN / COS  # m: of the joint above and below the middle
A, B = (1.0 - 0.25**2) / 20e9, 0.25 * 1.25 / 20e9
FRICTION, RESIDUAL, COHESION = 0.8, 0.5, 1.5e6

SPECIMEN = f"""
title: a specimen cut through by a joint
plane: strain
materials: {{rock: {{young: 20 GPa, poisson: 0.25}}}}
bodies:
  low: {{shape: {{polygon: [[-0.05, -0.1], [0.05, -0.1], [0.05, {REACH}], [-0.05, {-REACH}]]}}, material: rock}}
  top: {{shape: {{polygon: [[-0.05, {-REACH}], [0.05, {REACH}], [0.05, 0.1], [-0.05, 0.1]]}}, material: rock}}
interfaces:
  - between: [low, top]
    contact: {{friction: 0.8, residual_friction: 0.5, cohesion: 1.5e6, weakening_length: 0.0004}}
supports:
  - {{on: {{body: low, edge: 0}}, displacement: {{y: 0}}}}
  - {{at: [-0.05, -0.1], displacement: {{x: 0}}}}
  - {{on: {{body: top, edge: 2}}, displacement: {{y: -0.001}}}}
loads:
  - {{on: {{body: low, edge: 1}}, pressure: 2 MPa, held: true}}
  - {{on: {{body: low, edge: 3}}, pressure: 2 MPa, held: true}}
  - {{on: {{body: top, edge: 1}}, pressure: 2 MPa, held: true}}
  - {{on: {{body: top, edge: 3}}, pressure: 2 MPa, held: true}}
numerics: {{spacing: 0.03}}
output: {{points: {{joint: {{at: [0, 0], interface: [low, top]}}}}}}
"""
FORTH_AND_BACK = (0.1, 0.2, 0.3, 0.25, 0.4, 0.5, 0.45, 0.4, 0.3, 0.5, 1.0, 0.9, 0.5, 0.8)


@dataclass
class Joint:
    """The closed form."""

    weakening: float
    dilation: float = 0.0
    kept: bool = False
    slip: float = 0.0
    lost: float = 0.0
    dissipated: float = 0.0  # J/m

    @property
    def law(self) -> dict[str, object]:
        angle, kept = float(np.rad2deg(np.arctan(self.dilation))), "kept" if self.kept else "lost"
        return {"weakening_length": self.weakening, "dilation_angle": angle, "cohesion_after_slip": kept}

    def closure(self, q: float, slip: float) -> float:
        return (A * q - B * LATERAL) * HEIGHT + slip * SIN - self.dilation * abs(slip) * COS

    def sliding(self, way: int, lost: float) -> float:
        """q where it slides."""
        friction = FRICTION + (RESIDUAL - FRICTION) * lost
        cohesion = COHESION * (1.0 if self.kept else 1.0 - lost)
        shear = cohesion + friction * LATERAL * SIN**2
        return (way * shear + LATERAL * SIN * COS) / (SIN * COS - way * friction * COS**2)

    def press(self, d: float) -> float:
        """q after a closure."""
        q = (d - self.closure(0.0, self.slip)) / (A * HEIGHT)
        for way in (1, -1):
            if way * (q - self.sliding(way, self.lost)) > 0.0:
                return self._slide(d, way)
        return q

    def _slide(self, d: float, way: int) -> float:
        def lost(more: float) -> float:
            return min(1.0, self.lost + abs(more) / self.weakening)

        more = brentq(
            lambda x: self.closure(self.sliding(way, lost(x)), self.slip + x) - d, 0.0, way * 0.005, xtol=1e-18
        )
        share = (np.arange(200) + 0.5) / 200
        q = np.array([self.sliding(way, lost(x)) for x in share * more])
        shear, pressure = (q - LATERAL) * SIN * COS, q * COS**2 + LATERAL * SIN**2
        opened = self.dilation * (abs(self.slip + more) - abs(self.slip))
        self.dissipated += float(np.mean(shear) * more - np.mean(pressure) * opened) * WIDTH / COS
        self.slip, self.lost = self.slip + more, lost(more)
        return float(self.sliding(way, self.lost))


def steps(joint: Joint, factors: tuple[float, ...]) -> list[StepResult]:
    law = [f"interfaces.0.contact.{key}={value}" for key, value in joint.law.items()]
    return whole_run(case_of(SPECIMEN, f"loading.history={list(factors)}", *law))[0]


def axial(result: StepResult) -> float:
    """Pa, of the upper platen at the end of a step."""
    return -float(seen([result], "supports.2.force_y")[-1]) / WIDTH


@pytest.mark.parametrize("kept", [False, True])
@pytest.mark.parametrize("dilation", [0.0, 0.14])
@pytest.mark.parametrize("weakening", [4e-4, 2e-3])
def test_it_slides_forth_and_back_as_the_closed_form_does(weakening: float, dilation: float, kept: bool) -> None:
    joint = Joint(weakening, dilation, kept)
    found = steps(joint, FORTH_AND_BACK)
    assert len(found) == len(FORTH_AND_BACK)
    for before, factor, result in zip((0.0, *FORTH_AND_BACK), FORTH_AND_BACK, found, strict=False):
        for d in CLOSURE * np.linspace(before, factor, 50)[1:]:
            q = joint.press(d)
        assert axial(result) == pytest.approx(q, rel=2e-4)
        np.testing.assert_allclose(np.abs(result.contact.mean_slip), joint.slip, atol=1e-9)
        np.testing.assert_allclose(result.contact.mean_opening, joint.dilation * joint.slip, atol=1e-9)
        assert result.energy.error < 1e-9
        assert abs(result.energy.released) < 1e-9 * max(result.energy.work, 1.0)
        assert result.energy.dissipated == pytest.approx(joint.dissipated, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("dilation", [0.0, 0.14])
@pytest.mark.parametrize("weakening", [1e-4, 1e-5, 1e-7])
def test_a_sudden_slip_releases_what_the_weakening_joint_does_not_take(weakening: float, dilation: float) -> None:
    """Strength falls faster with slip than the specimen unloads: at the peak it slides at once to the residual law."""
    joint = Joint(weakening, dilation)
    (last,) = steps(joint, (0.3,))
    peak, residual = joint.sliding(1, 0.0), joint.sliding(1, 1.0)
    onset = joint.closure(peak, 0.0)
    jump, end = ((d - joint.closure(residual, 0.0)) / (SIN - dilation * COS) for d in (onset, 0.3 * CLOSURE))
    slip = np.concatenate([np.linspace(0.0, min(weakening, jump), 2001), np.linspace(min(weakening, jump), jump, 2001)])
    lost = np.minimum(1.0, slip / weakening)
    pressure = (peak + (residual - peak) * slip / jump) * COS**2 + LATERAL * SIN**2
    shear = COHESION * (1.0 - lost) + (FRICTION + (RESIDUAL - FRICTION) * lost) * pressure
    after = COS**2 * residual + LATERAL * SIN**2
    taken = np.trapezoid(shear - dilation * pressure, slip) + (RESIDUAL - dilation) * after * (end - jump)
    assert axial(last) == pytest.approx(residual, rel=1e-6)
    assert last.energy.dissipated == pytest.approx(taken * WIDTH / COS, rel=1e-4)
    assert last.energy.released > 0.05 * last.energy.dissipated
    assert last.history is not None
    assert len(last.history.load_factor) < 20
