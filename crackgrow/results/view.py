"""An interactive window of a run's frames, where there is a display."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import pyvista

from crackgrow.errors import CrackgrowError
from crackgrow.results.drawn_frame import drawn_frame
from crackgrow.results.field_picture import colours_of
from crackgrow.results.folder import open_run
from crackgrow.results.units import factor_text


class NoDisplayError(CrackgrowError):
    """There is no display to open a window on; the message says what to do instead."""

    exit_code = 3


def view(folder: Path, field: str = "sigma_1", warp: float | None = None) -> None:
    """Open a window with a slider over the steps, and return when it is closed.

    Raises FolderError where there is nothing to see, NoDisplayError.
    """
    unix = sys.platform not in ("win32", "darwin")
    if unix and not os.environ.get("DISPLAY") and not os.environ.get("WAYLAND_DISPLAY"):
        raise NoDisplayError(
            f"there is no display to open a window on: `crackgrow render {folder}` draws pictures without one; or open "
            f"the .pvd in {folder} in ParaView where there is one, or log in by `ssh -X`"
        )
    plotter = pyvista.Plotter(title=f"crackgrow: {folder}")
    fill(plotter, folder, field, warp)
    plotter.show()


def fill(plotter: pyvista.Plotter, folder: Path, field: str, warp: float | None) -> None:
    """Put the last frame into a plotter, with a slider that changes it; raises FolderError."""
    run = open_run(folder)
    steps = run.frames_of()
    last = drawn_frame(run, steps[-1], field)
    factor = last.magnification() if warp is None else warp
    (size, name), norm, colour_map = colours_of(field, last.values, last.areas(by_point=last.by_point))
    label = f"{field} [{name}]" if name else field
    looks: dict[str, Any] = {"cmap": colour_map, "clim": (norm.vmin, norm.vmax)}
    looks |= {"show_scalar_bar": False, "lighting": False}
    untyped: Any = plotter  # the declared types of some methods are not those of what they wrap

    def show(value: float) -> Any:
        step = min(steps, key=lambda other: abs(other - value))
        mesh = run.mesh(step)
        frame = drawn_frame(run, step, field, mesh)
        grid = mesh.warp_by_vector("displacement", factor=factor)
        (grid.point_data if frame.by_point else grid.cell_data)[label] = frame.values / size
        specimen = plotter.add_mesh(grid, name="specimen", scalars=label, **looks)
        edges = grid.extract_feature_edges(feature_edges=False, manifold_edges=False, non_manifold_edges=False)
        plotter.add_mesh(edges, name="edges", color="black", line_width=1)
        plotter.add_text(f"step {step}, displacement x {factor_text(factor)}", name="caption", font_size=10)
        return specimen

    colours = show(steps[-1]).mapper  # else the bar is that of the edges
    untyped.add_scalar_bar(label, mapper=colours, vertical=True, position_x=0.88, position_y=0.2, height=0.6)
    if len(steps) > 1:
        place = {"pointa": (0.03, 0.08), "pointb": (0.28, 0.08)}
        untyped.add_slider_widget(show, (steps[0], steps[-1]), value=steps[-1], title="step", fmt="%.0f", **place)
    plotter.camera_position = "xy"
