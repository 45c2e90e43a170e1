"""Kernels: compiled and as Python they do the same."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

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
