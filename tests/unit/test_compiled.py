"""Kernels: compiled and as Python they do the same."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

CODE = """
import numpy as np
from crackgrow.compiled import syrk
rows = np.arange(12.0).reshape(4, 3)
product = np.zeros((3, 3))
syrk(rows, product)
assert np.array_equal(product, np.tril(rows.T @ rows)), product
"""


@pytest.mark.parametrize("disabled", ["0", "1"])
def test_routines_of_blas_take_rows(disabled: str) -> None:
    environment = {**os.environ, "NUMBA_DISABLE_JIT": disabled}
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, env=environment, check=False)
    assert (done.returncode, done.stderr) == (0, "")
