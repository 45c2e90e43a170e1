"""Between the contact points of a surface: tractions are interpolated along each stretch, states are the nearest's."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from crackgrow.contact.faces import ContactFaces, stretch_ends
from crackgrow.cover.cover import Cover

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def between_contact_points(cover: Cover, faces: ContactFaces, surface: int, s: Floats, values: Floats) -> Floats:
    """Values (n,) at arc lengths s (n,) of a surface from those of all contact points (contact points,).

    Constant towards the ends of a stretch, zero on a surface without contact points.
    """
    found = np.zeros(len(s))
    for there, nodes in _stretches(cover, faces, surface, s):
        found[there] = np.interp(s[there], faces.s[nodes], values[nodes])
    return found


def nearest_contact_point(cover: Cover, faces: ContactFaces, surface: int, s: Floats) -> Ints:
    """Number (n,) of the contact point nearest to arc lengths s (n,) of a surface on the same stretch; -1 for none."""
    found = np.full(len(s), -1, dtype=np.int64)
    for there, nodes in _stretches(cover, faces, surface, s):
        found[there] = nodes[np.abs(s[there, None] - faces.s[nodes]).argmin(axis=1)]
    return found


def _stretches(cover: Cover, faces: ContactFaces, surface: int, s: Floats) -> Iterator[tuple[Ints, Ints]]:
    """Stretch by stretch: which of s (n,) lie on it, and the numbers of its contact points."""
    mine = np.flatnonzero(faces.surface == surface)
    if len(mine) == 0:
        return
    stretch = np.searchsorted(stretch_ends(cover.surfaces[surface].points)[1:-1], s, side="right")
    for number in np.unique(stretch):
        yield np.flatnonzero(stretch == number), mine[faces.stretch[mine] == number]
