"""The pictures of README.md, cases/README.md and cases/MAPS.md, drawn anew from runs of their commands.

They are part of `make docs ARGS=--pictures`. The one of the tutorial is drawn by VTK as ParaView draws it, with the
filter, the factor and the colours that the tutorial names. Without a display VTK needs a driver that draws into memory:
EGL or OSMesa.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
import pyvista

from crackgrow.api import run_case
from crackgrow.case import load_case
from crackgrow.cli.start import template_text
from crackgrow.results.render import render
from tests.scenes import shipped_case

ROOT = Path(__file__).resolve().parents[2]
PICTURES = ROOT / ".readme"
TUTORIAL: Final = re.compile(r"\*Scale Factor\* of (\S+),.*?rescale its range to (\S+) to (\S+) Pa", re.DOTALL)
"""What the tutorial says of its picture: factor of the displacements, limits of the colours."""

SIZE: Final = (800, 800)
BACKGROUND: Final = "#525870"  # ParaView's


def draw_all() -> None:
    """Run the cases in a folder that goes again, and draw the pictures."""
    with tempfile.TemporaryDirectory() as folder:
        runs = Path(folder)
        run_case(shipped_case("compression30"), runs / "compression30")
        *_, last = render(runs / "compression30")
        shutil.copy(last, PICTURES / "compression30.png")
        (runs / "my_rock.yaml").write_text(template_text("compression"), encoding="utf-8")
        run_case(load_case(runs / "my_rock.yaml"), runs / "my_rock")
        run_case(shipped_case("joint_map"), runs / "joint_map")
        shutil.copy(runs / "joint_map" / "figures" / "path.png", PICTURES / "joint_map.png")
        draw_laws(PICTURES / "joint_laws.png")
        draw_series(runs / "my_rock" / "my_rock.pvd", PICTURES / "paraview.png")


LAWS = (
    # scene, settings, displacement at factor 1 (mm), column of its force (N/m), width of the specimen (m)
    ("vein_in_tension", [], 0.04, "supports.1.force_y", 0.05),
    ("rough_joint_sheared", ["loading.follow=events"], 6.0, "supports.1.force_x", 0.4),
    ("barton_bandis", ["loading.follow=events"], 2.0, "supports.1.force_x", 0.4),
)


def draw_laws(picture: Path) -> None:
    """Draw the stress that joints of three laws carry over the displacement that their scenes give them."""
    figure, axes = plt.subplots(1, len(LAWS), figsize=(10.0, 3.0), layout="constrained")
    for plot, (scene, settings, most, column, width) in zip(axes, LAWS, strict=True):
        run = run_case(shipped_case(scene, settings))
        told = [result.history for result in run.results if result.history is not None]
        factor = np.concatenate([[0.0], *(each.load_factor for each in told)])
        force = np.concatenate([[0.0], *(each.values[:, each.columns.index(column)] for each in told)])
        plot.plot(most * factor, force / width / 1e6)
        plot.set(xlabel="given displacement [mm]", ylabel="stress [MPa]", title=f"{scene}.yaml")
        plot.grid(alpha=0.3)
    figure.savefig(picture, dpi=100)


def tutorial_settings() -> tuple[float, float, float]:
    """Factor of the displacements and limits of the colours (Pa) in the tutorial; raises ValueError without them."""
    found = TUTORIAL.search((ROOT / "README.md").read_text(encoding="utf-8"))
    if found is None:
        raise ValueError(f"README.md says nowhere: {TUTORIAL.pattern}")
    factor, low, high = map(float, found.groups())
    return factor, low, high


def draw_series(series: Path, picture: Path) -> None:
    """Draw the last frame of a .pvd file with `sigma_1` of its points, displaced, as the tutorial says."""
    factor, low, high = tutorial_settings()
    reader = pyvista.PVDReader(str(series))
    reader.set_active_time_value(reader.time_values[-1])
    (grid,) = reader.read()
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=SIZE)
    plotter.set_background(BACKGROUND)
    bar = {"title": "sigma_1", "vertical": True, "position_x": 0.82, "position_y": 0.3, "height": 0.4, "color": "w"}
    warped = grid.warp_by_vector("displacement", factor=factor)
    looks = {"cmap": "coolwarm", "clim": (low, high), "lighting": False, "scalar_bar_args": bar}
    plotter.add_mesh(warped, scalars="sigma_1", preference="point", **looks)
    plotter.enable_parallel_projection()
    plotter.view_xy()
    plotter.screenshot(picture)
    plotter.close()
