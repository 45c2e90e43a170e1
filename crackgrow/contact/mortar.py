"""Mortar nodes: contact points about a spacing apart, for averages over the faces weighted with hat functions."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.contact.faces import (
    ContactFaces,
    Part,
    integration_points,
    joined_faces,
    neighbours,
    stretch_ends,
)
from crackgrow.cover.cover import Cover
from crackgrow.geometry.polyline import arc_lengths

Floats = NDArray[np.float64]

TIE = 1e-6
"""A stretch that lacks this part of one more pair of pieces gets it all the same: rounding never decides."""

JOINT_PIECE = 0.5
"""Length of the constant piece at a junction over the distance of the nodes: there, unlike at a tip, the faces move."""


def mortar_faces(cover: Cover, touching: list[int], spacing: float) -> ContactFaces:
    """Mortar nodes at least `spacing` (lattice spacings) apart along each stretch of the surfaces `touching` (indices).

    One node lies on every end of the surface that lies on a rim, and one in the middle of each stretch between tips,
    sharp kinks and rims. There, and at junctions, the end pieces are constant: no node lies there. At junctions of
    cracks they are half as long.
    """
    ends = {surface: stretch_ends(cover.surfaces[surface]) for surface in touching}
    return joined_faces(
        cover, ends, [_mortar_on_surface(cover, surface, spacing, ends[surface]) for surface in touching]
    )


def _mortar_on_surface(cover: Cover, index: int, spacing: float, ends: Floats) -> Part:
    surface = cover.surfaces[index]
    on_rim = (
        not (surface.tip_at_start or surface.junctions[0]),
        not (surface.tip_at_end or surface.junctions[-1]),
    )
    at_junction = np.isin(ends, arc_lengths(surface.points)[surface.junctions]) & (index < len(cover.cracks))
    nodes, stretch = [], []
    for number, (start, end) in enumerate(pairwise(ends.tolist())):
        rim = (on_rim[0] and number == 0, on_rim[1] and number == len(ends) - 2)
        joint = at_junction[number : number + 2]
        if joint.any():
            free = np.where(rim, 0.0, np.where(joint, JOINT_PIECE, 1.0))  # end pieces over the distance of the nodes
            n_nodes = max(int((end - start) / spacing + TIE - free.sum()) + 1, 1)
            size = (end - start) / (n_nodes - 1 + free.sum())
            places = start + size * (free[0] + np.arange(n_nodes))
        else:
            n_pairs = int((end - start) / (2.0 * spacing) + TIE)  # never closer than `spacing`: see `numerics.contact`
            n_pieces = 2 * max(n_pairs, 1)  # even: one node in the middle
            first, last = (0 if rim[0] else 1), (n_pieces if rim[1] else n_pieces - 1)
            places = start + (end - start) * np.arange(first, last + 1) / n_pieces
        nodes.append(places)
        stretch.append(np.full(len(places), number))
    all_nodes, all_stretch = np.concatenate(nodes), np.concatenate(stretch)
    points, lengths = integration_points(cover, index, np.concatenate([ends[1:-1], all_nodes]))
    stretch_of_point = np.searchsorted(ends[1:-1], points.s, side="right")
    left, right, share = neighbours(all_nodes, all_stretch, points.s, stretch_of_point)
    there, between = np.arange(len(points.s)), share > 0.0
    rows, columns = np.concatenate([left, right[between]]), np.concatenate([there, there[between]])
    values = np.concatenate([1.0 - share, share[between]])
    functions = csr_array((values, (rows, columns)), shape=(len(all_nodes), len(points.s)))
    return points, lengths, functions, all_nodes, all_stretch
