"""What is told of a run: a line a step, its warnings, in summary.json its end, checks and errors; tables."""

from __future__ import annotations

import errno
import json
import math
import os
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from crackgrow import __version__
from crackgrow.results import tables
from crackgrow.results.atomic import OutputError, write_atomically, write_text
from crackgrow.results.gathered import Gathered
from crackgrow.results.log import step_line
from crackgrow.results.summary import K_error, K_spread, Tally, error_line, git_state, summarize
from crackgrow.run.result import RunEnd, StepResult
from crackgrow.run.warning_causes import StepWarning
from tests.unit.results.synthetic import make_case, make_end, make_result


def written(tally: Tally, end: RunEnd) -> dict[str, Any]:
    """The summary as it reads back."""
    text = json.dumps(summarize(make_case(), Tally.of(tally.record()), end, 12.5, 100.0), allow_nan=False)
    summary: dict[str, Any] = json.loads(text)
    return summary


def with_tips(step: int, *changes: dict[str, Any]) -> StepResult:
    """A step with one tip for each of `changes`: K = (3, -4), of size 5, with room enough."""
    K = {"K_I": 3.0, "K_II": -4.0, "K_I_error": 0.4, "K_II_error": 0.1, "K_I_spread": 0.02, "K_II_spread": 0.08}
    tip = replace(make_result(step).tips[1], **K, K_note="")
    return make_result(step, tips=tuple(replace(tip, **change) for change in changes))


def test_the_summary_of_a_run() -> None:
    """A check that is nan is the worst one, and null in JSON."""
    tally = Tally()
    for step, residual in enumerate((1e-12, math.nan, 2e-12)):
        cautions = (StepWarning("NOTE", "thin cell"),) if step else ()
        tally.add(make_result(step, residual=residual, step_warnings=cautions))
    tally.add_seconds("output", 1.0)
    summary = written(tally, make_end(2))
    wanted = {
        "case": "block", "version": __version__, "status": "completed", "stop_reason": "2 growth steps done",
        "steps_done": 2, "n_solves": 3, "n_dofs": {"first": 400, "last": 416}, "warnings": ["steps 1 to 2: thin cell"],
    }  # fmt: skip
    assert {name: summary[name] for name in wanted} == wanted
    assert summary["wall_seconds"]["total"] == 12.5
    assert summary["wall_seconds"]["by_phase"]["contact"] == 1.2
    assert summary["wall_seconds"]["by_phase"]["output"] == 1.188  # 3 x 0.0625 + 1, in ms
    worst = {"penetration": (2e-15, 1), "residual": (None, 1), "energy_error": (1e-6, 0), "overlap": (2e-9, 0)}
    for check, (value, step) in worst.items():
        assert summary["worst_checks"][check] == {"value": value, "step": step}


CROWDED = {"K_note": "the disc is small", "K_I": 9.0, "K_II": -12.0, "K_I_spread": 1.0, "K_II_error": 0.9}
STUCK = {"sticks": True, "K_I": 9e9, "K_I_error": 9e9, "K_I_spread": 9e9}
NOTHING = {"K_I": 3e-3, "K_II": -4e-3, "K_radius": 0.1}


@pytest.mark.parametrize(("tips", "stress", "spread", "error"), [
    ([{}], 0.0, 1.6, 8.0),
    ([{}, CROWDED], 0.0, 1.6, 6.0),  # the spread is that of tips with room, by their own largest K
    ([CROWDED], 0.0, math.nan, 6.0),
    ([], 0.0, math.nan, math.nan),
    ([{"K_I": 0.0, "K_II": 0.0}], 0.0, math.nan, math.nan),
    ([{"K_I": math.nan}], 0.0, math.nan, math.nan),
    ([STUCK, {}], 0.0, 1.6, 8.0),
    # 10 Pa make 10 sqrt(0.1 pi) = 5.6 Pa sqrt(m) of a crack with a half length of a tenth of a metre
    ([NOTHING], 10.0, math.nan, math.nan),
    ([NOTHING, {"K_radius": 0.1}], 10.0, 1.6, 8.0),
    ([NOTHING], 1.0, 1600.0, 8000.0),
])  # fmt: skip
def test_errors_of_K_are_relative_to_the_largest_K_of_the_step(
    tips: list[dict[str, Any]], stress: float, spread: float, error: float
) -> None:
    result = replace(with_tips(0, *tips), stress=stress)
    assert (K_spread(result), K_error(result)) == pytest.approx((spread, error), rel=1e-12, nan_ok=True)


