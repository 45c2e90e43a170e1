"""What the runs tell: K and loads of the states that all have, what they tend to, and what each setting misses.

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
from crackgrow.errors import CaseError
from crackgrow.results.folder import RunFolder
from crackgrow.study.compare import compare_paths
from crackgrow.study.converge.extrapolation import distinct, limit_of
from crackgrow.study.converge.plan import HALF, ConvergencePlan
from crackgrow.study.timed_run import Cost

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
class Ran:
    """A run that has ended."""

    name: str  # of its setting
    folder: Path
    cost: Cost
    n_dofs: int  # of the last step


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

    first: str
    second: str
    distance: float  # m, Hausdorff, of the tip where it is largest
    share: float  # of what has grown there in both, of the tip where that is largest


@dataclass(frozen=True, slots=True, eq=False)
class Convergence:
    """All that was found."""

    plan: ConvergencePlan
    runs: tuple[Ran, ...]
    quantities: tuple[Quantity, ...]
    paths: tuple[Apart, ...]
    left_out: int  # states that some run does not have
    same_cells: bool  # the three settings have the same cells at a tip: nothing can be extrapolated there
    why_no_half: str  # empty where half increments were run, or can't be

    @property
    def worst(self) -> Quantity | None:
        """Where the case's own setting is off by most; None where nothing has a size."""
        own = self.plan.own.name
        known = [quantity for quantity in self.quantities if not math.isnan(quantity.error(own))]
        return max(known, key=lambda quantity: quantity.error(own), default=None)

    def largest_error(self, setting: str) -> float:
        """Of a setting, over all that is known; nan where nothing is."""
        errors = [quantity.error(setting) for quantity in self.quantities]
        return max((error for error in errors if not math.isnan(error)), default=NAN)

    @property
    def good_enough(self) -> bool:
        """Whether the own setting is within the tolerance, and so are its paths."""
        return self.largest_error(self.plan.own.name) <= self.plan.tolerance and self.paths_good_enough

    @property
    def paths_good_enough(self) -> bool:
        """Whether neither the finest cells nor half increments, as far as they were run, move the own path by more."""
        off = [apart.share for apart in (self.path_of_cells, self.path_of_increments) if apart is not None]
        return max(off, default=0.0) <= self.path_tolerance

    @property
    def path_tolerance(self) -> float:
        """What paths may be apart, over what has grown."""
        return TURNED * self.plan.tolerance

    @property
    def path_of_cells(self) -> Apart | None:
        """How far the own path is from that on the finest cells; None without growth."""
        return self.path_of_setting(self.plan.own.name)

    def path_of_setting(self, setting: str) -> Apart | None:
        """How far the path of a setting is from that on the finest cells; None without growth."""
        return self._apart(setting, self.plan.settings[-1].name)

    @property
    def path_of_increments(self) -> Apart | None:
        """How far the own path is from that of half increments; None where that was not run."""
        return self._apart(self.plan.own.name, HALF)

    def _apart(self, first: str, second: str) -> Apart | None:
        if first == second:  # the own cells are the finest: those before say how far they may be off
            first = self.plan.settings[-2].name
        return next((apart for apart in self.paths if {apart.first, apart.second} == {first, second}), None)


def findings(plan: ConvergencePlan, runs: Sequence[Ran], why_no_half: str) -> Convergence:
    """What the runs tell; raises CaseError where paths can't be read."""
    states = {run.name: states_of(RunFolder(run.folder), plan.grows) for run in runs if run.name != HALF}
    three = [setting.name for setting in plan.settings]
    shared = [key for key in states[three[-1]] if all(key in found for found in states.values())]
    quantities = [quantity for key in shared for quantity in _quantities(plan, three, states, key)]
    all_keys = {key for found in states.values() for key in found}
    return Convergence(
        plan,
        tuple(runs),
        tuple(quantities),
        tuple(_paths(plan, runs)),
        len(all_keys) - len(shared),
        any(_same_cells(three, states, key) for key in shared),
        why_no_half,
    )


