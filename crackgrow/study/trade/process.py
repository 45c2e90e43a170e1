"""Runs in processes of their own, one after another: nothing is carried over from one to the next, one BLAS thread."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from crackgrow.blas import THREAD_SETTINGS
from crackgrow.study.trade.axes import CaseFile
from crackgrow.study.trade.worker import COST_FILE, Cost

WORKER = "crackgrow.study.trade.worker"
ROOT = Path(__file__).resolve().parents[3]  # that the package is imported from
NAN = float("nan")


def run_in_processes(
    file: CaseFile, overrides: Sequence[str], folder: Path, repeat: int, timeout: float | None
) -> Cost:
    """Run a setting `repeat` times into a folder and return its median cost; the results are those of the last run.

    A run that ends in any other way than a result tells it in `status`: `timeout` after so many seconds, `crashed`.
    Only a setting that was solved is repeated.
    """
    costs = []
    for _ in range(repeat):
        costs.append(_run_once(file, overrides, folder, timeout))
        if not costs[-1].cpu_steps:
            return costs[-1]
    return median_cost(costs)


def median_cost(costs: Sequence[Cost]) -> Cost:
    """The last of several costs of the same run, with the median of every time and memory."""

    def middle(values: Sequence[float]) -> float:
        return statistics.median(values)

    return replace(
        costs[-1],
        cpu_seconds=middle([cost.cpu_seconds for cost in costs]),
        wall_seconds=middle([cost.wall_seconds for cost in costs]),
        cpu_steps=tuple(map(middle, zip(*(cost.cpu_steps for cost in costs), strict=False))),
        wall_steps=tuple(map(middle, zip(*(cost.wall_steps for cost in costs), strict=False))),
        peak_memory_mb=middle([cost.peak_memory_mb for cost in costs]),
    )


def _run_once(file: CaseFile, overrides: Sequence[str], folder: Path, timeout: float | None) -> Cost:
    (folder / COST_FILE).unlink(missing_ok=True)
    command = [sys.executable, "-m", WORKER, str(file.path), str(folder), *file.overrides, *overrides]
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = {**os.environ, **dict.fromkeys(THREAD_SETTINGS, "1"), "PYTHONPATH": path}
    try:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=timeout)
    except subprocess.TimeoutExpired:
        return _failed("timeout", f"not done after {timeout:g} s")
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:] or [f"exit code {done.returncode}"]
        return _failed("crashed", last[0])
    found = json.loads((folder / COST_FILE).read_text(encoding="utf-8"))
    return Cost(**{**found, "cpu_steps": tuple(found["cpu_steps"]), "wall_steps": tuple(found["wall_steps"])})


def _failed(status: str, reason: str) -> Cost:
    return Cost(status, reason, NAN, NAN, (), (), NAN)
