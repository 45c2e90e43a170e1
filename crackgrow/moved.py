"""Names that the package had, called as they were: what does the same now takes its arguments in another form."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from crackgrow.study.trade.plan import Plan


def render(
    folder: Path,
    field: str = "sigma_1",
    warp: float | None = None,
    steps: Sequence[int | range] | None = None,
    size: tuple[int, int] | None = None,
    out: Path | None = None,
) -> Iterator[Path]:
    """Draw a field of the frames of a run: `results.render.render`, with a `Look(warp, size)`."""
    from crackgrow.results.field_picture import Look
    from crackgrow.results.render import render as drawn

    return drawn(folder, field, Look(warp, size), steps, out)


def plan_trade(case: Path, folder: Path, *, overrides: Sequence[str] = (), **more: Any) -> Plan:
    """Plan what accuracy costs: `study.trade.plan.plan_trade`, with a `CaseFile(case, overrides)`."""
    from crackgrow.study.setting import CaseFile
    from crackgrow.study.trade.plan import plan_trade as planned

    return planned(CaseFile(case, tuple(overrides)), folder, **more)
