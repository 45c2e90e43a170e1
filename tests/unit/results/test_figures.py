"""Figures: they show something, scaled as they say, with room for all words, whatever the user's settings are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from itertools import combinations, pairwise
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imread

from crackgrow.case import Case
from crackgrow.plan.cost import squares_of
from crackgrow.results import drawn_frame, field_picture, figures
from crackgrow.results.drawing import draw_scene, step_colour
from crackgrow.results.drawn_frame import DrawnFrame
from crackgrow.results.field_picture import Look
from crackgrow.results.folder import RunFolder
from crackgrow.results.report.charts import stress_strain
from crackgrow.results.style import own_style
from crackgrow.run.result import STICK
from tests.properties.broken_off import ENVIRONMENT, command, finished
from tests.scenes import shipped_case
from tests.unit.results.synthetic import HEIGHT, WIDTH, make_case, make_frame, make_paths, make_result


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """The figures that a test draws, in place of their files."""
    found: list[Figure] = []
    monkeypatch.setattr(figures, "_save", lambda path, figure: found.append(figure))
    return found


def run_of(folder: Path, case: Case, **columns: Sequence[float]) -> RunFolder:
    """A run with these columns in its steps.csv; one of its two surfaces slips."""
    n_steps = len(next(iter(columns.values())))
    slip, usual = columns.pop("slip", [0.0] * n_steps), {"mean_stress_xx": 0.0, "mean_stress_xy": 0.0}
    usual |= {f"mean_strain_{xx}": 0.0 for xx in ("xx", "yy", "xy")} | {"mean_stress_yy": 0.0}
    steps = {"step": range(n_steps), **{name: [value] * n_steps for name, value in usual.items()}, **columns}
    rows = [*((k, "flaw", slip[k]) for k in range(n_steps)), (0, "other", 0.0)]  # the other one goes with its rock
    folder.mkdir(exist_ok=True)
    for name, header, table in (
        ("steps", steps, zip(*steps.values(), strict=True)),
        ("contact", ("step", "crack", "slip"), rows),
    ):
        lines = [header, *table]
        (folder / f"{name}.csv").write_text("".join(",".join(map(str, line)) + "\n" for line in lines))
    run = RunFolder(folder)
    run.case = case
    return run


def falling(size: float, case: Case, folder: Path) -> RunFolder:
    """A run whose load falls while its crack grows."""
    k = np.arange(9)
    lengths = {"load_displacement": 1.1e-5 + 4e-7 * k**2, "crack_length": 0.01 + 0.002 * k}
    return run_of(
        folder, case, load_factor=(size * (1.0 - 0.1 * k)).tolist(), **{n: v.tolist() for n, v in lengths.items()}
    )


def pixels(path: Path) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.asarray(imread(path)[..., :3], dtype=float)


def inked_share(path: Path) -> float:
    """Share of the pixels that aren't white."""
    return float((pixels(path).min(axis=2) < 0.999).mean())


def test_paths_figure_shows_every_advance_in_its_colour(tmp_path: Path) -> None:
    figures.draw_paths(tmp_path / "given.png", make_case(), make_paths(0))
    figures.draw_paths(tmp_path / "grown.png", make_case(), make_paths(2))
    assert inked_share(tmp_path / "given.png") > 0.2
    assert np.ptp(pixels(tmp_path / "given.png"), axis=2).max() < 0.02  # black on grey: nothing has grown
    grown = pixels(tmp_path / "grown.png")
    assert grown.shape == (1230, 960, 3)
    specimen = grown[:, : int(0.82 * grown.shape[1])]  # without the colour bar
    for colour in (mpl.colors.to_rgb(step_colour(step, 2)) for step in (1, 2)):
        assert (np.abs(specimen - colour).max(axis=2) < 0.02).sum() > 80  # more than the vertex alone


