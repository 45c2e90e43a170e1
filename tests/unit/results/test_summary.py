"""summary.json: how the run ended, and its worst checks with their steps."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace
from pathlib import Path

from crackgrow import __version__
from crackgrow.results.summary import Tally, git_state, summarize, summary_text
from crackgrow.run.caution import Cause, Caution
from crackgrow.run.result import RunEnd
from tests.unit.results.synthetic import make_case, make_end, make_event, make_result


def test_summary_of_a_run() -> None:
    tally = Tally()
    for step in range(3):
        tally.add(make_result(step, cautions=(Caution(Cause.NOTE, "thin cell"),) if step == 2 else ()))
    tally.add_seconds("output", 1.0)
    summary = json.loads(summary_text(summarize(make_case(), tally, make_end(2), 12.5, 100.0)))
    assert (summary["case"], summary["title"], summary["version"]) == ("block", "A block with a crack", __version__)
    assert (summary["status"], summary["stop_reason"]) == ("completed", "2 growth steps done")
    assert (summary["steps_done"], summary["n_solves"]) == (2, 3)
    assert summary["n_dofs"] == {"first": 400, "last": 416}
    assert summary["wall_seconds"]["total"] == 12.5
    assert summary["wall_seconds"]["by_phase"]["contact"] == 1.2
    assert summary["wall_seconds"]["by_phase"]["output"] == 1.188  # 3 x 0.0625 + 1, in ms
    assert summary["worst_checks"]["penetration"] == {"value": 2e-15, "step": 1}
    assert summary["worst_checks"]["residual"] == {"value": 1e-12, "step": 0}
    assert summary["worst_checks"]["energy_error"] == {"value": 1e-6, "step": 0}
    assert summary["warnings"] == ["step 2: thin cell"]
    (record,) = summary["cautions"]
    assert (record["cause"], record["words"], record["steps"]) == ("note", "thin cell", [[2, 2]])
    assert summary["events"] == []
    assert summary["peak_memory_mb"] > 10
    assert "git_commit" in summary


def test_nan_check_is_the_worst_and_null_in_json() -> None:
    tally = Tally()
    for step, residual in enumerate([1.0, float("nan"), 2.0]):
        tally.add(make_result(step, residual=residual))
    summary = json.loads(summary_text(summarize(make_case(), tally, make_end(2), 1.0, 100.0)))
    assert summary["worst_checks"]["residual"] == {"value": None, "step": 1}


def test_events_of_the_steps_and_of_an_unsolved_advance_are_listed() -> None:
    tally = Tally()
    tally.add(make_result(0))
    tally.add(make_result(1, events=(make_event(1),)))
    last = make_event(2, kind="break_through", tip="start", met="the outline of body 'rock'")
    end = replace(make_end(2), status="broke_through", events=(last,))
    first, second = json.loads(summary_text(summarize(make_case(), tally, end, 1.0, 100.0)))["events"]
    x, y = make_event(1).point
    assert first == {
        "step": 1,
        "kind": "coalescence",
        "crack": "flaw",
        "tip": "end",
        "x": x,
        "y": y,
        "met": "crack 'b, the second'",
    }
    assert (second["step"], second["kind"], second["tip"]) == (2, "break_through", "start")


def test_summary_of_a_run_without_a_step() -> None:
    summary = json.loads(summary_text(summarize(make_case(), Tally(), RunEnd("failed", "no support", ()), 1.0, 100.0)))
    assert (summary["status"], summary["steps_done"], summary["n_dofs"]) == ("failed", 0, None)


def git(folder: Path, *words: str) -> str:
    identity = ["-c", "user.name=a", "-c", "user.email=a@b"]
    return subprocess.run(
        ["git", "-C", str(folder), *identity, *words], check=True, capture_output=True, text=True
    ).stdout.strip()


def test_git_state_is_that_of_the_top_of_a_checkout(tmp_path: Path) -> None:
    assert git_state(tmp_path) == (None, None)
    git(tmp_path, "init", "--quiet")
    assert git_state(tmp_path) == (None, None)  # no commit yet
    (tmp_path / "inner").mkdir()
    (tmp_path / "a").write_text("1")
    git(tmp_path, "add", "a")
    git(tmp_path, "commit", "--quiet", "--message", "a")
    git(tmp_path, "tag", "-a", "v1", "-m", "v1")
    commit = git(tmp_path, "rev-parse", "HEAD")
    assert git_state(tmp_path) == (commit, False)
    assert git_state(tmp_path / "inner") == (None, None)
    (tmp_path / "a").write_text("2")
    assert git_state(tmp_path) == (commit, True)
