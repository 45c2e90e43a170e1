"""The scenes that the axes are tried on: cases of the folder `cases`, static, with settings of their own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TypeVar

from crackgrow.case import load_case
from crackgrow.case.model import Case
from tests.stability.solved import Solved, solved

T = TypeVar("T")

CASES = Path(__file__).resolve().parents[3] / "cases"
FLAW, FOUNDATION, RIGID = (CASES / f"{name}.yaml" for name in ("compression30", "block_foundation", "block_rigid"))

COARSE, USUAL = 3.0, 1.5  # mm, spacings of the flaw's lattice


@dataclass(frozen=True, slots=True, eq=False)
class Scenes:
    """Cases with settings. A scene at its usual values, which others are held against, is solved once and kept."""

    short: bool  # coarse, and few values of every axis
    _kept: dict[tuple[object, ...], Solved] = field(default_factory=dict)

    def flaw(self, *settings: str) -> Case:
        """The closed flaw before growth; the stress at a tip is averaged over 2 mm, more than half of any spacing."""
        usual = (f"numerics.spacing={COARSE if self.short else USUAL}", "growth.steps=0", "growth.tip_stress.radius=2")
        return load_case(FLAW, [*usual, *settings])

    def solved_flaw(self, *settings: str) -> Callable[[], Solved]:
        """What solves the flaw with settings."""
        return lambda: solved(self.flaw(*settings))

    def usual_flaw(self, *settings: str) -> Callable[[], Solved]:
        """The same, kept."""
        return partial(self._keep, (FLAW, *settings), self.solved_flaw(*settings))

    def solved_case(self, path: Path, *settings: str) -> Callable[[], Solved]:
        """What solves a case with settings."""
        return lambda: solved(load_case(path, settings))

    def usual_case(self, path: Path, *settings: str) -> Callable[[], Solved]:
        """The same, kept."""
        return partial(self._keep, (path, *settings), self.solved_case(path, *settings))

    def few(self, values: tuple[T, ...], short: tuple[T, ...]) -> tuple[T, ...]:
        """The values of an axis."""
        return short if self.short else values

    def _keep(self, key: tuple[object, ...], solve: Callable[[], Solved]) -> Solved:
        if key not in self._kept:
            self._kept[key] = solve()
        return self._kept[key]
