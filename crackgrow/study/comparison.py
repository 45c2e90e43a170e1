"""What comparing two path sets gives: frozen numbers, SI."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from crackgrow.arrays import Floats
from crackgrow.study.path_files import PathSet

Tip = Literal["start", "end"]
Part = Literal["given", "start", "end", "path"]  # "path": of a file that doesn't tell what has grown


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A point of a path."""

    point: Floats  # (2,) m
    s: float  # m, arc length from the part's root (of a tip), from the start otherwise
    step: int | None  # whose advance made the segment; 0 in the given crack, None if not told


@dataclass(frozen=True, slots=True, eq=False)
class Deviation:
    """How far apart two lines are."""

    hausdorff: float  # m, largest distance of a point of either from the other
    frechet: float  # m, the same for points in the order of the paths: at least the Hausdorff distance
    in_a: Place  # where the Hausdorff distance is
    in_b: Place

    @property
    def largest(self) -> float:
        """What is held against a tolerance, m."""
        return max(self.hausdorff, self.frechet)


@dataclass(frozen=True, slots=True, eq=False)
class Common:
    """The part over which two lines run side by side: without what goes on beyond the other's end."""

    length_a: float  # m
    length_b: float  # m
    ends: Floats  # (2, 2) m, on A: where the part begins and ends
    deviation: Deviation


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """One part of one crack in both path sets."""

    crack: str
    part: Part
    length_a: float  # m
    length_b: float  # m
    whole: Deviation | None  # of the whole lengths; None where a file may hold a part of the path only
    end_distance: float | None  # m, between the tips; None like `whole`
    common: Common | None  # None where nothing has grown in A or in B, and of given cracks

    @property
    def deviation(self) -> Deviation:
        """What counts: of the whole lengths, or of the common part where no more is known."""
        if self.whole is not None:
            return self.whole
        if self.common is None:
            raise ValueError("a pair has a whole or a common part")
        return self.common.deviation

    @property
    def name(self) -> str:
        """The crack and its part, for messages."""
        return f"{self.crack} {self.part}" if self.crack else self.part


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """All that is told of two path sets."""

    a: PathSet
    b: PathSet
    pairs: tuple[Pair, ...]
    only_in_a: tuple[str, ...]  # cracks
    only_in_b: tuple[str, ...]
    tolerance: float | None  # m

    @property
    def in_one_only(self) -> tuple[tuple[str, str], ...]:
        """Cracks that A or B alone has: (crack, "A" or "B")."""
        return (*((crack, "A") for crack in self.only_in_a), *((crack, "B") for crack in self.only_in_b))

    @property
    def beyond(self) -> tuple[Pair, ...]:
        """Pairs further apart than the tolerance; none without one."""
        if self.tolerance is None:
            return ()
        return tuple(pair for pair in self.pairs if pair.deviation.largest > self.tolerance)

    @property
    def agrees(self) -> bool:
        """Whether all is within the tolerance, and no crack in one alone; true without a tolerance."""
        return self.tolerance is None or not (self.beyond or self.in_one_only)
