"""What a convergence study is going to run, and what is refused before anything runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.errors import CaseError
from crackgrow.study.converge.plan import HALF, OWN, ConvergencePlan, plan_convergence

CASES = Path(__file__).parents[4] / "cases"
FLAW = CASES / "compression30.yaml"
GIVEN = ("numerics.spacing=1.5",)


def plan(folder: Path, **asked: object) -> ConvergencePlan:
    return plan_convergence(FLAW, folder, **asked)  # type: ignore[arg-type]


def test_the_own_setting_is_one_of_the_three_where_it_is_the_same(tmp_path: Path) -> None:
    own = plan(tmp_path).own
    assert own.name == "standard"
    assert plan(tmp_path, overrides=("numerics.accuracy=fine",)).own.name == "fine"
    assert plan(tmp_path, overrides=GIVEN).own.name == OWN  # its spacing is given


def test_targets_are_settings_too(tmp_path: Path) -> None:
    found = plan(tmp_path, settings=("3%", "1 %", "0.003"))
    targets = [found.file.load(*setting.overrides).numerics.target for setting in found.settings]
    assert targets == [0.03, 0.01, 0.003]
    same = plan(tmp_path, overrides=("numerics.accuracy=1 %",), settings=("3%", "1%", "0.3%"))
    assert same.own.name == "1%"


def test_half_increments_grow_by_the_same_length(tmp_path: Path) -> None:
    found = plan(tmp_path, steps=3)
    assert found.half is not None
    assert found.half.name == HALF
    whole, half = found.case.growth, found.file.load(*found.half.overrides).growth
    assert whole is not None
    assert half is not None
    assert (2 * half.increment, half.steps) == (whole.increment, 2 * whole.steps)
    assert plan(tmp_path, steps=0).half is None
    assert plan(tmp_path, increments=False).half is None


@pytest.mark.parametrize(
    ("asked", "key", "words"),
    [
        ({"settings": ("draft", "fine")}, "--at", "three settings"),
        ({"settings": ("draft", "fine", "fine")}, "--at", "three settings"),
        ({"settings": ("draft", "fin", "fine")}, "--at", "fine"),
        ({"settings": ("1%", "3%", "0.3%")}, "--at", "largest error first"),
        ({"settings": ("3%", "1%", "0.00001%")}, "--at", "0.001"),
        ({"tolerance": "0"}, "--tolerance", "1 %"),
        ({"tolerance": "a lot"}, "--tolerance", "a lot"),
        ({"tolerance": "nan"}, "--tolerance", "nan"),
        ({"steps": -1}, "--steps", "0 or more"),
        ({"overrides": ("growth.steps=0",), "increments": True}, "--increments", "does not grow"),
    ],
)
def test_what_is_wrong_is_told(tmp_path: Path, asked: dict[str, object], key: str, words: str) -> None:
    with pytest.raises(CaseError) as caught:
        plan(tmp_path, **asked)
    (fault,) = caught.value.faults
    assert fault.source == key
    assert words in str(fault)


def test_the_command_line_tells_it_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["converge", str(FLAW), "--tolerance", "2", "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.startswith("--tolerance: '2' given")
    assert not (tmp_path / "out").exists()
