"""What a cover lists, as tables of everything by everything: the plain form that tests compare with."""

from __future__ import annotations

import numpy as np

from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import Elements
from crackgrow.cover.lattice import Lattice


def patch_table(cover: Cover) -> np.ndarray:
    """Physical patch (elements, nodes) of every node round an element's cell, -1 for none; of no crumb."""
    of_element = cover.patches.of_element
    table = np.full((of_element.n, len(cover.lattice.offsets)), -1)
    table[of_element.row, cover.patches.slot] = of_element.values
    return table


def function_table(cover: Cover) -> np.ndarray:
    """First of the four functions of every tip on every patch (tips, n_patches), -1 for none."""
    table = np.full((len(cover.tips), len(cover.patch_nodes)), -1)
    for row, tip in zip(table, cover.tips, strict=True):
        row[tip.patches] = tip.functions
    return table


def tiles_of(lattice: Lattice, elements: Elements) -> np.ndarray:
    """Indices (n, 2) of the tile that each element lies in."""
    n_parts = len(lattice.breaks) - 1
    return elements.cell * n_parts + np.stack(np.divmod(elements.part, n_parts), axis=1)
