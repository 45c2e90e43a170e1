"""The drawing of a scene: arrows that push or pull, what acts and nothing else, numbers in units that suit them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Annotation

from crackgrow.case import Case, dump_case
from crackgrow.plan.cost import squares_of
from crackgrow.results import signs
from crackgrow.results.drawing import draw_scene
from crackgrow.results.folder import RunFolder
from crackgrow.results.places import extent
from crackgrow.results.report.page import described_actions
from crackgrow.results.units import LENGTHS, STRESSES, TIMES, factor_text, rounded_all, shown, unit_of
from tests.scenes import shipped_case
from tests.unit.case.scenes import EVERYTHING, load

Arrow = tuple[np.ndarray, np.ndarray]
"""Tail and head (2,), m."""

HELD = "supports=[{on: {body: rock, edge: bottom}, displacement: {x: 0, y: 0}}]"


def size_of(case: Case) -> float:
    low, high = extent(case)
    return float((high - low).max())


def arrows_of(load: str) -> tuple[float, list[Arrow]]:
    """The size of the plate, and the arrows of its load, from left to right."""
    case = shipped_case("compression30", [f"loads=[{load}]"])
    sheet = signs.Sheet(Figure().add_subplot(), case, size_of(case))
    sheet.draw_load(case.loads[0])
    found = [text for text in sheet.axes.texts if isinstance(text, Annotation)]
    arrows = [(np.array(text.xyann), np.array(text.xy)) for text in found]
    return size_of(case), sorted(arrows, key=lambda arrow: float(arrow[0][0]))


def test_arrows_push_on_the_edge_or_pull_from_it() -> None:
    for way in (-1, 1):
        size, arrows = arrows_of(f"{{on: {{body: rock, edge: top}}, traction: [0, {3 * way}]}}")
        near = [(head if way < 0 else tail)[1] for tail, head in arrows]
        np.testing.assert_allclose(near, 0.0275 + signs.GAP * size)
        np.testing.assert_allclose([head - tail for tail, head in arrows], [[0.0, way * signs.ARROW * size]] * 7)
        np.testing.assert_allclose([tail[0] for tail, _ in arrows], 0.031 * (np.arange(7) - 3) / 7, atol=1e-15)


def test_a_case_with_every_form_of_the_format_can_be_drawn_and_is_the_same_file_again(tmp_path: Path) -> None:
    case = load(tmp_path, EVERYTHING)
    paths = [tmp_path / name for name in ("a.svg", "b.svg")]
    for path in paths:
        draw_scene(path, case, squares_of(case))
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert paths[0].read_text(encoding="utf-8").count("<path") > 20


@pytest.mark.physics
@pytest.mark.parametrize(("name", "settings", "mark", "least", "most"), [
    ("compression30", ["numerics.spacing=3"], "#b2182b", 1, 999),  # arrows of loads
    ("compression30", ["numerics.spacing=3", "loads=[]", HELD], "#b2182b", 0, 0),
    ("tunnel_excavated", [], "core is taken out in stage 'face near by'", 1, 9),
    ("two_flaws", ["numerics.spacing=4"], "stroke: #000000; stroke-width: 2; stroke-linecap: round", 2, 2),
    # a triangle, two rollers, ground and hatching, of three supports
    ("two_flaws", ["numerics.spacing=4"], "#404040", 3 * 5 + 1, 999),
])  # fmt: skip
def test_the_picture_shows_cracks_and_what_acts_and_nothing_else(
    name: str, settings: list[str], mark: str, least: int, most: int, tmp_path: Path
) -> None:
    case = shipped_case(name, settings)
    draw_scene(tmp_path / "scene.svg", case, squares_of(case))
    assert least <= (tmp_path / "scene.svg").read_text(encoding="utf-8").count(mark) <= most


def test_the_arrow_of_a_point_force_ends_at_its_point() -> None:
    _, ((tail, head),) = arrows_of("{at: [0, 27.5], force: [0 N/m, -1000 N/m]}")
    np.testing.assert_allclose(head, [0.0, 0.0275], atol=1e-15)
    assert tail[1] > head[1]


def test_actions_are_told_in_words(tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(dump_case(shipped_case("compression30")))
    told = dict(described_actions(RunFolder(tmp_path)))
    assert told["supports.0"] == "at: [-0.0155, -0.0275], displacement: {y: 0}, body: rock"
    assert told["loads.1"] == "on: {body: rock, edge: bottom}, traction: [0, 100000000], held: false"


def test_numbers_are_shown_in_the_unit_that_suits_them() -> None:
    assert unit_of([3e6, -2.5e8, float("nan")], STRESSES) == (1e6, "MPa")
    assert unit_of([1e-3], LENGTHS) == (1e-3, "mm")
    assert unit_of([3 * 86400.0], TIMES) == (86400.0, "days")
    assert unit_of([2 * 365.25 * 86400.0], TIMES) == (365.25 * 86400.0, "years")
    assert unit_of([], LENGTHS) == unit_of([0.0], LENGTHS) == (1e-9, "nm")
    assert rounded_all([1.23456789e6, float("inf")], 1e6) == [1.23457, None]
    assert shown(float("nan")) == "\N{EN DASH}"
    assert [factor_text(factor) for factor in (0.5, 18.93, 5502.0, 1e5)] == ["0.5", "18.9", "5500", "100000"]
