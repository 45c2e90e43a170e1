"""Fits: what least squares find and say of their certainty, what runs miss of a measurement, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from crackgrow import cli, open_run
from crackgrow.errors import SolveError
from crackgrow.study.fit import FitPlan, _fit_of, _measured, _scale, least_squares_of, missed
from crackgrow.study.path_files import read_paths
from crackgrow.study.sweep_file import FitFile, Measured
from crackgrow.study.values import Range
from tests.report_runs import make_run

CASES = Path(__file__).parents[3] / "cases"
JOINT, FLAW = CASES / "fits" / "rough_joint_measured.csv", CASES / "compression30.yaml"
LENGTHS = ("crack_length", "load_factor")


def plan_of(points: np.ndarray, **ranges: Range) -> FitPlan:
    file = FitFile(Path("fit.yaml"), Path("case.yaml"), ranges, {}, Measured("measured.csv", "x", "y"))
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
