"""All functions at points, among cells of any size: unity, slopes, jumps, and the definition of tip functions."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.approximation.basis import basis_at, values_at
from crackgrow.cover.elements import locate
from crackgrow.cover.tips import tip_angle
from tests.conftest import Sample
from tests.unit.approximation.tip_values import at_polar
from tests.unit.cover_tables import gradient_rows

CRACK = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]
PLACES = [CRACK[0], CRACK[2], (5.6, 4.9)]
"""Where cells are small: at the tips, and at a place on the way to a corner of the body."""
BENT = [(6.3, 9.2), (9.2, 9.9), (12.4, 12.1), (15.9, 13.4)]
"""The kinks lie in the discs of both tips."""

GRADED = [("graded", support, levels) for support in (1.5, 2.0, 2.5) for levels in (0, 1, 3, 6)]
GATHERED = [("gathered", 2.0, 0), ("gathered", 2.0, 2), ("gathered", 1.5, 2)]
SCENES = [*GRADED, ("graded", 1.25, 3), *GATHERED, ("milli", 2.0, 0), ("many tips", 2.0, 0), ("crumb", 1.5, 0)]
of_all_scenes = pytest.mark.parametrize(("name", "support", "levels"), SCENES)


def scene(build, name: str, support: float, levels: int) -> Sample:
    """A crack all inside in spacings of 1 or 1e-3, one with gathered tips, 32 tips, two cracks that cut a crumb."""
    if name == "graded":
        return build.block((6, 5), [build.crack(CRACK)], support, levels, PLACES)
    if name == "gathered":
        sample = build.block((22, 22), [build.crack(BENT, gathered=True)], support, levels, [BENT[-1]])
        assert all(tip.carriers.gathered for tip in sample.cover.tips)
        return sample
    if name == "many tips":
        return build.field_of_cracks(4)
    if name == "milli":
        crack = build.crack(1e-3 * np.array(CRACK))
        return build.sample((0.5e-3, 0.5e-3), (6.5e-3, 5.5e-3), [crack], spacing=1e-3, support=support)
    base, roof = [(1.0, 2.5), (5.0, 2.5)], [(3.0, 2.5), (3.2, 2.8), (3.4, 2.5)]
    sample = build.sample((0.5, 0.5), (6.5, 5.5), [build.crack(base, name="base"), build.crack(roof, (False, False))])
    assert sample.cover.patches.in_crumb.any()
    return sample


def inner_points(sample: Sample, seed: int, n: int = 600) -> tuple[np.ndarray, np.ndarray]:
    """Random points, most of them near tips, that are not within rounding of an edge or a tip, and their elements."""
    rng, cover = np.random.default_rng(seed), sample.cover
    tips = np.array([tip.point for tip in cover.tips])
    points = rng.uniform(sample.region.bounds[:2], sample.region.bounds[2:], (n, 2))
    spread = rng.choice([0.3, 0.05], (2 * n, 1))
    points = np.concatenate([points, tips[rng.integers(len(tips), size=2 * n)] + spread * rng.normal(size=(2 * n, 2))])
    elements = locate(sample.lattice, cover.elements, points)
    points, elements = points[elements >= 0], elements[elements >= 0]
    radius = 1e-5 * cover.elements.size[elements, None]
    around = [points + radius * d for d in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    keep = np.all([locate(sample.lattice, cover.elements, p) == elements for p in around], axis=0)
    far = np.hypot(*(points[:, None] - tips).transpose(2, 0, 1)).min(axis=1) > 0.02 * cover.elements.size[elements]
    return points[keep & far], elements[keep & far]


@of_all_scenes
def test_plain_functions_reproduce_linear_fields_and_all_have_the_slopes_of_their_values(
    build, name: str, support: float, levels: int
) -> None:
    """And fields are the products of their rows with coefficients."""
    sample = scene(build, name, support, levels)
    cover, n_patches = sample.cover, len(sample.cover.patches.nodes)
    points, elements = inner_points(sample, 20)
    assert len(points) > 700
    size = cover.elements.size[elements, None]
    assert size.min() == 0.5**levels
    basis = basis_at(cover, points, elements)
    slopes = [sample.lattice.spacing * slope for slope in gradient_rows(basis)]
    assert (basis.rows.count_nonzero(axis=0) > 0).sum() > 0.7 * cover.n_functions
    assert np.abs(basis.rows - values_at(cover, points, elements).rows).max() < 1e-13
    np.testing.assert_allclose(basis.rows[:, :n_patches].sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(basis.rows[:, :n_patches] @ cover.patches.nodes, points, rtol=0.0, atol=1e-12)
    step = 1e-6 * size
    for axis, slope in enumerate(slopes):
        plain, along = slope[:, :n_patches], np.eye(2)[axis]
        assert np.abs(plain.sum(axis=1) * size[:, 0]).max() < 1e-10
        assert np.abs((plain @ cover.patches.nodes - along) * size).max() < 1e-10
        ahead, behind = (values_at(cover, points + s * step * along, elements).rows for s in (1.0, -1.0))
        difference = (ahead - behind).toarray() / (2.0 * step)
        # per side of a cell: step^2 times the third derivative r^-2.5 = 2e4 at r = 0.02: 2e-8; rounding 1e-16 / step
        assert (np.abs(slope.toarray() - difference) * size).max() < 5e-8
    u = np.random.default_rng(6).normal(size=(cover.n_functions, 2))
    expected = [matrix @ u for matrix in (basis.rows, *gradient_rows(basis))]
    for n in (0, 1, len(points)):
        found, alone = (make(cover, points[:n], elements[:n]).fields(u.ravel()) for make in (basis_at, values_at))
        for field, exact in zip([*found, *alone], [*expected, expected[0]], strict=True):
            np.testing.assert_allclose(field, exact[:n], atol=1e-12 * np.abs(exact).max())


@pytest.mark.parametrize(("name", "support", "levels"), [kind for kind in SCENES if kind[0] != "crumb"])
def test_functions_jump_on_cracks_and_nowhere_else(build, name: str, support: float, levels: int) -> None:
    """On edges between neighbours, their slopes as well; nodes have the same values from both sides of a crack."""
    sample, rng = scene(build, name, support, levels), np.random.default_rng(levels)
    cover, edges, n_patches = sample.cover, sample.cover.elements.edges, len(sample.cover.patches.nodes)
    share = rng.uniform(0.0, 1.0, (len(edges.a), 1))
    places = (1.0 - share) * cover.elements.vertices[edges.a] + share * cover.elements.vertices[edges.b]
    inside = (edges.left >= 0) & (edges.right >= 0)
    for crack in (False, True):
        some = rng.permutation(np.flatnonzero(inside & (cover.elements.passable != crack)))[:1000]
        assert len(some) >= 5
        left, right = (basis_at(cover, places[some], side[some]) for side in (edges.left, edges.right))
        jumps = abs(left.rows - right.rows)
        if crack:
            assert jumps[:, n_patches:].max() > 0.1
            squares = [(side.rows[:, :n_patches] ** 2).sum(axis=1) for side in (left, right)]
            np.testing.assert_allclose(*squares, rtol=1e-12)
            assert np.count_nonzero(jumps[:, :n_patches].max(axis=1).toarray()) > 0.3 * len(some)
        else:
            assert jumps.max() < 1e-12
            size = cover.elements.size[edges.left[some]] * sample.lattice.spacing
            for slope, beyond in zip(gradient_rows(left), gradient_rows(right), strict=True):
                assert (abs(slope - beyond).max(axis=1).toarray().ravel() * size).max() < 1e-10


@pytest.mark.parametrize("support", [1.5, 2.0, 2.5])
def test_moments_are_as_well_conditioned_as_on_one_size(build, support: float) -> None:
    """The sum of the absolute values of all functions at a point bounds how far errors are blown up."""
    worst = []
    for levels in (0, 2, 6):
        sample = scene(build, "graded", support, levels)
        found = values_at(sample.cover, *inner_points(sample, 5)).rows[:, : len(sample.cover.patches.nodes)]
        worst.append(abs(found).sum(axis=1).max())
    assert max(worst) < 1.5 * worst[0]


@pytest.mark.parametrize(
    ("name", "levels"), [("graded", 0), ("graded", 3), ("many tips", 0), ("gathered", 0), ("gathered", 2)]
)
def test_functions_at_tips_are_the_carriers_times_the_four_within_their_reach(build, name: str, levels: int) -> None:
    """A carrier is the function of a patch, or a sum over patches for gathered ones."""
    sample = scene(build, name, 2.0, levels)
    cover, n_patches = sample.cover, len(sample.cover.patches.nodes)
    points, elements = inner_points(sample, 30, 2000)
    found, seen = values_at(cover, points, elements).rows.toarray(), 0
    for tip in cover.tips:
        four, first = at_polar(tip, *tip_angle(tip, points, cover.elements.reference[elements]))[0], tip.first_function
        for carrier in range(tip.carriers.n):
            mine = tip.carriers.number == carrier
            sums = found[:, :n_patches][:, tip.patches[mine]] @ tip.carriers.shares[mine]
            own = slice(first + 4 * carrier, first + 4 * carrier + 4)
            tolerance = 1e-13 if tip.carriers.gathered else 1e-14
            np.testing.assert_allclose(found[:, own], sums[:, None] * four, atol=tolerance)
        seen += 4 * tip.carriers.n
        near = found[:, first : first + 4 * tip.carriers.n].any(axis=1)
        farthest = np.hypot(*(points[near] - tip.point).T).max()
        assert 0.6 * tip.carriers.gathered * tip.carriers.reach < farthest <= tip.carriers.reach
    assert n_patches + seen == cover.n_functions
