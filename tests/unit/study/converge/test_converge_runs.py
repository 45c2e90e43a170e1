"""A real, short convergence study."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.errors import SolveError
from crackgrow.study.converge.plan import plan_convergence
from crackgrow.study.converge.runner import converge

CASES = Path(__file__).parents[4] / "cases"
EXACT = 5.9363e6 * 1e-3**0.5
"""Pa sqrt(m), K_I of edge_tension by an independent code, good to 0.01 %."""


def test_an_edge_crack_converges_to_its_K(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["converge", str(CASES / "edge_tension.yaml"), "--json", "--out", str(tmp_path / "out")]
    assert cli.main(words) == 0
    record = json.loads(capsys.readouterr().out)
    (K_I,) = [row for row in record["rows"] if row["quantity"] == "K_I"]
    assert K_I["extrapolated"] == pytest.approx(EXACT, rel=2e-3)
    for rank in ("coarse", "middle", "fine", "own"):
        assert abs(K_I[rank] - EXACT) <= 2.0 * K_I[f"error_{rank}"] * EXACT + 2e-4 * EXACT
    assert record["good_enough"]
    assert (tmp_path / "out" / "converge.csv").is_file()
    assert sorted(path.name for path in (tmp_path / "out" / "runs").iterdir()) == ["draft", "fine", "standard"]


def test_wings_are_run_with_half_increments_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["converge", str(CASES / "compression30.yaml"), "--steps", "1", "--out", str(tmp_path / "out")]
    assert cli.main([*words, "--tolerance", "0.001 %", "--increments"]) == 4
    told = capsys.readouterr().out
    assert "half increments" in told
    assert "would move the path" in told
    assert "not good enough" in told


def test_a_setting_without_a_first_step_is_told(tmp_path: Path) -> None:
    plan = plan_convergence(CASES / "compression30.yaml", tmp_path, steps=1)
    with pytest.raises(SolveError, match="'draft' is timeout"):
        list(converge(plan, timeout=0.01))
