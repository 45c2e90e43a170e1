"""Growth of cracked parts of interfaces: along lines and round corners, up to what they meet; energy is balanced."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import shapely

from crackgrow.fracture.debond import Debond, bonds
from crackgrow.geometry.polyline import arc_lengths
from tests.solving import whole_run
from tests.unit.fracture.test_interface_tips import E_PRIME, scene
from tests.verification.solutions import case_of

LINE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 6.0]])  # turns at 4, ends at 10
NOTHING = shapely.MultiPoint()


def debond(first: float, last: float) -> Debond:
    """What is cracked of the line between two of its arc lengths."""
    return Debond(("a", "b"), LINE, 1.0, np.array([first, last]), np.zeros(2, dtype=np.int64))


@pytest.mark.parametrize(
    ("increment", "tip", "met"),
    [
        (0.2, 2.6, False),
        (1.4, 3.3, False),  # 3.8, but for half an increment from the corner
        (2.0, 5.0, False),  # 4.4, but for half an increment behind the corner
        (3.0, 5.5, False),
        (7.5, 10.0, True),  # 9.9 is within a tenth of an increment of it
        (9.0, 10.0, True),
    ],
)
def test_it_goes_along_the_line_and_keeps_from_corners(increment: float, tip: float, met: bool) -> None:
    grown, reached = debond(1.0, 2.4).advanced(True, increment, 3, NOTHING)
    assert reached == met
    assert grown.at[-1] == pytest.approx(tip, abs=1e-12)
    assert arc_lengths(grown.points)[-1] == pytest.approx(grown.at[-1] - 1.0)
    mirrored = Debond(("a", "b"), LINE[::-1], 1.0, 10.0 - grown.at[1::-1], np.zeros(2, dtype=np.int64))
    back, reached = mirrored.advanced(False, increment, 3, NOTHING)
    assert reached == met
    np.testing.assert_allclose(back.points, grown.points[::-1], atol=1e-12)
    assert (grown.n_advances(True), grown.n_advances(False), back.n_advances(False)) == (1, 0, 1)


def test_it_ends_on_a_crack_that_touches_the_interface() -> None:
    touching = shapely.MultiPoint([[4.0, 2.0], [1.0, 1.0]])
    grown, reached = debond(1.0, 4.5).advanced(True, 2.0, 1, touching)
    assert (grown.at[-1], reached) == (6.0, True)
    grown, reached = grown.advanced(True, 2.0, 2, touching)
    assert not reached  # behind it it would be another one
    np.testing.assert_allclose(grown.points, [[1.0, 0.0], [4.0, 0.0], [4.0, 4.0]])


def test_what_is_left_is_bonded() -> None:
    parts = list(bonds((LINE, LINE + 20.0), [Debond(("a", "b"), LINE, 1.0, np.array([3.0, 10.0]), np.zeros(2, int))]))
    np.testing.assert_allclose(parts[0], [[0, 0], [3, 0]])
    np.testing.assert_allclose(parts[1], LINE + 20.0)


def test_it_goes_on_round_a_grain() -> None:
    """Of an arc of half an angle t in a plate pulled both ways K = s sqrt(pi R sin t) / (1 + sin(t/2)^2) (Tada)."""
    rock, ends = {"young": "20 GPa", "poisson": 0.25}, np.deg2rad([-19.5, 19.5])
    disk = {"disk": {"center": [0, 0], "radius": 10}}
    given = {
        "title": "a grain that comes loose",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "plate": {
                "shape": {"rectangle": {"center": [0, 0], "width": 240, "height": 240}, "holes": [disk]},
                "material": rock,
            },
            "grain": {"shape": disk, "material": rock},
        },
        "interfaces": [
            {
                "between": ["plate", "grain"],
                "contact": {"friction": 0, "cohesion": 0},
                "cracked": (10.0 * np.stack([np.cos(ends), np.sin(ends)], axis=1)).tolist(),
                "toughness": "10 J/m^2",
            }
        ],
        "supports": "minimal",
        "loads": [
            {"on": {"body": "plate", "edge": edge}, "traction": traction}
            for edge, traction in (("left", [-1, 0]), ("right", [1, 0]), ("top", [0, 1]), ("bottom", [0, -1]))
        ],
        "loading": "critical",
        "growth": {"steps": 2, "increment": 1.5, "criterion": "max_hoop_stress"},
        "numerics": {"accuracy": "standard"},
    }
    results, _ = whole_run(case_of(given))
    for step, result in enumerate(results):
        t = np.deg2rad(19.5 + 9.0 * step)
        K = result.load_factor * 1e6 * np.sqrt(np.pi * 0.01 * np.sin(t)) / (1.0 + np.sin(0.5 * t) ** 2)
        found = [np.arctan2(tip.point[1], tip.point[0]) for tip in result.interface_tips]
        np.testing.assert_allclose(np.sort(found), [-t, t], atol=1e-4)
        assert pytest.approx(10.0 * E_PRIME, rel=1.5e-2) == K**2


def test_what_growth_releases_is_its_G_times_the_length() -> None:
    """At held grips, along an increment the mean of G at both of its ends: to the second order in its length."""
    given = scene([])
    given["interfaces"][0]["toughness"] = "1 J/m^2"
    held = {"x": 0, "y": 0}
    given["supports"] = [
        {"on": {"body": "lower", "edge": 0}, "displacement": held},
        {"on": {"body": "upper", "edge": 2}, "displacement": {"y": 0.0075}},
    ]
    given["growth"] = {"steps": 2, "increment": 1, "criterion": "max_hoop_stress", "unload_between_steps": False}
    results, _ = whole_run(case_of(given))
    G = [np.array([tip.G for tip in result.interface_tips]) for result in results]
    released = [float((0.5 * (before + after)).sum()) * 1e-3 for before, after in pairwise(G)]
    np.testing.assert_allclose(np.diff([result.energy.released for result in results]), released, rtol=3e-3)
