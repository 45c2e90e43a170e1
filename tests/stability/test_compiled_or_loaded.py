"""A run whose process compiles its kernels and one that loads them: files with the same bits."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def test_where_kernels_come_from_changes_nothing(tmp_path: Path) -> None:
    """What a kernel calls is compiled into it: else the process would take whichever version it met first."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    files = []
    for name in ("compiled", "loaded"):
        command = ["run", "cases/compression30.yaml", "--out", str(tmp_path / name), "--set", "growth.steps=1"]
        done = subprocess.run(
            [sys.executable, "-m", "crackgrow", *command], capture_output=True, text=True, env=environment, check=False
        )
        assert done.returncode == 0, done.stderr
        files.append([(tmp_path / name / file).read_bytes() for file in ("tips.csv", "frames/step_0001.vtu")])
    assert files[0] == files[1]
