"""The jump operator on fields whose gap and slip are known: rigid motions of one side, and tip functions."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.faces import gauss_faces, points_at
from crackgrow.contact.jump import contact_operators, gap_and_slip, jump_matrix
from crackgrow.contact.mortar import mortar_faces
from crackgrow.geometry.polyline import arc_lengths

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


@pytest.mark.parametrize("tips", [(False, False), (True, True)])
def test_a_rigid_motion_of_everything_has_no_jump(build, tips: tuple[bool, bool]) -> None:
    path = {False: ACROSS["kinked"], True: [(2.2, 2.4), (5.1, 3.6), (6.0, 6.9)]}[tips[0]]
    sample = build.sample((0.0, 0.0), (WIDTH, HEIGHT), [build.crack(path, tips)], support=2.0)
    u = unknowns(sample, rigid(nodes(sample), (0.7, -0.4), 0.3))
    for faces in (mortar_faces(sample.cover, [0], 1.0), gauss_faces(sample.cover, [0])):
        gap, slip = gap_and_slip(sample.cover, faces.points, u)
        gap_of, slip_of = contact_operators(sample.cover, faces)
        for jump in (gap, slip, gap_of @ u, slip_of @ u):
            assert np.abs(jump).max() < EXACT


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


@pytest.mark.parametrize("at_end", [True, False])
def test_the_odd_tip_function_opens_as_twice_the_square_root(build, at_end: bool) -> None:
    """sqrt(r) sin t/2 is +-sqrt(r) on the faces; in the tip's own cell all patches carry it and sum to one."""
    tip, mouth = (6.05, 5.3), (WIDTH, 3.2)
    path = [mouth, tip] if at_end else [tip, mouth]
    crack = build.crack(path, tips=(not at_end, at_end))
    sample = build.sample((0.0, 0.0), (WIDTH, HEIGHT), [crack], support=2.0)
    cover = sample.cover
    singular = cover.tips[0].functions
    assert len(singular) == 16
    r = np.linspace(0.01, 0.25, 9)  # inside of the tip's cell
    total = arc_lengths(np.array(path))[-1]
    points = points_at(cover, 0, total - r if at_end else r)
    assert np.unique(np.floor(np.vstack([points.points, cover.tips[0].point])), axis=0).shape == (1, 2)
    scalar = np.zeros(cover.n_functions)
    for number, expected in ((0, 0.0), (1, 2.0), (2, 0.0), (3, -2.0)):  # cos t/2, sin t/2, cos 3t/2, sin 3t/2
        scalar[:] = 0.0
        scalar[singular + number] = 1.0
        outward_left = jump_matrix(cover, points) @ scalar
        sense = 1.0 if at_end else -1.0  # left of the tip's direction is the plus side at the end of a crack only
        np.testing.assert_allclose(sense * outward_left, expected * np.sqrt(r), atol=1e-8)  # off the line by the grid
