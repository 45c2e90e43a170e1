"""What the runs of a trade tell: K and loads of the states that all have, what they tend to, what each setting misses.

States of two runs are the same ones where all tips have grown as often, and the same cracks have started: in scenes
that are nearly symmetric tips take turns in another order.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crackgrow.case.model import CriticalLoad
from crackgrow.results.folder import RunFolder
from crackgrow.study.compare import grown_pairs
from crackgrow.study.extrapolation import distinct, limit_of
from crackgrow.study.trade_plan import TradePlan

Key = frozenset[tuple[str, str, int]]
"""Crack, end and number of advances of all tips that have grown; of a crack that has started its name and zero; of a
scene without growth the number of the step."""

TURNED = 2.0
"""K_II that is off by a part of K_I turns the direction of growth by twice that: paths may be off by so much more."""

NAN = float("nan")
MODES = ("K_I", "K_II")
LOAD = "load_factor"
DISPLACEMENT = "load_displacement"


@dataclass(frozen=True, slots=True, eq=False)
class Tip:
    """K of a tip (Pa sqrt(m)), what it is off by as the run says, and the side of the cells there (m)."""

    K: tuple[float, float]
    error: float
    cell_size: float


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """A step of a run."""

    step: int
    load_factor: float
    load_displacement: float  # m
    n_dofs: int  # unknowns
    tips: Mapping[tuple[str, str], Tip]  # by crack and end


def states_of(run: RunFolder, grows: bool) -> dict[Key, State]:
    """The states of a run."""
    advances: Counter[tuple[str, str]] = Counter()
    found: dict[Key, State] = {}
    tips, events = run.table("tips").rows(), run.table("events").rows() if grows else []
    for row in run.table("steps").rows():
        mine = [tip for tip in tips if tip["step"] == row["step"]]
        grown = frozenset((*tip, n) for tip, n in advances.items())
        until = (event for event in events if int(event["step"]) <= int(row["step"]))
        grown |= {(event["crack"], "", 0) for event in until if event["kind"] == "initiation"}
        key = grown if grows else frozenset({("", "", int(row["step"]))})
        found[key] = State(
            int(row["step"]),
            float(row["load_factor"]),
            float(row["load_displacement"]),
            int(row["n_dofs"]),
            {(tip["crack"], tip["tip"]): _tip(tip) for tip in mine},
        )
        advances.update((tip["crack"], tip["tip"]) for tip in mine if tip["advanced"] == "true")
    return found


def _tip(row: Mapping[str, str]) -> Tip:
    K_I, K_II, first, second, size = (
        float(row[name]) for name in ("K_I", "K_II", "K_I_error", "K_II_error", "cell_size")
    )
    return Tip((K_I, K_II), max(first, second), size)


@dataclass(frozen=True, slots=True, eq=False)
class Quantity:
    """K of a tip or a number of the whole scene, in one state."""

    step: int  # of the run with the finest cells
    crack: str  # empty: of the whole scene
    tip: str
    name: str  # K_I, K_II (Pa sqrt(m)), load_factor, load_displacement (m)
    values: Mapping[str, float]  # by setting
    order: float  # observed; nan where there is none
    limit: float  # what the values tend to
    rest: float  # what the finest is off by
    size: float  # what errors are shares of: the largest |K| of the step, or the limit

    def error(self, setting: str) -> float:
        """What a setting is off by, over the size."""
        off = abs(self.values[setting] - self.limit)
        return max(off, self.rest) / self.size if self.size > 0.0 else NAN


@dataclass(frozen=True, slots=True)
class Apart:
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
    same_cells: bool  # three settings have the same cells at a tip: nothing can be extrapolated there

    @property
    def worst(self) -> Quantity | None:
        """Where the case's own setting is off by most; None where nothing has a size."""
        own = self.plan.own
        known = [quantity for quantity in self.quantities if not math.isnan(quantity.error(own))]
        return max(known, key=lambda quantity: quantity.error(own), default=None)

    def error(self, setting: str) -> float:
        """The largest of a setting, over all that is known; nan where nothing is."""
        errors = [quantity.error(setting) for quantity in self.quantities if setting in quantity.values]
        return max((error for error in errors if not math.isnan(error)), default=NAN)

    @property
    def path_tolerance(self) -> float:
        """What paths may be apart, over what has grown."""
        return TURNED * self.plan.tolerance

    @property
    def path_of_cells(self) -> Apart | None:
        """How far the own path is from that on the finest cells, or is that of the next where it is these; or None."""
        finest, next_finest = self.plan.settings[-1], self.plan.settings[-2]
        return self.paths.get(next_finest if self.plan.own == finest else self.plan.own)

    @property
    def path_of_increments(self) -> Apart | None:
        """How far the own path is from that of the shortest other increment; None where that was not run."""
        return self.paths.get(self.plan.increments[-1]) if self.plan.increments else None

    @property
    def moves(self) -> dict[str, Apart]:
        """What would move the own path, in words, and by how much; as far as it was run."""
        moves = {"finer cells": self.path_of_cells, "a shorter increment": self.path_of_increments}
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
    states = {
        name: states_of(RunFolder(folders[name]), plan.grows) for name in dict.fromkeys((*plan.settings, plan.own))
    }
    shared = [key for key in states[plan.settings[-1]] if all(key in found for found in states.values())]
    quantities = []
    same_cells = False
    for key in shared:
        mine = {name: found[key] for name, found in states.items()}
        quantities += _quantities(plan, mine)
        same_cells |= _same_cells([mine[name] for name in plan.settings[-3:]])
    all_keys = {key for found in states.values() for key in found}
    return Findings(plan, tuple(quantities), _paths(plan, folders), len(all_keys) - len(shared), same_cells)


