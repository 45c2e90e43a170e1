"""By how much the direction of growth and the critical load factor may be off: by K, and by the criterion.

K that is off by d adds the singular field of d to the stress round the tip. The criterion is asked where K_I and K_II
are as far off as their bounds let them, K_I +- d_I and K_II +- d_II: the direction is off by as much as its answer
turns. The load factor is off by 1/n of what the criticality is, with n = d ln(criticality) / d ln(load factor).

The stress at the distance of its average is not that of K alone, and has an error of its own. Where the step is held
against other cells (`run.other_cells`) the criterion is asked there, too: direction and criticality are off by three
times what it says otherwise, or by what follows from K where that is more. A direction is off by half a turn at most:
of two that are as good as each other the criterion may take the other one there.

Where the direction is that without shear at the new tip (`growth.direction: implicit`), a kink that is off by dt leaves
K_II = K_I dt / 2 there, so that K_II that is off by d_II has turned the last increment by 2 d_II / K_I: what the hoop
stress says of the new tip. A tip that goes on in shear keeps the direction of the criterion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from crackgrow.case.model import CriticalLoad
from crackgrow.fracture.criteria import TipLoading, Verdict, hoop_stress_kink
from crackgrow.run.intensity_error import intensity_errors
from crackgrow.run.judging import StepSolution, verdicts
from crackgrow.run.result import CrackFaces

NAN = float("nan")
CRITERION_AT_MOST = 3.0
CORNERS = ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0))

Errors = Sequence[tuple[float, float]]
"""Bounds (Pa sqrt(m)) of the errors of K_I and K_II, tip by tip."""

Judged = list[list[tuple[TipLoading, Verdict]]]
"""Loadings and what the criterion says of them, tip by tip."""


@dataclass(frozen=True, slots=True, eq=False)
class StepErrors:
    """What a step may be off by; nan where that is not known."""

    K: Errors
    expected: Sequence[float]  # Pa sqrt(m), tip by tip: what K_I and K_II together are off by, most likely
    kinks: Sequence[float]  # rad, tip by tip, of the direction of growth
    load_factor: float  # of a critical one, over itself
    goal: float  # of its largest value; nan where that is K


def errors_of(solution: StepSolution, faces: tuple[CrackFaces, ...]) -> StepErrors:
    """What was measured of the errors of K, or else their bounds from the fit, and what follows from them."""
    known = solution.accuracy
    K = intensity_errors(solution, faces) if known is None else [(bound, bound) for bound in known.bounds]
    expected, goal = ([NAN] * len(K), NAN) if known is None else (known.expected, known.goal)
    off = judged_when_off(solution, K)
    return StepErrors(K, expected, kink_errors(solution, off), load_error(solution, off), goal)


def judged_when_off(solution: StepSolution, errors: Errors) -> Judged:
    """Each tip where K is off as far as it may be; nothing where that is not known."""
    tips = solution.configuration.sites[: len(solution.tips)]
    moved = [
        _moved(state.loading, error) if state.verdict is not None else []
        for state, error in zip(solution.tips, errors, strict=True)
    ]
    sites = [site for site, loadings in zip(tips, moved, strict=True) for _ in loadings]
    said = iter(verdicts(solution.scene, sites, list(chain(*moved))))
    return [[(loading, next(said)) for loading in loadings] for loadings in moved]


def kink_errors(solution: StepSolution, off: Judged) -> list[float]:
    """What the direction of growth may be off by (rad), tip by tip; nan without growth, or where K is not known."""
    growth = solution.scene.case.growth
    found = []
    for state, others, (apart, _) in zip(solution.tips, off, _measured(solution), strict=True):
        if state.verdict is None or growth is None:
            found.append(NAN)
            continue
        least = 0.0
        if growth.direction == "implicit" and state.verdict.mode == "tension":
            kink, kinks = hoop_stress_kink(*state.K), [hoop_stress_kink(each.K_I, each.K_II) for each, _ in others]
        else:
            kink, kinks, least = state.verdict.kink, [says.kink for _, says in others], apart
        found.append(min(max((least, *(abs(other - kink) for other in kinks))), np.pi) if kinks else NAN)
    return found


def load_error(solution: StepSolution, off: Judged) -> float:
    """What the critical load factor may be off by, over itself; nan where no tip of known K sets the load.

    Where bonds break at it, it is held against that on other cells.
    """
    if not isinstance(solution.scene.case.loading, CriticalLoad):
        return NAN
    measured = _measured(solution)
    if any(solution.jumps):
        return max((apart for _, apart in measured), default=0.0) or NAN
    ranges = [(0.0, 0.0, 0.0)]  # of the criticality of tips: as it is, the least and the largest that it may be
    for state, grows, others, (_, apart) in zip(solution.tips, solution.grows, off, measured, strict=True):
        if state.verdict is None or not grows:
            continue
        if not others:
            return NAN
        here = state.verdict.criticality
        own = [*(says.criticality for _, says in others), (1.0 - apart) * here, (1.0 + apart) * here]
        ranges.append((here, min(own), max(own)))
    found, least, most = (float(max(column)) for column in zip(*ranges, strict=True))
    starts = max((start.verdict.criticality for start in solution.starts), default=0.0)
    if found <= 0.0 or starts > found or not solution.steepness > 0.0:
        return NAN
    return max(most / found - 1.0, 1.0 - least / found) / solution.steepness


def _measured(solution: StepSolution) -> list[tuple[float, float]]:
    """Direction (rad) and criticality, over itself, of all tips: at most what they are off by; 0 where not measured."""
    known = solution.accuracy
    if known is None:
        return [(0.0, 0.0)] * len(solution.tips)
    apart = np.nan_to_num(np.array([known.turns, known.criticalities]))
    return [(turn, criticality) for turn, criticality in (CRITERION_AT_MOST * apart).T.tolist()]


def _moved(loading: TipLoading | None, error: tuple[float, float]) -> list[TipLoading]:
    """The loading of a tip where K is off as far as it may be; nothing where that is not known."""
    if loading is None or not np.isfinite((*error, loading.K_I, loading.K_II)).all():
        return []
    return loading.with_K_off(*((first * error[0], second * error[1]) for first, second in CORNERS))
