"""Compilation of the kernels, and BLAS and LAPACK for them.

A kernel is a function of numbers and arrays in plain loops. Numba compiles it once and keeps it in a folder, below
NUMBA_CACHE_DIR if that is set, else in the package, else in the user's cache, where it can write; with
NUMBA_DISABLE_JIT=1 it runs as Python. Importing this module loads Numba: only rooms that solve may do it.

Routines of SciPy's BLAS and LAPACK take addresses and store matrices by columns; those here take arrays (C order) and
hand over the transposes.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import tempfile
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

import llvmlite.binding
import numba
import numpy as np
from numba import types
from numba.core import config, event
from numba.extending import get_cython_function_address

from crackgrow.arrays import Floats, Ints

WITH_KERNELS: Final = ("approximation", "linear", "solid", "compiled.py")
"""Where kernels are."""


def _folder() -> Path:
    """Where compiled kernels are kept: one folder for each state of all of them together.

    Numba knows that a kernel has changed by its own file, but not by those of the kernels that it has taken in.
    """
    package, digest = Path(__file__).parent, sha256()
    for room in WITH_KERNELS:
        for file in sorted((package / room).glob("*.py")) or [package / room]:
            text = file.read_bytes()
            if b"@kernel" in text:
                digest.update(text)
    name, places = f"kernels-{digest.hexdigest()[:16]}", [package / "__pycache__"]
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        places.insert(0, Path(given))
    with contextlib.suppress(RuntimeError):  # nobody's home
        places.append(Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "crackgrow")
    for place in places:
        with contextlib.suppress(OSError):
            (place / name).mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=place / name).close()
            return place / name
    return Path(tempfile.mkdtemp(prefix=name))  # for this process alone


_FOLDER: Final = str(_folder())


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a kernel. Sums may be reordered; what is not finite stays so."""
    fast = {"contract", "reassoc", "nsz", "arcp"}
    before, config.CACHE_DIR = config.CACHE_DIR, _FOLDER  # type: ignore[attr-defined]
    try:
        compiled: Callable[..., Any] = numba.njit(
            cache=True, error_model="numpy", nogil=True, fastmath=fast, forceinline=True
        )(function)
    finally:
        config.CACHE_DIR = before  # type: ignore[attr-defined]
    return compiled


class _Once(event.Listener):
    """Tells of the first kernel that is compiled: those that the cache has are not."""

    def __init__(self, tell: Callable[[], None]) -> None:
        self._tell: Callable[[], None] | None = tell

    def on_start(self, event: object) -> None:
        if self._tell is not None:
            self._tell()
            self._tell = None

    def on_end(self, event: object) -> None:
        pass


def before_compiling(tell: Callable[[], None]) -> None:
    """Have `tell` called before the first kernel is compiled, if any is."""
    event.register("numba:compile", _Once(tell))  # type: ignore[no-untyped-call]


def _routine(name: str, n: int, module: str) -> Callable[..., None]:
    """A routine with n arguments, all of them addresses; compiled code knows it by a name, so that it can be cached."""
    address = get_cython_function_address(f"scipy.linalg.cython_{module}", name)
    if config.DISABLE_JIT:  # type: ignore[attr-defined]
        return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * n)(address)
    llvmlite.binding.add_symbol(f"crackgrow_{name}", address)
    routine: Callable[..., None] = types.ExternalFunction(f"crackgrow_{name}", types.void(*[types.intp] * n))
    return routine


_dsyrk = _routine("dsyrk", 10, "blas")
_dgemm = _routine("dgemm", 13, "blas")
_dtrsm = _routine("dtrsm", 11, "blas")
_dpotrf = _routine("dpotrf", 5, "lapack")
_dpstrf = _routine("dpstrf", 9, "lapack")


@kernel
def syrk(rows: Floats, product: Floats) -> None:
    """Replace the lower triangle of `product` (n, n) by R' R, R = `rows` (k, n), both contiguous."""
    flags, numbers = np.array([85, 78], np.uint8), np.array([1.0, 0.0])  # U: the lower triangle of rows; N
    sizes = np.array([rows.shape[1], rows.shape[0]], np.int32)
    uplo, one, n = flags.ctypes.data, numbers.ctypes.data, sizes.ctypes.data
    _dsyrk(uplo, uplo + 1, n, n + 4, one, rows.ctypes.data, n, one + 8, product.ctypes.data, n)
    flags[0], numbers[0], sizes[0] = 0, 0.0, 0  # used after the call: else Numba would free them before it