def _quantities(plan: TradePlan, mine: Mapping[str, State]) -> list[Quantity]:
    """K of the tips of a state, by setting, and what the whole scene has."""
    three = plan.settings[-3:]
    finest = mine[three[-1]]
    shared = [tip for tip in finest.tips if all(tip in state.tips for state in mine.values())]
    found = [quantity for tip in shared for quantity in _of_tip(tip, three, mine)]
    of_scene = [LOAD] if isinstance(plan.case.loading, CriticalLoad) else []
    sizes = _sizes([mine[name] for name in three])
    for name in (*of_scene, *([] if shared else [DISPLACEMENT])):
        values = {setting: float(getattr(state, name)) for setting, state in mine.items()}
        limit = limit_of([values[setting] for setting in three], sizes)
        size = abs(limit.value)
        found.append(Quantity(finest.step, "", "", name, values, limit.order, limit.value, limit.rest, size))
    return found


def _of_tip(tip: tuple[str, str], three: Sequence[str], states: Mapping[str, State]) -> list[Quantity]:
    """K_I and K_II of a tip; nothing where K is not known."""
    K, finest = {name: state.tips[tip].K for name, state in states.items()}, states[three[-1]]
    if not np.isfinite(list(K.values())).all():
        return []
    sizes = [states[name].tips[tip].cell_size for name in three]
    largest = max(float(np.hypot(*other.K)) for other in finest.tips.values() if np.isfinite(other.K).all())
    found = []
    for mode, name in enumerate(MODES):
        values = {setting: each[mode] for setting, each in K.items()}
        limit = limit_of([values[setting] for setting in three], sizes)
        # where cells are the same nothing is learnt of the error but by the run itself
        rest = limit.rest if distinct(sizes) else max(limit.rest, finest.tips[tip].error)
        found.append(Quantity(finest.step, *tip, name, values, limit.order, limit.value, rest, largest))
    return found


def _sizes(states: Sequence[State]) -> list[float]:
    """Sides of cells that stand for a whole scene: the smallest at any tip, else by the number of unknowns."""
    by_tips = [min((tip.cell_size for tip in state.tips.values()), default=NAN) for state in states]
    unknowns = [1.0 / math.sqrt(state.n_dofs) for state in states]
    return [other if math.isnan(size) else size for size, other in zip(by_tips, unknowns, strict=True)]


def _same_cells(states: Sequence[State]) -> bool:
    tips = set.intersection(*(set(state.tips) for state in states))
    if not tips:
        return not distinct(_sizes(states))
    return any(not distinct([state.tips[tip].cell_size for state in states]) for tip in tips)


def _paths(plan: TradePlan, folders: Mapping[str, Path]) -> dict[str, Apart]:
    """The paths of settings against that on the finest cells, of other increments against the own one."""
    if not plan.grows:
        return {}
    finest = plan.settings[-1]
    pairs = {name: (name, finest) for name in (*plan.settings[:-1], plan.own) if name != finest}
    pairs |= {name: (plan.own, name) for name in plan.increments}
    found = {name: _apart(folders[a], folders[b]) for name, (a, b) in pairs.items()}
    return {name: apart for name, apart in found.items() if apart is not None}


def _apart(first: Path, second: Path) -> Apart | None:
    """How far the paths are apart over what both have grown; None where nothing has grown in both."""
    grown = [pair.common for pair in grown_pairs(first, second) if pair.common is not None]
    apart = [(common.hausdorff, min(common.length_a, common.length_b)) for common in grown]
    if not apart:
        return None
    return Apart(max(d for d, _ in apart), max(d / length for d, length in apart))
