"""Crack tips: polar coordinates round a tip whose angle jumps on the crack itself.

With alpha(r) the polar angle of the crack at distance r from its tip (near +pi), the angle t of a point lies in
(alpha(r) - 2 pi, alpha(r)]. That needs every circle round the tip to cross the crack once; where that ends (a sharp
bend back, or the crack's other tip inside of the same patches, or another crack on which it ends while rock behind that
one sees the tip) the tip functions fade out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.shapes import Roots, turned_roots
from crackgrow.cover.squares import QUANTA
from crackgrow.geometry.polyline import arc_lengths

N_TIP_FUNCTIONS = 4
"""Tip functions on a singular patch, paper eq. (1)."""

NEAR = 0.5
"""Sides of cells on top of the fade: functions of nodes that are farther from the tip than both see too little of
their patches to be told apart."""

POINT_FADE = 0.25
"""Sides of cells: where they fade out sooner, the patches are as good as constant, and one node's are kept."""


@dataclass(frozen=True, slots=True, eq=False)
class TipView:
    """A crack as it is seen from its tip, in lattice coordinates."""

    point: Floats  # (2,)
    rotation: Floats  # (2, 2) rows: outward direction of the tip, and its left normal
    path: Floats  # (n, 2) the crack seen from the tip, in local axes; the first point is (0, 0)
    radii: Floats  # (n,) distances of `path` from the tip, increasing
    fade: float  # L; inf where nothing fades


@dataclass(frozen=True, slots=True, eq=False)
class Carriers:
    """What the four functions of a tip are multiplied by: sums of functions phi_i of patches, times shares."""

    patches: Ints  # (k,) carrier by carrier, of each ascending
    shares: Floats  # (k,)
    number: Ints  # (k,) of the carrier that each is a part of, from 0 on
    reach: float  # no farther from the tip are they seen, spacings

    @property
    def n(self) -> int:
        """Number of carriers."""
        return int(self.number.max(initial=-1)) + 1

    @property
    def gathered(self) -> bool:
        """Whether several patches have part in one of them."""
        return len(self.patches) > self.n


@dataclass(frozen=True, slots=True, eq=False)
class Tip(TipView):
    """A crack tip and its functions."""

    crack: int  # number of its crack
    at_end: bool  # whether it is at the crack's end, not at its start
    points: Floats  # (n, 2) all vertices of the crack, from the tip on
    other_is_tip: bool  # whether the crack's other end is a tip, too
    body: int
    carriers: Carriers
    first_function: int  # four functions for each carrier from this number on
    size: float  # side of the cells round it, spacings: the largest of those at nodes whose patches hold it

    @property
    def patches(self) -> Ints:
        """The patches (k,) of its carriers."""
        return self.carriers.patches

    @property
    def functions(self) -> Ints:
        """The first of the four functions that each of these patches (k,) has a part in."""
        return self.first_function + N_TIP_FUNCTIONS * self.carriers.number

    def from_start(self, arc: Floats) -> Floats:
        """Arc lengths (n,) from the crack's start, from those from the tip."""
        return np.asarray(arc_lengths(self.points[::-1])[-1] - arc if self.at_end else arc)


def largest_cells_at(lattice: Lattice, points: Floats) -> Floats:
    """The sides (n,), spacings, of the largest cell at a node whose patch holds a point (n, 2), not on its rim."""
    nodes, over = lattice.nodes, lattice.tiles.over.taken(lattice.tiles_at(points))
    point, node = over.row, over.values
    holds = np.abs(nodes.places[node] - QUANTA * points[point]).max(axis=1) < nodes.half[node]
    found = np.zeros(len(points))
    np.maximum.at(found, point[holds], nodes.largest[node[holds]] / QUANTA)
    return found


def reach_of_tips(support: float) -> float:
    """Distance (sides of cells) from a tip to the farthest point of a patch that holds it: tip functions end there."""
    return float(2.0 * np.sqrt(2.0) * support)


def n_outward(points_from_tip: Floats) -> int:
    """Number of segments of a crack (n, 2), from its tip on, along which the distance from the tip grows."""
    local = points_from_tip - points_from_tip[0]
    outward = np.sum(local[:-1] * (local[1:] - local[:-1]), axis=1) >= 0.0
    return len(outward) if outward.all() else int(np.argmin(outward))


