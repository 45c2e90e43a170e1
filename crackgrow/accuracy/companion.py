"""Errors of a step from its companion mesh: the same family of cells, all of them twice as large.

The step's cells are the companion's, each quartered, and so are the pieces between contact points: what the two meshes
say of any quantity differs by D, which is as large as the companion's error. With c1 = EXPECTED and c2 = BOUND

    error estimate = D,    error expected = D / c1,    error at most = c2 D

for K_I and K_II together, the T stress, directions of growth, critical load factors, jumps of faces and reactions. An
error may pass through zero at one tip, so D of K, T and directions is that of the crack's tip where it is largest, and
D of directions and of a critical load is not below that of the K that they follow from, over that K. To D of K and T
is added, as any independent error is, the spread between the discs of the integral, and to D of K the K_I below zero
at faces that can't overlap: next to such a tip they touch over less than the cells there, on both meshes. What no pair
can see is shear that faces carry beyond friction where a tip is open more closely to itself than any contact point
lies (`unresolved_shear`).

Targets are of the estimate, as is usual where cells follow from errors: a target on the bound is met by errors of a
fifth of it in the median, for three times the unknowns where cracks are many. Cells are refined for a target at the
features of what is off, or everywhere where that leaves too much. K of a crack is also off by what cells miss at
features of others close by, whose own K then mostly is, too: such neighbours are refined together in a second round.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from typing import Any

import numpy as np
import shapely

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Goal

EXPECTED = 1.6
"""D over the error in the median: tests/benchmarks/errors.md."""

BOUND = 3.0
"""The error is below so many D in 97 % of all quantities there."""

NOTHING = 1e-9
"""Of the largest K: a K below is round-off."""

MOST_AT_ONCE = 3
"""Levels in one round."""

STUCK = 0.8
"""An error of which this is left does not come from features of cracks alone: theta and corners are refined, too."""

ROOM = 0.6
"""Of the target: so far the next step may come with coarser cells, each level of which doubles the error."""

COARSEST = -2
"""Levels below those that a run begins with: features that nothing needs any more are of old kinks, grown far from."""

CLOSE = 0.5
"""Of the shorter of two cracks: neighbours are nearer to each other than that."""

End = tuple[int, bool]
"""Number of a crack, and whether it is its end or its start."""

Changes = tuple[tuple[int, float, float], ...]
"""Where contact status changes: crack, x and y (m)."""


@dataclass(frozen=True, slots=True)
class Grading:
    """Refinement levels that errors have asked for, and whether cells are those of a companion mesh, each quartered."""

    nested: bool = False  # False: cells by hand, without a companion
    companion: bool = False
    cracks: tuple[int, ...] = ()  # crack by crack; those beyond have the level 0
    rest: int = 0  # of corners, and of theta
    changes: Changes = field(default=(), repr=False)

    @property
    def quartered(self) -> bool:
        """Whether cells are those of the companion mesh, each quartered."""
        return self.nested and not self.companion

    def level(self, crack: int) -> int:
        """The level of a crack."""
        return self.cracks[crack] if crack < len(self.cracks) else 0


BY_HAND = Grading()


@dataclass(frozen=True, slots=True, eq=False)
class Quantities:
    """What a step says on one mesh, at places that do not depend on cells."""

    ends: tuple[End, ...]  # tip by tip
    K: Floats  # (n, 2) Pa sqrt(m), nan where it is not known
    spread: Floats  # (n,) Pa sqrt(m), of both between discs, with K_I below zero of faces that touch
    T: Floats  # (n,) Pa
    T_spread: Floats  # (n,) Pa, between discs
    unresolved: Floats  # (n,) Pa sqrt(m)
    kinks: Floats  # (n,) rad, directions of growth; nan without growth
    load_factor: float  # on the mesh's own path
    jumps: Floats  # (m, 2) m, opening and slip
    forces: Floats  # (k, 2) N/m, reactions
    small: Mapping[str, float]  # values of "K" (Pa sqrt(m)), "slip" (m), "reaction" (N/m) of which errors are parts


@dataclass(frozen=True, slots=True)
class Errors:
    """D of the quantities of a step, and the cells that it was solved on. An error that is not known is nan."""

    grading: Grading
    ends: tuple[End, ...] = ()
    K: tuple[float, ...] = ()  # Pa sqrt(m), tip by tip: of K_I and K_II together
    largest: float = 0.0  # Pa sqrt(m), |K| of the tip where it is largest, or what is small where that is larger
    T: tuple[float, ...] = ()  # Pa, tip by tip
    kinks: tuple[float, ...] = ()  # rad, tip by tip
    shares: Mapping[str, float] = field(default_factory=dict)  # of goals, over the largest value; no K
    missed: str = ""  # why the target is out of reach, in words; empty where it is met

    def estimate(self, goal: Goal) -> float:
        """D of a goal over its largest value; infinite where it is not known."""
        share = self._of_K(self.K) if goal == "K" else self.shares.get(goal, math.nan)
        return math.inf if math.isnan(share) else share

    def estimate_by_crack(self, goal: Goal, n: int) -> Floats:
        """The same (n,) crack by crack: of K nothing where a crack has no tips, nan where it is not known."""
        if goal != "K":
            return np.full(n, self.estimate(goal))
        found = np.zeros(n)
        for crack, tips in groupby(sorted(zip(self.ends, self.K, strict=True)), lambda tip: tip[0][0]):
            found[crack] = self._of_K([D for _, D in tips])
        return found

    def _of_K(self, D: Sequence[float]) -> float:
        """D of K of some tips, of which there may be none, over the largest."""
        known = [each for each in D if not math.isnan(each)]
        if not D or not self.largest > 0.0:  # no tips, no loads, or all faces stick
            return 0.0
        return max(known) / self.largest if known else math.nan


def errors_of(grading: Grading, here: Quantities, there: Quantities | None) -> Errors:
    """The errors of a step from its quantities, and those of its companion; not known without one."""
    n, K = len(here.ends), np.hypot(*here.K.T)
    largest = max(float(np.nanmax(K)), here.small["K"]) if np.isfinite(K).any() else 0.0
    if there is None:
        unknown = (math.nan,) * n
        return Errors(grading, here.ends, unknown, largest, unknown, unknown)
    other = [there.ends.index(end) if end in there.ends else -1 for end in here.ends]
    K_there, T_there, kinks_there = (
        np.append(values, np.full((1, *values.shape[1:]), np.nan), axis=0)[other]
        for values in (there.K, there.T, there.kinks)
    )
    apart = np.hypot(*(here.K - K_there).T)
    D = _largest_of_crack(here.ends, np.hypot(apart, here.spread)) + here.unresolved / BOUND
    D_T = _largest_of_crack(here.ends, np.hypot(here.T - T_there, here.T_spread))
    turned = _largest_of_crack(here.ends, np.abs(here.kinks - kinks_there))
    of_K, some = np.full(n, np.nan), NOTHING * largest < K
    of_K[some] = D[some] / K[some]  # what directions and critical loads follow from
    turned = np.where(np.isfinite(turned), np.fmax(turned, np.minimum(of_K, math.pi)), turned)
    lifted = abs(there.load_factor / here.load_factor - 1.0) if here.load_factor else math.nan
    shares = {
        "load_factor": np.fmax(lifted, of_K[np.nanargmax(K)]).item() if lifted > 0.0 and some.any() else lifted,
        "slip": _share(here.jumps, there.jumps, here.small["slip"]),
        "reaction": _share(here.forces, there.forces, here.small["reaction"]),
    }
    return Errors(grading, here.ends, tuple(D.tolist()), largest, tuple(D_T.tolist()), tuple(turned.tolist()), shares)


def _largest_of_crack(ends: Sequence[End], values: Floats) -> Floats:
    """Tip by tip (n,) the largest value of its crack's tips; nan where it is not known."""
    cracks = np.array([crack for crack, _ in ends], dtype=np.int64)
    largest = np.full(cracks.max(initial=-1) + 1, np.nan)
    np.fmax.at(largest, cracks, values)
    return np.where(np.isnan(values), np.nan, largest[cracks])


