"""The study of extremes finds nothing that is wrong and not told, on any axis; its files have every row."""

from __future__ import annotations

import csv
from dataclasses import fields
from pathlib import Path

import pytest

from crackgrow.cli.console import EXIT_DIFFERENT, EXIT_DONE
from tests.stability.extremes import study
from tests.stability.extremes.table import COLUMNS, csv_text, summary_text
from tests.stability.extremes.trial import Row


def row(
    deviation: float = 1e-4, status: str = "solved", refusable: bool = False, axis: str = "a", value: str = "1"
) -> Row:
    return Row(axis, value, "itself", deviation, 1e-3, 1e5, 1, 1e-15, status, refusable, "why | not", 0.5)  # type: ignore[arg-type]


@pytest.mark.slow
def test_short_study_of_all_axes(tmp_path: Path) -> None:
    code = study.main(["--short", "--out", str(tmp_path)])
    with (tmp_path / "stability.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["axis"], row["value"], row["reason"]) for row in rows if row["verdict"] == "NO"] == []
    assert code == EXIT_DONE
    assert {row["axis"].replace(" x ", "-") for row in rows} == set(study.AXES)
    said = {(row["axis"], row["value"]) for row in rows if row["verdict"] == "said"}
    assert ("poisson", "0.49999, plane strain") in said
    assert ("stiffness", "1e+12 E/h, gauss") in said
    assert len(said) < 0.2 * len(rows)
    assert (tmp_path / "stability.png").stat().st_size > 10_000
    summary = (tmp_path / "stability.md").read_text(encoding="utf-8")
    assert summary.count("\n| ") > len(rows)


def test_a_NO_is_the_exit_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for rows, code in (([row()], EXIT_DONE), ([row(), row(2e-3)], EXIT_DIFFERENT)):
        monkeypatch.setattr(study, "rows_of", lambda *_, rows=rows, **__: iter(rows))
        assert study.main(["--out", str(tmp_path)]) == code


def test_csv_has_every_row_and_no_nan() -> None:
    lines = list(csv.DictReader(csv_text([row(), row(float("nan"), "refused")]).splitlines()))
    assert [line["verdict"] for line in lines] == ["yes", "NO"]
    assert [line["deviation"] for line in lines] == ["0.0001", ""]
    assert float(lines[0]["condition"]) == 1e5


def test_summary_counts_axis_by_axis() -> None:
    rows = [row(), row(2e-3, "warned", value="2"), row(2e-3, value="3"), row(axis="b")]
    first, second = (line.split(" | ") for line in summary_text(rows).splitlines()[2:])
    assert first[:4] == ["| a", "1 ... 3", "0.0001", "0.001"]
    assert first[-3:] == ["1", "1", "1 |"]
    assert second[-3:] == ["1", "0", "0 |"]


def test_files_are_written(tmp_path: Path) -> None:
    study.write(tmp_path / "new", [row(), row(float("nan"), "refused"), row(axis="b")])
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == [
        "stability.csv",
        "stability.md",
        "stability.png",
    ]
    assert "why / not" in (tmp_path / "new" / "stability.md").read_text(encoding="utf-8")


def test_all_that_is_known_of_a_row_is_a_column() -> None:
    assert set(COLUMNS) == {field.name for field in fields(Row)} - {"refusable"} | {"verdict"}
