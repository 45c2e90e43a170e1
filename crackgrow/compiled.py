"""Compilation of the kernels, and BLAS and LAPACK for them.

A kernel is a function of numbers and arrays in plain loops. Numba compiles it once and keeps it in a cache; with
NUMBA_DISABLE_JIT=1 it runs as Python. Importing this module loads Numba: only rooms that solve may do it.

Routines of SciPy's BLAS and LAPACK take addresses and store matrices by columns; those here take arrays (C order) and
hand over the transposes.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import llvmlite.binding
import numba
import numpy as np
from numba import types
from numba.extending import get_cython_function_address

from crackgrow.arrays import Floats

kernel: Callable[[Callable[..., Any]], Callable[..., Any]] = numba.njit(
    cache=True, error_model="numpy", nogil=True, fastmath={"contract", "reassoc", "nsz", "arcp"}
)
"""Compile a kernel. Sums may be reordered; what is not finite stays so."""


def _routine(name: str, n: int, module: str) -> Callable[..., None]:
    """A routine with n arguments, all of them addresses; compiled code knows it by a name, so that it can be cached."""
    address = get_cython_function_address(f"scipy.linalg.cython_{module}", name)
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * n)(address)
    llvmlite.binding.add_symbol(f"crackgrow_{name}", address)
    routine: Callable[..., None] = types.ExternalFunction(f"crackgrow_{name}", types.void(*[types.intp] * n))
    return routine


_dsyrk = _routine("dsyrk", 10, "blas")


@kernel
def syrk(rows: Floats, product: Floats) -> None:
    """Replace the lower triangle of `product` (n, n) by R' R, R = `rows` (k, n), both contiguous."""
    flags, numbers = np.array([85, 78], np.uint8), np.array([1.0, 0.0])  # U: the lower triangle of rows; N
    sizes = np.array([rows.shape[1], rows.shape[0]], np.int32)
    uplo, one, n = flags.ctypes.data, numbers.ctypes.data, sizes.ctypes.data
    _dsyrk(uplo, uplo + 1, n, n + 4, one, rows.ctypes.data, n, one + 8, product.ctypes.data, n)
    flags[0], numbers[0], sizes[0] = 0, 0.0, 0  # used after the call: else Numba would free them before it
