"""The stiffness matrix: symmetry, zero-energy modes, the energy of linear fields."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.solid.elasticity import plane_elasticity
from crackgrow.solid.halves import half, sum_of
from crackgrow.solid.stiffness import element_matrix, stiffness

KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]
THROUGH = [(0.5, 2.3), (3.2, 2.9), (6.5, 3.6)]
CRACKS = {
    "uncut": [],
    "crack": [(KINKED, (True, True))],
    "from a side": [([(0.5, 2.2), (3.1, 2.7)], (False, True))],
}


def cracked(build, name: str, support: float, spacing: float = 1.0):
    cracks = [build.crack(np.array(points) * spacing, tips) for points, tips in CRACKS[name]]
    return build.sample((0.5 * spacing,) * 2, (6.5 * spacing, 5.5 * spacing), cracks, spacing=spacing, support=support)


def scaled(matrix) -> np.ndarray:
    """Dense, with a unit diagonal: slivers then cost no energy that counts."""
    dense = matrix.toarray()
    scale = 1 / np.sqrt(np.diag(dense))
    return scale[:, None] * dense * scale


def field(sample, values) -> np.ndarray:
    """Unknowns (n_dofs,) of a displacement that is linear in metres, tip functions zero."""
    u = np.zeros((sample.cover.n_functions, 2))
    nodes = sample.lattice.to_metres(sample.cover.patches.nodes)
    u[: len(nodes)] = values(nodes[:, 0], nodes[:, 1])
    return u.ravel()


RIGID = (
    lambda x, y: np.stack([np.ones_like(x), 0 * y], axis=1),
    lambda x, y: np.stack([0 * x, np.ones_like(y)], axis=1),
    lambda x, y: np.stack([-y, x], axis=1),
)


@pytest.mark.parametrize("support", [1.5, 2.0, 2.5])
@pytest.mark.parametrize("name", CRACKS)
def test_stiffness_is_symmetric_with_a_positive_diagonal(build, name: str, support: float) -> None:
    matrix = cracked(build, name, support).stiffness()
    size = np.abs(matrix.data).max()
    assert np.abs((matrix - matrix.T).data).max(initial=0.0) <= 1e-14 * size
    assert matrix.diagonal().min() > 0.0


@pytest.mark.parametrize("support", [1.5, 2.0])
@pytest.mark.parametrize("name", CRACKS)
def test_rigid_motions_and_no_others_have_zero_energy(build, name: str, support: float) -> None:
    """Three zero eigenvalues; the next is far above them."""
    sample = cracked(build, name, support)
    matrix = sample.stiffness()
    for motion in RIGID:
        u = field(sample, motion)
        assert np.abs(matrix @ u).max() < 1e-12 * np.abs(matrix.data).max() * np.abs(u).max()
    eigenvalues = np.linalg.eigvalsh(scaled(matrix))
    assert np.abs(eigenvalues[:3]).max() < 1e-12
    assert eigenvalues[3] > 1e-9  # 100 times the round-off of the three


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_a_body_cut_right_through_has_six_zero_energy_modes(build, support: float) -> None:
    sample = build.block((6, 5), [build.crack(THROUGH, (False, False))], support)
    eigenvalues = np.linalg.eigvalsh(scaled(sample.stiffness()))
    assert np.abs(eigenvalues[:6]).max() < 1e-12
    assert eigenvalues[6] > 1e-9


@pytest.mark.parametrize("support", [1.5, 1.75, 2.0, 2.5])
@pytest.mark.parametrize("name", CRACKS)
def test_energy_of_a_linear_field_is_exact(build, name: str, support: float) -> None:
    """Its strain is uniform: any rule that gives the area gives the energy."""
    sample = cracked(build, name, support)
    u = field(sample, lambda x, y: np.stack([1e-3 * x + 3e-4 * y, -2e-4 * x + 5e-4 * y], axis=1))
    strain = np.array([1e-3, 5e-4, 1e-4])
    exact = 30.0 * strain @ sample.material.matrix @ strain
    assert u @ (sample.stiffness() @ u) == pytest.approx(exact, rel=1e-9)  # the arrangement's grid


def test_plane_strain_stiffness_does_not_depend_on_the_spacings_unit(build) -> None:
    one, milli = (cracked(build, "uncut", 2.0, spacing).stiffness() for spacing in (1.0, 1e-3))
    assert np.abs((one - milli).data).max(initial=0.0) < 1e-12


def test_two_materials_each_stiffen_their_own_body(build) -> None:
    from crackgrow.cover.cover import build_cover
    from crackgrow.cover.shapes import BodyGeometry

    lattice = build.block((6, 5)).lattice
    bodies = [np.array([[x, 2.5], [x + 3, 2.5], [x + 3, 7.5], [x, 7.5]]) for x in (2.5, 5.5)]
    cover = build_cover(lattice, [BodyGeometry((outline,)) for outline in bodies], [])
    materials = [plane_elasticity(young, 0.25, "strain") for young in (1.0, 10.0)]
    matrix = stiffness(cover, materials, 4)
    nodes = lattice.to_metres(cover.patches.nodes)
    strain = np.array([1e-3, 0, 0])
    energy = sum(15.0 * strain @ material.matrix @ strain for material in materials)
    u = np.stack([1e-3 * nodes[:, 0], 0 * nodes[:, 0]], axis=1).ravel()
    assert u @ (matrix @ u) == pytest.approx(energy, rel=1e-12)


def test_element_matrix_is_the_integral_of_b_d_b() -> None:
    rng = np.random.default_rng(32)
    gradients, weights = rng.normal(size=(2, 4, 5)), rng.uniform(size=5)
    material = plane_elasticity(3.0, 0.2, "strain")
    expected = np.zeros((8, 8))
    for (by_x, by_y), weight in zip(gradients.transpose(2, 0, 1), weights, strict=True):
        B = np.zeros((3, 8))
        B[0, ::2], B[1, 1::2] = by_x, by_y
        B[2, ::2], B[2, 1::2] = by_y, by_x
        expected += weight * B.T @ material.matrix @ B
    np.testing.assert_allclose(element_matrix(material, gradients, weights).reshape(8, 8), expected, atol=1e-13)


def test_more_than_64_tips_assemble(build) -> None:
    """The matrix is symmetric, rigid motions cost nothing, a linear field costs what it must."""
    sample = build.field_of_cracks(6, 1.5)
    assert len(sample.cover.tips) == 72
    matrix = sample.stiffness(2)
    size = np.abs(matrix.data).max()
    assert np.abs((matrix - matrix.T).data).max(initial=0.0) <= 1e-14 * size
    assert matrix.diagonal().min() > 0.0
    for motion in RIGID:
        u = field(sample, motion)
        assert np.abs(matrix @ u).max() < 1e-12 * size * np.abs(u).max()
    u = field(sample, lambda x, y: np.stack([1e-3 * x + 3e-4 * y, -2e-4 * x + 5e-4 * y], axis=1))
    strain = np.array([1e-3, 5e-4, 1e-4])
    assert u @ (matrix @ u) == pytest.approx(25.0**2 * strain @ sample.material.matrix @ strain, rel=1e-9)


def test_sum_of_halves_is_that_of_dense_matrices() -> None:
    """Each stands at one or more places, in any order of its functions, and not all of these are coupled."""
    rng = np.random.default_rng(33)
    expected = np.zeros((9, 2, 9, 2))
    parts = []
    for k, n_places in ((3, 1), (1, 2), (5, 1), (4, 3)):
        coupled = rng.uniform(size=(k, k)) < 0.5
        coupled |= coupled.T | np.eye(k, dtype=bool)
        matrix = rng.normal(size=(2, 2, k, k)) * coupled
        matrix += matrix.transpose(1, 0, 3, 2)
        places = np.array([rng.permutation(9)[:k] for _ in range(n_places)])
        pairs = np.flatnonzero(np.triu(coupled))
        parts.append((places, half(k, pairs, matrix.reshape(2, 2, -1)[:, :, pairs])))
        for ids in places:
            expected[ids[:, None], :, ids[None], :] += matrix.transpose(2, 3, 0, 1)
    total = sum_of(parts, 9).tocsc()
    np.testing.assert_allclose(total.toarray(), expected.reshape(18, 18), atol=1e-15)
    assert abs(total - total.T).max() == 0.0


def test_sum_of_nothing_is_zero() -> None:
    nothing = sum_of([], 3).tocsc()
    assert nothing.shape == (6, 6)
    assert nothing.nnz == 0
