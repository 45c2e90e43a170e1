"""Linear algebra of numpy and scipy: one thread for each, whose copies of BLAS would fight for the cores, and room.

Nothing here loads either before it is used, and neither must what calls `one_thread`.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Iterator
from typing import Final

THREAD_SETTINGS: Final = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
WARM: Final = 256  # rows of a matrix that no shortcut for small ones takes

_settled = any(name in os.environ for name in THREAD_SETTINGS)  # by the user, or by `one_thread` before numpy loaded
_guard = threading.Lock()
_users = 0  # blocks of `single_threaded` that go on, in all threads
_limits = contextlib.ExitStack()  # what the first of them has set, and the last one takes back


def one_thread() -> None:
    """Let linear algebra use one thread, unless the user says otherwise: before numpy loads.

    Later it can't: then `single_threaded` does it. Nor does that ask the environment again, which others write to for
    processes that they start, such as Dask.
    """
    global _settled
    if "numpy" not in sys.modules:
        for name in THREAD_SETTINGS:
            os.environ.setdefault(name, "1")
        _settled = True


@contextlib.contextmanager
def single_threaded() -> Iterator[None]:
    """As `one_thread` where numpy is loaded, until the end of the block: then the user's threads are back."""
    global _users
    if _settled:
        yield
        return
    with _guard:
        if _users == 0:
            from threadpoolctl import threadpool_limits

            _limits.enter_context(threadpool_limits(limits=1, user_api="blas"))
        _users += 1
    try:
        yield
    finally:
        with _guard:
            _users -= 1
            if _users == 0:
                _limits.close()


def warm_up() -> None:
    """Have both copies of BLAS, numpy's and scipy's, take their work space: later they'd wait for memory for ever."""
    import numpy as np
    import scipy.linalg

    matrix = np.eye(WARM)
    scipy.linalg.lu_solve(scipy.linalg.lu_factor(matrix @ matrix), matrix)
    np.linalg.solve(matrix, matrix)
