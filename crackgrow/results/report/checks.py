"""How good a run is: its worst checks with their limits, and what it estimates of its error."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from markupsafe import Markup

from crackgrow.arrays import Floats
from crackgrow.results.folder import RunFolder
from crackgrow.results.report.scene import tag
from crackgrow.results.units import shown
from crackgrow.run.result import CHECK_LIMITS

WHAT = {
    "residual": "equilibrium residual",
    "penetration": "penetration at contact points, by the step's largest jump",
    "complementarity": "complementarity of contact",
    "overlap_share": "overlap anywhere along the faces, by what is small beside jump and displacement",
    "energy_error": "error of the energy balance",
}

ESTIMATES = {
    "energy_norm_percent, first": "energy norm, first step [%]",
    "energy_norm_percent, last": "energy norm, last step [%]",
    "K_percent_expected": "K, error that is expected, over the largest K of its step [%]",
    "K_percent_at_most": "K, error at most, over the largest K of its step [%]",
    "K_spread_percent": "spread of K over discs of its integral, not its error [%]",
    "kink_degrees_at_most": "directions of growth, at most [°]",
    "load_factor_percent_at_most": "critical load factors, at most [%]",
    "goal_percent_at_most": "numerics.goal, at most, over its largest value [%]",
}
"""Numbers of the summary in the order of the table, in words."""


def check_rows(run: RunFolder) -> Iterator[tuple[object, ...]]:
    """Rows of the table of checks: name, worst value, step, limit, verdict."""
    jumps = _largest_jumps(run)
    for name, words in WHAT.items():
        values = np.abs(run.table("steps").numbers(name))
        if name == "penetration":
            values = np.divide(values, jumps, out=np.zeros_like(values), where=jumps > 0.0)
        if len(values) == 0:
            continue
        worst = int(np.argmax(np.where(np.isnan(values), np.inf, values)))
        good = bool(values[worst] <= CHECK_LIMITS[name])
        verdict = tag("span", "ok" if good else "above the limit", class_="good" if good else "bad")
        yield words, shown(float(values[worst]), 3), run.solved[worst], f"{CHECK_LIMITS[name]:g}", verdict


def estimate_rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Rows of what the run estimates of its own error, the worst of all steps: any numbers that the summary has."""
    known = dict(_flat(summary.get("error_estimate") or {}, ""))
    order = [*(name for name in ESTIMATES if name in known), *(name for name in known if name not in ESTIMATES)]
    return [(ESTIMATES.get(name, name), known[name]) for name in order]


def _flat(values: dict[str, Any], before: str) -> Iterator[tuple[str, str]]:
    for key, value in values.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{key}, ")
        else:
            yield f"{before}{key}", value if isinstance(value, str) else shown(math.nan if value is None else value)


def _largest_jumps(run: RunFolder) -> Floats:
    """Largest jump (m) at the contact points of each solved step; 0 where there are none."""
    contact = run.table("contact")
    steps = contact.steps()
    sizes = np.hypot(contact.numbers("opening"), contact.numbers("slip"))
    largest = np.zeros(len(run.solved))
    np.maximum.at(largest, np.searchsorted(run.solved, steps), sizes)
    return largest


def status_badge(status: str) -> Markup:
    """How the run ended, in a word."""
    kind = {"failed": "bad", "interrupted": "doubtful", "running": "doubtful"}.get(status, "good")
    return tag("strong", status, class_=f"badge {kind}")
