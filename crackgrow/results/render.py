"""Pictures of a run's frames: a field on the displaced specimen, its cracks open, in one scale for all steps.

They are drawn by matplotlib: no display, no graphics driver is needed.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from crackgrow.arrays import Floats
from crackgrow.results.atomic import write_atomically
from crackgrow.results.drawn_frame import DrawnFrame, drawn_frame, field_unit
from crackgrow.results.figures import (
    areas,
    bar_place,
    boundary_edges,
    colours_of,
    displayed_magnification,
    off_mean,
    shade,
)
from crackgrow.results.folder import RunFolder, open_run
from crackgrow.results.rendered import FOLDER, picture_name, remove_rendered
from crackgrow.results.style import own_style, wrapped
from crackgrow.results.units import LENGTHS, unit_of

LONG_SIDE = 1000  # pixels, where no size is given
INCHES = 6.5  # of the longer side of a picture whose size fits the specimen: text is in proportion to that
COLOUR_BAR = 0.34  # what caption and colour bar take of the width or height, by the specimen's longer side
BEHIND = "0.8"  # shows in open cracks, and is no colour of a field
MARGIN = 0.03  # round the specimen, by its longer side
NAMES = {"displacement": "size of the displacement", "sigma_1": "\u03c3\u2081, most tensile in-plane principal stress",
         "sigma_3": "\u03c3\u2083, least in-plane principal stress"}  # fmt: skip


def render(
    folder: Path,
    field: str = "sigma_1",
    warp: float | None = None,
    steps: Sequence[int | range] | None = None,
    size: tuple[int, int] | None = None,
    out: Path | None = None,
) -> Iterator[Path]:
    """Draw a field of the frames of the run in `folder`, and yield each picture as it is done.

    field: displacement (its size), sigma_1, sigma_3, stress_xx, ..., or one of the cells: body, energy_error
    warp: factor of the displacements; None: a visible one, the same for all steps
    steps: those to draw, or ranges of them; None: all that have frames
    size: width and height in pixels
    out: folder of the pictures, `render` in that of the run if it is None; earlier pictures of the field go

    Raises FolderError where there is nothing to draw, OutputError.
    """
    run = open_run(folder)
    frames = [drawn_frame(run, step, field) for step in run.frames_of(steps)]
    scene = _Scene(run, field, frames, warp, size)
    target = folder / FOLDER if out is None else out
    remove_rendered(target / field)
    for frame in frames:
        path = target / picture_name(field, frame.step)
        data = scene.picture(frame)
        write_atomically(path, lambda temporary, data=data: temporary.write_bytes(data))  # type: ignore[misc]
        yield path


class _Scene:
    """What all pictures of a run share: extent, magnification, colours, size."""

    def __init__(
        self,
        run: RunFolder,
        field: str,
        frames: Sequence[DrawnFrame],
        warp: float | None,
        size: tuple[int, int] | None,
    ) -> None:
        self.title, self.field = run.case.title, field
        self.factors = dict(zip(run.solved, run.table("steps").numbers("load_factor").tolist(), strict=True))
        self.warp = min(displayed_magnification(frame) for frame in frames) if warp is None else warp
        values = np.concatenate([frame.values for frame in frames])
        self.unit = field_unit(field, values)
        weights = np.concatenate([areas(frame, by_point=frame.by_point) for frame in frames])
        self.norm, self.colormap = colours_of(values / self.unit[0], weights)
        moved = np.concatenate([self._moved(frame) for frame in frames])
        low, high = moved.min(axis=0), moved.max(axis=0)
        self.length = unit_of((high - low).tolist(), LENGTHS)
        room = MARGIN * (high - low).max()
        self.low, self.high = (low - room) / self.length[0], (high + room) / self.length[0]
        fitting = _fitting(high - low)
        self.size = fitting if size is None else size
        self.dpi = LONG_SIDE / INCHES * min(self.size[0] / fitting[0], self.size[1] / fitting[1])

    @own_style()
    def picture(self, frame: DrawnFrame) -> bytes:
        """The picture of a frame, as PNG."""
        width, height = self.size[0] / self.dpi, self.size[1] / self.dpi
        figure = Figure(figsize=(width, height), dpi=self.dpi, layout="compressed")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot(facecolor=BEHIND)
        points = self._moved(frame) / self.length[0]
        values = frame.values / self.unit[0]
        if frame.by_point:
            shade(axes, frame, points, values, self.norm, self.colormap)
        else:
            polygons = [*points[frame.triangles], *points[frame.quads]]
            cells = PolyCollection(polygons, array=values, cmap=self.colormap, norm=self.norm, antialiaseds=False)
            axes.add_collection(cells)
        edges = points[boundary_edges(frame)]
        axes.add_collection(LineCollection(list(edges), colors="0.1", linewidths=0.8))
        axes.set(xlim=(self.low[0], self.high[0]), ylim=(self.low[1], self.high[1]), aspect="equal")
        axes.set(xlabel=f"x [{self.length[1]}]", ylabel=f"y [{self.length[1]}]")
        colours, place = ScalarMappable(self.norm, self.colormap), bar_place(self.high - self.low)
        bar = figure.colorbar(colours, ax=axes, extend="both", shrink=0.8, location=place)
        unit = f" [{self.unit[1]}]" if self.unit[1] else ""
        bar.set_label(f"{NAMES.get(self.field, self.field.replace('_', ' '))}{unit}")
        load = f", load factor {self.factors[frame.step]:.4g}" if frame.step in self.factors else ""
        caption = f"step {frame.step}{load}, displacement x {self.warp:.3g}"
        figure.suptitle(f"{wrapped(self.title, figure)}\n{caption}", fontsize=10)
        data = io.BytesIO()
        figure.savefig(data, format="png")
        return data.getvalue()

    def _moved(self, frame: DrawnFrame) -> Floats:
        """Displaced points (n, 2) m, without the mean translation."""
        return frame.points + self.warp * off_mean(frame)


def _fitting(extent: Floats) -> tuple[int, int]:
    """Width and height in pixels of a picture of a specimen of this extent (2,), with its colour bar; even numbers."""
    room = [COLOUR_BAR, 0.16] if bar_place(extent) == "right" else [0.12, COLOUR_BAR]
    width, height = extent / extent.max() + room
    scale = LONG_SIDE / max(width, height)
    return 2 * round(width * scale / 2), 2 * round(height * scale / 2)
