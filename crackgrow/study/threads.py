"""One thread for linear algebra, settled before numpy loads: its and scipy's copies of BLAS would fight for the cores.

This module loads nothing of either, and neither must what calls it before.
"""

from __future__ import annotations

import os
from typing import Final

THREAD_SETTINGS: Final = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def one_thread() -> None:
    """Let linear algebra use one thread, unless the user says otherwise."""
    for name in THREAD_SETTINGS:
        os.environ.setdefault(name, "1")
