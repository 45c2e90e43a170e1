"""Signs of the scene: arrows that push or pull, supports outside of the rock, colours of steps."""

from __future__ import annotations

import re

import numpy as np
import pytest
from markupsafe import escape

from crackgrow.case import Case
from crackgrow.results import signs
from crackgrow.results.report.scene import describe_actions, step_colour, svg_of, tag, view_of
from crackgrow.results.units import LENGTHS, STRESSES, rounded, shown, unit_of
from tests.scenes import shipped_case


def loaded(traction: str) -> tuple[Case, list[signs.Arrow]]:
    """The plate with one traction on its top, and the arrows of it."""
    load = f"loads=[{{on: {{body: rock, edge: top}}, traction: {traction}}}]"
    case = shipped_case("compression30", [load])
    (sign,) = signs.load_signs(case)
    arrows = [mark for mark in sign.marks if isinstance(mark, signs.Arrow)]
    return case, sorted(arrows, key=lambda arrow: float(arrow.tail[0]))


def test_arrows_push_on_the_edge_or_pull_from_it() -> None:
    for way in (-1, 1):
        case, arrows = loaded(f"[0, {3 * way}]")
        top, size = 0.0275, signs.size_of(case)
        near = [(arrow.head if way < 0 else arrow.tail)[1] for arrow in arrows]
        np.testing.assert_allclose(near, top + signs.GAP * size)
        np.testing.assert_allclose([arrow.head - arrow.tail for arrow in arrows], [[0.0, way * signs.ARROW * size]] * 7)
        np.testing.assert_allclose([arrow.tail[0] for arrow in arrows], 0.031 * (np.arange(7) - 3) / 7, atol=1e-15)


def test_shear_runs_beside_the_edge_in_its_direction() -> None:
    case, arrows = loaded("[2, 0]")
    assert {round(arrow.tail[1] - 0.0275, 9) for arrow in arrows} == {round(signs.SHEAR_GAP * signs.size_of(case), 9)}
    assert all(arrow.head[0] > arrow.tail[0] and arrow.head[1] == arrow.tail[1] for arrow in arrows)


def test_arrows_are_as_long_as_a_traction_that_varies_is_large() -> None:
    _, arrows = loaded('[0, "-1 - 20*(x + 15.5)/31"]')
    lengths = np.array([arrow.tail[1] - arrow.head[1] for arrow in arrows])
    assert (np.diff(lengths) > 0.0).all()
    places = np.array([arrow.tail[0] for arrow in arrows])
    expected = 1.0 + 20.0 * (places + 0.0155) / 0.031
    np.testing.assert_allclose(lengths / lengths[-1], expected / expected[-1])


@pytest.mark.parametrize("rolls", [True, False])
def test_a_support_stands_outside_with_its_apex_at_the_point(rolls: bool) -> None:
    held = "{y: 0}" if rolls else "{x: 0, y: 0}"
    first, other = f"at: [-15.5, -27.5], displacement: {held}", "at: [15.5, -27.5], displacement: {x: 0, y: 0}"
    case = shipped_case("compression30", [f"supports=[{{{first}}}, {{{other}}}]"])
    sign, _ = signs.support_signs(case)
    (triangle,) = (mark for mark in sign.marks if isinstance(mark, signs.Polygon))
    np.testing.assert_allclose(triangle.corners[0], [-0.0155, -0.0275])
    assert (triangle.corners[1:, 1] < -0.0275).all()
    assert sum(isinstance(mark, signs.Circle) for mark in sign.marks) == (2 if rolls else 0)


@pytest.mark.parametrize("name", ["brazilian_disk", "slope_safety", "cyclic_friction", "two_flaws"])
def test_signs_are_drawn_mark_by_mark(name: str) -> None:
    case = shipped_case(name)
    for sign in (*signs.support_signs(case), *signs.load_signs(case)):
        drawn = svg_of(sign, view_of(case))
        assert drawn.count('class="head"') == sum(isinstance(mark, signs.Arrow) for mark in sign.marks)
        assert drawn.count("<circle") == sum(isinstance(mark, signs.Circle) for mark in sign.marks)
        assert f"<title>{escape(sign.title)}</title>" in drawn
        assert "nan" not in drawn


def test_view_keeps_proportions() -> None:
    case = shipped_case("compression30")
    corners = view_of(case).pixels(case.bodies[0].outline)
    width, height = np.ptp(corners, axis=0)
    assert width / height == pytest.approx(31 / 55)
    assert corners[0, 1] > corners[2, 1]  # the first corner is at the bottom, further down in the picture


def test_actions_are_told_in_words() -> None:
    told = dict(describe_actions(shipped_case("compression30")))
    assert told["supports.0"] == "at: [-0.0155, -0.0275], displacement: {y: 0}, body: rock"
    assert told["loads.1"] == "on: {body: rock, edge: bottom}, traction: [0, 1e+08], held: false"


def test_every_step_has_a_colour_of_its_own() -> None:
    assert len({step_colour(step, 60) for step in range(1, 61)}) == 60
    assert re.fullmatch("#[0-9a-f]{6}", step_colour(1, 1))


def test_markup_is_escaped_once() -> None:
    inner = tag("b", '<&">')
    assert inner == "<b>&lt;&amp;&#34;&gt;</b>"
    assert tag("p", inner, title="a'b", data_x=None) == f'<p title="a&#39;b">{inner}</p>'


def test_numbers_are_shown_in_the_unit_that_suits_them() -> None:
    assert unit_of([3e6, -2.5e8, float("nan")], STRESSES) == (1e6, "MPa")
    assert unit_of([1e-3], LENGTHS) == (1e-3, "mm")
    assert unit_of([], LENGTHS) == unit_of([0.0], LENGTHS) == (1e-9, "nm")
    assert rounded(1.23456789e6, 1e6) == 1.23457
    assert rounded(float("inf")) is None
    assert shown(float("nan")) == "\N{EN DASH}"
