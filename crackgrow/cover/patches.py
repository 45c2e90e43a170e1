"""Physical patches: the connected pieces into which cracks and outlines cut the mathematical patches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crackgrow.cover.elements import Elements
from crackgrow.cover.lattice import Lattice
from crackgrow.geometry.arrangement import connected

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


def covering_nodes(lattice: Lattice, elements: Elements) -> tuple[Ints, Bools]:
    """Nodes of each element's window (n, window, 2), and which of them cover the element (n, window)."""
    per_cell = len(lattice.breaks) - 1
    cell, part = np.divmod(elements.tile, per_cell)
    nodes = cell[:, None, :] + lattice.offsets[None]
    middle = 0.5 * (lattice.breaks[1:] + lattice.breaks[:-1])[part]
    distance = np.abs(lattice.offsets[None] - middle[:, None, :])
    return nodes, np.all(distance < lattice.support, axis=2)


def physical_patches(lattice: Lattice, elements: Elements) -> tuple[Ints, Ints]:
    """Physical patch of every node of an element's window (n, window), -1 where none; node of every patch (p, 2).

    Two elements of one mathematical patch belong to the same physical patch if a way inside the patch leads from one
    to the other without crossing a crack or leaving the body.
    """
    nodes, covers = covering_nodes(lattice, elements)
    window = lattice.window
    passable = elements.passable
    first, second = elements.edges.left[passable], elements.edges.right[passable]

    shift = nodes[first, 0] - nodes[second, 0]  # of the first node of the two windows
    side = 2 * lattice.reach
    slot_in_second = (lattice.offsets - lattice.offsets[0])[None] + shift[:, None, :]
    in_window = np.all((slot_in_second >= 0) & (slot_in_second < side), axis=2)
    slot = np.where(in_window, slot_in_second[..., 0] * side + slot_in_second[..., 1], 0)
    joined = in_window & covers[first] & covers[second[:, None], slot]
    rows = (first[:, None] * window + np.arange(window))[joined]
    columns = (second[:, None] * window + slot)[joined]
    label = connected(elements.n * window, rows, columns).reshape(elements.n, window)

    used, representative, number = np.unique(label[covers], return_index=True, return_inverse=True)
    patch = np.full((elements.n, window), -1, dtype=np.int64)
    patch[covers] = number
    patch_nodes = nodes[covers][representative]
    order = np.lexsort((patch_nodes[:, 1], patch_nodes[:, 0]))  # numbered along the lattice
    rank = np.empty(len(used), dtype=np.int64)
    rank[order] = np.arange(len(used))
    patch[covers] = rank[patch[covers]]
    return patch, patch_nodes[order]
