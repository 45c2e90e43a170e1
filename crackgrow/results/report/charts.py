"""The plots against the steps and the load curve, as data that `chart.js` draws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.results.folder import HISTORY, RunFolder
from crackgrow.results.units import (
    ENERGIES,
    FORCES,
    INTENSITIES,
    LENGTHS,
    STRESSES,
    TIMES,
    Unit,
    rounded_all,
    unit_of,
)

Chart = dict[str, Any]

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b8860b", "#56b4e9")
MOST_TIPS = 6  # that one plot shows
HISTORIES = (
    ("Displacement of points", ("u_x", "u_y"), LENGTHS),
    ("Stress at points", ("stress_xx", "stress_yy", "stress_xy"), STRESSES),
    ("Opening and slip at points", ("opening", "slip"), LENGTHS),
    ("Convergence", ("convergence",), LENGTHS),
    ("Reactions", ("force_x", "force_y"), FORCES),
)
"""Title, what the columns of history.csv end with, and units."""


def charts(run: RunFolder) -> list[Chart]:
    """The plots that tell something: none against the steps where there is but one.

    A chart has title, xlabel, ylabel and series; a series has name, colour, dash, x, y and `steps`, the step of each
    of its points.
    """
    history = list(_history_charts(run))
    if len(run.solved) < 2:
        return history
    factor = run.table("steps").numbers("load_factor")
    found = [*history, *_tip_charts(run)]
    if len(set(factor.tolist())) > 1:
        found.append(_load_curve(run, factor))
        found.append(_by_step(run, "Load factor", "load factor", [("load factor", factor)], (1.0, "")))
    for title, column, units in (
        ("Crack length", "crack_length", LENGTHS),
        ("Displacement of the loads", "load_displacement", LENGTHS),
    ):
        values = run.table("steps").numbers(column)
        unit = unit_of(values, units)
        found.append(_by_step(run, title, f"{title.lower()} [{unit[1]}]", [(title.lower(), values)], unit))
    found.append(_energies(run))
    found.extend(_in_time(run))
    return found


def _in_time(run: RunFolder) -> Iterator[Chart]:
    """How the cracks grow in time, where that takes time."""
    if run.case.growth is None or run.case.growth.subcritical is None:
        return
    table = run.table("steps")
    time, length = table.numbers("time"), table.numbers("crack_length")
    in_time, in_length = unit_of(time, TIMES), unit_of(length, LENGTHS)
    x, y = rounded_all(time, in_time[0]), rounded_all(length, in_length[0])
    series = [_series("crack length", COLOURS[0], "", x, y, run.solved)]
    yield _chart("Growth in time", f"time [{in_time[1]}]", f"crack length [{in_length[1]}]", series)


def drawn_tips(run: RunFolder) -> list[tuple[str, ...]]:
    """The tips that plots show, those that have grown most first: name of the crack, and which end."""
    tips = run.table("tips").by("crack", "tip")
    return sorted(tips, key=lambda tip: -tips[tip].words("advanced").count("true"))[:MOST_TIPS]


def _tip_charts(run: RunFolder) -> list[Chart]:
    tips = drawn_tips(run)
    if not tips:
        return []
    tables = run.table("tips").by("crack", "tip")
    rest = f" ({len(tips)} of {len(tables)} tips)" if len(tables) > len(tips) else ""
    found = []
    for title, columns, units in (
        ("Stress intensity", ("K_I", "K_II"), INTENSITIES),
        ("Stress at the tips", ("sigma_1", "sigma_3"), STRESSES),
    ):
        values = [run.table("tips").numbers(column) for column in columns]
        if not np.isfinite(values).any():
            continue
        unit = unit_of(np.concatenate(values), units)
        series = []
        for number, tip in enumerate(tips):
            steps = tables[tip].steps().tolist()
            for column, dash in zip(columns, ("", "5 3"), strict=True):
                y = rounded_all(tables[tip].numbers(column), unit[0])
                series.append(_series(f"{column} {' '.join(tip)}", COLOURS[number], dash, steps, y, steps))
        found.append(_chart(f"{title}{rest}", "step", f"{', '.join(columns)} [{unit[1]}]", series))
    return found


def _history_charts(run: RunFolder) -> Iterator[Chart]:
    """What the case's points see, increment by increment: those of a step at fractions of it."""
    if not run.case.output.points or not run.has(HISTORY):
        return
    table = run.table("history")
    if len(table) < 2:
        return
    steps, increment = table.steps(), table.numbers("increment")
    n_in_step = np.array([(steps == step).sum() for step in steps.tolist()])
    x = rounded_all(steps - 1.0 + (increment + 1.0) / n_in_step)
    for title, endings, units in HISTORIES:
        columns = [column for column in table.columns if column.rpartition(".")[2] in endings]
        drawn = columns[: len(COLOURS)]
        if not drawn:
            continue
        values = [table.numbers(column) for column in drawn]
        unit = unit_of(np.concatenate(values), units)
        series = [
            _series(column, colour, "", x, rounded_all(of_column, unit[0]), steps.tolist())
            for column, colour, of_column in zip(drawn, COLOURS, values, strict=False)
        ]
        rest = f" ({len(drawn)} of {len(columns)})" if len(columns) > len(drawn) else ""
        yield _chart(f"{title}{rest}", "step", f"[{unit[1]}]", series)


def _load_curve(run: RunFolder, factor: Floats) -> Chart:
    displacement = run.table("steps").numbers("load_displacement")
    unit = unit_of(displacement, LENGTHS)
    x = rounded_all(displacement, unit[0])
    series = [_series("load factor", COLOURS[0], "", x, rounded_all(factor), run.solved)]
    return _chart("Load curve", f"displacement of the loads [{unit[1]}]", "load factor", series)


def _energies(run: RunFolder) -> Chart:
    names = ("work", "strain_energy", "dissipation", "released_energy")
    values = [(name.replace("_", " "), run.table("steps").numbers(name)) for name in names]
    unit = unit_of(np.concatenate([column for _, column in values]), ENERGIES)
    return _by_step(run, "Energies", f"energy per thickness [{unit[1]}]", values, unit)


def _by_step(run: RunFolder, title: str, label: str, columns: Sequence[tuple[str, Floats]], unit: Unit) -> Chart:
    series = [
        _series(name, colour, dash, run.solved, rounded_all(values, unit[0]), run.solved)
        for (name, values), colour, dash in zip(columns, COLOURS, ("", "5 3", "", ""), strict=False)
    ]
    return _chart(title, "step", label, series)


def _chart(title: str, xlabel: str, ylabel: str, series: Sequence[dict[str, Any]]) -> Chart:
    return {"title": title, "xlabel": xlabel, "ylabel": ylabel, "series": list(series)}


def _series(
    name: str, colour: str, dash: str, x: Sequence[float | None], y: Sequence[float | None], steps: Sequence[int]
) -> dict[str, Any]:
    return {"name": name, "colour": colour, "dash": dash, "x": list(x), "y": list(y), "steps": list(steps)}
