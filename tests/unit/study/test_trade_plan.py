"""What a trade is going to run, and what is refused before anything runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.errors import CaseError
from crackgrow.study.trade_plan import OWN, TradePlan, plan_trade

CASES = Path(__file__).parents[3] / "cases"
FLAW = CASES / "compression30.yaml"
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


@pytest.mark.parametrize(
    ("increments", "steps"),
    [(("half",), [6]), (("1.5 mm", "1", "0.3"), [4, 6, 20]), (("none",), [])],
)
def test_increments_grow_by_the_same_length(tmp_path: Path, increments: tuple[str, ...], steps: list[int]) -> None:
    """Of three increments of 2 mm; the longest first."""
    found = plan(tmp_path, steps=3, increments=increments)
    grown = [run.case.growth.steps for run in found.study.runs[3:] if run.case and run.case.growth]
    assert grown == steps
    assert len(found.increments) == len(steps)
    assert plan(tmp_path, steps=0).increments == ()


@pytest.mark.parametrize(
    ("asked", "key", "words"),
    [
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
    ],
)
def test_what_is_wrong_is_told(tmp_path: Path, asked: dict[str, object], key: str, words: str) -> None:
    with pytest.raises(CaseError) as caught:
        plan(tmp_path, **asked)
    (fault,) = caught.value.faults
    assert fault.source == key
    assert words in str(fault)


def test_the_command_line_tells_it_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["trade", str(FLAW), "--tolerance", "2", "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.startswith("--tolerance: '2' given")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["converge"], "'converge' is gone: `crackgrow trade` tells whether a setting is good enough"),
        (["trade", "a.yaml", "--axis", "spacing=3,2"], "--axis spacing=3,2; it is gone: `crackgrow sweep`"),
        (["trade", "a.yaml", "--reference", "out"], "`reference` of a sweep file"),
        (["trade", "a.yaml", "--no-increments"], "it is gone: --increments none"),
    ],
)
def test_words_of_earlier_versions_name_what_does_their_work(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(words)
    assert stopped.value.code == 2
    assert told in capsys.readouterr().err
