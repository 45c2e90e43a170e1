"""Two bodies of very unlike stiffness: limits, balance of forces, and what is said where they are lost."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.run import grow
from crackgrow.run.result import StepResult
from tests.scenes import shipped_case

BLOCK = 1e3  # Pa, Young's modulus of the block
LOADS = np.array([60.0 * 2.0, -200.0 * 3.6])  # N/m, pull on the right side and pressure on the top
QUIET = ("output.frames=none", "output.figures=false")
BALANCE = 1e-9
ROUND_OFF = 3e-14  # a hundred units in the last place: sums over the nodes of a block

TWO_BLOCKS = """
title: Two blocks on each other under pressure
units: {{length: m, stress: Pa}}
plane: strain
bodies:
  upper:
    shape: {{rectangle: {{center: [0, 1], width: 4, height: 2}}}}
    material: {{young: {upper}, poisson: 0}}
  lower:
    shape: {{rectangle: {{center: [0, -1], width: 4, height: 2}}}}
    material: {{young: {lower}, poisson: 0}}
interfaces:
  - {{between: [upper, lower], contact: {contact}}}
supports:
  - {{on: {{body: lower, edge: bottom}}, displacement: {{x: 0, y: 0}}}}
loads:
  - {{on: {{body: upper, edge: top}}, traction: [0, -100]}}
numerics: {{spacing: 0.4}}
"""


def foundation(ratio: float) -> StepResult:
    young = f"bodies.foundation.material.young={ratio * BLOCK!r}"
    return next(grow(shipped_case("block_foundation", [young, *QUIET])))


@pytest.fixture(scope="module")
def rigid() -> StepResult:
    return next(grow(shipped_case("block_rigid", QUIET)))


@pytest.mark.parametrize("ratio", [1e3, 1e5, 1e7, 1e9])
def test_stiff_foundation_is_as_a_rigid_one(ratio: float, rigid: StepResult) -> None:
    """The foundation gives way by a part of 1/ratio; at 1e9 what is left is the noise of the solver."""
    found = foundation(ratio)
    contact, on_rigid = (
        np.array([step.contact.normal_traction, step.contact.tangential_traction]) for step in (found, rigid)
    )
    assert np.abs(contact - on_rigid).max() < (1.0 / ratio + 1e-9) * np.abs(on_rigid).max()
    assert max(found.energy.error, found.residual) < 1e-10
    assert not any("out of balance" in warning for warning in found.warnings)


@pytest.mark.parametrize("ratio", [1e-9, 1e-8, 1e-3, 1.0, 1e3, 1e7, 1e9])
def test_interface_carries_the_loads_of_the_block(ratio: float) -> None:
    """On soft rock a block moves 1/ratio times further than it strains: motion and strain are unknowns of their own."""
    found = foundation(ratio)
    (carried,) = (np.array(r.force) for r in found.reactions if r.where == "block/foundation")
    missing = np.abs(carried + LOADS).max() / np.abs(LOADS).max()
    assert missing < BALANCE
    assert not any("out of balance" in warning for warning in found.warnings)
    assert any("ill conditioned" in warning for warning in found.warnings) == (ratio <= 1e-8)


@pytest.mark.parametrize("contact", ["{friction: 0.5, cohesion: 0}", "bonded"])
@pytest.mark.parametrize("ratio", [1e-9, 1e-4, 1e4, 1e9])
def test_pressure_goes_through_any_two_blocks(ratio: float, contact: str, tmp_path: Path) -> None:
    """Without sideways strain both are under 100 Pa, and the top goes down by 2 m (100 Pa/E) for each (exact)."""
    accuracy = max(BALANCE, ROUND_OFF / ratio)
    path = tmp_path / "blocks.yaml"
    path.write_text(TWO_BLOCKS.format(upper=BLOCK, lower=ratio * BLOCK, contact=contact), encoding="utf-8")
    found = next(grow(load_case(path, QUIET)))
    assert found.load_displacement == pytest.approx(200.0 / BLOCK * (1.0 + 1.0 / ratio), rel=accuracy)
    told = any("out of balance" in warning for warning in found.warnings)
    assert told == (ratio == 1e-9 and contact == "bonded")
    reactions = {reaction.where: reaction.force for reaction in found.reactions}
    assert reactions["upper/lower"][1] == pytest.approx(400.0, rel=accuracy)
    assert reactions["supports.0"][1] == pytest.approx(400.0, rel=accuracy)
