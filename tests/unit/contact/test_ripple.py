"""Short waves of the tractions: found where values alternate, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.ripple import ripple, turning_points, worst_ripple
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.scene import make_scene
from tests.scenes import shipped_case
from tests.solving import solve_step
from tests.unit.cell_sizes import with_sizes

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


def test_of_two_waves_the_larger_counts_and_few_points_have_none() -> None:
    p = np.zeros(61)
    p[40:44] = [1.0, -1.0, 1.0, -1.0]
    p[10:14] = [0.2, -0.2, 0.2, -0.2]
    assert ripple(S, p) == 2.0
    for n in range(4):
        assert ripple(S[:n], p[40 : 40 + n]) == 0.0
    assert ripple(S[:4], p[40:44]) == 2.0


@pytest.mark.parametrize(
    ("values", "places"),
    [([], []), ([1.0, 2.0, 3.0], [0, 2]), ([1.0, 3.0, 3.0, 2.0, 4.0], [0, 2, 3, 4]), ([0.0, 1.0, 1.0, 2.0], [0, 3])],
)
def test_turning_points(values: list[float], places: list[int]) -> None:
    assert turning_points(np.array(values)).tolist() == places


def test_the_ripple_of_a_surface_is_held_against_its_own_pressure() -> None:
    settings = ("numerics.contact={discretization: gauss, stiffness: 1}", "numerics.spacing=3", "growth.steps=0")
    case = shipped_case("compression30", settings)
    solution = solve_step(make_scene(case), (GrowingCrack.given(case.cracks[0]),), 1.0)
    cover, faces, none = solution.cover, solution.faces, np.zeros(solution.faces.n)
    calm = none - 75e6
    wave = calm + 15e6 * (-1.0) ** np.arange(faces.n)
    for normal, tangential in ((wave, none), (1e-9 * wave, none), (calm, wave)):
        assert worst_ripple(cover, faces, normal, tangential).part == pytest.approx(30.0 / 75.0, rel=0.01)
    assert worst_ripple(cover, faces, none, none) is None
    assert worst_ripple(with_sizes(cover, 1.0 / 64.0), faces, wave, none).part == 0.0  # so small cells carry that wave
