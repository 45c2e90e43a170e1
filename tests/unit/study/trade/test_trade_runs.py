"""Real, short trades: what is on disk, that a study goes on where it stopped, and that a failure is a row."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.case import load_case
from crackgrow.errors import CaseError, SolveError
from crackgrow.results.declarations import PHASES
from crackgrow.study import processes
from crackgrow.study.setting import CaseFile, Setting
from crackgrow.study.timed_run import Cost, median_cost, run_in_processes
from crackgrow.study.trade.columns import COLUMNS
from crackgrow.study.trade.plan import Plan, plan_trade
from crackgrow.study.trade.row import Row, Run, read_rows, row_of
from crackgrow.study.trade.runner import trade

CASES = Path(__file__).parents[4] / "cases"
FLAW = CASES / "compression30.yaml"


def small(folder: Path, axes: Sequence[str], overrides: Sequence[str] = (), **settings: object) -> Plan:
    """A trade of compression30 without presets, against a spacing of 2 mm."""
    given = {"steps": 1, "reference": ["numerics.spacing=2"], **settings}
    return plan_trade(CaseFile(FLAW, tuple(overrides)), folder, axes=axes, presets=False, **given)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> tuple[Plan, list[Row]]:
    """Two settings and their reference."""
    plan = small(tmp_path_factory.mktemp("trade"), ["spacing=5,4"])
    return plan, list(trade(plan))


def test_rows_tell_errors_and_costs(study: tuple[Plan, list[Row]]):
    _, rows = study
    reference, coarse, fine = rows
    assert [row.name for row in rows] == ["reference", "spacing=5", "spacing=4"]
    assert all(row.cells["status"] == "completed" and row.cells["steps"] == "1" for row in rows)
    assert reference.cells["K_error"] == ""
    assert [row.number("spacing") for row in rows] == [0.002, 0.005, 0.004]
    assert 0.0 < fine.number("K_error") < coarse.number("K_error") < 0.1  # 2 spacings a flaw; README has 2 % from one
    assert 0.0 < fine.number("true_energy_error") < coarse.number("true_energy_error") < 0.5
    assert 0.2 < coarse.number("error_estimate") / coarse.number("true_energy_error") < 5.0  # it is an estimate
    assert 0.0 < fine.number("path_hausdorff") <= fine.number("path_frechet") < 2e-3  # less than an increment
    for row in rows:
        assert row.number("cpu_seconds") >= row.number("cpu_first_step") + row.number("cpu_step") > 0.0
        assert sum(row.number(f"wall_{phase}") for phase in PHASES) <= row.number("wall_seconds")
        assert 30.0 < row.number("peak_memory_mb") < 2000.0


def test_run_of_a_row_is_what_the_case_gives(study: tuple[Plan, list[Row]]):
    plan, rows = study
    case = load_case(plan.folder / "runs" / "spacing=5" / "case.yaml")
    assert case.numerics.spacing == rows[1].number("spacing") == 0.005
    summary = json.loads((plan.folder / "runs" / "spacing=5" / "summary.json").read_text())
    assert str(summary["n_dofs"]["first"]) == rows[1].cells["n_dofs"]


def test_files_hold_the_rows_and_a_picture(study: tuple[Plan, list[Row]]):
    plan, rows = study
    assert [row.cells for row in read_rows(plan.folder / "trade.csv")] == [row.cells for row in rows]
    assert (plan.folder / "trade.png").read_bytes().startswith(b"\x89PNG")


def test_resume_runs_what_is_missing_alone(study: tuple[Plan, list[Row]], monkeypatch: pytest.MonkeyPatch):
    plan, rows = study
    table = plan.folder / "trade.csv"
    whole = table.read_text()
    table.write_text("".join(whole.splitlines(keepends=True)[:3]))  # as if stopped in the last run
    ran: list[str] = []

    def recorded(file: object, overrides: Sequence[str], *rest: object) -> Cost:
        ran.append(overrides[0])
        return run_in_processes(file, overrides, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr("crackgrow.study.trade.runner.run_in_processes", recorded)
    new = list(trade(plan, resume=True))
    assert ran == ["numerics.spacing=4"]
    assert [row.name for row in new] == ["spacing=4"]
    again = read_rows(table)
    assert [row.name for row in again] == [row.name for row in rows]
    errors = COLUMNS[COLUMNS.index("steps") : COLUMNS.index("cpu_seconds")]
    assert [[row.cells[name] for name in errors] for row in again] == [
        [row.cells[name] for name in errors] for row in rows
    ]
    assert list(trade(plan, resume=True)) == []


def test_resume_with_other_axes_leaves_the_runs_that_are_there(study: tuple[Plan, list[Row]]):
    plan, rows = study
    other = small(plan.folder, ["spacing=6,5,4"])
    (new,) = trade(other, resume=True)
    assert new.name == "spacing=6"
    assert {path.name for path in (plan.folder / "runs").iterdir()} == {"spacing=4", "spacing=5", "spacing=6"}
    case = load_case(plan.folder / "runs" / "spacing=5" / "case.yaml")
    assert case.numerics.spacing == rows[1].number("spacing")


def test_resume_of_another_study_is_refused(study: tuple[Plan, list[Row]], tmp_path: Path):
    plan, _ = study
    with pytest.raises(CaseError, match="had another steps"):
        next(trade(small(plan.folder, ["spacing=5"], steps=2), resume=True))
    other = small(plan.folder, ["spacing=5"], reference=["numerics.spacing=1"], overrides=["growth.increment=1"])
    with pytest.raises(CaseError, match="had another case and reference"):
        next(trade(other, resume=True))
    with pytest.raises(CaseError, match="holds no trade"):
        next(trade(small(tmp_path, ["spacing=5"]), resume=True))


def test_table_of_another_version_is_not_gone_on_with(tmp_path: Path):
    table = tmp_path / "trade.csv"
    table.write_text("setting,seconds\nspacing=3,1\n")
    with pytest.raises(CaseError, match="has other columns"):
        read_rows(table)


def test_failing_settings_are_rows_and_do_not_stop_the_rest(study: tuple[Plan, list[Row]], tmp_path: Path):
    """An increment of less than 1e-4 of the spacing is refused; it fits the case's own spacing."""
    plan, _ = study
    axes = ["increment=0.00045 mm", "spacing=5,4"]
    refused, solved = trade(small(tmp_path, axes, steps=0, reference=[str(plan.reference_folder)]))
    assert (refused.cells["status"], solved.cells["status"]) == ("refused", "completed")
    assert "growth.increment: 0.00045 mm is less than 0.0001 of the lattice spacing" in refused.cells["reason"]
    assert refused.cells["K_error"] == refused.cells["cpu_step"] == ""
    assert solved.number("K_error") < 0.1
    assert len(read_rows(tmp_path / "trade.csv")) == 2
    assert (tmp_path / "trade.png").is_file()