@pytest.mark.parametrize(("scale", "colours"), [(1.0, 20), (0.0, 1)])
def test_sigma_1_figure_shows_the_field_also_of_a_body_at_rest(scale: float, colours: int, tmp_path: Path) -> None:
    path = tmp_path / "figures" / "a.png"
    figures.draw_sigma_1(path, make_case(), replace(make_result(3), mesh=lambda: make_frame(scale)))
    assert inked_share(path) > 0.3
    assert len(np.unique(np.round(pixels(path) * 31).astype(int).reshape(-1, 3), axis=0)) > colours


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1.0])
def test_magnification_draws_the_largest_displacement_as_four_percent(scale: float) -> None:
    frame = drawn_frame.frame_with_sigma_1(make_frame(scale), 0)
    moved = frame.displacement + np.array([3.0, -1.0])  # a translation changes nothing
    factor = replace(frame, displacement=moved).magnification()
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
    frame = DrawnFrame(0, points, quads, closing, np.zeros(len(points)), by_point=True)
    factor = frame.magnification()
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
    return DrawnFrame(0, points, both, u, above, by_point=True)


def test_magnification_keeps_faces_together_that_slip_and_turn() -> None:
    """A face that has turned by w is left by the slip w along where it was, by w^2 slip turn."""
    factor = two_blocks(slip=0.02, turn=-0.01).magnification()
    assert factor**2 * 0.02 * 0.01 == pytest.approx(drawn_frame.TOGETHER * 2.0, rel=0.03)  # two digits of the factor
    assert two_blocks(slip=0.0, turn=-0.01).magnification() > 1.2 * factor
    assert two_blocks(slip=0.02, turn=-0.01, apart=0.002).magnification() > 1.05 * factor
    assert two_blocks(slip=0.5, turn=0.2).magnification() == 1.0  # never less than they are


