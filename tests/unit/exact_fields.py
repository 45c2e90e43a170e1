"""Bodies under the tractions of a known stress, and their errors; what a cover lists, as tables of all by all."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import shapely
from scipy.sparse import csr_array

from crackgrow.approximation.basis import at_point, values_at, workspace
from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.case.model import PointSupport
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import Elements
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.squares import QUANTA
from crackgrow.quadrature.elements import element_points
from crackgrow.quadrature.rims import points_on_outlines
from crackgrow.solid.elasticity import energy_components
from crackgrow.solid.recovery import stress_at
from tests.conftest import Sample

Field = Callable[[Floats], Floats]
"""Stress (n, 3): xx, yy, xy at points (n, 2) in metres."""

PAPER = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [1, 0, 0, 4], [0, -1, 4, 0]])
"""What sqrt(r) {cos t/2, sin t/2, cos 3t/2, sin 3t/2} are of the four tip functions in isotropic rock."""


def solved_under(sample: Sample, field: Field) -> Floats:
    """Displacement unknowns under the tractions of a field on the outline, which balance each other."""
    cover, outlines = sample.cover, sample.cover.elements.outlines
    edge, points, length = points_on_outlines(cover, outlines.points, outlines.element, outlines.edge)
    step = outlines.points[:, 1] - outlines.points[:, 0]
    outward = (np.stack([step[:, 1], -step[:, 0]], axis=1) / np.hypot(*step.T)[:, None])[edge]
    xx, yy, xy = field(sample.lattice.to_metres(points)).T
    traction = np.stack([xx * outward[:, 0] + xy * outward[:, 1], xy * outward[:, 0] + yy * outward[:, 1]], axis=1)
    values = values_at(cover, points, outlines.element[edge])
    loads = values.T @ (length[:, None] * sample.lattice.spacing * traction)
    corners = sample.body.outline
    held = (PointSupport("rock", corners[0], (0.0, 0.0)), PointSupport("rock", corners[1], (None, 0.0)))
    system, given = sample.system(held)
    return system.solve(loads.ravel(), given)[0]


def near_field(t: Floats, K_I: float, K_II: float) -> Floats:
    """sqrt(2 pi r) times the stress (n, 3) round the tip of a crack (Williams) at angles t (n,), in the tip's axes."""
    c, s, c3, s3 = np.cos(t / 2), np.sin(t / 2), np.cos(3 * t / 2), np.sin(3 * t / 2)
    first = np.stack([c * (1 - s * s3), c * (1 + s * s3), c * s * c3], axis=1)
    second = np.stack([-s * (2 + c * c3), s * c * c3, c * (1 - s * s3)], axis=1)
    return K_I * first + K_II * second


def turned(stress: Floats, angle: float) -> Floats:
    """Stress (n, 3) turned by an angle (rad), counter-clockwise."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s], [s, c]])
    tensors = R @ stress[:, [0, 2, 2, 1]].reshape(-1, 2, 2) @ R.T
    return np.stack([tensors[:, 0, 0], tensors[:, 1, 1], tensors[:, 0, 1]], axis=1)


def true_error(sample: Sample, u: Floats, field: Field) -> float:
    """Energy norm of the difference to the field, percent of the field's."""
    found = element_points(sample.cover, 4)
    exact = field(sample.lattice.to_metres(found.points))
    stress = stress_at(sample.cover, [sample.material], u, found.points, found.element)
    body = np.zeros(len(exact), dtype=np.int64)
    squares = [found.weights @ energy_components([sample.material], s, body) ** 2 for s in (stress - exact, exact)]
    return float(100.0 * np.sqrt(squares[0].sum() / squares[1].sum()))


def patch_table(cover: Cover) -> np.ndarray:
    """Physical patch (elements, nodes) of every node round an element's cell, -1 for none; of cells of one size."""
    of_element, reach = cover.patches.of_element, math.ceil(cover.lattice.support)
    step = (cover.patches.nodes[of_element.values] - cells_of(cover)[of_element.row]).astype(int) + reach - 1
    table = np.full((of_element.n, (2 * reach) ** 2), -1)
    table[of_element.row, 2 * reach * step[:, 0] + step[:, 1]] = of_element.values
    return table


def cells_of(cover: Cover) -> np.ndarray:
    """Lower left corners (elements, 2) of the cells that elements lie in, spacings."""
    return cover.lattice.cells.low[cover.lattice.tiles.cell[cover.elements.tile]] / QUANTA


def function_table(cover: Cover) -> np.ndarray:
    """First of the four functions of every tip on every patch (tips, n_patches), -1 for none."""
    table = np.full((len(cover.tips), len(cover.patches.nodes)), -1)
    for row, tip in zip(table, cover.tips, strict=True):
        row[tip.patches] = tip.functions
    return table


def tile_boxes(lattice: Lattice, tiles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corners (n, 2) of tiles (n,)."""
    low = lattice.tile_low[tiles]
    return low, low + lattice.tile_size[tiles, None]


def areas(lattice: Lattice, elements: Elements) -> np.ndarray:
    """Areas (n,) of all elements, squared spacings."""
    whole = lattice.tile_size[elements.tile[: elements.n_whole]] ** 2
    return np.concatenate([whole, shapely.area(elements.polygons)])


def gradient_rows(cover: Cover, points: Floats, elements: Ints) -> tuple[csr_array, csr_array]:
    """The derivatives (n, n_functions) by x and by y, per spacing, of all functions at points; zeros stay entries."""
    work, k, on = workspace(cover.arrays), 0, cover.functions.taken(elements)
    values = np.empty((2, len(on.values)))
    for i, (first, last) in enumerate(pairwise(on.start.tolist())):
        k = at_point(i, points, elements, True, k, cover.arrays, work)
        values[:, first:last] = work[4][1:, : last - first]
    by_x, by_y = (csr_array((each, on.values, on.start), shape=(on.n, cover.n_functions)) for each in values)
    return by_x, by_y


def on_their_sides(elements: Elements, line: int) -> Bools:
    """Whether the plus element lies just left of each edge's middle, and the minus element just right: (2, n)."""
    edges = elements.lines[line]
    start, along = edges.points[:, 0], edges.points[:, 1] - edges.points[:, 0]
    length = np.hypot(*along.T)
    left = np.stack([-along[:, 1], along[:, 0]], axis=1) / length[:, None]
    height = 1e-10  # thinner than the thinnest sliver, one step of the grid
    inside = []
    for side, sign in ((edges.plus, 1.0), (edges.minus, -1.0)):
        middle = start + 0.5 * along + sign * height * left
        polygons = elements.polygons[side - elements.n_whole]
        inside.append(shapely.distance(polygons, shapely.points(middle)) == 0.0)
    return np.stack(inside)
