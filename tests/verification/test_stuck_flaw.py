"""A crack that sticks everywhere does not grow, and its K falls with the spacing."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.contact.coulomb import STICK
from tests.verification.solutions import REFERENCES, solve_case
from tests.whole_run import whole_run

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
