"""The loading of a tip whose K is off: the singular field of the difference is added to the stress round it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.case.model import Strength
from crackgrow.fracture.criteria import (
    CRITERIA,
    TipLoading,
    directional_strength,
    hoop_and_shear,
    hoop_stress_kink,
    max_hoop_stress,
    strength,
)
from crackgrow.fracture.tip_stress import TipField
from crackgrow.fracture.williams import singular_stress, williams_gradient
from crackgrow.solid.elasticity import plane_elasticity

LIMITS = Strength(tension=1e6, cohesion=1e9, friction_angle=30.0)
RADIUS = 2e-3
ANGLES = np.pi * (2.0 * np.arange(72) + 1.0 - 72) / 72


def unloaded(direction: float) -> TipLoading:
    return TipLoading(TipField(direction, ANGLES, np.zeros((72, 3)), np.zeros(3)), 0.0, 0.0, RADIUS)


def test_the_singular_stress_is_that_of_the_displacement() -> None:
    material = plane_elasticity(1e10, 0.25, "strain")
    t = np.linspace(-3.0, 3.0, 13)
    gradient = williams_gradient(material, np.ones(13), t)
    for mode in range(2):
        xx, yy = gradient[:, mode, 0, 0], gradient[:, mode, 1, 1]
        strain = np.stack([xx, yy, gradient[:, mode, 0, 1] + gradient[:, mode, 1, 0]], axis=1)
        stress = strain @ np.array(material.matrix).T * np.sqrt(2.0 * np.pi)
        np.testing.assert_allclose(singular_stress(t, 0.0)[:, :, mode], stress, atol=1e-12)


@pytest.mark.parametrize("direction", [0.0, 0.7, -2.5])
def test_axes_turn_with_the_tip(direction: float) -> None:
    """Hoop stress and shear on rays do not know of the axes: cos^3(t/2) and so on (Irwin 1957)."""
    [loading] = unloaded(direction).with_K_off((1.0, 0.0))
    hoop, shear = hoop_and_shear(loading.field, loading.field.rays)
    unit = 2.0 / np.sqrt(2.0 * np.pi * RADIUS)
    half = 0.5 * ANGLES
    np.testing.assert_allclose(hoop, unit * np.cos(half) ** 3, atol=1e-9)
    np.testing.assert_allclose(shear, unit * np.sin(half) * np.cos(half) ** 2, atol=1e-9)


@pytest.mark.parametrize("K", [(1e5, 0.0), (1e5, -5e4), (2e4, 8e4)])
def test_criteria_see_a_tip_that_has_this_K(K: tuple[float, float]) -> None:
    [loading] = unloaded(0.4).with_K_off(K)
    assert (loading.K_I, loading.K_II) == K
    kink = hoop_stress_kink(*K)
    assert max_hoop_stress(loading, LIMITS).kink == kink
    (by_ray,) = directional_strength([loading], LIMITS)
    assert by_ray.kink == pytest.approx(kink, abs=np.deg2rad(1.0))
    assert by_ray.criticality == pytest.approx(2.0 * max_hoop_stress(loading, LIMITS).criticality, rel=2e-3)
    assert set(CRITERIA) == {"strength", "directional_strength", "max_hoop_stress"}


def test_over_another_length_for_shear_K_is_off_by_as_much() -> None:
    """Of every loading between two as well; the average of 1 / sqrt(r) over a length falls with its square root."""
    plain = unloaded(0.3)
    both = replace(plain, field=replace(plain.field, radius=RADIUS, shear=replace(plain.field, radius=4.0 * RADIUS)))
    _, moved = both.with_K_off((2e4, 0.0), (1e5, -5e4))
    half = TipLoading.between(moved.none, moved, 0.5)
    assert moved.field.shear is not None
    assert half.field.shear is not None
    np.testing.assert_allclose(moved.field.shear.rays, 0.5 * moved.field.rays, rtol=1e-12)
    np.testing.assert_allclose(half.field.shear.rays, 0.5 * moved.field.shear.rays, rtol=1e-12)
    np.testing.assert_allclose(half.field.shear.mean, 0.5 * moved.field.shear.mean, rtol=1e-12)


def test_the_average_over_the_disc_is_that_of_the_singular_field() -> None:
    """4.8 / pi in mode I, 1.0186 for the shear of mode II."""
    unit = 1.0 / np.sqrt(2.0 * np.pi * RADIUS)
    mean_I, mean_II = (loading.field.mean for loading in unloaded(0.0).with_K_off((1.0, 0.0), (0.0, 1.0)))
    assert mean_I[1] == pytest.approx(4.8 / np.pi * unit, rel=1e-3)
    assert mean_II[2] == pytest.approx(1.0186 * unit, rel=1e-3)
    [opened] = unloaded(0.0).with_K_off((1e5, 0.0))
    assert strength(opened, LIMITS).kink == pytest.approx(0.0, abs=1e-9)
