"""Cracked interfaces: G at their tips, which is that of a crack in one body; growth along lines and round corners."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import shapely

from crackgrow.fracture.debond import Debond, bonds
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.run.result import InterfaceTipResult
from tests.solving import whole_run
from tests.verification.solutions import case_of, solve_case

E_PRIME = 20e9 / (1.0 - 0.25**2)
ENDS = np.array([[-8.0, -2.0], [8.0, 4.0]])  # mm
RISE = 0.375  # of the line through them


def traction(x: float, y: float) -> dict[str, Any]:
    """A load on the top edge."""
    return {"on": {"body": "upper", "edge": 2}, "traction": [x, y]}


def scene(loads: list[dict[str, Any]], friction: float = 0.0, *, young: float = 20.0, pair: str = "upper lower") -> Any:
    """Two halves of a square of 120 mm, the upper one of another Young's modulus (GPa), cracked between ENDS."""
    left, right = 1.0 - 60.0 * RISE, 1.0 + 60.0 * RISE
    shapes = {
        "upper": [[-60, left], [60, right], [60, 60], [-60, 60]],
        "lower": [[-60, -60], [60, -60], [60, right], [-60, left]],
    }
    rock = {"young": "20 GPa", "poisson": 0.25, "density": "2500 kg/m^3"}
    law = {"friction": friction, "cohesion": 0}
    return {
        "title": "a cracked interface",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "upper": {"shape": {"polygon": shapes["upper"]}, "material": {**rock, "young": f"{young} GPa"}},
            "lower": {"shape": {"polygon": shapes["lower"]}, "material": rock},
        },
        "interfaces": [{"between": pair.split(), "contact": law, "cracked": ENDS.tolist()}],
        "supports": [
            {"on": {"body": "lower", "edge": 0}, "displacement": {"y": 0}},
            {"at": [-60, -60], "displacement": {"x": 0}},
        ],
        "loads": loads,
        "numerics": {"accuracy": "standard"},
    }


def whole(loads: list[dict[str, Any]], friction: float) -> Any:
    """The same crack in one body."""
    given = scene([], friction)
    (interface,) = given.pop("interfaces")
    square = {"polygon": [[-60, -60], [60, -60], [60, 60], [-60, 60]]}
    bodies = {"lower": {**given["bodies"]["lower"], "shape": square}}
    crack = {"path": {"points": ENDS.tolist()}, "contact": interface["contact"]}
    told = [{**load, "on": {"body": "lower", "edge": 2}} if "on" in load else load for load in loads]
    told = [{"crack": "crack", "pressure": load["pressure"]} if "pressure" in load else load for load in told]
    return {
        **given,
        "bodies": bodies,
        "cracks": {"crack": crack},
        "loads": [x for x in told if x.get("body") != "upper"],
    }


def tips_of(given: Any) -> list[InterfaceTipResult]:
    """The tips of the cracked interface, from left to right."""
    tips = solve_case(case_of(given)).result.interface_tips
    return sorted(tips, key=lambda tip: float(tip.point[0]))


@pytest.mark.physics
@pytest.mark.parametrize(
    ("loads", "friction"),
    [
        ([traction(0, 1)], 0.0),
        ([traction(0, -4)], 0.2),
        ([{"interface": ["lower", "upper"], "pressure": 1}], 0.0),
        ([traction(0, 1e-4), *({"body": body, "gravity": [0, 9.81]} for body in ("upper", "lower"))], 0.0),
    ],
    ids=["pulled", "slides with friction", "fluid", "weight"],
)
def test_between_equal_bodies_it_is_that_of_a_crack(loads: list[dict[str, Any]], friction: float) -> None:
    """By Irwin's relation G = (K_I^2 + K_II^2) / E', K by the interaction integral in one body."""
    cracks = sorted(solve_case(case_of(whole(loads, friction))).result.tips, key=lambda tip: float(tip.point[0]))
    K = np.array([np.hypot(tip.K_I, tip.K_II) for tip in cracks])
    tips = tips_of(scene(loads, friction))
    np.testing.assert_allclose([tip.G for tip in tips], K**2 / E_PRIME, rtol=5e-3)
    np.testing.assert_allclose([tip.K for tip in tips], K, rtol=2.5e-3)
    assert max(tip.G_spread / tip.G for tip in tips) < 5e-3


@pytest.mark.physics
def test_it_does_not_matter_which_body_is_named_first() -> None:
    one, other = (tips_of(scene([traction(0, 1)], young=80.0, pair=pair)) for pair in ("upper lower", "lower upper"))
    np.testing.assert_allclose([tip.G for tip in one], [tip.G for tip in other], rtol=1e-6)
    assert [tip.tip for tip in one] == ["start", "end"]
    assert [tip.tip for tip in other] == ["end", "start"]


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
    ends, steps = replace(grown, at=grown.at + 1e-15).path  # on corners but for round-off
    assert (np.diff(arc_lengths(ends)).min() > 1e-9, steps[0], steps[-1]) == (True, 0, 3)


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


GRAIN = """
title: a grain that comes loose
units: {length: mm, stress: MPa}
plane: strain
materials: {rock: {young: 20 GPa, poisson: 0.25}}
bodies:
  plate:
    shape: {rectangle: {center: [0, 0], width: 240, height: 240}, holes: [{disk: {center: [0, 0], radius: 10}}]}
    material: rock
  grain: {shape: {disk: {center: [0, 0], radius: 10}}, material: rock}
interfaces:
  - {between: [plate, grain], contact: {friction: 0, cohesion: 0}, cracked: ENDS, toughness: 10 J/m^2}
supports: minimal
loads: [{far_field: [1, 1, 0]}]
loading: critical
growth: {steps: 2, increment: 1.5, criterion: max_hoop_stress}
numerics: {accuracy: standard}
"""


@pytest.mark.physics
def test_it_goes_on_round_a_grain() -> None:
    """Of an arc of half an angle t in a plate pulled both ways K = s sqrt(pi R sin t) / (1 + sin(t/2)^2) (Tada)."""
    ends = np.deg2rad([-19.5, 19.5])
    cracked = (10.0 * np.stack([np.cos(ends), np.sin(ends)], axis=1)).tolist()
    results, _ = whole_run(case_of(GRAIN, ENDS=cracked))
    for step, result in enumerate(results):
        t = np.deg2rad(19.5 + 9.0 * step)
        K = result.load_factor * 1e6 * np.sqrt(np.pi * 0.01 * np.sin(t)) / (1.0 + np.sin(0.5 * t) ** 2)
        found = [np.arctan2(tip.point[1], tip.point[0]) for tip in result.interface_tips]
        np.testing.assert_allclose(np.sort(found), [-t, t], atol=1e-4)
        assert pytest.approx(10.0 * E_PRIME, rel=1.5e-2) == K**2


@pytest.mark.physics
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
