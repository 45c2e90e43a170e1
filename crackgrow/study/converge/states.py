"""The states of a run that can be held against those of another: its steps, by how often each tip has grown until then.

Where scenes are nearly symmetric the tips of two runs take turns in another order. States in which all have grown as
often, and the same cracks have started, are the same ones.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from crackgrow.results.folder import RunFolder

Key = frozenset[tuple[str, str, int]]
"""Crack, end and number of advances of all tips that have grown; of a crack that has started its name and zero; of a
scene without growth the number of the step."""


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