@pytest.mark.parametrize("by_point", [True, False])
def test_one_of_two_sides_that_are_drawn_in_each_other_covers_the_other(by_point: bool, tmp_path: Path) -> None:
    frame = two_blocks(slip=0.0, turn=0.0, apart=-0.25)
    values = frame.values if by_point else np.tile([1.0, 0.0], len(frame.cells) // 2)
    frame = replace(frame, values=values, by_point=by_point)
    pictures = field_picture.FieldPictures("blocks", "body", [frame], {}, Look(warp=1.0))
    (tmp_path / "a.png").write_bytes(pictures.png(frame))
    image = pixels(tmp_path / "a.png")
    high, low = (np.abs(image - mpl.colormaps["viridis"](value)[:3]).max(axis=2) < 0.02 for value in (1.0, 0.0))
    columns = np.flatnonzero(high.sum(axis=0) > 0.2 * len(image))[5:-40]
    columns = columns[low[:, columns].any(axis=0)]
    assert len(columns) > 300
    for column in columns:
        assert np.flatnonzero(low[:, column]).min() > np.flatnonzero(high[:, column]).max()


def white_rim(path: Path) -> bool:
    """Whether nothing touches the rim of a picture, as words do that it has no room for."""
    image = pixels(path)
    return all(bool((side == 1.0).all()) for side in (image[0], image[-1], image[:, 0], image[:, -1]))


@pytest.mark.parametrize(
    ("size", "stretch"), [(1.0, (1.0, 1.0)), (1.234567e-5, (40.0, 40.0)), (1e12, (8.0, 1.0)), (1.0, (1.0, 8.0))]
)
def test_words_stay_clear_of_panels_of_the_title_and_of_the_edge(
    size: float, stretch: tuple[float, float], tmp_path: Path, drawn: list[Figure]
) -> None:
    case, result, frame = make_case(), make_result(3), make_frame()
    face, at = result.faces[0], result.contact
    faces = tuple(replace(face, crack=name, normal_traction=size * face.normal_traction) for name in "abc")
    parts = {part.name: np.concatenate([np.array(getattr(at, part.name))] * 3) for part in fields(at)}
    contact = replace(
        at, **parts | {"crack": tuple(name for name in "abc" for _ in at.s), "slip": size * parts["slip"]}
    )
    rings = [tuple(replace(ring, points=ring.points * stretch) for ring in body.rings) for body in case.bodies]
    bodies = tuple(replace(body, rings=mine) for body, mine in zip(case.bodies, rings, strict=True))
    figures.draw_curves(tmp_path, falling(size, case, tmp_path))
    figures.draw_contact(tmp_path / "b.png", case, replace(result, faces=faces, contact=contact))
    figures.draw_paths(tmp_path / "c.png", replace(case, bodies=bodies), make_paths(3))
    for figure in drawn:
        FigureCanvasAgg(figure).draw()
        boxes = [axes.get_tightbbox() for axes in figure.axes] + [text.get_window_extent() for text in figure.texts]
        assert figure.texts
        assert all(box.x0 > 0.0 and box.x1 < figure.bbox.width for box in boxes if box is not None)
        assert all(box.y0 > 0.0 and box.y1 < figure.bbox.height for box in boxes if box is not None)
        assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    stretched = replace(frame, points=frame.points * stretch)
    figures.draw_sigma_1(tmp_path / "d.png", case, replace(result, mesh=lambda: stretched))
    assert white_rim(tmp_path / "d.png")


@pytest.mark.parametrize(
    ("size", "unit", "name"),
    [(1.0, 1e-6, "µm"), (1e-4, 1e-9, "nm"), (1e-9, 1e-9, "nm"), (300.0, 1e-3, "mm"), (1e6, 1.0, "m")],
)
def test_a_load_curve_is_in_units_that_suit_its_values_and_its_ticks_do_not_overlap(
    size: float, unit: float, name: str, tmp_path: Path, drawn: list[Figure]
) -> None:
    lengths = [size * (1.1e-5 + 4e-7 * k**2) for k in range(9)]
    factors, grown = (1.0 - 0.1 * np.arange(9)).tolist(), (0.01 + 0.002 * np.arange(9)).tolist()
    run = run_of(tmp_path, make_case(), load_factor=factors, load_displacement=lengths, crack_length=grown)
    figures.draw_curves(tmp_path, run)
    (figure,) = drawn
    displacement, growth = figure.axes
    assert displacement.get_xlabel() == f"displacement of the loads [{name}]"
    assert np.asarray(displacement.lines[0].get_xdata()) == pytest.approx(np.array(lengths) / unit, rel=1e-5)
    assert growth.get_xlabel() == "crack growth [mm]"
    FigureCanvasAgg(figure).draw()
    for axes in figure.axes:
        low, high = axes.get_xlim()
        texts = [t for t in axes.get_xticklabels() if low <= t.get_position()[0] <= high]
        boxes = [text.get_window_extent() for text in texts]
        assert len(boxes) >= 2
        assert all(left.x1 < right.x0 for left, right in pairwise(boxes))


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
    frame = drawn_frame.frame_with_sigma_1(make_frame(), 0)
    for by_point in (False, True):
        areas = frame.areas(by_point=by_point)
        assert len(areas) == len(frame.points if by_point else frame.cells)
        assert areas.sum() == pytest.approx(WIDTH * HEIGHT)


@pytest.mark.parametrize(("lengths", "slip", "panels"), [
    ([0.02, 0.02, 0.02], 0.0, 1), ([0.02, 0.02, 0.02], 1e-6, 2), (np.linspace(0.02, 0.2, 200), 0.0, 2)
])  # fmt: skip
def test_load_curve_has_a_second_panel_where_cracks_have_grown_or_slipped(
    lengths: list[float], slip: float, panels: int, tmp_path: Path, drawn: list[Figure]
) -> None:
    factors = np.linspace(1.0, 0.7, len(lengths))
    ways = [*np.linspace(1e-5, 2e-5, len(lengths) - 1).tolist(), float("nan")]
    columns = {"load_displacement": ways, "crack_length": list(lengths), "slip": (slip * factors).tolist()}
    figures.draw_curves(tmp_path, run_of(tmp_path, make_case(), load_factor=factors.tolist(), **columns))
    (figure,) = drawn
    assert len(figure.axes) == panels
    assert all(axes.lines for axes in figure.axes)


def test_steps_at_about_the_same_place_share_the_words_that_name_them() -> None:
    x, y = np.array([0.0, 1.0, 1.01, np.nan, 0.0]), np.array([0.0, 2.0, 1.99, 1.0, 2.0])
    assert figures._labels(x, y, [0, 1, 2, 3, 4, 4]) == [
        ((0.0, 0.0), ["0"]),
        ((1.0, 2.0), ["1", "2"]),
        ((0.0, 2.0), ["4"]),
    ]


@pytest.mark.parametrize(("traction", "unit"), [(-2e7, "MPa"), (-5e4, "kPa")])
def test_round_off_in_tractions_is_not_blown_up_and_the_legend_has_the_states_there_are(
    traction: float, unit: str, tmp_path: Path, drawn: list[Figure]
) -> None:
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


NO_FORMULA = r"$\frac{1}{0$ & <b> $_$"
ODD = {"font.family": ["cursive"], "font.size": 30.0, "lines.linewidth": 9.0, "figure.facecolor": "black",
       "axes.grid": True, "savefig.dpi": 20.0, "text.usetex": True, "figure.autolayout": True}  # fmt: skip


def draw_falling(path: Path, case: Case) -> None:
    figures.draw_curves(path.parent, falling(1.0, case, path.parent))
    (path.parent / "load_curve.png").rename(path)


DRAWN: dict[str, Callable[[Path, Case], None]] = {
    "paths": lambda path, case: figures.draw_paths(path, case, make_paths(2)),
    "sigma_1": lambda path, case: figures.draw_sigma_1(path, case, make_result(1)),
    "contact": lambda path, case: figures.draw_contact(path, case, make_result(1)),
    "load curve": draw_falling,
    "scene": lambda path, case: draw_scene(path, case, squares_of(case)),
}


@pytest.mark.parametrize("draw", DRAWN.values(), ids=DRAWN)
def test_pictures_take_no_notice_of_settings_and_know_no_formulas(
    draw: Callable[[Path, Case], None], tmp_path: Path
) -> None:
    case = shipped_case("compression30", ["numerics.spacing=3"])
    crack = replace(case.cracks[0], name=NO_FORMULA)
    case = replace(make_case(), title=NO_FORMULA, bodies=case.bodies, cracks=(crack,))
    draw(tmp_path / "usual.png", case)
    with mpl.rc_context(ODD):
        draw(tmp_path / "odd.png", case)
        assert {key: mpl.rcParams[key] for key in ODD} == ODD
        with pytest.raises(ValueError, match="no picture"), own_style():
            raise ValueError("no picture")
        assert {key: mpl.rcParams[key] for key in ODD} == ODD  # the user's again, also after an error
    assert (tmp_path / "odd.png").read_bytes() == (tmp_path / "usual.png").read_bytes()


def test_a_run_and_its_pictures_are_made_in_any_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "matplotlibrc").write_text("lines.linewidth: thick\nno such key: 1\n")
    monkeypatch.setitem(ENVIRONMENT, "MPLBACKEND", "of_another_program")
    monkeypatch.setitem(ENVIRONMENT, "MATPLOTLIBRC", str(tmp_path / "matplotlibrc"))
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):  # pictures need none
        monkeypatch.delitem(ENVIRONMENT, name, raising=False)
    run = command("compression30", ("numerics.spacing=3", "growth.steps=1", f"title='{NO_FORMULA}'"), tmp_path / "out")
    render = [*run[:3], "render", str(tmp_path / "out")]
    check = [*run[:3], "check", str(tmp_path / "out" / "case.yaml"), "--picture", str(tmp_path / "scene.svg")]
    for words in (run, render, check):
        done = finished(words)
        assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "out" / "figures" / "path.png").is_file()


