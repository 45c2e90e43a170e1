"""Pictures of a run: the crack paths, the stress on the displaced specimen, the contacts, the load over the steps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.case.on_map import case_on_map, extent, length_unit
from crackgrow.results.atomic import write_bytes
from crackgrow.results.drawing import body_path, draw_steps, step_colour
from crackgrow.results.drawn_frame import frame_with_sigma_1
from crackgrow.results.field_picture import FieldPictures, on_specimen, png_of
from crackgrow.results.log import load_words
from crackgrow.results.report.charts import Chart, load_curves, stress_strain
from crackgrow.results.run import Run
from crackgrow.results.style import add_bar, give_title, own_style
from crackgrow.results.units import STRESSES, unit_of
from crackgrow.run.result import OPEN, SLIP, STATE_NAMES, STICK, CrackPath, StepResult

DPI = 150
MOST_CONTACT_ROWS = 6  # surfaces in one figure
MOST_STEP_TICKS = 11  # on the colour bar of steps, and of points named by their step
SAME_PLACE = 0.04  # of a plot's width and height: points closer than this share the words that name them


@own_style()
def draw_paths(path: Path, case: Case, cracks: Sequence[CrackPath]) -> None:
    """Draw the specimen's outline, the given cracks in black and each advance in the colour of its step.

    Raises OutputError.
    """
    case = case_on_map(case)
    last = max((int(crack.steps.max()) for crack in cracks), default=0)
    figure, axes, length = on_specimen(*extent(case), bar=last > 0)
    for body in case.bodies:
        axes.add_patch(PathPatch(body_path(body, 1.0 / length), facecolor="0.94", edgecolor="0.35", linewidth=1.0))
    draw_steps(axes, [(crack.points, crack.steps) for crack in cracks], 1.0 / length)
    colours = [step_colour(step, last) for step in range(1, last + 1)]
    for crack in cracks:
        x, y = (crack.points[crack.steps > 0] / length).T
        axes.scatter(x, y, s=7, color=[colours[step - 1] for step in crack.steps if step > 0], zorder=8)
    if last > 0:
        scale_of_steps = ScalarMappable(BoundaryNorm(np.arange(0.5, last + 1), last), ListedColormap(colours))
        ticks, label = range(1, last + 1, -(-last // MOST_STEP_TICKS)), "step of the advance (given crack: black)"
        add_bar(figure, axes, scale_of_steps, ticks=ticks, label=label).minorticks_off()
    _save(path, figure, case.title)


def draw_sigma_1(path: Path, case: Case, result: StepResult) -> None:
    """Draw the major in-plane principal stress on the displaced, magnified specimen, if there is one.

    Raises OutputError.
    """
    if result.frame is None:
        return
    frame = frame_with_sigma_1(result.frame, result.step)
    loads = {result.step: load_words(case, result.load_factor)}
    write_bytes(path, FieldPictures(case.title, "sigma_1", [frame], loads).png(frame))


@own_style()
def draw_contact(path: Path, case: Case, result: StepResult) -> None:
    """Plot slip, normal and shear traction against the arc length, a row for each surface with a contact law, if any.

    Dots are the contact points: white open, blue stuck, red slipping; the lines are the same along the whole face.
    Raises OutputError.
    """
    scale, unit = length_unit(case)
    contact = result.contact
    touching = [face for face in result.faces if face.crack in contact.crack]
    if not touching:
        return
    faces = touching[:MOST_CONTACT_ROWS]
    figure = Figure(figsize=(3.6 * 3, 2.6 * len(faces) + 0.4), dpi=DPI, layout="constrained")
    table = figure.subplots(len(faces), 3, squeeze=False, sharex="row")
    owner = np.array(contact.crack)
    for row, face in zip(table, faces, strict=True):
        mine = owner == face.crack
        largest = max(np.abs(contact.normal_traction[mine]).max(), np.abs(contact.tangential_traction[mine]).max())
        pascals, pressure = unit_of([largest], STRESSES)
        for axes, name, size, label in (
            (row[0], "slip", 1.0 / scale, f"slip [{unit}]"),
            (row[1], "normal_traction", pascals, f"normal traction [{pressure}]"),
            (row[2], "tangential_traction", pascals, f"shear traction [{pressure}]"),
        ):
            axes.axhline(0.0, color="0.7", linewidth=0.6)  # always in the picture: round-off is not blown up to fill it
            axes.plot(face.s * scale, getattr(face, name) / size, color="0.4", linewidth=1.0)
            for state, fill in ((OPEN, "white"), (STICK, "tab:blue"), (SLIP, "tab:red")):
                here = mine & (contact.state == state)
                if here.any():
                    dots = {
                        "markersize": 3.5,
                        "markerfacecolor": fill,
                        "markeredgecolor": "0.2",
                        "markeredgewidth": 0.5,
                    }
                    s, values = contact.s[here] * scale, getattr(contact, name)[here] / size
                    axes.plot(s, values, "o", label=STATE_NAMES[state], **dots)
            axes.set(xlabel=f"s along {face.crack} [{unit}]", ylabel=label)
            axes.grid(linewidth=0.3)
        row[0].legend(fontsize=7)
    rest = f" (the first {len(faces)} of {len(touching)} surfaces)" if len(touching) > len(faces) else ""
    _save(path, figure, f"{case.title}, step {result.step}{rest}")


@own_style()
def draw_curves(folder: Path, run: Run) -> None:
    """Plot the load curve and the stress-strain curve of a run, if it has them. Raises OutputError.

    Points are named by their steps: every so many, or in a history of loads those where it turns.
    """
    n_steps = len(run.solved)
    some = list(range(0, n_steps, -(-n_steps // MOST_STEP_TICKS)))
    if curves := load_curves(run):
        factor = run.table("steps")["load_factor"]
        turns = np.flatnonzero(np.diff(np.sign(np.diff(factor)))) + 1
        named = some if run.case.growth is not None else [0, *turns.tolist(), n_steps - 1]
        _draw_charts(folder / "load_curve.png", f"{run.case.title} (points: steps)", curves, named)
    if curve := stress_strain(run):
        title = f"{run.case.title} ({curve['title'].partition(', ')[2]})"
        _draw_charts(folder / "stress_strain.png", title, [curve], some, peak=True)


def _draw_charts(path: Path, title: str, charts: Sequence[Chart], named: Sequence[int], *, peak: bool = False) -> None:
    """Plot charts of a line each beside each other, some points with the number of their step, a line at the peak.

    Other series are marks, in a legend.
    """
    figure = Figure(figsize=(4.6 * len(charts), 4.0), dpi=DPI, layout="constrained")
    table = figure.subplots(1, len(charts), squeeze=False)
    for axes, chart in zip(table[0], charts, strict=True):
        line, *marks = chart["series"]
        x, y = (np.array(line[name], dtype=float) for name in "xy")
        axes.plot(x, y, "o-", color="tab:blue", markersize=3.5, linewidth=1.0)
        if peak:
            axes.axhline(np.nanmax(y), color="0.6", linewidth=0.6, linestyle="--")
        for place, steps in _labels(x, y, named):
            axes.annotate(", ".join(steps), place, xytext=(4, -9), textcoords="offset points", fontsize=7)
        for mark in marks:
            places = (np.array(mark[name], dtype=float) for name in "xy")
            axes.plot(*places, "o", color=mark["colour"], markersize=6, fillstyle="none", label=mark["name"])
        if marks:
            axes.legend(fontsize=7)
        axes.margins(x=0.1)  # room for the words at the right end
        axes.locator_params(axis="x", nbins=5)
        axes.ticklabel_format(scilimits=(-3, 5), useOffset=False)
        axes.set(xlabel=chart["xlabel"], ylabel=chart["ylabel"])
        axes.grid(linewidth=0.3)
    _save(path, figure, title)


def _labels(x: Floats, y: Floats, named: Sequence[int]) -> list[tuple[tuple[float, float], list[str]]]:
    """Where to name some steps of a curve x, y (n,), and by which words: steps at about the same place share one."""
    width, height = (SAME_PLACE * float(np.ptp(values[np.isfinite(values)])) or 1.0 for values in (x, y))
    labels: dict[tuple[int, int], tuple[tuple[float, float], list[str]]] = {}
    for step in dict.fromkeys(named):
        if np.isfinite(x[step]) and np.isfinite(y[step]):
            cell = (round(x[step] / width), round(y[step] / height))
            labels.setdefault(cell, ((float(x[step]), float(y[step])), []))[1].append(str(step))
    return list(labels.values())


def _save(path: Path, figure: Figure, title: str) -> None:
    give_title(figure, title)
    write_bytes(path, png_of(figure))
