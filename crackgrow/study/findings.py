"""What the runs of a trade tell: K and loads of the states that all have, what they tend to, what each setting misses.

States of two runs are the same ones where all tips have grown as often, and the same cracks have started: in scenes
that are nearly symmetric tips take turns in another order. With f = f0 + c h^p on cells of sides h_3 > h_2 > h_1 the
order p follows from

    (f_3 - f_2) / (f_2 - f_1) = (h_3^p - h_2^p) / (h_2^p - h_1^p),

whatever the ratios of the sides (Celik and others 2008, Procedure for estimation and reporting of uncertainty due to
discretization, J. Fluids Eng. 130, 078001), and f0 = f_1 - (f_2 - f_1) / ((h_2 / h_1)^p - 1).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from scipy.optimize import brentq

from crackgrow.case.model import CriticalLoad
from crackgrow.results.folder import RunFolder
from crackgrow.study.compare import compared_growth
from crackgrow.study.trade_plan import TradePlan

TURNED: Final = 2.0
"""K_II that is off by a part of K_I turns the direction of growth by twice that: paths may be off by so much more."""

LEAST_ORDER: Final = 0.5
MOST_ORDER: Final = 2.0
"""Orders that are extrapolated with: with a larger one that is an accident the finest would seem to be exact."""

ORDERS: Final = (0.05, 12.0)
"""Orders that are looked for."""

SAME_SIZE: Final = 1.05
"""Sides of cells whose ratio is less are the same."""

MODES: Final = ("K_I", "K_II")
LOAD: Final = "load_factor"
DISPLACEMENT: Final = "load_displacement"


class Reading(NamedTuple):
    """What a run says of a quantity in a step."""

    step: int
    value: float  # Pa sqrt(m) of K, m of the displacement
    error: float  # what K is off by as the run says
    cell_size: float  # m; for a whole scene the smallest at any tip, else a length by the number of unknowns


Key = frozenset[tuple[str, str, int]]
"""A state: crack, end and number of advances of all tips that have grown; of a crack that has started its name and
zero; of a scene without growth the number of the step."""

State = dict[tuple[str, str, str], Reading]
"""By crack, tip (both empty for the whole scene) and name of the quantity."""


def states_of(run: RunFolder, grows: bool) -> dict[Key, State]:
    """The states of a run."""
    advances: Counter[tuple[str, str]] = Counter()
    found: dict[Key, State] = {}
    tips, events = run.table("tips").records(), run.table("events").records() if grows else []
    for row in run.table("steps").records():
        step, state = row["step"], State()
        mine = {(tip["crack"], tip["tip"]): tip for tip in tips if tip["step"] == step}
        for place, tip in mine.items():
            error = max(tip["K_I_error"], tip["K_II_error"])
            state |= {(*place, name): Reading(step, tip[name], error, tip["cell_size"]) for name in MODES}
        size = min((reading.cell_size for reading in state.values()), default=math.nan)
        size = 1.0 / math.sqrt(row["n_dofs"]) if math.isnan(size) else size
        state |= {("", "", name): Reading(step, row[name], 0.0, size) for name in (LOAD, DISPLACEMENT)}
        started = [event["crack"] for event in events if event["step"] <= step and event["kind"] == "initiation"]
        grown = {(*tip, n) for tip, n in advances.items()} | {(crack, "", 0) for crack in started}
        found[frozenset(grown if grows else {("", "", step)})] = state
        advances.update(place for place, tip in mine.items() if tip["advanced"])
    return found


class Limit(NamedTuple):
    """What three values tend to."""

    value: float
    order: float  # nan where the values do not approach anything from one side
    rest: float  # what the finest value is off by


def limit_of(values: Sequence[float], sizes: Sequence[float]) -> Limit:
    """The limit of three values, of the coarsest cells first, on cells of these sizes.

    Values that do not approach it from one side tend to the finest, which is off by half of what they vary, or by the
    last change if that is more.
    """
    (_, f2, f1), order = values, order_of(values, sizes)
    if math.isnan(order):
        return Limit(f1, order, max(abs(f2 - f1), 0.5 * (max(values) - min(values))))
    ratio = sizes[1] / sizes[2]
    beyond = (f1 - f2) / (ratio ** min(max(order, LEAST_ORDER), MOST_ORDER) - 1.0)
    return Limit(f1 + beyond, order, abs(beyond))


def order_of(values: Sequence[float], sizes: Sequence[float]) -> float:
    """The observed order; nan where there is none."""
    (f3, f2, f1), (h3, h2, h1) = values, sizes
    if same_cells(sizes) or f2 == f1 or (f3 - f2) / (f2 - f1) <= 0.0:
        return math.nan
    wanted = math.log((f3 - f2) / (f2 - f1))

    def excess(p: float) -> float:
        return math.log((h3**p - h2**p) / (h2**p - h1**p)) - wanted

    low, high = ORDERS
    if excess(low) > 0.0:
        return math.nan  # the changes grow
    return high if excess(high) < 0.0 else float(brentq(excess, low, high))


def same_cells(sizes: Sequence[float]) -> bool:
    """Whether one of three sides is not smaller than the one before: nothing can be extrapolated then."""
    return not min(sizes[0] / sizes[1], sizes[1] / sizes[2]) > SAME_SIZE


@dataclass(frozen=True, slots=True, eq=False)
class Quantity:
    """K of a tip or a number of the whole scene, in one state."""

    step: int  # of the run with the finest cells
    crack: str  # empty: of the whole scene
    tip: str
    name: str  # K_I, K_II (Pa sqrt(m)), load_factor, load_displacement (m)
    values: Mapping[str, float]  # by setting
    limit: Limit
    same_cells: bool  # of three settings
    size: float  # what errors are shares of: the largest |K| of the step, or the limit

    def error(self, setting: str) -> float:
        """What a setting is off by, over the size."""
        off = abs(self.values[setting] - self.limit.value)
        return max(off, self.limit.rest) / self.size if self.size > 0.0 else math.nan


class Apart(NamedTuple):
    """How far apart the paths of two runs are, over what both have grown."""

    distance: float  # m, Hausdorff, of the tip where it is largest
    share: float  # of what has grown there in both, of the tip where that is largest


@dataclass(frozen=True, slots=True, eq=False)
class Findings:
    """All that was found."""

    plan: TradePlan
    quantities: tuple[Quantity, ...]
    paths: Mapping[str, Apart]  # by setting: to that on the finest cells; by other increment: to the own one
    left_out: int  # states that some run does not have

    @property
    def worst(self) -> Quantity | None:
        """Where the case's own setting is off by most; None where nothing has a size."""
        own = self.plan.own
        known = [quantity for quantity in self.quantities if not math.isnan(quantity.error(own))]
        return max(known, key=lambda quantity: quantity.error(own), default=None)

    def error(self, setting: str) -> float:
        """The largest of a setting, over all that is known; nan where nothing is."""
        errors = [quantity.error(setting) for quantity in self.quantities if setting in quantity.values]
        return max((error for error in errors if not math.isnan(error)), default=math.nan)

    @property
    def path_tolerance(self) -> float:
        """What paths may be apart, over what has grown."""
        return TURNED * self.plan.tolerance

    @property
    def moves(self) -> dict[str, Apart]:
        """What would move the own path, in words, and by how much; as far as it was run.

        Where the own cells are the finest, it is what they move the path of the next finest.
        """
        *_, next_finest, finest = self.plan.settings
        moves = {"finer cells": self.paths.get(next_finest if self.plan.own == finest else self.plan.own)}
        if self.plan.increments:
            moves["a shorter increment"] = self.paths.get(self.plan.increments[-1])
        return {what: apart for what, apart in moves.items() if apart is not None}

    @property
    def paths_good_enough(self) -> bool:
        """Whether nothing of that moves the path by more than it may."""
        return max((apart.share for apart in self.moves.values()), default=0.0) <= self.path_tolerance

    @property
    def good_enough(self) -> bool:
        """Whether the own setting is within the tolerance, and so are its paths."""
        return self.error(self.plan.own) <= self.plan.tolerance and self.paths_good_enough

    def within(self, setting: str) -> bool:
        """Whether K of a setting is within the tolerance, and its path is as near to that on the finest cells."""
        path = self.paths.get(setting)
        return (path is None or path.share <= self.path_tolerance) and self.error(setting) <= self.plan.tolerance


