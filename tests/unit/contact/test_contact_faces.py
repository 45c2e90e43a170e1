"""Contact points along cracks: how many, where, their functions and weights, and which side is which."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.faces import (
    ContactFaces,
    FacePoints,
    gauss_faces,
    points_at,
    stretch_ends,
)
from crackgrow.contact.mortar import mortar_faces
from crackgrow.cover.elements import locate
from crackgrow.geometry.polyline import arc_lengths
from tests.solving import face_vertices

ROUND_OFF = 1e-8
"""In spacings: vertices lie on a grid of 1e-9 spacings, so that lengths are exact to a few of those."""

LENGTH = 10.0
KINKED = [(-4.3, -3.1), (-0.9, -2.2), (1.2, 1.9), (4.4, 2.6)]  # turns by 48 and 51 degrees
PATHS = {
    "straight": [(-4.13, -2.02), (4.53, 2.98)],
    "kinked": KINKED,
    "gentle": [(-4.3, -3.1), (-0.2, -1.7), (4.1, 0.9)],
    "along the lattice": [(-4.0, 0.5), (4.0, 0.5)],
}


def tilted(length: float, angle_deg: float) -> np.ndarray:
    a = np.deg2rad(angle_deg)
    half = 0.5 * length * np.array([np.cos(a), np.sin(a)])
    return np.array([-half, half])


def bent(first: float, second: float, kink_deg: float) -> np.ndarray:
    """Two segments of given lengths; the second is turned by `kink_deg` from the first."""
    a = np.deg2rad([10.0, 10.0 + kink_deg])
    corner = np.array([0.21, 0.33])
    return np.array(
        [
            corner - first * np.array([np.cos(a[0]), np.sin(a[0])]),
            corner,
            corner + second * np.array([np.cos(a[1]), np.sin(a[1])]),
        ]
    )


def plate(build, *paths, spacing: float = 1.0):
    cracks = [build.crack(path, name=str(k)) for k, path in enumerate(paths)]
    return build.sample((-15.5, -27.5), (15.5, 27.5), cracks, spacing=spacing, support=2.0)


def shape_sum(faces: ContactFaces) -> np.ndarray:
    return np.asarray(faces.functions.sum(axis=0)).ravel()


@pytest.mark.parametrize("discretize", [lambda cover: mortar_faces(cover, [0], 1.0), lambda c: gauss_faces(c, [0])])
@pytest.mark.parametrize("path", PATHS.values(), ids=PATHS.keys())
def test_functions_sum_to_one_and_weights_to_the_length(build, path, discretize) -> None:
    faces = discretize(plate(build, path).cover)
    np.testing.assert_allclose(shape_sum(faces), 1.0, rtol=1e-14)
    assert faces.functions.data.min() >= 0.0
    total = arc_lengths(np.array(path))[-1]
    assert faces.weights.sum() == pytest.approx(total, abs=ROUND_OFF)
    assert faces.lengths.sum() == pytest.approx(total, abs=ROUND_OFF)
    assert faces.weights.min() > 0.0


def test_weighted_points_integrate_along_the_crack(build) -> None:
    """Half powers of the distance from a tip, as openings have them, and polynomials."""
    faces = mortar_faces(plate(build, PATHS["straight"]).cover, [0], 0.8)
    s, total = faces.points.s, arc_lengths(np.array(PATHS["straight"]))[-1]
    for power in (0.5, 1.0, 1.5, 3.0, 4.0):
        # sqrt(distance) is integrated exactly in the piece at the tip, to 1e-9 by 5 points in the others
        assert faces.lengths @ s**power == pytest.approx(total ** (power + 1) / (power + 1), rel=1e-7)
        assert faces.lengths @ (total - s) ** power == pytest.approx(total ** (power + 1) / (power + 1), rel=1e-7)


def test_gauss_points_of_the_paper(build) -> None:
    faces = gauss_faces(plate(build, KINKED).cover, [0])
    assert faces.n == 3 * 10 * 5
    assert np.bincount(faces.stretch).tolist() == [50, 50, 50]
    assert np.all(np.diff(faces.s) > 0.0)
    corners = arc_lengths(np.array(KINKED))
    for k in range(3):
        mine = faces.stretch == k
        low, high = corners[k], corners[k + 1]
        limits = np.linspace(low, high, 11)
        assert np.histogram(faces.s[mine], limits)[0].tolist() == [5] * 10
        # five points a part are exact to degree 9
        assert faces.weights[mine] @ faces.s[mine] ** 9 == pytest.approx((high**10 - low**10) / 10, rel=1e-8)


@pytest.mark.parametrize("path", PATHS.values(), ids=PATHS.keys())
def test_plus_is_the_left_side_of_the_crack(build, path) -> None:
    cover = plate(build, path).cover
    points = mortar_faces(cover, [0], 1.0).points
    corners = arc_lengths(np.array(path))
    segment = np.searchsorted(corners, points.s) - 1
    steps = np.diff(np.array(path), axis=0)
    tangent = (steps / np.hypot(*steps.T)[:, None])[segment]
    turned = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    np.testing.assert_allclose(points.normal, turned, atol=ROUND_OFF)
    step = 1e-6  # spacings: far less than the distance of any point from the next edge
    assert np.array_equal(locate(cover.lattice, cover.elements, points.points + step * turned), points.plus)
    assert np.array_equal(locate(cover.lattice, cover.elements, points.points - step * turned), points.minus)
    assert np.all(points.plus != points.minus)


def on_polyline(path: np.ndarray, s: np.ndarray) -> np.ndarray:
    corners = arc_lengths(path)
    return np.stack([np.interp(s, corners, path[:, axis]) for axis in range(2)], axis=1)


@pytest.mark.parametrize("path", PATHS.values(), ids=PATHS.keys())
def test_face_vertices_cover_the_crack_from_start_to_end(build, path) -> None:
    sample = plate(build, path)
    vertices = face_vertices(sample.cover, 0)
    corners = arc_lengths(np.array(path))
    assert vertices.s[0] == pytest.approx(0.0, abs=ROUND_OFF)
    assert vertices.s[-1] == pytest.approx(corners[-1], abs=ROUND_OFF)
    np.testing.assert_allclose(vertices.s[1:-1:2], vertices.s[2::2], atol=ROUND_OFF)  # an edge starts where one ends
    assert np.all(vertices.s[1::2] > vertices.s[::2])
    assert np.abs(corners[:, None] - vertices.s).min(axis=1) == pytest.approx(0.0, abs=ROUND_OFF)
    places = sample.lattice.to_metres(vertices.points)
    np.testing.assert_allclose(places, on_polyline(np.array(path), vertices.s), atol=2 * ROUND_OFF)


def test_points_at_any_arc_length_lie_on_the_crack(build) -> None:
    sample = plate(build, KINKED)
    s = np.sort(np.random.default_rng(3).uniform(0.0, arc_lengths(np.array(KINKED))[-1], 200))
    points = points_at(sample.cover, 0, s)
    np.testing.assert_allclose(
        sample.lattice.to_metres(points.points), on_polyline(np.array(KINKED), s), atol=2 * ROUND_OFF
    )


def test_no_touching_crack_has_no_contact_points(build) -> None:
    cover = plate(build, tilted(LENGTH, 30.0)).cover
    for faces in (mortar_faces(cover, [], 1.0), gauss_faces(cover, [])):
        assert faces.n == 0
        assert isinstance(faces.points, FacePoints)
        assert len(faces.weights) == 0


@pytest.mark.parametrize(("length", "n_stretches"), [(0.12, 2), (0.08, 1), (1e-3, 1)])
def test_a_kink_just_behind_a_tip_ends_no_stretch(build, length: float, n_stretches: int) -> None:
    assert len(stretch_ends(plate(build, bent(5.0, length, 60.0)).cover, 0)) == n_stretches + 1


def test_of_close_kinks_the_sharpest_ends_the_stretches(build) -> None:
    directions = np.deg2rad([10.0, 25.0, 70.0, 90.0])  # kinks of 15, 45 and 20 degrees
    steps = np.array([4.0, 0.05, 0.05, 4.0])[:, None] * np.stack([np.cos(directions), np.sin(directions)], axis=1)
    path = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)]) - 0.5 * steps.sum(axis=0) + np.array([0.21, 0.33])
    assert stretch_ends(plate(build, path).cover, 0) == pytest.approx([0.0, 4.05, 8.1], abs=ROUND_OFF)
