"""Which cells are refined for a target: at the features of what is off, or everywhere where that leaves too much.

K of a crack is also off by what cells miss at features of others close by: such neighbours are refined together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from crackgrow.accuracy.companion import Errors
from crackgrow.accuracy.features import Changes, Grading
from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Goal

MOST_AT_ONCE = 3
"""Levels in one round."""

STUCK = 0.8
"""An error of which this is left does not come from features of cracks alone: theta and corners are refined, too."""

ROOM = 0.6
"""Of the target: so far the next step may come with coarser cells, each level of which doubles the error."""

NO_ERROR = 1e-9
"""Of a target."""

COARSEST = -2
"""Levels below those that a run begins with: features that nothing needs any more are of old kinks, grown far from."""

CLOSE = 0.5
"""Of the shorter of two cracks: neighbours are nearer to each other than that."""


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
    for crack, share in enumerate((_shares(errors, goal, cracks) / target).tolist()):
        if share > 1.0 or unknown:
            levels[crack] += 1 if stuck or unknown else math.ceil(math.log2(min(share, 2.0**MOST_AT_ONCE)))
    none = all(level == grading.level(crack) for crack, level in enumerate(levels))
    return replace(grading, cracks=tuple(levels), rest=grading.rest + (stuck or none), changes=changes)


def coarsened(errors: Errors, target: float, goal: Goal, cracks: Sequence[Floats], changes: Changes) -> Grading:
    """The grading that the next step begins with; contact status changes at some places by now."""
    grading = errors.grading
    levels, shares = [grading.level(crack) for crack in range(len(cracks))], _shares(errors, goal, cracks) / target
    rest_too = grading.rest > 0 and bool(2.0 * np.fmax.reduce(shares, initial=math.nan) < ROOM)
    for crack, share in enumerate((shares * 2.0**rest_too).tolist()):
        if share < ROOM:  # neither where it is not known
            fewer = int(math.log2(ROOM / max(share, NO_ERROR)))
            levels[crack] = max(levels[crack] - min(fewer, MOST_AT_ONCE), min(levels[crack], COARSEST))
    return replace(grading, cracks=tuple(levels), rest=grading.rest - rest_too, changes=changes)


def _shares(errors: Errors, goal: Goal, cracks: Sequence[Floats]) -> Floats:
    """What the goal is off by (n,) of its largest value, crack by crack, each with its neighbours; nan: not known.

    A crack without tips has the largest of all: any K may hang on it.
    """
    own = errors.estimate_by_crack(goal, len(cracks))
    tipless = np.setdiff1d(np.arange(len(cracks)), [crack for crack, _ in errors.ends])
    own[tipless] = errors.estimate(goal) if math.isfinite(errors.estimate(goal)) else math.nan
    found = own.copy()
    first, second = neighbours(cracks)
    np.fmax.at(found, first, own[second])
    return found