def test_errors_are_those_of_the_worst_step_and_told_in_one_line() -> None:
    """Directions count at tips that grow."""
    tally, end = Tally(), replace(make_end(2), norm_error=2.25)
    for step, size in enumerate((2.0, 3.0, 1.0)):
        K = {"K_I_error": 0.2 * size, "K_II_spread": 0.04 * size, "K_error_expected": 0.05 * size}
        grows, waits = {"advanced": True, "kink_error_deg": size}, {"advanced": False, "kink_error_deg": 90.0}
        result = replace(with_tips(step, grows | K, waits), load_factor_error=4.0 * size, goal_error=0.5 * size)
        tally.add(replace(result, norm_error=1.5 if step == 0 else math.nan))
    found = written(tally, end)["error_estimate"]
    assert found.pop("energy_norm_percent") == {"first": 1.5, "last": 2.25}
    assert found == pytest.approx({
        "K_percent_at_most": 12.0, "K_percent_expected": 3.0, "K_spread_percent": 2.4, "kink_degrees_at_most": 3.0,
        "load_factor_percent_at_most": 12.0, "goal_percent_at_most": 1.5,
    })  # fmt: skip
    assert error_line(tally, end) == (
        "estimated error: 2.2 % of the energy norm, K by an expected 3 %, at most 12 % of the largest, directions of "
        "growth by 3 degrees, critical load factors by 12 %, numerics.goal by at most 1.5 % of its largest value"
    )


def git(folder: Path, *words: str) -> str:
    command = ["git", "-C", str(folder), "-c", "user.name=a", "-c", "user.email=a@b", *words]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


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


def test_the_log_names_every_tip_that_advanced_in_one_unit() -> None:
    result = with_tips(1, *({"crack": f"c{k}", "K_I": 4e5, "K_II": 0.0} for k in range(5)))
    log, told = (step_line(result, make_case(), 2e6, logged=logged) for logged in (True, False))
    assert log.count(" end (tension) K_I 0.400 K_II 0.000 MPa sqrt(m), ") == 5
    assert log.endswith(", 408 dofs, 4 contact iterations, 1.56 s")
    assert "c2 end" in told
    assert "c3 end" not in told
    assert ", 2 more, " in told


def overlap(name: str, percent: float) -> StepWarning:
    return StepWarning("OVERLAP", f"'{name}' overlaps by {percent:g} %", f"'{name}'", percent)


CLOSE = StepWarning("RIPPLE", "close", "tip")


@pytest.mark.parametrize(("cautions", "sentences"), [
    (  # a cause tells its worst place and lists the others
        {step: [overlap("a", 5), overlap("b", 30 if step == 7 else 6), *[overlap("c", 1)] * (step == 14)]
         for step in range(3, 15)},
        ["steps 3 to 14, worst 7: 'b' overlaps by 30 %; likewise 'a', 'c'"],
    ),
    (  # the important ones come first
        {0: [StepWarning("LEFT_OUT", "left out"), StepWarning("SAWING", "saw")],
         1: [StepWarning("UNBALANCED", "unbalanced")]},
        ["step 1: unbalanced", "step 0: saw", "step 0: left out"],
    ),
    ({step: [CLOSE] for step in (0, 2, 3, 4, 9)}, ["steps 0, 2 to 4, 9: close"]),
    (  # notes that differ in numbers alone are one
        {1: [StepWarning("NOTE", "left K_II at 0.12 of K"),
             StepWarning("NOTE", "another method")],
         2: [StepWarning("NOTE", "left K_II at 3e-05 of K")]},
        ["steps 1 to 2: left K_II at 0.12 of K", "step 1: another method"],
    ),
])  # fmt: skip
def test_a_cause_of_warnings_is_one_sentence(cautions: dict[int, list[StepWarning]], sentences: list[str]) -> None:
    gathered = Gathered()
    for step, each in cautions.items():
        gathered.add(step, each)
    assert gathered.sentences() == sentences
    assert gathered.sentences(with_steps=False) == [text.split(": ", 1)[1] for text in sentences]


def test_a_file_is_written_whole_or_stays_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "new" / "a.csv"
    write_text(path, "x,y\n1,µ\n")

    def write_half(temporary: Path) -> None:
        temporary.write_text("ha")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_atomically(path, write_half)
    assert path.read_bytes() == "x,y\n1,µ\n".encode()
    assert [file.name for file in path.parent.iterdir()] == ["a.csv"]


@pytest.mark.parametrize(("number", "room"), [(errno.ENOSPC, True), (errno.EDQUOT, True), (errno.EROFS, False)])
def test_what_the_system_refuses_names_the_file_and_asks_for_room(number: int, room: bool, tmp_path: Path) -> None:
    def write(temporary: Path) -> None:
        raise OSError(number, os.strerror(number), temporary)

    with pytest.raises(OutputError, match=rf"a\.csv: {os.strerror(number)}; .*choose another folder") as caught:
        write_atomically(tmp_path / "a.csv", write)
    assert ("make room" in str(caught.value)) == room
    assert caught.value.exit_code == 3


@pytest.mark.parametrize("name", ["tips", "events"])
def test_rows_from_a_step_on_are_dropped_and_a_row_that_a_kill_cut_off(name: str, tmp_path: Path) -> None:
    """ "1" may be the begin of a row of step 12."""
    table = tables.Table(tmp_path, name)
    table.extend([(step, "flaw") for step in (0, 1, 1, 2, 3)])
    table.write()
    whole = table.path.read_text()
    table.path.write_text(whole + "1")
    table.drop_from(3)
    assert table.path.read_text() == whole[: whole.index("\n3,") + 1]
    assert len(table) == 4
