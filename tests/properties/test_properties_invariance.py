"""What must not matter: where the scene lies, its mirror image, its units, its stiffness."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.case.model import PointSupport
from crackgrow.cover.elements import locate
from crackgrow.solid.recovery import displacement_at, stress_at

KINKED = np.array([(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)])
LOWER, UPPER = np.array([0.0, 0.0]), np.array([6.0, 5.0])
PLACES = np.random.default_rng(80).uniform(LOWER, UPPER, (200, 2))
PLACES = PLACES[np.abs(PLACES[:, None] - KINKED).max(axis=2).min(axis=1) > 0.2]


def solution(build, *, shift=(0.0, 0.0), mirror=(1.0, 1.0), size=1.0, young=1.0, support=2.0, traction=(0.2, 1.0)):
    """Displacement over traction / modulus and size, and stress over traction, at the same places of the scene.

    `mirror` turns the scene about its centre before it is scaled by `size` and moved by `shift`.
    """
    shift, mirror = np.array(shift), np.array(mirror)
    middle = 0.5 * (LOWER + UPPER)

    def place(points: np.ndarray) -> np.ndarray:
        return (middle + (points - middle) * mirror) * size + shift

    sample = build.sample(
        LOWER * size + shift, UPPER * size + shift, [build.crack(place(KINKED))],
        spacing=size, support=support, young=young,
    )  # fmt: skip
    t = young * 1e-3 * np.array(traction) * mirror
    top, bottom = ("top", "bottom") if mirror[1] > 0 else ("bottom", "top")
    held = [
        PointSupport("rock", place(LOWER), (0.0, 0.0)),
        PointSupport("rock", place(LOWER * (0, 1) + UPPER * (1, 0)), (None, 0.0)),
    ]
    u = sample.solve(held, {top: tuple(t), bottom: tuple(-t)})
    points = sample.lattice.to_lattice(place(PLACES))
    elements = locate(sample.lattice, sample.cover.elements, points)
    displacement = displacement_at(sample.cover, u, points, elements) * mirror / (1e-3 * size)
    stress = stress_at(sample.cover, [sample.material], u, points, elements) / (young * 1e-3)
    return displacement, stress * (1, 1, mirror[0] * mirror[1])


@pytest.fixture(scope="module")
def reference(build):
    return solution(build)


@pytest.mark.parametrize("shift", [(10.0, -3.0), (0.1, 0.2), (-np.pi, np.e), (0.0, 1e3)])
def test_shifted_scene_has_the_same_solution(build, reference, shift: tuple[float, float]) -> None:
    """The lattice moves with the body. Rounding to the grid moves vertices by up to 1e-9 spacings."""
    for found, expected in zip(solution(build, shift=shift), reference, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(("size", "young"), [(1e-3, 1.0), (1e-3, 1e6), (1.0, 70e9), (1e3, 70e9), (25.4e-3, 1.0)])
def test_units_do_not_matter(build, reference, size: float, young: float) -> None:
    """Millimetres for metres, MPa for Pa."""
    for found, expected in zip(solution(build, size=size, young=young), reference, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("mirror", [(-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
def test_mirrored_scene_has_the_mirrored_solution(build, reference, mirror: tuple[float, float]) -> None:
    """Polygons fall into the mirrored triangles, with the mirrored points."""
    for found, expected in zip(solution(build, mirror=mirror), reference, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_solution_is_linear_in_the_load(build, reference) -> None:
    one, two = solution(build, traction=(0.2, 0.0)), solution(build, traction=(0.0, 1.0))
    for first, second, expected in zip(one, two, reference, strict=True):
        np.testing.assert_allclose(first + second, expected, atol=1e-9 * np.abs(expected).max())


def test_turning_the_crack_round_does_not_matter(build) -> None:
    """The same scene with start and end of the crack exchanged: the same functions in another order."""
    results = []
    for points in (KINKED, KINKED[::-1]):
        sample = build.sample(LOWER, UPPER, [build.crack(points)], support=2.0)
        held = [PointSupport("rock", LOWER, (0.0, 0.0)), PointSupport("rock", np.array([6.0, 0.0]), (None, 0.0))]
        u = sample.solve(held, {"top": (0.2, 1.0), "bottom": (-0.2, -1.0)})
        at = sample.lattice.to_lattice(PLACES)
        results.append(displacement_at(sample.cover, u, at, locate(sample.lattice, sample.cover.elements, at)))
    np.testing.assert_allclose(results[0], results[1], atol=1e-8 * np.abs(results[0]).max())


def test_crack_without_load_opens_under_tension_and_the_body_gets_softer(build) -> None:
    """The work of the load grows with the crack's length."""
    held = [PointSupport("rock", LOWER, (0.0, 0.0)), PointSupport("rock", np.array([6.0, 0.0]), (None, 0.0))]
    tops = np.array([[x, 5.0] for x in np.linspace(0.5, 5.5, 11)])
    lifts = []
    for half in (0.0, 0.8, 1.3, 1.8):
        cracks = [build.crack([(3.0 - half, 2.4), (3.0 + half, 2.4)])][: int(half > 0)]
        sample = build.sample(LOWER, UPPER, cracks, support=1.5)
        u = sample.solve(held, {"top": (0.0, 1.0), "bottom": (0.0, -1.0)})
        at = sample.lattice.to_lattice(tops)
        elements = locate(sample.lattice, sample.cover.elements, at)
        bottom = sample.lattice.to_lattice(tops * (1, 0))
        under = locate(sample.lattice, sample.cover.elements, bottom)
        top = displacement_at(sample.cover, u, at, elements)
        lifts.append(np.mean((top - displacement_at(sample.cover, u, bottom, under))[:, 1]))
    assert np.all(np.diff(lifts) > 0.0)
