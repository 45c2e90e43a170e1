"""Pictures of a field: the specimen displaced, its cracks open, with a colour bar.

They are drawn by matplotlib: no display, no graphics driver is needed.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any, Final, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from PIL import Image

from crackgrow.arrays import Floats
from crackgrow.case.report import quoted
from crackgrow.case.units import QuantityError, Units, is_number, parse_number, parse_quantity
from crackgrow.errors import CaseError
from crackgrow.results.drawn_frame import INCHES, LINE, DrawnFrame, areas_of, percentiles
from crackgrow.results.style import add_bar, give_title, has_bar_beside, own_style
from crackgrow.results.units import LENGTHS, STRESSES, Unit, factor_text, unit_of

LONG_SIDE = 1000  # pixels, where no size is given
COLOUR_BAR = 0.34  # what caption and colour bar take of the width or height, by the specimen's longer side
LEAST_SHARE = 0.33  # of the longer side that the shorter one has room for: words are wider than a thin specimen
BEHIND = "0.8"  # shows in open cracks, and is no colour of a field
MARGIN = 0.03  # round the specimen, by its longer side
NAMES = {"displacement": "size of the displacement", "sigma_1": "\u03c3\u2081, most tensile in-plane principal stress",
         "sigma_3": "\u03c3\u2083, least in-plane principal stress"}  # fmt: skip
Kind = Literal["length", "stress"]
KINDS: Final[Mapping[str, Kind]] = {"displacement": "length", "sigma": "stress", "stress": "stress"}
UNITS: Final = {"length": LENGTHS, "stress": STRESSES, None: ((1.0, ""),)}  # of fields by what their names begin with
COLOUR_PERCENTILES = (2.0, 98.0)  # of the area: colours span these, so that a singular tip doesn't wash out the rest
ONE_SIGN_SHARE = 0.05  # a side of zero smaller than this share of the other doesn't make the colours two-sided
DRAWING = 32 * 2**20  # bytes that have to be free for a picture
COMPRESSION = 3  # of PNG: 6, which is usual, takes twice as long for smooth colours, and saves a fifth of the bytes
THIN = 2e-3  # of the size: cells thinner than that are drawn first, under their neighbours, since they come out wider


class FieldPictures:
    """A field on the displaced specimen, in one extent, magnification, colour scale and size for all frames.

    loads: what loads each step, for the captions
    warp: factor of the displacements; None: a visible one
    size: width and height in pixels; None: what fits the specimen
    limits: of the colours, with a unit or in that of the colour bar; None: those of the values
    """

    def __init__(
        self,
        title: str,
        field: str,
        frames: Sequence[DrawnFrame],
        loads: Mapping[int, str],
        warp: float | None = None,
        size: tuple[int, int] | None = None,
        limits: tuple[str, str] | None = None,
    ) -> None:
        """Raises CaseError for limits that the field cannot have."""
        self.title, self.field, self.loads, self.size = title, field, loads, size
        self.warp = min(frame.magnification() for frame in frames) if warp is None else warp
        values = np.concatenate([frame.values for frame in frames])
        weights = np.concatenate([frame.areas(by_point=frame.by_point) for frame in frames])
        self.unit, self.norm, self.colormap = colours_of(field, values, weights)
        if limits is not None:
            low, high = limits_of(field, limits, self.unit)
            self.norm, self.colormap = Normalize(low, high), "RdBu_r" if low == -high else "viridis"  # white is zero
        moved = np.concatenate([self._moved(frame) for frame in frames])
        self.corners = moved.min(axis=0), moved.max(axis=0)
        self._layouts: dict[int, list[Any]] = {}  # places of the title and of axes, by the number of its lines

    @own_style()
    def png(self, frame: DrawnFrame) -> bytes:
        """The picture of a frame, as PNG."""
        figure, axes, length = on_specimen(*self.corners, self.size)
        axes.set_facecolor(BEHIND)
        points = self._moved(frame) / length
        shade(axes, frame, points, frame.values / self.unit[0], self.norm, self.colormap)
        edges = points[frame.boundary_edges]
        axes.add_collection(LineCollection(list(edges), colors="0.1", linewidths=LINE), autolim=False)
        unit = f" [{self.unit[1]}]" if self.unit[1] else ""
        label = f"{NAMES.get(self.field, self.field.replace('_', ' '))}{unit}"
        load = f", {self.loads[frame.step]}" if frame.step in self.loads else ""
        title = f"{self.title}\nstep {frame.step}{load}, displacement x {factor_text(self.warp)}"
        words = give_title(figure, title)
        add_bar(figure, axes, ScalarMappable(self.norm, self.colormap), extend="both", label=label)
        n_lines = words.get_text().count("\n")
        if n_lines in self._layouts:  # else matplotlib measures all words again
            figure.set_layout_engine("none")
            title_at, *axes_at = self._layouts[n_lines]
            words.set_position(title_at)
            for each, place in zip(figure.axes, axes_at, strict=True):
                each.set_position(place)
        picture = png_of(figure)
        self._layouts[n_lines] = [words.get_position(), *(each.get_position(original=True) for each in figure.axes)]
        return picture

    def _moved(self, frame: DrawnFrame) -> Floats:
        """Points (n, 2) m of a frame, displaced without the mean translation."""
        return frame.points + self.warp * frame.off_mean()


def on_specimen(
    low: Floats, high: Floats, size: tuple[int, int] | None = None, bar: bool = True
) -> tuple[Figure, Axes, float]:
    """A figure of a specimen with these corners (2,) m, room for title and colour bar, axes and metres of their unit.

    Without a size, in pixels, it fits the specimen, with a `bar` or not; that is even, as films want it.
    """
    extent = high - low
    length, unit = unit_of(extent.tolist(), LENGTHS)
    margin = MARGIN * extent.max()
    beside = has_bar_beside(*(extent + 2.0 * margin))
    room = [COLOUR_BAR if bar and beside else 0.12, COLOUR_BAR if bar and not beside else 0.16]
    shares = np.maximum(extent / extent.max(), LEAST_SHARE) + room
    fitting = 2 * np.round(shares * LONG_SIDE / shares.max() / 2)
    width, height = size or fitting
    dpi = LONG_SIDE / INCHES * min(width / fitting[0], height / fitting[1])
    figure = Figure(figsize=(width / dpi, height / dpi), dpi=dpi, layout="constrained")
    axes = figure.add_subplot()
    (left, bottom), (right, top) = (low - margin) / length, (high + margin) / length
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xlabel=f"x [{unit}]", ylabel=f"y [{unit}]")
    return figure, axes, length


def png_of(figure: Figure) -> bytes:
    """A figure as PNG; raises MemoryError where there is less than DRAWING of memory."""
    np.empty(DRAWING, dtype=np.uint8)  # compiled code that draws ends the process where its memory runs out
    canvas, data = FigureCanvasAgg(figure), io.BytesIO()
    canvas.draw()
    colours = np.asarray(canvas.buffer_rgba())[..., :3]  # all is opaque: a fourth channel would take as long as another
    Image.fromarray(colours).save(data, format="PNG", compress_level=COMPRESSION, dpi=(figure.dpi, figure.dpi))
    return data.getvalue()


def shade(axes: Axes, frame: DrawnFrame, points: Floats, values: Floats, norm: Normalize, colormap: str) -> None:
    """Fill a frame's cells, its points drawn at `points` (n, 2), with their colours or those between their points."""
    n, cells = len(points), frame.cells
    middle = np.broadcast_to(n + np.arange(len(cells))[:, None], cells.shape)
    parts, whole = np.stack([cells, np.roll(cells, -1, axis=1), middle], axis=2), cells[:, 2] == cells[:, 3]
    corners = np.concatenate([cells[whole, :3], parts[~whole].reshape(-1, 3)])  # triangles have their last one twice
    of_cell = np.concatenate([np.flatnonzero(whole), np.repeat(np.flatnonzero(~whole), 4)])
    points = np.concatenate([points, points[cells].mean(axis=1)])
    last = np.append(frame.above(), np.zeros(len(cells), dtype=bool))[corners].any(axis=1)
    ends = points[np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)]
    longest = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).max(axis=1)
    thin = 2.0 * areas_of(points, corners) < THIN * longest * np.ptp(points, axis=0).max()
    order = np.lexsort([~thin, last])
    mesh = Triangulation(points[:, 0], points[:, 1], corners[order])
    if frame.by_point:
        values = np.concatenate([values, values[cells].mean(axis=1)])
        axes.tripcolor(mesh, values, shading="gouraud", cmap=colormap, norm=norm)
    else:
        axes.tripcolor(mesh, facecolors=values[of_cell[order]], cmap=colormap, norm=norm)


