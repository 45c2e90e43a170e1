"""Where cracks can start: the corners of rock between cracks and rims, and points in the rock."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.fracture.sites import BESIDE, Site, StartRegions, start_sites

APART = 0.5
BENT = [(2.0, 6.1), (6.05, 6.1), (8.05, 6.1 + 2.0 * np.sqrt(3.0))]  # turns by 60 degrees
GENTLE = [(2.0, 6.1), (6.05, 6.1), (10.05, 7.1)]
WALL, GUEST = [(6.05, 2.0), (6.05, 10.0)], [(2.0, 6.1), (6.05, 6.1)]
KINK = (6.05, 6.1)
SLIGHT = np.rad2deg(np.arctan(0.25)) / 2  # half of the turn of GENTLE


def looked(on_cracks: bool = False, on_rims: bool = False, in_rock: bool = False) -> StartRegions:
    return StartRegions(on_cracks, on_rims, in_rock, 2.0, (APART,))


def sites(sample, where: StartRegions, began=()) -> list[Site]:
    """Sites with their places as those of the sample, whose spacing is 1."""
    cover, origin = sample.cover, sample.lattice.to_lattice(np.zeros(2))
    found = start_sites(cover, [0] * len(cover.cracks), [place + origin for place in began], where)
    return [replace(site, point=site.point - origin) for site in found]


def plate(build, *cracks):
    given = [build.crack(np.array(path), (path[0][0] > 0.0, True)) for path in cracks]
    return build.sample((0.0, 0.0), (12.0, 12.0), given, support=2.0, spacing=1.0)


CORNERS = [
    ([BENT], [], [(0, 120.0, 30.0), (0, 300.0, 90.0)]),  # a corner of rock on either side of a kink
    ([GENTLE], [], []),
    ([GENTLE], [KINK], [(0, 90.0 + SLIGHT, 60.0 - SLIGHT), (0, 270.0 + SLIGHT, 60.0 + SLIGHT)]),  # where growth began
    ([GUEST], [KINK], []),  # an end of a crack
    ([WALL, GUEST], [], [(1, 0.0, 60.0), (1, 135.0, 15.0), (1, 225.0, 15.0)]),  # behind WALL the guest may go on
]


@pytest.mark.parametrize(("cracks", "began", "ways"), CORNERS)
def test_starts_on_cracks_are_the_corners_of_rock(build, cracks: list, began: list, ways: list) -> None:
    """Crack, direction and half width in degrees of the corners at the kink or junction."""
    found = sites(plate(build, *cracks), looked(on_cracks=True), [np.array(place) for place in began])
    assert len(found) == len(ways)
    for site in found:
        assert site.kind == "crack"
        np.testing.assert_allclose(site.point, KINK, atol=1e-8)
    degrees = [(site.crack, np.rad2deg(site.direction) % 360.0, np.rad2deg(site.half_width)) for site in found]
    np.testing.assert_allclose(np.reshape(sorted(degrees), (-1, 3)), np.reshape(ways, (-1, 3)), atol=1e-6)


def test_starts_on_rims_look_into_the_rock_and_keep_clear_of_cracks(build) -> None:
    found = sites(plate(build, [(0.0, 6.0), (4.0, 6.0)]), looked(on_rims=True))
    points = np.array([site.point for site in found])
    inward = np.array([[np.cos(site.direction), np.sin(site.direction)] for site in found])
    assert ((points + 0.1 * inward > 0.0) & (points + 0.1 * inward < 12.0)).all()
    np.testing.assert_allclose([site.half_width for site in found], 0.5 * np.pi - BESIDE, rtol=1e-12)
    assert np.hypot(*(points - [0.0, 6.0]).T).min() > APART
    assert {tuple(point) for point in points.tolist()} >= {(2.0, 0.0), (12.0, 4.0), (0.0, 4.0), (0.0, 8.0)}


def test_points_of_the_rock_keep_clear_of_rims_and_cracks(build) -> None:
    """Rock without strength has no starts at all."""
    found = sites(plate(build, [(2.0, 5.0), (10.0, 5.0)]), looked(in_rock=True))
    points = np.array([site.point for site in found])
    assert points.min() >= APART
    assert points.max() <= 12.0 - APART
    across = np.maximum(np.maximum(2.0 - points[:, 0], points[:, 0] - 10.0), 0.0)
    assert np.hypot(across, points[:, 1] - 5.0).min() > APART
    assert sites(plate(build, BENT), StartRegions(True, True, True, 2.0, (None,))) == []
