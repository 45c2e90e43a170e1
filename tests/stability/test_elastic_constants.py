"""Nearly incompressible rock, and bodies of very unlike stiffness: exact fields, limits, balance, and what is said.

In plane strain a Poisson's ratio near 1/2 makes volume changes cost far more than shear. Displacements that cannot keep
their volume then lock. At a support of 2 they do not; at 1.5 they do, and the run warns.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.run import grow
from crackgrow.run.result import StepResult
from tests.scenes import shipped_case, told
from tests.verification.rows.test_fields import YOUNG
from tests.verification.solutions import QUIET, case_of, solve_case

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
    shape = {"rectangle": {"center": [0, 0], "width": 2.0 * HALF, "height": DEPTH}}
    scene = {
        "title": "exact displacements on a part of the outline",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": plane,
        "bodies": {"rock": {"shape": shape, "material": {"young": YOUNG, "poisson": poisson}}},
        "supports": [{"on": {"body": "rock", "edge": edge}, "displacement": exact} for edge in ("left", "right")],
        "numerics": {"spacing": 3, "support": support},
    }
    found, half = solve_case(Case.from_dict(scene)), 0.5e-3 * np.array([2.0 * HALF, DEPTH])
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
        result = solve_case(shipped_case(name, [*settings, spacing, ratio, f"plane={plane}"])).result
        return np.array([(tip.K_I, tip.K_II) for tip in result.tips])

    (body,) = (body.name for body in shipped_case(name).bodies)
    expected, plane = K(0.25), {0.5: "stress"}
    size = np.abs(expected).max()
    for poisson, most in ((0.0, 0.01), (0.49, 0.01), (0.5, 0.01), (0.499, 0.04), (0.4999, 0.2)):
        assert np.abs(K(poisson, plane.get(poisson, "strain")) - expected).max() < most * size


def test_what_K_of_nearly_incompressible_rock_is_off_by_is_measured() -> None:
    """Cells that a run chooses are smaller there than at 0.25, and K is within its bound."""
    expected, found = (
        solve_case(shipped_case("tension0", [f"bodies.rock.material.poisson={ratio}", "growth.steps=0"])).result
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
