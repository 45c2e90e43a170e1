"""Cracks in an infinite plate against closed forms, limits and the equations themselves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

from tests.verification.crack_array import CrackArray, StraightCrack, solve_crack_array

YOUNG, POISSON = 10.0, 0.25
STRESS = (0.4, 1.0, 0.1)
SCATTERED = (
    StraightCrack(0.0, 0.0, 1.0, 20.0),
    StraightCrack(0.5, 1.2, 0.8, -40.0),
    StraightCrack(-1.6, -0.6, 0.7, 80.0),
    StraightCrack(1.9, -0.3, 0.6, 110.0, normal=-0.3, shear=0.2),
)


@pytest.fixture(scope="module")
def plate() -> CrackArray:
    return solve_crack_array(SCATTERED, STRESS)


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0, 135.0, -50.0])
def test_one_crack_at_any_angle(angle: float) -> None:
    crack = StraightCrack(0.3, 0.2, 1.5, angle, normal=-0.5, shear=0.1)
    along = np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])
    normal = np.array([-along[1], along[0]])
    stress = np.array([[0.2, 0.3], [0.3, 1.0]])
    exact = np.array([normal @ stress @ normal + 0.5, along @ stress @ normal - 0.1]) * np.sqrt(np.pi * 1.5)
    found = solve_crack_array([crack], (0.2, 1.0, 0.3), 4)
    np.testing.assert_allclose([found.K(0, "start"), found.K(0, "end")], [exact, exact], rtol=1e-12)


@pytest.mark.parametrize("inner", [0.1, 0.5, 2.0])
def test_two_collinear_cracks(inner: float) -> None:
    """Cracks at a < abs(x) < b (Erdogan 1962; Tada, Paris, Irwin, The Stress Analysis of Cracks Handbook)."""
    a, b = inner, inner + 2.0
    ratio = ellipe(1.0 - (a / b) ** 2) / ellipk(1.0 - (a / b) ** 2)
    root = np.sqrt(b**2 - a**2)
    at_a = np.sqrt(np.pi / a) * (b**2 * ratio - a**2) / root
    at_b = np.sqrt(np.pi / b) * (b**2 - b**2 * ratio) / root
    middle = 0.5 * (a + b)
    cracks = [StraightCrack(-middle, 0.0, 1.0, 0.0), StraightCrack(middle, 0.0, 1.0, 180.0)]
    found = solve_crack_array(cracks, (0.7, 1.0, 0.0), 100)
    K = [found.K(0, "start"), found.K(0, "end"), found.K(1, "end"), found.K(1, "start")]  # the second one runs back
    np.testing.assert_allclose(K, [(at_b, 0.0), (at_a, 0.0), (at_a, 0.0), (at_b, 0.0)], rtol=1e-10, atol=1e-10)


def test_K_converges_exponentially(plate: CrackArray) -> None:
    """The traction left over on the faces tells the error of K."""
    exact = np.array(solve_crack_array(SCATTERED, STRESS, 120).K(0, "end"))
    assert plate.residual < 1e-12
    for n_terms, expected in ((20, 1e-5), (40, 1e-11)):
        coarse = solve_crack_array(SCATTERED, STRESS, n_terms)
        assert coarse.residual < expected
        assert np.abs(coarse.K(0, "end") - exact).max() < coarse.residual + 1e-13


def test_faces_carry_what_is_given(plate: CrackArray) -> None:
    s = np.array([-0.97, -0.3, 0.4, 0.9])
    for crack in SCATTERED:
        for side in (1.0, -1.0):
            z = crack.middle + crack.direction * (crack.half_length * s + side * 1e-12j)
            xx, yy, xy = plate.stress_at(np.stack([z.real, z.imag], axis=1)).T
            turned = 0.5 * (xx + yy) + 0.5 * ((yy - xx) + 2j * xy) * crack.direction**2
            np.testing.assert_allclose(turned, crack.normal + 1j * crack.shear, atol=1e-9)


def test_displacement_gives_the_stress(plate: CrackArray) -> None:
    points = np.random.default_rng(1).uniform(-3.0, 3.0, (20, 2))
    step = 1e-5
    d_x, d_y = (
        (plate.displacement_at(points + e, YOUNG, POISSON) - plate.displacement_at(points - e, YOUNG, POISSON)) / 2e-5
        for e in step * np.eye(2)
    )
    strain = np.stack([d_x[:, 0], d_y[:, 1], 0.5 * (d_x[:, 1] + d_y[:, 0])], axis=1)
    twice_shear_modulus = YOUNG / (1.0 + POISSON)
    volume = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)) * strain[:, :2].sum(axis=1)
    stress = twice_shear_modulus * strain + volume[:, None] * np.array([1.0, 1.0, 0.0])
    np.testing.assert_allclose(stress, plate.stress_at(points), atol=1e-8)


def test_displacement_jumps_by_opening_and_slip(plate: CrackArray) -> None:
    s = np.linspace(-0.95, 0.95, 9)
    for number, crack in enumerate(SCATTERED):
        z = crack.middle + crack.direction * crack.half_length * s
        left, right = (
            plate.displacement_at(np.stack([p.real, p.imag], axis=1), YOUNG, POISSON)
            for p in (z + 1e-10j * crack.direction, z - 1e-10j * crack.direction)
        )
        jump = ((left - right) @ np.array([1.0, 1.0j])) / crack.direction
        opening, slip = plate.opening_and_slip(number, s, YOUNG / (1.0 - POISSON**2))
        np.testing.assert_allclose(jump, slip + 1j * opening, atol=1e-8)


def test_K_is_the_limit_of_the_jump(plate: CrackArray) -> None:
    young_prime = YOUNG / (1.0 - POISSON**2)
    for number, crack in enumerate(SCATTERED):
        for tip, sign in (("start", -1.0), ("end", 1.0)):
            r = 1e-8
            jump = plate.opening_and_slip(number, np.array([sign * (1.0 - r / crack.half_length)]), young_prime)
            K = np.ravel(jump) * young_prime / 8.0 * np.sqrt(2.0 * np.pi / r)
            np.testing.assert_allclose(K, plate.K(number, tip), rtol=1e-5, atol=1e-5)