def test_trade_of_which_nothing_is_solved_is_told_by_its_exit_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    plan = small(tmp_path, ["spacing=5"])
    rows = [
        row_of(Run(Setting(name, ()), None, Cost(status, "", 1.0, 1.0, (), (), 1.0), tmp_path))
        for name, status in (("reference", "completed"), ("spacing=5", "unsolved"))
    ]
    monkeypatch.setattr("crackgrow.study.trade.plan.plan_trade", lambda *_, **__: plan)
    for given, code in ((rows, 3), (rows[:1], 0)):
        monkeypatch.setattr("crackgrow.study.trade.runner.trade", lambda *_, given=given, **__: iter(given))
        assert cli.main(["trade", str(FLAW), "--out", str(tmp_path)]) == code


def test_run_that_the_reference_is_too_coarse_for_is_not_judged(study: tuple[Plan, list[Row]], tmp_path: Path):
    plan, _ = study
    (row,) = trade(small(tmp_path, ["spacing=3.9"], steps=0, reference=[str(plan.reference_folder)]))
    assert row.cells["status"] == "completed"
    assert row.cells["reason"].endswith("not judged: the spacing is less than 2 times that of the reference")
    assert row.cells["K_error"] == ""
    assert row.number("cpu_seconds") > 0.0


def test_reference_of_another_body_is_told_in_the_row(study: tuple[Plan, list[Row]], tmp_path: Path):
    """The reference has the whole body, the run a narrower one: no point outside of it has a stress there."""
    plan, _ = study
    narrow = ["bodies.rock.shape.rectangle.width=28", "supports.0.at=[-14, -27.5]", "supports.1.at=[14, -27.5]"]
    (row,) = trade(small(tmp_path, ["spacing=5"], reference=[str(plan.reference_folder)], overrides=narrow))
    assert row.cells["status"] == "completed"
    assert "no distance in energy: " in row.cells["reason"]
    assert row.cells["true_energy_error"] == ""
    assert row.number("K_error") > 0.0


def test_run_that_takes_too_long_or_crashes_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    file = small(tmp_path, ["spacing=5"]).file
    cost = run_in_processes(file, (), tmp_path / "slow", 3, 0.01)
    assert (cost.status, cost.reason) == ("timeout", "not done after 0.01 s")
    monkeypatch.setattr(processes, "CHILD", "crackgrow.no_such_module")
    cost = run_in_processes(file, (), tmp_path / "broken", 3, None)
    assert cost.status == "crashed"
    assert "No module named crackgrow.no_such_module" in cost.reason


def test_reference_that_cannot_be_solved_ends_the_study(tmp_path: Path):
    with pytest.raises(SolveError, match=r"the reference \(numerics\.spacing=2\) is timeout: not done after 0\.01 s"):
        next(trade(small(tmp_path, ["spacing=5"]), timeout=0.01))


def test_median_of_repeated_runs():
    costs = [Cost("completed", "", cpu, 2 * cpu, (cpu, 1.0), (cpu, 9.0), 50.0) for cpu in (3.0, 10.0, 1.0)]
    middle = median_cost(costs)
    assert (middle.cpu_seconds, middle.wall_seconds, middle.cpu_steps, middle.wall_steps) == (
        3.0,
        6.0,
        (3.0, 1.0),
        (3.0, 9.0),
    )


@pytest.mark.slow
def test_command_line_of_a_scene_without_growth(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    case, out = str(CASES / "interface_friction04.yaml"), tmp_path / "out"
    reference = ["--reference", "numerics.spacing=0.1"]
    assert cli.main(["trade", case, "--axis", "spacing=0.2", *reference, "--out", str(out)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "interface_friction04: 4 settings"
    assert lines[-2:] == ["5 new rows, 0 not solved", f"results in {out}"]
    rows = read_rows(out / "trade.csv")
    assert [row.preset for row in rows] == ["", "draft", "standard", "fine", ""]
    assert all(row.cells["K_error"] == row.cells["path_hausdorff"] == "" for row in rows)
    assert all("not judged" in row.cells["reason"] for row in rows[1:4])  # the presets: finer than half the reference
    assert 0.0 < rows[-1].number("pressure_error") < 0.2
    assert 0.0 < rows[-1].number("slip_error") < 0.2
