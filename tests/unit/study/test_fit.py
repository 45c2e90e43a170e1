"""Fits: what least squares find, how certain it is, what runs miss of a measurement; what a sweep file may say."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from crackgrow import cli, open_run
from crackgrow.errors import SolveError
from crackgrow.study.fit import FitPlan, _fit_of, _measured, _scale, least_squares_of, missed
from crackgrow.study.path_files import read_paths
from crackgrow.study.plan import folder_names
from crackgrow.study.sweep import combinations, plan_sweep
from crackgrow.study.sweep_file import FitFile, Measured, Range, SweepFile, read_sweep_file
from tests.scenes import make_run

CASES = Path(__file__).parents[3] / "cases"
FLAW = CASES / "compression30.yaml"
LENGTHS = ("crack_length", "load_factor")


def plan_of(points: np.ndarray, **ranges: Range) -> FitPlan:
    file = FitFile(Path("fit.yaml"), {}, Path("case.yaml"), ranges, {}, Measured("measured.csv", "x", "y"))
    return FitPlan(file, "", Path("out"), tuple(ranges), points)


@pytest.mark.parametrize("unit", [1.0, 1e-6, 1e9])
def test_a_straight_line_is_that_of_linear_regression_with_its_intervals(unit: float) -> None:
    """In any unit of y = a + b x, s^2 = SSR/(n - 2): var(b) = s^2 / sum (x - mean)^2, the covariance of polyfit."""
    rng, x = np.random.default_rng(1), np.linspace(0.0, 2.0, 12)
    y = unit * (1.0 + 3.0 * x + rng.normal(0.0, 0.2, 12))
    a, b = Range(-5.0, 5.0, "", None, log=False), Range(0.5, 20.0, "", None, log=True)
    plan = plan_of(np.stack([x, y], axis=1), a=a, b=b)

    def residuals(places: np.ndarray) -> list[np.ndarray]:
        return [unit * (-5.0 + 10.0 * a + 0.5 * 40.0**b * x) - y for a, b in places]

    place, misfit, *_ = least_squares_of(residuals, 2, _scale(plan))
    best, cov = np.polyfit(x, y / unit, 1, cov=True)
    np.testing.assert_allclose(misfit, unit * np.polyval(best, x) - y, atol=2e-3 * unit)
    found = np.array([-5.0 + 10.0 * place[0], 0.5 * 40.0 ** place[1]])
    np.testing.assert_allclose(found, best[::-1], rtol=1e-3)
    exact = unit * np.stack([np.full(12, 10.0), found[1] * np.log(40.0) * x], axis=1)  # of places in the unit square
    told = _fit_of(plan, place, unit * np.polyval(best, x) - y, exact, 7, True)
    np.testing.assert_allclose(told.covariance, cov[::-1, ::-1], rtol=5e-3)
    np.testing.assert_allclose(told.half_widths, 2.2281 * np.sqrt(np.diag(cov))[::-1], rtol=5e-3)  # Student, 10 degrees
    assert told.region == pytest.approx(2.0 * 4.1028, rel=1e-4)  # F(2, 10)
    assert (told.n_runs, told.at_end) == (7, ())


def test_what_a_fit_cannot_tell_is_told(recwarn: pytest.WarningsRecorder) -> None:
    """Keys that a curve does not tell apart or depend on, and the end of a range; without misfit nothing correlates."""
    one = Range(0.0, 1.0, "mm", None, log=False)
    plan, half, ones = plan_of(np.zeros((9, 2)), a=one, b=one), np.full(2, 0.5), np.ones(9)
    with pytest.raises(SolveError, match="does not tell the keys apart a, b"):
        _fit_of(plan, half, ones, np.ones((9, 2)), 1, True)
    told = str(_fit_of(plan, half, np.zeros(9), np.eye(9, 2), 1, True))
    assert told == "a = 0.5 +- 0 mm (95 %)\nb = 0.5 +- 0 mm (95 %)\nresiduals of 0, 1 run"
    alone = plan_of(np.zeros((9, 2)), a=one)
    with pytest.raises(SolveError, match="does not depend on the key a"):
        _fit_of(alone, half[:1], ones, np.zeros((9, 1)), 1, True)
    words = str(_fit_of(alone, np.zeros(1), ones, np.ones((9, 1)), 1, True))
    assert words.startswith("a = 0 +- 0.82 mm (95 %)\na is at an end of its range")  # t(8) sqrt(9/8) / 3
    assert not recwarn.list


def test_a_fit_that_has_not_converged_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("crackgrow.study.fit.MOST_ROUNDS", 2)
    bent = least_squares_of(lambda places: [np.array([k**9, k**9 - 0.1]) for (k,) in places], 1, 1.0)
    assert bent[3] is False
    found = _fit_of(plan_of(np.zeros((2, 2)), a=Range(0.0, 1.0, "", None, log=False)), *bent[:3], 9, bent[3])
    assert (found.converged, "\nnot converged in 2 rounds: narrow the ranges" in str(found)) == (False, True)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_run(tmp_path_factory.mktemp("fit") / "run")


def test_what_a_run_misses_of_a_curve_is_the_difference_between_its_rows(run: Path) -> None:
    x, y = (open_run(run).steps[name].to_numpy() for name in LENGTHS)
    middle = 0.5 * (x[1:] + x[:-1])
    points = np.stack([middle, 0.5 * (y[1:] + y[:-1]) + 0.1], axis=1)
    np.testing.assert_allclose(missed(run, points, Measured("a.csv", *LENGTHS)), -0.1, rtol=1e-9)
    with pytest.raises(SolveError, match=r"crack_length of the run in .* let the run go as far"):
        missed(run, points + np.array([1.0, 0.0]), Measured("a.csv", *LENGTHS))


def test_what_a_run_lacks_is_told(run: Path) -> None:
    points = np.stack([open_run(run).steps["crack_length"], np.zeros(4)], axis=1)
    with pytest.raises(SolveError, match=r"cycles of the run in .* is nan at crack_length = "):
        missed(run, points, Measured("a.csv", "crack_length", "cycles"))
    with pytest.raises(SolveError, match=r"cycles of the run in .* does not rise"):
        missed(run, points, Measured("a.csv", "cycles", "crack_length"))
    with pytest.raises(SolveError, match=r"has no column left.force_x; steps.csv has step, "):
        missed(run, points, Measured("a.csv", "load_factor", "left.force_x"))
    with pytest.raises(SolveError, match=r"has no crack started_1; it has flaw"):
        missed(run, points, Measured("a.csv", crack="started_1"))


def test_what_a_run_misses_of_a_path_is_the_way_to_its_nearest_point(run: Path) -> None:
    points = read_paths(run).cracks["flaw"].points
    along = (points[1] - points[0]) / np.hypot(*(points[1] - points[0]))
    across = np.array([-along[1], along[0]])
    beside = 0.5 * (points[1] + points[0]) + 1e-5 * across
    found = missed(run, beside[None], Measured("a.csv", crack="flaw"))
    np.testing.assert_allclose(found, -1e-5 * across, atol=1e-12)


def test_a_measured_path_is_that_of_its_crack(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("crack,x,y\nflaw,0,0\nflaw,1,1\nother,5,5\nother,6,6\n")
    np.testing.assert_array_equal(_measured(tmp_path / "a.csv", Measured("a.csv", crack="other")), [[5, 5], [6, 6]])


@pytest.mark.physics
def test_the_angle_of_a_flaw_is_recovered_from_its_path(tmp_path: Path) -> None:
    """Within its noise, of a path that the same case has drawn at 33 degrees; resumed, no run is made again."""
    coarse = ["numerics.spacing=4", "growth.steps=1"]
    points = read_paths(make_run(tmp_path / "run", [*coarse, "cracks.flaw.path.angle=33"])).cracks["flaw"].points
    places = np.concatenate([points[:-1] + s * np.diff(points, axis=0) for s in (0.1, 0.4, 0.7)])
    places += np.random.default_rng(2).normal(0.0, 2e-5, places.shape)
    rows = "".join(f"{x!r},{y!r}\n" for x, y in places[np.argsort(places[:, 0])].tolist())
    (tmp_path / "path.csv").write_text(f"x,y\n{rows}")
    file = tmp_path / "fit.yaml"
    file.write_text(
        f"base: {FLAW}\nset: {{numerics.spacing: 4, growth.steps: 1}}\n"
        "parameters: {cracks.flaw.path.angle: {from: 20, to: 40}}\nmeasured: {file: path.csv, crack: flaw}\n"
    )
    assert cli.main(["fit", str(file), "--out", str(tmp_path / "out"), "--workers", "1"]) == 0
    found = json.loads((tmp_path / "out" / "fit.json").read_text())
    assert abs(found["values"][0] - 33.0) < found["half_widths"][0] < 1.0
    made = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").glob("*/summary.json")}
    assert len(made) == found["n_runs"]
    assert cli.main(["fit", str(file), "--out", str(tmp_path / "out"), "--resume"]) == 0
    assert json.loads((tmp_path / "out" / "fit.json").read_text()) == found
    assert made == {path: path.stat().st_mtime_ns for path in (tmp_path / "out").glob("*/summary.json")}


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
    growth = "{steps: 2, increment: 2, criterion: max_hoop_stress, tip_stress: {radius: 2}}"
    text = f"set: {{growth.increment: 1}}\nparameters: {{growth: [{growth}]}}\nreference: {{growth.increment: 0.5}}"
    plan = plan_sweep(written(tmp_path, text), tmp_path)  # what holds the key comes before it
    assert [run.case.growth.increment for run in plan.runs] == [2e-3, 5e-4]


@pytest.mark.parametrize(("names", "folders"), [
    (["angle=30 traction=[0, -1e8]/x", "a=2 mm"], ["angle=30_traction=_0_-1e8_x", "a=2_mm"]),
    (["a=[1]", "a=(1)", "a={1}", "A=[1]"], ["a=_1", "a=_1_2", "a=_1_3", "A=_1_4"]),
])  # fmt: skip
def test_folders_have_letters_that_every_file_system_takes_and_names_of_their_own(
    names: list[str], folders: list[str]
) -> None:
    assert folder_names(names) == folders