def limits_of(field: str, texts: tuple[str, str], unit: Unit) -> tuple[float, float]:
    """Limits of the colours in the unit of the colour bar, of texts such as "-20 MPa" or "-20"; raises CaseError."""
    kind = KINDS.get(field.partition("_")[0])
    found = []
    for text in texts:
        try:
            bare = kind is None or is_number(text.strip())
            found.append(parse_number(text.strip()) if bare else parse_quantity(text, kind or "", Units()) / unit[0])
        except QuantityError as error:
            wanted = f"a number, in {unit[1]}, or with a unit such as '{unit[1]}'" if kind else "a number"
            raise CaseError.at("--range", f"{quoted(text)} {error}; wanted: {wanted}") from None
    if found[0] >= found[1]:
        message = f"{quoted(texts[0])} is not less than {quoted(texts[1])}; wanted: the lower limit first"
        raise CaseError.at("--range", message)
    return found[0], found[1]


def colours_of(field: str, values: Floats, weights: Floats) -> tuple[Unit, Normalize, str]:
    """The unit of a field for its values, limits in it that values of little weight, such as area, don't move, colours.

    The limits are symmetrical where both signs matter.
    """
    low, high = (float(limit) for limit in percentiles(values, weights, COLOUR_PERCENTILES))
    largest = max(abs(low), abs(high))
    kind, both = KINDS.get(field.partition("_")[0]), min(-low, high) > ONE_SIGN_SHARE * largest
    unit = unit_of([low, high], UNITS[kind])
    if both:
        low, high = -largest, largest
    elif high - low <= 1e-9 * largest:  # one value: any width shows it
        low, high = low - 0.5 * (largest or unit[0]), high + 0.5 * (largest or unit[0])
    return unit, Normalize(low / unit[0], high / unit[0]), "RdBu_r" if both else "viridis"
