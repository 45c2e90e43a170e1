"""A field at points straight from its coefficients, without the table of all functions that `basis` makes.

On an element u = sum of phi_i (c_i + F_tk a_itk) over nodes i of the window, tips t and functions k. The coefficients
of the window are one small matrix, which the functions phi_i of all points on the element are multiplied by at once;
the tip functions come last, a few products a point.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from crackgrow.approximation.mls import mls, mls_values
from crackgrow.approximation.tip_functions import tip_functions, tip_values
from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.enrichment import entries
from crackgrow.cover.tips import N_TIP_FUNCTIONS, Tip, polar_beside, side_angle


def field_values(cover: Cover, coefficients: Floats, points: Floats, elements: Ints) -> Floats:
    """Values (n, m) of fields with `coefficients` (n_functions, m) at points (n, 2), each in its element (n,)."""
    tables = _tables(cover, coefficients, elements)
    phi = mls_values(points - _cells(cover, elements), cover.lattice.support, cover.lattice.reach)
    crumbs = np.flatnonzero(cover.crumbs.of_element[elements] >= 0)
    if len(crumbs):
        phi[crumbs, :3], _ = cover.crumbs.functions(points[crumbs], cover.crumbs.of_element[elements[crumbs]])
    (sums,) = _sums(tables, phi.T[None])
    found = sums[0]
    for tip, rows, columns, side in _near_tips(cover, tables):
        f = tip_values(tip, *polar_beside(tip, points[rows], side)).T
        found[:, rows] += np.sum(f[:, None] * sums[columns].take(rows, axis=2), axis=0)
    return np.asarray(found.T)


def field_gradients(cover: Cover, coefficients: Floats, points: Floats, elements: Ints) -> Floats:
    """Gradients (n, m, 2) per metre of fields as of `field_values`."""
    lattice, tables = cover.lattice, _tables(cover, coefficients, elements)
    phi, dphi = mls(points - _cells(cover, elements), lattice.support, lattice.reach)
    crumbs = np.flatnonzero(cover.crumbs.of_element[elements] >= 0)
    if len(crumbs):
        linear = cover.crumbs.functions(points[crumbs], cover.crumbs.of_element[elements[crumbs]])
        phi[crumbs, :3], dphi[crumbs, :3] = linear
    sums = _sums(tables, np.concatenate([phi.T[None], dphi.transpose(2, 1, 0)]))
    found = sums[1:, 0]
    for tip, rows, columns, side in _near_tips(cover, tables):
        f, df = tip_functions(tip, *polar_beside(tip, points[rows], side))
        value, by_x, by_y = sums[:, columns].take(rows, axis=3)
        for component, slope, along in zip(found, df.transpose(2, 1, 0), (by_x, by_y), strict=True):
            component[:, rows] += np.sum(f.T[:, None] * along + slope[:, None] * value, axis=0)
    return np.asarray(found.transpose(2, 1, 0) / lattice.spacing)


@dataclass(frozen=True, slots=True, eq=False)
class _Tables:
    """The coefficients on each of e elements, in columns: the lattice's own functions, then four for each tip."""

    elements: Ints  # (e,)
    of: Ints  # (n,) table of every point
    tips: Ints  # (e, t) tips that act on the element, -1 for none
    values: Floats  # (e, window, 1 + 4 t, m)


def _tables(cover: Cover, coefficients: Floats, elements: Ints) -> _Tables:
    distinct, of = np.unique(elements, return_inverse=True)
    enrichment = cover.enrichment
    which, pair = enrichment.tips.of(distinct)
    place = pair - enrichment.tips.start[distinct[which]]
    tips = np.full((len(distinct), int(place.max(initial=-1)) + 1), -1, dtype=np.int64)
    tips[which, place] = enrichment.tips.tip[pair]
    m = coefficients.shape[1]
    values = np.zeros((len(distinct), cover.lattice.window, 1 + N_TIP_FUNCTIONS * tips.shape[1], m))
    with_none = np.concatenate([coefficients, np.zeros((1, m))])  # the last entry serves the index -1
    values[:, :, 0] = with_none.take(cover.functions[distinct], axis=0)
    if len(pair):
        functions = np.arange(N_TIP_FUNCTIONS)
        pair_of_patch, entry = entries(enrichment.start, pair)
        column = 1 + N_TIP_FUNCTIONS * place[pair_of_patch, None] + functions
        window = enrichment.slot[entry, None]
        values[which[pair_of_patch, None], window, column] = coefficients[enrichment.number[entry, None] + functions]
    return _Tables(distinct, of, tips, values)


def _sums(tables: _Tables, functions: Floats) -> Floats:
    """Sums over the window (f, columns, m, n), for f sets of its functions (f, window, n) at the points.

    Points of an element are taken together, in batches of one size.
    """
    f, window, n = functions.shape
    n_elements, _, n_columns, m = tables.values.shape
    of, size = tables.of, -(-n // max(n_elements, 1)) or 1
    counts = np.bincount(of, minlength=n_elements)
    order = np.argsort(of, kind="stable")
    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n) - np.repeat(np.cumsum(counts) - counts, counts)
    n_batches = -(-counts // size)
    batch, lane = np.divmod(place, size)
    batch += (np.cumsum(n_batches) - n_batches)[of]
    filled = np.zeros((int(n_batches.sum()), size, f, window))
    filled[batch, lane] = functions.transpose(2, 0, 1)
    owner = np.repeat(np.arange(n_elements), n_batches)
    of_batch = tables.values.reshape(n_elements, window, n_columns * m)[owner]
    products = filled.reshape(len(filled), size * f, window) @ of_batch
    of_points = products.reshape(len(filled) * size, f * n_columns * m)[batch * size + lane]
    return np.ascontiguousarray(of_points.T).reshape(f, n_columns, m, n)


def _near_tips(cover: Cover, tables: _Tables) -> Iterator[tuple[Tip, Ints, slice, Floats]]:
    """Tip by tip: points (q,) on whose elements it acts, the columns of its functions, the points' sides (q,).

    A tip comes once for every place that its functions have among the columns.
    """
    for place, tips in enumerate(tables.tips.T):
        columns = slice(1 + N_TIP_FUNCTIONS * place, 1 + N_TIP_FUNCTIONS * (place + 1))
        of_points = tips[tables.of]
        for number in np.unique(tips[tips >= 0]).tolist():
            tip, rows = cover.tips[number], np.flatnonzero(of_points == number)
            sides = side_angle(tip, cover.elements.reference[tables.elements])
            yield tip, rows, columns, sides[tables.of[rows]]


def _cells(cover: Cover, elements: Ints) -> Ints:
    """Lower left nodes (n, 2) of the cells of elements (n,)."""
    return np.asarray(cover.elements.tile[elements] // (len(cover.lattice.breaks) - 1))
