"""Growth of cracked parts of interfaces: along lines and round corners, up to what they meet; energy is balanced."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import shapely

from crackgrow.fracture.debond import Debond, bonds
from crackgrow.geometry.polyline import arc_lengths
from tests.unit.fracture.test_interface_tips import scene
from tests.verification.solutions import case_of
from tests.whole_run import whole_run

LINE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 6.0]])  # turns at 4, ends at 10
NOTHING = shapely.MultiPoint()


def debond(first: float, last: float) -> Debond:
    """What is cracked of the line between two of its arc lengths."""
    return Debond(("a", "b"), LINE, 1.0, np.array([first, last]), np.zeros(2, dtype=np.int64))


@pytest.mark.parametrize(
    ("increment", "tip", "met"),
    [
        (0.2, 2.6, ""),
        (1.4, 3.3, ""),  # 3.8, but for half an increment from the corner
        (2.0, 5.0, ""),  # 4.4, but for half an increment behind the corner
        (3.0, 5.5, ""),
        (7.5, 10.0, "the end of the interface"),  # 9.9 is within a tenth of an increment of it
        (9.0, 10.0, "the end of the interface"),
    ],
)
def test_it_goes_along_the_line_and_keeps_from_corners(increment: float, tip: float, met: str) -> None:
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
    assert (grown.at[-1], reached) == (6.0, "a crack")
    grown, reached = grown.advanced(True, 2.0, 2, touching)
    assert reached == ""  # behind it it would be another one
    np.testing.assert_allclose(grown.points, [[1.0, 0.0], [4.0, 0.0], [4.0, 4.0]])


def test_what_is_left_is_bonded() -> None:
    parts = list(bonds((LINE, LINE + 20.0), [Debond(("a", "b"), LINE, 1.0, np.array([3.0, 10.0]), np.zeros(2, int))]))
    np.testing.assert_allclose(parts[0], [[0, 0], [3, 0]])
    np.testing.assert_allclose(parts[1], LINE + 20.0)


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
