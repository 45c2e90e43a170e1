"""A cover made from the one before is the same, to the last bit, as one made from nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
import pytest
import shapely

from crackgrow.case.surface import SurfaceName, crack_name
from crackgrow.cover.cover import Cover, build_cover
from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.errors import GeometryError
from crackgrow.geometry.polyline import first_hit

BOX = np.array([(0.5, 0.5), (8.5, 0.5), (8.5, 7.5), (0.5, 7.5)])
HOLE = 4.6 + 0.9 * np.array([(np.cos(t), -np.sin(t)) for t in np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)])


def assert_same(one: Any, other: Any, where: str = "cover") -> None:
    assert type(one) is type(other), where
    if isinstance(one, shapely.STRtree):
        one, other = one.geometries, other.geometries
    if is_dataclass(one):
        for field in fields(one):
            assert_same(getattr(one, field.name), getattr(other, field.name), f"{where}.{field.name}")
    elif isinstance(one, tuple):
        assert len(one) == len(other), where
        for k, (first, second) in enumerate(zip(one, other, strict=True)):
            assert_same(first, second, f"{where}[{k}]")
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype, where
        assert one.shape == other.shape, where
        if one.dtype == object:
            one, other = shapely.to_wkb(one), shapely.to_wkb(other)
        np.testing.assert_array_equal(one, other, err_msg=where)
    else:
        assert one == other, where


def lattice_of(support: float) -> Lattice:
    return place_lattice(BOX[0], BOX[2], 1.0, support)


def follow(
    lattice: Lattice,
    bodies: Sequence[BodyGeometry],
    paths: Iterator[list[CrackGeometry]],
    interfaces: Sequence[CrackGeometry] = (),
) -> list[Cover]:
    """Covers of cracks that grow, each made with the one before, held against one that is made without."""
    covers: list[Cover] = []
    for cracks in paths:
        cover = build_cover(lattice, bodies, cracks, interfaces, before=covers[-1] if covers else None)
        assert_same(cover, build_cover(lattice, bodies, cracks, interfaces))
        covers.append(cover)
    return covers


def growing(
    lattice: Lattice, path: Sequence[tuple[float, float]], first: int, tips: tuple[bool, bool] = (True, True)
) -> Iterator[list[CrackGeometry]]:
    """A crack along a path, with one more vertex each time."""
    for n in range(first, len(path) + 1):
        yield [CrackGeometry(crack_name("crack"), lattice.to_lattice(np.array(path[:n])), *tips)]


def body(lattice: Lattice, *rings: np.ndarray) -> BodyGeometry:
    return BodyGeometry(tuple(lattice.to_lattice(ring) for ring in rings))


PATHS = {
    "kinks": [(2.2, 2.3), (3.4, 2.6), (4.1, 3.7), (3.9, 5.2), (5.8, 5.9)],
    "on lattice lines": [(1.0, 2.0), (3.0, 2.0), (3.0, 4.0), (4.5, 4.0), (6.0, 5.5), (7.0, 5.5)],
    "past nodes": [(1.0, 1.2), (2.0 + 1e-9, 2.2), (3.0, 3.0 - 1e-9), (4.0 - 1e-10, 4.0), (5.3, 5.3), (6.0, 6.0)],
    "short steps": [(2.0, 2.4), (2.6, 2.4), (2.7, 2.45), (2.8, 2.47), (2.9, 2.5), (3.0, 2.5), (3.1, 2.6)],
    "back towards itself": [(2.0, 2.0), (5.0, 2.2), (6.0, 3.6), (4.6, 4.8), (3.1, 4.0), (3.4, 2.8)],
}


@pytest.mark.parametrize("support", [1.5, 2.0, 2.25])
@pytest.mark.parametrize("name", PATHS)
def test_a_crack_that_grows(name: str, support: float) -> None:
    lattice = lattice_of(support)
    covers = follow(lattice, [body(lattice, BOX)], growing(lattice, PATHS[name], 2))
    assert len(covers) == len(PATHS[name]) - 1


def test_only_tiles_whose_lines_have_changed_are_cut_again() -> None:
    lattice = lattice_of(1.5)
    path = [(1.0, 1.2), (4.0, 4.4), (6.0, 5.9), (6.5, 6.7)]  # its ends do not see each other
    before, after = follow(lattice, [body(lattice, BOX)], growing(lattice, path, 3))
    old, new = before.elements.cut, after.elements.cut
    taken = {id(polygon) for polygon in old.polygons}
    kept = np.array([id(polygon) in taken for polygon in new.polygons])
    near = shapely.dwithin(new.polygons, shapely.LineString(after.cracks[0].points[-2:]), 1.5)
    assert kept[~near].all()
    assert not kept[near].all()
    assert kept.sum() > 0.6 * len(kept)


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_a_crack_that_breaks_through(support: float) -> None:
    lattice = lattice_of(support)
    path = [(0.5, 2.3), (3.2, 2.9), (6.0, 3.4), (8.5, 4.0)]
    steps = [*growing(lattice, path[:3], 2, (False, True)), *growing(lattice, path, 4, (False, False))]
    assert [len(cover.tips) for cover in follow(lattice, [body(lattice, BOX)], iter(steps))] == [1, 1, 0]


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_cracks_that_meet(support: float) -> None:
    """The growing one reaches the other, which gets a junction; then the latter grows on."""
    lattice = lattice_of(support)
    other = np.array([(1.6, 5.2), (5.7, 4.6)])
    longer = np.array([(1.6, 5.2), (5.7, 4.6), (6.9, 4.9)])
    hit = other[0] + 0.6 * (other[1] - other[0])
    path = [(2.2, 1.7), (2.9, 2.6), (3.4, 3.6), tuple(hit)]
    steps = [[*cracks, CrackGeometry(crack_name("other"), lattice.to_lattice(other), True, True)]
             for cracks in growing(lattice, path, 2, (True, True))]  # fmt: skip
    steps.append([steps[-1][0], CrackGeometry(crack_name("other"), lattice.to_lattice(longer), True, True)])
    covers = follow(lattice, [body(lattice, BOX)], iter(steps))
    assert [len(cover.tips) for cover in covers] == [4, 4, 3, 3]


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_two_bodies_with_an_interface_that_a_crack_reaches(support: float) -> None:
    lattice = lattice_of(support)
    low = np.array([(0.5, 0.5), (8.5, 0.5), (8.5, 4.1), (0.5, 3.3)])
    high = np.array([(0.5, 3.3), (8.5, 4.1), (8.5, 7.5), (0.5, 7.5)])
    interface = CrackGeometry(
        SurfaceName("interface", ("left", "right")), lattice.to_lattice(low[[3, 2]]), False, False
    )
    hit = low[3] + 0.37 * (low[2] - low[3])
    path = [(2.1, 1.2), (2.6, 2.0), (2.9, 2.8), tuple(hit)]
    steps = growing(lattice, path, 2, (True, True))
    covers = follow(lattice, [body(lattice, low), body(lattice, high)], steps, [interface])
    assert [len(cover.tips) for cover in covers] == [2, 2, 1]


def random_growth(rng: np.random.Generator, lattice: Lattice, n_steps: int) -> Iterator[list[CrackGeometry]]:
    """Cracks of a body with a hole that grow at random, until their ends meet an outline or another crack."""
    starts = rng.uniform((1.5, 1.5), (3.2, 6.5), (2, 2)), rng.uniform((5.8, 1.5), (7.5, 6.5), (1, 2))
    paths = [np.stack([at, at + rng.uniform(-0.7, 0.7, 2)]) for at in np.concatenate(starts)]
    arrested = np.zeros((len(paths), 2), dtype=bool)
    rim = [shapely.LinearRing(BOX), shapely.LinearRing(HOLE)]
    for _ in range(n_steps):
        yield [
            CrackGeometry(crack_name(str(k)), lattice.to_lattice(path), not arrested[k, 0], not arrested[k, 1])
            for k, path in enumerate(paths)
        ]
        for k, end in np.ndindex(len(paths), 2):
            if arrested[k, end] or rng.random() < 0.3:
                continue
            along = paths[k] if end else paths[k][::-1]
            step = (along[-1] - along[-2]) / np.hypot(*(along[-1] - along[-2]))
            turn = rng.uniform(-0.6, 0.6)
            step = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ step
            far = along[-1] + rng.uniform(0.2, 1.2) * step
            others = [shapely.LineString(path) for m, path in enumerate(paths) if m != k]
            hit = first_hit(shapely.GeometryCollection([*rim, *others]), along[-1], far)
            arrested[k, end] = hit is not None
            grown = np.vstack([along, far if hit is None else hit])
            paths[k] = grown if end else grown[::-1]


def made_or_refused(
    lattice: Lattice, bodies: list[BodyGeometry], cracks: list[CrackGeometry], before: Cover | None
) -> Cover | str:
    try:
        return build_cover(lattice, bodies, cracks, before=before)
    except GeometryError as error:
        return str(error)


@pytest.mark.parametrize("seed", range(12))
def test_random_growth_in_a_body_with_a_hole(seed: int) -> None:
    """What no cover can represent is refused with and without the one before."""
    rng = np.random.default_rng(seed)
    lattice = lattice_of((1.5, 2.0, 1.75)[seed % 3])
    bodies = [body(lattice, BOX, HOLE)]
    before, n_made = None, 0
    for cracks in random_growth(rng, lattice, 6):
        alone, made = (made_or_refused(lattice, bodies, cracks, known) for known in (None, before))
        assert_same(made, alone)
        if isinstance(made, Cover):
            before, n_made = made, n_made + 1
    assert n_made >= 3


def test_cracks_of_another_scene_are_no_matter() -> None:
    """Of a cover of other bodies nothing is taken over, and of one of other cracks only what is the same."""
    lattice = lattice_of(2.0)
    box, holed = body(lattice, BOX), body(lattice, BOX, HOLE)
    crack = CrackGeometry(crack_name("crack"), lattice.to_lattice(np.array([(1.5, 1.4), (3.3, 2.0)])), True, True)
    moved = replace(crack, points=crack.points + np.array([0.3, 0.2]))
    for before in (build_cover(lattice, [box], [moved]), build_cover(lattice, [holed], [crack])):
        assert_same(build_cover(lattice, [box], [crack], before=before), build_cover(lattice, [box], [crack]))
