"""Contact at its extremes on the closed flaw of compression30: stiffness, friction, cohesion from nothing to all.

Uniform compression of 100 MPa, the flaw at 30 degrees: p_n = -100 cos(30)^2 = -75 MPa on it while it sticks, and the
shear 100 sin(30) cos(30) = 43.3 MPa sticks from a friction of tan(30) = 0.577 on.
"""

from __future__ import annotations

import functools

import numpy as np
import pytest
from numpy.typing import NDArray

from crackgrow.contact.coulomb import SLIP, STICK, ContactMemory
from crackgrow.contact.problem import ContactProblem, ContactSolution
from crackgrow.contact.ripple import worst_ripple
from crackgrow.errors import CaseError, SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run import grow
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.frame import make_frame
from crackgrow.run.judging import StepSolution
from crackgrow.run.result import StepResult
from crackgrow.run.scene import make_scene
from tests.scenes import shipped_case, told
from tests.solving import at_once, solve_step

CASE = "compression30"
SETTINGS = ("output.frames=none", "output.figures=false", "growth.steps=0", "numerics.spacing=1.5")

STRESS = 100e6
PRESSURE = STRESS * np.cos(np.deg2rad(30.0)) ** 2
SHEAR = STRESS * np.sin(np.deg2rad(30.0)) * np.cos(np.deg2rad(30.0))
STICK_LIMIT = float(np.tan(np.deg2rad(30.0)))
"""cot of the 60 degrees between the flaw's normal and the direction at a right angle to the load."""

YOUNG, POISSON = 10e9, 0.25


@functools.cache
def first_step(*overrides: str) -> StepResult:
    return next(grow(shipped_case(CASE, [*overrides, *SETTINGS])))


@functools.cache
def solution(*overrides: str) -> StepSolution:
    case = shipped_case(CASE, [*overrides, *SETTINGS])
    return solve_step(make_scene(case), (GrowingCrack.given(case.cracks[0]),), 1.0)


def configuration(*overrides: str) -> Configuration:
    case = shipped_case(CASE, [*overrides, *SETTINGS])
    return assemble(make_scene(case), (GrowingCrack.given(case.cracks[0]),))


def law(friction: float = 0.0, cohesion: float = 0.0) -> tuple[str, ...]:
    contact = "cracks.flaw.contact"
    return f"{contact}.friction={friction!r}", f"{contact}.cohesion={cohesion!r}"


def stiff(stiffness: str, discretization: str = "mortar") -> tuple[str, ...]:
    contact = "numerics.contact"
    return f"{contact}.stiffness={stiffness}", f"{contact}.discretization={discretization}"


def K_II(step: StepResult) -> float:
    start, end = (tip.K_II for tip in step.tips)
    assert start == pytest.approx(end, rel=1e-4)
    return start


def swing(found: StepSolution) -> float:
    worst = worst_ripple(found.cover, found.faces, found.outcome.points.normal, found.outcome.points.tangential)
    assert worst is not None
    return worst.part


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_elastic_contact_converges_to_rigid_contact(friction: float) -> None:
    rigid = K_II(first_step(*law(friction)))
    steps = [first_step(*law(friction), *stiff(k)) for k in ("1e0", "1e2", "1e4", "1e8", "1e12", "1e30")]
    away = np.abs([K_II(step) / rigid - 1.0 for step in steps])
    assert (np.diff(away[:4]) < 0.0).all()
    assert away[2] < 5e-4
    assert away[3:].max() < 1e-8  # 1e8 gives way by h/(1e8 E'), after that there is nothing left to see
    for step in steps:
        assert step.contact_status == "solved"
        assert step.complementarity < 1e-10
        assert step.residual < 1e-10


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("stiffness", ["1e2", "1e4", "1e8", "1e12", "rigid"])  # 1e0 bends: it gives way over h/2
def test_mortar_tractions_are_smooth_at_every_stiffness(stiffness: str, friction: float) -> None:
    spacing = "numerics.spacing=0.75"  # enough nodes for waves to show
    case = shipped_case(CASE, [*law(friction), *stiff(stiffness), *SETTINGS[:-1], spacing])
    found = solve_step(make_scene(case), (GrowingCrack.given(case.cracks[0]),), 1.0)
    p = found.outcome.points.normal
    assert len(p) >= 9
    assert swing(found) == 0.0
    middle = np.abs(found.faces.s - 0.5 * found.faces.s.max()) < 0.25 * found.faces.s.max()
    bends = np.diff(p[middle], 2)
    assert np.abs(bends).max() < 4.0 * 1e-3 * PRESSURE  # of values that are good to 0.1 %
    np.testing.assert_allclose(p[middle], -PRESSURE, rtol=0.015)  # 74.2 MPa: the flaw is not short for the plate
    np.testing.assert_allclose(np.abs(found.outcome.points.tangential), -friction * p, rtol=1e-9, atol=1.0)


@pytest.mark.parametrize("stiffness", ["1e6", "1e8", "1e12", "rigid"])
def test_gauss_points_are_refused_where_their_tractions_mean_nothing(stiffness: str) -> None:
    """K_I would be 160 MPa sqrt(m) at 1e8, 28 times the K_II of a flaw that is closed."""
    with pytest.raises(CaseError, match="more contact points than the displacement can follow") as error:
        first_step(*law(), *stiff(stiffness, "gauss"))
    assert "stiffer than 100000" in str(error.value)


