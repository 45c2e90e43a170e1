"""Features: where cells are small, and what becomes of them as cracks grow."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from crackgrow.case.accuracy import CELLS
from crackgrow.case.model import Case
from crackgrow.cover.cover import Cover
from crackgrow.run.checkpoint import beginning
from crackgrow.run.layout import cells_of, contact_faces, cover_of
from crackgrow.run.scene import Scene, make_scene
from crackgrow.run.size_field import JOG
from tests.scenes import one_size, shipped_case
from tests.verification.solutions import QUIET

FLAW = "cracks.flaw.path={points: [[-5, 0], [5, 0]]}"
AUTO = "numerics.spacing=auto"
THREE = "numerics.spacing=3"


def case(name: str, *settings: str) -> Case:
    return shipped_case(name, [*one_size(name), *settings, *QUIET])


def laid_out(scene: Case) -> Cover:
    return cover_of(make_scene(scene), beginning(scene).cracks)


def automatic(*settings: str) -> Cover:
    """The cover of `compression30` with automatic cells, without growth unless it is set."""
    return laid_out(case("compression30", AUTO, "growth.steps=0", *settings))


def size_at(cover: Cover, metres: tuple[float, float]) -> float:
    """Side of the cell at a place, spacings."""
    lattice = cover.lattice
    tile = lattice.tiles_at(lattice.to_lattice(np.array([metres])))[0]
    return float(lattice.cells.size[lattice.tiles.cell[tile]] / lattice.cells.size.max())


def test_tips_kinks_corners_and_junctions_get_the_cells_that_they_ask_for() -> None:
    path = "cracks.flaw.path={points: [[-6, -4], [0, 0], [5, 0]]}"
    notch = "bodies.rock.shape.holes=[{rectangle: {center: [9, 18], width: 6, height: 6}}]"
    cover = laid_out(case("compression30", path, notch, THREE, "numerics.refine={tips: 2, kinks: 4, corners: 1}"))
    assert [tip.size for tip in cover.tips] == [0.25, 0.25]
    places = ((0.0, 0.0), (0.0061, 0.0149), (-0.013, 0.005))
    assert [size_at(cover, place) for place in places] == [2.0**-4, 0.5, 1.0]
    assert laid_out(case("junction_static", "numerics.refine.kinks=2")).elements.size.min() == 0.25
    assert np.all(laid_out(case("compression30", "numerics.refine.rings=3")).elements.size == 1.0)


LONG, SHORT = 0.008, 0.001
CORNERED = f"cracks.flaw.path={{points: [[-8, 0], [0, 0], [0, {1e3 * SHORT}]]}}"
BESIDE = ("cracks.other={path: {points: [[5.5, -3], [5.5, 3]]}, contact: {friction: 0.3, cohesion: 0}}", FLAW)
HOLE = "bodies.rock.shape.holes=[{disk: {center: [0, 12], radius: 1}}]"
AT_TIP = [(0.005, 0.0)]
FEATURES = {
    "length": ((FLAW,), AT_TIP, 0.010 / CELLS["stretch"]),
    "growth": ((FLAW, "growth.steps=3", "growth.increment=0.3"), AT_TIP, 0.0003 / CELLS["increment"]),
    "radius": ((FLAW, "growth.steps=3", "growth.tip_stress={radius: 0.2}"), AT_TIP, 0.0002 / CELLS["radius"]),
    "room": (BESIDE, AT_TIP, 0.0005 / CELLS["room"]),
    "kink": ((CORNERED,), [(0.0, 0.0)], min((LONG + SHORT) / CELLS["kink"], SHORT / CELLS["stretch"])),
    "hole": ((FLAW, HOLE), [(0.0, 0.0132), (-0.0012, 0.012)], 0.002 / CELLS["feature"]),
}
"""Settings, places (m) of a feature, and the cells (m) that it asks for."""


@pytest.mark.parametrize("name", FEATURES)
def test_automatic_cells_follow_lengths_growth_room_kinks_and_holes(name: str) -> None:
    settings, places, wanted = FEATURES[name]
    cover = automatic(*settings)
    expected = 2.0 ** -max(0, np.ceil(np.log2(0.5 * cover.lattice.spacing / wanted)))  # of the largest of the step
    assert [size_at(cover, place) for place in places] == [expected] * len(places)
    assert size_at(cover, (0.0, -0.025)) == 1.0


def test_automatic_cells_are_larger_at_kinks_that_turn_less_and_at_none_of_many_jogs() -> None:
    kinked = "cracks.flaw.path={{points: [[-6, 0], [0, 0], [6, {}]]}}"
    sizes = [size_at(automatic(kinked.format(y)), (1e-6, 1e-6)) for y in (0.02, 0.3, 0.6, 1.2)]  # 0.2 to 12 degrees
    assert sizes[0] > sizes[1] > sizes[2] > sizes[3]
    points = np.column_stack([np.linspace(-8.0, 8.0, 81), 0.05 * (-1.0) ** np.arange(81)])
    cells = automatic(f"cracks.flaw.path={{points: {points.tolist()}}}").lattice.cells
    assert cells.size.min() / cells.size.max() >= 0.5 * 0.016 / CELLS["kink"] / JOG / 0.0031


def test_a_pressure_that_varies_along_a_crack_has_small_cells_where_it_does() -> None:
    cover = automatic(FLAW, 'loads=[{crack: flaw, pressure: "1e6*exp(-((x - 2)/0.3)**2)"}]')
    assert size_at(cover, (0.0023, 1e-6)) < 0.5 * size_at(cover, (-0.0023, 1e-6))


def test_the_largest_cells_are_smaller_where_a_crack_is_a_thousandth_of_what_levels_reach() -> None:
    """A crack of a micrometre in a block of 31 mm."""
    cover = automatic("cracks.flaw.path={points: [[0, 0], [0.001, 0]]}")
    assert min(tip.size for tip in cover.tips) >= 2.0**-15
    assert all(tip.size * cover.lattice.spacing <= 1e-6 / CELLS["tip"] * 1.0000001 for tip in cover.tips)


@pytest.mark.parametrize("settings", [(AUTO,), (THREE,), (THREE, "numerics.refine.tips=2")])
def test_the_cells_that_are_told_beforehand_are_those_of_the_first_step(settings: tuple[str, ...]) -> None:
    scene = case("compression30", *settings)
    assert cells_of(make_scene(scene), beginning(scene).cracks).equal(laid_out(scene).lattice.cells)


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


def test_levels_refine_the_features_of_their_crack_alone_and_where_its_contact_changes() -> None:
    scene = make_scene(shipped_case("two_flaws", [AUTO, *QUIET]))
    given, refined = on(scene), on(scene, cracks=(2, 0))
    sizes = [{(tip.crack, tip.at_end): tip.size for tip in cover.tips} for cover in (given, refined)]
    assert all(sizes[1][end] == sizes[0][end] / (4.0 if end[0] == 0 else 1.0) for end in sizes[0])
    assert on(scene, rest=1).n_dofs > given.n_dofs
    scene = make_scene(case("compression30", AUTO, FLAW, "growth.steps=0"))
    few, many = (size_at(on(scene, cracks=(level,), changes=((0, 0.0, 0.0),)), (1e-5, 1e-5)) for level in (0, 3))
    assert many <= 0.010 / CELLS["tip"] / 8.0 / (0.5 * scene.lattice.spacing)
    assert many < few


@pytest.mark.parametrize("unit", ["um", "in", "km"])
def test_automatic_cells_are_the_same_in_a_scene_of_another_size(unit: str) -> None:
    """A flaw of 12 mm whose tips ask for 1 mm where the largest cells have 4: a quarter but for rounding."""
    plate = "bodies.rock.shape.rectangle={center: [0, 0], width: 40, height: 80}"
    flaw = "cracks.flaw.path={center: [0, 0], length: 12, angle: 45}"
    held = (f"supports.{number}.at=[{x}, -40]" for number, x in enumerate((-20, 20, 0)))
    settings = (plate, flaw, *held, "growth.increment=2", "growth.tip_stress.radius=1")
    here, there = (case("compression30", AUTO, *settings, f"units.length={length}") for length in ("mm", unit))
    assert laid_out(here).lattice.cells.equal(laid_out(there).lattice.cells)


def test_the_end_of_a_crack_that_has_met_another_one_has_no_room_that_cells_are_small_by() -> None:
    """It lies on the other one: cells would be halved until they can't be any more."""
    for accuracy in ("standard", "1 %"):
        cover = laid_out(shipped_case("junction_static", [AUTO, f"numerics.accuracy={accuracy}"]))
        assert cover.elements.size.min() > 1e-3
