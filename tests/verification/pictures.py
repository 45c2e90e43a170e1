"""The picture of the verification page: wings under lateral pressure, beside their model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tests.verification.rows import confined


def draw_confined_wings(place: Path) -> None:
    """K_I of growing wings under lateral pressure, the sliding-crack model, and where both fall through the toughness.

    Beside them the lengths at arrest over the pressure; bars: by elements in an infinite plate.
    """
    figure = Figure(figsize=(8.4, 3.4), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    curves, arrests = figure.subplots(1, 2)
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
    arrests.plot(pressures, 1e3 * modelled, label="model", linewidth=2.5, color="0.75", zorder=1)
    arrests.set(
        xlabel="lateral pressure / axial stress [%]", ylabel="length at arrest [mm]", xlim=(0, 11), ylim=(0, 20)
    )
    arrests.legend(fontsize=7)
    figure.savefig(place)
