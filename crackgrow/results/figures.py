"""Pictures of a run: the crack paths, the stress on the displaced specimen, the contacts, the load over the steps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, Protocol

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, TriMesh
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as LinePath
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.results.atomic import write_atomically
from crackgrow.results.load_point import LoadPoint
from crackgrow.results.stress import principal_stresses
from crackgrow.results.style import own_style, wrapped
from crackgrow.run.result import OPEN, SLIP, STATE_NAMES, STICK, CrackPath, Frame, StepResult

DISPLACED_SHARE = 0.04  # of the specimen's size: how far the most displaced point is drawn from its place
LARGEST_STRAIN = 0.15  # that is drawn: beyond it holes lose their shape
STRAIN_PERCENTILE = 98.0  # of the length of all sides of cells: what is left lies at tips
WIDE = 2.0  # width over height from which a colour bar lies below the picture, where its words have room
COLOUR_PERCENTILES = (2.0, 98.0)  # of the area: colours span these, so that a singular tip doesn't wash out the rest
ONE_SIGN_SHARE = 0.05  # a side of zero smaller than this share of the other doesn't make the colours two-sided
LONG_SIDE = 7.0  # inches
DPI = 150
COMPRESSION = 3  # of PNG: 6, which is usual, takes twice as long for smooth colours, and saves a fifth of the bytes
MOST_CONTACT_ROWS = 6  # surfaces in one figure
MOST_STEP_TICKS = 11  # on the colour bar of steps, and of points named by their step
THIN = 2e-3  # of the size: cells thinner than that are drawn first, under their neighbours, since they come out wider
SAME_PLACE = 0.04  # of a plot's width and height: points closer than this share the words that name them


class Cells(Protocol):
    """Triangles (t, 3) and quads (q, 4) of a mesh."""

    @property
    def triangles(self) -> NDArray[np.int64]: ...

    @property
    def quads(self) -> NDArray[np.int64]: ...


class Displaced(Cells, Protocol):
    """A mesh whose points (n, 2) m are displaced."""

    @property
    def points(self) -> Floats: ...

    @property
    def displacement(self) -> Floats: ...


@own_style()
def draw_paths(path: Path, case: Case, cracks: Sequence[CrackPath]) -> None:
    """Draw the specimen's outline, the given cracks in black and each advance in the colour of its step.

    Raises OutputError.
    """
    scale, unit = _length_unit(case)
    low, high = _extent([body.outline for body in case.bodies])
    figure, axes = _equal_axes(low * scale, high * scale, unit)
    for body in case.bodies:
        closed = [LinePath(np.vstack([ring.points, ring.points[:1]]) * scale, closed=True) for ring in body.rings]
        whole = LinePath.make_compound_path(*closed)
        axes.add_patch(PathPatch(whole, facecolor="0.94", edgecolor="0.35", linewidth=1.0))
    last = max((int(crack.steps.max()) for crack in cracks), default=0)
    colours = _step_colours(max(last, 1))
    for crack in cracks:
        segments = np.stack([crack.points[:-1], crack.points[1:]], axis=1) * scale
        made = np.maximum(crack.steps[:-1], crack.steps[1:])  # a segment is as young as its younger vertex
        given = LineCollection(list(segments[made == 0]), colors="black", linewidths=2.4, capstyle="round", zorder=3)
        axes.add_collection(given)
        axes.add_collection(
            LineCollection(list(segments[made > 0]), colors=list(colours.to_rgba(made[made > 0])), linewidths=2.0)
        )
        grown = crack.steps > 0
        x, y = (crack.points[grown] * scale).T
        axes.scatter(x, y, s=7, color=colours.to_rgba(crack.steps[grown]), zorder=4)
    axes.set_title(wrapped(case.title, figure), fontsize=10)
    if last > 0:
        every, place = -(-last // MOST_STEP_TICKS), bar_place(high - low)
        bar = figure.colorbar(colours, ax=axes, ticks=range(1, last + 1, every), shrink=0.8, location=place)
        bar.minorticks_off()
        bar.set_label("step of the advance (given crack: black)")
    _save(path, figure)


@own_style()
def draw_sigma_1(path: Path, case: Case, frame: Frame, step: int) -> None:
    """Draw the major in-plane principal stress on the displaced, magnified specimen.

    The mean translation is taken off first; the title says the magnification. Raises OutputError.
    """
    scale, unit = _length_unit(case)
    magnification = displayed_magnification(frame)
    points = (frame.points + magnification * off_mean(frame)) * scale
    sigma_1, _ = principal_stresses(frame.point_stress)
    sigma, stress_unit = (sigma_1 / 1e6, "MPa") if np.abs(sigma_1).max(initial=0.0) >= 1e4 else (sigma_1, "Pa")
    norm, colormap = colours_of(sigma, areas(frame, by_point=True))
    low, high = _extent([points])
    figure, axes = _equal_axes(low, high, unit)
    shades = shade(axes, frame, points, sigma, norm, colormap)
    edges = points[boundary_edges(frame)]
    axes.add_collection(LineCollection(list(edges), colors="0.15", linewidths=0.5))
    bar = figure.colorbar(shades, ax=axes, extend="both", shrink=0.8, location=bar_place(high - low))
    bar.set_label(f"\u03c3\u2081, most tensile in-plane principal stress [{stress_unit}]")
    caption = f"step {step}, displacement x {magnification:g}"
    axes.set_title(f"{wrapped(case.title, figure)}\n{caption}", fontsize=10)
    _save(path, figure)


@own_style()
def draw_contact(path: Path, case: Case, result: StepResult) -> None:
    """Plot slip, normal and shear traction against the arc length, a row for each surface with a contact law.

    Dots are the contact points: white open, blue stuck, red slipping; the lines are the same along the whole face.
    Raises OutputError.
    """
    scale, unit = _length_unit(case)
    contact = result.contact
    touching = [face for face in result.faces if face.crack in contact.crack]
    faces = touching[:MOST_CONTACT_ROWS]
    figure = Figure(figsize=(3.6 * 3, 2.6 * len(faces) + 0.4), dpi=DPI, layout="constrained")
    table = figure.subplots(len(faces), 3, squeeze=False, sharex="row")
    owner = np.array(contact.crack)
    for row, face in zip(table, faces, strict=True):
        mine = owner == face.crack
        largest = max(np.abs(contact.normal_traction[mine]).max(), np.abs(contact.tangential_traction[mine]).max())
        stress, stress_unit = (1e-6, "MPa") if largest >= 1e4 else (1.0, "Pa")
        for axes, values, along, label in (
            (row[0], contact.slip, face.slip * scale, f"slip [{unit}]"),
            (row[1], contact.normal_traction, face.normal_traction * stress, f"normal traction [{stress_unit}]"),
            (row[2], contact.tangential_traction, face.tangential_traction * stress, f"shear traction [{stress_unit}]"),
        ):
            factor = scale if values is contact.slip else stress
            axes.axhline(0.0, color="0.7", linewidth=0.6)  # always in the picture: round-off is not blown up to fill it
            axes.plot(face.s * scale, along, color="0.4", linewidth=1.0)
            for state, fill in ((OPEN, "white"), (STICK, "tab:blue"), (SLIP, "tab:red")):
                here = mine & (contact.state == state)
                if not here.any():
                    continue
                axes.plot(
                    contact.s[here] * scale, values[here] * factor, "o", markersize=3.5, markerfacecolor=fill,
                    markeredgecolor="0.2", markeredgewidth=0.5, label=STATE_NAMES[state],
                )  # fmt: skip
            axes.set(xlabel=f"s along {face.crack} [{unit}]", ylabel=label)
            axes.grid(linewidth=0.3)
        row[0].legend(fontsize=7)
    rest = f" (the first {len(faces)} of {len(touching)} surfaces)" if len(touching) > len(faces) else ""
    figure.suptitle(wrapped(f"{case.title}, step {result.step}{rest}", figure), fontsize=10)
    _save(path, figure)


@own_style()
def draw_load_curve(path: Path, case: Case, curve: Sequence[LoadPoint]) -> None:
    """Plot the load factor, step by step from step 0, against the displacement of the loads and what cracks make of it.

    That is how much they have grown where they have, else the slip of the surface that slips most. Points are named by
    their steps: every so many, or in a history of loads those where it turns. Raises OutputError.
    """
    scale, unit = _length_unit(case)
    factor, displacement, length = np.array([(p.factor, p.displacement, p.crack_length) for p in curve]).T
    growth = length - length[0]
    panels = [(displacement, f"displacement of the loads [{unit}]")]
    if growth.any():
        panels.append((growth, f"crack growth [{unit}]"))
        named = list(range(0, len(curve), -(-len(curve) // MOST_STEP_TICKS)))
    else:
        panels.extend(_most_slip(curve, unit))
        turns = np.flatnonzero(np.diff(np.sign(np.diff(factor)))) + 1
        named = [0, *turns.tolist(), len(curve) - 1]
    figure = Figure(figsize=(4.6 * len(panels), 4.0), dpi=DPI, layout="constrained")
    for axes, (values, label) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        axes.plot(values * scale, factor, "o-", color="tab:blue", markersize=3.5, linewidth=1.0)
        for (x, y), steps in _labels(values * scale, factor, named):
            axes.annotate(", ".join(steps), (x, y), xytext=(4, -9), textcoords="offset points", fontsize=7)
        axes.margins(x=0.1)  # room for the words at the right end
        axes.locator_params(axis="x", nbins=5)
        axes.ticklabel_format(scilimits=(-3, 5), useOffset=False)
        axes.set(xlabel=label, ylabel="load factor")
        axes.grid(linewidth=0.3)
    figure.suptitle(wrapped(f"{case.title} (points: steps)", figure), fontsize=10)
    _save(path, figure)


def _labels(x: Floats, y: Floats, named: Sequence[int]) -> list[tuple[tuple[float, float], list[str]]]:
    """Where to name some steps of a curve x, y (n,), and by which words: steps at about the same place share one."""
    width, height = (float(np.ptp(values[np.isfinite(values)])) or 1.0 for values in (x, y))
    labels: list[tuple[tuple[float, float], list[str]]] = []
    for step in dict.fromkeys(named):
        place = (float(x[step]), float(y[step]))
        if not np.isfinite(place).all():
            continue
        for (a, b), words in labels:
            if abs(a - place[0]) < SAME_PLACE * width and abs(b - place[1]) < SAME_PLACE * height:
                words.append(str(step))
                break
        else:
            labels.append((place, [str(step)]))
    return labels


def _most_slip(curve: Sequence[LoadPoint], unit: str) -> list[tuple[Floats, str]]:
    """Slip (m) step by step of the surface that slips most, and what to call it; none without slip.

    nan where the surface is gone with the rock beside it.
    """
    slips = {name: np.array([point.slip.get(name, np.nan) for point in curve]) for name in curve[0].slip}
    largest = max(slips, key=lambda name: float(np.nanmax(np.abs(slips[name]))), default=None)
    if largest is None or not np.nan_to_num(slips[largest]).any():
        return []
    return [(slips[largest], f"largest slip of {largest} [{unit}]")]


def displayed_magnification(frame: Displaced) -> float:
    """Factor, two digits, that draws the largest displacement off the mean as DISPLACED_SHARE of the size.

    It is less where LARGEST_STRAIN would be drawn, and 1 where nothing is displaced.
    """
    largest = np.linalg.norm(off_mean(frame), axis=1).max()
    size = np.ptp(frame.points, axis=0).max()
    if not largest > 0:
        return 1.0
    strain = max(_usual_strain(frame, sides) for sides in (np.concatenate(_all_sides(frame)), boundary_edges(frame)))
    return float(f"{min(DISPLACED_SHARE * size / largest, LARGEST_STRAIN / max(strain, 1e-300)):.1e}")


def _usual_strain(frame: Displaced, sides: NDArray[np.int64]) -> float:
    """Size of the strain along sides of cells, given by their ends (n, 2), that little of their length exceeds."""
    x, u = (values[sides[:, 1]] - values[sides[:, 0]] for values in (frame.points, frame.displacement))
    squares = (x * x).sum(axis=1)
    kept = squares > 0.0
    strains = np.abs((x * u).sum(axis=1)[kept]) / squares[kept]
    return float(_percentiles(strains, np.sqrt(squares[kept]), STRAIN_PERCENTILE)) if len(strains) else 0.0


def boundary_edges(frame: Cells) -> NDArray[np.int64]:
    """Edges (n, 2) that one cell alone has: the outline and both faces of the cracks."""
    unique, counts = np.unique(np.sort(np.concatenate(_all_sides(frame)), axis=1), axis=0, return_counts=True)
    outer: NDArray[np.int64] = unique[counts == 1]
    return outer


def _all_sides(frame: Cells) -> list[NDArray[np.int64]]:
    """Ends (n, 2) of the sides of triangles and of quads, a side of two cells twice."""
    return [np.stack([cells, np.roll(cells, -1, axis=1)], axis=2).reshape(-1, 2) for cells in _cell_groups(frame)]


def bar_place(extent: Floats) -> Literal["right", "bottom"]:
    """The side of a picture of something of this width and height (2,) on which its colour bar has room."""
    return "bottom" if extent[0] > WIDE * extent[1] else "right"


def _cell_groups(frame: Cells) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    return frame.triangles.reshape(-1, 3), frame.quads.reshape(-1, 4)


def off_mean(frame: Displaced) -> Floats:
    """Displacement (n, 2) m less its mean over the specimen."""
    return np.asarray(frame.displacement - np.average(frame.displacement, axis=0, weights=areas(frame, by_point=True)))


def areas(frame: Displaced, *, by_point: bool) -> Floats:
    """Area m^2 of each cell (c,), or that each point (n,) stands for: equal parts of those of its cells."""
    groups = _cell_groups(frame)
    of_cells = [_areas(frame.points, cells) for cells in groups]
    if not by_point:
        return np.concatenate(of_cells)
    corners = np.concatenate([cells.ravel() for cells in groups])
    parts = [np.repeat(some / cells.shape[1], cells.shape[1]) for some, cells in zip(of_cells, groups, strict=True)]
    return np.asarray(np.bincount(corners, np.concatenate(parts), len(frame.points)), dtype=float)


def _areas(points: Floats, cells: NDArray[np.int64]) -> Floats:
    """Areas (c,) of cells with corners (c, k) among points (n, 2)."""
    x, y = points[cells].transpose(2, 0, 1)
    return np.asarray(0.5 * np.abs(np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y, axis=1)))


def shade(axes: Axes, frame: Cells, points: Floats, values: Floats, norm: Normalize, colormap: str) -> TriMesh:
    """Fill a frame's cells, its points drawn at `points` (n, 2), with the colours between those of its points (n,)."""
    triangles, quads = _cell_groups(frame)
    middle = np.broadcast_to(len(points) + np.arange(len(quads))[:, None], quads.shape)
    fans = np.stack([quads, np.roll(quads, -1, axis=1), middle], axis=2).reshape(-1, 3)
    corners = np.concatenate([triangles, fans])
    points, values = (np.concatenate([field, field[quads].mean(axis=1)]) for field in (points, values))
    ends = points[np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)]
    longest = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).max(axis=1)
    thin = 2.0 * _areas(points, corners) < THIN * longest * np.ptp(points, axis=0).max()
    corners = np.concatenate([corners[thin], corners[~thin]])
    mesh = Triangulation(points[:, 0], points[:, 1], corners)
    return axes.tripcolor(mesh, values, shading="gouraud", cmap=colormap, norm=norm)