def findings(plan: TradePlan) -> Findings:
    """What the runs tell, all of which have a first step; raises CaseError where paths can't be read."""
    folders = {run.name: run.folder for run in plan.study.runs}
    states = {name: states_of(RunFolder(folders[name]), plan.grows) for name in {*plan.settings, plan.own}}
    all_keys = {key for found in states.values() for key in found}
    shared = [key for key in states[plan.settings[-1]] if all(key in found for found in states.values())]
    found = [q for key in shared for q in _quantities(plan, {name: states[name][key] for name in _compared(plan)})]
    return Findings(plan, tuple(found), _paths(plan, folders) if plan.grows else {}, len(all_keys) - len(shared))


def _compared(plan: TradePlan) -> list[str]:
    """Settings of cells, the own one among them."""
    return list(dict.fromkeys((*plan.settings, plan.own)))


def _quantities(plan: TradePlan, states: Mapping[str, State]) -> Iterator[Quantity]:
    """K of the tips of a state, by setting, where it is known, and what the whole scene has."""
    three = plan.settings[-3:]
    finest = states[three[-1]]
    shared = [place for place in finest if all(place in state for state in states.values())]
    tips = {place[:2] for place in finest if place[0]}
    K = [(finest[*tip, "K_I"].value, finest[*tip, "K_II"].value) for tip in tips]
    largest = max((float(np.hypot(*both)) for both in K if np.isfinite(both).all()), default=math.nan)
    for place in shared:
        crack, tip, name = place
        values = {setting: state[place].value for setting, state in states.items()}
        known = isinstance(plan.case.loading, CriticalLoad) if name == LOAD else not any(crack for crack, *_ in shared)
        if not (np.isfinite(list(values.values())).all() if crack else known):
            continue
        sizes = [states[setting][place].cell_size for setting in three]
        limit, same = limit_of([values[setting] for setting in three], sizes), same_cells(sizes)
        if same:  # nothing is learnt of the error but by the run itself
            limit = limit._replace(rest=max(limit.rest, finest[place].error))
        size = largest if crack else abs(limit.value)
        yield Quantity(finest[place].step, crack, tip, name, values, limit, same, size)


def _paths(plan: TradePlan, folders: Mapping[str, Path]) -> dict[str, Apart]:
    """The paths of settings against that on the finest cells, of other increments against the own one."""
    finest = plan.settings[-1]
    pairs = {name: (name, finest) for name in _compared(plan) if name != finest}
    pairs |= {name: (plan.own, name) for name in plan.increments}
    found = {}
    for name, (a, b) in pairs.items():
        grown = [pair.common for pair in compared_growth(folders[a], folders[b]) if pair.common is not None]
        if grown:  # in both
            shares = [common.hausdorff / min(common.length_a, common.length_b) for common in grown]
            found[name] = Apart(max(common.hausdorff for common in grown), max(shares))
    return found
