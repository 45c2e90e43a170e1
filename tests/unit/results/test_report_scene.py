"""Signs of the scene: arrows that push or pull, supports outside of the rock, colours of steps."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.results.report import symbols
from crackgrow.results.report.markup import Markup, tag, text
from crackgrow.results.report.scene import describe_actions, step_colour
from crackgrow.results.report.view import view_of
from crackgrow.results.units import LENGTHS, STRESSES, rounded, shown, unit_of

CASES = Path(__file__).resolve().parents[3] / "cases"
EDGE = np.array([[0.0, 50.0], [100.0, 50.0]])
UP = np.array([0.0, -1.0])  # the picture's y is downwards


def heads(drawn: Markup) -> list[tuple[float, float]]:
    """Points of the heads of arrows."""
    found = re.findall(r'd="M([-\d.]+),([-\d.]+)L[^"]*" class="head"', drawn)
    return [(float(x), float(y)) for x, y in found]


def shafts(drawn: Markup) -> list[tuple[float, float]]:
    """Tails of arrows."""
    found = re.findall(r'd="M([-\d.]+),([-\d.]+)L[^"]*" class="shaft"', drawn)
    return [(float(x), float(y)) for x, y in found]


def test_arrows_push_on_the_edge_or_pull_from_it() -> None:
    pushing = symbols.arrows_along(EDGE, -3.0 * UP, UP)
    assert [y for _, y in heads(pushing)] == [50.0] * 4
    assert all(y == 50.0 - symbols.ARROW for _, y in shafts(pushing))
    pulling = symbols.arrows_along(EDGE, 3.0 * UP, UP)
    assert [y for _, y in shafts(pulling)] == [50.0] * 4
    assert all(y == 50.0 - symbols.ARROW for _, y in heads(pulling))
    assert [x for x, _ in heads(pulling)] == [12.5, 37.5, 62.5, 87.5]


def test_shear_runs_beside_the_edge_in_its_direction() -> None:
    drawn = symbols.arrows_along(EDGE, np.array([2.0, 0.0]), UP)
    assert {y for _, y in heads(drawn)} == {45.0}
    assert all(head[0] - tail[0] == symbols.ARROW for head, tail in zip(heads(drawn), shafts(drawn), strict=True))


@pytest.mark.parametrize("rolls", [True, False])
def test_a_support_stands_outside_with_its_apex_at_the_point(rolls: bool) -> None:
    drawn = symbols.triangle(np.array([10.0, 20.0]), np.array([0.0, 1.0]), rolls)
    corners = re.search(r'd="M10\.00,20\.00L(.*?)Z" class="support"', drawn)
    assert corners is not None
    assert {float(pair.split(",")[1]) for pair in corners[1].split("L")} == {20.0 + symbols.TRIANGLE[0]}
    assert ('class="hatch"' in drawn) != rolls


def test_view_keeps_proportions_and_goes_both_ways() -> None:
    case = load_case(CASES / "compression30.yaml")
    view = view_of(case)
    corners = view.pixels(case.bodies[0].outline)
    width, height = np.ptp(corners, axis=0)
    assert width / height == pytest.approx(31 / 55)
    assert corners[0, 1] > corners[2, 1]  # the first corner is at the bottom, further down in the picture
    np.testing.assert_allclose(view.metres(corners), case.bodies[0].outline, atol=1e-12)


def test_actions_are_told_in_words() -> None:
    told = dict(describe_actions(load_case(CASES / "compression30.yaml")))
    assert told["supports.0"] == "at: [-0.0155, -0.0275], displacement: {y: 0}, body: rock"
    assert told["loads.1"] == "on: {body: rock, edge: bottom}, traction: [0, 1e+08], held: false"


def test_every_step_has_a_colour_of_its_own() -> None:
    assert len({step_colour(step, 60) for step in range(1, 61)}) == 60
    assert re.fullmatch("#[0-9a-f]{6}", step_colour(1, 1))


def test_markup_is_escaped_once() -> None:
    inner = tag("b", '<&">')
    assert inner == "<b>&lt;&amp;&quot;&gt;</b>"
    assert tag("p", inner, title="a'b", data_x=None) == f'<p title="a&#x27;b">{inner}</p>'
    assert text(inner) == inner


def test_numbers_are_shown_in_the_unit_that_suits_them() -> None:
    assert unit_of([3e6, -2.5e8, float("nan")], STRESSES) == (1e6, "MPa")
    assert unit_of([1e-3], LENGTHS) == (1e-3, "mm")
    assert unit_of([], LENGTHS) == unit_of([0.0], LENGTHS) == (1e-9, "nm")
    assert rounded(1.23456789e6, 1e6) == 1.23457
    assert rounded(float("inf")) is None
    assert shown(float("nan")) == "\N{EN DASH}"
