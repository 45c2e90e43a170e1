"""Scenes that random ones came down to: each of them was refused or wrong once, without need."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case.surface import crack_name
from crackgrow.cover.cover import Cover, build_cover
from crackgrow.cover.lattice import place_lattice
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.geometry.tolerance import ON_LINE
from tests.stability.growing_scenes import Scene, text_of
from tests.stability.judge.written import WrittenRun, run_case

HELD = {"body": "rock", "edge": "2"}
TRIANGLE = [[4.0, -10.0], [-6.0, -9.0], [-0.6, -20.0]]


def run(folder: Path, corners: list, material: dict, cracks: Scene, load: dict, numerics: dict) -> WrittenRun:
    """A polygon held at its edge 2."""
    document = {
        "title": "a polygon",
        "plane": "strain",
        "bodies": {"rock": {"shape": {"polygon": corners}, "material": material}},
        "cracks": cracks,
        "supports": [{"on": HELD, "displacement": {"x": 0, "y": 0}}],
        "loads": [load],
        "numerics": numerics,
        "output": {"frames": "none", "figures": False, "report": False},
    }
    (folder / "scene.yaml").write_text(text_of(document), encoding="utf-8")
    return run_case(folder / "scene.yaml", folder / "out")


@pytest.mark.parametrize("traction", [[5.0, -6.0], [0.0, 1.0]], ids=["oblique", "along y"])
def test_loads_on_nothing_but_held_rock_move_nothing(tmp_path: Path, traction: list[float]) -> None:
    """All displacements are round-off then: what supports miss by as much is no contradiction."""
    load = {"on": HELD, "traction": traction}
    found = run(tmp_path, TRIANGLE, {"young": 4e4, "poisson": 0.2}, {}, load, {"spacing": 0.8})
    length = np.hypot(4.6, 10.0)
    (force,) = found.tables["reactions"][["force_x", "force_y"]].to_numpy()
    np.testing.assert_allclose(force, -length * np.array(traction), atol=1e-9 * length)


def covered(corners: np.ndarray, path: np.ndarray, support: float) -> Cover:
    """A polygon with a crack that starts on its outline."""
    lattice = place_lattice(corners.min(axis=0), corners.max(axis=0), 1.0, support)
    crack = CrackGeometry(crack_name("flaw"), lattice.to_lattice(path), False, True)
    return build_cover(lattice, [BodyGeometry((lattice.to_lattice(corners),))], [crack])


def assert_whole(cover: Cover) -> None:
    """The crack is cut into edges from its start to its tip."""
    edges = cover.surfaces[0].edges
    assert len(cover.tips) == 1
    assert edges.s[0, 0] == pytest.approx(0.0, abs=ON_LINE)
    assert edges.s[-1, 1] == pytest.approx(np.hypot(*np.diff(cover.cracks[0].points, axis=0)[0]), abs=ON_LINE)


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_cracks_start_anywhere_on_a_slanting_side(support: float) -> None:
    """Rounding puts the end to either side of the outline; a speck of rock between them would cut the crack short."""
    corners = np.array([[0.0, 0.0], [7.3, 1.9], [5.1, 6.7]])
    for share in np.random.default_rng(4).uniform(0.15, 0.85, 40):
        start = (1.0 - share) * corners[0] + share * corners[1]
        assert_whole(covered(corners, np.array([start, corners.mean(axis=0)]), support))
