"""Quadrature points of the whole body, element by element."""

from __future__ import annotations

import numpy as np

from crackgrow.cover.cover import Cover
from crackgrow.quadrature.elements import ElementPoints, element_points
from crackgrow.quadrature.plain_kinds import plain_kinds
from crackgrow.quadrature.rules import square


def all_points(cover: Cover, n: int) -> ElementPoints:
    """Points of all elements, plain ones included, in lattice coordinates; `n` Gauss points per direction."""
    cut = element_points(cover, n)
    points, weights, elements = [cut.points], [cut.weights], [cut.element]
    local, weight = square(n)
    for kind in plain_kinds(cover):
        cell, size = cover.elements.cell[kind.elements], cover.elements.size[kind.elements]
        points.append((cell[:, None] + (kind.low + local * kind.size) * size[:, None, None]).reshape(-1, 2))
        weights.append(np.outer(size**2, weight * kind.size.prod()).ravel())
        elements.append(np.repeat(kind.elements, len(weight)))
    return ElementPoints(np.concatenate(points), np.concatenate(weights), np.concatenate(elements))
