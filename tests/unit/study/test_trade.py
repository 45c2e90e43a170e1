"""Whether a setting is good enough: what a trade is going to run, what it refuses, and real, short trades."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.errors import CaseError
from crackgrow.study.trade_plan import OWN, TradePlan, plan_trade

CASES = Path(__file__).parents[3] / "cases"
FLAW = CASES / "compression30.yaml"
EXACT = 5.9363e6 * 1e-3**0.5
"""Pa sqrt(m), K_I of edge_tension by an independent code, good to 0.01 %."""

GIVEN = ("numerics.spacing=1.5",)


def plan(folder: Path, **asked: object) -> TradePlan:
    return plan_trade(FLAW, folder, **asked)  # type: ignore[arg-type]


def test_the_own_setting_is_one_of_the_three_where_it_is_the_same(tmp_path: Path) -> None:
    assert plan(tmp_path).own == "standard"
    assert plan(tmp_path, overrides=("numerics.accuracy=fine",)).own == "fine"
    own = plan(tmp_path, overrides=GIVEN)  # its spacing is given
    assert own.own == OWN
    spacings = [run.case.numerics.spacing for run in own.study.runs if run.case]
    assert spacings[3:] == [1.5e-3, 1.5e-3]  # with half the increment, too


def test_targets_are_settings_too(tmp_path: Path) -> None:
    found = plan(tmp_path, settings=("3%", "1 %", "0.003", "0.002"))
    targets = [run.case.numerics.target for run in found.study.runs if run.case]
    assert targets[:4] == [0.03, 0.01, 0.003, 0.002]
    same = plan(tmp_path, overrides=("numerics.accuracy=1 %",), settings=("3%", "1%", "0.3%"))
    assert same.own == "1%"


@pytest.mark.parametrize(("increments", "steps"), [
    (("half",), [6]), (("1.5 mm", "1", "0.3"), [4, 6, 20]), (("none",), [])
])  # fmt: skip
def test_increments_grow_by_the_same_length(tmp_path: Path, increments: tuple[str, ...], steps: list[int]) -> None:
    """Of three increments of 2 mm; the longest first."""
    found = plan(tmp_path, steps=3, increments=increments)
    grown = [run.case.growth.steps for run in found.study.runs[3:] if run.case and run.case.growth]
    assert grown == steps
    assert len(found.increments) == len(steps)
    assert plan(tmp_path, steps=0).increments == ()


@pytest.mark.parametrize(("asked", "key", "words"), [
    ({"settings": ("draft", "fine")}, "--at", "three settings"),
    ({"increments": ("1 mm", "5 mm")}, "--increments", "shorter than the case's own"),
    ({"increments": ("2 mm",)}, "--increments", "shorter than the case's own"),
    ({"settings": ("draft", "fine", "fine")}, "--at", "three settings"),
    ({"settings": ("draft", "fin", "fine")}, "--at", "fine"),
    ({"settings": ("1%", "3%", "0.3%")}, "--at", "largest error first"),
    ({"settings": ("3%", "1%", "0.00001%")}, "--at", "0.001"),
    ({"tolerance": "0"}, "--tolerance", "1 %"),
    ({"tolerance": "a lot"}, "--tolerance", "a lot"),
    ({"tolerance": "nan"}, "--tolerance", "nan"),
    ({"steps": -1}, "--steps", "0 or more"),
    ({"overrides": ("growth.steps=0",), "increments": ("1",)}, "--increments", "does not grow"),
    ({"increments": ("-1",)}, "--increments", "-1"),
])  # fmt: skip
def test_what_is_wrong_is_told(tmp_path: Path, asked: dict[str, object], key: str, words: str) -> None:
    with pytest.raises(CaseError) as caught:
        plan(tmp_path, **asked)
    (fault,) = caught.value.faults
    assert fault.source == key
    assert words in str(fault)


@pytest.mark.physics
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


@pytest.mark.physics
def test_wings_are_run_with_half_increments_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["trade", str(CASES / "compression30.yaml"), "--steps", "1", "--out", str(tmp_path / "out")]
    assert cli.main([*words, "--tolerance", "0.001 %", "--workers", "2"]) == 4
    told = capsys.readouterr().out
    assert "half increment" in told
    assert "would move the path" in told
    assert "not good enough" in told
