"""Growth criteria on fields made by hand: uniform stress, and the near field of a crack in closed form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, replace

import numpy as np
import pytest

from crackgrow.case.model import Bedding, Strength
from crackgrow.case.toughness import MODE_I, radius_of, shear_radius_of
from crackgrow.fracture.criteria import (
    CRITERIA,
    Criterion,
    TipLoading,
    Verdict,
    directional_strength,
    max_hoop_stress,
    shear_growth,
    strength,
    without_K,
)
from crackgrow.fracture.opening import ahead, hoop_stress_kink, opening
from crackgrow.fracture.sites import LARGEST_KINK
from crackgrow.fracture.tip_stress import TipField
from tests.unit import exact_fields

N_RAYS = 72
ANGLES = np.pi * (2.0 * np.arange(N_RAYS) + 1.0 - N_RAYS) / N_RAYS
RADIUS = 1e-3  # m
ROOT = np.sqrt(2.0 * np.pi * RADIUS)
ROCK = Strength(tension=2.0, cohesion=10.0, friction_angle=40.0)
WEAK_IN_TENSION = Strength(tension=1e-3, cohesion=1e6, friction_angle=40.0)
WEAK_IN_SHEAR = Strength(tension=1e6, cohesion=1e-3, friction_angle=10.0)
RAYS = 1e-3
"""Relative error of a peak between rays that are 5 degrees apart, by a parabola."""

DIRECTION = 0.5
"""Degrees: error of the peak's direction."""


def loading(field: TipField, K_I: float = 0.0, K_II: float = 0.0) -> TipLoading:
    return TipLoading(field, K_I, K_II, RADIUS)


def uniform(stress: tuple[float, float, float], direction: float = 0.0) -> TipLoading:
    """The same stress everywhere, seen by a tip that points to `direction` (rad)."""
    return loading(TipField(direction, ANGLES, np.tile(stress, (N_RAYS, 1)), np.array(stress)))


def uniaxial(sigma: float, axis: float) -> tuple[float, float, float]:
    c, s = np.cos(axis), np.sin(axis)
    return sigma * c * c, sigma * s * s, sigma * c * s


def near_field(
    K_I: float, K_II: float, along: float = 0.0, direction: float = 0.0, pressure: float = 0.0
) -> TipLoading:
    """Williams' field averaged as the polar rule does (2 / sqrt(2 pi R)), plus a stress `along` the crack."""
    rays = 2.0 / ROOT * exact_fields.near_field(ANGLES, K_I, K_II) + np.array([along - pressure, -pressure, 0.0])
    rays = exact_fields.turned(rays, direction)
    return loading(TipField(direction, ANGLES, rays, rays.mean(axis=0)), K_I, K_II)


def largest_hoop(K_I: float, K_II: float, planes: float = 0.0, along: float = 1.0) -> tuple[float, float]:
    """Direction (rad) and sqrt(2 pi r) times the largest hoop stress, over what bedding leaves of resistance."""
    t = np.linspace(-LARGEST_KINK, LARGEST_KINK, 200_001)
    hoop = np.cos(t / 2) * (K_I * np.cos(t / 2) ** 2 - 1.5 * K_II * np.sin(t))
    hoop /= along * np.cos(t - planes) ** 2 + np.sin(t - planes) ** 2
    return float(t[np.argmax(hoop)]), float(hoop.max())


def axis_apart(angle: float, axis: float) -> float:
    """Angle (rad) from 0 to pi/2 between two axes."""
    return float(abs((angle - axis + 0.5 * np.pi) % np.pi - 0.5 * np.pi))


def by_rays(site: TipLoading, limits: Strength) -> Verdict:
    """What `directional_strength` says of a single site."""
    (verdict,) = directional_strength([site], limits)
    return verdict


def in_bedding(limits: Strength, angle: float, along: float) -> Strength:
    """Rock that opens along planes at an angle (degrees) at a part of what it needs across them."""
    toughness = None if limits.toughness is None else along * limits.toughness
    return replace(limits, bedding=Bedding(angle, tension=along * limits.tension, toughness=toughness))


