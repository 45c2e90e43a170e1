"""Lemke's method on problems that are hard for it: each answer is checked from the problem alone, row by row."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.lemke import LcpResult, lemke


def violation(M: np.ndarray, q: np.ndarray, result: LcpResult) -> float:
    """Worst violation of w = M z + q, w >= 0, z >= 0, z w = 0 against the terms of a row and the largest z."""
    z, w = result.z, result.w
    terms = np.abs(M) @ np.abs(z) + np.abs(q)
    w, off = (part / np.where(terms > 0.0, terms, 1.0) for part in (w, w - M @ z - q))
    z = z / max(float(np.abs(z).max()), np.finfo(float).tiny)
    return float(np.max([np.abs(off), -w, -z, np.abs(w * z)]))


@pytest.mark.parametrize("degenerate", [0.3, 0.9])
@pytest.mark.parametrize("seed", range(20))
def test_degenerate_integer_problems_end(seed: int, degenerate: float) -> None:
    """Copositive-plus matrices of small integers and right-hand sides full of equal numbers."""
    rng = np.random.default_rng(seed)
    B, S = rng.integers(-1, 2, (2, 10, 10))
    M = (B @ B.T + S - S.T + np.eye(10)).astype(float)
    q = np.where(rng.random(10) < degenerate, -1.0, rng.integers(-1, 2, 10))
    result = lemke(M, q, max_pivots=500)
    assert result.status == "solved"
    assert violation(M, q, result) <= 1e-9


@pytest.mark.parametrize("spread", [6, 60, 600])
@pytest.mark.parametrize("of", [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)])
def test_units_of_rows_and_columns_do_not_matter(of: tuple[float, float], spread: int) -> None:
    """They differ by `spread` powers of ten: the same problem, the same solution."""
    for seed in range(10):
        rng, n = np.random.default_rng(seed), 20
        B = rng.normal(size=(n, n))
        M = B @ B.T / n + 0.1 * np.eye(n)
        z = np.where(rng.random(n) < 0.5, rng.random(n), 0.0)
        q = np.where(z > 0.0, 0.0, rng.random(n)) - M @ z
        row, column = 10.0 ** (np.array(of)[:, None] * rng.uniform(-0.25 * spread, 0.25 * spread, (2, n)))
        result = lemke(row[:, None] * M * column, row * q)
        assert violation(row[:, None] * M * column, row * q, result) <= 1e-9
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
        assert result.status != "solved" or violation(M, q, result) <= 1e-8
    assert {"solved", "ray"} <= statuses
