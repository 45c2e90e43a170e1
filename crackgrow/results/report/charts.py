"""The plots against the steps and the load curve, as data that `chart.js` draws."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.results.folder import HISTORY, RunFolder, TextTable
from crackgrow.results.summary import Curve, stress_strain
from crackgrow.results.tables import COMPONENTS
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

ENERGY_COLUMNS = ("work", "strain_energy", "dissipation", "released_energy")
NO_UNIT = ((1.0, ""),)


def charts(run: RunFolder) -> list[Chart]:
    """The plots that tell something: none against the steps where there is but one.

    A chart has title, xlabel, ylabel and series; a series has name, colour, dash, x, y and `steps`, the step of each
    of its points.
    """
    history = list(_history_charts(run))
    if len(run.solved) < 2:
        return history
    by_step = partial(_chart, xlabel="step", x=run.solved, steps=run.solved)
    table = run.table("steps")
    factor, length = table.numbers("load_factor"), table.numbers("crack_length")
    displacement = table.numbers("load_displacement")
    found = [*history, *_tip_charts(run)]
    if len(set(factor.tolist())) > 1:
        size, unit = unit_of(displacement, LENGTHS)
        x, xlabel = rounded_all(displacement, size), f"displacement of the loads [{unit}]"
        load = {"load factor": factor}
        found.append(_chart("Load curve", "load factor", load, NO_UNIT, xlabel=xlabel, x=x, steps=run.solved))
        found.append(by_step("Load factor", "load factor", load, NO_UNIT))
    if curve := _stress_strain(table):
        along, sense, stress, strain = curve
        x, xlabel = rounded_all(strain, 1e-3), f"{sense} strain along {along} [1e-3]"
        what = f"{sense} stress along {along}"
        found.append(_chart("Stress and strain", what, {what: stress}, STRESSES, xlabel=xlabel, x=x, steps=run.solved))
    for title, values in (("Crack length", length), ("Displacement of the loads", displacement)):
        found.append(by_step(title, title.lower(), {title.lower(): values}, LENGTHS))
    energies = {name.replace("_", " "): table.numbers(name) for name in ENERGY_COLUMNS}
    found.append(by_step("Energies", "energy per thickness", energies, ENERGIES))
    if run.case.growth is not None and run.case.growth.subcritical is not None:
        time = table.numbers("time")
        size, unit = unit_of(time, TIMES)
        x, xlabel, grown = rounded_all(time, size), f"time [{unit}]", {"crack length": length}
        found.append(_chart("Growth in time", "crack length", grown, LENGTHS, xlabel=xlabel, x=x, steps=run.solved))
    return found


def _stress_strain(table: TextTable) -> Curve | None:
    """The stress-strain curve of the steps; None where there is none, as of a run by a version before."""
    if "mean_stress_xx" not in table.columns:
        return None
    means = [[table.numbers(f"mean_{what}_{xx}") for xx in COMPONENTS] for what in ("stress", "strain")]
    return stress_strain(*(np.array(mean).T.tolist() for mean in means))


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
        ("Criticality", ("criticality",), NO_UNIT),
    ):
        values = [run.table("tips").numbers(column) for column in columns]
        if not np.isfinite(values).any():
            continue
        unit = unit_of(np.concatenate(values), units)
        series = []
        for number, tip in enumerate(tips):
            steps = tables[tip].steps().tolist()
            for column, dash in zip(columns, ("", "5 3"), strict=False):
                y = rounded_all(tables[tip].numbers(column), unit[0])
                series.append(_series(f"{column} {' '.join(tip)}", COLOURS[number], dash, steps, y, steps))
        ylabel = f"{', '.join(columns)} [{unit[1]}]" if unit[1] else columns[0]
        found.append({"title": f"{title}{rest}", "xlabel": "step", "ylabel": ylabel, "series": series})
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
        drawn = {column: table.numbers(column) for column in columns[: len(COLOURS)]}
        rest = f" ({len(drawn)} of {len(columns)})" if len(columns) > len(drawn) else ""
        if drawn:
            dashes = ("",) * len(COLOURS)
            yield _chart(f"{title}{rest}", "", drawn, units, xlabel="step", x=x, steps=steps.tolist(), dashes=dashes)


def _chart(
    title: str,
    what: str,
    columns: Mapping[str, Floats],
    units: Sequence[Unit],
    *,
    xlabel: str,
    x: Sequence[float | None],
    steps: Sequence[int],
    dashes: Sequence[str] = ("", "5 3", "", ""),
) -> Chart:
    """Columns (n,) by name over x (n,), in one unit."""
    size, unit = unit_of(np.concatenate(list(columns.values())), units)
    lines = zip(columns.items(), COLOURS, dashes, strict=False)
    series = [_series(name, colour, dash, x, rounded_all(y, size), steps) for (name, y), colour, dash in lines]
    ylabel = f"{what} [{unit}]".strip() if unit else what
    return {"title": title, "xlabel": xlabel, "ylabel": ylabel, "series": series}


def _series(
    name: str, colour: str, dash: str, x: Sequence[float | None], y: Sequence[float | None], steps: Sequence[int]
) -> dict[str, Any]:
    return {"name": name, "colour": colour, "dash": dash, "x": list(x), "y": list(y), "steps": list(steps)}
