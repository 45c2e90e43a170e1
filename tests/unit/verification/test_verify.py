"""The runner of the verification table: what passes, what fails, and what is known to miss its bar."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from tests.verification.row import Row, evaluate
from tests.verification.verify import FAILED, report


def row(value: float, tolerance: float = 0.01, **more: object) -> Row:
    return Row("scene", "K [Pa]", 2.0, "exact", "formula", tolerance, lambda: value, **more)


def no_value() -> float:
    raise ValueError("no solution")


def test_rows_within_their_tolerance_pass(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert report([evaluate(row(2.01)), evaluate(row(1.99))], tmp_path) == 0
    assert "| yes |" in capsys.readouterr().out


def test_one_row_beyond_its_tolerance_fails_the_table_and_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert report([evaluate(row(2.0)), evaluate(row(2.1))], tmp_path) == FAILED == 1
    printed = capsys.readouterr().out
    assert "| scene | K [Pa] | 2 (formula) | exact | 2.1 | 5 % | 1 % | NO |" in printed
    assert "NO: scene, K [Pa]: source: formula" in printed
    assert (tmp_path / "table.md").read_text() in printed
    good, bad = csv.DictReader((tmp_path / "table.csv").read_text().splitlines())
    assert (good["pass"], bad["pass"]) == ("yes", "NO")
    assert float(bad["error"]) == pytest.approx(0.05)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_no_number_fails(value: float, tmp_path: Path) -> None:
    assert report([evaluate(row(value))], tmp_path) == FAILED


def test_a_row_that_raises_fails_and_says_what(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    failing = Row("scene", "K [Pa]", 2.0, "exact", "formula", 0.01, no_value)
    assert report([evaluate(failing), evaluate(row(2.0))], tmp_path) == FAILED
    assert "NO: scene, K [Pa]: ValueError: no solution" in capsys.readouterr().out


def test_a_known_miss_is_shown_with_its_reason_and_does_not_fail(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert report([evaluate(row(3.0, known="too coarse"))], tmp_path) == 0
    table = (tmp_path / "table.md").read_text()
    assert "missed (1)" in table
    assert "(1) too coarse." in table
    assert "NO" not in capsys.readouterr().out


def test_a_mark_that_has_outlived_its_miss_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert report([evaluate(row(2.0, known="too coarse"))], tmp_path) == 0
    assert "scene, K [Pa]: passes by now" in capsys.readouterr().out


def test_a_known_miss_that_raises_fails(tmp_path: Path) -> None:
    failing = Row("scene", "K [Pa]", 2.0, "exact", "formula", 0.01, no_value, known="too coarse")
    assert report([evaluate(failing)], tmp_path) == FAILED


@pytest.mark.parametrize(
    ("measure", "value", "passes"),
    [
        ("relative", 2.019, True),
        ("relative", 1.979, False),
        ("absolute", 2.009, True),
        ("absolute", 2.011, False),
        ("at most", -5.0, True),
        ("at most", 2.02, False),
        ("at least", 5.0, True),
        ("at least", 1.98, False),
    ],
)
def test_measures_of_the_error(measure: str, value: float, passes: bool) -> None:
    assert evaluate(row(value, error=measure)).within == passes


def test_an_error_relative_to_a_negative_reference_keeps_its_sign() -> None:
    outcome = evaluate(Row("scene", "K_I", -2.0, "exact", "formula", 0.1, lambda: -1.9))
    assert outcome.error == pytest.approx(0.05)
