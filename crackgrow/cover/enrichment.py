"""Where tips act: the tips whose functions each element carries, and the numbers of those functions.

A scene may have hundreds of tips, of which a place sees none, or a few. So these are lists of the pairs that exist, not
tables of all tips by all elements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools, Ints


def entries(start: Ints, rows: Ints) -> tuple[Ints, Ints]:
    """All entries of `rows` (m,) in lists of which list i has the entries start[i] to start[i + 1].

    Returns which of the rows (q,), ascending, and the number of the entry (q,).
    """
    n = start[rows + 1] - start[rows]
    which = np.repeat(np.arange(len(rows)), n)
    return which, np.arange(len(which)) + np.repeat(start[rows] - np.cumsum(n) + n, n)


def list_starts(owner: Ints, n: int) -> Ints:
    """Starts (n + 1,) of the lists of n owners in `owner` (p,), ascending."""
    return np.searchsorted(owner, np.arange(n + 1))


@dataclass(frozen=True, slots=True, eq=False)
class TipsOf:
    """The tips that act on each of n things, elements or edges: on thing i, `tip[start[i] : start[i + 1]]`."""

    start: Ints  # (n + 1,)
    tip: Ints  # (p,)

    @property
    def any(self) -> Bools:
        """Which of the things (n,) a tip acts on."""
        return np.asarray(np.diff(self.start) > 0)

    def of(self, things: Ints) -> tuple[Ints, Ints]:
        """Pairs of one of `things` (m,) and a tip: which of them (q,), ascending, and number of the pair (q,)."""
        return entries(self.start, things)


@dataclass(frozen=True, slots=True, eq=False)
class Enrichment:
    """The tip functions on the elements: for each pair of an element and a tip, the singular patches over it.

    Those of pair p are the entries start[p] to start[p + 1]; all of an element follow each other.
    """

    tips: TipsOf  # element by element
    start: Ints  # (pairs + 1,)
    slot: Ints  # (s,) place of the singular patch in the element's window
    number: Ints  # (s,) first of its four functions of this tip

    @property
    def n_patches(self) -> Ints:
        """Number (elements,) of pairs of a tip and a singular patch on each element."""
        return np.diff(self.start[self.tips.start])


def enrichment_of(functions: Ints, tip_function_ids: Sequence[Ints]) -> Enrichment:
    """The enrichment of elements with patches `functions` (n, window), from the numbers (n_patches,) of each tip."""
    n_elements, n_tips = len(functions), len(tip_function_ids)
    singular = [np.flatnonzero(first >= 0) for first in tip_function_ids]
    patch = np.concatenate([np.empty(0, dtype=np.int64), *singular])
    tip = np.repeat(np.arange(n_tips), [len(patches) for patches in singular])
    order = np.argsort(patch, kind="stable")
    patch, tip = patch[order], tip[order]
    number = np.array(
        [tip_function_ids[t][p] for t, p in zip(tip.tolist(), patch.tolist(), strict=True)], dtype=np.int64
    )

    acted_on = np.zeros(int(functions.max(initial=-1)) + 2, dtype=bool)  # the last entry serves the index -1
    acted_on[patch] = True
    element, slot = np.nonzero(acted_on[functions])
    seen = functions[element, slot]
    which, entry = entries(list_starts(patch, int(seen.max(initial=-1)) + 1), seen)
    element, slot, tip, number = element[which], slot[which], tip[entry], number[entry]
    order = np.lexsort((tip, element))
    pair, start = np.unique((element * n_tips + tip)[order], return_index=True)
    pair_element, pair_tip = np.divmod(pair, max(n_tips, 1))
    return Enrichment(
        TipsOf(list_starts(pair_element, n_elements), pair_tip),
        np.append(start, len(order)),
        slot[order],
        number[order],
    )
