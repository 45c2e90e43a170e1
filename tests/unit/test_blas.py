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
ROOT = Path(__file__).parents[2]


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


@pytest.mark.physics
def test_routines_of_blas_are_those_of_kernels_without_compilation() -> None:
    """The direct solver calls all of them."""
    some = ["-k", "(superlu or repeat_each_other or is_that_of_solutions) and 5"]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/unit/linear", *some]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stdout
