"""The Python interface: its examples run, its tables are those on disk, its fields are those that were solved."""

from __future__ import annotations

import doctest
import html
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pandas.testing import assert_frame_equal

import crackgrow
from crackgrow import api
from crackgrow.case.model import Case
from crackgrow.errors import SolveError
from tests.scenes import shipped_case

ROOT = Path(__file__).resolve().parents[2]
COARSE = ("numerics.spacing=3", "output.figures=false")
MPA = 1e6


def case(name: str, *overrides: str) -> Case:
    return shipped_case(name, [*COARSE, *overrides])


@pytest.fixture(scope="module")
def run() -> crackgrow.Run:
    """Two steps of growth."""
    return crackgrow.run_case(case("compression30", "growth.steps=2"))


def test_examples_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    found = doctest.testmod(api)
    assert found.attempted >= 10
    assert found.failed == 0


def test_solution_is_the_first_step_of_a_run(run: crackgrow.Run) -> None:
    solution = crackgrow.solve(run.case)
    for name in ("tips", "contact", "reactions"):
        table = getattr(run, name)
        assert_frame_equal(getattr(solution, name), table[table["step"] == 0], check_exact=True)
    assert solution.paths["step"].max() == 0


def test_step_that_is_solved_again_is_the_same(run: crackgrow.Run) -> None:
    again = run.solution(1)
    table = run.tips
    assert_frame_equal(again.tips, table[table["step"] == 1].reset_index(drop=True), check_exact=True)
    assert run.solution(2) is run.last
    with pytest.raises(IndexError, match="steps 0 to 2"):
        run.solution(3)


def test_fields_at_points_are_those_of_the_frame(run: crackgrow.Run) -> None:
    frame, solution = run.last.frame, run.last
    corners = frame.points[frame.triangles]
    cells = np.concatenate([corners.mean(axis=1), frame.points[frame.quads].mean(axis=1)])
    size = np.abs(frame.stress).max()
    np.testing.assert_allclose(solution.stress_at(cells), frame.stress, rtol=0, atol=1e-6 * size)
    _, counts = np.unique(frame.points.round(9), axis=0, return_counts=True)
    assert (counts > 1).any()  # nodes are double along the crack, where a point has two displacements
    far = np.abs(frame.points).max(axis=1) > 0.0115
    found = solution.displacement_at(frame.points[far])
    np.testing.assert_allclose(found, frame.displacement[far], rtol=0, atol=1e-9 * np.abs(found).max())


def test_uniform_compression_is_exact() -> None:
    """Friction beyond tan of the flaw's slope to the load: the flaw sticks, and the plate is as one without it."""
    solution = crackgrow.solve(case("compression30", "cracks.flaw.contact.friction=0.9"))
    points = np.array([[[0.0, 0.02], [0.01, 0.004]], [[-0.012, -0.01], [0.0, -0.0275]]])
    stress = solution.stress_at(points)
    assert stress.shape == (2, 2, 3)
    np.testing.assert_allclose(stress, np.broadcast_to([0.0, -100 * MPA, 0.0], (2, 2, 3)), atol=1e-4 * MPA)
    E, nu, height = 1e10, 0.25, 0.0275
    expected = -100 * MPA / E * np.stack([-nu * (1 + nu) * points[..., 0], (1 - nu**2) * (points[..., 1] + height)])
    np.testing.assert_allclose(solution.displacement_at(points), np.moveaxis(expected, 0, -1), atol=1e-11)


def test_there_is_nothing_outside_and_no_stress_at_a_tip() -> None:
    solution = crackgrow.solve(case("compression30"))
    tip = solution.tips[["x", "y"]].to_numpy()[0]
    outside = [[0.1, 0.0], [1e300, 0.0], [np.nan, 0.0], [0.0, np.inf]]
    assert np.isnan(solution.stress_at([*outside, tip])).all()
    assert np.isnan(solution.displacement_at(outside)).all()
    assert np.isfinite(solution.displacement_at(tip)).all()
    assert np.isfinite(solution.stress_at(tip + np.array([1e-5, 0.0]))).all()
    assert solution.stress_at(np.empty((0, 2))).shape == (0, 3)
    for points in (1.0, [1.0, 2.0, 3.0], [[1.0], [2.0]]):
        with pytest.raises(ValueError, match="x and y in m"):
            solution.stress_at(points)


def test_what_notebooks_and_prompts_show(run: crackgrow.Run) -> None:
    """Texts of a notebook are escaped, and what a prompt shows is one line."""
    solution = crackgrow.solve(case("compression30", 'title="a < b"'))
    shown = solution._repr_html_()
    assert "a &lt; b" in shown
    assert "<td>flaw</td>" in shown
    (warning,) = [text for text in solution.warnings if "no error is measured" in text]
    assert warning.startswith("step 0: ")
    assert html.escape(warning) in shown
    assert "completed: all 2 growth steps are done" in run._repr_html_()
    assert repr(run) == "<Run of compression30: completed: all 2 growth steps are done>"
    assert repr(run.last) == "<Solution of compression30: step 2, load factor 1, 880 unknowns>"
    assert repr(run.case) == "<Case compression30: Closed crack at 30 degrees under uniaxial compression>"


def test_mistakes_at_a_prompt_are_told(run: crackgrow.Run) -> None:
    path = str(ROOT / "cases" / "compression30.yaml")
    for wrong in (crackgrow.solve, crackgrow.run_case):
        with pytest.raises(TypeError, match=r"a Case is wanted, as crackgrow.load_case\(path\) gives, not '.*yaml'"):
            wrong(path)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="overrides are a list"):
        crackgrow.load_case(path, "growth.steps=2")
    with pytest.raises(KeyError, match="no crack 'flw'; the cracks are flaw"):
        run.path("flw")


@pytest.mark.parametrize(("error", "status", "reason"), [
    (SolveError("too soft"), "failed", "too soft"), (KeyboardInterrupt(), "interrupted", "by Ctrl-C, after step 0")
])  # fmt: skip
def test_what_was_solved_before_an_error_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, status: str, reason: str
) -> None:
    def breaking(case: Case, solved_steps: Any = api.solved_steps) -> Iterator[Any]:
        yield next(solved_steps(case))
        raise error

    monkeypatch.setattr(api, "solved_steps", breaking)
    with pytest.raises(type(error)):
        crackgrow.run_case(case("compression30", "output.frames=none"), tmp_path)
    kept = crackgrow.open_run(tmp_path)
    assert (kept.status, kept.reason, len(kept.tips)) == (status, reason, 2)


def test_public_names_are_few_and_there_and_errors_are_of_one_kind() -> None:
    assert len(crackgrow.__all__) <= 25
    assert all(getattr(crackgrow, name) for name in crackgrow.__all__)
    for name in ("CaseError", "CrackgrowError", "GeometryError", "OccupiedError", "OutputError"):
        assert issubclass(getattr(crackgrow, name), crackgrow.CrackgrowError)
        assert name in dir(crackgrow)
    with pytest.raises(AttributeError, match="has no attribute 'rendered'"):
        crackgrow.rendered  # noqa: B018
