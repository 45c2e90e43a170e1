"""Names of the columns of a sweep's table."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from crackgrow.case.model import Case

FIRST: Final = ("run", "folder")
ENDING: Final = ("status", "reason")
COSTS: Final = (
    "steps", "load_factor", "n_dofs", "seconds", "peak_memory_mb", "energy_error_percent", "K_spread_percent",
)  # fmt: skip
TAKEN: Final = frozenset({*FIRST, *ENDING, *COSTS})  # no parameter can be called so
OF_TIPS: Final = ("K_I_first", "K_II_first", "K_I_last", "K_II_last", "x", "y")
"""After CRACK.TIP: Pa sqrt(m) at the first and at the last step, and the end of its path, m."""


def tip_columns(case: Case) -> list[str]:
    """Columns of all ends that can grow."""
    ends = [(crack, end) for crack in case.cracks for end in ("start", "end") if getattr(crack, f"tip_at_{end}")]
    return [f"{crack.name}.{end}.{what}" for crack, end in ends for what in OF_TIPS]


def response_columns(cases: Iterable[Case]) -> list[str]:
    """All columns with numbers that runs of these cases may have."""
    return list(dict.fromkeys([*COSTS, *(name for case in cases for name in tip_columns(case))]))