@pytest.mark.parametrize("direction", np.deg2rad([0.0, 130.0]))
@pytest.mark.parametrize("planes", [-70.0, -20.0, 0.0, 45.0, 85.0])
@pytest.mark.parametrize(("K_I", "K_II"), [(1.0, 0.0), (1.0, 0.5), (0.6, -1.0)])
@pytest.mark.parametrize("toughness", [None, 3.0])
def test_a_crack_turns_to_where_the_stress_over_its_resistance_is_largest(
    K_I: float, K_II: float, planes: float, direction: float, toughness: float | None
) -> None:
    """By K, and by rays, within half a degree of the largest value on the exact field."""
    rock = in_bedding(replace(ROCK, cohesion=1e6, toughness=toughness), np.rad2deg(direction) + planes, 0.4)
    kink, K = largest_hoop(K_I, K_II, np.deg2rad(planes), 0.4)
    site = near_field(K_I, K_II, direction=direction)
    by_K, by_hoop = max_hoop_stress(site, rock), by_rays(site, rock)
    assert by_K.kink == pytest.approx(kink, abs=np.deg2rad(0.05))
    assert by_hoop.kink == pytest.approx(kink, abs=np.deg2rad(DIRECTION))
    assert by_K.criticality == pytest.approx(K / (ROCK.tension * ROOT), rel=1e-4)
    expected = 2.0 * K / (ROCK.tension * ROOT) if toughness is None else K / toughness  # by a stress over rays, or by K
    assert by_hoop.criticality == pytest.approx(expected, rel=5e-3 if toughness is None else 1e-4)


@pytest.mark.parametrize("planes", [-60.0, 10.0, 45.0])
def test_strength_opens_planes_of_bedding_under_the_tension_across_them(planes: float) -> None:
    """Uniaxial tension s at right angles to 0: s cos^2 a / (1 + (along - 1) cos^2 (a - b)) on an axis a is largest."""
    rock, a = in_bedding(ROCK, planes, 0.3), np.linspace(-0.5, 0.5, 200_001) * np.pi
    ratio = np.cos(a) ** 2 / (1.0 - 0.7 * np.cos(a - np.deg2rad(planes)) ** 2)
    verdict = strength(uniform((0.0, 1.0, 0.0)), rock)
    assert np.rad2deg(axis_apart(verdict.kink, a[np.argmax(ratio)])) < 0.05
    assert verdict.criticality == pytest.approx(ratio.max() / ROCK.tension, rel=1e-4)


def test_where_K_is_not_known_the_strength_along_the_planes_decides() -> None:
    """A start under uniaxial tension opens planes across it at their strength, and at that of the rock along it."""
    rock = replace(ROCK, cohesion=1e6, toughness=3.0)
    for planes, strength_there in ((0.0, 0.5), (90.0, 1.0)):
        bedded = replace(rock, bedding=Bedding(planes, tension=0.5 * ROCK.tension))
        verdict = by_rays(replace(uniform((0.0, 1.0, 0.0)), K_I=np.nan, K_II=np.nan), bedded)
        assert verdict.criticality == pytest.approx(1.0 / (strength_there * ROCK.tension), rel=RAYS)


AXES = np.deg2rad([-80.0, -33.0, 4.0, 41.0, 77.0])
of_all_criteria = pytest.mark.parametrize("criterion", CRITERIA.values(), ids=CRITERIA.keys())


@pytest.mark.parametrize("direction", np.deg2rad([0.0, 37.0, 190.0, -120.0]))
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("phi_deg", [10.0, 40.0])
def test_strength_grows_across_tension_and_at_45_less_half_phi_to_compression_and_forward(
    phi_deg: float, axis: float, direction: float
) -> None:
    limits = Strength(tension=2.0, cohesion=1.0, friction_angle=phi_deg)
    for sigma, branch, away in ((3.0, "tension", 0.5 * np.pi), (-50.0, "shear", np.deg2rad(45.0 - 0.5 * phi_deg))):
        verdict = strength(uniform(uniaxial(sigma, axis), direction), limits)
        assert verdict.branch == branch
        assert (verdict.sigma_1, verdict.sigma_3) == pytest.approx((max(sigma, 0.0), min(sigma, 0.0)), abs=1e-12)
        assert axis_apart(direction + verdict.kink, axis) == pytest.approx(away)
        assert np.cos(verdict.kink) >= 0.0
        assert branch == "shear" or verdict.criticality == pytest.approx(1.5)  # 3 over 2