def seen_from_tip(points_from_tip: Floats, reach: float, ends_inside: bool) -> TipView:
    """A crack given by its vertices (n, 2) from the tip on; `reach` is how far tip functions can be seen.

    ends_inside: whether the jump of the angle would go on beyond the crack's far end, through rock that sees the tip
    """
    direction = points_from_tip[0] - points_from_tip[1]
    direction = direction / np.hypot(*direction)
    rotation = np.array([direction, [-direction[1], direction[0]]])
    path = (points_from_tip - points_from_tip[0]) @ rotation.T
    radii = np.hypot(path[:, 0], path[:, 1])
    n_good = n_outward(points_from_tip)
    ends = np.inf if n_good == len(path) - 1 and not ends_inside else radii[n_good]
    return TipView(
        point=points_from_tip[0],
        rotation=rotation,
        path=path[: n_good + 1],
        radii=radii[: n_good + 1],
        fade=float(ends) if ends < reach else np.inf,
    )


def tip_table(tips: Sequence[TipView], roots: Sequence[Roots]) -> Floats:
    """What the kernels need of tips (t, 11): the point, the rotation row by row, the length L, and the two roots.

    `roots` are, tip by tip, in the axes of the lattice.
    """
    rows = []
    for tip, of_rock in zip(tips, roots, strict=True):
        first, last = turned_roots(of_rock, tip.rotation)
        rows.append([*tip.point, *tip.rotation.ravel(), tip.fade, first.real, first.imag, last.real, last.imag])
    return np.array(rows).reshape(-1, 11)


def carrying_nodes(tip: TipView, nodes: Floats, size: float) -> Bools:
    """Which `nodes` (n, 2) of singular patches carry the tip's functions; `size` is the side of the cells there.

    Within a small disc the functions phi_i of the patches are polynomials of a low degree, up to a small rest: with all
    patches the tip functions would depend on each other, at a fade of half a spacing to working precision.
    """
    distance = np.abs(nodes - tip.point).max(axis=1, initial=0.0)
    if tip.fade < POINT_FADE * size:
        return np.asarray(np.arange(len(nodes)) == np.argmin(distance))
    return np.asarray(distance < tip.fade + NEAR * size)


def tip_angle(tip: TipView, points: Floats, reference: Floats) -> tuple[Floats, Floats]:
    """Distance r and angle t (n,) of points (n, 2), each on the same side of the crack as its `reference` (n, 2).

    The reference lies off the crack; the point may lie on it.
    """
    local = (points - tip.point) @ tip.rotation.T
    angle = np.arctan2(local[:, 1], local[:, 0])
    angle += 2.0 * np.pi * np.round((side_angle(tip, reference) - angle) / (2.0 * np.pi))
    return np.hypot(local[:, 0], local[:, 1]), angle


def side_angle(tip: TipView, reference: Floats) -> Floats:
    """Angle t (n,) of points (n, 2) that lie off the crack."""
    seen = (reference - tip.point) @ tip.rotation.T
    alpha = crack_angle(tip, np.hypot(seen[:, 0], seen[:, 1]))
    return np.asarray(alpha - np.mod(alpha - np.arctan2(seen[:, 1], seen[:, 0]), 2.0 * np.pi))


def crack_angle(tip: TipView, r: Floats) -> Floats:
    """Polar angle alpha (n,) of the crack at distances r (n,) from its tip, counted from the tip's direction."""
    alpha = np.full(len(r), np.pi)
    beyond = np.flatnonzero(r > tip.radii[1]) if len(tip.radii) > 2 else ()
    if len(beyond):
        alpha[beyond] += _winding(tip, r[beyond])
    return alpha


def _winding(tip: TipView, r: Floats) -> Floats:
    """Polar angle (n,) of the crack at distances r (n,) from its tip, counted from straight back: no jump there."""
    segment = np.clip(np.searchsorted(tip.radii, r, side="right") - 1, 0, len(tip.radii) - 2)
    start = tip.path[segment]
    step = tip.path[segment + 1] - start
    # |start + tau step| = r, the larger root: the distance grows along the segment
    a = np.sum(step * step, axis=1)
    half_b = np.sum(start * step, axis=1)
    c = np.sum(start * start, axis=1) - r * r
    tau = (-half_b + np.sqrt(np.maximum(half_b * half_b - a * c, 0.0))) / a
    at = start + tau[:, None] * step
    return np.asarray(np.arctan2(-at[:, 1], -at[:, 0]))
