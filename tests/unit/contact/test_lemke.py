"""Lemke's method on problems that are hard for it: each answer is checked from the problem alone, row by row."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.lemke import LcpResult, lemke


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


@pytest.mark.parametrize("n", [3, 20, 70, 130])
def test_random_positive_definite(n):
    rng = np.random.default_rng(n)
    B = rng.normal(size=(n, n))
    M = B @ B.T / n + 0.1 * np.eye(n) + (lambda S: S - S.T)(rng.normal(size=(n, n)))
    z = np.where(rng.random(n) < 0.5, rng.random(n), 0.0)
    q = np.where(z > 0.0, 0.0, rng.random(n)) - M @ z
    before = M.copy(), q.copy()
    result = lemke(M, q, d=rng.uniform(0.5, 2.0, n))
    check(M, q, result)
    np.testing.assert_allclose(result.z, z, atol=1e-10)
    np.testing.assert_array_equal(M, before[0])
    np.testing.assert_array_equal(q, before[1])


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


RELATIVE = 1e-9


"""Violation of a row of w = M z + q against the terms that it is the sum of."""


def violation(M: np.ndarray, q: np.ndarray, result: LcpResult) -> float:
    """Worst relative violation of w = M z + q, w >= 0, z >= 0, z w = 0; reads z and w of the result alone."""
    z, w = result.z, result.w
    terms = np.abs(M) @ np.abs(z) + np.abs(q)
    size = np.where(terms > 0.0, terms, 1.0)
    largest = max(float(np.abs(z).max()), np.finfo(float).tiny)
    return max(
        float((np.abs(w - M @ z - q) / size).max()),
        float((-w / size).max()),
        float((-z / largest).max()),
        float((np.abs(w) / size * np.abs(z) / largest).max()),
    )


def check(M: np.ndarray, q: np.ndarray, result: LcpResult) -> None:
    assert result.status == "solved"
    assert violation(M, q, result) <= RELATIVE


def murty(n: int) -> np.ndarray:
    """P-matrix for which the rows' order makes complementary pivoting visit every basis (Murty 1978)."""
    return np.eye(n) + 2.0 * np.tril(np.ones((n, n)), -1)


@pytest.mark.parametrize("n", [11, 12])
def test_murtys_example_is_solved_or_honestly_given_up(n: int) -> None:
    M, q = murty(n), -np.ones(n)
    whole = lemke(M, q, np.ones(n), max_pivots=2**n)
    check(M, q, whole)
    assert whole.pivots == 2**n
    assert whole.z.tolist() == [1.0] + [0.0] * (n - 1)
    given_up = lemke(M, q, np.ones(n))  # 1000 + 20 n pivots
    assert given_up.status == "limit"
    assert given_up.pivots == 1000 + 20 * n
    check(M, q, lemke(M, q))


@pytest.mark.parametrize("degenerate", [0.3, 0.9])
@pytest.mark.parametrize("seed", range(20))
def test_degenerate_integer_problems_end(seed: int, degenerate: float) -> None:
    """Copositive-plus matrices of small integers and right-hand sides full of equal numbers."""
    rng = np.random.default_rng(seed)
    B = rng.integers(-1, 2, (10, 10))
    S = rng.integers(-1, 2, (10, 10))
    M = (B @ B.T + S - S.T + np.eye(10)).astype(float)
    q = np.where(rng.random(10) < degenerate, -1.0, rng.integers(-1, 2, 10))
    check(M, q, lemke(M, q, max_pivots=500))


@pytest.mark.parametrize("spread", [6, 20, 60, 200, 600])
@pytest.mark.parametrize("which", ["rows", "columns", "both", "alike"])
def test_badly_scaled_rows_and_columns(which: str, spread: int) -> None:
    """Rows and columns in units that differ by `spread` powers of ten: the same problem, the same solution."""
    for seed in range(10):
        rng = np.random.default_rng(seed)
        n = 20
        B = rng.normal(size=(n, n))
        M = B @ B.T / n + 0.1 * np.eye(n)
        z = np.where(rng.random(n) < 0.5, rng.random(n), 0.0)
        q = np.where(z > 0.0, 0.0, rng.random(n)) - M @ z
        row, column = 10.0 ** rng.uniform(-0.25 * spread, 0.25 * spread, (2, n))
        row = np.ones(n) if which == "columns" else row
        column = {"rows": np.ones(n), "alike": row}.get(which, column)
        result = lemke(row[:, None] * M * column, row * q)
        check(row[:, None] * M * column, row * q, result)
        np.testing.assert_allclose(result.z * column, z, atol=1e-12)


@pytest.mark.parametrize(
    ("M", "q"),
    [
        ([[0.0, 0.0], [0.0, 1.0]], [-1e-12, -1.0]),  # a row of zeros can't be made positive, however small q
        ([[1.0, -1.0], [-1.0, 1.0]], [1.0, -2.0]),  # w_1 + w_2 = -1
        ([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [-1.0, -1.0, -1.0]),  # -z_1 - 1 >= 0
    ],
)
def test_problems_without_a_solution_end_in_a_ray(M: list[list[float]], q: list[float]) -> None:
    assert lemke(np.array(M), np.array(q)).status == "ray"


@pytest.mark.parametrize("exponent", range(-14, 15, 4))
def test_solved_is_never_said_of_a_wrong_solution(exponent: int) -> None:
    """Random matrices of no class, near-singular ones among them: any status, but "solved" only if it is."""
    statuses = set()
    for seed in range(40):
        rng = np.random.default_rng(seed)
        M = rng.normal(size=(8, 8))
        M[:, 1] = M[:, 0] + 10.0**exponent * M[:, 1]
        M[1] = M[0] + 10.0**exponent * M[1]
        q = rng.normal(size=8)
        result = lemke(M, q)
        statuses.add(result.status)
        if result.status == "solved":
            assert violation(M, q, result) <= 1e-8
    assert {"solved", "ray"} <= statuses
