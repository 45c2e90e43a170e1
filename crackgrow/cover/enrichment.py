"""Tips and where they act: the tips whose functions each element carries, and the numbers of those functions.

A scene may have hundreds of tips, of which a place sees none, or a few. So these are lists of the pairs that exist, not
tables of all tips by all elements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.elements import Elements
from crackgrow.cover.gathered import gathered, surroundings
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.patches import Patches
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.cover.tips import (
    N_TIP_FUNCTIONS,
    Carriers,
    Tip,
    carrying_nodes,
    largest_cells_at,
    reach_of_tips,
    seen_from_tip,
    side_angle,
)
from crackgrow.geometry.tolerance import TOUCH
from crackgrow.ragged import Ragged, by_row


@dataclass(frozen=True, slots=True, eq=False)
class Enrichment:
    """The tip functions on the elements: for each pair of an element and a tip, its carriers there.

    A carrier is what the four functions of a tip are multiplied by: a sum of functions phi_i of patches, times shares.
    All pairs of an element follow each other, and so do their carriers, and the patches of these.
    """

    tips: Ragged  # elements -> tips that act on them
    side: Floats  # (pairs,) angle of each element as its tip sees it: which side of the crack it is on
    first: Ragged  # pairs -> the first of the four functions of each carrier
    place: Ragged  # carriers of all pairs -> places of their patches among the patches of the element
    share: Floats  # (s,) of each of these, over the root of the side of the cells round the tip

    @property
    def acted_on(self) -> Bools:
        """Which elements (n,) a tip acts on."""
        return self.tips.counts > 0


def make_tips(
    lattice: Lattice, elements: Elements, cracks: Sequence[CrackGeometry], patches: Patches
) -> tuple[Tip, ...]:
    """The tips of all cracks, which are the first lines of the elements; their functions follow the patches."""
    n_functions = len(patches.nodes)
    tips: list[Tip] = []
    around = surroundings(elements) if any(crack.gathered for crack in cracks) else None
    places = [crack.seen_from(at_end)[0] for crack in cracks for at_end in crack.tips()]
    sizes = iter(largest_cells_at(lattice, np.array(places).reshape(-1, 2)).tolist())
    for index, crack in enumerate(cracks):
        for at_end in crack.tips():
            points, beside = crack.seen_from(at_end), elements.lines[index].beside(at_end)
            size = next(sizes)
            other_is_tip = crack.tip_at_start if at_end else crack.tip_at_end
            found = gathered(around, patches, index, points, size) if around and crack.gathered else None
            if found is None:
                reach = reach_of_tips(lattice.support) * size
                singular = _singular_patches(patches, beside, points[0])
                ends_inside = other_is_tip or _is_seen_beyond(lattice, elements, patches, singular, points, reach)
                view = seen_from_tip(points, reach, ends_inside)
                singular = singular[carrying_nodes(view, patches.nodes[singular], size)]
                found = view, Carriers(singular, np.ones(len(singular)), np.arange(len(singular)), reach)
            view, carriers = found
            body = int(elements.body[beside[0]])
            seen = (view.point, view.rotation, view.path, view.radii, view.fade)
            tips.append(Tip(*seen, index, at_end, points, other_is_tip, body, carriers, n_functions, size))
            n_functions += N_TIP_FUNCTIONS * carriers.n
    return tuple(tips)


def enrichment_of(patches: Ragged, tips: Sequence[Tip], reference: Floats) -> Enrichment:
    """The enrichment of elements with these physical patches and reference points (elements, 2).

    Tip functions are of the order sqrt(r): over the side of the cells round a tip they are as stiff as all others.
    """
    none = np.empty(0, dtype=np.int64)
    patch = np.concatenate([none, *(tip.patches for tip in tips)])
    first = np.concatenate([none, *(tip.functions for tip in tips)])
    share = np.concatenate([np.empty(0), *(tip.carriers.shares / np.sqrt(tip.size) for tip in tips)])
    tip = np.repeat(np.arange(len(tips)), [len(tip.patches) for tip in tips])
    carries = np.zeros(int(patches.values.max(initial=-1)) + 1, dtype=bool)
    carries[patch] = True
    at = np.flatnonzero(carries[patches.values])
    at = at[np.argsort(patches.values[at], kind="stable")]
    row, place = by_row(patches.values[at], at, len(carries)).places(patch)  # of the table: all that tips have part in
    at, first, share, tip = at[place], first[row], share[row], tip[row]
    element = np.searchsorted(patches.start, at, side="right") - 1
    order = np.lexsort((at, first, element))
    at, first, share, tip, element = at[order], first[order], share[order], tip[order], element[order]
    new_pair = _changes(element) | _changes(tip)
    pair, carrier = np.flatnonzero(new_pair), np.flatnonzero(new_pair | _changes(first))
    side = np.empty(len(pair))
    for number, seen in enumerate(tips):
        mine = np.flatnonzero(tip[pair] == number)
        side[mine] = side_angle(seen, reference[element[pair[mine]]])
    return Enrichment(
        by_row(element[pair], tip[pair], patches.n),
        side,
        Ragged(np.searchsorted(carrier, np.append(pair, len(at))), first[carrier]),
        Ragged(np.append(carrier, len(at)), at - patches.start[element]),
        share,
    )


def _changes(values: Ints) -> Bools:
    """Which of `values` (n,) differ from the one before; the first does."""
    return np.append(True, values[1:] != values[:-1])[: len(values)]


def _singular_patches(patches: Patches, beside: tuple[int, int], tip: Floats) -> Ints:
    """Physical patches that a tip ends in: the elements `beside` it, on both faces, belong to the same piece."""
    plus, minus = (patches.of_element.of(element) for element in beside)
    candidates: Ints = np.intersect1d(plus, minus)
    return np.asarray(candidates[np.abs(patches.nodes[candidates] - tip).max(axis=1) < patches.half[candidates]])


def _is_seen_beyond(
    lattice: Lattice, elements: Elements, patches: Patches, some: Ints, points: Floats, reach: float
) -> bool:
    """Whether one of `some` patches is where the angle round a tip jumps on: in line beyond the far end of its crack.

    The crack has vertices (n, 2) from the tip on.
    """
    step = (points[-1] - points[-2]) / np.hypot(*(points[-1] - points[-2]))
    line = shapely.linestrings([points[-1] + TOUCH * step, points[-1] + reach * step])
    cut = elements.tree.query(line, predicate="intersects") + elements.n_whole
    whole = elements.whole_of_tile[lattice.tiles.squares.tree.query(line, predicate="intersects")]
    through = np.concatenate([cut, whole[whole >= 0]])
    return bool(np.isin(patches.of_element.taken(through).values, some).any())
