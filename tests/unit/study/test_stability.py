"""The study of extremes: one bad row ends itself alone, verdicts, files, what the command line says."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from crackgrow import cli
from crackgrow.case import load_case
from crackgrow.case.model import Case, ContactSupport, EdgeTraction
from crackgrow.cli.console import EXIT_DIFFERENT, EXIT_DONE
from crackgrow.errors import SolveError
from crackgrow.run.caution import Cause, Caution
from crackgrow.study.stability import runner
from crackgrow.study.stability.measures import everything, overall
from crackgrow.study.stability.placed import mirrored, moved, placed, scaled, turned
from crackgrow.study.stability.scenes import Scenes
from crackgrow.study.stability.solved import Solved, solved
from crackgrow.study.stability.table import COLUMNS, csv_text, summary_text
from crackgrow.study.stability.trial import Row, Trial, evaluate
from crackgrow.study.stability.writer import write_stability

ROOT = Path(__file__).parents[3]
CASES = ROOT / "cases"


@pytest.fixture(scope="module")
def flaw() -> Solved:
    return solved(coarse())


def coarse() -> Case:
    return load_case(CASES / "compression30.yaml", ["numerics.spacing=3", "growth.tip_stress.radius=2"])


def trial(solve: Callable[[], Solved], deviation: float, plain: Solved, refusable: bool = False) -> Trial:
    return Trial("axis", "1", "itself", 1e-3, solve, lambda _: deviation, lambda: plain, refusable)


def refuses() -> Solved:
    raise SolveError("no such luck")


def crashes() -> Solved:
    raise ZeroDivisionError("a bug")


def row(
    deviation: float = 1e-4, status: str = "solved", refusable: bool = False, axis: str = "a", value: str = "1"
) -> Row:
    return Row(axis, value, "itself", deviation, 1e-3, 1e5, 1, 1e-15, status, refusable, "why | not", 0.5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("found", "verdict"),
    [
        (row(), "yes"),
        (row(1e-4, "warned"), "yes"),
        (row(2e-3), "NO"),
        (row(2e-3, "warned"), "said"),
        (row(float("nan")), "NO"),
        (row(float("nan"), "warned"), "said"),
        (row(float("nan"), "refused"), "NO"),
        (row(float("nan"), "refused", refusable=True), "said"),
        (row(0.0, "crashed", refusable=True), "NO"),
    ],
)
def test_verdict(found: Row, verdict: str) -> None:
    assert found.verdict == verdict


def test_row_tells_how_its_scene_was_solved(flaw: Solved) -> None:
    found = evaluate(trial(lambda: flaw, 1e-4, flaw))
    assert (found.status, found.reason, found.iterations, found.verdict) == ("solved", "", 1, "yes")
    assert 1e5 < found.condition < 1e9
    assert 0.0 < found.residual < 1e-12


def test_warnings_that_the_usual_scene_does_not_have_are_news(flaw: Solved) -> None:
    warned = replace(
        flaw, result=replace(flaw.result, cautions=(Caution(Cause.NOTE, "old"), Caution(Cause.NOTE, "new")))
    )
    usual = replace(flaw, result=replace(flaw.result, cautions=(Caution(Cause.NOTE, "old"),)))
    found = evaluate(trial(lambda: warned, 1.0, usual))
    assert (found.status, found.reason, found.verdict) == ("warned", "new", "said")


def test_what_is_raised_ends_its_own_row_alone(flaw: Solved) -> None:
    refused = evaluate(trial(refuses, 0.0, flaw))
    assert (refused.status, refused.reason, refused.verdict, refused.iterations) == (
        "refused",
        "no such luck",
        "NO",
        -1,
    )
    crashed = evaluate(trial(crashes, 0.0, flaw))
    assert (crashed.status, crashed.reason, crashed.verdict) == ("crashed", "ZeroDivisionError: a bug", "NO")


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
    write_stability(tmp_path / "new", [row(), row(float("nan"), "refused"), row(axis="b")])
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == [
        "stability.csv",
        "stability.md",
        "stability.png",
    ]
    assert "why / not" in (tmp_path / "new" / "stability.md").read_text(encoding="utf-8")


def test_all_that_is_known_of_a_row_is_a_column() -> None:
    assert set(COLUMNS) == {field.name for field in fields(Row)} - {"refusable"} | {"verdict"}


def test_a_NO_is_the_exit_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, flaw: Solved) -> None:
    monkeypatch.chdir(ROOT)
    deviation = {"good": 1e-4, "bad": 1.0}

    def axis(name: str) -> Callable[[Scenes], Iterator[Trial]]:
        return lambda _: iter(
            [trial(lambda: flaw, deviation[name], flaw), trial(crashes, 0.0, flaw)][: 2 - (name == "good")]
        )

    monkeypatch.setattr(runner, "AXES", {name: axis(name) for name in deviation})
    assert cli.main(["stability", "--axis", "good", "--out", str(tmp_path)]) == EXIT_DONE
    assert cli.main(["stability", "--out", str(tmp_path)]) == EXIT_DIFFERENT
    assert (tmp_path / "stability.csv").read_text(encoding="utf-8").count("\n") == 4


def test_unknown_axis_is_a_fault(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    assert cli.main(["stability", "--axis", "young", "joung"]) == 2
    assert "--axis: joung: no such axis here; there are stiffness, friction" in capsys.readouterr().err


def test_scenes_that_are_not_there_are_a_fault(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["stability"]) == 2
    assert "compression30.yaml: no such file: run in the folder that holds `cases`" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["compression30", "block_rigid", "interface_friction01", "junction_static"])
@pytest.mark.parametrize(
    "placement", [turned(90.0), turned(180.0), mirrored(), moved(3.0, -2.0)], ids=["90", "180", "mirror", "moved"]
)
def test_placed_scene_is_the_same_scene(name: str, placement: object, flaw: Solved) -> None:
    case = coarse() if name == "compression30" else load_case(CASES / f"{name}.yaml")
    plain = flaw if name == "compression30" else solved(case)
    assert overall(solved(placed(case, placement), placement), plain) < 1e-3  # type: ignore[arg-type]


def test_other_units_are_the_same_to_round_off_and_other_loads_are_not(flaw: Solved) -> None:
    placement = scaled(1e-3, 1e6, 1e-4)
    case = placed(coarse(), placement)
    assert everything(solved(case, placement), flaw) < 1e-9
    more = replace(case, loads=tuple(_doubled(load) for load in case.loads))
    assert overall(solved(more, placement), flaw) > 0.5


def _doubled(load: object) -> EdgeTraction:
    assert isinstance(load, EdgeTraction)
    return replace(load, traction=(2.0 * load.traction[0], 2.0 * load.traction[1]))


def test_mirror_keeps_rock_on_the_left_and_edges_under_their_names() -> None:
    case = placed(load_case(CASES / "block_foundation.yaml"), mirrored())
    for body in case.bodies:
        x, y = body.outline.T
        assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0.0
    side = next(load.region for load in case.loads if isinstance(load, EdgeTraction) and load.region.edge == "right")
    ends = case.bodies[0].outline[[side.sides[0], (side.sides[0] + 1) % 4]]
    assert ends[:, 0].tolist() == [-2.0, -2.0]
    bottom = next(s for s in placed(load_case(CASES / "block_rigid.yaml"), mirrored()).supports)
    assert isinstance(bottom, ContactSupport)


def test_single_components_cannot_be_turned_askew() -> None:
    with pytest.raises(ValueError, match="right angles"):
        placed(coarse(), turned(30.0))
