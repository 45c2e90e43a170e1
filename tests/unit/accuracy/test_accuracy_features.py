"""Features: where cells are small, and what becomes of them as cracks grow."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from crackgrow.accuracy.features import JOG
from crackgrow.case.accuracy import CELLS
from crackgrow.case.model import Case
from crackgrow.cover.cover import Cover
from crackgrow.errors import CaseError
from crackgrow.plan.text import plan_text
from crackgrow.run import grow
from crackgrow.run.checkpoint import beginning
from crackgrow.run.layout import cells_of, contact_faces, cover_of
from crackgrow.run.scene import Scene, make_scene
from tests.one_size import one_size
from tests.scenes import shipped_case

QUIET = ("output.frames=none", "output.figures=false", "output.report=false")


def case(name: str, *settings: str) -> Case:
    return shipped_case(name, [*one_size(name), *settings, *QUIET])


def laid_out(scene: Case) -> Cover:
    return cover_of(make_scene(scene), beginning(scene).cracks)


def size_at(cover: Cover, metres: tuple[float, float]) -> float:
    """Side of the cell at a place, spacings."""
    lattice = cover.lattice
    tile = lattice.tiles_at(lattice.to_lattice(np.array([metres])))[0]
    return float(lattice.cells.size[lattice.tiles.cell[tile]] / lattice.cells.size.max())


def test_without_halvings_all_cells_are_of_one_size() -> None:
    cover = laid_out(case("compression30", "numerics.refine.rings=3"))
    assert np.all(cover.sizes == 1.0)


def test_tips_kinks_and_corners_get_the_cells_that_they_ask_for() -> None:
    path = "cracks.flaw.path={points: [[-6, -4], [0, 0], [5, 0]]}"
    notch = "bodies.rock.shape.holes=[{rectangle: {center: [9, 18], width: 6, height: 6}}]"
    settings = ("numerics.spacing=3", "numerics.refine={tips: 2, kinks: 4, corners: 1}")
    cover = laid_out(case("compression30", path, notch, *settings))
    assert [tip.size for tip in cover.tips] == [0.25, 0.25]
    assert size_at(cover, (0.0, 0.0)) == 2.0**-4
    assert size_at(cover, (0.0061, 0.0149)) == 0.5
    assert size_at(cover, (-0.013, 0.005)) == 1.0


def test_the_less_a_crack_turns_the_larger_are_the_cells_at_its_kink() -> None:
    sizes = []
    for y in (0.02, 0.3, 0.6, 1.2):  # turns by 0.2, 3, 6, 12 degrees
        path = f"cracks.flaw.path={{points: [[-6, 0], [0, 0], [6, {y}]]}}"
        scene = shipped_case("compression30", [AUTO, path, "growth.steps=0", *QUIET])
        sizes.append(size_at(laid_out(scene), (1e-6, 1e-6)))
    assert sizes[0] > sizes[1] > sizes[2] > sizes[3]


def test_where_cracks_meet_or_end_on_an_outline_cells_are_small() -> None:
    cover = laid_out(case("junction_static", "numerics.refine.kinks=2"))
    assert cover.sizes.min() == 0.25


def test_small_cells_follow_the_tip_and_stay_at_the_kink() -> None:
    settings = ("numerics.spacing=3", "numerics.refine={tips: 2, kinks: 3}", "growth.steps=2")
    steps = list(grow(case("compression30", *settings)))
    assert all(tip.cell_size == pytest.approx(0.75e-3) for step in steps for tip in step.tips)
    assert steps[-1].n_dofs > steps[0].n_dofs
    assert steps[-1].cracks[0].points.shape[0] > 2


def test_the_check_counts_the_cells_by_their_size() -> None:
    text = plan_text(case("compression30", "numerics.spacing=3", "numerics.refine.tips=2"))
    (line,) = (line for line in text.splitlines() if line.startswith("  cells: "))
    assert [part.split(" of ")[1] for part in line.split(", ")] == ["3 mm", "1.5 mm", "0.75 mm"]


@pytest.mark.parametrize(("setting", "told"), [("tips=12", "<= 11"), ("rings=1", ">= 2"), ("holes=1", "tips")])
def test_halvings_out_of_range_are_refused(setting: str, told: str) -> None:
    with pytest.raises(CaseError, match=told):
        case("compression30", f"numerics.refine.{setting}")


def test_contact_remembers_through_cells_of_several_sizes() -> None:
    """Loading, unloading and loading again: K_II lags by friction, alike on small cells and on equal ones."""
    history = "loading.history=[0.5, 1, 0.6, 0.2, 1]"
    runs = [
        [[step.tips[0].K_II for step in grow(case("cyclic_friction", history, *settings))]]
        for settings in ((), ("numerics.refine={tips: 2}",))
    ]
    np.testing.assert_allclose(runs[1], runs[0], atol=0.01 * np.abs(runs[0]).max())


FLAW = "cracks.flaw.path={points: [[-5, 0], [5, 0]]}"
AUTO = "numerics.spacing=auto"


def halved_to(size: float, lattice: float) -> float:
    """Side, in those of the largest of a step, of the largest that is no larger than `size` (m)."""
    return float(2.0 ** -max(0, np.ceil(np.log2(0.5 * lattice / size))))


@pytest.mark.parametrize(
    ("settings", "size"),
    [
        (("growth.steps=0",), 0.010 / CELLS["stretch"]),
        (("growth.steps=3", "growth.increment=0.3"), 0.0003 / CELLS["increment"]),
        (("growth.steps=3", "growth.tip_stress={radius: 0.2}"), 0.0002 / CELLS["radius"]),
        (("growth.steps=0", "cracks.other={path: {points: [[5.5, -3], [5.5, 3]]}}"), 0.0005 / CELLS["room"]),
    ],
)
def test_automatic_cells_at_tips_follow_length_growth_and_room(settings: tuple[str, ...], size: float) -> None:
    contact = "cracks.other.contact={friction: 0.3, cohesion: 0}"
    more = (contact,) if "other" in settings[-1] else ()
    cover = laid_out(case("compression30", AUTO, FLAW, *settings, *more))
    (tip,) = (tip for tip in cover.tips if str(cover.cracks[tip.crack].name) == "flaw" and tip.at_end)
    assert 2.0 * tip.size == halved_to(size, cover.lattice.spacing)


@pytest.mark.parametrize(
    "settings", [(AUTO,), ("numerics.spacing=3",), ("numerics.spacing=3", "numerics.refine.tips=2")]
)
def test_the_cells_that_are_told_beforehand_are_those_of_the_first_step(settings: tuple[str, ...]) -> None:
    scene = case("compression30", *settings)
    assert cells_of(make_scene(scene), beginning(scene).cracks).equal(laid_out(scene).lattice.cells)


def test_automatic_cells_at_a_kink_follow_both_parts_beside_it() -> None:
    long, short = 0.008, 0.001
    path = f"cracks.flaw.path={{points: [[-8, 0], [0, 0], [0, {1e3 * short}]]}}"
    cover = laid_out(case("compression30", AUTO, "growth.steps=0", path))
    wanted = min((long + short) / CELLS["kink"], short / CELLS["stretch"])
    assert size_at(cover, (0.0, 0.0)) == halved_to(wanted, cover.lattice.spacing)


def test_a_rough_crack_gets_no_cells_for_each_of_its_jogs() -> None:
    x = np.linspace(-8.0, 8.0, 81)
    points = np.column_stack([x, 0.05 * (-1.0) ** np.arange(81)])
    cover = laid_out(case("compression30", AUTO, "growth.steps=0", f"cracks.flaw.path={{points: {points.tolist()}}}"))
    kinks = 0.016 / CELLS["kink"] / JOG
    assert cover.lattice.cells.size.min() / cover.lattice.cells.size.max() >= 0.5 * kinks / 0.0031


def test_automatic_cells_along_a_hole_follow_its_width() -> None:
    hole = "bodies.rock.shape.holes=[{disk: {center: [0, 12], radius: 1}}]"
    cover = laid_out(case("compression30", AUTO, FLAW, "growth.steps=0", hole))
    wanted = halved_to(0.002 / CELLS["feature"], cover.lattice.spacing)
    assert size_at(cover, (0.0, 0.0132)) == size_at(cover, (-0.0012, 0.012)) == wanted
    assert size_at(cover, (0.0, -0.025)) == 1.0


def test_the_largest_cells_are_smaller_where_a_crack_is_a_thousandth_of_what_levels_reach() -> None:
    """A crack of a micrometre in a block of 31 mm."""
    tiny = "cracks.flaw.path={points: [[0, 0], [0.001, 0]]}"
    cover = laid_out(case("compression30", AUTO, tiny, "growth.steps=0"))
    assert min(tip.size for tip in cover.tips) >= 2.0**-15
    assert all(tip.size * cover.lattice.spacing <= 1e-6 / CELLS["tip"] * 1.0000001 for tip in cover.tips)


def on(scene: Scene, **grading: Any) -> Cover:
    return cover_of(scene.with_grading(replace(scene.grading, **grading)), beginning(scene.case).cracks)


@pytest.mark.parametrize("name", ["compression30", "two_flaws", "flaw_and_hole", "tunnel_excavated", "slope_safety"])
def test_the_cells_of_a_step_are_those_of_its_companion_quartered_and_so_are_pieces_between_contact_points(
    name: str,
) -> None:
    scene = make_scene(shipped_case(name, [AUTO, *QUIET]))
    step, companion = on(scene), on(scene, companion=True)
    assert step.lattice.cells.equal(companion.lattice.cells.quartered())
    for fine, coarse in zip(step.surfaces, companion.surfaces, strict=True):
        assert fine.in_cells.total == pytest.approx(2.0 * coarse.in_cells.total, rel=1e-9)
    here = contact_faces(scene, step)
    there = contact_faces(scene.with_grading(replace(scene.grading, companion=True)), companion)
    for surface in np.unique(there.surface):
        few, many = (np.sort(faces.s[faces.surface == surface]) for faces in (there, here))
        assert len(many) > len(few)
        if len(few) > 5:  # between the ends each length in cells is halved
            along = step.surfaces[surface].in_cells
            assert np.median(np.diff(along.at(many))) == pytest.approx(np.median(np.diff(along.at(few))) / 2, rel=0.05)


def test_levels_refine_the_features_of_their_crack_alone() -> None:
    scene = make_scene(shipped_case("two_flaws", [AUTO, *QUIET]))
    given, refined = on(scene), on(scene, cracks=(2, 0))
    sizes = [{(tip.crack, tip.at_end): tip.size for tip in cover.tips} for cover in (given, refined)]
    assert all(sizes[1][end] == sizes[0][end] / (4.0 if end[0] == 0 else 1.0) for end in sizes[0])
    assert on(scene, rest=1).n_dofs > given.n_dofs


def test_places_where_contact_status_changes_have_small_cells_once_their_crack_is_refined() -> None:
    scene = make_scene(shipped_case("compression30", [AUTO, FLAW, "growth.steps=0", *QUIET]))
    middle = ((0, 0.0, 0.0),)
    sizes = [size_at(on(scene, cracks=(level,), changes=middle), (1e-5, 1e-5)) for level in (0, 3)]
    assert sizes[1] <= 0.010 / CELLS["tip"] / 8.0 / (0.5 * scene.lattice.spacing)
    assert sizes[1] < sizes[0]


def test_a_pressure_that_varies_along_a_crack_has_small_cells_where_it_does() -> None:
    pressure = "1e6*exp(-((x - 2)/0.3)**2)"
    load = f'loads=[{{crack: flaw, pressure: "{pressure}"}}]'
    scene = shipped_case("compression30", [AUTO, FLAW, "growth.steps=0", load, *QUIET])
    cover = laid_out(scene)
    assert size_at(cover, (0.0023, 1e-6)) < 0.5 * size_at(cover, (-0.0023, 1e-6))


@pytest.mark.parametrize("factor", [1e-5, 1 / 3, 1e5])
def test_automatic_cells_are_the_same_in_a_scene_of_another_size(factor: float) -> None:
    """A flaw of 12 mm whose tips ask for 1 mm where the largest cells have 4: a quarter but for rounding."""
    cells = []
    for size in (1.0, factor):
        scene = {
            "bodies.rock.shape.rectangle": {"center": [0, 0], "width": 40 * size, "height": 80 * size},
            "cracks.flaw.path": {"center": [0, 0], "length": 12 * size, "angle": 45},
            "supports.0.at": [-20 * size, -40 * size],
            "supports.1.at": [20 * size, -40 * size],
            "supports.2.at": [0, -40 * size],
            "growth.increment": 2 * size,
            "growth.tip_stress.radius": size,
        }
        settings = [f"{key}={value}".replace("'", "") for key, value in scene.items()]
        of_size = case("compression30", AUTO, *settings)
        cells.append(cells_of(make_scene(of_size), beginning(of_size).cracks))
    assert cells[0].equal(cells[1])


@pytest.mark.parametrize("accuracy", ["standard", "1 %"])
def test_the_end_of_a_crack_that_has_met_another_one_has_no_room_that_cells_are_small_by(accuracy: str) -> None:
    """It lies on the other one: cells would be halved until they can't be any more."""
    case = shipped_case("junction_static", ["numerics.spacing=auto", f"numerics.accuracy={accuracy}"])
    cover = cover_of(make_scene(case), beginning(case).cracks)
    assert cover.sizes.min() > 1e-3