@kernel
def add_square(rows: Floats, total: Floats, factor: float) -> None:
    """Add `factor` R' R to the upper triangle of `total` (n, n), R = `rows` (k, n); numbers of a row are contiguous."""
    if rows.size == 0:
        return
    flags, numbers = np.array([76, 78], np.uint8), np.array([factor, 1.0])  # L: the upper triangle of rows; N
    sizes = np.array([rows.shape[1], rows.shape[0], rows.strides[0] // 8, total.strides[0] // 8], np.int32)
    uplo, number, n = flags.ctypes.data, numbers.ctypes.data, sizes.ctypes.data
    at, to = rows.ctypes.data, total.ctypes.data
    _dsyrk(uplo, uplo + 1, n, n + 4, number, at, n + 8, number + 8, to, n + 12)
    flags[0], numbers[0], sizes[0] = 0, 0.0, 0


@kernel
def add_product(left: Floats, right: Floats, total: Floats, factor: float, transposed: bool) -> None:
    """Add `factor` A B to `total` (n, k), or A' B if `transposed`, A = `left`, B = `right`; rows are contiguous."""
    if left.size == 0 or right.size == 0:
        return
    flags, numbers = np.array([78, 84 if transposed else 78], np.uint8), np.array([factor, 1.0])  # N; N or T
    sizes = np.array([total.shape[1], total.shape[0], right.shape[0], 0, 0, 0], np.int32)
    sizes[3], sizes[4], sizes[5] = right.strides[0] // 8, left.strides[0] // 8, total.strides[0] // 8
    flag, number, n = flags.ctypes.data, numbers.ctypes.data, sizes.ctypes.data
    b, a, to = right.ctypes.data, left.ctypes.data, total.ctypes.data
    _dgemm(flag, flag + 1, n, n + 4, n + 8, number, b, n + 12, a, n + 16, number + 8, to, n + 20)
    flags[0], numbers[0], sizes[0] = 0, 0.0, 0


@kernel
def solve_upper(upper: Floats, right: Floats, transposed: bool) -> None:
    """Replace `right` (n, k) by U^-1 times it, or U'^-1 if `transposed`, U = `upper` (n, n); rows are contiguous."""
    if right.size == 0:
        return
    flags = np.array([82, 76, 84 if transposed else 78, 78], np.uint8)  # R, L, T or N, N
    one = np.ones(1)
    sizes = np.array([right.shape[1], right.shape[0], upper.strides[0] // 8, right.strides[0] // 8], np.int32)
    flag, n, number = flags.ctypes.data, sizes.ctypes.data, one.ctypes.data
    u, b = upper.ctypes.data, right.ctypes.data
    _dtrsm(flag, flag + 1, flag + 2, flag + 3, n, n + 4, number, u, n + 8, b, n + 12)
    flags[0], one[0], sizes[0] = 0, 0.0, 0


@kernel
def cholesky(matrix: Floats) -> int:
    """Replace the upper triangle of a symmetric `matrix` (n, n) by U with U' U; 0, or which pivot is not positive."""
    if matrix.size == 0:
        return 0
    flags, sizes = np.array([76], np.uint8), np.array([len(matrix), matrix.strides[0] // 8, 0], np.int32)
    n = sizes.ctypes.data
    _dpotrf(flags.ctypes.data, n, matrix.ctypes.data, n + 4, n + 8)
    flags[0] = 0
    return int(sizes[2])


@kernel
def dependent_of(matrix: Floats, least: float) -> Ints:
    """Return the rows of a symmetric `matrix` (n, n) whose pivots are at most `least`; replace its upper triangle.

    The largest pivot is taken first (Higham 1990): what is left is as small as its largest one.
    """
    n = len(matrix)
    if n == 0:
        return np.zeros(0, np.int64)
    flags, sizes = np.array([76], np.uint8), np.array([n, matrix.strides[0] // 8, 0, 0], np.int32)
    pivots, work = np.zeros(n, np.int32), np.zeros(2 * n + 1)
    work[2 * n] = least
    size, number = sizes.ctypes.data, work.ctypes.data
    _dpstrf(
        flags.ctypes.data,
        size,
        matrix.ctypes.data,
        size + 4,
        pivots.ctypes.data,
        size + 8,
        number + 16 * n,
        number,
        size + 12,
    )
    flags[0], work[0] = 0, 0.0
    return pivots[sizes[2] :].astype(np.int64) - 1
