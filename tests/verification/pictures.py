"""Pictures of the verification scenes: curves along the faces with their references, deformed blocks, convergence."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from crackgrow.results.drawn_frame import boundary_edges
from crackgrow.run.result import Frame
from tests.verification.rows import block, closed_crack, confined, convergence, history, interface, path
from tests.verification.solutions import table

Floats = NDArray[np.float64]

FOUND = {"marker": "o", "markersize": 3.5, "linewidth": 1.0, "color": "tab:red"}
REFERENCE = {"linewidth": 2.5, "color": "0.75", "zorder": 1}


def draw_all(folder: Path) -> None:
    """Write every picture as PNG into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    draw_interface(folder / "interface.png")
    draw_block(folder / "block.png")
    draw_closed_crack(folder / "closed_crack.png")
    draw_convergence(folder / "convergence.png")
    draw_wing(folder / "wing.png")
    draw_reversed_shear(folder / "reversed_shear.png")
    draw_confined_wings(folder / "confined_wings.png")


def draw_interface(place: Path) -> None:
    """Example 1: pressure, shear, slip and the displaced blocks for both coefficients of friction (figures 5 to 8)."""
    figure, panels = _panels(2, 4)
    for friction, row in zip(("0.1", "0.4"), panels, strict=True):
        solution, reference = interface.at(friction), table(f"interface_strain_friction{friction}.csv")
        contact = solution.result.contact
        x = contact.points[:, 0]
        row[0].plot(reference["x_m"], reference["normal_pressure_Pa"] / 1e6, label="reference", **REFERENCE)
        row[0].plot(x, -contact.normal_traction / 1e6, label="crackgrow, spacing 0.05 m", **FOUND)
        row[1].plot(reference["x_m"], np.abs(reference["shear_Pa"]) / 1e6, **REFERENCE)
        row[1].plot(x, np.abs(contact.tangential_traction) / 1e6, **FOUND)
        row[0].set(title=f"friction {friction}", xlabel="x [m]", ylabel="pressure [MPa]")
        row[1].set(title=f"friction {friction}", xlabel="x [m]", ylabel="shear [MPa]")
        row[2].plot(reference["x_m"], 1e3 * np.abs(reference["slip_m"]), **REFERENCE)
        row[2].plot(x, 1e3 * np.abs(contact.slip), **FOUND)
        row[2].set(title=f"friction {friction}", xlabel="x [m]", ylabel="slip [mm]")
        row[0].legend(fontsize=7)
        _draw_displaced(row[3], solution.result.frame, 1.0)
    _save(place, figure)


def draw_block(place: Path) -> None:
    """Example 2: pressure and shear at the paper's spacing and a finer one, the displaced block (figures 11, 12)."""
    figure, panels = _panels(1, 3)
    line = np.linspace(-1.99, 1.99, 400)
    for what, axes in enumerate(panels[0][:2]):
        axes.plot(line, block.reference(line)[what], label="reference", **REFERENCE)
        for spacing, colour in ((0.2, "tab:blue"), (0.05, "tab:red")):
            x, *found = block.pressure_and_shear(block.at("block_rigid", spacing, 1.5))
            axes.plot(x, found[what], **{**FOUND, "color": colour}, label=f"crackgrow, spacing {spacing} m")
        axes.set(xlabel="x [m]", ylabel=("pressure [Pa]", "shear on the block, towards -x [Pa]")[what])
    panels[0][0].set(ylim=(0, 600))
    panels[0][1].set(ylim=(-100, 250))
    panels[0][0].legend(fontsize=7)
    _draw_displaced(panels[0][2], block.at("block_rigid", 0.2, 1.5).result.frame, 1.0)
    _save(place, figure)


