"""The branched crack's reference: it is what the program gives today, and it has converged."""

from __future__ import annotations

import numpy as np
import pytest

from tests.verification.rows.branched import FINEST, K_of, difference, reference

SPACINGS = (0.75, 0.5, FINEST)


def test_reference_has_converged() -> None:
    """K extrapolated in the spacing squared from the two finest lattices stays close to the finest."""
    coarse, middle, fine = (reference(spacing) for spacing in SPACINGS)
    assert difference(coarse, fine) < 1e-3
    assert difference(middle, fine) < 5e-4
    share = FINEST**2 / (0.5**2 - FINEST**2)
    beyond = {tip: tuple(np.add(fine[tip], share * np.subtract(fine[tip], middle[tip]))) for tip in fine}
    assert difference(beyond, fine) < 5e-4


@pytest.mark.slow
@pytest.mark.parametrize("spacing", SPACINGS)
def test_reference_is_reproduced(spacing: float) -> None:
    """`difference` allows for a change of the method that keeps it accurate."""
    assert difference(K_of(spacing), reference(spacing)) < 1e-3
