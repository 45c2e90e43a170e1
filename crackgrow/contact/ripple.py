"""Tractions that oscillate along a surface: contact points closer than the displacement can tell apart.

Where contact points are denser than the functions of the displacement, some tractions do next to no work on it. Stiff
contact leaves their size to round-off and to the smallest terms of the jump. They show as waves shorter than two
cells, the shortest that values one cell apart can carry; no wave of the rock's stress is that short.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.contact.faces import ContactFaces
from crackgrow.cover.cover import Cover

SHORTEST_WAVE: Final = 2.0
"""Cells: length of the shortest wave that they can carry."""


def worst_ripple(cover: Cover, faces: ContactFaces, normal: Floats, tangential: Floats) -> tuple[int, float] | None:
    """The surface with the largest short wave of tractions (contact points,) Pa, and its swing over the pressure.

    That is the mean pressure of the surface where it is pressed.
    """
    found: list[tuple[int, float]] = []
    for surface in np.unique(faces.surface).tolist():
        pressed = (faces.surface == surface) & (normal < 0.0)
        if not pressed.any():
            continue
        pressure = -float(np.average(normal[pressed], weights=faces.weights[pressed]))
        along = cover.surfaces[surface].in_cells
        for stretch in np.unique(faces.stretch[pressed]).tolist():
            mine = np.flatnonzero((faces.surface == surface) & (faces.stretch == stretch))
            mine = mine[np.argsort(faces.s[mine])]
            for traction in (normal, tangential):
                found.append((surface, ripple(along.at(faces.s[mine]), traction[mine]) / pressure))
    return max(found, key=lambda each: each[1], default=None)


def ripple(xi: Floats, p: Floats) -> float:
    """Largest swing of a traction p (n,) up, down and up again within short waves.

    `xi` (n,) are lengths along the surface in cells, increasing. The swing is the least of the three, so that neither a
    steep end, nor a step, nor a lone peak or trough is one; zero without such waves.
    """
    at = turning_points(p)
    swing = np.abs(np.diff(p[at]))
    short = xi[at[2:]] - xi[at[:-2]] < SHORTEST_WAVE
    if len(at) < 4:
        return 0.0
    least = np.where(short[:-1] & short[1:], np.minimum(np.minimum(swing[:-2], swing[1:-1]), swing[2:]), 0.0)
    return float(least.max())


def turning_points(p: Floats) -> Ints:
    """Indices (k,) of the first and the last value and of those in between where p (n,) turns round."""
    if len(p) == 0:
        return np.empty(0, dtype=np.int64)
    rises = np.diff(p)
    moving = np.flatnonzero(rises)
    turns = moving[1:][np.sign(rises[moving[1:]]) != np.sign(rises[moving[:-1]])]
    return np.concatenate([[0], turns, [len(p) - 1]]).astype(np.int64)
