"""Linear algebra: one thread while a case is solved, the user's afterwards; BLAS for kernels, also as Python."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import crackgrow
from crackgrow import blas
from crackgrow.blas import THREAD_SETTINGS, one_thread, single_threaded
from crackgrow.run import loop
from tests.scenes import shipped_case

CASE = "compression30"


def threads() -> set[int]:
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def unset(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blas, "_settled", False)


@pytest.mark.physics
def test_a_case_is_solved_with_one_thread_and_the_user_s_are_back_between_its_steps(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    inside: list[set[int]] = []
    load = loop.load

    def looking(*arguments: object, **more: object) -> object:
        inside.append(threads())
        return load(*arguments, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(loop, "load", looking)
    case = shipped_case(CASE, ["numerics.spacing=4", "growth.steps=1"])
    with threadpool_limits(2, "blas"):
        crackgrow.solve(case)
        assert threads() == {2}
        run = crackgrow.run_case(case, tmp_path)
        run.solution(0)
        assert threads() == {2}
        for _ in crackgrow.grow(case):
            assert threads() == {2}
    assert inside
    assert all(found == {1} for found in inside)


def test_what_the_user_has_set_stays() -> None:
    code = (
        "import numpy; from threadpoolctl import threadpool_info; from crackgrow import blas; blas.one_thread()\n"
        "with blas.single_threaded(): print({pool['num_threads'] for pool in threadpool_info()})"
    )
    environment = {name: value for name, value in os.environ.items() if name not in THREAD_SETTINGS}
    for settings, expected in (({"OPENBLAS_NUM_THREADS": "2"}, "{2}\n"), ({}, "{1}\n")):
        command = [sys.executable, "-c", code]
        done = subprocess.run(command, env=environment | settings, capture_output=True, text=True, check=True)
        assert done.stdout == expected


def test_settings_that_come_too_late_are_not_taken_for_the_user_s(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of the command line in a program that has loaded numpy, and of Dask for the workers that it starts.

    Runs after them had several threads, and other bits than those of the command line.
    """
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    with threadpool_limits(2, "blas"):
        one_thread()
        assert "OPENBLAS_NUM_THREADS" not in os.environ
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
        with single_threaded():
            assert threads() == {1}
        assert threads() == {2}


CODE = """
import numpy as np
from crackgrow.compiled import add_product, add_square, cholesky, solve_upper, syrk
rows = np.arange(12.0).reshape(4, 3)
product = np.zeros((3, 3))
syrk(rows, product)
assert np.array_equal(product, np.tril(rows.T @ rows)), product
large = np.zeros((6, 7))
total = large[1:4, 2:5]  # a part of an array, as all others below
add_square(rows, total, -2.0)
assert np.array_equal(total, np.triu(-2.0 * rows.T @ rows)), total
assert large.sum() == total.sum()
total[:] = 1.0
add_product(rows, rows, total, 2.0, True)
assert np.array_equal(total, 1.0 + 2.0 * rows.T @ rows), total
square, other = np.arange(9.0).reshape(3, 3), np.ones((4, 3))
add_product(rows, square, other, -1.0, False)
assert np.array_equal(other, 1.0 - rows @ square), other
total[:] = rows.T @ rows + np.eye(3)
matrix = total.copy()
assert cholesky(total) == 0
upper = np.triu(total)
assert np.allclose(upper.T @ upper, matrix, rtol=1e-14)
for transposed, factor in ((True, upper.T), (False, upper)):
    right = rows.T.copy()
    solve_upper(total, right, transposed)
    assert np.allclose(factor @ right, rows.T, rtol=1e-13)
assert cholesky(-np.eye(2)) == 1
none, wide = np.zeros((0, 3)), np.ones((3, 0))
for nothing in (lambda: add_square(none, total, 1.0), lambda: add_product(none, none, total, 1.0, True)):
    before = total.copy()
    nothing()
    assert np.array_equal(total, before)
solve_upper(total, wide, True)
assert cholesky(np.zeros((0, 0))) == 0
"""


@pytest.mark.parametrize("disabled", ["0", "1"])
def test_routines_of_blas_take_rows(disabled: str) -> None:
    environment = {**os.environ, "NUMBA_DISABLE_JIT": disabled}
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, env=environment, check=False)
    assert (done.returncode, done.stderr) == (0, "")
