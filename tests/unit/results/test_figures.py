"""Pictures: what acts and nothing else, holes that keep their shape, room for all words, whatever the user has set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from itertools import combinations
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.text import Annotation

from crackgrow.case import Case, dump_case, model
from crackgrow.case.on_map import extent
from crackgrow.plan.cost import squares_of
from crackgrow.results import drawn_frame, figures, signs
from crackgrow.results.drawing import draw_scene
from crackgrow.results.drawn_frame import DrawnFrame
from crackgrow.results.folder import RunFolder
from crackgrow.results.report.charts import event_energies, stress_strain
from crackgrow.results.report.page import described_actions
from crackgrow.results.style import own_style
from crackgrow.results.units import LENGTHS, STRESSES, TIMES, factor_text, rounded_all, shown, unit_of
from tests.scenes import shipped_case
from tests.unit.case.scenes import EVERYTHING, load
from tests.unit.results.synthetic import make_case, make_frame, make_paths, make_result


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """The figures that a test draws, in place of their files."""
    found: list[Figure] = []
    monkeypatch.setattr(figures, "png_of", lambda figure: found.append(figure) or b"")
    return found


def run_of(
    folder: Path, case: Case, events: Sequence[tuple[object, ...]] = (), **columns: Sequence[float]
) -> RunFolder:
    """A run with these columns in its steps.csv; of events there are step, kind, crack, load and energy."""
    n_steps = len(next(iter(columns.values())))
    usual = {f"mean_{of}_{xx}": 0.0 for of in ("stress", "strain") for xx in ("xx", "yy", "xy")} | {"load_factor": 1.0}
    steps = {"step": range(n_steps), **{name: [value] * n_steps for name, value in usual.items()}, **columns}
    folder.mkdir(exist_ok=True)
    for name, header, table in (
        ("steps", steps, zip(*steps.values(), strict=True)),
        ("contact", ("step", "crack", "slip"), [(step, "flaw", 0.0) for step in range(n_steps)]),
        ("events", ("step", "kind", "crack", "load_factor", "energy", "tip"), [(*event, "") for event in events]),
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


@pytest.mark.physics
@pytest.mark.parametrize(("size", "stretch"), [(1.234567e-5, (40.0, 40.0)), (1e12, (8.0, 1.0)), (1.0, (1.0, 8.0))])
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
    image = imread(tmp_path / "d.png")[..., :3]  # white at its rim, where words would end that have no room
    assert all((side == 1.0).all() for side in (image[0], image[-1], image[:, 0], image[:, -1]))


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


@pytest.mark.physics
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


@pytest.mark.parametrize(("stress", "drawn"), [
    ([(0.0, -1e6, 0.0), (0.0, -2e6, 1e3), (0.0, -1.5e6, 0.0)], ("y", "compressive", [1.0, 2.0, 1.5])),
    ([(3e6, -1e6, 0.0), (np.nan, np.nan, np.nan)], None),
    ([(3e6, -1e6, 0.0), (np.nan, np.nan, np.nan), (4e6, -1e6, 0.0)], ("x", "tensile", [3.0, None, 4.0])),
    ([(1e-9, 2e-9, 1e6), (3e-9, 1e-9, 2e6)], None),
    ([(0.0, 1e6, 0.0), (0.0, 1e6 + 1e-9, 0.0)], None),
], ids=["compression", "one step", "nan", "pure shear", "steady"])  # fmt: skip
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


EVENTS = (
    (0, "slip", "flaw", 0.5, 2.0), (1, "coalescence", "flaw", "nan", "nan"), (1, "slip", "flaw", 1.0, 1.0),
    (1, "slip", "other", 1.5, 4.0), (1, "break", "other", 1.75, 8.0), (2, "opening", "flaw", 2.0, 0.0),
)  # fmt: skip


def pulled(folder: Path, case: Case) -> RunFolder:
    """Three loads, under which strain comes before stress and then behind."""
    stress, strain = [1e6, 2e6, 2.5e6], [1e-3, 2e-3, 4e-3]
    return run_of(folder, case, EVENTS, mean_stress_yy=stress, mean_strain_yy=strain, load_factor=[1.0, 2.0, 3.0])


def marks(run: RunFolder) -> dict[str, list[tuple[float | None, float | None, int]]]:
    """Places and steps of the events on the curve, by what they are called."""
    chart = stress_strain(run)
    assert chart is not None
    return {
        line["name"]: list(zip(line["x"], line["y"], line["steps"], strict=True))
        for line in chart["series"]
        if line.get("marks")
    }


def test_what_happens_first_to_each_surface_is_on_the_curve_between_the_loads(tmp_path: Path) -> None:
    """Loads go on from each other without growth; with it each step begins unloaded, as the first of them does."""
    static = replace(make_case(), growth=None, loading=model.LoadHistory((1.0, 2.0, 3.0)))
    assert marks(pulled(tmp_path / "static", static)) == {
        "first: faces slip": [(0.5, 0.5, 0), (1.5, 1.5, 1)],
        "first: bonds break": [(1.75, 1.75, 1)],
        "first: faces open": [(2.0, 2.0, 2)],
    }
    grown = marks(pulled(tmp_path / "grown", make_case()))
    assert grown["first: faces open"] == [(pytest.approx(8.0 / 3.0, rel=1e-3), pytest.approx(5.0 / 3.0, rel=1e-3), 2)]
    held = replace(static, loads=(model.Gravity(held=True, body="rock", acceleration=(0.0, 0.0)),))
    assert marks(pulled(tmp_path / "held", held))["first: faces slip"] == [(None, None, 0), (1.5, 1.5, 1)]


def test_the_energy_of_events_is_that_of_their_steps(tmp_path: Path) -> None:
    found = event_energies(pulled(tmp_path, make_case()))
    assert {name: energy.tolist() for name, energy in found.items()} == {
        "bonds break": [0.0, 8.0, 0.0],
        "faces slip": [2.0, 5.0, 0.0],
    }


Arrow = tuple[np.ndarray, np.ndarray]
"""Tail and head (2,), m."""

HELD = "supports=[{on: {body: rock, edge: bottom}, displacement: {x: 0, y: 0}}]"


def arrows_of(load: str) -> tuple[float, list[Arrow]]:
    """The size of the plate, and the arrows of its load, from left to right."""
    case = shipped_case("compression30", [f"loads=[{load}]"])
    size = float(np.ptp(extent(case), axis=0).max())
    sheet = signs.Sheet(Figure().add_subplot(), case, size)
    sheet.draw_load(case.loads[0])
    found = [text for text in sheet.axes.texts if isinstance(text, Annotation)]
    arrows = [(np.array(text.xyann), np.array(text.xy)) for text in found]
    return size, sorted(arrows, key=lambda arrow: float(arrow[0][0]))


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
