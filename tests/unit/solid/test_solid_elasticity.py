"""Constants of plane elasticity, principal stresses, stress and displacement at points."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.cover.elements import locate
from crackgrow.solid.elasticity import plane_elasticity, principal
from crackgrow.solid.recovery import displacement_at, stress_at

E, NU = 70e9, 0.3


def test_plane_stress_inverts_the_flexibility() -> None:
    material = plane_elasticity(E, NU, "stress")
    flexibility = np.array([[1, -NU, 0], [-NU, 1, 0], [0, 0, 2 * (1 + NU)]]) / E
    np.testing.assert_allclose(material.matrix @ flexibility, np.eye(3), atol=1e-15)
    assert material.young_prime == E
    assert material.zz == 0.0


def test_plane_strain_inverts_the_flexibility_without_thickness_strain() -> None:
    material = plane_elasticity(E, NU, "strain")
    flexibility = (1 + NU) / E * np.array([[1 - NU, -NU, 0], [-NU, 1 - NU, 0], [0, 0, 2]])
    np.testing.assert_allclose(material.matrix @ flexibility, np.eye(3), atol=1e-15)
    assert material.young_prime == pytest.approx(E / 0.91, rel=1e-15)
    stress = material.matrix @ np.array([1e-3, -4e-4, 2e-4])
    szz = material.zz * (stress[0] + stress[1])
    assert (szz - NU * (stress[0] + stress[1])) / E == pytest.approx(0.0, abs=1e-18)


def test_both_planes_agree_without_poisson_effect_and_share_the_shear_modulus() -> None:
    strain, stress = (plane_elasticity(E, 0.0, plane) for plane in ("strain", "stress"))
    np.testing.assert_allclose(strain.matrix, stress.matrix, rtol=1e-15)
    assert plane_elasticity(E, NU, "strain").c33 == plane_elasticity(E, NU, "stress").c33 == E / 2.6


def test_elasticity_does_not_depend_on_the_axes() -> None:
    material = plane_elasticity(E, NU, "strain")
    assert material.c11 - material.c12 == pytest.approx(2 * material.c33, rel=1e-14)


@pytest.mark.parametrize(
    ("stress", "expected"),
    [
        ((3.0, 1.0, 0.0), (3, 1, 0)),
        ((1.0, 3.0, 0.0), (3, 1, 90)),
        ((0.0, 0.0, 2.0), (2, -2, 45)),
        ((0.0, 0.0, -2.0), (2, -2, -45)),
        ((-5.0, 1.0, 4.0), (3, -7, np.degrees(0.5 * np.arctan2(4, -3)))),
    ],
)
def test_principal_stresses_of_known_states(stress: tuple, expected: tuple) -> None:
    s1, s3, angle = principal(np.array([stress]))
    np.testing.assert_allclose([s1[0], s3[0], np.degrees(angle[0])], expected, atol=1e-13)


def test_principal_stresses_agree_with_eigenvalues_and_vectors() -> None:
    stress = np.random.default_rng(30).normal(size=(200, 3))
    s1, s3, angle = principal(stress)
    tensors = stress[:, [0, 2, 2, 1]].reshape(-1, 2, 2)
    np.testing.assert_allclose(np.stack([s3, s1], axis=1), np.linalg.eigvalsh(tensors), atol=1e-14)
    axis = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", tensors, axis), s1[:, None] * axis, atol=1e-14)


@pytest.mark.parametrize("cracks", [[], [[(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]]])
def test_linear_field_gives_its_displacement_and_uniform_stress_at_points(build, cracks: list) -> None:
    sample = build.block((6, 5), [build.crack(points) for points in cracks], 2.0)
    gradient = np.array([[1e-3, 3e-4], [-2e-4, 5e-4]])  # du_c / dx_d
    u = np.zeros((sample.cover.n_functions, 2))
    nodes = sample.lattice.to_metres(sample.cover.patches.nodes)
    u[: len(nodes)] = nodes @ gradient.T
    metres = np.random.default_rng(31).uniform((0.5, 0.5), (6.5, 5.5), (100, 2))
    points = sample.lattice.to_lattice(metres)
    elements = locate(sample.lattice, sample.cover.elements, points)
    np.testing.assert_allclose(
        displacement_at(sample.cover, u.ravel(), points, elements), metres @ gradient.T, atol=1e-15
    )
    stress = sample.material.matrix @ (1e-3, 5e-4, 1e-4)
    found = stress_at(sample.cover, [sample.material], u.ravel(), points, elements)
    np.testing.assert_allclose(found, np.broadcast_to(stress, found.shape), atol=1e-13)
