"""Lattices with cells of several sizes at random places, and what is wanted of them in the plainest words."""

from __future__ import annotations

import numpy as np
import shapely

from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.cover.refinement import Focus, refined
from crackgrow.cover.squares import Squares

SIDES = 6.0
"""Of the box that the lattices here are placed round, spacings."""


def graded(seed: int, levels: int, support: float = 2.0, rings: float = 2.0) -> Lattice:
    """A lattice with two random places that ask for cells of 2^-levels, and one that asks for half as many levels."""
    lattice = place_lattice(np.zeros(2), np.full(2, SIDES), 1.0, support)
    places = lattice.to_lattice(np.random.default_rng(seed).uniform(0.0, SIDES, (3, 2)))
    return refined(lattice, Focus(shapely.points(places), 0.5 ** np.array([levels, levels, levels // 2]), rings))


def boxes(squares: Squares) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corners (n, 2) of squares, quanta."""
    return squares.low, squares.low + squares.size[:, None]
