"""Cross products of vectors of the plane."""

from __future__ import annotations

import numpy as np

from crackgrow.vectors import cross


def test_the_cross_product_is_the_sine_of_the_turn_from_one_vector_to_the_other() -> None:
    start, turn = np.random.default_rng(3).uniform(-np.pi, np.pi, (2, 4, 5))
    a, b = (np.stack([np.cos(angle), np.sin(angle)], axis=-1) for angle in (start, start + turn))
    np.testing.assert_allclose(cross(2.0 * a, 3.0 * b), 6.0 * np.sin(turn), atol=1e-14)


def test_many_vectors_are_taken_with_one_each() -> None:
    a, b = np.array([[[1.0, 0.0], [0.0, 1.0]], [[2.0, 0.0], [0.0, 2.0]]]), np.array([[0.0, 3.0], [3.0, 0.0]])
    np.testing.assert_array_equal(cross(a, b), [[3.0, -3.0], [6.0, -6.0]])
