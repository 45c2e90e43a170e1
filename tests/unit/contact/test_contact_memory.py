"""What contact points remember, on points that rest on springs: kn gap + p_n = -P and kt slip + p_t = T.

They are closed with p_n = -P, and their slip is the play operator of T, (T -+ b) / kt while it slides.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.sparse import block_diag

from crackgrow.contact.coulomb import OPEN, SLIP, STICK, ContactLaw, ContactMemory
from crackgrow.contact.solve import ContactOutcome
from crackgrow.errors import SolveError
from tests.contact_problems import contact_law, rock_of
from tests.solving import solve_contact

N = 3
KN = np.array([40.0, 55.0, 30.0])
KT = np.array([20.0, 10.0, 35.0])
PRESSURE = np.array([2.0, 1.5, 3.0])
WEIGHTS = np.array([1.0, 0.5, 2.0])
FRICTION, COHESION = 0.5, 0.4

pytestmark = pytest.mark.parametrize("solver", ["newton", "lemke"])


class Springs:
    """N points on springs of their own; loads are forces per length of the points, Pa."""

    def __init__(self, solver: str, coupling: float = 0.0, cohesion: float = 0.0, **law: Any) -> None:
        """`coupling` ties the slip of neighbours together: a stiffness, Pa. Cohesion is in parts of PRESSURE."""
        tangential = np.diag(WEIGHTS * KT) + coupling * (2.0 * np.eye(N) - np.eye(N, k=1) - np.eye(N, k=-1))
        K = block_diag([np.diag(KN * WEIGHTS), tangential]).toarray()
        self.contact = rock_of(K, uniform_law(N, cohesion=cohesion * PRESSURE, **law), solver, WEIGHTS)

    def follow(self, *shears: float, pressure: float = 1.0, last: ContactOutcome | None = None) -> list[ContactOutcome]:
        """Outcomes under shears, one after the other, each times PRESSURE; `pressure` in the same measure."""
        outcomes = []
        for shear in shears:
            loads = np.concatenate([-pressure * PRESSURE * WEIGHTS, shear * PRESSURE * WEIGHTS])
            last = solve_contact(self.contact, loads, np.zeros(0), last.memory if last else None)
            outcomes.append(last)
        return outcomes


def uniform_law(
    n: int, friction: float = FRICTION, cohesion: Any = 0.0, compliance: float = 0.0, **more: Any
) -> ContactLaw:
    """The same law for n points, but for what is given as (n,)."""
    values = [np.full(n, value) for value in (friction, cohesion, compliance)]
    return contact_law(*values, **{name: np.full(n, value) for name, value in more.items()})


def solve(
    stiffness: Any, law: ContactLaw, solver: str, loads: Any, memory: ContactMemory | None = None
) -> ContactOutcome:
    return solve_contact(rock_of(np.asarray(stiffness), law, solver), np.array(loads, dtype=float), np.zeros(0), memory)


def states(outcomes: list[ContactOutcome]) -> list[int]:
    """The state of each outcome, which is that of all points."""
    assert all(len(set(outcome.points.state.tolist())) == 1 for outcome in outcomes)
    return [int(outcome.points.state[0]) for outcome in outcomes]


def test_residual_slip_stays_until_the_shear_has_changed_by_twice_the_limit(solver: str) -> None:
    """Limit 0.5: loaded to 1.2, the reversal is at 0.2."""
    outcomes = Springs(solver).follow(0.49, 1.2, 0.9, 0.21, 0.0, -0.7, 0.29, 0.5, 1.2)
    assert states(outcomes) == [STICK, SLIP, STICK, STICK, SLIP, SLIP, STICK, SLIP, SLIP]
    w = np.array([0.0, 0.7, 0.7, 0.7, 0.5, -0.2, -0.2, 0.0, 0.7])
    shear = np.array([0.49, 1.2, 0.9, 0.21, 0.0, -0.7, 0.29, 0.5, 1.2])
    before = np.zeros_like(outcomes[0].memory.slip)
    for outcome, driving, applied in zip(outcomes, w, shear, strict=True):
        np.testing.assert_allclose(outcome.points.slip, driving * PRESSURE / KT, atol=1e-13)
        np.testing.assert_allclose(outcome.points.tangential, (applied - driving) * PRESSURE, rtol=1e-10)
        np.testing.assert_allclose(outcome.points.normal, -PRESSURE, rtol=1e-12)
        stuck = outcome.points.state == STICK  # these keep their slip to the bit
        np.testing.assert_array_equal(outcome.memory.slip, np.where(stuck, before, outcome.points.slip))
        before = outcome.memory.slip


def test_cohesion_is_lost_by_slip_and_stays_lost(solver: str) -> None:
    """Limits 0.9 and then 0.5."""
    stuck, slipped, back, down = Springs(solver, cohesion=COHESION).follow(0.89, 0.95, 0.4, -0.1)
    assert states([stuck, slipped, back, down]) == [STICK, SLIP, STICK, SLIP]
    assert not stuck.memory.broken.any()
    for outcome in (slipped, back, down):
        assert outcome.memory.broken.all()
    np.testing.assert_allclose(slipped.points.tangential, 0.5 * PRESSURE)  # it drops to the residual limit
    np.testing.assert_allclose(slipped.points.slip, 0.45 * PRESSURE / KT)
    np.testing.assert_allclose(back.points.slip, slipped.points.slip)
    np.testing.assert_allclose(down.points.tangential, -0.5 * PRESSURE)
    np.testing.assert_allclose(down.points.slip, 0.4 * PRESSURE / KT)


@pytest.mark.parametrize(("kept", "limit"), [(False, 0.5), (True, 0.9)])
def test_faces_that_have_opened_and_closed_again(solver: str, kept: bool, limit: float) -> None:
    """Open faces carry no shear and slip freely; closed again, they stick where they came down."""
    springs = Springs(solver, cohesion=COHESION, kept=kept)
    (stuck,) = springs.follow(0.6)
    (opened,) = springs.follow(0.6, pressure=-0.1, last=stuck)
    assert states([stuck, opened]) == [STICK, OPEN]
    assert not opened.points.tangential.any()
    assert opened.memory.broken.all()
    np.testing.assert_allclose(opened.points.slip, 0.6 * PRESSURE / KT)
    closed, sliding = springs.follow(0.7, 1.7, last=opened)
    assert states([closed, sliding]) == [STICK, SLIP]
    np.testing.assert_allclose(closed.points.slip, opened.points.slip)
    np.testing.assert_allclose(closed.points.tangential, 0.1 * PRESSURE, rtol=1e-9)
    np.testing.assert_allclose(sliding.points.tangential, limit * PRESSURE)


def test_one_point_that_breaks_can_take_its_neighbours_along(solver: str) -> None:
    """Only the last one is beyond its limit; the shear that it drops breaks the others in the same increment."""
    springs = Springs(solver, coupling=1e3, cohesion=COHESION)
    (held,) = springs.follow(0.85)
    assert not held.memory.broken.any()
    uneven = replace(springs.contact.law, cohesion=np.array([[0.4, 0.4, 0.2], [0.0] * 3]) * PRESSURE)
    springs.contact = replace(springs.contact, law=uneven)
    (outcome,) = springs.follow(0.85)
    assert outcome.memory.broken.all()
    np.testing.assert_allclose(outcome.points.tangential, 0.5 * PRESSURE)


def test_dilation_that_does_not_settle_is_an_error(solver: str) -> None:
    """The opening that is asked for is no number: never a silent result."""
    with pytest.raises(SolveError, match=r"was not solved|residual"):
        Springs(solver, dilation=1e12).follow(1.5)


@pytest.mark.parametrize("pressure", [1.0, 1e5, 1.1e6, 1e9])
def test_how_hard_others_are_pressed_does_not_open_a_point(solver: str, pressure: float) -> None:
    """Two points that know nothing of each other: the first is pressed by 1 and sheared by half of its limit."""
    law = uniform_law(2, 0.6, residual_friction=0.1)
    outcome = solve(10.0 * np.eye(4), law, solver, [-1.0, -pressure, 0.3, 0.0])
    assert outcome.points.state.tolist() == [STICK, STICK]
    assert not outcome.memory.broken.any()
    np.testing.assert_allclose(outcome.points.tangential[0], 0.3, rtol=1e-9)


def test_dilation_that_presses_a_neighbour_keeps_it_from_breaking(solver: str) -> None:
    """Slip opens the first by d s, and a lever presses the second the more, K_nn = [[2, 1], [1, 2]]: it sticks."""
    d, mu, T, P = 0.5, 0.5, np.array([4.0, 0.9]), np.array([1.0, 1.0])
    K, loads = block_diag([[[2.0, 1.0], [1.0, 2.0]], np.eye(2)]).toarray(), np.concatenate([-P, T])
    law = uniform_law(2, mu, residual_friction=[mu, 0.1], dilation=d)
    outcome = solve(K, law, solver, loads)
    s = (T[0] - mu * P[0]) / (1.0 + 2.0 * mu * d)
    np.testing.assert_allclose(outcome.points.normal, -P - d * s * np.array([2.0, 1.0]), rtol=1e-12)
    np.testing.assert_allclose(outcome.points.slip, [s, 0.0], atol=1e-12)
    assert outcome.memory.broken.tolist() == [True, False]
    assert solve(K, replace(law, dilation=np.zeros((2, 2))), solver, loads).memory.broken.all()


def test_elastic_contact_remembers_its_inelastic_slip_alone(solver: str) -> None:
    """kt (s + e p_t) + p_t = T: stuck after sliding to s, the traction follows the shear by 1 / (1 + kt e)."""
    e = 1.0 / 25.0
    limit = FRICTION * PRESSURE / (1.0 + KN * e)
    sliding, stuck = Springs(solver, compliance=e).follow(1.5, 1.4)
    s = (1.5 * PRESSURE - limit * (1.0 + KT * e)) / KT
    np.testing.assert_allclose(sliding.memory.slip, s, rtol=1e-10)
    np.testing.assert_allclose(sliding.points.slip, s + e * limit, rtol=1e-10)
    assert states([sliding, stuck]) == [SLIP, STICK]
    np.testing.assert_allclose(stuck.memory.slip, s, rtol=1e-10)
    np.testing.assert_allclose(stuck.points.tangential, (1.4 * PRESSURE - KT * s) / (1.0 + KT * e), rtol=1e-10)


def test_only_closed_points_begin_an_increment_bonded(solver: str) -> None:
    """Slip opens a point on a lever: gap = -P + T/2 - p_n - p_t/2, slip = T - P/2 - p_t - p_n/2; its bond holds it."""
    K, law = np.linalg.inv([[1.0, 0.5], [0.5, 1.0]]), uniform_law(1, 0.5, 0.4, kept=True)
    outcomes: list[ContactOutcome] = []
    for pressure, shear in ((0.1, 0.35), (0.1, 0.5), (0.1, 0.45), (-1.0, 0.0), (0.1, 0.5)):
        memory = outcomes[-1].memory if outcomes else None
        outcomes.append(solve(K, law, solver, [-pressure, shear], memory))
    stuck, slipped, back, opened, still_open = outcomes
    assert states(outcomes) == [STICK, SLIP, STICK, OPEN, OPEN]
    np.testing.assert_allclose([*stuck.points.normal, *stuck.points.tangential], [-0.1, 0.35], rtol=1e-12)
    np.testing.assert_allclose([*slipped.points.normal, *slipped.points.slip], [-1.0 / 15.0, 0.05], rtol=1e-12)
    np.testing.assert_allclose([*back.points.tangential, *back.points.slip], [0.75 - 11.0 / 30.0, 0.05], rtol=1e-12)
    np.testing.assert_allclose(opened.points.opening, 1.0, rtol=1e-12)
    np.testing.assert_allclose(still_open.points.opening, 0.15, rtol=1e-12)
    assert not still_open.points.tangential.any()


def test_faces_that_touch_without_pressure_cohere(solver: str) -> None:
    """|p_t| <= c - mu p_n at p_n = 0: they stick up to the cohesion, slip beyond it and lose it."""
    stuck, slipped = Springs(solver, cohesion=COHESION).follow(0.39, 0.41, pressure=0.0)
    assert states([stuck, slipped]) == [STICK, OPEN]
    np.testing.assert_allclose(stuck.points.tangential, 0.39 * PRESSURE, rtol=1e-12)
    assert not stuck.memory.broken.any()
    assert slipped.memory.broken.all()
    np.testing.assert_allclose(slipped.points.slip, 0.41 * PRESSURE / KT, rtol=1e-12)
    (kept,) = Springs(solver, cohesion=COHESION, kept=True).follow(0.41, pressure=0.0)
    assert states([kept]) == [SLIP]
    np.testing.assert_allclose(kept.points.tangential, COHESION * PRESSURE, rtol=1e-12)
    np.testing.assert_allclose(kept.points.slip, 0.01 * PRESSURE / KT, rtol=1e-9)
