"""Plane elasticity and the stiffness: symmetry, zero-energy modes, energies of linear fields."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.cover.cover import build_cover
from crackgrow.cover.elements import locate
from crackgrow.cover.shapes import BodyGeometry
from crackgrow.solid.elasticity import energy_components, plane_elasticity, principal
from crackgrow.solid.recovery import displacement_at, stress_at
from crackgrow.solid.stiffness import stiffness
from tests.conftest import Sample

E, NU = 70e9, 0.3
KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]
THROUGH = [(0.5, 2.3), (3.2, 2.9), (6.5, 3.6)]
CRACKS = {
    "uncut": [],
    "crack": [(KINKED, (True, True))],
    "from a side": [([(0.5, 2.2), (3.1, 2.7)], (False, True))],
    "cut through": [(THROUGH, (False, False))],
}
GRADIENT = np.array([[1e-3, 3e-4], [-2e-4, 5e-4]])
STRAIN = np.array([1e-3, 5e-4, 1e-4])


def test_elasticity_inverts_the_flexibility_of_either_plane() -> None:
    strain, stress = (plane_elasticity(E, NU, plane) for plane in ("strain", "stress"))
    flexibility = np.array([[1, -NU, 0], [-NU, 1, 0], [0, 0, 2 * (1 + NU)]]) / E
    np.testing.assert_allclose(stress.matrix @ flexibility, np.eye(3), atol=1e-15)
    assert (stress.young_prime, stress.zz) == (E, 0.0)
    flexibility = (1 + NU) / E * np.array([[1 - NU, -NU, 0], [-NU, 1 - NU, 0], [0, 0, 2]])
    np.testing.assert_allclose(strain.matrix @ flexibility, np.eye(3), atol=1e-15)
    assert (strain.young_prime, strain.zz) == (pytest.approx(E / 0.91, rel=1e-15), NU)  # no strain along z
    assert strain.c11 - strain.c12 == pytest.approx(2 * strain.c33, rel=1e-14)


def test_principal_stresses_agree_with_eigenvalues_and_vectors() -> None:
    stress = np.concatenate([np.random.default_rng(30).normal(size=(200, 3)), [(3, 1, 0), (1, 3, 0), (0, 0, -2)]])
    s1, s3, angle = principal(stress)
    tensors = stress[:, [0, 2, 2, 1]].reshape(-1, 2, 2)
    np.testing.assert_allclose(np.stack([s3, s1], axis=1), np.linalg.eigvalsh(tensors), atol=1e-14)
    axis = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", tensors, axis), s1[:, None] * axis, atol=1e-14)
    assert np.all(np.abs(angle) <= 0.5 * np.pi)


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_energy_components_square_to_the_strain_energy(plane: str) -> None:
    material = plane_elasticity(3.0, 0.3, plane)
    stress = np.array([[1.0, 2.0, -0.5], [0.0, 0.0, 1.0]])
    body = np.zeros(2, dtype=np.int64)
    expected = np.einsum("ni,ij,nj->n", stress, np.linalg.inv(material.matrix), stress)
    np.testing.assert_allclose(np.sum(energy_components([material], stress, body) ** 2, axis=1), expected)


def linear(sample: Sample, gradient: np.ndarray) -> np.ndarray:
    """Unknowns (n_dofs,) of a displacement with this gradient du_c / dx_d, tip functions zero."""
    u = np.zeros((sample.cover.n_functions, 2))
    nodes = sample.lattice.to_metres(sample.cover.patches.nodes)
    u[: len(nodes)] = nodes @ gradient.T
    return u.ravel()


def check_energies(sample: Sample, matrix: np.ndarray, area: float) -> None:
    """Symmetric; rigid motions cost nothing, a linear field what it must: any rule that gives the area gives that."""
    size = np.abs(matrix.data).max()
    assert np.abs((matrix - matrix.T).data).max(initial=0.0) <= 1e-14 * size
    assert matrix.diagonal().min() > 0.0
    shifts = [np.zeros((sample.cover.n_functions, 2)) for _ in range(2)]
    for axis, shift in enumerate(shifts):
        shift[: len(sample.cover.patches.nodes), axis] = 1.0
    for u in (*map(np.ravel, shifts), linear(sample, np.array([[0.0, -1.0], [1.0, 0.0]]))):
        assert np.abs(matrix @ u).max() < 1e-12 * size * np.abs(u).max()
    u, exact = linear(sample, GRADIENT), area * STRAIN @ sample.material.matrix @ STRAIN
    assert u @ (matrix @ u) == pytest.approx(exact, rel=1e-9)  # the arrangement's grid


@pytest.mark.parametrize("spacing", [1.0, 1e-3])
@pytest.mark.parametrize("support", [1.5, 1.75, 2.0, 2.5])
@pytest.mark.parametrize("name", CRACKS)
def test_stiffness_has_the_energies_of_rigid_and_linear_fields(
    build, name: str, support: float, spacing: float
) -> None:
    """And no other fields without energy: three for each piece; the next eigenvalue is far above."""
    cracks = [build.crack(np.array(points) * spacing, tips) for points, tips in CRACKS[name]]
    corners = np.array([(0.5, 0.5), (6.5, 5.5)]) * spacing
    sample = build.sample(*corners, cracks, spacing=spacing, support=support)
    matrix = sample.stiffness()
    check_energies(sample, matrix, 30.0 * spacing**2)
    if support <= 2.0:
        dense = matrix.toarray()
        scale = 1 / np.sqrt(np.diag(dense))  # slivers then cost no energy that counts
        eigenvalues = np.linalg.eigvalsh(scale[:, None] * dense * scale)
        n_free = 6 if name == "cut through" else 3
        assert np.abs(eigenvalues[:n_free]).max() < 1e-12
        assert eigenvalues[n_free] > 1e-9  # 100 times the round-off of the others


@pytest.mark.physics
def test_more_than_64_tips_assemble(build) -> None:
    sample = build.field_of_cracks(6, 1.5)
    assert len(sample.cover.tips) == 72
    check_energies(sample, sample.stiffness(2), 25.0**2)


def test_two_materials_each_stiffen_their_own_body(build) -> None:
    lattice = build.block((6, 5)).lattice
    bodies = [np.array([[x, 2.5], [end, 2.5], [end, 7.5], [x, 7.5]]) for x, end in ((2.5, 4.5), (4.5, 8.5))]
    cover = build_cover(lattice, [BodyGeometry((outline,)) for outline in bodies], [])
    np.testing.assert_array_equal(cover.elements.body, (cover.elements.reference[:, 0] > 4.5).astype(int))
    soft, hard = (plane_elasticity(young, 0.25, "strain") for young in (1.0, 10.0))
    matrix = stiffness(cover, [soft, hard], 4)
    nodes = lattice.to_metres(cover.patches.nodes)
    u = np.stack([1e-3 * nodes[:, 0], 0 * nodes[:, 0]], axis=1).ravel()
    assert u @ (matrix @ u) == pytest.approx(1e-6 * (10.0 * soft.c11 + 20.0 * hard.c11), rel=1e-12)


@pytest.mark.parametrize("name", ["uncut", "crack"])
def test_linear_field_gives_its_displacement_and_uniform_stress_at_points(build, name: str) -> None:
    sample = build.block((6, 5), [build.crack(points) for points, _ in CRACKS[name]], 2.0)
    u, metres = linear(sample, GRADIENT), np.random.default_rng(31).uniform((0.5, 0.5), (6.5, 5.5), (100, 2))
    points = sample.lattice.to_lattice(metres)
    elements = locate(sample.lattice, sample.cover.elements, points)
    np.testing.assert_allclose(displacement_at(sample.cover, u, points, elements), metres @ GRADIENT.T, atol=1e-15)
    found = stress_at(sample.cover, [sample.material], u, points, elements)
    np.testing.assert_allclose(found, np.tile(sample.material.matrix @ STRAIN, (100, 1)), atol=1e-13)
