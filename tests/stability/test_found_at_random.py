"""Scenes that random ones came down to: each of them was refused or wrong once, without need."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.case.surface import crack_name
from crackgrow.contact.coulomb import STICK
from crackgrow.cover.cover import build_cover
from crackgrow.cover.lattice import place_lattice
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.run import grow
from tests.stability.contact_conditions import recorded, violations
from tests.stability.random_scenes import text_of

HELD = {"on": {"edge": "2", "body": "rock"}, "displacement": {"x": 0, "y": 0}}


def scene(corners: list, material: dict, crack: dict | None, load: dict, spacing: float) -> dict:
    """A polygon held at its edge 2."""
    return {
        "title": "a polygon",
        "plane": "strain",
        "bodies": {"rock": {"shape": {"polygon": corners}, "material": material}},
        "cracks": {} if crack is None else {"flaw": crack},
        "supports": [HELD],
        "loads": [load],
        "numerics": {"spacing": spacing},
        "output": {"frames": "none", "figures": False},
    }


def run(folder: Path, document: dict) -> list:
    path = folder / "scene.yaml"
    path.write_text(text_of(document), encoding="utf-8")
    return list(grow(load_case(path)))


def slipping(friction: float, cohesion: float, angle: float, points: list) -> dict:
    return {
        "path": {"points": points},
        "contact": {"friction": friction, "cohesion": cohesion, "dilation_angle": angle},
    }


IN_SITU = scene(
    [[-7.5, 23.0], [-14.0, 30.0], [-30.0, 30.0], [-33.0, 20.0], [-21.0, 10.0]],
    {"young": 1e6, "poisson": 0.2},
    slipping(0.6, 20.0, 30.0, [[-24.0, 25.0], [-20.0, 20.0]]),
    {"body": "rock", "stress": [-1.0, -7.0, -2.0]},
    4.0,
)
PUSHED = scene(
    [[4.0, -10.0], [-6.0, -9.0], [-0.6, -20.0]],
    {"young": 4e4, "poisson": 0.0},
    slipping(0.8, 1.0, 30.0, [[2.0, -10.0], [3.0, -10.0]]),
    {"on": {"edge": "0", "body": "rock"}, "traction": [5.0, -6.0]},
    1.0,
)


@pytest.mark.parametrize("document", [IN_SITU, PUSHED], ids=["in-situ stress", "traction"])
@pytest.mark.parametrize("solver", ["newton", "lemke"])
def test_faces_that_stick_do_not_open_by_dilation(tmp_path: Path, document: dict, solver: str) -> None:
    """A repetition that put the opening of one solve into the next one never came to rest here."""
    numerics = {**document["numerics"], "contact": {"solver": solver}}
    with recorded() as increments:
        run(tmp_path, {**document, "numerics": numerics})
    (increment,) = increments
    outcome = increment.outcome
    assert set(outcome.points.state.tolist()) == {STICK}
    assert np.abs(outcome.points.dilation).max() < 1e-12 * np.ptp(outcome.u)
    assert max(violations(increment).values()) < 1e-9


@pytest.mark.parametrize("load", [{"traction": [5.0, -6.0]}, {"traction": [0.0, 1.0]}], ids=["oblique", "along y"])
def test_loads_on_nothing_but_held_rock_move_nothing(tmp_path: Path, load: dict) -> None:
    """All displacements are round-off then: what supports miss by as much is no contradiction."""
    document = scene(
        [[4.0, -10.0], [-6.0, -9.0], [-0.6, -20.0]],
        {"young": 4e4, "poisson": 0.2},
        None,
        {**load, "on": HELD["on"]},
        0.8,
    )
    (result,) = run(tmp_path, document)
    (reaction,) = result.reactions
    length = np.hypot(4.0 - (-0.6), -10.0 - (-20.0))
    np.testing.assert_allclose(reaction.force, -length * np.array(load["traction"]), atol=1e-9 * length)


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_cracks_start_anywhere_on_a_slanting_side(support: float) -> None:
    """Rounding puts the end to either side of the outline; a speck of rock between them would cut the crack short."""
    corners = np.array([[0.0, 0.0], [7.3, 1.9], [5.1, 6.7]])
    lattice = place_lattice(corners.min(axis=0), corners.max(axis=0), 1.0, support)
    body = BodyGeometry((lattice.to_lattice(corners),))
    for share in np.random.default_rng(4).uniform(0.15, 0.85, 40):
        start = (1.0 - share) * corners[0] + share * corners[1]
        crack = CrackGeometry(
            crack_name("flaw"), lattice.to_lattice(np.array([start, corners.mean(axis=0)])), False, True
        )
        cover = build_cover(lattice, [body], [crack])
        edges = cover.surfaces[0].edges
        assert edges.s[0, 0] == pytest.approx(0.0, abs=ON_LINE)
        assert edges.s[-1, 1] == pytest.approx(np.hypot(*np.diff(crack.points, axis=0)[0]), abs=ON_LINE)


@pytest.mark.parametrize("width", [5.0, 5.2, 5.4, 5.6, 5.8])
@pytest.mark.parametrize("slope", [0.0, 0.2])
def test_short_cracks_start_on_sides_anywhere_in_a_tile(width: float, slope: float) -> None:
    """What leads on from such a start can reach the last line of the lattice."""
    lattice = place_lattice(np.zeros(2), np.array([width, 4.0]), 1.0, 2.0)
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, 4.0], [0.0, 4.0]])
    body = BodyGeometry((lattice.to_lattice(corners),))
    path = np.array([[width, 1.9], [width - 1.5, 1.9 - 1.5 * slope]])
    cover = build_cover(lattice, [body], [CrackGeometry(crack_name("flaw"), lattice.to_lattice(path), False, True)])
    assert len(cover.tips) == 1
    assert cover.surfaces[0].edges.s[-1, 1] == pytest.approx(np.hypot(1.5, 1.5 * slope), abs=ON_LINE)
