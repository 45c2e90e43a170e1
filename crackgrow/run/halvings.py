"""How often cells are halved to meet a target of the error of K or to measure it, and what is known of it on them."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

from crackgrow.case.accuracy import FIRST_HALVINGS, UNREFINED

if TYPE_CHECKING:
    from crackgrow.run.configuration import Configuration

AT_KINKS = 3
"""Halvings more at kinks of a crack than at its tips: they have no functions of their own.

The error of cracks that are closed at a kink falls with the cells there, whatever those at the tips are.
"""

AT_ENDS = 2
"""The same at meetings and at ends that are no tips."""


Place = tuple[float, float, float, float, int]
"""A straight stretch, x and y of its ends in m, and halvings of the cells along it."""


@dataclass(frozen=True, slots=True)
class Halvings:
    """Of the lattice's largest cells, beside those that `numerics.refine` asks for."""

    everywhere: int = 0
    cracks: tuple[int, ...] = ()  # crack by crack, besides, at its tips
    corners: int = 0  # besides, at corners of bodies and along supports, loads and interfaces
    kinks: int = 0  # besides, at kinks of cracks
    places: tuple[Place, ...] = ()  # besides, where faces part

    def at_tips(self, crack: int) -> int:
        """Of a crack, besides those everywhere."""
        return self.cracks[crack] if self.cracks else 0

    def at_kinks(self, crack: int) -> int:
        """The same of its kinks."""
        tips = self.at_tips(crack)
        return self.kinks + (tips + AT_KINKS if tips else 0)

    def at_ends(self, crack: int) -> int:
        """The same of its meetings, and of its ends that are no tips."""
        tips = self.at_tips(crack)
        return tips + AT_ENDS if tips else 0

    def finer_at_kinks(self, crack: int, others: Halvings) -> int:
        """How much more often cells at kinks of a crack are halved than `others` are, all sizes counted."""
        return self.everywhere + self.at_kinks(crack) - others.everywhere - others.at_kinks(crack)

    def finer_at_tips(self, crack: int, others: Halvings) -> int:
        """The same of cells at its tips."""
        return self.everywhere + self.at_tips(crack) - others.everywhere - others.at_tips(crack)

    @property
    def doubled(self) -> Halvings:
        """Of cells all of which are twice as large."""
        return replace(self, everywhere=self.everywhere - 1)

    def compared(self, more: int) -> Halvings:
        """Of cells that K is held against: twice as large, but halved some times `more` at kinks."""
        return replace(self.doubled, kinks=self.kinks + 1 + more)


AS_GIVEN = Halvings()
"""Cells as `numerics.refine` has them."""


def half_as_large(n_cracks: int, more: int) -> Halvings:
    """Of cells half as large as those at all places that ask for some, and halved some times `more` at kinks."""
    return Halvings(cracks=(1,) * n_cracks, corners=1, kinks=more - AT_KINKS - 1)


def first_halvings(target: float, spacing: float, cracks: Iterable[tuple[float, bool]]) -> Halvings:
    """What to begin with for a target, with cracks of these lengths (m) that have sharp kinks or not.

    Each halving leaves half of the error. With the first one come those at kinks, without which it is no smaller.
    """
    return Halvings(1, tuple(_at_first(target, spacing, *crack) for crack in cracks))


def with_started(halvings: Halvings, target: float, spacing: float, lengths: Iterable[float]) -> Halvings:
    """The same with cracks that start, of these lengths (m)."""
    return replace(halvings, cracks=(*halvings.cracks, *(_at_first(target, spacing, each, False) for each in lengths)))


def _at_first(target: float, spacing: float, length: float, kinked: bool) -> int:
    size = max(UNREFINED * spacing / (length * target), 1.0)
    return min(max(round(math.log2(size)), int(kinked)), FIRST_HALVINGS)


@dataclass(frozen=True, slots=True, eq=False)
class Accuracy:
    """What is known of the error of K on the cells of a step."""

    halvings: Halvings
    ends: tuple[tuple[int, bool], ...]  # tip by tip: its crack, and whether it is the crack's end
    bounds: tuple[float, ...]  # Pa sqrt(m), tip by tip: what K_I and K_II are off by at most; nan where K is
    largest: float  # Pa sqrt(m): |K| of the tip where it is largest
    grown: tuple[float, ...] = ()  # m, crack by crack: what had been added to it when this was measured
    fitted: float = 0.0  # B of `run.other_cells` over `largest`, where it is largest
    missed: str = ""  # why the target is out of reach, in words; empty where it is met
    goal: float = math.nan  # what the goal is off by at most, over its largest value; nan where that is K
    compared: Configuration | None = field(default=None, repr=False)  # that it was measured against, where it is kept
    expected: tuple[float, ...] = ()  # Pa sqrt(m), like bounds: what K_I and K_II together are off by, most likely
    rooms: tuple[float, ...] = ()  # m, like bounds: to what lies nearest to the tip when this was measured; or nan
    age: int = 0  # steps since this was measured
    turns: tuple[float, ...] = ()  # rad, like bounds: by what the direction of growth was another there; nan: not known
    criticalities: tuple[float, ...] = ()  # the same of the criticality, of itself; of a load that bonds break at
    jumps: bool = False  # whether they do: the other cells had their own load then
    widened: tuple[float, ...] = ()  # tip by tip: how much wider bounds are than as measured; nothing: they are not
    coarser: tuple[int, ...] = ()  # crack by crack: how often its cells have been doubled since; nothing: never

    def shares(self, crack: int | None = None) -> list[float]:
        """Bounds over the largest K, of the tips of one crack or of all, where they are known; or that of the goal."""
        if not math.isnan(self.goal):
            return [self.goal]
        mine = [bound for bound, end in zip(self.bounds, self.ends, strict=True) if crack in (None, end[0])]
        known = [bound for bound in mine if not math.isnan(bound)]
        return [bound / self.largest if self.largest > 0.0 else float("inf") for bound in known]


def record_of(accuracy: Accuracy) -> dict[str, Any]:
    """An accuracy as plain data, whose numbers may be nan."""
    kept = {part.name: getattr(accuracy, part.name) for part in fields(accuracy) if part.name != "compared"}
    record: dict[str, Any] = json.loads(json.dumps({**kept, "halvings": asdict(accuracy.halvings)}))
    return record


def accuracy_of_record(record: Mapping[str, Any]) -> Accuracy:
    """The accuracy that was written as plain data."""
    halvings = Halvings(**{name: _as_tuples(value) for name, value in record["halvings"].items()})
    return Accuracy(**{**{name: _as_tuples(value) for name, value in record.items()}, "halvings": halvings})


def _as_tuples(value: Any) -> Any:
    return tuple(map(_as_tuples, value)) if isinstance(value, list) else value