def _quantities(
    plan: ConvergencePlan, three: Sequence[str], states: Mapping[str, Mapping[Key, State]], key: Key
) -> list[Quantity]:
    """K of the tips of a state that all runs have, and what the whole scene has."""
    mine = {name: found[key] for name, found in states.items()}
    step, tips = mine[three[-1]].step, list(mine[three[-1]].tips)
    shared = [tip for tip in tips if all(tip in state.tips for state in mine.values())]
    found = [quantity for tip in shared for quantity in _of_tip(step, tip, three, mine)]
    of_scene = [LOAD] if isinstance(plan.case.loading, CriticalLoad) else []
    sizes = _sizes(three, mine)
    for name in (*of_scene, *([] if shared else [DISPLACEMENT])):
        values = {setting: float(getattr(state, name)) for setting, state in mine.items()}
        limit = limit_of([values[setting] for setting in three], sizes)
        found.append(Quantity(step, "", "", name, values, limit.order, limit.value, limit.rest, abs(limit.value)))
    return found


def _of_tip(step: int, tip: tuple[str, str], three: Sequence[str], states: Mapping[str, State]) -> list[Quantity]:
    """K_I and K_II of a tip; nothing where K is not known."""
    K = {name: np.array(state.tips[tip].K) for name, state in states.items()}
    if not all(np.isfinite(each).all() for each in K.values()):
        return []
    sizes = [states[name].tips[tip].cell_size for name in three]
    largest = max(_size(other.K) for other in states[three[-1]].tips.values())
    found = []
    for mode, name in enumerate(MODES):
        values = {setting: float(each[mode]) for setting, each in K.items()}
        limit = limit_of([values[setting] for setting in three], sizes)
        # where cells are the same nothing is learnt of the error but by the run itself
        rest = limit.rest if distinct(sizes) else max(limit.rest, states[three[-1]].tips[tip].error)
        found.append(Quantity(step, *tip, name, values, limit.order, limit.value, rest, largest))
    return found


def _size(K: tuple[float, float]) -> float:
    return float(np.hypot(*K)) if np.isfinite(K).all() else 0.0


def _sizes(three: Sequence[str], states: Mapping[str, State]) -> list[float]:
    """Sides of cells that stand for a whole scene: the smallest at any tip, else by the number of unknowns."""
    found = []
    for name in three:
        sizes = [tip.cell_size for tip in states[name].tips.values()]
        found.append(min(sizes) if sizes else 1.0 / math.sqrt(states[name].n_dofs))
    return found


def _same_cells(three: Sequence[str], states: Mapping[str, Mapping[Key, State]], key: Key) -> bool:
    tips = set.intersection(*(set(states[name][key].tips) for name in three))
    if not tips:
        return not distinct(_sizes(three, {name: states[name][key] for name in three}))
    return any(not distinct([states[name][key].tips[tip].cell_size for name in three]) for tip in tips)


def _paths(plan: ConvergencePlan, runs: Sequence[Ran]) -> list[Apart]:
    """The paths of all runs against that on the finest cells, and the own one against that of half increments."""
    if not plan.grows:
        return []
    folders = {run.name: run.folder for run in runs}
    finest = plan.settings[-1].name
    pairs = [(name, finest) for name in folders if name not in (finest, HALF)]
    if HALF in folders:
        pairs.append((plan.own.name, HALF))
    found = [_apart(a, b, folders) for a, b in pairs]
    return [apart for apart in found if apart is not None]


def _apart(first: str, second: str, folders: Mapping[str, Path]) -> Apart | None:
    """How far the paths are apart over what both have grown; None where nothing has grown in both."""
    try:
        pairs = compare_paths(folders[first], folders[second]).pairs
    except CaseError:  # a scene without cracks
        return None
    grown = [pair.common for pair in pairs if pair.part in ("start", "end") and pair.common is not None]
    apart = [(common.deviation.hausdorff, min(common.length_a, common.length_b)) for common in grown]
    if not apart:
        return None
    return Apart(first, second, max(d for d, _ in apart), max(d / length for d, length in apart))
