"""Contact, moduli and Poisson's ratios at their extremes: exact fields, limits, balance, and what is said.

The closed flaw of compression30 under 100 MPa at 30 degrees has p_n = -100 cos(30)^2 = -75 MPa while it sticks, and a
shear of 100 sin(30) cos(30) = 43.3 MPa, which sticks from a friction of tan(30) = 0.577 on. In plane strain a Poisson's
ratio near 1/2 makes volume changes cost far more than shear: displacements that cannot keep their volume lock, at a
support of 1.5 but not at 2, and the run warns.
"""

from __future__ import annotations

import functools
from collections import Counter
from functools import cache
from itertools import product

import numpy as np
import pytest

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.contact.coulomb import SLIP, STICK
from crackgrow.contact.ripple import worst_ripple
from crackgrow.errors import CaseError
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.loop import grow
from crackgrow.run.result import StepResult
from tests.contact_problems import drawn, ended
from tests.scenes import shipped_case, specimen, told
from tests.solving import solve_case
from tests.verification.rows.test_fields import YOUNG
from tests.verification.solutions import QUIET, case_of
from tests.verification.solutions import solve_case as solved_case

STRESS = 100e6
PRESSURE = STRESS * np.cos(np.deg2rad(30.0)) ** 2
SHEAR = STRESS * np.sin(np.deg2rad(30.0)) * np.cos(np.deg2rad(30.0))
STICK_LIMIT = float(np.tan(np.deg2rad(30.0)))
"""cot of the 60 degrees between the flaw's normal and the direction at a right angle to the load."""


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
    worst = worst_ripple(found.cover, found.configuration.faces, p_n, p_t)
    assert worst is not None
    assert worst[1] == 0.0
    middle = (
        np.abs(found.configuration.faces.s - 0.5 * found.configuration.faces.s.max())
        < 0.25 * found.configuration.faces.s.max()
    )
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
        assert np.abs(step.contact.slip).max() < 1e-9 * STRESS * 0.055 / (1e6 * YOUNG)
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


HALF, DEPTH = 30.0, 20.0  # mm: half width and depth of the beam
Formulas = tuple[str, str]


def cantilever(poisson: float, plane: str) -> Formulas:
    """u_x, u_y (mm) of a beam under a shear force of 1 N/mm at its end (Timoshenko, Goodier: Elasticity, art. 21)."""
    E, nu = (YOUNG / (1 - poisson**2), poisson / (1 - poisson)) if plane == "strain" else (YOUNG, poisson)
    factor, x, length = 2.0 / (E * DEPTH**3), f"(x+{HALF})", 2.0 * HALF
    u_x = f"{-factor}*y*((6*{length}-3*{x})*{x}+{2 + nu}*(y**2-{DEPTH**2 / 4}))"
    u_y = f"{factor}*({3 * nu}*y**2*({length}-{x})+{4 + 5 * nu}*{DEPTH**2 / 4}*{x}+(3*{length}-{x})*{x}**2)"
    return u_x, u_y


def solved_beam(poisson: float, plane: str, support: float) -> tuple[StepResult, float]:
    """The beam with exact displacements prescribed at both ends; error of the L2 norm of the displacement, relative."""
    formulas = cantilever(poisson, plane)
    exact = dict(zip("xy", formulas, strict=True))
    held = [{"on": {"body": "rock", "edge": edge}, "displacement": exact} for edge in ("left", "right")]
    more = {"plane": plane, "supports": held, "loads": [], "numerics": {"spacing": 3, "support": support}}
    scene = specimen({}, (2.0 * HALF, DEPTH), **more)
    scene["bodies"]["rock"]["material"]["poisson"] = poisson
    found, half = solved_case(Case.from_dict(scene)), 0.5e-3 * np.array([2.0 * HALF, DEPTH])
    points = np.random.default_rng(1).uniform(-half, half, (5000, 2))
    x, y = 1e3 * points.T
    wanted = 1e-3 * np.stack([eval(formula, {"x": x, "y": y}) for formula in formulas], axis=1)
    return found.result, float(np.linalg.norm(found.displacement(points) - wanted) / np.linalg.norm(wanted))


@pytest.mark.parametrize(("poisson", "plane"), [(0.49, "strain"), (0.4999, "strain"), (0.5, "stress")])
def test_displacement_does_not_lock(poisson: float, plane: str) -> None:
    """Measured at 0.499 and 0.4999: 3e-7 and 1e-7."""
    found, error = solved_beam(poisson, plane, 2.0)
    assert error < 1e-4
    assert told(found.warnings) == []
    assert found.residual < 1e-10