def colours_of(values: Floats, weights: Floats) -> tuple[Normalize, str]:
    """Limits that values of little weight, such as area, don't move; symmetrical where both signs matter."""
    low, high = (float(limit) for limit in _percentiles(values, weights, COLOUR_PERCENTILES))
    largest = max(abs(low), abs(high))
    if min(-low, high) > ONE_SIGN_SHARE * largest:
        return Normalize(-largest, largest), "RdBu_r"
    if high - low <= 1e-9 * largest:  # one value: any width shows it
        low, high = low - 0.5 * (largest or 1.0), high + 0.5 * (largest or 1.0)
    return Normalize(low, high), "viridis"


def _percentiles(values: Floats, weights: Floats, percentiles: float | tuple[float, float]) -> Floats:
    return np.asarray(np.percentile(values, percentiles, weights=weights, method="inverted_cdf"))


def _step_colours(last: int) -> ScalarMappable:
    """One colour for each of the steps 1..last; none so pale that it is lost on the specimen."""
    colours = mpl.colormaps["plasma"](np.linspace(0.05, 0.85, last))
    return ScalarMappable(BoundaryNorm(np.arange(0.5, last + 1), last), ListedColormap(list(colours)))


def _length_unit(case: Case) -> tuple[float, str]:
    low, high = _extent([body.outline for body in case.bodies])
    return (1e3, "mm") if (high - low).max() < 1 else (1.0, "m")


def _extent(points: Sequence[Floats]) -> tuple[Floats, Floats]:
    stacked = np.concatenate(points)
    return stacked.min(axis=0), stacked.max(axis=0)


def _equal_axes(low: Floats, high: Floats, unit: str) -> tuple[Figure, Axes]:
    """A figure in the specimen's proportions, with room for titles and a colour bar."""
    width, height = LONG_SIDE * (high - low) / (high - low).max()
    beside = bar_place(high - low) == "right"
    size = (max(width, 2.5) + 2.2, max(height, 2.2) + 1.2) if beside else (width + 1.0, max(height, 0.7) + 2.4)
    figure = Figure(figsize=size, dpi=DPI, layout="constrained")
    axes = figure.add_subplot()
    margin = 0.03 * (high - low).max()
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    axes.set(xlabel=f"x [{unit}]", ylabel=f"y [{unit}]", aspect="equal")
    return figure, axes


def _save(path: Path, figure: Figure) -> None:
    """Draw the figure once; `Figure.savefig` would draw it twice, where the layout is its own."""
    options = {"compress_level": COMPRESSION}
    write_atomically(path, lambda temporary: FigureCanvasAgg(figure).print_png(temporary, pil_kwargs=options))
