"""What a sweep file may say, and what is said of one that is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.study.plan import folder_names
from crackgrow.study.sweep import combinations, plan_sweep
from crackgrow.study.sweep_file import SweepFile, read_sweep_file

CASES = Path(__file__).parents[3] / "cases"
FLAW = CASES / "compression30.yaml"
ANGLE, FRICTION = "cracks.flaw.path.angle", "cracks.flaw.contact.friction"


def written(folder: Path, text: str, base: Path = FLAW) -> Path:
    path = folder / "study.yaml"
    path.write_text(f"base: {base}\n{text}", encoding="utf-8")
    return path


def read(folder: Path, text: str) -> SweepFile:
    return read_sweep_file(written(folder, text))


@pytest.mark.parametrize(("text", "expected"), [
    # every combination, the first parameter slowest
    (f"parameters: {{{ANGLE}: [20, 30], {FRICTION}: {{from: 0, to: 0.3, n: 4}}}}",
     [(angle, friction) for angle in ("20", "30") for friction in ("0", "0.1", "0.2", "0.3")]),
    (f"design: zip\nparameters: {{{ANGLE}: [20, 30, 20], {FRICTION}: [0.3, 0.2, 0.1]}}",
     [("20", "0.3"), ("30", "0.2"), ("20", "0.1")]),
    # equal ratios, with the unit
    ("parameters: {numerics.spacing: {from: 1 mm, to: 8 mm, n: 4, scale: log}}",
     [("1 mm",), ("2 mm",), ("4 mm",), ("8 mm",)]),
])  # fmt: skip
def test_combinations_of_a_grid_of_pairs_and_of_a_logarithmic_range(
    text: str, expected: list[tuple[str, ...]], tmp_path: Path
):
    assert combinations(read(tmp_path, text)) == expected


def test_latin_hypercube_meets_every_part_of_every_range_once(tmp_path: Path):
    n = 40
    text = f"""
design: latin_hypercube
samples: {n}
seed: 3
parameters:
  {ANGLE}: {{from: 20, to: 60}}
  numerics.spacing: {{from: 1, to: 100, scale: log}}
  growth.advance: [all, most_critical]
"""
    file = read(tmp_path, text)
    angle, spacing, advance = zip(*combinations(file), strict=True)
    parts = (np.array(angle, dtype=float) - 20) / 40, np.log10(np.array(spacing, dtype=float)) / 2
    for part in parts:
        assert sorted(np.floor(part * n)) == list(range(n))
    assert not np.array_equal(np.argsort(parts[0]), np.argsort(parts[1]))
    assert advance.count("all") == advance.count("most_critical") == n // 2
    assert combinations(file) == combinations(read(tmp_path, text))
    assert combinations(file) != combinations(read(tmp_path, text.replace("seed: 3", "seed: 4")))


def test_refused_combinations_are_part_of_the_plan_with_their_reason(tmp_path: Path):
    plan = plan_sweep(written(tmp_path, f"parameters: {{{FRICTION}: [0, -1, 0.2]}}"))
    assert [run.case is None for run in plan.runs] == [False, True, False]
    assert plan.runs[1].refusal.startswith(f"{FRICTION}: '-1' is out of range")
    assert [run.refusal for run in plan.runs if run.case] == ["", ""]


def test_each_run_is_held_against_the_same_one_with_finer_values(tmp_path: Path):
    """One reference for each friction, none for what is no case."""
    text = f"parameters: {{numerics.spacing: [4, 3], {FRICTION}: [0, -1, 0.3]}}\nreference: {{numerics.spacing: 2}}"
    plan = plan_sweep(written(tmp_path, text), tmp_path)
    assert [run.name for run in plan.runs[6:]] == ["reference spacing=2 friction=0", "reference spacing=2 friction=0.3"]
    assert [run.reference for run in plan.runs] == [6, None, 7, 6, None, 7, None, None]
    assert [run.case.numerics.spacing for run in plan.runs if run.case] == [4e-3, 4e-3, 3e-3, 3e-3, 2e-3, 2e-3]
    assert plan.asked == plan.runs[:6]


@pytest.mark.parametrize(("names", "folders"), [
    (["angle=30 traction=[0, -1e8]/x", "a=2 mm"], ["angle=30_traction=_0_-1e8_x", "a=2_mm"]),
    (["a=[1]", "a=(1)", "a={1}", "A=[1]"], ["a=_1", "a=_1_2", "a=_1_3", "A=_1_4"]),
])  # fmt: skip
def test_folders_have_letters_that_every_file_system_takes_and_names_of_their_own(
    names: list[str], folders: list[str]
) -> None:
    assert folder_names(names) == folders
