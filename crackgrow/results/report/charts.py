"""The plots against the steps and the curves over each other, as data that `chart.js` draws, and figures of the run.

A chart has title, xlabel, ylabel and series; a series has name, colour, dash, x, y and `steps`, the step of each of its
points. One that is `marks` is no line.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Fatigue, Stages
from crackgrow.results.atomic import FolderError
from crackgrow.results.run import Run
from crackgrow.results.tables import COMPONENTS
from crackgrow.results.units import ENERGIES, FORCES, INTENSITIES, LENGTHS, STRESSES, TIMES, Unit, rounded_all, unit_of

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
EMISSIONS = {"break": "bonds break", "slip": "faces slip", "opening": "faces open", "growth": "tips grow"}
"""Kinds of events that happen on the way of the loads, in words."""
DISPLACEMENT = "displacement of the loads"
STEADY = 1e-6  # of the largest stress: one that varies by less is the same in all steps, but for round-off


def charts(run: Run) -> list[Chart]:
    """The plots that tell something: none against the steps where there is but one."""
    found = list(_history_charts(run))
    if len(run.solved) < 2:
        return found
    table, steps = run.table("steps"), run.solved
    length, way = {"crack length": table["crack_length"]}, {DISPLACEMENT: table["load_displacement"]}
    found += _tip_charts(run)
    for curve in load_curves(run)[:1]:
        label = curve["ylabel"]
        found += [curve, _chart(label.capitalize(), label, {label: table["load_factor"]}, NO_UNIT, steps)]
    found += filter(None, [stress_strain(run)])
    found += [_chart("Crack length", "crack length", length, LENGTHS, steps)]
    found += [_chart(DISPLACEMENT.capitalize(), DISPLACEMENT, way, LENGTHS, steps)]
    energies = {name.replace("_", " "): table[name] for name in ENERGY_COLUMNS}
    found.append(_chart("Energies", "energy per thickness", energies, ENERGIES, steps))
    if events := event_energies(run):
        found.append(_chart("Energy of events", "energy per thickness", events, ENERGIES, steps))
    if run.case.rate_law is not None:
        cycles = isinstance(run.case.rate_law, Fatigue)
        clock = ("cycles", table["cycles"], NO_UNIT) if cycles else ("time", table["time"], TIMES)
        found.append(_chart(f"Growth in {clock[0]}", "crack length", length, LENGTHS, steps, over=clock))
    return found


def load_curves(run: Run) -> list[Chart]:
    """The load factor over the displacement of the loads, and over what cracks make of it; none where it is constant.

    That is how much they grow where they do, else the slip of the surface that slips most.
    """
    table = run.table("steps")
    factor, length = table["load_factor"], table["crack_length"]
    if len(set(factor.tolist())) < 2:
        return []
    ways = {DISPLACEMENT: table["load_displacement"]}
    ways |= {"crack growth": length - length[0]} if length[-1] > length[0] else _most_slip(run)
    label = "stages that are over" if isinstance(run.case.loading, Stages) else "load factor"
    return [
        _chart("Load curve", label, {label: factor}, NO_UNIT, run.solved, over=(name, way, LENGTHS))
        for name, way in ways.items()
    ]


def _most_slip(run: Run) -> dict[str, Floats]:
    """Slip (m) step by step of the surface that slips most, and what to call it; none without slip.

    nan where the surface is gone with the rock beside it.
    """
    slips: dict[str, Floats] = {}
    for (name, step), points in run.table("contact").by("crack", "step").items():
        slip = points["slip"]
        of_steps = slips.setdefault(name, np.full(len(run.solved), np.nan))
        of_steps[run.solved.index(step)] = slip[np.argmax(np.abs(slip))]
    sizes = {name: float(np.nan_to_num(np.abs(slip)).max()) for name, slip in slips.items()}
    largest = max(sizes, key=lambda name: sizes[name], default="")
    return {f"largest slip of {largest}": slips[largest]} if sizes.get(largest) else {}


def stress_strain(run: Run) -> Chart | None:
    """Mean stress over mean strain, along the axis with the larger stress, positive in the sense of the largest one.

    None where that stress hardly varies.
    """
    table = run.table("steps")
    stress, strain = (np.array([table[f"mean_{of}_{xx}"] for xx in COMPONENTS]) for of in ("stress", "strain"))
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
    x, y = sign * strain[axis], sign * stress[axis]
    over = (along.replace("stress", "strain"), x, STRAINS)
    chart = _chart(title, along, {along: y}, STRESSES, run.solved, over=over)
    for (kind, words), colour in zip(EMISSIONS.items(), COLOURS[1:], strict=False):
        steps, places = _beginnings(run, kind, np.stack([x, y]))
        if steps:
            at = {name: rounded_all(of, by) for name, of, by in zip("xy", places, (STRAINS[0][0], size), strict=True)}
            chart["series"].append(
                {"name": f"first: {words}", "colour": colour, "dash": "", "steps": steps, "marks": True, **at}
            )
    return chart


def _beginnings(run: Run, kind: str, curve: Floats) -> tuple[list[int], Floats]:
    """Steps (n,) and places (2, n) on a curve (2, steps) at which a kind of event first happens to each surface or tip.

    Between two loads curves are straight. A step of growth begins unloaded: where held loads act alone, and beyond its
    last load, is not known.
    """
    factor, grows = run.table("steps")["load_factor"], run.case.growth is not None
    rest = np.full(2, np.nan if any(load.held for load in run.case.loads) else 0.0)
    steps, places = [], []
    for (of_kind, *_), events in run.table("events").by("kind", "crack", "tip").items():
        if of_kind != kind:
            continue
        k, at = run.solved.index(events["step"][0]), float(events["load_factor"][0])
        first = grows or k == 0
        before, start = (0.0, rest) if first else (factor[k - 1], curve[:, k - 1])
        share = (at - before) / (factor[k] - before) if factor[k] != before else 1.0
        on_the_way = curve[:, k] if share == 1.0 else start + share * (curve[:, k] - start)
        places.append(on_the_way if 0.0 <= share <= 1.0 else np.full(2, np.nan))
        steps.append(run.solved[k])
    return steps, np.array(places).T


def event_energies(run: Run) -> dict[str, Floats]:
    """Energy (J/m) of the events of each kind, step by step; of kinds that have any."""
    table, steps = run.table("events"), np.array(run.solved)
    energy, kinds, found = np.nan_to_num(table["energy"]), table["kind"], dict[str, Floats]()
    for kind, words in EMISSIONS.items():
        mine = (kinds == kind) & np.isin(table["step"], steps)
        if energy[mine].any():
            found[words] = np.zeros(len(steps))
            np.add.at(found[words], np.searchsorted(steps, table["step"][mine]), energy[mine])
    return found


def _tip_charts(run: Run) -> list[Chart]:
    """What is at the tips, those that have grown most first."""
    tables = run.table("tips").by("crack", "tip")
    tips = sorted(tables, key=lambda tip: -tables[tip]["advanced"].sum())[:MOST_TIPS]
    rest = f" ({len(tips)} of {len(tables)} tips)" if len(tables) > len(tips) else ""
    found = []
    for title, columns, units in (
        ("Stress intensity", ("K_I", "K_II"), INTENSITIES),
        ("Stress at the tips", ("sigma_1", "sigma_3"), STRESSES),
        ("Criticality", ("criticality",), NO_UNIT),
    ):
        values = [run.table("tips")[column] for column in columns]
        if not np.isfinite(values).any():
            continue
        unit = unit_of(np.concatenate(values), units)
        series = []
        for number, tip in enumerate(tips):
            steps = tables[tip]["step"].tolist()
            for column, dash in zip(columns, ("", "5 3"), strict=False):
                y = rounded_all(tables[tip][column], unit[0])
                line = {"name": f"{column} {' '.join(tip)}", "colour": COLOURS[number], "dash": dash}
                series.append({**line, "x": steps, "y": y, "steps": steps})
        ylabel = f"{', '.join(columns)} [{unit[1]}]" if unit[1] else columns[0]
        found.append({"title": f"{title}{rest}", "xlabel": "step", "ylabel": ylabel, "series": series})
    return found


def _history_charts(run: Run) -> Iterator[Chart]:
    """What the case's points see, increment by increment: those of a step at fractions of it."""
    if not run.case.output.points or not run.solved:
        return
    try:
        table = run.table("history")
    except FolderError:  # somebody has taken it away
        return
    if table.n_rows < 2:
        return
    steps, increment = table["step"], table["increment"]
    n_in_step = np.array([(steps == step).sum() for step in steps.tolist()])
    place = ("step", steps - 1.0 + (increment + 1.0) / n_in_step, NO_UNIT)
    for title, endings, units in HISTORIES:
        columns = [column for column in table if column.rpartition(".")[2] in endings]
        drawn = {column: table[column] for column in columns[: len(COLOURS)]}
        rest = f" ({len(drawn)} of {len(columns)})" if len(columns) > len(drawn) else ""
        if drawn:
            dashes = ("",) * len(COLOURS)
            yield _chart(f"{title}{rest}", "", drawn, units, steps.tolist(), over=place, dashes=dashes)


def _chart(
    title: str,
    what: str,
    columns: Mapping[str, Floats],
    units: Sequence[Unit],
    steps: Sequence[int],
    *,
    over: tuple[str, Floats, Sequence[Unit]] | None = None,
    dashes: Sequence[str] = ("", "5 3", "", ""),
) -> Chart:
    """Columns (n,) by name in one unit, over another column with its name and units, or else over the steps (n,)."""
    x, xlabel = list[Any](steps), "step"
    if over is not None:
        name, values, choice = over
        size, unit = unit_of(values, choice)
        x, xlabel = rounded_all(values, size), f"{name} [{unit}]" if unit else name
    size, unit = unit_of(np.concatenate(list(columns.values())), units)
    series = [
        {"name": name, "colour": colour, "dash": dash, "x": x, "y": rounded_all(y, size), "steps": list(steps)}
        for (name, y), colour, dash in zip(columns.items(), COLOURS, dashes, strict=False)
    ]
    ylabel = f"{what} [{unit}]".strip() if unit else what
    return {"title": title, "xlabel": xlabel, "ylabel": ylabel, "series": series}