def test_tension_comes_first_even_where_shear_is_further_beyond_its_limit() -> None:
    soft = Strength(tension=2.0, cohesion=0.1, friction_angle=30.0)
    verdict = strength(uniform((2.5, -50.0, 0.0)), soft)
    assert verdict.branch == "tension"
    assert verdict.criticality == pytest.approx(1.25)


@pytest.mark.parametrize("phi_deg", [0.0, 20.0, 40.0])
@pytest.mark.parametrize(("s1", "s3"), [(0.0, -30.0), (-4.0, -60.0), (-10.0, -45.0), (1.0, -20.0)])
def test_shear_criticality_is_the_ratio_of_the_circle_to_the_mohr_coulomb_line(
    s1: float, s3: float, phi_deg: float
) -> None:
    """The circle's radius over the distance of its centre from the line: 1 where it touches."""
    verdict = strength(uniform((s3, s1, 0.0)), Strength(tension=1e3, cohesion=10.0, friction_angle=phi_deg))
    phi, radius, centre = np.deg2rad(phi_deg), 0.5 * (s1 - s3), 0.5 * (s1 + s3)
    assert verdict.criticality == pytest.approx(radius / (10.0 * np.cos(phi) - centre * np.sin(phi)), rel=1e-8)


@pytest.mark.parametrize("sense", [-1.0, 1.0])
def test_of_two_shear_planes_the_one_with_the_larger_shear_is_taken(sense: float) -> None:
    """Compression along the crack; the stress is larger above (angles > 0) or below."""
    rays = np.outer(1.0 + 0.3 * sense * np.sin(ANGLES), [-50.0, 0.0, 0.0])
    field = TipField(0.0, ANGLES, rays, rays.mean(axis=0))
    verdict = strength(loading(field), Strength(tension=1e3, cohesion=1.0, friction_angle=30.0))
    assert verdict.branch == "shear"
    assert verdict.kink == pytest.approx(sense * np.deg2rad(30.0))  # 45 - 30 / 2


def test_directional_shear_follows_mohr_coulomb_on_the_ray_of_uniform_stress() -> None:
    """In uniform compression the worst rays are the Mohr-Coulomb planes, and they fail together with these."""
    axis, phi = np.deg2rad(20.0), np.deg2rad(30.0)
    limits = Strength(tension=1e3, cohesion=10.0, friction_angle=30.0)
    sigma = 2.0 * limits.cohesion * np.cos(phi) / (1.0 - np.sin(phi))
    for judge in (by_rays, shear_growth):
        assert judge(uniform(uniaxial(-sigma, axis)), limits).criticality == pytest.approx(1.0, rel=RAYS)
    below, beyond = (by_rays(uniform(uniaxial(-f * sigma, axis)), limits) for f in (0.97, 1.03))
    assert (below.branch, beyond.branch) == ("none", "shear")
    assert axis_apart(beyond.kink, axis) == pytest.approx(0.25 * np.pi - 0.5 * phi, abs=np.deg2rad(DIRECTION))


@of_all_criteria
@pytest.mark.parametrize("radius", [RADIUS, 3e-3])
def test_a_radius_stands_for_the_K_I_that_just_grows(criterion: Criterion, radius: float) -> None:
    limits = Strength(tension=5e5, cohesion=1e9, friction_angle=40.0)
    toughness = limits.tension * np.sqrt(2.0 * np.pi * radius) / MODE_I[criterion.name]
    assert radius_of(criterion.name, limits.tension, toughness) == pytest.approx(radius, rel=1e-12)
    field = near_field(toughness * np.sqrt(RADIUS / radius), 0.0)  # made for RADIUS
    assert criterion.at_tips([field], limits)[0].criticality == pytest.approx(1.0, rel=RAYS)


