"""Pieces of lines on which Gauss points integrate what varies along them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import erf

from crackgrow.quadrature.rims import POINTS_PER_EDGE
from crackgrow.quadrature.rules import gauss
from crackgrow.quadrature.subdivision import MOST_HALVINGS, SHARE, subdivided

ENDS = np.array([[[0.0, 0.0], [3.0, 4.0]], [[3.0, 4.0], [3.0, 6.0]]])  # 5 and 2 long
LENGTHS = np.array([5.0, 2.0])


def integral(values, line: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Integral of the values with a Gauss rule on each piece."""
    x, w = gauss(POINTS_PER_EDGE)
    width = np.diff(limits, axis=1)
    at = limits[:, :1] + width * x
    places = ENDS[line, 0][:, None] + at[:, :, None] * (ENDS[line, 1] - ENDS[line, 0])[:, None]
    found = values(places.reshape(-1, 2), np.repeat(line, len(x))).reshape(len(line), len(x), -1)
    return np.einsum("mp,mpc->c", width * LENGTHS[line][:, None] * w, found)


def test_what_the_points_integrate_is_not_cut() -> None:
    line, limits = subdivided(ENDS, lambda at, line: np.stack([at[:, 0] ** 7, 1.0 + line], axis=1))
    assert line.tolist() == [0, 1]
    assert limits.tolist() == [[0.0, 1.0], [0.0, 1.0]]


@pytest.mark.parametrize("width", [1.0, 0.3, 0.05])
def test_a_peak_between_the_points_is_found(width: float) -> None:
    def peak(at: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.exp(-(((at[:, 1] - 4.7) / width) ** 2))[:, None]

    line, limits = subdivided(ENDS, peak)
    root = 0.5 * np.sqrt(np.pi) * width
    on_first = root * (erf((4.0 - 4.7) / width) - erf(-4.7 / width)) * 5.0 / 4.0
    exact = on_first + root * (erf(1.3 / width) - erf(-0.7 / width))
    assert integral(peak, line, limits) == pytest.approx(exact, rel=20.0 * SHARE)
    assert np.all(np.diff(line) >= 0)
    for number in (0, 1):  # the pieces follow each other without gaps
        low, high = limits[line == number].T
        assert (low[0], high[-1]) == (0.0, 1.0)
        np.testing.assert_array_equal(low[1:], high[:-1])


def test_a_kink_is_cut_out_and_no_singularity_is_followed_for_ever() -> None:
    def kinked(at: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.maximum(at[:, 1] - 4.9, 0.0)[:, None]

    line, limits = subdivided(ENDS, kinked)
    assert integral(kinked, line, limits) == pytest.approx(0.5 * 1.1**2, rel=20.0 * SHARE)
    line, limits = subdivided(ENDS, lambda at, _: (1.0 / np.abs(at[:, 1] - 5.0 + 1e-9))[:, None])
    assert np.diff(limits, axis=1).min() >= 0.5**MOST_HALVINGS
    assert len(line) < 200