@pytest.mark.parametrize(
    ("stress", "drawn"),
    [
        ([(0.0, -1e6, 0.0), (0.0, -2e6, 1e3), (0.0, -1.5e6, 0.0)], ("y", "compressive", [1.0, 2.0, 1.5])),
        ([(3e6, -1e6, 0.0), (np.nan, np.nan, np.nan)], None),
        ([(3e6, -1e6, 0.0), (np.nan, np.nan, np.nan), (4e6, -1e6, 0.0)], ("x", "tensile", [3.0, None, 4.0])),
        ([(1e-9, 2e-9, 1e6), (3e-9, 1e-9, 2e6)], None),
        ([(0.0, 1e6, 0.0), (0.0, 1e6 + 1e-9, 0.0)], None),
    ],
    ids=["compression", "one step", "nan", "pure shear", "steady"],
)
def test_the_curve_is_of_the_axis_that_bears_more_and_none_of_round_off(
    stress: list[tuple[float, ...]], drawn: tuple[str, str, list[float | None]] | None, tmp_path: Path
) -> None:
    columns = dict(zip(("mean_stress_xx", "mean_stress_yy", "mean_stress_xy"), zip(*stress, strict=True), strict=True))
    found = stress_strain(run_of(tmp_path, make_case(), **columns))
    if drawn is None:
        assert found is None
    else:
        axis, sense, values = drawn
        assert found is not None
        assert found["ylabel"] == f"{sense} stress along {axis} [MPa]"
        assert found["series"][0]["y"] == values
