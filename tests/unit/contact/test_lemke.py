"""Lemke's method on small, degenerate and unsolvable problems, and on contact by hand."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

import crackgrow.contact.contact_lcp as module
from crackgrow.contact.contact_lcp import solve_by_lemke
from crackgrow.contact.coulomb import OPEN, SLIP, STICK
from crackgrow.contact.lemke import lemke
from crackgrow.contact.problem import ContactProblem
from crackgrow.contact.tableau import Tableau
from crackgrow.errors import SolveError
from tests.contact_problems import smooth

EXACT = 1e-12


@pytest.mark.parametrize(
    ("m", "q", "status", "z"),
    [
        (1.0, -1.0, "solved", 1.0),
        (1.0, 0.0, "solved", 0.0),
        (1.0, 1.0, "solved", 0.0),
        (0.0, -1.0, "ray", 0.0),
        (0.0, 0.0, "solved", 0.0),
        (0.0, 1.0, "solved", 0.0),
        (-1.0, -1.0, "ray", 0.0),
        (-1.0, 0.0, "solved", 0.0),
        (-1.0, 1.0, "solved", 0.0),
        (4.0, -2.0, "solved", 0.5),
    ],
)
def test_one_by_one(m, q, status, z):
    result = lemke(np.array([[m]]), np.array([q]))
    assert result.status == status
    assert result.z.tolist() == [z]


@pytest.mark.parametrize("n", range(2, 8))
def test_fathi_example_needs_many_pivots_and_ends(n):
    L = np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1)
    M, q = L @ L.T, -np.ones(n)
    result = lemke(M, q, np.ones(n))
    assert result.status == "solved"
    assert result.pivots == 2**n
    assert np.abs(np.minimum(result.z, M @ result.z + q)).max() <= 1e-10  # condition number up to 1e6


def test_leaving_row_is_the_lexicographic_minimum():
    """Against the definition: the least row of (value, inverse basis) / entry, on degenerate integer problems."""
    n_ties = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        B = rng.integers(-1, 2, (5, 5))
        M, d = (B @ B.T + np.eye(5)).astype(float), np.ones(5)
        table = Tableau(M, -rng.integers(0, 2, 5).astype(float) - 1.0, d)
        columns = np.column_stack([np.eye(5), -M, -d])
        leaving = table.pivot(table.first_row(d), 5)
        while leaving != 10:
            entering = int(table.place[(leaving + 5) % 10])
            inverse = np.linalg.inv(columns[:, table.basic])
            entries = inverse @ columns[:, table.nonbasic[entering]]
            rows = np.flatnonzero(entries > 1e-9)
            keys = np.round(np.column_stack([table.value, inverse])[rows] / entries[rows, None], 9) + 0.0
            ties = rows[keys[:, 0] == keys[:, 0].min()]
            n_ties += ties.size > 1
            row = table.leaving_row(entering)
            if np.any(table.basic[ties] == 10):
                assert table.basic[row] == 10
            else:
                assert row == rows[min(range(rows.size), key=lambda i, keys=keys: tuple(keys[i]))]
            leaving = table.pivot(row, entering)
    assert n_ties > 20


@pytest.mark.parametrize(("rest", "status"), [(1e-11, "solved"), (1e-3, "ray")])
def test_ray_with_next_to_no_artificial_variable_is_a_solution(rest, status):
    """z = (1, any) but for w_2 = -rest."""
    result = lemke(np.array([[1.0, 0.0], [1.0, 0.0]]), np.array([-1.0, -1.0 - rest]), np.array([1.0, 2.0]))
    assert result.status == status


def test_limit_of_pivots():
    L = np.eye(6) + 2.0 * np.tril(np.ones((6, 6)), -1)
    result = lemke(L @ L.T, -np.ones(6), np.ones(6), max_pivots=3)
    assert result.status == "limit"
    assert result.pivots == 3


@pytest.mark.parametrize("n", [3, 20, 70, 130])
def test_random_positive_definite(n):
    rng = np.random.default_rng(n)
    B = rng.normal(size=(n, n))
    M = B @ B.T / n + 0.1 * np.eye(n) + (lambda S: S - S.T)(rng.normal(size=(n, n)))
    z = np.where(rng.random(n) < 0.5, rng.random(n), 0.0)
    q = np.where(z > 0.0, 0.0, rng.random(n)) - M @ z
    before = M.copy(), q.copy()
    result = lemke(M, q, d=rng.uniform(0.5, 2.0, n))
    assert result.status == "solved"
    np.testing.assert_allclose(result.z, z, atol=1e-10)
    np.testing.assert_array_equal(M, before[0])
    np.testing.assert_array_equal(q, before[1])


def test_p_matrices_against_enumeration():
    rng = np.random.default_rng(9)
    for _ in range(30):
        B = rng.normal(size=(4, 4))
        M, q = B @ B.T + 0.1 * np.eye(4), rng.integers(-2, 3, 4).astype(float)
        result = lemke(M, q)
        assert result.status == "solved"
        np.testing.assert_allclose(result.z, enumerate_solutions(M, q), atol=1e-10)


def enumerate_solutions(M, q):
    """The one solution of a problem with a positive definite matrix, by trying every basis."""
    n = q.size
    for size in range(n + 1):
        for J in itertools.combinations(range(n), size):
            z = np.zeros(n)
            z[list(J)] = np.linalg.solve(M[np.ix_(J, J)], -q[list(J)])
            if z.min() >= -EXACT and (M @ z + q).min() >= -EXACT:
                return z
    raise AssertionError("a positive definite problem has a solution")


@pytest.mark.parametrize(
    ("M", "q", "d", "name"),
    [
        (np.eye(3), np.zeros(2), None, "M"),
        (np.array([[np.nan]]), np.zeros(1), None, "M"),
        (np.eye(1), np.array([np.inf]), None, "q"),
        (np.eye(2), np.zeros(2), np.ones(3), "d"),
        (np.eye(2), np.zeros(2), np.array([1.0, 0.0]), "d"),
    ],
)
def test_wrong_input_is_refused(M, q, d, name):
    with pytest.raises(ValueError, match=f"lemke {name}"):
        lemke(M, q, d)


@pytest.mark.parametrize(
    ("free_n", "free_t", "friction", "cohesion", "p_n", "p_t", "state"),
    [
        (1.0, 3.0, 0.5, 0.0, 0.0, 0.0, OPEN),
        (1.0, 3.0, 0.5, 0.2, 0.0, 0.2, OPEN),
        (-2.0, 1.0, 0.5, 0.0, -1.0, 0.25, STICK),
        (-2.0, 8.0, 0.5, 0.0, -1.0, 0.5, SLIP),
        (-2.0, -8.0, 0.5, 0.25, -1.0, -0.75, SLIP),
        (-2.0, 8.0, 0.0, 0.0, -1.0, 0.0, SLIP),
        (-2.0, 8.0, 5.0, 0.0, -1.0, 2.0, STICK),
    ],
)
@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e9])
def test_one_contact_point_by_hand(free_n, free_t, friction, cohesion, p_n, p_t, state, unit):
    problem = ContactProblem(
        np.diag([2.0, 4.0]) / unit, np.array([free_n, free_t]), np.array([friction]), np.array([cohesion * unit])
    )
    solution = solve_by_lemke(problem)
    assert solution.status == "solved"
    np.testing.assert_allclose(solution.traction, np.array([p_n, p_t]) * unit, atol=1e-12 * unit)
    assert solution.state.tolist() == [state]


@pytest.mark.parametrize("end", ["ray", "limit"])
@pytest.mark.parametrize("off", [0.0, 0.1])
def test_what_counts_of_an_end_is_whether_the_law_holds(monkeypatch, end, off):
    """Round-off makes rays of solutions of hundreds of points; where the law does not hold a ray is one."""

    def ends(M, q, d):
        result = lemke(M, q, d)
        return replace(result, status=end, z=result.z + off, w=result.w + off)

    monkeypatch.setattr(module, "lemke", ends)
    monkeypatch.setattr(module, "solve_active", lambda problem, active: np.full(2, off - 1.0))  # no better
    problem = ContactProblem(np.diag([2.0, 4.0]), np.array([-2.0, 8.0]), np.array([0.5]))
    assert solve_by_lemke(problem).status == (end if off else "solved")


def test_singular_compliance_is_refused():
    with pytest.raises(SolveError, match="condition number"):
        solve_by_lemke(smooth(np.ones((2, 2)), -np.ones(2)))


def test_no_contact_points():
    assert solve_by_lemke(ContactProblem(np.zeros((0, 0)), np.zeros(0), np.zeros(0))).status == "solved"
