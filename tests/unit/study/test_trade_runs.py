"""Real, short trades."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.errors import SolveError
from crackgrow.study.trade import trade
from crackgrow.study.trade_plan import plan_trade

CASES = Path(__file__).parents[3] / "cases"
EXACT = 5.9363e6 * 1e-3**0.5
"""Pa sqrt(m), K_I of edge_tension by an independent code, good to 0.01 %."""


def test_an_edge_crack_converges_to_its_K(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    words = ["trade", str(CASES / "edge_tension.yaml"), "--json", "--out", str(out)]
    assert cli.main(words) == 0
    record = json.loads(capsys.readouterr().out)
    K_I = [row for row in record["rows"] if row["quantity"] == "K_I"]
    assert [row["setting"] for row in K_I] == ["draft", "standard", "fine"]
    for row in K_I:
        assert row["extrapolated"] == pytest.approx(EXACT, rel=2e-3)
        assert abs(row["value"] - EXACT) <= 2.0 * row["error"] * EXACT + 2e-4 * EXACT
    assert record["good_enough"]
    assert {path.name for path in out.iterdir()} == {
        "convergence.csv", "draft", "fine", "standard", "trade.csv", "trade.png"
    }  # fmt: skip
    rows = list(csv.DictReader((out / "trade.csv").read_text().splitlines()))
    assert [float(row["error"]) for row in rows] == [row["error"] for row in record["runs"]]
    assert all(float(row["cpu_seconds"]) > 0.0 and float(row["peak_memory_mb"]) > 50.0 for row in rows)


def test_wings_are_run_with_half_increments_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["trade", str(CASES / "compression30.yaml"), "--steps", "1", "--out", str(tmp_path / "out")]
    assert cli.main([*words, "--tolerance", "0.001 %", "--workers", "2"]) == 4
    told = capsys.readouterr().out
    assert "half increment" in told
    assert "would move the path" in told
    assert "not good enough" in told


def test_a_setting_without_a_first_step_is_told_and_run_again(tmp_path: Path) -> None:
    plan = plan_trade(CASES / "edge_tension.yaml", tmp_path / "out")
    with pytest.raises(SolveError, match=r"'draft' is failed: not done after 0\.01 s; mend that and --resume"):
        list(trade(plan, timeout=0.01))
    assert [row.done for row in trade(plan, resume=True)] == [True, True, True]
    summary = tmp_path / "out" / "draft" / "summary.json"
    summary.write_text(summary.read_text().replace('"completed"', '"failed"'))
    with pytest.raises(SolveError, match=r"'draft' is failed: .*; mend that and --resume"):  # though it has steps
        list(trade(plan, resume=True, timeout=0.01))
