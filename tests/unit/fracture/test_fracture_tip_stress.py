"""The averaged stress at a tip, on fields that the cover holds exactly: K fields and uniform stress."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from crackgrow.fracture.face_displacements import from_face_displacements
from crackgrow.fracture.sites import tip_site
from crackgrow.fracture.tip_stress import N_RAYS, fields_of, stress_functionals
from crackgrow.solid.elasticity import plane_elasticity
from tests.unit import exact_fields

POISSON = 0.25
SHEAR_MODULUS = 1.0 / (2.0 * (1.0 + POISSON))  # of the sample's Young's modulus 1
KOLOSOV = {"strain": 3.0 - 4.0 * POISSON, "stress": (3.0 - POISSON) / (1.0 + POISSON)}
RAYS = 5e-4
"""Relative error of a mean over the angle by 72 rays: the stress has kinks on the crack faces."""


def stub(build, angle_deg: float, at_end: bool, spacing: float = 1.0):
    """A short edge crack all in one cell: there all patches are singular and sum to one, up to 0.2 from the tip."""
    a = np.deg2rad(angle_deg)
    mouth = np.array([0.0, 6.03])
    tip = mouth + 0.25 * np.array([np.cos(a), np.sin(a)])
    path = spacing * np.array([mouth, tip] if at_end else [tip, mouth])
    corner = spacing * np.array([12.0, 12.0])
    return build.sample((0.0, 0.0), corner, [build.crack(path, (not at_end, at_end))], support=2.0, spacing=spacing)


def at_tips(cover) -> list:
    return [tip_site(tip) for tip in cover.tips]


def near_field(sample, K_I: float, K_II: float, plane: str = "strain") -> np.ndarray:
    """Unknowns of Williams' displacement with given K, 2 G u = sqrt(r / 2 pi) times sums of the four tip functions."""
    cover, k = sample.cover, KOLOSOV[plane]
    along = K_I * np.array([k - 0.5, 0.0, -0.5, 0.0]) + K_II * np.array([0.0, k + 1.5, 0.0, 0.5])
    across = K_I * np.array([0.0, k + 0.5, 0.0, -0.5]) + K_II * np.array([1.5 - k, 0.0, -0.5, 0.0])
    factor = np.sqrt(sample.lattice.spacing / (2.0 * np.pi)) / (2.0 * SHEAR_MODULUS)
    coefficients = factor * exact_fields.PAPER.T @ np.stack([along, across], axis=1) @ cover.tips[0].rotation
    u = np.zeros((cover.n_functions, 2))
    for number in cover.tips[0].functions:
        u[number : number + 4] = coefficients
    return u.ravel()


@pytest.mark.parametrize(("plane", "spacing"), [("strain", 1.0), ("stress", 1.0), ("strain", 0.02)])
@pytest.mark.parametrize(("angle", "at_end"), [(0.0, True), (0.0, False), (23.0, True), (-31.0, False)])
@pytest.mark.parametrize(("K_I", "K_II"), [(1.0, 0.0), (0.0, 1.0), (0.7, -0.4)])
def test_rays_mean_and_faces_of_the_near_field(
    build, K_I: float, K_II: float, angle: float, at_end: bool, plane: str, spacing: float
) -> None:
    """On a ray the weight is area / distance: the mean of r^-1/2 is 2 R^-1/2. The faces open by sqrt(r) exactly."""
    sample = stub(build, angle, at_end, spacing)
    material, u = plane_elasticity(1.0, POISSON, plane), near_field(sample, K_I, K_II, plane)
    means = []
    for radius in (0.2 * spacing, 0.05 * spacing):
        (field,) = fields_of(
            sample.cover, [material], u, stress_functionals(sample.cover, at_tips(sample.cover), radius)
        )
        assert field.direction == pytest.approx(np.deg2rad(angle), abs=1e-8)
        np.testing.assert_allclose(np.diff(field.angles), 2.0 * np.pi / N_RAYS, rtol=1e-12)
        assert np.abs(field.angles).max() == pytest.approx(np.pi * (1.0 - 1.0 / N_RAYS))  # none on the crack
        root = np.sqrt(2.0 * np.pi * radius)
        expected = 2.0 * exact_fields.near_field(field.angles, K_I, K_II)
        np.testing.assert_allclose(root * exact_fields.turned(field.rays, -field.direction), expected, atol=2e-6)
        means.append(root * exact_fields.turned(field.mean[None], -field.direction)[0])
        assert tuple(means[-1][1:]) == pytest.approx((1.5279 * K_I, 1.0186 * K_II), abs=2 * RAYS)
    np.testing.assert_allclose(*means, atol=1e-6)
    found = from_face_displacements(sample.cover, [material], u, [0])[0]
    assert found == pytest.approx((K_I, K_II), abs=1e-6)


def test_rays_are_blind_behind_any_of_many_cracks(build) -> None:
    """Of uniform stress a tip's rays see the part up to what they meet, others its root; discs end on rims alone."""
    sample = build.field_of_cracks(3)
    cover = sample.cover
    u = np.zeros((cover.n_functions, 2))
    u[: len(cover.patches.nodes), 0] = sample.lattice.to_metres(cover.patches.nodes)[:, 0]
    xx, yy, _ = sample.material.matrix @ (1.0, 0.0, 0.0)
    radius, hidden = 3.0, 0
    rim, paths = sample.region.boundary, shapely.MultiLineString([crack.points for crack in cover.cracks])

    def part(start: np.ndarray, angle: float, line: shapely.Geometry) -> float:
        """The part of a ray up to where it first meets a line."""
        end = start + radius * np.array([np.cos(angle), np.sin(angle)])
        met = shapely.intersection(shapely.LineString([start + 1e-5 * (end - start), end]), line)
        return 1.0 if met.is_empty else float(shapely.Point(start).distance(met)) / radius

    tips = at_tips(cover)
    sites = [*tips, *(replace(tip, kind="crack") for tip in tips)]
    readings = stress_functionals(cover, sites, radius)
    fields = fields_of(cover, [sample.material], u.ravel(), readings)
    for site, field, points in zip(sites, fields, (reading.points for reading in readings), strict=True):
        toward = field.direction + field.angles
        whole, sight = ([part(site.point, angle, line) for angle in toward] for line in (rim, rim.union(paths)))
        np.testing.assert_allclose(field.mean, [xx, yy, 0.0], atol=1e-9)
        hidden += np.count_nonzero(np.less(sight, np.subtract(whole, 1e-9)))
        np.testing.assert_allclose(
            field.rays, np.outer(sight if site.kind == "tip" else np.sqrt(sight), [xx, yy, 0.0]), atol=1e-9
        )
        r = np.hypot(*(points.places - site.point).T) / radius
        for power in (0, 1, 2):  # what is behind a crack is known as exactly
            moments = np.bincount(points.ray, points.weight * r**power, N_RAYS)
            np.testing.assert_allclose(moments, np.power(whole, power + 1) / (power + 1), atol=1e-9)
    assert hidden > 40
