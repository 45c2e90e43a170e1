"""`crackgrow stability --short` finds nothing that is wrong and not told, on any axis."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.cli.console import EXIT_DONE
from crackgrow.study.stability.runner import AXES, CASE_AXES

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_short_study_of_all_axes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    code = cli.main(["stability", "--short", "--out", str(tmp_path)])
    with (tmp_path / "stability.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["axis"], row["value"], row["reason"]) for row in rows if row["verdict"] == "NO"] == []
    assert code == EXIT_DONE
    assert {row["axis"].replace(" x ", "-") for row in rows} == set(AXES)
    said = {(row["axis"], row["value"]) for row in rows if row["verdict"] == "said"}
    assert ("poisson", "0.49999, plane strain") in said
    assert ("stiffness", "1e+12 E/h, gauss") in said
    assert len(said) < 0.2 * len(rows)
    assert (tmp_path / "stability.png").stat().st_size > 10_000
    summary = (tmp_path / "stability.md").read_text(encoding="utf-8")
    assert summary.count("\n| ") > len(rows)


@pytest.mark.parametrize("name", ["interface_friction01", "block_rigid"])
def test_study_of_a_case_of_ones_own(name: str, tmp_path: Path) -> None:
    code = cli.main(["stability", str(ROOT / "cases" / f"{name}.yaml"), "--short", "--out", str(tmp_path)])
    with (tmp_path / "stability.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert code == EXIT_DONE
    assert {row["axis"] for row in rows} == set(CASE_AXES)
    assert {row["verdict"] for row in rows} == {"yes"}
