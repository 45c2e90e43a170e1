"""Short waves of the tractions: found where values alternate, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.ripple import ripple, turning_points

S = np.linspace(0.0, 6.0, 61)
"""Ten points a cell."""


@pytest.mark.parametrize("length", [0.3, 0.5, 1.0, 1.6])
@pytest.mark.parametrize("amplitude", [0.1, 2.0])
def test_a_short_wave_is_measured_whatever_it_rides_on(length: float, amplitude: float) -> None:
    s = np.linspace(0.0, 6.0, 601)
    for smooth in (np.zeros(601), np.full(601, -75.0), -75.0 + 0.002 * s**2):
        swing = ripple(s, smooth + amplitude * np.sin(2.0 * np.pi * s / length))
        assert swing == pytest.approx(2.0 * amplitude, rel=0.1)


def test_waves_that_the_lattice_carries_are_none() -> None:
    for length in (2.5, 4.0, 12.0):
        assert ripple(S, np.sin(2.0 * np.pi * S / length)) == 0.0


def test_what_rock_does_is_no_wave() -> None:
    root = np.sqrt(S * (6.0 - S))
    step = np.where(S < 3.0, -75.0, -20.0)
    peak = -75.0 - 500.0 * np.eye(61)[30]
    for smooth in (-75.0 * np.ones(61), -75.0 + S, root, -1.0 / (S + 0.01), step, peak, -np.abs(S - 2.0)):
        assert ripple(S, smooth) == 0.0


def test_of_two_waves_the_larger_counts() -> None:
    p = np.zeros(61)
    p[40:44] = [1.0, -1.0, 1.0, -1.0]
    p[10:14] = [0.2, -0.2, 0.2, -0.2]
    assert ripple(S, p) == 2.0


def test_few_points_have_no_waves() -> None:
    for n in range(4):
        assert ripple(S[:n], np.array([1.0, -1.0, 1.0])[:n]) == 0.0
    assert ripple(S[:4], np.array([1.0, -1.0, 1.0, -1.0])) == 2.0


def test_turning_points() -> None:
    assert turning_points(np.array([])).tolist() == []
    assert turning_points(np.array([1.0, 2.0, 3.0])).tolist() == [0, 2]
    assert turning_points(np.array([1.0, 3.0, 3.0, 2.0, 4.0])).tolist() == [0, 2, 3, 4]
    assert turning_points(np.array([0.0, 1.0, 1.0, 2.0])).tolist() == [0, 3]
