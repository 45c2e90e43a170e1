"""How often cells are halved to meet a target of the error of K, and what is known of that error on them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any

from crackgrow.case.accuracy import UNREFINED

if TYPE_CHECKING:
    from crackgrow.run.configuration import Configuration

AT_KINKS = 2
"""Halvings more at kinks, meetings and ends of a crack than at its tips: they have no functions of their own.

With 3 a closed kink of 30 degrees asked for 1 % reaches the least cells at 1.7 %, with 2 it has 0.86 %; open kinks and
wings are within 3 and 1 % with both, at about the same cost.
"""


@dataclass(frozen=True, slots=True)
class Halvings:
    """Of the lattice's largest cells, beside those that `numerics.refine` asks for."""

    everywhere: int = 0
    cracks: tuple[int, ...] = ()  # crack by crack, besides, at its tips
    corners: int = 0  # besides, at corners of bodies and along supports, loads and interfaces

    def at_tips(self, crack: int) -> int:
        """Of a crack, besides those everywhere."""
        return self.cracks[crack] if self.cracks else 0

    def at_kinks(self, crack: int) -> int:
        """The same of its kinks, meetings and ends."""
        tips = self.at_tips(crack)
        return tips + AT_KINKS if tips else 0

    @property
    def doubled(self) -> Halvings:
        """Of cells all of which are twice as large."""
        return replace(self, everywhere=self.everywhere - 1)


AS_GIVEN = Halvings()
"""Cells as `numerics.refine` has them."""


MOST_AT_FIRST = 7
"""Halvings that a run begins with."""


def first_halvings(target: float, spacing: float, lengths: Iterable[float]) -> Halvings:
    """What to begin with for a target, with cracks of these lengths (m): each halving leaves half of the error."""
    sizes = (max(UNREFINED * spacing / (length * target), 1.0) for length in lengths)
    return Halvings(1, tuple(min(round(math.log2(size)), MOST_AT_FIRST) for size in sizes))


@dataclass(frozen=True, slots=True, eq=False)
class Accuracy:
    """What is known of the error of K on the cells of a step."""

    halvings: Halvings
    ends: tuple[tuple[int, bool], ...]  # tip by tip: its crack, and whether it is the crack's end
    bounds: tuple[float, ...]  # Pa sqrt(m), tip by tip: what K_I and K_II are off by at most; nan where K is
    largest: float  # Pa sqrt(m): |K| of the tip where it is largest
    grown: tuple[float, ...] = ()  # m, crack by crack: what had been added to it when this was measured
    fitted: float = 0.0  # B of `run.doubled_cells` over `largest`, where it is largest
    missed: str = ""  # why the target is out of reach, in words; empty where it is met
    goal: float = math.nan  # what the goal is off by at most, over its largest value; nan where that is K
    doubled: Configuration | None = field(default=None, repr=False)  # that it was measured against, where it is kept

    def shares(self, crack: int | None = None) -> list[float]:
        """Bounds over the largest K, of the tips of one crack or of all, where they are known; or that of the goal."""
        if not math.isnan(self.goal):
            return [self.goal]
        mine = [bound for bound, end in zip(self.bounds, self.ends, strict=True) if crack in (None, end[0])]
        known = [bound for bound in mine if not math.isnan(bound)]
        return [bound / self.largest if self.largest > 0.0 else float("inf") for bound in known]


def record_of(accuracy: Accuracy) -> dict[str, Any]:
    """An accuracy as plain data, which knows no nan."""
    record = {name: getattr(accuracy, name) for name in ("ends", "largest", "grown", "fitted", "missed")}
    record["goal"] = None if math.isnan(accuracy.goal) else accuracy.goal if math.isfinite(accuracy.goal) else "inf"
    record["bounds"] = [None if math.isnan(bound) else bound for bound in accuracy.bounds]
    return {**asdict(accuracy.halvings), **record}


def accuracy_of_record(record: Mapping[str, Any]) -> Accuracy:
    """The accuracy that was written as plain data."""
    return Accuracy(
        Halvings(record["everywhere"], tuple(record["cracks"]), record.get("corners", 0)),
        tuple((crack, at_end) for crack, at_end in record["ends"]),
        tuple(math.nan if bound is None else bound for bound in record["bounds"]),
        record["largest"],
        tuple(record["grown"]),
        record["fitted"],
        record["missed"],
        math.nan if record.get("goal") is None else float(record["goal"]),
    )