@of_all_criteria
@pytest.mark.parametrize(("K_I", "K_II"), [(1.0, 0.0), (0.8, -0.5), (0.0, 1.0), (-0.1, 1.0)])
@pytest.mark.parametrize(("along", "pressure"), [(0.0, 0.0), (0.0, 40.0), (-30.0, 20.0), (15.0, 0.0)])
def test_a_tip_with_a_toughness_opens_by_K_whatever_the_rest_of_the_stress(
    K_I: float, K_II: float, along: float, pressure: float, criterion: Criterion
) -> None:
    """K_eq is the largest of all kinks; where the tip goes is for the criterion, as without a toughness."""
    limits = Strength(MODE_I[criterion.name] * 0.3 / ROOT, cohesion=1e9, friction_angle=0.0, toughness=0.3)
    K_eq = largest_hoop(K_I, K_II)[1]
    found = criterion.at_tips([near_field(f * K_I, f * K_II, along, pressure=pressure) for f in (1.0, 3.0)], limits)
    assert [verdict.criticality for verdict in found] == pytest.approx([K_eq / 0.3, K_eq / 0.1], rel=1e-6)
    assert {verdict.mode for verdict in found} == {"tension"}
    pulled = [near_field(share * K_I, share * K_II, along, pressure=-1e3) for share in (1.0, 3.0)]
    by_stress = criterion.at_tips(pulled, replace(limits, toughness=None))
    assert [verdict.kink for verdict in found] == pytest.approx([verdict.kink for verdict in by_stress], abs=1e-9)


@pytest.mark.parametrize("criterion", [CRITERIA["strength"], CRITERIA["directional_strength"]], ids=lambda c: c.name)
def test_a_toughness_leaves_shear_and_places_without_K_to_the_stress(criterion: Criterion) -> None:
    limits = Strength(tension=0.35, cohesion=0.58, friction_angle=32.0)
    tough = replace(limits, toughness=1e3)
    pressed = near_field(0.0, 1e-2, pressure=0.1)
    (with_it,), (without) = criterion.at_tips([pressed], tough), criterion.at_tips([pressed], limits)[0]
    assert (with_it.mode, with_it.criticality) == ("shear", without.of_shear or without.criticality)
    start = near_field(0.02, 0.0, along=-1.0)
    unknown = without_K(start.field, RADIUS)
    assert astuple(criterion.at_starts([unknown], tough)[0]) == astuple(criterion.at_starts([start], limits)[0])


def test_mean_factor_is_that_of_a_disc_with_weight_one_over_r() -> None:
    """Mean over the angle of cos t/2 (1 + sin t/2 sin 3t/2) times the mean 2 of (R / r)^1/2 along a ray."""
    t = (np.arange(100_000) + 0.5) / 100_000 * 2.0 * np.pi - np.pi
    angular = np.cos(t / 2) * (1.0 + np.sin(t / 2) * np.sin(3 * t / 2))
    assert MODE_I["strength"] == pytest.approx(2.0 * angular.mean(), abs=5e-5)  # given to four decimals
    assert 2.0 * angular.mean() == pytest.approx(24.0 / (5.0 * np.pi), rel=1e-8)
    assert MODE_I["directional_strength"] == 2.0  # straight ahead the angular part is 1


def test_rays_outside_of_the_body_and_along_the_crack_itself_are_left_out() -> None:
    field = near_field(0.0, -1.0).field  # the largest hoop stress is at 70.5 degrees
    rays = field.rays.copy()
    rays[np.abs(np.rad2deg(ANGLES) - 70.0) < 20.0] = np.nan
    verdict = by_rays(loading(replace(field, rays=rays)), WEAK_IN_TENSION)
    assert np.rad2deg(verdict.kink) == pytest.approx(92.5, abs=1e-9)  # larger than at 47.5: 1.035 to 1.012
    rays = np.zeros((N_RAYS, 3))
    rays[np.abs(np.rad2deg(ANGLES)) > 160.0] = (0.0, 100.0, 0.0)  # hoop tension behind the tip
    rays[36] = (0.0, 5.0, 0.0)  # at 2.5 degrees
    verdict = by_rays(loading(replace(field, rays=rays)), ROCK)
    assert abs(np.rad2deg(verdict.kink)) < 5.0
    assert verdict.criticality == pytest.approx(2.5, rel=0.01)