@pytest.mark.parametrize("cohesion", [0.0, 1e6, 1e9])
@pytest.mark.parametrize("friction", [0.0, 0.3, STICK_LIMIT, 2.0, 10.0, 1e3])
@pytest.mark.parametrize("solver", ["newton", "lemke"])
def test_friction_and_cohesion_of_any_size(solver: str, friction: float, cohesion: float) -> None:
    settings = (*law(friction, cohesion / 1e6), f"numerics.contact.solver={solver}")
    step = first_step(*settings)
    assert step.contact_status == "solved"
    assert told(step.warnings) == []
    assert step.complementarity < 1e-12
    u_size = STRESS * 0.055 / YOUNG
    p_n, p_t = step.contact.normal_traction, step.contact.tangential_traction
    held = cohesion + friction * PRESSURE >= SHEAR * (1.0 - 1e-12)
    if held:
        np.testing.assert_allclose(p_n, -PRESSURE, rtol=1e-8)
        np.testing.assert_allclose(p_t, p_t.mean(), rtol=1e-8)
        np.testing.assert_allclose(np.abs(p_t), SHEAR, rtol=1e-8)
        assert np.abs(step.contact.slip).max() < 1e-9 * u_size
        assert np.abs([tip.K_II for tip in step.tips]).max() < 1e-6 * SHEAR * np.sqrt(np.pi * 5e-3)
    else:
        assert set(step.contact.state.tolist()) == {SLIP}
        np.testing.assert_allclose(np.abs(p_t), -friction * p_n, rtol=1e-9, atol=1.0)  # cohesion is lost by slip
        drive = SHEAR - friction * PRESSURE
        assert K_II(step) == pytest.approx(-drive * np.sqrt(np.pi * 5e-3), rel=0.07)  # infinite plate
    if held and friction != STICK_LIMIT:
        assert set(step.contact.state.tolist()) == {STICK}


def intact(points: np.ndarray) -> np.ndarray:
    """Displacement (n, 2) of the plate without the flaw under uniaxial compression in plane strain, held as the case.

    No corner at the bottom moves up or down, its middle does not move sideways.
    """
    shear_modulus = YOUNG / (2.0 * (1.0 + POISSON))
    across, along = POISSON * STRESS / (2.0 * shear_modulus), -(1.0 - POISSON) * STRESS / (2.0 * shear_modulus)
    return np.stack([across * points[:, 0], along * (points[:, 1] + 27.5e-3)], axis=1)


def distance_from_intact(found: StepSolution) -> float:
    """L2 distance over the plate from the intact plate, relative to that plate's displacement."""
    frame = make_frame(found.cover, found.materials, found.outcome.u)
    squares = np.sum((frame.displacement - intact(frame.points)) ** 2, axis=1)
    size = np.sum(intact(frame.points) ** 2, axis=1)
    cells = [frame.triangles, frame.quads[:, [0, 1, 2]], frame.quads[:, [0, 2, 3]]]
    total = np.zeros(2)
    for corners in cells:
        a, b, c = (frame.points[corners[:, k]] for k in range(3))
        area = 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        total += [area @ squares[corners].mean(axis=1), area @ size[corners].mean(axis=1)]
    return float(np.sqrt(total[0] / total[1]))


@pytest.mark.parametrize(
    ("friction", "cohesion"),
    [(STICK_LIMIT, 0.0), (0.6, 0.0), (2.0, 0.0), (10.0, 0.0), (1e3, 0.0), (STICK_LIMIT, 1.0), (0.0, 1e3), (1e3, 1e3)],
)
def test_a_stuck_flaw_is_as_if_it_were_not_there(friction: float, cohesion: float) -> None:
    assert distance_from_intact(solution(*law(friction, cohesion))) < 1e-9


@pytest.mark.parametrize("stiffness", ["1e2", "1e4", "1e8", "1e12"])
def test_a_stuck_flaw_of_elastic_contact_gives_way_by_its_stiffness_alone(stiffness: str) -> None:
    """Shear p/k over the flaw: below 0.1 % of the displacement field from 1e2 on."""
    found = solution(*law(2.0), *stiff(stiffness))
    assert set(found.outcome.points.state.tolist()) == {STICK}
    assert distance_from_intact(found) < max(1e-3 * 1e2 / float(stiffness), 1e-9)


def gives_up(problem: ContactProblem, start: NDArray[np.float64] | None = None) -> ContactSolution:
    return ContactSolution(np.zeros(problem.free.size), "limit", 17, np.zeros(problem.n_points, dtype=np.int64))


def test_a_failed_increment_leaves_everything_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both solvers give up: neither the memory handed in nor later solves notice. Bit for bit."""
    system = configuration(*law(0.3))
    broken = np.arange(system.faces.n) % 2 == 0
    memory = ContactMemory(
        np.linspace(-1e-6, 1e-6, system.faces.n), broken.astype(float), ~broken, np.zeros(system.faces.n)
    )
    slip = memory.slip.copy()
    messages = []
    for _ in range(2):
        with monkeypatch.context() as patch:
            for name in ("newton", "lemke"):
                patch.setattr(f"crackgrow.contact.solve.solve_by_{name}", gives_up)
            with pytest.raises(SolveError) as error:
                at_once(system, 1.0, memory)
        messages.append(str(error.value))
    assert messages[0] == messages[1]
    np.testing.assert_array_equal(memory.slip, slip)
    np.testing.assert_array_equal(memory.broken, broken)
    start = ContactMemory.fresh(system.faces.n)
    first = at_once(system, 1.0, start)
    at_once(system, -3.0, start)
    again = at_once(system, 1.0, start)
    np.testing.assert_array_equal(again.u, first.u)
    np.testing.assert_array_equal(again.memory.slip, first.memory.slip)
    np.testing.assert_array_equal(start.slip, np.zeros(system.faces.n))
