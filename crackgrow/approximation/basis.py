"""The basis at points of elements, and what is made of it: sparse rows, derivatives by function, and fields.

    u(x) = sum_i phi_i(x) u_i + sum_tk F_tk(x) sum_c X_c(x) a_ctk,    paper eqs. (2), (3),

over the physical patches i, and over the tips t that act on the element with their four functions F_tk. What carries
these, X_c = sum_i chi_i phi_i, is the function of a singular patch, as in the paper, or a sum over the patches round
the tip. So the basis at a point is kept as its factors: the phi_i, the X_c of each tip, and the F_tk.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from crackgrow.approximation.mls import mls
from crackgrow.approximation.tip_functions import tip_functions, tip_values
from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.enrichment import Enrichment
from crackgrow.cover.tips import N_TIP_FUNCTIONS, Tip, polar_beside, side_angle
from crackgrow.ragged import Ragged, numbered, spans, starts_of

AT_ONCE = 16_000
"""Pairs of a point and a patch taken together: more do not fit into a cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Derivatives:
    """Derivatives of some functions at n points: those at point i are the places start[i] to start[i + 1]."""

    functions: Ints  # (k,) ascending
    start: Ints  # (n + 1,)
    column: Ints  # (e,) place among the functions
    values: Floats  # (2, e) by x and by y, per metre

    def summed(self, weights: Floats) -> Floats:
        """Sums (k, q) over the points, and over both derivatives, times `weights` (2, n, q)."""
        shape = (len(self.start) - 1, len(self.functions))
        tables = (csr_array((values, self.column, self.start), shape=shape) for values in self.values)
        by_x, by_y = (table.T @ each for table, each in zip(tables, weights, strict=True))
        return np.asarray(by_x + by_y)


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """All functions at n points: their values and, if asked for, their derivatives by x and by y, per metre.

    The components of an array come first: one (the value) or three.
    """

    cover: Cover
    elements: Ints  # (n,) that the points belong to
    patches: Ragged  # points -> physical patches
    phi: Floats  # (components, patches of all points)
    pairs: Ragged  # points -> pairs of an element and a tip, numbers in the cover's enrichment
    first: Ragged  # pairs of all points -> the first of the four functions of each carrier
    carriers: Floats  # (components, carriers of all pairs)
    tip: Floats  # (components, pairs of all points, 4)

    def values(self) -> csr_array:
        """The values (n, n_functions)."""
        functions = self.cover.functions_on(self.elements)
        counts = np.stack([self.patches.counts, np.diff(self._tip_start)], axis=1).ravel()
        is_tip = np.repeat(np.arange(len(counts)) % 2 == 1, counts)
        found = np.empty(len(is_tip))
        found[~is_tip] = self.phi[0]
        found[is_tip] = self._carried([0], 0, self.pairs.values.size)[0]
        return csr_array((found, functions.values, functions.start), shape=(len(self.elements), self.cover.n_functions))

    def derivatives(self, at: slice) -> tuple[Derivatives, Derivatives]:
        """The derivatives of the functions of patches, and of those of tips, at the points `at`."""
        patches, pairs = self.patches.start[at.start : at.stop + 1], self.pairs.start[at.start : at.stop + 1]
        carriers, own = self.first.start[pairs], slice(patches[0], patches[-1])
        of_tips = self.first.values[carriers[0] : carriers[-1], None] + np.arange(N_TIP_FUNCTIONS)
        return (
            self._by_function(patches, self.patches.values[own], self.phi[1:, own]),
            self._by_function(N_TIP_FUNCTIONS * carriers, of_tips.ravel(), self._carried((1, 2), pairs[0], pairs[-1])),
        )

    def _by_function(self, start: Ints, functions: Ints, values: Floats) -> Derivatives:
        used, column = numbered(functions, self.cover.n_functions)
        return Derivatives(used, start - start[0], column, values)

    def of_alike(self, groups: Sequence[tuple[int, int]]) -> Iterator[Floats]:
        """The functions (components, e, k, n) of groups of e elements with n points each and equally many functions.

        Points follow each other element by element and group by group. Functions are as `Cover.functions_on` has them.
        """
        first = starts_of(np.array([e * n for e, n in groups], dtype=np.int64))
        parts = (self.phi, self._carried(range(len(self.phi)), 0, self.pairs.values.size))
        starts = (self.patches.start[first].tolist(), self._tip_start[first].tolist())
        for group, (e, n) in enumerate(groups):
            pieces = [part[:, start[group] : start[group + 1]] for part, start in zip(parts, starts, strict=True)]
            tables = [p.reshape(len(p), e, n, p.shape[1] // max(e * n, 1)) for p in pieces if p.size]
            yield (tables[0] if len(tables) == 1 else np.concatenate(tables, axis=3)).swapaxes(2, 3)

    def field(self, coefficients: Floats) -> Floats:
        """Fields (components, n, m) with `coefficients` (n_functions, m): the products with all rows at once.

        The factors are multiplied one after the other, which takes a fraction of the time.
        """
        n_patches, m = len(self.cover.patches.nodes), coefficients.shape[1]
        found = [_sums(phi, self.patches, coefficients[:n_patches]) for phi in self.phi]
        if len(self.first.values):
            amplitudes = coefficients[n_patches:].reshape(-1, N_TIP_FUNCTIONS * m)
            number = Ragged(self.first.start, (self.first.values - n_patches) // N_TIP_FUNCTIONS)
            by_tip = [_sums(carrier, number, amplitudes).reshape(-1, m) for carrier in self.carriers]
            start = N_TIP_FUNCTIONS * self.pairs.start
            columns = Ragged(start, np.arange(start[-1]))
            tip = self.tip.reshape(len(self.tip), -1)
            for component, total in enumerate(found):
                total += _sums(tip[component], columns, by_tip[0])
                if component > 0:
                    total += _sums(tip[0], columns, by_tip[component])
        return np.stack(found)

    @property
    def _tip_start(self) -> Ints:
        """Where the tip functions of each point begin (n + 1,), among those of all points."""
        return N_TIP_FUNCTIONS * self.first.start[self.pairs.start]

    def _carried(self, components: Sequence[int], begin: int, end: int) -> Floats:
        """The products X_c F_tk (components, tip functions), or derivatives, of the pairs from `begin` to `end`."""
        first, last = self.first.start[[begin, end]]
        w, f = self.carriers[:, first:last, None], self.tip[:, begin:end].repeat(self.first.counts[begin:end], axis=1)
        found = np.empty((len(components), *f.shape[1:]))
        for component, product in zip(components, found, strict=True):
            np.multiply(w[component], f[0], out=product)
            if component:
                product += w[0] * f[component]
        return found.reshape(len(found), -1)


def basis_at(cover: Cover, points: Floats, elements: Ints) -> Basis:
    """Values and gradients at points (n, 2), in lattice coordinates, each inside or on the rim of its element (n,)."""
    return _basis(cover, points, elements, derivatives=True)


def values_at(cover: Cover, points: Floats, elements: Ints) -> Basis:
    """The values of `basis_at` alone, at a third of the cost."""
    return _basis(cover, points, elements, derivatives=False)


def of_component(rows: csr_array, component: int) -> csr_array:
    """Rows (m, n_dofs) that give of one displacement component what `rows` (m, n_functions) give of a scalar field."""
    m, n = rows.shape
    return csr_array((rows.data, 2 * rows.indices + component, rows.indptr), shape=(m, 2 * n))


def _basis(cover: Cover, points: Floats, elements: Ints, derivatives: bool) -> Basis:
    patches, phi = _of_patches(cover, points, elements, derivatives)
    enrichment = cover.enrichment
    point, pair = enrichment.tips.places(elements)
    pairs, first = Ragged(starts_of(enrichment.tips.counts[elements]), pair), enrichment.first.taken(pair)
    tip = np.empty((len(phi), len(pair), N_TIP_FUNCTIONS))
    for of_tip, rows, r, t in _polar(cover, points, elements, point, pair):
        if derivatives:
            value, gradient = tip_functions(of_tip, r, t)
            tip[0, rows], tip[1:, rows] = value, gradient.transpose(2, 0, 1) / cover.lattice.spacing
        else:
            tip[0, rows] = tip_values(of_tip, r, t)
    return Basis(cover, elements, patches, phi, pairs, first, _carriers(phi, patches, enrichment, elements), tip)


def _carriers(phi: Floats, patches: Ragged, enrichment: Enrichment, elements: Ints) -> Floats:
    """The carriers (components, q) at points of `elements` (n,), of the functions `phi` of their `patches`."""
    of_element = enrichment.first.start[enrichment.tips.start]
    carriers = spans(of_element[elements], np.diff(of_element)[elements])
    entries = enrichment.place.start[of_element]
    counts = np.diff(entries)[elements]
    entry = spans(entries[elements], counts)
    terms = phi.take(patches.start[:-1].repeat(counts) + enrichment.place.values[entry], axis=1)
    terms *= enrichment.share[entry]
    if len(entry) == len(carriers):  # each is one patch
        return terms
    return np.add.reduceat(terms, starts_of(enrichment.place.counts[carriers])[:-1], axis=1)


def _of_patches(cover: Cover, points: Floats, elements: Ints, derivatives: bool) -> tuple[Ragged, Floats]:
    """The physical patches of points, and the functions phi_i of all of them, (components, patches)."""
    patches = cover.patches.of_element.taken(elements)
    nodes, half = np.ascontiguousarray(cover.patches.nodes.T), cover.patches.weight_half
    found = np.empty((3 if derivatives else 1, len(patches.values)))
    begin = 0
    while begin < len(points):
        last = int(np.searchsorted(patches.start, patches.start[begin] + AT_ONCE, side="right")) - 1
        end = max(begin + 1, last)
        start = patches.start[begin : end + 1]
        own = slice(start[0], start[-1])
        distance = nodes.take(patches.values[own], axis=1)
        distance -= points[begin:end].T.repeat(np.diff(start), axis=1)
        found[:, own] = mls(distance, half.take(patches.values[own]), start - start[0], derivatives)
        begin = end
    found[1:] /= cover.lattice.spacing
    return patches, found


def _polar(
    cover: Cover, points: Floats, elements: Ints, point: Ints, pair: Ints
) -> Iterator[tuple[Tip, Ints, Floats, Floats]]:
    """Tip by tip: which pairs of a point and a tip are its own, and the polar coordinates round it of their points."""
    tips = cover.enrichment.tips.values[pair]
    order = np.argsort(tips, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(tips[order])) + 1) if len(pair) else ():
        tip, at = cover.tips[tips[rows[0]]], point[rows]
        element = elements[at]
        first = np.append(True, element[1:] != element[:-1])  # points of an element mostly follow each other
        side = side_angle(tip, cover.elements.reference[element[first]])
        yield tip, rows, *polar_beside(tip, points[at], side[np.cumsum(first) - 1])


def _sums(weights: Floats, columns: Ragged, values: Floats) -> Floats:
    """Sums (n, m) of `values` (k, m) over the columns of each row, times their `weights`."""
    return np.asarray(csr_array((weights, columns.values, columns.start), shape=(columns.n, len(values))) @ values)