def draw_closed_crack(place: Path) -> None:
    """Example 3 before growth: slip, pressure and shear along the crack, with and without friction."""
    figure, panels = _panels(1, 3)
    for friction, colour in ((0.0, "tab:blue"), (0.3, "tab:red")):
        solution = closed_crack.closed(friction, 0.75)
        reference = table(f"closed_crack_theta30_friction{friction:g}.csv")
        contact, along = solution.result.contact, closed_crack.HALF_LENGTH * np.sin(np.linspace(-1.57, 1.57, 201))
        s = 1e3 * (contact.s - closed_crack.HALF_LENGTH)
        style = {**FOUND, "color": colour}
        for axes, column in zip(panels[0], ("slip_mm", "normal_pressure_MPa", "shear_MPa"), strict=True):
            axes.plot(reference["s_mm"], np.abs(reference[column]), label="" if friction else "reference", **REFERENCE)
        slip = 1e3 * np.abs(solution.jump(along + closed_crack.HALF_LENGTH)[1])
        panels[0][0].plot(1e3 * along, slip, **{**style, "marker": ""}, label=f"friction {friction}")
        panels[0][1].plot(s, -contact.normal_traction / 1e6, **style)
        panels[0][2].plot(s, np.abs(contact.tangential_traction) / 1e6, **style)
    for axes, label in zip(panels[0], ("slip [mm]", "pressure [MPa]", "shear [MPa]"), strict=True):
        axes.set(xlabel="s from the middle [mm]", ylabel=label)
    panels[0][1].set(ylim=(73, 76))
    panels[0][0].legend(fontsize=7)
    _save(place, figure)


def draw_convergence(place: Path) -> None:
    """Errors over the spacing: displacement, K, pressure and shear."""
    figure, panels = _panels(1, 3)
    for support in convergence.SUPPORTS:
        spacings = (*convergence.SPACINGS, 1.5)
        errors = [convergence.displacement_error(spacing, support) for spacing in spacings]
        panels[0][0].loglog(spacings, errors, marker="o", label=f"support {support}")
        errors = [convergence.K_error(spacing, support) for spacing in convergence.CRACK_SPACINGS]
        panels[0][1].loglog(convergence.CRACK_SPACINGS, errors, marker="o", label=f"support {support}")
    for friction, what in (("0.1", "pressure"), ("0.4", "shear")):
        errors = [interface.curve_error(friction, what, spacing) for spacing in interface.SPACINGS]
        panels[0][2].loglog(interface.SPACINGS, errors, marker="o", label=f"{what}, friction {friction}")
    panels[0][0].set(title="plate with a hole", xlabel="spacing [mm]", ylabel="L2 error of the displacement")
    panels[0][1].set(title="edge crack in tension", xlabel="spacing [mm]", ylabel="error of K_I")
    panels[0][2].set(title="interface", xlabel="spacing [m]", ylabel="L2 difference from the reference")
    for axes in panels[0]:
        axes.legend(fontsize=7)
        axes.grid(which="both", linewidth=0.3)
    _save(place, figure)


def draw_wing(place: Path) -> None:
    """The right wing of compression30 and its reference."""
    figure, ((axes, *_),) = _panels(1, 1)
    reference = table("wing_path_theta30.csv")
    axes.plot(reference["x_mm_LS_inc05"], reference["y_mm"], label="reference, K_II = 0, steps of 0.5 mm", **REFERENCE)
    for settings, label, colour in (
        ((), "directional_strength, 2 mm", "tab:blue"),
        (path.IMPLICIT, "max_hoop_stress, implicit, 2 mm", "tab:red"),
    ):
        axes.plot(*path.right_wing(*settings).T, **{**FOUND, "color": colour}, label=label)
    axes.set(xlabel="x [mm]", ylabel="y [mm]")
    axes.legend(fontsize=7)
    _save(place, figure)


def draw_reversed_shear(place: Path) -> None:
    """Shear that goes back and forth: the loop of the mean slip, and the energy that friction takes."""
    figure, ((loop, energy),) = _panels(1, 2)
    cycle, crack = history.cycle(), history.CRACK
    corners = np.concatenate([[0.0], cycle.shear])
    path = np.interp(np.linspace(0.0, len(corners) - 1.0, 60 * len(corners)), np.arange(len(corners)), corners)
    loop.plot(1e6 * crack.mean_slip(path), path / 1e6, label="reference, infinite plate", **REFERENCE)
    style = {**FOUND, "linewidth": 0.0}
    loop.plot(1e6 * cycle.mean_slip, cycle.shear / 1e6, label="crackgrow, one point a load step", **style)
    loop.set(xlabel="mean slip [micrometre]", ylabel="shear stress on the plate [MPa]")
    loop.axhline(0.0, color="0.6", linewidth=0.4)
    loop.axvline(0.0, color="0.6", linewidth=0.4)
    loop.legend(fontsize=7)
    steps = np.linspace(0.0, len(cycle.shear), len(path))
    energy.plot(steps, crack.dissipated(path), **REFERENCE)
    energy.plot(np.arange(1, len(cycle.shear) + 1), cycle.dissipated, **style)
    energy.set(xlabel="load step", ylabel="energy dissipated by friction [J/m]")
    _save(place, figure)


