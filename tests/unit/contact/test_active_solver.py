"""Linear solves of active sets: corrections of an earlier factorization against a new one, and when it is made."""

from __future__ import annotations

import numpy as np
import pytest

import crackgrow.contact.active_solver as module
from crackgrow.contact.active_solver import FEW_ROWS, ActiveSolver, solve_active
from crackgrow.contact.coulomb import ActiveSet, ContactProblem, jump
from tests.contact_problems import crack_problem

N = 120


def random_set(rng: np.random.Generator, n: int) -> ActiveSet:
    return ActiveSet(rng.random(n) < 0.8, rng.integers(-1, 2, n))


def changed(active: ActiveSet, rng: np.random.Generator, n_changed: int) -> ActiveSet:
    """The set with some points on any branch."""
    other = random_set(rng, len(active.slip))
    points = rng.choice(len(active.slip), n_changed, replace=False)
    closed, slip = active.closed.copy(), active.slip.copy()
    closed[points], slip[points] = other.closed[points], other.slip[points]
    return ActiveSet(closed, slip)


@pytest.fixture
def factorizations(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Sizes of the matrices that are factorized."""
    sizes: list[int] = []
    factorize = module._factors

    def counted(K: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        sizes.append(len(K))
        return factorize(K)

    monkeypatch.setattr(module, "_factors", counted)
    return sizes


@pytest.mark.parametrize("cohesion", [0.0, 0.2])
def test_corrections_are_as_good_as_factorizations(cohesion: float, factorizations: list[int]) -> None:
    problem = crack_problem(N, 0.6, cohesion, np.inf, 0.3, 5)
    rng = np.random.default_rng(1)
    active = random_set(rng, N)
    solver = ActiveSolver(problem)
    solver.solve(active)
    large = 0
    for _ in range(12):
        active = changed(active, rng, 3)
        factorizations.clear()
        p = solver.solve(active)
        large += max(factorizations) > FEW_ROWS
        exact = solve_active(problem, active)
        np.testing.assert_allclose(p, exact, rtol=0.0, atol=1e-11 * np.abs(exact).max())
    assert large <= 2  # as the changes add up


@pytest.mark.parametrize("friction", [None, 0.6])
def test_the_rows_of_every_branch_hold(friction: float | None) -> None:
    full = crack_problem(300, 0.6, 0.1, np.inf, 0.3, 2)
    problem = full if friction is not None else ContactProblem(full.compliance[:300, :300], full.free[:300])
    rng = np.random.default_rng(2)
    active = random_set(rng, 300) if friction is not None else ActiveSet(rng.random(300) < 0.8, np.ones(300, np.int64))
    solver = ActiveSolver(problem)
    for _ in range(4):
        p = solver.solve(active)
        du, size = jump(problem, p), np.abs(problem.free).max()
        closed = active.closed
        assert np.abs(du[:300][closed]).max() < 1e-11 * size
        assert not p[:300][~closed].any()
        if friction is not None:
            stuck = active.slip == 0
            assert np.abs(du[300:][stuck]).max() < 1e-11 * size
            bound = active.slip * (0.1 - 0.6 * p[:300])
            np.testing.assert_allclose(p[300:][~stuck], bound[~stuck], rtol=0.0, atol=1e-11 * np.abs(p).max())
        active = (
            changed(active, rng, 5)
            if friction is not None
            else ActiveSet(closed ^ (rng.random(300) < 0.02), active.slip)
        )


def test_many_changes_and_few_rows_are_factorized(factorizations: list[int]) -> None:
    problem = crack_problem(N, 0.6, 0.0, np.inf, 0.3, 5)
    rng = np.random.default_rng(3)
    solver = ActiveSolver(problem)
    unknown = []
    for _ in range(3):  # nothing in common
        active = random_set(rng, N)
        unknown.append(int(active.closed.sum() + (active.slip == 0).sum()))
        solver.solve(active)
    assert factorizations == unknown
    small = crack_problem(20, 0.6, 0.0, np.inf, 0.3, 5)
    solver, active = ActiveSolver(small), random_set(rng, 20)
    factorizations.clear()
    for _ in range(3):
        active = changed(active, rng, 1)
        solver.solve(active)
    assert len(factorizations) == 3


def test_a_correction_that_round_off_spoils_is_not_used() -> None:
    """What is kept is a factorization of nearly singular equations: points that lie on each other stick."""
    problem = crack_problem(N, 0.6, 0.0, np.inf, 0.0, 5)
    compliance = problem.compliance.copy()
    compliance[1], compliance[:, 1] = compliance[0], compliance[:, 0]
    compliance[1, 1] *= 1.0 + 1e-15
    twins = ContactProblem(compliance, problem.free, problem.friction)
    all_stuck = ActiveSet(np.ones(N, dtype=bool), np.zeros(N, dtype=np.int64))
    one_open = ActiveSet(np.arange(N) != 1, np.zeros(N, dtype=np.int64))
    solver = ActiveSolver(twins)
    solver.solve(all_stuck)
    p = solver.solve(one_open)
    exact = solve_active(twins, one_open)
    np.testing.assert_allclose(p, exact, rtol=0.0, atol=1e-10 * np.abs(exact).max())


def test_solving_leaves_the_tractions_alone_that_it_has_handed_out(factorizations: list[int]) -> None:
    problem = crack_problem(N, 0.6, 0.0, np.inf, 0.3, 5)
    rng = np.random.default_rng(4)
    active, solver = random_set(rng, N), ActiveSolver(problem)
    first = solver.solve(active)
    kept = first.copy()
    other = changed(active, rng, 2)
    second = solver.solve(other)
    np.testing.assert_array_equal(first, kept)
    second[:] = np.nan
    factorizations.clear()
    np.testing.assert_allclose(solver.solve(active), kept, rtol=0.0, atol=1e-11 * np.abs(kept).max())
    assert max(factorizations, default=0) < FEW_ROWS  # nor does it trust what others may have changed
