"""Figures: they show something, and what they show is scaled as they say."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import combinations, pairwise
from pathlib import Path
from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imread

from crackgrow.results import drawn_frame, field_picture, figures
from crackgrow.results.drawn_frame import DrawnFrame
from crackgrow.results.field_picture import Look
from crackgrow.results.summary import LoadPoint
from crackgrow.run.result import STICK
from tests.unit.results.synthetic import HEIGHT, WIDTH, make_case, make_frame, make_paths, make_result

WHITE = 0.999


def inked_share(path: Path) -> float:
    """Share of the pixels that aren't white."""
    return float((imread(path)[..., :3].min(axis=2) < WHITE).mean())


def n_colours(path: Path) -> int:
    return len(np.unique(np.round(imread(path)[..., :3] * 31).astype(int).reshape(-1, 3), axis=0))


def test_paths_figure_shows_every_advance_in_its_colour(tmp_path: Path) -> None:
    figures.draw_paths(tmp_path / "given.png", make_case(), make_paths(0))
    figures.draw_paths(tmp_path / "grown.png", make_case(), make_paths(2))
    assert inked_share(tmp_path / "given.png") > 0.2
    pixels = imread(tmp_path / "given.png")[..., :3]
    assert np.ptp(pixels, axis=2).max() < 0.02  # black on grey: nothing has grown
    grown = imread(tmp_path / "grown.png")[..., :3]
    specimen = grown[:, : int(0.82 * grown.shape[1])]  # without the colour bar
    for colour in figures._step_colours(2).to_rgba(np.arange(1, 3))[:, :3]:
        assert (np.abs(specimen - colour).max(axis=2) < 0.02).sum() > 80  # more than the vertex alone


def test_sigma_1_figure_shows_the_field(tmp_path: Path) -> None:
    figures.draw_sigma_1(tmp_path / "figures" / "a.png", make_case(), replace(make_result(3), mesh=make_frame))
    assert inked_share(tmp_path / "figures" / "a.png") > 0.3
    assert n_colours(tmp_path / "figures" / "a.png") > 20


def test_sigma_1_figure_of_a_body_at_rest(tmp_path: Path) -> None:
    figures.draw_sigma_1(tmp_path / "a.png", make_case(), replace(make_result(0), mesh=lambda: make_frame(0.0)))
    assert inked_share(tmp_path / "a.png") > 0.3


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1.0])
def test_magnification_draws_the_largest_displacement_as_four_percent(scale: float) -> None:
    frame = make_frame(scale)
    moved = frame.displacement + np.array([3.0, -1.0])  # a translation changes nothing
    factor = drawn_frame.displayed_magnification(replace(frame, displacement=moved))
    largest = np.linalg.norm(frame.displacement - frame.displacement.mean(axis=0), axis=1).max()
    assert factor * largest / np.ptp(frame.points, axis=0).max() == pytest.approx(0.04, rel=0.05)  # two digits


def test_magnification_leaves_holes_their_shape() -> None:
    """A wide plate that shifts much far away, and a small hole in it that closes: u = -c / r."""
    x, y = (grid.ravel() for grid in np.meshgrid(np.arange(-20.0, 21.0), np.arange(-20.0, 21.0)))
    corners = np.arange(41 * 41).reshape(41, 41)
    quads = np.stack([corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1]], axis=-1)
    quads = np.delete(quads.reshape(-1, 4), [19 * 40 + 19, 19 * 40 + 20, 20 * 40 + 19, 20 * 40 + 20], axis=0)
    points, c = np.column_stack([x, y]), 1e-3
    closing = -c * points / np.maximum((points**2).sum(axis=1), 0.5)[:, None]
    frame = SimpleNamespace(points=points, displacement=closing, triangles=np.empty((0, 3), dtype=int), quads=quads)
    factor = drawn_frame.displayed_magnification(frame)
    at_corners = factor * c / 2
    assert drawn_frame.LARGEST_STRAIN / 2 < at_corners < drawn_frame.LARGEST_STRAIN * 1.5