def test_in_rock_with_elastic_bedding_a_crack_turns_to_the_largest_hoop_stress_there() -> None:
    """By the hoop stress of Saouma, Ayari, Leavell 1987, eq. 8, (cos t + s sin t)^(3/2) weighed by the roots."""
    first, last, t = 0.35 + 0.6j, -0.2 + 1.9j, np.linspace(-LARGEST_KINK, LARGEST_KINK, 4001)
    one, other = ((np.cos(t) + root * np.sin(t)) ** 1.5 for root in (first, last))
    for K in ((1.0, 0.0), (1.0, -0.6), (0.2, 1.0)):
        hoop = ((K[0] * (first * other - last * one) + K[1] * (other - one)) / (first - last)).real
        np.testing.assert_allclose(ahead(K, t, (first, last))[0], hoop, atol=1e-13)
        size, kink = opening(K, (first, last))
        assert (size, kink) == pytest.approx((hoop.max(), t[hoop.argmax()]), abs=1e-3)
        assert opening(K, (last, first)) == pytest.approx((size, kink), abs=1e-9)


@pytest.mark.parametrize("K_I", [-2.0, -0.1, 0.0, 0.3, 1.0, 5.0])
@pytest.mark.parametrize("K_II", [1.0, -0.5])
def test_a_crack_turns_to_the_largest_hoop_stress(K_I: float, K_II: float) -> None:
    """By K, also that of closed faces; by rays of open ones."""
    (kink, hoop), site = largest_hoop(K_I, K_II), near_field(K_I, K_II)
    assert hoop_stress_kink(K_I, K_II) == pytest.approx(kink, abs=2e-5)
    verdict = max_hoop_stress(site, WEAK_IN_TENSION)
    assert (verdict.kink, verdict.criticality) == pytest.approx((kink, hoop / WEAK_IN_TENSION.tension / ROOT), abs=2e-5)
    (kink, hoop), open_site = largest_hoop(abs(K_I), K_II), near_field(abs(K_I), K_II)
    verdict = by_rays(open_site, WEAK_IN_TENSION)
    assert verdict.branch == "tension"
    assert np.rad2deg(verdict.kink) == pytest.approx(np.rad2deg(kink), abs=DIRECTION)
    assert verdict.criticality == pytest.approx(2.0 * hoop / ROOT / WEAK_IN_TENSION.tension, rel=2.0 * RAYS)


def test_a_small_K_II_turns_the_crack_in_proportion_and_a_pressed_tip_does_not_grow() -> None:
    for K_II in (1e-3, 1e-9, 1e-15, -1e-15, 0.0):
        assert hoop_stress_kink(1.0, K_II) == pytest.approx(-2.0 * K_II, rel=1e-5, abs=0.0)
    verdict = max_hoop_stress(near_field(-1.0, 0.0), WEAK_IN_TENSION)
    assert (verdict.branch, verdict.kink) == ("none", 0.0)
    assert verdict.criticality < 0.0


def tough_in_shear(field: TipField, part: float = 1.0) -> TipLoading:
    """A tip whose toughness in shear stands for a length `part` times that of its field, which is all singular."""
    return loading(replace(field, shear=field.mapped(lambda stress: stress / np.sqrt(part))))


@pytest.mark.parametrize("judge", [shear_growth, by_rays])
@pytest.mark.parametrize("pressure", [0.0, 0.1, 1.0])
@pytest.mark.parametrize(("friction", "phi"), [(0.0, 0.0), (0.0, 32.0), (0.6, 32.0), (0.9, 32.0)])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_shear_grows_straight_on_at_its_toughness_and_what_pressure_adds(
    sense: float, friction: float, phi: float, pressure: float, judge: Callable[[TipLoading, Strength], Verdict]
) -> None:
    """Faces that slide under a pressure p leave the shear stress mu p ahead of the tip, the rock bears p tan(phi)."""
    K_IIc = 0.5 * 0.58 * ROOT
    limits = Strength(tension=1e3, cohesion=0.58, friction_angle=phi, shear_toughness=K_IIc)
    assert shear_radius_of(limits.cohesion, K_IIc) == pytest.approx(RADIUS)
    K_II = sense * K_IIc * (1.0 + pressure * (np.tan(np.deg2rad(phi)) - friction) / limits.cohesion)
    field = near_field(0.0, K_II, pressure=pressure).field
    slides = field.mapped(lambda stress: stress + sense * friction * pressure * np.array([0.0, 0.0, 1.0]))
    verdict = judge(tough_in_shear(slides), limits)
    assert verdict.mode == "shear"
    assert verdict.criticality == pytest.approx(1.0, rel=RAYS)
    assert np.rad2deg(verdict.kink) == pytest.approx(0.0, abs=DIRECTION)


