"""The tests run under guard: warnings and floating-point faults are errors in them."""

from __future__ import annotations

import warnings

import numpy as np
import pytest


def test_warnings_are_errors() -> None:
    with pytest.raises(UserWarning, match="doubtful"):
        warnings.warn("doubtful", stacklevel=1)


@pytest.mark.parametrize("numerator", [1e300, 1.0, 0.0], ids=["overflow", "division by zero", "invalid"])
def test_floating_point_faults_raise_though_warnings_are_off(numerator: float) -> None:
    denominator = np.array(1e-300 if numerator > 1.0 else 0.0)
    with warnings.catch_warnings(action="ignore"), pytest.raises(FloatingPointError):
        np.array(numerator) / denominator
