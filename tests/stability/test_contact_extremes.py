"""Contact at its extremes on the closed flaw of compression30: stiffness, friction, cohesion from nothing to all.

Uniform compression of 100 MPa, the flaw at 30 degrees: p_n = -100 cos(30)^2 = -75 MPa on it while it sticks, and the
shear 100 sin(30) cos(30) = 43.3 MPa sticks from a friction of tan(30) = 0.577 on.
"""

from __future__ import annotations

import functools
from collections import Counter
from itertools import product

import numpy as np
import pytest

from crackgrow.contact.coulomb import SLIP, STICK
from crackgrow.contact.ripple import worst_ripple
from crackgrow.errors import CaseError
from crackgrow.run import grow
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.result import StepResult
from tests.scenes import shipped_case, told
from tests.solving import solve_case
from tests.stability.contact_at_random import drawn, ended
from tests.verification.solutions import QUIET

STRESS = 100e6
PRESSURE = STRESS * np.cos(np.deg2rad(30.0)) ** 2
SHEAR = STRESS * np.sin(np.deg2rad(30.0)) * np.cos(np.deg2rad(30.0))
STICK_LIMIT = float(np.tan(np.deg2rad(30.0)))
"""cot of the 60 degrees between the flaw's normal and the direction at a right angle to the load."""

YOUNG, POISSON = 10e9, 0.25


def flaw(
    friction: float = 0.0,
    cohesion: float = 0.0,
    stiffness: str = "rigid",
    discretization: str = "mortar",
    solver: str = "newton",
    spacing: float = 1.5,
) -> tuple[str, ...]:
    """Settings of the flaw; cohesion in MPa."""
    return (
        f"cracks.flaw.contact={{friction: {friction!r}, cohesion: {cohesion!r}}}",
        f"numerics.contact={{stiffness: {stiffness}, discretization: {discretization}, solver: {solver}}}",
        f"numerics.spacing={spacing}",
        *QUIET,
        "growth.steps=0",
    )


@functools.cache
def first_step(*settings: str) -> StepResult:
    return next(grow(shipped_case("compression30", settings)))


def solution(*settings: str) -> StepSolution:
    return solve_case(shipped_case("compression30", settings))


def K_II(step: StepResult) -> float:
    start, end = (tip.K_II for tip in step.tips)
    assert start == pytest.approx(end, rel=1e-4)
    return start


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_elastic_contact_converges_to_rigid_contact(friction: float) -> None:
    rigid = K_II(first_step(*flaw(friction)))
    steps = [first_step(*flaw(friction, stiffness=k)) for k in ("1e0", "1e2", "1e4", "1e8", "1e12", "1e30")]
    away = np.abs([K_II(step) / rigid - 1.0 for step in steps])
    assert (np.diff(away[:4]) < 0.0).all()
    assert away[2] < 5e-4
    assert away[3:].max() < 1e-8  # 1e8 gives way by h/(1e8 E'), after that there is nothing left to see
    assert max(max(step.complementarity, step.residual) for step in steps) < 1e-10


@pytest.mark.parametrize(("stiffness", "friction"), [("1e2", 0.3), ("1e4", 0.0), ("1e8", 0.3)])
def test_mortar_tractions_are_smooth_at_every_stiffness(stiffness: str, friction: float) -> None:
    """But for 1e0, which gives way over h/2."""
    found = solution(*flaw(friction, stiffness=stiffness, spacing=0.75))  # enough nodes for waves to show
    p_n, p_t = found.outcome.points.normal, found.outcome.points.tangential
    assert len(p_n) >= 9
    worst = worst_ripple(found.cover, found.faces, p_n, p_t)
    assert worst is not None
    assert worst.part == 0.0
    middle = np.abs(found.faces.s - 0.5 * found.faces.s.max()) < 0.25 * found.faces.s.max()
    assert np.abs(np.diff(p_n[middle], 2)).max() < 4.0 * 1e-3 * PRESSURE  # of values that are good to 0.1 %
    np.testing.assert_allclose(p_n[middle], -PRESSURE, rtol=0.015)  # 74.2 MPa: the flaw is not short for the plate
    np.testing.assert_allclose(np.abs(p_t), -friction * p_n, rtol=1e-9, atol=1.0)


@pytest.mark.parametrize("stiffness", ["1e6", "rigid"])
def test_gauss_points_are_refused_where_their_tractions_mean_nothing(stiffness: str) -> None:
    """K_I would be 160 MPa sqrt(m) at 1e8, 28 times the K_II of a flaw that is closed."""
    with pytest.raises(CaseError, match="more contact points than the displacement can follow") as error:
        first_step(*flaw(stiffness=stiffness, discretization="gauss"))
    assert "stiffer than 100000" in str(error.value)


@pytest.mark.parametrize(
    ("solver", "friction", "cohesion"),
    [
        *product(["newton"], [0.0, 0.3, STICK_LIMIT, 2.0, 1e3], [0.0, 1.0, 1e3]),
        *product(["lemke"], [0.3, STICK_LIMIT, 1e3], [0.0, 1.0]),
    ],
)
def test_friction_and_cohesion_of_any_size(solver: str, friction: float, cohesion: float) -> None:
    step = first_step(*flaw(friction, cohesion, solver=solver))
    assert told(step.warnings) == []
    assert step.complementarity < 1e-12
    p_n, p_t = step.contact.normal_traction, step.contact.tangential_traction
    held = 1e6 * cohesion + friction * PRESSURE >= SHEAR * (1.0 - 1e-12)
    if held:
        np.testing.assert_allclose(p_n, -PRESSURE, rtol=1e-8)
        np.testing.assert_allclose(p_t, p_t.mean(), rtol=1e-8)
        np.testing.assert_allclose(np.abs(p_t), SHEAR, rtol=1e-8)
        assert np.abs(step.contact.slip).max() < 1e-9 * STRESS * 0.055 / YOUNG
        assert np.abs([tip.K_II for tip in step.tips]).max() < 1e-6 * SHEAR * np.sqrt(np.pi * 5e-3)
    else:
        assert set(step.contact.state.tolist()) == {SLIP}
        np.testing.assert_allclose(np.abs(p_t), -friction * p_n, rtol=1e-9, atol=1.0)  # cohesion is lost by slip
        drive = SHEAR - friction * PRESSURE
        assert K_II(step) == pytest.approx(-drive * np.sqrt(np.pi * 5e-3), rel=0.07)  # infinite plate
    if held and friction != STICK_LIMIT:
        assert set(step.contact.state.tolist()) == {STICK}


def test_each_is_solved_or_a_limit_state() -> None:
    ends = {seed: ended(drawn(seed))[0] for seed in range(200)}
    assert {seed: end for seed, end in ends.items() if end not in ("solved", "limit state")} == {}
    assert Counter(ends.values())["limit state"] >= 3