def draw_confined_wings(place: Path) -> None:
    """K_I of growing wings under lateral pressure, the sliding-crack model, and where both fall through the toughness.

    Beside them the lengths at arrest over the pressure; bars: by elements in an infinite plate.
    """
    figure, ((curves, arrests, *_),) = _panels(1, 2)
    lengths, toughness = np.linspace(0.0, 14e-3, 200), confined.TOUGHNESS
    for percent, colour in zip(confined.STEPS, ("tab:green", "tab:blue", "tab:red", "tab:purple"), strict=True):
        model, wing = confined.model(percent), confined.wing_at(percent)
        K_I = np.array([model.K_I(length) for length in lengths])
        curves.plot(1e3 * lengths, K_I / 1e6, color=colour, linewidth=1.2, label=f"{percent:g} %")
        infinite = confined.in_infinite_plate(wing, percent)
        curves.plot(1e3 * wing.length, infinite.K_I / 1e6, linewidth=0.8, linestyle=":", color=colour)
        curves.plot(1e3 * wing.length, wing.K_I / 1e6, marker="o", markersize=3.5, linestyle="", color=colour)
        if percent:
            arrests.plot(percent, 1e3 * wing.arrest_length(toughness), marker="o", markersize=5, color=colour)
            arrests.plot(percent, 1e3 * infinite.arrest_length(toughness), marker="_", markersize=10, color="0.3")
    curves.axhline(toughness / 1e6, color="0.4", linewidth=1.0, linestyle="--")
    curves.text(13.9, toughness / 1e6 + 0.02, "$K_c$", ha="right", va="bottom", fontsize=8)
    curves.set(xlabel="length of a wing [mm]", ylabel="K_I [MPa sqrt(m)]", xlim=(0, 14), ylim=(0, 2.3))
    title = "lateral pressure / axial stress;\npoints: crackgrow, lines: model,\ndotted: elements, infinite plate"
    curves.legend(title=title, fontsize=7, title_fontsize=7)
    pressures = np.linspace(1.0, 11.0, 100)
    modelled = np.array([confined.model(percent).arrest_length(toughness) for percent in pressures])
    arrests.fill_between(pressures, 0.8e3 * modelled, 1.2e3 * modelled, color="0.9", label="within 20 %")
    arrests.plot(pressures, 1e3 * modelled, label="model", **REFERENCE)
    arrests.set(
        xlabel="lateral pressure / axial stress [%]", ylabel="length at arrest [mm]", xlim=(0, 11), ylim=(0, 20)
    )
    arrests.legend(fontsize=7)
    _save(place, figure)


def _draw_displaced(axes: Axes, frame: Frame, magnification: float) -> None:
    """The specimen displaced, coloured by its normal stress in y."""
    points = frame.points + magnification * frame.displacement
    stress = frame.stress[:, 1]
    scale, unit = (1e-6, "MPa") if np.abs(stress).max() > 1e4 else (1.0, "Pa")
    cells: Sequence[Floats] = [*points[frame.triangles.reshape(-1, 3)], *points[frame.quads.reshape(-1, 4)]]
    low, high = np.percentile(stress * scale, (2.0, 98.0))
    filled = PolyCollection(cells, array=stress * scale, cmap="viridis", edgecolors="none", antialiaseds=False)
    filled.set_clim(low, high)
    axes.add_collection(filled)
    axes.add_collection(LineCollection(list(points[boundary_edges(frame)]), colors="0.15", linewidths=0.6))
    axes.autoscale_view()
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"displacement x {magnification:g}")
    axes.figure.colorbar(filled, ax=axes, label=f"sigma_yy [{unit}]", extend="both")


def _panels(n_rows: int, n_columns: int) -> tuple[Figure, NDArray[np.object_]]:
    figure = Figure(figsize=(4.2 * n_columns, 3.4 * n_rows), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(n_rows, n_columns, squeeze=False)


def _save(place: Path, figure: Figure) -> None:
    figure.savefig(place)
