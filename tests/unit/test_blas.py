"""Linear algebra has one thread while a case is solved, from Python too, and the user's threads afterwards."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import crackgrow
from crackgrow.blas import THREAD_SETTINGS, single_threaded
from crackgrow.run import loop

CASE = Path(__file__).resolve().parents[2] / "cases" / "compression30.yaml"


def threads() -> set[int]:
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def unset(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in THREAD_SETTINGS:
        monkeypatch.delenv(name, raising=False)


def test_a_case_is_solved_with_one_thread_and_the_user_s_are_back_between_its_steps(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    inside: list[set[int]] = []
    load = loop.load

    def looking(*arguments: object, **more: object) -> object:
        inside.append(threads())
        return load(*arguments, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(loop, "load", looking)
    case = crackgrow.load_case(CASE, ["numerics.spacing=4", "growth.steps=1"])
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


def test_an_error_gives_the_threads_back(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object) -> object:
        raise crackgrow.SolveError("singular")

    monkeypatch.setattr(loop, "load", fails)
    with threadpool_limits(2, "blas"):
        with pytest.raises(crackgrow.SolveError):
            crackgrow.solve(crackgrow.load_case(CASE, ["numerics.spacing=4"]))
        assert threads() == {2}


def test_what_the_user_has_set_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    with threadpool_limits(2, "blas"), single_threaded():
        assert threads() == {2}


def test_the_last_of_several_gives_the_threads_back() -> None:
    with threadpool_limits(2, "blas"):
        first, second = single_threaded(), single_threaded()
        first.__enter__()
        other = threading.Thread(target=second.__enter__)
        other.start()
        other.join()
        first.__exit__(None, None, None)
        assert threads() == {1}
        second.__exit__(None, None, None)
        assert threads() == {2}
