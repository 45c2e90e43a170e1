"""Cracks that stay closed: K behind kinks settles on small cells, and what sticks everywhere does not grow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.contact.coulomb import STICK
from crackgrow.run.checkpoint import beginning
from crackgrow.run.loading import load
from crackgrow.run.scene import make_scene
from tests.benchmarks.target_scenes import kinked_scene
from tests.verification.solutions import REFERENCES, case_of, solve_case
from tests.whole_run import whole_run


def test_K_behind_a_closed_kink_settles_as_cells_there_get_smaller() -> None:
    """Tractions at the pressed corner, which no cells resolve, once put it off by up to 4 %, more on smaller cells."""
    scene = make_scene(case_of({**kinked_scene(30.0), "numerics": {"accuracy": 0.03}}))
    cracks = beginning(scene.case).cracks
    found = []
    for level in (2, 4, 6):
        cells = scene.with_grading(replace(scene.grading, cracks=(level,)))
        found.append(load(cells, cracks).tips[0].K)
    assert np.ptp(found, axis=0).max() < 0.005 * np.hypot(*found[-1])


STUCK = REFERENCES / "stuck_flaw.yaml"
"""A flaw that sticks everywhere under a pressure that varies along it: K_I = K_II = 0."""


@pytest.mark.parametrize("spacing", [3.0, 2.0])
def test_a_flaw_that_sticks_everywhere_does_not_grow(spacing: float) -> None:
    results, end = whole_run(load_case(STUCK, [f"numerics.spacing={spacing}"]))
    assert end.status == "arrested"
    assert len(results) == 1
    assert (results[0].contact.state == STICK).all()


def test_K_of_a_flaw_that_sticks_everywhere_falls_with_the_spacing() -> None:
    """Contact holds on average along the faces: what is left of K is zero in the limit."""
    cases = [load_case(STUCK, [f"numerics.spacing={h}"]) for h in (3.0, 1.5, 1.0)]
    K = [max(np.hypot(tip.K_I, tip.K_II) for tip in solve_case(case).result.tips) for case in cases]
    assert K[1] < 0.7 * K[0]
    assert K[2] < 0.7 * K[1]
    assert K[2] < 0.005 * 97e6 * np.sqrt(np.pi * 7.5e-3)  # of the open crack under the mean pressure
