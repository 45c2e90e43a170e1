"""Distances of solutions in the energy norm."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.errors import GeometryError
from tests.energy_distance import energy_distance
from tests.unit.run.test_run_error import COARSE, solve


def test_a_solution_is_at_no_distance_from_itself_and_at_a_tenth_of_one_with_nine_tenths_of_its_load() -> None:
    solution = solve("compression30", COARSE)
    assert energy_distance(solution, solution).relative < 1e-9
    np.testing.assert_allclose(energy_distance(solve("compression30", COARSE, factor=0.9), solution).relative, 10.0)


def test_the_distance_of_uniform_stresses_is_exact() -> None:
    """-100 MPa and -60 MPa on 31 x 55 mm without a jump: (40 MPa)^2 (1 - nu^2) / E times the area."""
    stuck = (COARSE, "cracks.flaw.contact.friction=0.7")
    coarse, fine = solve("compression30", *stuck, factor=0.6), solve("compression30", "numerics.spacing=2", *stuck[1:])
    distance = energy_distance(coarse, fine)
    np.testing.assert_allclose(distance.absolute**2, 40e6**2 * (1.0 - 0.25**2) / 1e10 * 31e-3 * 55e-3, rtol=1e-4)
    np.testing.assert_allclose(distance.relative, 40.0, rtol=1e-4)


def test_distances_obey_the_triangle_inequality() -> None:
    a, b, c = (solve("compression30", f"numerics.spacing={spacing}") for spacing in (3, 2, 1.5))
    ab, bc, ac = (energy_distance(*pair).absolute for pair in ((a, b), (b, c), (a, c)))
    assert ac < 1.01 * (ab + bc)
    assert ab < 1.01 * (ac + bc)


def test_other_bodies_are_an_error() -> None:
    wide = solve("compression30", COARSE, "bodies.rock.shape.rectangle.width=32")
    with pytest.raises(GeometryError, match="different bodies"):
        energy_distance(solve("compression30", COARSE), wide)
