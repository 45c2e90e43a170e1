"""Ratios of now against those of a stored baseline."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.benchmarks.tables import table

Ratios = Mapping[str, Mapping[str, float]]
"""Run by run, then ratio by ratio: the larger the worse."""

WORSE = 1.25
"""Ratios that have grown by more than this factor are marked; run to run they differ by up to 15 %."""


@dataclass(frozen=True, slots=True)
class Change:
    """One ratio now and in the baseline."""

    run: str
    ratio: str
    now: float
    before: float

    @property
    def factor(self) -> float:
        """Now over baseline."""
        return self.now / self.before

    @property
    def worse(self) -> bool:
        """Whether it has grown by more than noise."""
        return self.factor > WORSE


def changes(now: Ratios, baseline: Ratios) -> list[Change]:
    """All ratios that both have."""
    return [
        Change(run, name, value, baseline[run][name])
        for run, found in now.items()
        for name, value in found.items()
        if name in baseline.get(run, {})
    ]


def comparison_text(found: Sequence[Change]) -> str:
    """A table of the changes, the worse ones marked, and how many those are."""
    header = ("run", "ratio", "now", "baseline", "now / baseline", "")
    rows = [
        (c.run, c.ratio, f"{c.now:.3g}", f"{c.before:.3g}", f"{c.factor:.2f}", "WORSE" if c.worse else "")
        for c in found
    ]
    n = sum(change.worse for change in found)
    return f"{table(header, rows)}\n{n} of {len(found)} ratios are more than {100 * (WORSE - 1):.0f} % worse\n"


def load_baseline(path: Path) -> dict[str, dict[str, float]]:
    """The stored ratios; none where there is no file."""
    ratios: dict[str, dict[str, float]] = json.loads(path.read_text()) if path.exists() else {}
    return ratios


def store_baseline(path: Path, now: Ratios) -> None:
    """Replace what the baseline has of the runs of `now`, and keep its other runs."""
    merged = {**load_baseline(path), **now}
    rounded = {run: {name: float(f"{value:.4g}") for name, value in found.items()} for run, found in merged.items()}
    path.write_text(json.dumps(rounded, indent=1) + "\n")