def _share(here: Floats, there: Floats, small: float) -> float:
    """Difference of vectors (m, 2), where it is largest, over the largest of them; nan where there are none."""
    largest = max(float(np.hypot(*here.T).max(initial=0.0)), small)
    if not len(here) or here.shape != there.shape:
        return math.nan
    return float(np.hypot(*(here - there).T).max()) / largest if largest > 0.0 else 0.0


def unresolved_shear(K_I: float, y: float, pressure: float, shear: float) -> float:
    """Bound (Pa sqrt(m)) of what K_II misses where a tip is open over a stretch that no contact point lies on.

    The first point is closed, y (m) from the tip, with this pressure and shear beyond friction (Pa). By the weight
    function of a half-infinite crack (Tada, Paris, Irwin 2000) the tip is open over a, K_I = p sqrt(8 a / pi).
    """
    if K_I <= 0.0:
        return 0.0
    return shear * min(math.sqrt(8.0 / math.pi * y), K_I / pressure if pressure > 0.0 else math.inf)


def errors_of_record(record: Mapping[str, Any]) -> Errors:
    """The errors that were written as plain data (`asdict`), whose numbers may be nan."""
    values = {name: _as_tuples(value) for name, value in record.items()}
    grading = {name: _as_tuples(value) for name, value in record["grading"].items()}
    return Errors(**{**values, "grading": Grading(**grading)})