def test_small_patches_lock_and_the_run_says_so() -> None:
    found, error = solved_beam(0.4999, "strain", 1.5)
    assert error > 2e-2
    assert any("it locks" in warning for warning in found.warnings)
    found, error = solved_beam(0.49, "strain", 1.5)
    assert error < 1e-2
    assert told(found.warnings) == []


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("compression30", ("growth.tip_stress.radius=2",)),
        ("compression30", ("growth.tip_stress.radius=2", "numerics.contact.stiffness=1e12")),
        ("slant_tension", ("numerics.spacing=3 mm",)),
    ],
)
def test_K_does_not_depend_on_poissons_ratio(name: str, settings: tuple[str, ...]) -> None:
    """Bodies loaded by tractions alone (Michell 1899). By hand K is off by more at once beyond 0.49."""

    def K(poisson: float, plane: str = "strain") -> Floats:
        ratio, spacing = f"bodies.{body}.material.poisson={poisson}", "numerics.spacing=3 mm"
        result = solved_case(shipped_case(name, [*settings, spacing, ratio, f"plane={plane}"])).result
        return np.array([(tip.K_I, tip.K_II) for tip in result.tips])

    (body,) = (body.name for body in shipped_case(name).bodies)
    expected, plane = K(0.25), {0.5: "stress"}
    size = np.abs(expected).max()
    for poisson, most in ((0.0, 0.01), (0.49, 0.01), (0.5, 0.01), (0.499, 0.04), (0.4999, 0.2)):
        assert np.abs(K(poisson, plane.get(poisson, "strain")) - expected).max() < most * size


def test_what_K_of_nearly_incompressible_rock_is_off_by_is_measured() -> None:
    """Cells that a run chooses are smaller there than at 0.25, and K is within its bound."""
    expected, found = (
        solved_case(shipped_case("tension0", [f"bodies.rock.material.poisson={ratio}", "growth.steps=0"])).result
        for ratio in (0.25, 0.499)
    )
    assert found.n_dofs > expected.n_dofs
    assert pytest.approx(expected.tips[0].K_I, abs=found.tips[0].K_I_error) == found.tips[0].K_I


BLOCK = 1e3  # Pa, Young's modulus of the block
BALANCE = 1e-9
ROUND_OFF = 3e-14  # a hundred units in the last place: sums over the nodes of a block


TWO_BLOCKS = """
title: two blocks of 4 m x 2 m on each other under 100 Pa
plane: strain
bodies:
  upper: {shape: {rectangle: {center: [0, 1], width: 4, height: 2}}, material: {young: UPPER, poisson: 0}}
  lower: {shape: {rectangle: {center: [0, -1], width: 4, height: 2}}, material: {young: LOWER, poisson: 0}}
interfaces: [{between: [upper, lower], contact: CONTACT}]
supports: [{on: {body: lower, edge: bottom}, displacement: {x: 0, y: 0}}]
loads: [{on: {body: upper, edge: top}, traction: [0, -100]}]
numerics: {spacing: 0.4}
"""


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


@pytest.mark.parametrize("contact", ["{friction: 0.5, cohesion: 0}", "bonded"])
@pytest.mark.parametrize("ratio", [1e-9, 1e-4, 1.0, 1e4, 1e9])
def test_pressure_goes_through_any_two_blocks(ratio: float, contact: str) -> None:
    """Without sideways strain both are under 100 Pa, and the top goes down by 2 m (100 Pa/E) for each (exact)."""
    accuracy = max(BALANCE, ROUND_OFF / ratio)
    found = next(grow(case_of(TWO_BLOCKS, UPPER=BLOCK, LOWER=ratio * BLOCK, CONTACT=contact)))
    assert found.load_displacement == pytest.approx(200.0 / BLOCK * (1.0 + 1.0 / ratio), rel=accuracy)
    assert said(found, "out of balance") == (ratio == 1e-9 and contact == "bonded")
    reactions = {reaction.where: reaction.force for reaction in found.reactions}
    assert reactions["upper/lower"][1] == pytest.approx(400.0, rel=accuracy)
    assert reactions["supports.0"][1] == pytest.approx(400.0, rel=accuracy)
