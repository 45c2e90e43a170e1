"""Two bodies of very unlike stiffness: limits, balance of forces, and what is said where they are lost."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from crackgrow.case.model import Case
from crackgrow.run import grow
from crackgrow.run.result import StepResult
from tests.scenes import shipped_case

BLOCK = 1e3  # Pa, Young's modulus of the block
LOADS = np.array([60.0 * 2.0, -200.0 * 3.6])  # N/m, pull on the right side and pressure on the top
QUIET = ("output.frames=none", "output.figures=false")
BALANCE = 1e-9
ROUND_OFF = 3e-14  # a hundred units in the last place: sums over the nodes of a block


def two_blocks(upper: float, lower: float, contact: Any) -> Case:
    """Two blocks of 4 m x 2 m on each other under 100 Pa."""
    bodies = {
        name: {
            "shape": {"rectangle": {"center": [0, y], "width": 4, "height": 2}},
            "material": {"young": young, "poisson": 0},
        }
        for name, y, young in (("upper", 1, upper), ("lower", -1, lower))
    }
    return Case.from_dict(
        {
            "title": "two blocks",
            "plane": "strain",
            "bodies": bodies,
            "interfaces": [{"between": ["upper", "lower"], "contact": contact}],
            "supports": [{"on": {"body": "lower", "edge": "bottom"}, "displacement": {"x": 0, "y": 0}}],
            "loads": [{"on": {"body": "upper", "edge": "top"}, "traction": [0, -100]}],
            "numerics": {"spacing": 0.4},
            "output": {"frames": "none", "figures": False},
        }
    )


def said(step: StepResult, words: str) -> bool:
    return any(words in warning for warning in step.warnings)


@cache
def foundation(ratio: float) -> StepResult:
    young = f"bodies.foundation.material.young={ratio * BLOCK!r}"
    return next(grow(shipped_case("block_foundation", [young, *QUIET])))


def test_stiff_foundation_is_as_a_rigid_one() -> None:
    """The foundation gives way by a part of 1/ratio; at 1e9 what is left is the noise of the solver."""
    rigid = next(grow(shipped_case("block_rigid", QUIET)))
    on_rigid = np.array([rigid.contact.normal_traction, rigid.contact.tangential_traction])
    for ratio in (1e3, 1e5, 1e7, 1e9):
        found = foundation(ratio)
        contact = np.array([found.contact.normal_traction, found.contact.tangential_traction])
        assert np.abs(contact - on_rigid).max() < (1.0 / ratio + 1e-9) * np.abs(on_rigid).max()
        assert max(found.energy.error, found.residual) < 1e-10


@pytest.mark.parametrize("ratio", [1e-9, 1e-8, 1e-3, 1.0, 1e3, 1e7, 1e9])
def test_interface_carries_the_loads_of_the_block(ratio: float) -> None:
    """On soft rock a block moves 1/ratio times further than it strains: motion and strain are unknowns of their own."""
    found = foundation(ratio)
    (carried,) = (np.array(r.force) for r in found.reactions if r.where == "block/foundation")
    assert np.abs(carried + LOADS).max() < BALANCE * np.abs(LOADS).max()
    assert not said(found, "out of balance")
    assert said(found, "ill conditioned") == (ratio <= 1e-8)


@pytest.mark.parametrize("contact", [{"friction": 0.5, "cohesion": 0}, "bonded"], ids=["contact", "bonded"])
@pytest.mark.parametrize("ratio", [1e-9, 1e-4, 1.0, 1e4, 1e9])
def test_pressure_goes_through_any_two_blocks(ratio: float, contact: Any) -> None:
    """Without sideways strain both are under 100 Pa, and the top goes down by 2 m (100 Pa/E) for each (exact)."""
    accuracy = max(BALANCE, ROUND_OFF / ratio)
    found = next(grow(two_blocks(BLOCK, ratio * BLOCK, contact)))
    assert found.load_displacement == pytest.approx(200.0 / BLOCK * (1.0 + 1.0 / ratio), rel=accuracy)
    assert said(found, "out of balance") == (ratio == 1e-9 and contact == "bonded")
    reactions = {reaction.where: reaction.force for reaction in found.reactions}
    assert reactions["upper/lower"][1] == pytest.approx(400.0, rel=accuracy)
    assert reactions["supports.0"][1] == pytest.approx(400.0, rel=accuracy)
