"""All functions at points: closed forms, unity, slopes and jumps among cells of any size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.approximation.basis import fields_at, values_at
from crackgrow.approximation.mls import mls
from crackgrow.approximation.tip_functions import tip_functions
from crackgrow.cover.elements import locate
from crackgrow.cover.shapes import Roots
from crackgrow.cover.tips import TipView, seen_from_tip, tip_table
from tests.conftest import Sample
from tests.unit.exact_fields import PAPER, gradient_rows

CRACK = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]
PLACES = [CRACK[0], CRACK[2], (5.6, 4.9)]
"""Where cells are small: at the tips, and at a place on the way to a corner of the body."""
BENT = [(6.3, 9.2), (9.2, 9.9), (12.4, 12.1), (15.9, 13.4)]
"""The kinks lie in the discs of both tips."""

MET = [
    ([(0.5, 7.3), (6.2, 7.9), (12.5, 7.6)], (False, False)),  # through
    ([(0.5, 2.2), (3.1, 2.7)], (False, True)),  # from the side
    ([(4.7, 2.2), (7.9, 3.0)], (True, True)),  # crosses the next one
    ([(6.0, 1.4), (6.6, 4.1)], (True, True)),
    ([(9.0, 2.2), (12.0, 3.0)], (True, True)),  # branches
    ([(10.5, 2.6), (10.8, 4.1)], (False, True)),
    ([(1.3, 5.0), (3.0, 5.0), (3.0, 6.6)], (True, True)),  # on lattice lines
]
"""Cracks and which of their ends are tips."""

GRADED = [("graded", support, levels) for support in (1.5, 2.0, 2.5) for levels in (0, 1, 3, 6)]
GATHERED = [("gathered", 2.0, 0), ("gathered", 2.0, 2), ("gathered", 1.5, 2)]
LINES = [("lines", support, 0) for support in (1.5, 2.0, 2.5)]
OTHERS = [("milli", 2.0, 0), ("many tips", 2.0, 0), ("crumb", 1.5, 0)]
SCENES = [*GRADED, ("graded", 1.25, 3), *GATHERED, *LINES, *OTHERS]
of_all_scenes = pytest.mark.parametrize(("name", "support", "levels"), SCENES)


def scene(build, name: str, support: float, levels: int) -> Sample:
    """A crack all inside in spacings of 1 or 1e-3, gathered tips, cracks that meet, 32 tips, two that cut a crumb."""
    if name == "graded":
        return build.block((6, 5), [build.crack(CRACK)], support, levels, PLACES)
    if name == "gathered":
        sample = build.block((22, 22), [build.crack(BENT, gathered=True)], support, levels, [BENT[-1]])
        assert all(tip.carriers.gathered for tip in sample.cover.tips)
        return sample
    if name == "lines":
        cracks = [build.crack(points, tips, str(k)) for k, (points, tips) in enumerate(MET)]
        return build.block((12, 9), cracks, support)
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
    rows, slopes = values_at(cover, points, elements), gradient_rows(cover, points, elements)
    assert (rows.count_nonzero(axis=0) > 0).sum() > 0.7 * cover.n_functions
    np.testing.assert_allclose(rows[:, :n_patches].sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(rows[:, :n_patches] @ cover.patches.nodes, points, rtol=0.0, atol=1e-12)
    step = 1e-6 * size
    for axis, slope in enumerate(slopes):
        plain, along = slope[:, :n_patches], np.eye(2)[axis]
        assert np.abs(plain.sum(axis=1) * size[:, 0]).max() < 1e-10
        assert np.abs((plain @ cover.patches.nodes - along) * size).max() < 1e-10
        ahead, behind = (values_at(cover, points + s * step * along, elements) for s in (1.0, -1.0))
        difference = (ahead - behind).toarray() / (2.0 * step)
        # per side of a cell: step^2 times the third derivative r^-2.5 = 2e4 at r = 0.02: 2e-8; rounding 1e-16 / step
        assert (np.abs(slope.toarray() - difference) * size).max() < 5e-8
    u = np.random.default_rng(6).normal(size=(cover.n_functions, 2))
    expected = [rows @ u, *(slope @ u / sample.lattice.spacing for slope in slopes)]
    for n in (0, 1, len(points)):
        at = points[:n], elements[:n], u.ravel()
        found, alone = fields_at(cover, *at), fields_at(cover, *at, derivatives=False)
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
        sides = [(cover, places[some], side[some]) for side in (edges.left, edges.right)]
        left, right = (values_at(*side) for side in sides)
        jumps = abs(left - right)
        if crack:
            assert jumps[:, n_patches:].max() > 0.1
            squares = [(side[:, :n_patches] ** 2).sum(axis=1) for side in (left, right)]
            np.testing.assert_allclose(*squares, rtol=1e-12)
            assert np.count_nonzero(jumps[:, :n_patches].max(axis=1).toarray()) > 0.3 * len(some)
        else:
            assert jumps.max() < 1e-12
            size = cover.elements.size[edges.left[some]]
            for slope, beyond in zip(*(gradient_rows(*side) for side in sides), strict=True):
                assert (abs(slope - beyond).max(axis=1).toarray().ravel() * size).max() < 1e-10


def functions_of(nodes: np.ndarray, point: np.ndarray, support: float) -> np.ndarray:
    """Values and derivatives (3, k) at a point (2,) of the functions of nodes (k, 2), all of one half width."""
    k = len(nodes)
    found, alone, work, per_half = np.empty((3, k)), np.empty((1, k)), np.empty((5, k)), np.full(k, 1.0 / support)
    at = np.ascontiguousarray(nodes.T, dtype=float)
    mls(*point, at, per_half, k, True, found, work)
    mls(*point, at, per_half, k, False, alone, work)
    np.testing.assert_array_equal(alone[0], found[0])
    return found


def test_weight_is_the_cubic_spline() -> None:
    """Two groups of nodes mirrored about the point: phi follow from ratios of w(q) = 4/3 ((1-q)^3 - 4 (1/2-q)^3)."""
    for a, b in ((0.2, 0.4), (0.3, 0.8), (0.6, 0.9)):
        nodes = np.array([(s * d, t) for d in (a, b) for s in (-1.0, 1.0) for t in (-0.1, 0.1)])
        phi = functions_of(nodes, np.zeros(2), 1.0)[0]
        w = [4 / 3 * ((1 - q) ** 3 - 4 * max(0.5 - q, 0.0) ** 3) for q in (a, b)]
        np.testing.assert_allclose(phi[:4], w[0] / (4.0 * (w[0] + w[1])), rtol=1e-13)
        np.testing.assert_allclose(phi[4:], w[1] / (4.0 * (w[0] + w[1])), rtol=1e-13)


POINTS = np.array([[4.0, 3.0], [3.2, 2.9], [2.6, 2.3], [1.6, 2.5]])


def tip_with(fade: float) -> TipView:
    return replace(seen_from_tip(POINTS, 1.0, ends_inside=False), fade=fade)


def test_tip_functions_follow_the_closed_form_and_those_with_sines_jump_across_the_crack() -> None:
    r, t = np.array([0.25, 1.0, 4.0, 1.0, 1.0]), np.array([0.0, np.pi, -np.pi, np.pi / 2, -np.pi / 3])
    s = np.sqrt(0.5)
    expected = [[0.5, 0, 0.5, 0], [0, 1, 0, -1], [0, -2, 0, 2], [s, s, -s, s], [np.sqrt(3) / 2, -0.5, 0, -1]]
    np.testing.assert_allclose(at_polar(tip_with(np.inf), r, t)[0] @ PAPER.T, expected, atol=1e-15)
    values, gradients = at_polar(tip_with(np.inf), np.zeros(1), np.zeros(1))
    assert np.all(values == 0.0)
    assert np.isfinite(gradients).all()


@pytest.mark.parametrize("roots", [(1j, 1j), (0.3 + 0.6j, -0.4 + 1.7j)], ids=["isotropic", "bedded"])
def test_tip_functions_have_their_derivatives_and_their_jump_on_whatever_turn_the_crack_is(roots: Roots) -> None:
    tip, (r, t) = tip_with(2.0), np.random.default_rng(5).uniform((0.1, -5.0), (1.9, 5.0), (40, 2)).T
    places = (r * np.array([np.cos(t), np.sin(t)])).T
    values, slopes = at_polar(tip, r, t, roots)
    for axis in range(2):
        ends = [places + step * tip.rotation[:, axis] for step in (-1e-6, 1e-6)]
        angles = [t + np.angle(np.exp(-1j * t) * (end @ (1.0, 1.0j))) for end in ends]
        before, after = (at_polar(tip, np.hypot(*end.T), a, roots)[0] for end, a in zip(ends, angles, strict=True))
        np.testing.assert_allclose(slopes[:, :, axis], (after - before) / 2e-6, atol=1e-7)
    np.testing.assert_allclose(at_polar(tip, r, t + 2.0 * np.pi, roots)[0], -values, atol=1e-14)


def test_fading_multiplies_by_chi_and_leaves_nothing_beyond() -> None:
    r, t = np.linspace(0.01, 3.0, 60), np.linspace(-3, 3, 60)
    (plain, _), (faded, slopes) = (at_polar(tip_with(fade), r, t) for fade in (np.inf, 2.0))
    chi = np.where(r < 2.0, (1 - (r / 2.0) ** 2) ** 2, 0.0)
    np.testing.assert_allclose(faded, chi[:, None] * plain, atol=1e-15)
    assert not faded[r >= 2.0].any()
    assert not slopes[r >= 2.0].any()


def at_polar(tip: TipView, r: np.ndarray, t: np.ndarray, roots: Roots = (1j, 1j)) -> tuple[np.ndarray, np.ndarray]:
    """Values (n, 4) and gradients (n, 4, 2) at polar coordinates (n,) round a tip, on the side that the angles say."""
    points = (r * np.array([np.cos(t), np.sin(t)])).T @ tip.rotation
    (row,), found = tip_table([replace(tip, point=np.zeros(2))], [roots]), np.empty((len(r), 3, 4))
    for point, side, f in zip(points, t, found, strict=True):
        tip_functions(*point, row, side, f)
    return found[:, 0], found[:, 1:].transpose(0, 2, 1)