def two_blocks(slip: float, turn: float, apart: float = 0.0) -> DrawnFrame:
    """A block (value 1) on another one (value 0), 2 x 1 each, whose faces are double: it slips; the faces turn.

    Cells of both come in turn.
    """
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 21), np.linspace(0.0, 1.0, 11))
    upper, corners = np.column_stack([x.ravel(), y.ravel()]), np.arange(11 * 21).reshape(11, 21)
    quads = np.stack([corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1]], axis=-1).reshape(-1, 4)
    points = np.concatenate([upper, upper - [0.0, 1.0]])
    points[len(upper) :][np.abs(points[len(upper) :, 1]) < 1e-12, 1] = 0.0
    above = (np.arange(len(points)) < len(upper)).astype(float)
    u = turn * np.column_stack([np.zeros(len(points)), points[:, 0]]) + above[:, None] * [slip, apart]
    both = np.stack([quads, quads + len(upper)], axis=1).reshape(-1, 4)
    return DrawnFrame(0, points, np.empty((0, 3), dtype=np.int64), both, u, above, by_point=True)


def test_magnification_keeps_faces_together_that_slip_and_turn() -> None:
    """A face that has turned by w is left by the slip w along where it was, by w^2 slip turn."""
    factor = drawn_frame.displayed_magnification(two_blocks(slip=0.02, turn=-0.01))
    assert factor**2 * 0.02 * 0.01 == pytest.approx(drawn_frame.TOGETHER * 2.0, rel=0.03)  # two digits of the factor
    assert drawn_frame.displayed_magnification(two_blocks(slip=0.0, turn=-0.01)) > 1.2 * factor
    assert drawn_frame.displayed_magnification(two_blocks(slip=0.02, turn=-0.01, apart=0.002)) > 1.05 * factor


def test_displacements_are_never_drawn_less_than_they_are() -> None:
    assert drawn_frame.displayed_magnification(two_blocks(slip=0.5, turn=0.2)) == 1.0


