"""The estimated error of whole scenes: invariance, its place in results, and the true error of a finer solution."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run import report
from crackgrow.run.judging import StepSolution
from crackgrow.run.report import estimated_error
from crackgrow.run.result import RunEnd, StepResult
from crackgrow.run.scene import make_scene
from tests.energy_distance import energy_distance
from tests.scenes import shipped_case
from tests.solving import solve_step
from tests.whole_run import whole_run

COARSE = "numerics.spacing=3"


def solve(name: str, *settings: str, factor: float = 1.0) -> StepSolution:
    case = shipped_case(name, settings)
    cracks = tuple(map(GrowingCrack.given, case.cracks))
    return solve_step(make_scene(case), cracks, factor)


def run(*settings: str) -> tuple[list[StepResult], RunEnd]:
    case = shipped_case("compression30", (COARSE, "output.figures=false", *settings))
    return whole_run(case)


@pytest.mark.parametrize(
    ("name", "spacing", "finer"),
    [("compression30", 3, 0.6), ("edge_tension", 3, 0.6), ("interface_friction04", 0.1, 0.02)],
)
def test_the_estimate_is_the_distance_to_a_finer_solution(name: str, spacing: float, finer: float) -> None:
    coarse = solve(name, f"numerics.spacing={spacing}")
    error = energy_distance(coarse, solve(name, f"numerics.spacing={finer}")).relative
    assert 0.5 < estimated_error(coarse).relative / error < 2.0


def test_units_and_loads_do_not_matter() -> None:
    relative = estimated_error(solve("compression30", COARSE)).relative
    for settings, factor in (
        (("bodies.rock.material.young=10", "loads.0.traction=[0,-1e-4]", "loads.1.traction=[0,1e-4]"), 1.0),
        ((), 0.25),
    ):
        other = estimated_error(solve("compression30", COARSE, *settings, factor=factor))
        np.testing.assert_allclose(other.relative, relative, rtol=1e-6)


def test_the_cells_of_a_frame_add_up_to_the_estimate() -> None:
    results, end = run("growth.steps=1", "output.fields=[energy_error]")
    for result, expected in zip(results, (results[0].norm_error, end.norm_error), strict=True):
        frame = result.frame
        assert frame is not None
        assert frame.error_density is not None
        area = np.concatenate([_areas(frame.points, cells) for cells in (frame.triangles, frame.quads)])
        share = np.sum(area * frame.error_density**2) / area.sum()
        np.testing.assert_allclose(100.0 * np.sqrt(share), expected, rtol=1e-9)


def test_the_first_and_the_last_step_are_estimated_alone() -> None:
    results, end = run("growth.steps=2", "output.frames=none")
    assert [bool(np.isfinite(result.norm_error)) for result in results] == [True, False, False]
    assert end.norm_error > results[0].norm_error  # the kinks
    (only,), end = run("growth.steps=0", "output.frames=none")
    assert end.norm_error == only.norm_error == results[0].norm_error


def test_the_error_of_cells_is_estimated_where_it_is_asked_for_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    estimate = report.error_estimate
    monkeypatch.setattr(report, "error_estimate", lambda *of: made.append(1) or estimate(*of))
    for fields, n in (("[displacement,stress]", 2), ("[energy_error]", 3)):  # of the first and the last of three steps
        made.clear()
        results, _ = run("growth.steps=2", f"output.fields={fields}")
        known = [result.frame is not None and result.frame.error_density is not None for result in results]
        assert known == [n == 3] * 3
        assert len(made) == n + (n == 3)  # the last step is estimated when it is known to be the last


def _areas(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    x, y = points[cells].transpose(2, 0, 1)
    return 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
