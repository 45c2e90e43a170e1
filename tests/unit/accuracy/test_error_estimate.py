"""The estimated error on fields that are known: none, smooth, and with slivers of rock."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.accuracy.energy_norm import error_estimate
from tests.conftest import Build
from tests.unit.exact_fields import solved_under, true_error

pytestmark = pytest.mark.physics


def smooth(points: np.ndarray) -> np.ndarray:
    """Balanced stress of the potentials phi = exp(z), psi = 0 (Muskhelishvili 1953, section 32), z in units of 4 m."""
    z = (points @ (1.0, 1.0j)) / 4.0
    total, deviator = 4.0 * np.exp(z).real, 2.0 * np.conj(z) * np.exp(z)
    return np.stack([0.5 * (total - deviator.real), 0.5 * (total + deviator.real), deviator.imag / 2.0], axis=1)


def errors_and_estimates(build: type[Build], support: float) -> tuple[np.ndarray, np.ndarray]:
    """True errors and estimates, percent, at spacings of 0.25 and 0.125."""
    found = []
    for spacing in (0.25, 0.125):
        sample = build.sample((0.0, 0.0), (4.0, 3.0), spacing=spacing, support=support)
        u = solved_under(sample, smooth)
        estimate = error_estimate(sample.cover, [sample.material], u, ()).relative
        found.append((true_error(sample, u, smooth), estimate))
    return np.array(found).T


@pytest.mark.parametrize("support", [1.5, 1.75, 2.0, 2.5])
def test_the_estimate_of_a_smooth_field_is_its_error_or_a_bound(build: type[Build], support: float) -> None:
    """Linear functions: both fall at a rate of one. At a support of two they are cubic B-splines: the error falls at a
    rate of three, as that of a quadratic fit does, which is larger."""
    errors, estimates = errors_and_estimates(build, support)
    for values in (errors, estimates):
        np.testing.assert_allclose(np.log2(values[0] / values[1]), 3.0 if support == 2.0 else 1.0, atol=0.1)
    if support == 2.0:
        assert np.all(estimates > errors)
        assert estimates[-1] < 1e-3  # percent
    else:
        np.testing.assert_allclose(estimates, errors, rtol=0.15)


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_a_uniform_stress_has_no_error(build: type[Build], support: float) -> None:
    """Through a crack along the stress, slivers of rock beside it included."""
    crack = build.crack([(0.0, 2.031), (2.6, 2.031)], tips=(False, True))
    sample = build.sample((0.0, 0.0), (6.0, 4.0), (crack,), spacing=0.5, support=support)

    def along(points: np.ndarray) -> np.ndarray:
        return np.tile([1.0, 0.0, 0.0], (len(points), 1))

    u = solved_under(sample, along)
    assert error_estimate(sample.cover, [sample.material], u, ()).relative < 1e-6
