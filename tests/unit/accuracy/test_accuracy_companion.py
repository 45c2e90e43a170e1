"""Errors from two meshes and the cells that are refined for them; the estimate in the energy norm on known fields."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from crackgrow.accuracy.companion import (
    BOUND,
    Errors,
    Grading,
    Quantities,
    coarsened,
    errors_of,
    refined,
    unresolved_shear,
)
from crackgrow.accuracy.energy_norm import error_estimate
from crackgrow.arrays import Floats
from crackgrow.case.model import ElasticBedding
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.cover.shapes import turned_roots
from crackgrow.cover.tips import tip_angle
from crackgrow.fracture.near_tip import near_tip_gradient
from crackgrow.fracture.singular_stress import SingularStress
from crackgrow.solid.elasticity import PlaneElasticity, plane_elasticity
from crackgrow.solid.recovery import stress_of
from tests.conftest import Build
from tests.unit.exact_fields import solved_under, true_error

ENDS = ((0, False), (0, True), (1, True))
HERE = Quantities(
    ENDS, np.array([[3.0, 0.0], [3.0, 4.0], [1.0, 0.0]]), np.zeros(3), np.array([5.0, -4.0, 1.0]),
    np.array([0.0, 0.4, 0.0]), np.zeros(3), np.array([0.1, 0.2, 0.3]), 2.0, np.array([[0.0, 2.0]]),
    np.array([[3.0, 4.0]]), {"K": 0.1, "slip": 1e-9, "reaction": 1e-9},
)  # fmt: skip
GRADING = Grading(nested=True)


def test_the_difference_of_a_crack_is_that_of_its_tip_where_it_is_largest() -> None:
    there = replace(
        HERE,
        K=HERE.K + np.array([[0.03, 0.04], [0.0, 0.0], [0.01, 0.0]]),
        T=HERE.T + np.array([0.1, -0.3, 0.2]),
        kinks=HERE.kinks + np.array([0.0, 0.05, 0.01]),
    )
    errors = errors_of(GRADING, HERE, there)
    assert pytest.approx((0.05, 0.05, 0.01)) == errors.K
    assert pytest.approx((0.5, 0.5, 0.2)) == errors.T  # its spread of 0.4 and the difference of 0.3, at the second tip
    assert errors.kinks == pytest.approx((0.05, 0.05, 0.01))
    assert (errors.largest, errors.estimate("K")) == (5.0, pytest.approx(0.05 / 5.0))
    assert errors.estimate_by_crack("K", 3) == pytest.approx([0.05 / 5.0, 0.01 / 5.0, 0.0])
    small = errors_of(GRADING, replace(HERE, small={**HERE.small, "K": 8.0}), there)
    assert small.estimate("K") == pytest.approx(0.05 / 8.0)


def test_the_spread_of_the_integral_and_shear_that_no_mesh_sees_are_added() -> None:
    noisy = replace(HERE, spread=np.array([0.0, 0.0, 0.3]), unresolved=np.array([0.0, 0.0, 1.2]))
    errors = errors_of(GRADING, noisy, replace(HERE, K=HERE.K + np.array([[0.0, 0.0], [0.0, 0.0], [0.4, 0.0]])))
    assert pytest.approx((0.0, 0.0, 0.5 + 1.2 / BOUND)) == errors.K


def test_directions_and_critical_loads_are_known_no_better_than_the_K_that_they_follow_from() -> None:
    there = replace(HERE, K=HERE.K + np.array([[0.0, 0.0], [0.0, 0.1], [0.02, 0.0]]), load_factor=2.0 + 1e-9)
    errors = errors_of(GRADING, HERE, there)
    assert errors.kinks == pytest.approx((0.1 / 3.0, 0.1 / 5.0, 0.02 / 1.0))
    assert errors.shares["load_factor"] == pytest.approx(0.1 / 5.0)
    assert errors_of(GRADING, HERE, replace(there, load_factor=2.0)).shares["load_factor"] == 0.0  # it was given


def test_tips_are_found_by_name_and_what_is_not_there_is_not_known() -> None:
    there = replace(HERE, ends=ENDS[1:], K=HERE.K[1:] + 0.1, kinks=HERE.kinks[1:])
    errors = errors_of(GRADING, HERE, there)
    assert math.isnan(errors.K[0])
    assert errors.K[1:] == pytest.approx((0.1 * math.sqrt(2.0),) * 2)


def test_goals_are_shares_of_their_largest_values_and_unknown_without_a_companion() -> None:
    there = replace(HERE, load_factor=2.1, jumps=np.array([[0.0, 1.9]]), forces=np.array([[3.0, 4.5]]))
    errors = errors_of(GRADING, HERE, there)
    assert [errors.estimate(goal) for goal in ("load_factor", "slip", "reaction")] == pytest.approx([0.05, 0.05, 0.1])
    small = replace(HERE, jumps=np.array([[0.0, 1e-3]]), small={**HERE.small, "slip": 0.5})
    assert errors_of(GRADING, small, replace(small, jumps=np.zeros((1, 2)))).estimate("slip") == pytest.approx(2e-3)
    nothing = replace(HERE, jumps=np.zeros((0, 2)))
    assert errors_of(GRADING, nothing, nothing).estimate("slip") == math.inf
    unknown = errors_of(GRADING, HERE, None)
    assert all(map(math.isnan, (*unknown.K, *unknown.kinks)))
    assert unknown.estimate("K") == unknown.estimate("slip") == math.inf


def test_a_tip_that_opens_before_the_first_contact_point_loses_its_shear() -> None:
    """All of it over the length a of K_I = p sqrt(8 a / pi), or up to the point."""
    y, p, c = 0.01, 4.0, 2.0
    a = 0.25 * y
    assert unresolved_shear(p * math.sqrt(8.0 * a / math.pi), y, p, c) == pytest.approx(
        c * math.sqrt(8.0 * a / math.pi)
    )
    assert unresolved_shear(1e9, y, p, c) == pytest.approx(c * math.sqrt(8.0 * y / math.pi))
    assert unresolved_shear(-1.0, y, p, c) == unresolved_shear(0.0, y, p, c) == 0.0


def off(*shares: float, grading: Grading = GRADING) -> Errors:
    """Errors whose estimates are such shares of the largest K, crack by crack."""
    ends = tuple((crack, True) for crack in range(len(shares)))
    return Errors(grading, ends, tuple(share for share in shares), 1.0)


def apart(n: int, distance: float = 1.0) -> list[Floats]:
    """Cracks of length 1, one above the other."""
    return [np.array([[0.0, distance * number], [1.0, distance * number]]) for number in range(n)]


def test_neighbours_are_refined_in_a_second_round_and_kept_with_a_crack_that_is_off() -> None:
    """In the first those alone that have no K to say so themselves."""
    now, lines = off(0.035, 0.009, 0.0), apart(3, 0.4)
    assert refined(now, None, 0.01, "K", lines, ()).cracks == (2, 0, 0)
    assert refined(now, off(0.07, 0.0, 0.0), 0.01, "K", lines, ()).cracks == (2, 2, 0)
    tipless = replace(now, ends=((0, True), (2, True)), K=(0.035, 0.0))
    assert refined(tipless, None, 0.01, "K", lines, ()).cracks == (2, 2, 0)
    begun = off(0.001, 0.02, 0.001, math.nan, grading=replace(GRADING, cracks=(2, 2, 2, 2)))
    assert coarsened(begun, 0.01, "K", [*apart(3, 0.2), *apart(5)[4:]], ()).cracks == (2, 2, 2, 2)
    assert coarsened(begun, 0.01, "K", apart(4), ()).cracks == (0, 2, 0, 2)


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


@pytest.mark.physics
@pytest.mark.parametrize("support", [1.5, 1.75, 2.0, 2.5])
def test_the_estimate_of_a_smooth_field_is_its_error_or_a_bound(build: type[Build], support: float) -> None:
    """Rates are one; at a support of two (cubic splines) it falls as that of a quadratic fit, which is larger."""
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


K = (2.0, -1.0)
MATERIAL = plane_elasticity(1.0, 0.25, "strain")
BEDDED = plane_elasticity(1.0, 0.25, "strain", ElasticBedding(35.0, 0.4, 0.2, 0.3))


def williams(cover: Cover, points: np.ndarray, elements: np.ndarray, rock: PlaneElasticity = MATERIAL) -> np.ndarray:
    """Stress (n, 3) of K at the first tip."""
    tip = cover.tips[0]
    r, t = tip_angle(tip, points, cover.elements.reference[elements])
    gradient = np.einsum("nmcd,m->ncd", near_tip_gradient(rock.turned(tip.rotation), r * cover.lattice.spacing, t), K)
    turned = tip.rotation.T @ gradient @ tip.rotation
    return stress_of([rock], turned, np.zeros(len(r), dtype=np.int64), np.zeros((len(r), 2)))


def points_in(cover: Cover, low: tuple[float, float], high: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    points = np.random.default_rng(5).uniform(low, high, (200, 2))
    elements = locate(cover.lattice, cover.elements, points)
    return points[elements >= 0], elements[elements >= 0]


def in_bedded(cover: Cover) -> Cover:
    """The cover in rock with bedding."""
    return replace(cover, bodies=tuple(replace(body, roots=BEDDED.roots) for body in cover.bodies))


@pytest.mark.parametrize("kink", [0.0, 1.0])
def test_from_an_edge_it_is_the_field_of_williams_and_that_of_bedded_rock(build: type[Build], kink: float) -> None:
    crack = build.crack([(0.0, 1.5), (2.1, 1.5), (3.0, 1.5 + kink)], tips=(False, True))
    cover = build.sample((0.0, 0.0), (6.0, 4.0), (crack,), spacing=0.5, support=2.0).cover
    points, elements = points_in(cover, (3.0, 2.0), (14.0, 10.0))
    np.testing.assert_allclose(
        SingularStress(cover, 0, K).at(points, elements), williams(cover, points, elements), rtol=1e-10, atol=1e-12
    )
    found = SingularStress(in_bedded(cover), 0, K).at(points, elements)
    np.testing.assert_allclose(found, williams(cover, points, elements, BEDDED), rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 0.6])
def test_both_tips_of_a_straight_crack_make_the_field_of_griffith(build: type[Build], angle: float) -> None:
    """The field of an infinite plate less the stress at infinity, Z = z / sqrt(z^2 - a^2) - 1 (Muskhelishvili 1953)."""
    half, along = 0.75, np.array([np.cos(angle), np.sin(angle)])
    middle, rotation = np.array([3.0, 2.5]), np.array([along, [-along[1], along[0]]])
    crack = build.crack([middle - half * along, middle + half * along])
    cover = build.sample((0.0, 0.0), (6.0, 5.0), (crack,), spacing=0.5, support=2.0).cover
    points, elements = points_in(cover, (5.0, 4.0), (12.0, 10.0))
    local = (cover.lattice.to_metres(points) - middle) @ rotation.T
    z = local @ (1.0, 1.0j)
    root = np.sqrt(z - half) * np.sqrt(z + half)
    Z, slope, y = z / root, -(half**2) / root**3, local[:, 1]
    opening, sliding = np.array(K) / np.sqrt(np.pi * half)
    xx = opening * (Z.real - y * slope.imag) + sliding * (2.0 * Z.imag + y * slope.real)
    yy = opening * (Z.real + y * slope.imag) - sliding * y * slope.real
    xy = -opening * y * slope.real + sliding * (Z.real - y * slope.imag)
    tensor = np.stack([np.stack([xx, xy], axis=1), np.stack([xy, yy], axis=1)], axis=1)
    turned = rotation.T @ tensor @ rotation
    found = sum(SingularStress(cover, tip, K).at(points, elements) for tip in range(2))
    difference = found - np.stack([turned[:, 0, 0], turned[:, 1, 1], turned[:, 0, 1]], axis=1)
    assert np.abs(difference - difference[0]).max() < 1e-7  # uniform; tips are rounded to 1e-9 spacings
    bedded, exact = in_bedded(cover), np.zeros((3, len(points)))
    roots = turned_roots(BEDDED.roots, rotation)
    for s, other in (roots, roots[::-1]):
        z = local[:, 0] + s * local[:, 1]
        Z = z / (np.sqrt(z - half) * np.sqrt(z + half))
        exact += (np.array([[s * s], [1.0], [-s]]) * -(other * opening + sliding) / (s - other) * Z).real
    xx, yy, xy = exact
    turned = rotation.T @ np.stack([np.stack([xx, xy], axis=1), np.stack([xy, yy], axis=1)], axis=1) @ rotation
    found = sum(SingularStress(bedded, tip, K).at(points, elements) for tip in range(2))
    difference = found - np.stack([turned[:, 0, 0], turned[:, 1, 1], turned[:, 0, 1]], axis=1)
    assert np.abs(difference - difference[0]).max() < 1e-7


@pytest.mark.physics
@pytest.mark.parametrize("support", [1.5, 2.0])
def test_the_estimate_of_a_singular_field_is_its_error(build: type[Build], support: float) -> None:
    """An edge crack under the tractions of Williams' field."""
    for spacing in (0.5, 0.25):
        crack = build.crack([(0.0, 1.53), (2.1, 1.53)], tips=(False, True))
        sample = build.sample((0.0, 0.0), (4.0, 3.0), (crack,), spacing=spacing, support=support)
        cover = sample.cover

        def field(metres: np.ndarray, cover: Cover = cover) -> np.ndarray:
            points = cover.lattice.to_lattice(metres)
            return williams(cover, points, locate(cover.lattice, cover.elements, points))

        u = solved_under(sample, field)
        error = true_error(sample, u, field)
        estimate = error_estimate(cover, [sample.material], u, [SingularStress(cover, 0, K)]).relative
        assert error < 15.0
        assert 0.7 < estimate / error < 1.4
        assert error_estimate(cover, [sample.material], u, ()).relative > 2.0 * error  # the split is what does it
