"""Histories of load, with growth and without."""

from __future__ import annotations

import numpy as np

from crackgrow.run import grow
from tests.scenes import shipped_case
from tests.unit.run.test_run_critical_load import case_of
from tests.unit.run.test_run_increments import SMALL_SHEAR
from tests.whole_run import whole_run


def test_a_history_is_gone_through_on_one_factorization() -> None:
    files = ("output.frames=none", "output.figures=false")
    case = shipped_case("cyclic_friction", [*SMALL_SHEAR, *files, "loading.history=[0.5, 1.0, 0.2]"])
    results, end = whole_run(case)
    assert [result.load_factor for result in results] == [0.5, 1.0, 0.2]
    assert [result.factorizations for result in results] == [1, 0, 0]
    assert [result.seconds["assembly"] > 0.0 for result in results] == [True, False, False]
    assert (end.status, end.reason) == ("completed", "all 3 load factors are done")
    slip = [result.contact.slip for result in results]
    np.testing.assert_allclose(slip[2], 0.8 * slip[1], rtol=1e-3)  # it slips back only below a factor of 1/3


def test_with_growth_every_step_goes_through_the_history_to_its_last_factor() -> None:
    """Loaded to 2 and back to 1 the stuck crack holds more slip than one that is loaded to 1."""
    case = case_of("compression30", "cracks.flaw.contact.friction=0.3", "growth.steps=1", "loading.history=[2, 1]")
    results, _ = whole_run(case)
    assert [result.load_factor for result in results] == [1.0, 1.0]
    direct = next(grow(case_of("compression30", "cracks.flaw.contact.friction=0.3", "loading.history=[1]")))
    assert np.abs(results[0].contact.slip).max() > 1.2 * np.abs(direct.contact.slip).max()
    assert np.abs(results[1].contact.slip).max() > 1.2 * np.abs(direct.contact.slip).max()