def _as_tuples(value: Any) -> Any:
    return tuple(map(_as_tuples, value)) if isinstance(value, list | tuple) else value


def neighbours(cracks: Sequence[Floats]) -> Ints:
    """Pairs (2, k) of cracks, by their points (n, 2), that are close to each other; both ways round."""
    lines = np.array([shapely.LineString(points) for points in cracks], dtype=object)
    first, second = shapely.STRtree(lines).query(lines, "dwithin", distance=CLOSE * shapely.length(lines))
    close = shapely.distance(lines[first], lines[second]) <= CLOSE * shapely.length(lines[second])
    return np.stack([first[close], second[close]])


def refined(
    errors: Errors, before: Errors | None, target: float, goal: Goal, cracks: Sequence[Floats], changes: Changes
) -> Grading:
    """The grading after a round whose errors are beyond the target, and after one `before` it in the same step.

    Depths at features have an error of the first order in the sizes of cells. Contact status changes at some places.
    Where errors are not known cells may be too large for a companion to have a solution at all.
    """
    grading = errors.grading
    unknown = math.isinf(errors.estimate(goal))
    stuck = not unknown and before is not None and errors.estimate(goal) > STUCK * before.estimate(goal)
    levels = [grading.level(crack) for crack in range(len(cracks))]
    for crack, share in enumerate((_shares(errors, goal, cracks, widely=before is not None) / target).tolist()):
        if share > 1.0 or unknown:
            levels[crack] += 1 if stuck or unknown else math.ceil(math.log2(min(share, 2.0**MOST_AT_ONCE)))
    none = all(level == grading.level(crack) for crack, level in enumerate(levels))
    return replace(grading, cracks=tuple(levels), rest=grading.rest + (stuck or none), changes=changes)


def coarsened(errors: Errors, target: float, goal: Goal, cracks: Sequence[Floats], changes: Changes) -> Grading:
    """The grading that the next step begins with; contact status changes at some places by now."""
    grading = errors.grading
    levels = [grading.level(crack) for crack in range(len(cracks))]
    shares = _shares(errors, goal, cracks, widely=True) / target
    rest_too = grading.rest > 0 and bool(2.0 * np.fmax.reduce(shares, initial=math.nan) < ROOM)
    for crack, share in enumerate((shares * 2.0**rest_too).tolist()):
        if share < ROOM:  # neither where it is not known
            fewer = int(math.log2(ROOM / max(share, ROOM * 0.5**MOST_AT_ONCE)))
            levels[crack] = max(levels[crack] - fewer, min(levels[crack], COARSEST))
    return replace(grading, cracks=tuple(levels), rest=grading.rest - rest_too, changes=changes)


def _shares(errors: Errors, goal: Goal, cracks: Sequence[Floats], widely: bool) -> Floats:
    """What the goal is off by (n,) of its largest value, crack by crack; nan: not known.

    A crack without tips has that of its neighbours. `widely` every crack has, and any K may hang on one without tips.
    """
    own = errors.estimate_by_crack(goal, len(cracks))
    tipless = np.setdiff1d(np.arange(len(cracks)), [crack for crack, _ in errors.ends])
    first, second = neighbours(cracks)
    if widely:
        own[tipless] = errors.estimate(goal) if math.isfinite(errors.estimate(goal)) else math.nan
    else:
        near = np.isin(first, tipless)
        first, second = first[near], second[near]
    found = own.copy()
    np.fmax.at(found, first, own[second])
    return found
