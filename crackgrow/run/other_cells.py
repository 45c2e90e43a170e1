"""The error of K from K on other cells: twice or half as large, but at kinks, where they are halved three times.

Tip functions follow the field at tips: there the error falls by an order or more. Cells that are chosen for a target
are small enough for that, and all of them twice as large tell it, at less than half the cost of smaller ones. Those of
a name may not be: a crack is three cells long at `draft`. They are half as large to compare, wherever a place asks for
small ones.

Nothing follows the field at kinks. K hardly changes until cells are as small as what opens beside the kink, and then
comes down past its limit more often than not: the difference to K on kinks halved once more is within half and twice
the error in 46 %, to that on kinks doubled in 64 %, but to that on kinks halved three times in 93 %; halved twice, and
times 1.5, in 79 % (140 covers of ten scenes with closed kinks).

With D the difference of both K, K_I and K_II together, and what K_I is below that of faces that touch up to the tip,
tan(dilation angle) |K_II|, since they can't overlap, S that between discs of integration, each at the tip of a crack
where it is largest, since an error may pass through zero at one of them (what the criterion says otherwise, too), and B
the fitted bound (`run.intensity_error`):

                                                            expected                 at most
    kinks halved three times, or cracks without kinks       E = sqrt(D^2 + S^2)      2 E
    kinks halved twice: cells can't be halved more often    E = 1.5 sqrt(D^2 + S^2)  2 E
    nor so often: all twice, or half, as large              E = 0.45 sqrt(D B)       3 E
    nothing to hold K against                               not known                B

Where faces touch at the contact point next to a tip K_I is that of faces that touch up to the tip, and not more but by
a stretch that no contact point sees. What K_I is beyond that, G, comes from cells too large for the pressure along the
faces, on other cells, too. So does what K misses where faces part (`run.parting`): cells there can be the same for
both. It is of K_I, by pressure, and of K_II, by the friction times that and by cohesion. All of it together is that
error at most: half of it counts beside D and S.

Where cells at partings are not the same, what is missed on larger ones may be most of D. It is taken off for both kinds
of cells: all that is missed of cohesion, and half of what is missed of pressure, most of which is less.

How often these are right: tests/benchmarks/targets.md. What the criterion says on the other cells is kept, too
(`run.growth_error`). Cells that are the same but at kinks would cost a quarter less,
since what is integrated elsewhere serves again, but would tell nothing of cells elsewhere: of a kinked crack beside a
square hole 0.001 % where K is off by 0.6 %.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np

from crackgrow.cover.refinement import MOST_LEVELS
from crackgrow.fracture.criteria import Verdict
from crackgrow.fracture.stress_intensity import StressIntensity
from crackgrow.run.advancing import End
from crackgrow.run.halvings import Accuracy, half_as_large
from crackgrow.run.increments import LoadState
from crackgrow.run.intensity_error import intensity_errors, largest_kink
from crackgrow.run.judging import StepSolution, TipState, stress_fields, tip_states
from crackgrow.run.nearby import room_at_tips
from crackgrow.run.parting import Partings, partings
from crackgrow.run.scene import Scene
from crackgrow.run.surface_laws import SurfaceLaw

WORSE_AT_KINKS: Final[Mapping[int, float]] = {3: 1.0, 2: 1.5}
"""How often cells at kinks are halved, if they can be, and by how much more K is off than the difference."""

OF_BOTH = 0.45
AT_MOST, AT_MOST_OF_BOTH = 2.0, 3.0


def compared(solution: StepSolution) -> Scene:
    """The scene with the cells that K is held against."""
    scene, halvings = solution.scene, solution.scene.halvings
    room = MOST_LEVELS + math.log2(float(solution.cover.sizes.min()))
    more = max((times for times in WORSE_AT_KINKS if times <= room), default=0)
    if scene.case.numerics.target is None:
        return scene.with_halvings(half_as_large(len(scene.case.cracks), more or 1))
    return scene.with_halvings(halvings.compared(more) if more else halvings.doubled)


def accuracy_of(solution: StepSolution, other: LoadState | None) -> Accuracy:
    """What K, and what follows from the stress at tips, is off by: by the state under the same loads on other cells.

    Where there is none B alone is known.
    """
    scene, cover = solution.scene, solution.cover
    off = {} if other is None else _of_cracks(_differences(solution, other))
    expected, bounds, all_fitted = [], [], fitted_bounds(solution)
    for tip, end, fitted in zip(cover.tips, cover.tip_ends, all_fitted, strict=True):
        worst = off.get(end[0], UNKNOWN).K
        more = 0 if other is None else _more_at_kinks(solution, other, end[0])
        if np.isnan(worst) or np.isnan(fitted):
            error, most = np.nan, fitted
        elif more in WORSE_AT_KINKS or not largest_kink(solution, tip):
            error = worst * (WORSE_AT_KINKS[more] if largest_kink(solution, tip) else 1.0)
            most = AT_MOST * error
        else:
            error = OF_BOTH * float(np.sqrt(worst * fitted))
            most = AT_MOST_OF_BOTH * error
        expected.append(error)
        bounds.append(most)
    keep = scene.case.numerics.target is not None  # a name's error is measured too seldom for that
    each = [off.get(crack, UNKNOWN) for crack, _ in cover.tip_ends]
    return Accuracy(
        scene.halvings,
        tuple(cover.tip_ends),
        tuple(bounds),
        largest_K(solution),
        fitted=fitted_share(solution, all_fitted),
        compared=other.configuration if other is not None and keep else None,
        expected=tuple(expected),
        rooms=room_at_tips(scene, cover),
        turns=tuple(difference.turn for difference in each),
        criticalities=tuple(difference.criticality for difference in each),
        jumps=any(solution.jumps),
    )


def still_tells(solution: StepSolution, other: LoadState) -> bool:
    """Whether a state that a solution on larger cells was held against tells the error of this one, too.

    It does at kinks, while cells there are a quarter at most; what else it tells is of larger cells, and no less. Where
    cracks have no kinks, cells at their tips have to be twice as large.
    """
    if other.factor != solution.state.factor:
        return False
    mine, others = (each.scene.halvings for each in (solution.configuration, other.configuration))
    return all(
        _more_at_kinks(solution, other, crack) in WORSE_AT_KINKS
        if largest_kink(solution, tip)
        else mine.finer_at_tips(crack, others) == 1
        for tip, (crack, _) in zip(solution.cover.tips, solution.cover.tip_ends, strict=True)
    )


def _more_at_kinks(solution: StepSolution, other: LoadState, crack: int) -> int:
    """How much more often cells at kinks of a crack are halved in the state to compare."""
    mine, others = (each.scene.halvings for each in (solution.configuration, other.configuration))
    return others.finer_at_kinks(crack, mine)


class _Difference(NamedTuple):
    """Of a tip on two kinds of cells."""

    K: float = np.nan  # Pa sqrt(m), sqrt(D^2 + S^2)
    turn: float = np.nan  # rad, of the direction of growth; nan without growth
    criticality: float = np.nan  # of itself; of the load factor where both have their own


UNKNOWN: Final = _Difference()


def _differences(solution: StepSolution, other: LoadState) -> dict[End, _Difference]:
    """Of the tips where K is known; none if both have the same smallest cells.

    So they can have where cells are as small as they can be.
    """
    apart = solution.cover.sizes.min() / other.configuration.cover.sizes.min()
    if 0.6 < apart < 1.5:
        return {}
    scene, others, found = solution.scene, _tips_of(other), {}
    missed, missed_there = partings(solution.state, solution.tips), partings(other, [*others.values()])
    for tip, end in zip(solution.tips, solution.cover.tip_ends, strict=True):
        there = others.get(end)
        if there is not None and np.isfinite((*there.K, *tip.K)).all():
            turn, criticality = _criterion_apart(tip.verdict, there.verdict)
            if other.factor != solution.state.factor:
                criticality = abs(other.factor / solution.state.factor - 1.0)
            apart = _apart(tip, there, (missed[end], missed_there[end]), scene.laws[end[0]])
            found[end] = _Difference(apart, turn, criticality)
    return found


def _of_cracks(differences: Mapping[End, _Difference]) -> dict[int, _Difference]:
    """Those of each crack: the larger one of its tips, each by itself."""
    found: dict[int, _Difference] = {}
    for (crack, _), one in differences.items():
        found[crack] = _Difference(*np.fmax(found.get(crack, UNKNOWN), one).tolist())
    return found


def _apart(here: TipState, there: TipState, missed: tuple[Partings, Partings], law: SurfaceLaw) -> float:
    """sqrt(D^2 + S^2), with what K misses where faces part, and what it is beyond that of faces that touch."""
    K, mine, beyond = here.intensity, missed[0], _beyond_touching(here.intensity, law)
    unexplained = math.dist(there.K, here.K) - sum(each.lost + each.K_I / AT_MOST for each in missed)
    misplaced = mine.K_I + (max(beyond, 0.0) if mine.touches else 0.0)
    most = math.hypot(misplaced, mine.lost + mine.friction * misplaced)
    spread = (K.K_I_spread, K.K_II_spread)
    return math.hypot(max(unexplained, 0.0), *spread, max(-beyond, 0.0), most / AT_MOST)


def _beyond_touching(K: StressIntensity, law: SurfaceLaw) -> float:
    """K_I less that of faces that touch up to the tip (Pa sqrt(m)): those that slip there open by dilation.

    Elastic slip of faces with a stiffness does not dilate.
    """
    if law.contact is None:
        return 0.0
    return K.K_I - (0.0 if law.elastic else law.dilation * abs(K.K_II))


def _criterion_apart(here: Verdict | None, there: Verdict | None) -> tuple[float, float]:
    """What the criterion says otherwise: of the direction (rad), and of the criticality over itself; nan if nothing."""
    if here is None or there is None or not here.criticality > 0.0:
        return np.nan, np.nan
    return abs(there.kink - here.kink), abs(there.criticality / here.criticality - 1.0)


def fitted_bounds(solution: StepSolution) -> list[float]:
    """B (Pa sqrt(m)), tip by tip; nan where K is."""
    fitted = intensity_errors(solution, solution.state.along_surfaces[1])
    return [float(np.max(both)) for both in fitted]


def fitted_share(solution: StepSolution, bounds: Sequence[float]) -> float:
    """B over the largest K, of the tip where it is largest."""
    known, largest = [bound for bound in bounds if np.isfinite(bound)], largest_K(solution)
    return max(known) / largest if known and largest > 0.0 else 0.0


def largest_K(solution: StepSolution) -> float:
    """|K| (Pa sqrt(m)) of the tip where it is largest."""
    return max((float(np.hypot(*tip.K)) for tip in solution.tips if np.isfinite(tip.K).all()), default=0.0)


def _tips_of(state: LoadState) -> dict[End, TipState]:
    """What all tips of a state make of it."""
    tips = tip_states(state, stress_fields(state)[: len(state.cover.tips)])
    return dict(zip(state.cover.tip_ends, tips, strict=True))
