"""The condition estimate against dense eigenvalues, and what it does not depend on."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.sparse import csc_array, csr_array, diags_array

from crackgrow.case.model import EdgeSupport
from crackgrow.errors import SolveError
from crackgrow.linear import ConstrainedSystem
from crackgrow.solid.supports import constraints
from tests.conftest import Build, Sample
from tests.stability.condition import condition_estimate


def held_sample(build: type[Build], support: float) -> tuple[Sample, csr_array]:
    sample = build.block((6, 5), [build.crack([[2.1, 3.2], [4.7, 3.9]])], support)
    held = constraints(sample.cover, (EdgeSupport(build.edge("bottom"), (0.0, 0.0)),))
    return sample, held.matrix


def dense_condition(stiffness: csc_array, rows: csr_array) -> float:
    """lambda_max(K^) / lambda_min(K^ on the null space of C D) by dense eigenvalues."""
    size = np.sqrt(stiffness.diagonal())
    scaled = stiffness.toarray() / np.outer(size, size)
    space = null_space(rows.toarray() / size) if rows.shape[0] else np.eye(len(size))
    return float(np.linalg.eigvalsh(scaled)[-1] / np.linalg.eigvalsh(space.T @ scaled @ space)[0])


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_estimate_is_that_of_dense_eigenvalues(build: type[Build], support: float) -> None:
    sample, rows = held_sample(build, support)
    system = ConstrainedSystem(sample.stiffness(), rows)
    assert condition_estimate(system) == pytest.approx(dense_condition(system.stiffness.tocsc(), rows), rel=0.05)


def test_estimate_depends_neither_on_units_nor_on_the_size_of_single_unknowns(build: type[Build]) -> None:
    sample, rows = held_sample(build, 2.0)
    stiffness = sample.stiffness()
    plain = condition_estimate(ConstrainedSystem(stiffness, rows))
    scale = diags_array(10.0 ** np.random.default_rng(3).uniform(-4, 4, stiffness.shape[0]))
    unlike = ConstrainedSystem(csc_array(1e12 * scale @ stiffness @ scale), csr_array(rows @ scale))
    assert condition_estimate(unlike) == pytest.approx(plain, rel=0.05)


@pytest.mark.parametrize("n", [6, 40])
def test_estimate_of_a_known_spectrum(n: int) -> None:
    rotation = np.linalg.qr(np.random.default_rng(n).standard_normal((n, n)))[0]
    matrix = rotation @ np.diag(np.geomspace(1.0, 1e-6, n)) @ rotation.T
    system = ConstrainedSystem(csc_array(0.5 * (matrix + matrix.T)), csr_array((0, n)))
    assert condition_estimate(system) == pytest.approx(
        dense_condition(system.stiffness.tocsc(), system.constraints), rel=0.05
    )


def test_unknown_without_stiffness_is_refused() -> None:
    system = ConstrainedSystem(csc_array(np.diag([1.0, 0.0])), csr_array(np.array([[1.0, 1.0]])))
    with pytest.raises(SolveError, match="without stiffness"):
        condition_estimate(system)