def test_rays_in_tension_do_not_grow_in_shear() -> None:
    """K_I turns the ray with the largest shear stress to where it is pulled beyond the tensile strength."""
    limits = Strength(tension=0.35, cohesion=1e-3, friction_angle=30.0)
    assert shear_growth(tough_in_shear(near_field(1.0, 1.0).field), limits).criticality == 0.0
    assert shear_growth(tough_in_shear(near_field(-1.0, 1.0).field), limits).criticality > 1.0
    assert shear_growth(uniform((1.0, 1.0, 0.4)), WEAK_IN_SHEAR).criticality == 0.0
    assert shear_growth(uniform((-1.0, -1.0, 0.4)), WEAK_IN_SHEAR).criticality > 1.0


@pytest.mark.parametrize("part", [0.25, 1.0, 9.0])
def test_a_toughness_in_shear_leaves_tension_alone(part: float) -> None:
    """Without friction the load of shear rises with it, which is the square root of the length."""
    plain = near_field(0.0, 1.0)
    for limits in (WEAK_IN_TENSION, replace(WEAK_IN_SHEAR, friction_angle=0.0)):
        one, both = (by_rays(each, limits) for each in (plain, tough_in_shear(plain.field, part)))
        assert both.mode == one.mode
        scale = 1.0 if one.mode == "tension" else np.sqrt(part)
        assert one.criticality == pytest.approx(scale * both.criticality, rel=1e-12)


@of_all_criteria
def test_a_branch_that_is_met_stays_met_as_the_load_rises(criterion: Criterion) -> None:
    """The criticality does: from shear's to tension's where that comes first, though shear was met at a lower load."""
    rng, fell, weak = np.random.default_rng(5), False, replace(ROCK, cohesion=1.0)
    for K_I, K_II, along in rng.normal(size=(10, 3)) * (0.1, 0.2, 4.0):
        site = near_field(K_I, K_II, along, pressure=1.0)
        for last in (site, tough_in_shear(site.field)):
            loads = [TipLoading.between(last.none, last, share) for share in np.linspace(0.0, 2.0, 100)]
            verdicts = criterion.at_tips(loads, weak)
            met = np.array([verdict.largest >= 1.0 for verdict in verdicts])
            assert (np.diff(met.astype(int)) >= 0).all()
            assert all(verdict.largest >= verdict.criticality for verdict in verdicts)
            fell |= bool(np.diff([verdict.criticality for verdict in verdicts]).min() < -0.1)
    assert fell == (criterion.name != "max_hoop_stress")


@of_all_criteria
def test_a_site_is_judged_alike_alone_and_among_others(criterion: Criterion) -> None:
    """Sites of all directions, with rays that cracks hide, with other rays, with none ahead, tough in shear."""
    rng = np.random.default_rng(3)
    sites = [near_field(*rng.normal(size=3), direction) for direction in rng.uniform(-3.0, 3.0, 20)]
    hidden = [near_field(1.0, K_II) for K_II in (-0.5, 0.2, 0.5)]
    for number, site in enumerate(hidden):
        site.field.rays[20 + number : 30] = np.nan
    few = uniform((1.0, -2.0, 0.3)).field
    fewer = loading(replace(few, angles=few.angles[::2], rays=few.rays[::2]))
    narrow = [loading(replace(site.field, half_width=width)) for site in sites[:4] for width in (0.05, 0.4)]
    unseen = loading(replace(few, rays=np.full((N_RAYS, 3), np.nan)))
    sites += [*hidden, fewer, *narrow, tough_in_shear(sites[0].field), unseen, tough_in_shear(unseen.field)]
    for judge in (criterion.at_tips, criterion.at_starts):
        alone = [verdict for site in sites for verdict in judge([site], ROCK)]
        assert list(map(astuple, judge(sites, ROCK))) == list(map(astuple, alone))
        assert judge([], ROCK) == []
