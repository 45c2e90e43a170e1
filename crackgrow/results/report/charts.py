"""The plots against the steps and the load curve, as data that `chart.js` draws."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Stages
from crackgrow.results.folder import HISTORY, RunFolder
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
STRAINS = ((1e-3, "1e-3"),)
DISPLACEMENT = "displacement of the loads"
STEADY = 1e-6  # of the largest stress: one that varies by less is the same in all steps, but for round-off


def charts(run: RunFolder) -> list[Chart]:
    """The plots that tell something: none against the steps where there is but one.

    A chart has title, xlabel, ylabel and series; a series has name, colour, dash, x, y and `steps`, the step of each
    of its points.
    """
    found = list(_history_charts(run))
    if len(run.solved) < 2:
        return found
    by_step = partial(_chart, xlabel="step", x=run.solved, steps=run.solved)
    table = run.table("steps")
    length = table.numbers("crack_length")
    found += _tip_charts(run)
    for load_curve in load_curves(run)[:1]:
        label = load_curve["ylabel"]
        found += [load_curve, by_step(label.capitalize(), label, {label: table.numbers("load_factor")}, NO_UNIT)]
    if curve := stress_strain(run):
        found.append(curve)
    for title, values in (("Crack length", length), (DISPLACEMENT.capitalize(), table.numbers("load_displacement"))):
        found.append(by_step(title, title.lower(), {title.lower(): values}, LENGTHS))
    energies = {name.replace("_", " "): table.numbers(name) for name in ENERGY_COLUMNS}
    found.append(by_step("Energies", "energy per thickness", energies, ENERGIES))
    if run.case.growth is not None and run.case.growth.subcritical is not None:
        time, grown = {"time": table.numbers("time")}, {"crack length": length}
        found.append(_over("Growth in time", "crack length", grown, LENGTHS, time, TIMES, run.solved))
    return found


def load_curves(run: RunFolder) -> list[Chart]:
    """The load factor over the displacement of the loads, and over what cracks make of it; none where it is constant.

    That is how much they grow where they do, else the slip of the surface that slips most.
    """
    table = run.table("steps")
    factor, length = table.numbers("load_factor"), table.numbers("crack_length")
    if len(set(factor.tolist())) < 2:
        return []
    grown = {"crack growth": length - length[0]} if length[-1] > length[0] else _most_slip(run)
    label = "stages that are over" if isinstance(run.case.loading, Stages) else "load factor"
    return [
        _over("Load curve", label, {label: factor}, NO_UNIT, {name: way}, LENGTHS, run.solved)
        for name, way in ({DISPLACEMENT: table.numbers("load_displacement")} | grown).items()
    ]


def _most_slip(run: RunFolder) -> dict[str, Floats]:
    """Slip (m) step by step of the surface that slips most, and what to call it; none without slip.

    nan where the surface is gone with the rock beside it.
    """
    slips: dict[str, Floats] = {}
    for (name, step), points in run.table("contact").by("crack", "step").items():
        slip = points.numbers("slip")
        slips.setdefault(name, np.full(len(run.solved), np.nan))[run.solved.index(int(step))] = slip[
            np.argmax(np.abs(slip))
        ]
    largest = max(slips, key=lambda name: float(np.nanmax(np.abs(slips[name]))), default="")
    return {f"largest slip of {largest}": slips[largest]} if largest and np.nan_to_num(slips[largest]).any() else {}


def stress_strain(run: RunFolder) -> Chart | None:
    """Mean stress over mean strain, along the axis with the larger stress, positive in the sense of the largest one.

    None where that stress hardly varies, or is not there, as of a run by a version before.
    """
    table = run.table("steps")
    if "mean_stress_xx" not in table.columns:
        return None
    stress, strain = (np.array([table.numbers(f"mean_{of}_{xx}") for xx in COMPONENTS]) for of in ("stress", "strain"))
    sizes = np.nan_to_num(np.abs(stress)).max(axis=1, initial=0.0)
    axis = int(np.argmax(sizes[:2]))
    known = stress[axis][np.isfinite(stress[axis])]
    if not len(known) or not np.ptp(known) > STEADY * sizes.max():
        return None
    sense = "compressive" if known[np.argmax(np.abs(known))] < 0.0 else "tensile"
    sign = -1.0 if sense == "compressive" else 1.0
    along = f"{sense} stress along {'xy'[axis]}"
    size, unit = unit_of(stress[axis].tolist(), STRESSES)
    peak = int(np.nanargmax(sign * stress[axis]))
    title = f"Stress and strain, peak {sign * stress[axis][peak] / size:.4g} {unit} at step {run.solved[peak]}"
    over = {along.replace("stress", "strain"): sign * strain[axis]}
    return _over(title, along, {along: sign * stress[axis]}, STRESSES, over, STRAINS, run.solved)


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


def _over(
    title: str,
    what: str,
    columns: Mapping[str, Floats],
    units: Sequence[Unit],
    over: Mapping[str, Floats],
    units_over: Sequence[Unit],
    steps: Sequence[int],
) -> Chart:
    """As `_chart`, over one column (n,) by name in one of some units."""
    ((name, values),) = over.items()
    size, unit = unit_of(values, units_over)
    x = rounded_all(values, size)
    return _chart(title, what, columns, units, xlabel=f"{name} [{unit}]", x=x, steps=steps)


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
