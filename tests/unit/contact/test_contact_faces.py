"""Contact points along cracks: how many, where, their functions and weights; the jump operator on known fields."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.contact.faces import ContactFaces, gauss_faces, points_at, stretch_ends
from crackgrow.contact.jump import contact_operators, gap_and_slip
from crackgrow.contact.mortar import mortar_faces
from crackgrow.cover.cell_lengths import sizes_beside
from crackgrow.cover.cover import Cover
from crackgrow.geometry.polyline import arc_lengths

ROUND_OFF = 1e-8
"""In spacings: vertices lie on a grid of 1e-9 spacings, so that lengths are exact to a few of those."""

LENGTH = 10.0
KINKED = [(-4.3, -3.1), (-0.9, -2.2), (1.2, 1.9), (4.4, 2.6)]  # turns by 48 and 51 degrees
PATHS = {
    "straight": [(-4.13, -2.02), (4.53, 2.98)],
    "kinked": KINKED,
    "gentle": [(-4.3, -3.1), (-0.2, -1.7), (4.1, 0.9)],
    "along the lattice": [(-4.0, 0.5), (4.0, 0.5)],
}
THROUGH = [(-15.5, 3.3), (15.5, 3.3)]
"""From side to side of the plate."""


def tilted(length: float, angle_deg: float) -> np.ndarray:
    a = np.deg2rad(angle_deg)
    half = 0.5 * length * np.array([np.cos(a), np.sin(a)])
    return np.array([-half, half])


def bent(lengths: list[float], *kinks_deg: float) -> np.ndarray:
    """Segments of these lengths, each turned by a kink from the one before."""
    a = np.deg2rad(10.0 + np.cumsum([0.0, *kinks_deg]))
    steps = np.array(lengths)[:, None] * np.stack([np.cos(a), np.sin(a)], axis=1)
    points = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return points - 0.5 * points[-1] + np.array([0.21, 0.33])


def plate(build, *paths, spacing: float = 1.0, tips: tuple[bool, bool] = (True, True)):
    cracks = [build.crack(path, tips, name=str(k)) for k, path in enumerate(paths)]
    return build.sample((-15.5, -27.5), (15.5, 27.5), cracks, spacing=spacing, support=2.0)


def with_smaller_cells(cover: Cover, line: float, side: float) -> Cover:
    """The cover that takes cells on the right of x = `line` for those of this side; rules go by the sizes alone."""
    start, element = cover.elements.rings.start, cover.elements.rings.face
    rings = [start[element == number] for number in range(cover.elements.n)]
    middles = np.array([cover.elements.vertices[ring].mean(axis=0) for ring in rings])
    sizes = np.where(middles[:, 0] > cover.lattice.to_lattice(np.array([line, 0.0]))[0], side, 1.0)
    surfaces = tuple(replace(surface, sizes=sizes_beside(surface.edges, sizes)) for surface in cover.surfaces)
    return replace(cover, elements=replace(cover.elements, size=sizes), surfaces=surfaces)


def shape_sum(faces: ContactFaces) -> np.ndarray:
    return np.asarray(faces.functions.sum(axis=0)).ravel()


@pytest.mark.parametrize("discretize", [lambda cover: mortar_faces(cover, [0], 1.0), lambda c: gauss_faces(c, [0])])
@pytest.mark.parametrize("path", PATHS.values(), ids=PATHS.keys())
def test_functions_sum_to_one_and_weights_to_the_length(build, path, discretize) -> None:
    faces = discretize(plate(build, path).cover)
    np.testing.assert_allclose(shape_sum(faces), 1.0, rtol=1e-14)
    assert faces.functions.data.min() >= 0.0
    total = arc_lengths(np.array(path))[-1]
    assert faces.weights.sum() == pytest.approx(total, abs=ROUND_OFF)
    assert faces.lengths.sum() == pytest.approx(total, abs=ROUND_OFF)
    assert faces.weights.min() > 0.0


def test_weighted_points_integrate_along_the_crack(build) -> None:
    """Half powers of the distance from a tip, as openings have them, and polynomials."""
    faces = mortar_faces(plate(build, PATHS["straight"]).cover, [0], 0.8)
    s, total = faces.points.s, arc_lengths(np.array(PATHS["straight"]))[-1]
    for power in (0.5, 1.0, 1.5, 3.0, 4.0):
        # sqrt(distance) is integrated exactly in the piece at the tip, to 1e-9 by 5 points in the others
        assert faces.lengths @ s**power == pytest.approx(total ** (power + 1) / (power + 1), rel=1e-7)
        assert faces.lengths @ (total - s) ** power == pytest.approx(total ** (power + 1) / (power + 1), rel=1e-7)


def test_gauss_points_of_the_paper(build) -> None:
    faces = gauss_faces(plate(build, KINKED).cover, [0])
    assert np.bincount(faces.stretch).tolist() == [50, 50, 50]
    assert np.all(np.diff(faces.s) > 0.0)
    corners = arc_lengths(np.array(KINKED))
    for k in range(3):
        mine = faces.stretch == k
        low, high = corners[k], corners[k + 1]
        assert np.histogram(faces.s[mine], np.linspace(low, high, 11))[0].tolist() == [5] * 10
        # five points a part are exact to degree 9
        assert faces.weights[mine] @ faces.s[mine] ** 9 == pytest.approx((high**10 - low**10) / 10, rel=1e-8)


@pytest.mark.parametrize(
    ("lengths", "kinks", "ends"),
    [
        ([4.0, 3.2], [-9.5], [7.2]),
        ([4.0, 3.2], [10.5], [4.0, 7.2]),
        ([4.0, 3.2], [-70.0], [4.0, 7.2]),
        ([5.0, 0.12], [60.0], [5.0, 5.12]),
        ([5.0, 0.08], [60.0], [5.08]),  # just behind a tip
        ([4.0, 0.05, 0.05, 4.0], [15.0, 45.0, 20.0], [4.05, 8.1]),  # the sharpest of close ones
    ],
)
def test_sharp_kinks_split_stretches(build, lengths: list[float], kinks: list[float], ends: list[float]) -> None:
    """A gentle kink lies between two nodes, whose functions reach to both sides; nothing reaches over a sharp one."""
    cover = plate(build, bent(lengths, *kinks)).cover
    assert stretch_ends(cover, 0) == pytest.approx([0.0, *ends], abs=ROUND_OFF)
    faces = mortar_faces(cover, [0], 1.0)
    assert set(faces.stretch.tolist()) == set(range(len(ends)))
    reach = faces.functions.toarray() != 0.0
    over = [reach[:, faces.points.s < end].any(axis=1) & reach[:, faces.points.s > end].any(axis=1) for end in ends]
    assert not np.any(over)
    if len(kinks) == len(ends) == 1 and lengths[-1] > 1.0:
        assert (reach[:, faces.points.s < 4.0].any(axis=1) & reach[:, faces.points.s > 4.0].any(axis=1)).sum() == 2


@pytest.mark.parametrize(("spacing", "n"), [(3.0, 5), (1.5, 5), (1.0, 9), (0.5, 19)])
@pytest.mark.parametrize("angle", [0.0, 30.0, -75.0])
def test_nodes_of_a_10_mm_crack(build, angle: float, spacing: float, n: int) -> None:
    """Hats, and constant pieces at the ends."""
    path = tilted(LENGTH, angle)
    sample = plate(build, path, spacing=spacing)
    faces = mortar_faces(sample.cover, [0], 1.0)
    assert faces.n == n
    share = np.arange(1, n + 1) / (n + 1)  # evenly spread, none on a tip
    np.testing.assert_allclose(faces.s * spacing, LENGTH * share, atol=ROUND_OFF)
    expected = path[0] + share[:, None] * (path[1] - path[0])
    np.testing.assert_allclose(sample.lattice.to_metres(faces.nodes.points), expected, atol=ROUND_OFF)
    pieces = np.array([1.5, *[1.0] * (n - 2), 1.5]) * LENGTH / (n + 1)
    np.testing.assert_allclose(faces.weights * spacing, pieces, atol=ROUND_OFF)


@pytest.mark.parametrize(
    ("lengths", "numbers", "on_kink"),
    [([6.0, 2.4, 7.0], [5, 4, 5], [0, 1]), *(([6.0, length], [3, 3], [1]) for length in (1.0, 1.4, 1.9))],
)
def test_a_kink_has_a_node_on_each_side_but_for_that_of_a_short_stretch(
    build, lengths: list[float], numbers: list[int], on_kink: list[int]
) -> None:
    """A wing that opens would be held closed by a node on the flaw; one that is closed needs its own."""
    faces = mortar_faces(plate(build, bent(lengths, *[40.0] * (len(lengths) - 1))).cover, [0], 1.25)
    assert faces.stretch[np.isclose(faces.s, 6.0, rtol=0.0, atol=1e-6)].tolist() == on_kink
    assert np.bincount(faces.stretch).tolist() == numbers


def test_nodes_next_to_a_junction_leave_half_a_piece_free(build) -> None:
    """X with arms of 10 spacings: a whole piece free at the tips, half a one at the junction."""
    cross = [(-6.0, -8.0), (6.0, 8.0)], [(-6.0, 8.0), (6.0, -8.0)]
    faces = mortar_faces(plate(build, *cross).cover, [0, 1], 1.25)
    size = 10.0 / 7.5  # seven nodes on every arm: 8 would be closer than 1.25
    arm = size * np.arange(1.0, 8.0)
    np.testing.assert_allclose(faces.s, np.tile(np.concatenate([arm, 20.0 - arm[::-1]]), 2), atol=ROUND_OFF)
    np.testing.assert_array_equal(faces.stretch, np.tile(np.repeat([0, 1], 7), 2))
    ends = size * np.array([1.5, *[1.0] * 12, 1.5])
    np.testing.assert_allclose(faces.weights, np.tile(ends, 2), atol=ROUND_OFF)
    np.testing.assert_allclose(shape_sum(faces), 1.0, rtol=1e-14)


@pytest.mark.parametrize("side", [0.5, 0.25, 1.0 / 64.0])
def test_nodes_are_as_far_apart_as_the_cells_beside_them_are_large(build, side: float) -> None:
    """The same number of cells from node to node: where these are half as large there are twice as many nodes."""
    cover = with_smaller_cells(plate(build, [(-8.0, 0.3), (8.0, 0.3)]).cover, 0.5, side)
    faces = mortar_faces(cover, [0], 1.25)
    steps = np.diff(cover.surfaces[0].in_cells.at(faces.s))
    np.testing.assert_allclose(steps, steps[0], rtol=1e-9)
    assert 1.25 <= steps[0] < 1.4
    apart = np.diff(faces.s)
    coarse, fine = apart[faces.s[1:] < 8.0], apart[faces.s[:-1] > 9.0]
    np.testing.assert_allclose(coarse, coarse[0], rtol=1e-9)
    np.testing.assert_allclose(fine, coarse[0] * side, rtol=1e-9)


@pytest.mark.parametrize("line", [-3.0, 0.2, 4.0, 16.0])
def test_functions_from_rim_to_rim_keep_force_and_moment(build, line: float) -> None:
    """A linear pressure has its force and nodes on rims act there, where a hat would act a third of a piece inside."""
    cover = plate(build, THROUGH, tips=(False, False)).cover
    faces = mortar_faces(with_smaller_cells(cover, line, 0.25), [0], 1.25)
    np.testing.assert_allclose(shape_sum(faces), 1.0, rtol=1e-13)
    centroids = faces.functions @ (faces.lengths * faces.points.s) / faces.weights
    np.testing.assert_allclose(centroids[[0, -1]], [0.0, 31.0], atol=1e-7)
    pressure = 3.0 - 0.2 * faces.s
    assert pressure @ faces.weights == pytest.approx(3.0 * 31.0 - 0.1 * 31.0**2, rel=1e-9)
    inside = (faces.points.s > faces.s[1]) & (faces.points.s < faces.s[-2])
    np.testing.assert_allclose((faces.functions.T @ faces.s)[inside], faces.points.s[inside], atol=ROUND_OFF)


EXACT = 1e-10
"""Moving least squares reproduce linear fields to round-off; coordinates are about 10."""

WIDTH, HEIGHT = 12.0, 10.0
ACROSS = {  # from the left to the right side: everything above is the plus side
    "horizontal": [(0.0, 4.8), (WIDTH, 4.8)],
    "inclined": [(0.0, 2.3), (WIDTH, 7.1)],
    "kinked": [(0.0, 3.1), (4.4, 3.9), (7.3, 6.7), (WIDTH, 6.2)],
}


def cut_block(build, path):
    crack = build.crack(path, tips=(False, False))
    return build.sample((0.0, 0.0), (WIDTH, HEIGHT), [crack], support=2.0)


def above(sample, path) -> np.ndarray:
    """Which physical patches lie above a crack that runs across."""
    of_element = sample.cover.patches.of_element
    x, y = sample.cover.elements.reference.T
    element_above = y > np.interp(x, *sample.lattice.to_lattice(np.array(path)).T)
    side = np.full(len(sample.cover.patches.nodes), -1)
    side[of_element.values] = element_above[of_element.row]
    assert side.min() == 0
    return side == 1


def rigid(points: np.ndarray, shift: tuple[float, float], turn: float) -> np.ndarray:
    """Displacements (n, 2) of points (n, 2): a translation and a small rotation round the origin."""
    return np.array(shift) + turn * np.stack([-points[:, 1], points[:, 0]], axis=1)


def unknowns(sample, displacement: np.ndarray) -> np.ndarray:
    """Unknowns with coefficients (n_patches, 2) of the physical patches, none of tip functions."""
    u = np.zeros((sample.cover.n_functions, 2))
    u[: len(displacement)] = displacement
    return u.ravel()


def nodes(sample) -> np.ndarray:
    return sample.lattice.to_metres(sample.cover.patches.nodes)


@pytest.mark.parametrize("forward", [True, False])
@pytest.mark.parametrize("path", ACROSS.values(), ids=ACROSS.keys())
def test_moving_one_side_gives_its_motion_as_the_jump(build, path, forward: bool) -> None:
    """Opening, and the plus face going forward, are positive, whichever way the crack runs."""
    sample = cut_block(build, path if forward else path[::-1])
    shift, turn = (0.31, 0.22), -0.05
    u = unknowns(sample, above(sample, path)[:, None] * rigid(nodes(sample), shift, turn))
    corners = arc_lengths(np.array(path))
    s = np.sort(np.random.default_rng(5).uniform(0.0, corners[-1], 100))
    points = points_at(sample.cover, 0, s if forward else corners[-1] - s)
    steps = np.diff(np.array(path), axis=0)
    tangent = (steps / np.hypot(*steps.T)[:, None])[np.searchsorted(corners, s) - 1]
    jump = rigid(sample.lattice.to_metres(points.points), shift, turn)
    gap, slip = gap_and_slip(sample.cover, points, u)
    np.testing.assert_allclose(gap, jump[:, 1] * tangent[:, 0] - jump[:, 0] * tangent[:, 1], atol=10 * EXACT)
    np.testing.assert_allclose(slip, np.sum(jump * tangent, axis=1), atol=10 * EXACT)


@pytest.mark.parametrize("discretize", [lambda cover: mortar_faces(cover, [0], 1.0), lambda c: gauss_faces(c, [0])])
def test_contact_points_average_the_jump_with_their_functions(build, discretize) -> None:
    """A jump that is linear in s averages to its value at the centroid of N_k."""
    sample = cut_block(build, ACROSS["inclined"])
    u = unknowns(sample, above(sample, ACROSS["inclined"])[:, None] * rigid(nodes(sample), (0.1, 0.2), 0.04))
    faces = discretize(sample.cover)
    gap_of, slip_of = contact_operators(sample.cover, faces)
    centroid = (faces.functions @ (faces.lengths * faces.points.s)) / faces.weights
    gap, slip = gap_and_slip(sample.cover, points_at(sample.cover, 0, centroid), u)
    np.testing.assert_allclose(gap_of @ u, gap, atol=10 * EXACT)
    np.testing.assert_allclose(slip_of @ u, slip, atol=10 * EXACT)
    assert np.ptp(gap) > 0.3  # the field is not constant
