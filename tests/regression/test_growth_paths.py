"""Crack paths of the shipped scenes: against an independent code, between spacings, and by symmetry."""

from __future__ import annotations

from functools import cache

import numpy as np

from crackgrow.run.result import RunEnd, StepResult
from tests.scenes import shipped_case
from tests.whole_run import whole_run

MM = 1e-3


@cache
def run(scene: str, *settings: str) -> tuple[list[StepResult], RunEnd]:
    return whole_run(shipped_case(scene, [*settings, "output.frames=none", "output.figures=false"]))


def wings(end: RunEnd) -> list[np.ndarray]:
    """Both wings (n, 2) in mm, from the flaw's end on, the left one turned onto the right one by half a turn."""
    path = end.cracks[0]
    given = np.flatnonzero(path.steps == 0)
    points = path.points / MM
    return [points[given[-1] :], -points[: given[0] + 1][::-1]]


def n_advances(results: list[StepResult], tip: str) -> int:
    return sum(t.advanced for result in results for t in result.tips if t.tip == tip)


def test_compression30_is_symmetric_by_point_reflection() -> None:
    right, left = wings(run("compression30")[1])
    y = np.linspace(3.0, 24.0, 100)
    apart = np.interp(y, right[:, 1], right[:, 0]) - np.interp(y, left[:, 1], left[:, 0])
    assert np.abs(apart).max() < 0.3  # mm; the wings grow in turn, not together


def test_path_does_not_depend_on_the_spacing() -> None:
    paths = [wings(run("compression30", f"numerics.spacing={spacing}")[1]) for spacing in (3.0, 1.5, 0.75)]
    y = np.linspace(2.6, 24.2, 200)
    x = np.array([[np.interp(y, wing[:, 1], wing[:, 0]) for wing in path] for path in paths])
    assert np.ptp(x, axis=0).max() < 0.3  # mm


def test_tension0_runs_straight_and_needs_no_contact() -> None:
    results, end = run("tension0")
    assert end.status == "completed"
    assert results[-1].step == 10
    assert max(result.energy.error for result in results) < 1e-3
    assert np.abs(end.cracks[0].points[:, 1]).max() < 0.05 * MM
    assert [result.n_contact for result in results] == [0] * 11
    assert [n_advances(results, tip) for tip in ("start", "end")] == [5, 5]


def test_most_critical_tip_in_tension_runs_out_of_the_plate_and_then_the_other_one_tears_it_apart() -> None:
    results, end = run("tension0", "growth.advance=most_critical", "growth.steps=30")
    assert end.status == "broke_through"
    assert "is free to move" in end.reason
    events = [event for result in results for event in result.events] + list(end.events)
    assert [(event.kind, event.met) for event in events] == [("break_through", "the outline of body 'rock'")] * 2
    assert {event.tip for event in events} == {"start", "end"}
    assert events[1].step == results[-1].step + 1  # the last advance was not solved
    np.testing.assert_allclose(np.abs(end.cracks[0].points[[0, -1], 0]), 15.5 * MM, rtol=1e-9)
