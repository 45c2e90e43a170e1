"""The pictures of README.md can be drawn anew: the tutorial names what its picture shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.image import imread

from tests.readme.pictures import BACKGROUND, SIZE, draw_series, tutorial_settings
from tests.report_runs import make_run


def test_the_tutorial_names_factor_and_colours_of_its_picture() -> None:
    factor, low, high = tutorial_settings()
    assert factor >= 1.0
    assert -low == high > 0.0


def test_a_series_is_drawn_off_screen_on_the_ground_of_paraview(tmp_path: Path) -> None:
    folder = make_run(tmp_path / "run", ["output.frames=every_step", "growth.steps=1"])
    (series,) = (path for path in folder.glob("*.pvd") if "cracks" not in path.name)
    draw_series(series, tmp_path / "a.png")
    image = np.round(255 * imread(tmp_path / "a.png")[..., :3]).astype(int)
    assert image.shape[:2] == SIZE[::-1]
    ground = np.array([int(BACKGROUND[k : k + 2], 16) for k in (1, 3, 5)])
    behind = (np.abs(image - ground).max(axis=2) <= 1).mean()
    assert 0.3 < behind < 0.8
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 100  # the colours of a field, not one a cell