@pytest.mark.parametrize("by_point", [True, False])
def test_one_of_two_sides_that_are_drawn_in_each_other_covers_the_other(by_point: bool, tmp_path: Path) -> None:
    frame = two_blocks(slip=0.0, turn=0.0, apart=-0.25)
    values = frame.values if by_point else np.tile([1.0, 0.0], len(frame.quads) // 2)
    frame = replace(frame, values=values, by_point=by_point)
    pictures = field_picture.FieldPictures("blocks", "body", [frame], {}, Look(warp=1.0))
    (tmp_path / "a.png").write_bytes(pictures.png(frame))
    image = imread(tmp_path / "a.png")[..., :3]
    high, low = (np.abs(image - mpl.colormaps["viridis"](value)[:3]).max(axis=2) < 0.02 for value in (1.0, 0.0))
    columns = np.flatnonzero(high.sum(axis=0) > 0.2 * len(image))[5:-40]
    columns = columns[low[:, columns].any(axis=0)]
    assert len(columns) > 300
    for column in columns:
        assert np.flatnonzero(low[:, column]).min() > np.flatnonzero(high[:, column]).max()


def white_rim(path: Path) -> bool:
    """Whether nothing touches the rim of a picture, as words do that it has no room for."""
    image = imread(path)[:, :, :3]
    return all(bool((side == 1.0).all()) for side in (image[0], image[-1], image[:, 0], image[:, -1]))


@pytest.mark.parametrize("stretch", [(1.0, 1.0), (8.0, 1.0), (1.0, 8.0)])
def test_words_beside_a_colour_bar_have_room(stretch: tuple[float, float], tmp_path: Path) -> None:
    frame = make_frame()
    case = make_case()
    rings = [tuple(replace(ring, points=ring.points * stretch) for ring in body.rings) for body in case.bodies]
    bodies = tuple(replace(body, rings=mine) for body, mine in zip(case.bodies, rings, strict=True))
    stretched = replace(frame, points=frame.points * stretch)
    figures.draw_sigma_1(tmp_path / "a.png", case, replace(make_result(3), mesh=lambda: stretched))
    figures.draw_paths(tmp_path / "b.png", replace(case, bodies=bodies), make_paths(3))
    assert white_rim(tmp_path / "a.png")
    assert white_rim(tmp_path / "b.png")


@pytest.mark.parametrize("size", [1.0, 1.234567e-5, 1e12])
@pytest.mark.parametrize("stretch", [1.0, 40.0])
def test_words_of_a_panel_stay_clear_of_other_panels_of_the_title_and_of_the_edge(
    size: float, stretch: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(figures, "_save", lambda path, figure: drawn.append(figure))
    curve = [LoadPoint(size * (1.0 - 0.1 * k), 1.1e-5 + 4e-7 * k**2, 0.01 + 0.002 * k, {}) for k in range(9)]
    case, result = make_case(), make_result(3)
    face, at = result.faces[0], result.contact
    faces = tuple(replace(face, crack=name, normal_traction=size * face.normal_traction) for name in "abc")
    parts = {part.name: getattr(at, part.name) for part in fields(at)}
    contact = replace(at, **{name: np.concatenate([np.array(part)] * 3) for name, part in parts.items()})
    contact = replace(contact, crack=tuple(name for name in "abc" for _ in at.s), slip=size * contact.slip)
    figures.draw_load_curve(tmp_path / "a.png", case, curve)
    figures.draw_contact(tmp_path / "b.png", case, replace(result, faces=faces, contact=contact))
    rings = [tuple(replace(ring, points=ring.points * stretch) for ring in body.rings) for body in case.bodies]
    bodies = tuple(replace(body, rings=mine) for body, mine in zip(case.bodies, rings, strict=True))
    figures.draw_paths(tmp_path / "c.png", replace(case, bodies=bodies), make_paths(3))
    for figure in drawn:
        FigureCanvasAgg(figure).draw()
        boxes = [axes.get_tightbbox() for axes in figure.axes] + [text.get_window_extent() for text in figure.texts]
        assert figure.texts
        assert all(box.x0 > 0.0 and box.x1 < figure.bbox.width for box in boxes if box is not None)
        assert all(box.y0 > 0.0 and box.y1 < figure.bbox.height for box in boxes if box is not None)
        assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


@pytest.mark.parametrize("size", [1.0, 1e-4, 1e-9, 1e6])
def test_ticks_of_a_load_curve_do_not_overlap(size: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(figures, "_save", lambda path, figure: drawn.append(figure))
    curve = [LoadPoint(1.0 - 0.1 * k, size * (1.1e-5 + 4e-7 * k**2), 0.01 + 0.002 * k, {}) for k in range(9)]
    figures.draw_load_curve(tmp_path / "a.png", make_case(), curve)
    (figure,) = drawn
    FigureCanvasAgg(figure).draw()
    for axes in figure.axes:
        low, high = axes.get_xlim()
        texts = [t for t in axes.get_xticklabels() if low <= t.get_position()[0] <= high]
        boxes = [text.get_window_extent() for text in texts]
        assert len(boxes) >= 2
        assert all(left.x1 < right.x0 for left, right in pairwise(boxes))


@pytest.mark.parametrize(("size", "unit"), [(3e-6, "µm"), (3e-3, "mm"), (3.0, "m")])
def test_a_load_curve_is_in_units_that_suit_its_values(
    size: float, unit: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(figures, "_save", lambda path, figure: drawn.append(figure))
    curve = [LoadPoint(1.0 + k, size * (1.0 + k), 0.01 + 0.002 * k, {}) for k in range(3)]
    figures.draw_load_curve(tmp_path / "a.png", make_case(), curve)
    displacement, growth = drawn[0].axes
    assert displacement.get_xlabel() == f"displacement of the loads [{unit}]"
    assert np.asarray(displacement.lines[0].get_xdata()) == pytest.approx([3.0, 6.0, 9.0])
    assert growth.get_xlabel() == "crack growth [mm]"


def test_colours_are_symmetrical_for_both_signs_and_ignore_outliers() -> None:
    values = np.concatenate([np.linspace(-1.0, 2.0, 1000), [1e9]])
    _, norm, _ = field_picture.colours_of("body", values, np.ones(1001))
    assert norm.vmin == -norm.vmax
    assert norm.vmax == pytest.approx(1.94, rel=1e-2)
    _, norm, _ = field_picture.colours_of("body", np.linspace(1.0, 2.0, 101), np.ones(101))
    assert (norm.vmin, norm.vmax) == (pytest.approx(1.02, abs=0.011), pytest.approx(1.98, abs=0.011))


def test_many_small_cells_at_a_tip_count_by_their_area() -> None:
    values = np.concatenate([np.linspace(1.0, 2.0, 1000), np.full(1000, 50.0)])
    _, norm, _ = field_picture.colours_of("body", values, np.repeat([1.0, 1e-3], 1000))
    assert norm.vmax == pytest.approx(1.98, rel=1e-2)
    frame = make_frame()
    for by_point in (False, True):
        areas = drawn_frame.areas(frame, by_point=by_point)
        assert len(areas) == len(frame.point_stress if by_point else frame.stress)
        assert areas.sum() == pytest.approx(WIDTH * HEIGHT)


def points(*rows: tuple[float, float, float], slip: float = 0.0) -> list[LoadPoint]:
    return [LoadPoint(*row, {"flaw": slip * row[0], "other": 0.0}) for row in rows]


def test_load_curve_has_a_second_panel_where_cracks_have_grown_or_slipped(tmp_path: Path) -> None:
    static = [(0.5, 1e-5, 0.02), (1.0, 2e-5, 0.02), (0.5, 1e-5, 0.02)]
    figures.draw_load_curve(tmp_path / "static.png", make_case(), points(*static))
    figures.draw_load_curve(tmp_path / "slipped.png", make_case(), points(*static, slip=1e-6))
    grown = [(1.0, 1e-5, 0.02), (0.8, 1.5e-5, 0.022), (0.7, float("nan"), 0.024)]
    figures.draw_load_curve(tmp_path / "grown.png", make_case(), points(*grown))
    one, *two = (imread(tmp_path / f"{name}.png").shape[1] for name in ("static", "slipped", "grown"))
    assert two == [2 * one, 2 * one]
    for name in ("static.png", "grown.png"):
        assert inked_share(tmp_path / name) > 0.02
    long = [(1.0 - 0.001 * step, 1e-6 * step, 0.02 + 0.001 * step) for step in range(200)]
    figures.draw_load_curve(tmp_path / "long.png", make_case(), points(*long))


def test_steps_at_about_the_same_place_share_the_words_that_name_them() -> None:
    x, y = np.array([0.0, 1.0, 1.01, np.nan, 0.0]), np.array([0.0, 2.0, 1.99, 1.0, 2.0])
    assert figures._labels(x, y, [0, 1, 2, 3, 4, 4]) == [
        ((0.0, 0.0), ["0"]),
        ((1.0, 2.0), ["1", "2"]),
        ((0.0, 2.0), ["4"]),
    ]


@pytest.mark.parametrize(("traction", "unit"), [(-2e7, "MPa"), (-5e4, "kPa")])
def test_round_off_in_tractions_is_not_blown_up_and_the_legend_has_the_states_there_are(
    traction: float, unit: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(figures, "_save", lambda path, figure: drawn.append(figure))
    result = make_result(1)
    n = len(result.contact.s)
    constant = traction * (1.0 - 5e-7 * np.arange(n))
    contact = replace(result.contact, normal_traction=constant, state=np.full(n, STICK))
    faces = tuple(replace(face, normal_traction=np.full(len(face.s), traction)) for face in result.faces)
    tangential = replace(contact, tangential_traction=0.1 * constant)
    faces = tuple(replace(face, tangential_traction=0.1 * face.normal_traction) for face in faces)
    figures.draw_contact(tmp_path / "contact.png", make_case(), replace(result, contact=tangential, faces=faces))
    low, high = drawn[0].axes[1].get_ylim()
    assert low < -20.0
    assert high > 0.0
    assert drawn[0].axes[1].get_ylabel() == f"normal traction [{unit}]"
    legend = drawn[0].axes[0].get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["stick"]
